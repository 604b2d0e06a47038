"""Sweeps of the target before three instruments, and what a bench measures of itself."""

from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose
from pytest import approx, fixture, mark
from refusals import refused

from cmtof.hardware.calibration import cyclic_error, drive_amplitudes, plate, resonance
from cmtof.hardware.ranging import sweep, sweep_errors
from cmtof.hardware.rig import Rig
from cmtof_lab.instrument import RfKnobs, amplitude
from cmtof_lab.rehearsal import simulated_bench
from cmtof_lab.settings import TwinSettings
from cmtof_lab.sweep import POSITIONS, zero_positions
from cmtof_lab.targets import MIRROR

RIG = replace(Rig.default(), flip_mirror="photodiode")
GREY = replace(MIRROR, reflectance=6e-6)
KNOWN = TwinSettings(reference=GREY)
IDEAL = TwinSettings.ideal(reference=GREY)


@fixture
def bench_of():
    """Makers of a bench that is set up."""

    def made(settings, rig=RIG):
        bench = simulated_bench(rig, None, settings, seed=1)
        bench.set_up()
        return bench

    return made


@mark.parametrize(
    "way, worst", [("reference", 2e-5), ("rf", 2e-5), ("interferometer", 6.6e-8)]
)
def test_each_instrument_follows_the_stage(bench_of, way, worst):
    """Within a thousandth of a wrap, and a quarter of a fringe; RF needs more light."""
    target = replace(MIRROR, reflectance=1e-2 if way == "rf" else 6e-6)
    bench = bench_of(replace(KNOWN, reference=target))
    seen = sweep(bench, way, np.append(zero_positions(8), POSITIONS))
    assert 0 < abs(sweep_errors(seen, target.distance, visits=8)[8:]).max() < worst
    assert (seen["laser_power"] > 0).all()
    panel = bench.daq.panel
    assert not (panel.beam_block_out or panel.shutter_open)


def test_what_a_bench_lacks_or_cannot_measure_is_said(bench_of):
    with refused("Expected flip_mirror: photodiode, got reference"):
        sweep(bench_of(KNOWN, Rig.default()), "rf", [0.0])
    with refused("Expected RF in the single mode"):
        sweep(bench_of(KNOWN), "rf", [0.0], mode="doubled")
    with refused(r"got 4\.10 V: it saturates\. Put a grey filter"):
        sweep(bench_of(TwinSettings(reference=MIRROR)), "reference", [0.0])
    with refused("Expected RF up to power_dbm_limit, 30 dBm, got 31"):
        drive_amplitudes(bench_of(KNOWN), "emission", [(7.15e9, 31.0)])


# --- calibration ---------------------------------------------------------------------------------

MODULES = ("emission", "detection")


@mark.parametrize("module", MODULES)
def test_amplitude_and_resonance_are_those_of_the_drive(bench_of, module):
    """A splitter that leaks in the dark, and a laser that drifts."""
    drives = [(7.15e9, 20.0), (7.15e9, 30.0), (7.155e9, 27.0)]
    wanted = [abs(amplitude(KNOWN, RfKnobs(True, *drive))) for drive in drives]
    bench = bench_of(KNOWN)
    assert_allclose(drive_amplitudes(bench, module, drives), wanted, rtol=5e-3)
    assert not (bench.daq.panel.emission.on or bench.daq.panel.detection.on)
    assert resonance(bench, module, np.linspace(7.145e9, 7.165e9, 5)) == (
        approx(KNOWN.resonance, abs=1e5),
        approx(KNOWN.resonance_width, rel=0.01),
    )


@mark.parametrize("module", MODULES)
def test_a_plate_that_is_turned_tells_its_zero_and_the_splitters_extinction(
    bench_of, module
):
    rig = replace(RIG, plate_zero_emission_deg=1.5, plate_zero_detection_deg=1.5)
    assert plate(bench_of(KNOWN, rig), module, np.arange(0.0, 45.0, 5.0)) == (
        approx(-1.5, abs=0.02),
        approx(KNOWN.reflected_extinction, rel=0.05),
    )


def test_stray_light_of_constant_phase_errs_once_a_wrap(bench_of):
    clean = cyclic_error(bench_of(IDEAL), zero_positions(16))
    assert clean.max() < 2e-7
    found = cyclic_error(
        bench_of(replace(IDEAL, back_fraction=1e-9)), zero_positions(16)
    )
    assert found.argmax() == 0
    assert found[0] > 10 * clean.max()
