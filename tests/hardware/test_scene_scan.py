"""Scans without wires: the same counts as over them, and ranges where the target is."""

from dataclasses import replace

import numpy as np
import pytest

import cmtof
from cmtof.correlation import centred, phase_from_depth
from cmtof.hardware.scan import planned, scan
from cmtof.hardware.scene_scan import scan_scene
from cmtof.hardware.twin.run import Twin
from cmtof.instrument.settings import TwinSettings
from cmtof.instrument.targets import Hits

WALL = {"kind": "plane", "distance": 1.0, "tilt_x": 0.1, "reflectance": 0.8}
VIEW = np.deg2rad(20.0)  # of the default rig


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """One small scan over the wires, and the same without."""
    with Twin.default(seed=2, scene=WALL) as twin:
        plan = planned(twin.rig.settings, size=4)
        wired = scan(twin.rig, plan, tmp_path_factory.mktemp("scan") / "m.nc", seed=2)
    return wired.dataset, scan_scene(TwinSettings(), WALL, size=4, field_of_view=VIEW, seed=2)


def test_every_count_is_that_of_the_wires(both):
    wired, direct = both
    assert np.array_equal(direct.dataset["raw_counts"], wired["raw_counts"])
    assert np.array_equal(direct.dataset["dark"], wired["dark"])
    assert np.array_equal(direct.dataset["camera"], wired["camera"])


def test_it_decodes_like_a_scan(both):
    wired, direct = both
    # the power meter answers with an offset and seven digits, the stage stops at a whole count
    assert np.allclose(direct.dataset["laser_power"], wired["laser_power"], rtol=1e-6)
    assert np.allclose(direct.dataset["psi"], wired["psi"], atol=2e-5)
    assert np.allclose(direct.dataset["correlation"], wired["correlation"], rtol=1e-6, atol=1e-6)
    assert direct.dataset.attrs.keys() == wired.attrs.keys()
    assert np.allclose(direct.dataset["time"], wired["time"])


def test_ideal_phases_are_those_of_the_range():
    measurement = scan_scene(TwinSettings.ideal(), WALL, size=(3, 5), field_of_view=0.2, seed=0)
    assert measurement.shape == (3, 5)
    assert measurement.dataset.attrs["group_index"] == 1
    depth = measurement.depth
    assert depth is not None
    for phase, frequency in zip(measurement.phase, measurement.frequencies, strict=True):
        # what is left: steps of the mirrors, 43 urad at most, on a slope of 0.15 m a radian
        assert np.abs(centred(phase - phase_from_depth(depth, frequency))).max() < 5e-3


def test_depth_is_optical_as_what_is_unwrapped():
    settings = replace(TwinSettings(), noise=False)
    settings = replace(settings, optics=replace(settings.optics, speckle=False, divergence=0.0))
    measurement = scan_scene(
        settings, WALL, size=4, field_of_view=0.05, seed=0, range_min=0.995, range_max=1.01
    )
    assert measurement.range == (0.995, 1.01)
    index = measurement.dataset.attrs["group_index"]
    assert index == pytest.approx(1.000285, abs=2e-6)
    depth = measurement.depth
    assert depth is not None and depth.mean() == pytest.approx(index * 1.0, abs=2e-3)
    error = cmtof.unwrap(measurement, method="crt")["depth"].to_numpy() - depth
    assert np.abs(error).max() < 5e-5 < (index - 1) * 1.0


class Half:
    """A wall on the right side alone."""

    material = "diffuse"

    def look(self, directions):
        seen = directions[..., 0] > 0
        reach = np.where(seen, 1 / directions[..., 2], np.nan)
        return Hits(reach, directions[..., 2], np.full(reach.shape, 0.5))


def test_pixels_without_a_surface_are_masked():
    measurement = scan_scene(TwinSettings(), Half(), size=4, field_of_view=0.3, seed=0)
    assert measurement.mask.tolist() == [[False, False, True, True]] * 4
    depth = measurement.depth
    assert depth is not None and np.array_equal(np.isfinite(depth), measurement.mask)


def test_number_of_phases():
    measurement = scan_scene(TwinSettings(), WALL, size=2, field_of_view=0.1, seed=0, phases=8)
    assert measurement.dataset.sizes["step"] == 8


def test_beyond_the_mirrors():
    with pytest.raises(ValueError, match=r"Expected directions within 10 V of the mirrors"):
        scan_scene(TwinSettings(), WALL, size=2, field_of_view=2.5, seed=0)
