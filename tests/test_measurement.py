"""Measurement: what goes in comes out; whatever is wrong is said in one line."""

from datetime import date
from pathlib import Path

import h5netcdf
import h5py
import numpy as np
import xarray as xr
from contents import external_link, netcdf, netcdf_3, plain_hdf5, virtual_dataset
from numpy.testing import assert_allclose, assert_array_equal
from pytest import approx, mark, raises
from refusals import WRONG, refused

import cmtof
from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU, correlation_from_phase
from cmtof.measurement import Measurement, unambiguous_range
from cmtof.simulation import QUADRATURES
from cmtof.storage import save_dataset

pytestmark = mark.usefixtures("own_folder")
PSI = np.array(QUADRATURES)
ONES = np.ones((5, 6))


def stack():
    one = correlation_from_phase(ONES, PSI, amplitude=600.0, offset=1000.0)
    return np.array([one, one], np.float32)


def changed(**changes):
    """A valid dataset with some things replaced."""
    return made().dataset.assign(changes)


def made(**more):
    """A measurement of which some things may be replaced."""
    return Measurement.from_arrays(
        **{"correlation": stack(), "psi": PSI, "frequencies": FREQUENCIES} | more
    )


def with_sample(value):
    """Correlation images with another value at one sample."""
    values = stack()
    values[1, 2, 1, 1] = value
    return values


def test_arrays_come_back_from_the_file(rng):
    depth = rng.uniform(1, 2, (5, 6))
    mask = depth > 1.2
    written = made(
        depth=depth, mask=mask, camera=[10.0, 11.0, 3.0, 2.5], range_max=3.0, note="hi"
    )
    written.save("m.nc")
    read = cmtof.open("m.nc")
    xr.testing.assert_equal(read.dataset, written.dataset)
    assert read.dataset.attrs["note"] == "hi"
    assert read.range == (0.0, 3.0)
    assert_allclose(read.phase[:, mask], 1.0, atol=1e-5)
    assert_allclose(read.amplitude[:, mask], 600.0, rtol=1e-5)
    assert "7.15, 14.32 GHz" in repr(read)


def test_npz_of_the_same_names_opens():
    np.savez(
        "m.npz", correlation=stack(), psi=PSI, frequency=FREQUENCIES, range_max=2.0
    )
    assert cmtof.open("m.npz").range == (0.0, 2.0)


def test_default_range_ends_where_the_phases_repeat():
    assert unambiguous_range(FREQUENCIES) == approx(7.4948, abs=1e-4)
    assert unambiguous_range([7.15e9]) == approx(0.0209645, abs=1e-7)


@mark.parametrize("name", ["correlation", "psi", "frequency", "depth", "camera"])
def test_units_stand_in_every_stored_array(measurement_file, name):
    with xr.open_dataset(measurement_file, engine="h5netcdf") as stored:
        assert stored[name].attrs["units"]


# --- what others write ---------------------------------------------------------------------------


LEFT_OUT = np.arange(30).reshape(5, 6) % 4 == 0


@mark.parametrize(
    "arrays",
    [
        {"mask": ~LEFT_OUT},
        {"mask": np.where(LEFT_OUT, np.nan, 1.0)},  # a fill value, as it is read
        {"mask": np.where(LEFT_OUT, 0, 7)},
        {"mask": np.ma.masked_array(ONES, LEFT_OUT)},
        {"correlation": np.ma.masked_where(0 * stack() + LEFT_OUT, stack())},
    ],
)
def test_every_mark_of_an_invalid_pixel_is_understood(arrays):
    found = made(**arrays)
    assert_array_equal(found.mask, ~LEFT_OUT)
    assert np.isnan(found.dataset["correlation"].to_numpy()[..., LEFT_OUT]).all()


@mark.parametrize("fill", [0, 1])
def test_a_mask_with_a_fill_value_survives_its_file(fill):
    marks = np.where(LEFT_OUT, fill, 1 - fill).astype(np.int8)
    dataset = changed(mask=(("y", "x"), marks, {}, {"_FillValue": np.int8(fill)}))
    dataset.to_netcdf("m.nc", engine="h5netcdf")
    assert_array_equal(cmtof.open("m.nc").mask, ~LEFT_OUT & (fill == 0))


@mark.parametrize(
    "name, unit, size",
    [
        ("frequency", "GHz", 1e9),
        ("psi", "degree", np.pi / 180),
        ("psi", "degrees", np.pi / 180),
        ("depth", "mm", 1e-3),
    ],
)
def test_units_that_a_file_or_its_arrays_state_are_used(name, unit, size):
    right = changed(depth=(("y", "x"), ONES))
    stated = right.assign({name: right[name] / size})
    stated[name].attrs["units"] = unit
    arrays = made(frequencies=stated.frequency, psi=stated.psi, depth=stated.depth)
    for measurement in (Measurement(stated), arrays):
        found = measurement.dataset[name]
        assert_allclose(found, right[name], rtol=1e-12)
        assert found.attrs["units"] == right[name].attrs.get("units", "m")


def test_phases_of_any_turn_are_wrapped():
    phase = np.linspace(-np.pi, np.pi, 12).reshape(1, 3, 4)
    dataset = Measurement.from_phase(np.mod(phase, TAU), [7.15e9]).dataset
    found = Measurement(dataset.assign(phase=dataset["phase"].copy(data=phase)))
    assert_allclose(found.phase, np.mod(phase, TAU), atol=1e-12)


def psi_undeclared(dataset):
    return netcdf(dataset.reset_coords("psi"))


@mark.parametrize("write", [netcdf_3, psi_undeclared, plain_hdf5])
def test_files_of_other_writers_open(write):
    whole = made(mask=~LEFT_OUT)
    Path("m.nc").write_bytes(write(whole.dataset))
    found = cmtof.open("m.nc")
    assert_array_equal(found.phase, whole.phase)
    assert_array_equal(found.mask, whole.mask)
    assert found.range == whole.range


@mark.parametrize(
    "value, kept",
    [
        (True, 1),
        ({"a": 1}, '{"a": 1}'),
        (date(2026, 5, 3), "2026-05-03"),
        (Path("a.yml"), "a.yml"),
        ([1, "x"], '[1, "x"]'),
        (np.array([True]), "[true]"),
        (np.array(["2026-05-03"], "M8[D]"), '["2026-05-03"]'),
    ],
)
def test_anything_else_is_kept_as_an_attribute(value, kept):
    written = made(note=value)
    written.dataset["psi"].attrs["note"] = value
    written.save("m.nc")
    read = cmtof.open("m.nc").dataset
    assert read.attrs["note"] == read["psi"].attrs["note"] == kept


def external_storage(file, other):
    file.create_dataset("dark", (8,), "u1", external=[(other, 0, 8)])


@mark.parametrize("reach", [external_link, external_storage, virtual_dataset])
def test_a_file_cannot_reach_into_another(reach):
    made().save("m.nc")
    with h5py.File("m.nc", "r+") as file:
        reach(file, "other.nc")
    with refused("another file"):
        cmtof.open("m.nc")


def test_a_range_may_be_an_array_of_one_number():
    assert made(range_min=np.array([0.5]), range_max=[1.2]).range == (0.5, 1.2)


# --- what is wrong is said -----------------------------------------------------------------------


@mark.parametrize(
    "arrays, message",
    [
        ({"correlation": stack().T}, "Put frequency and step first"),
        ({"correlation": with_sample(np.inf)}, "finite correlation"),
        (
            {
                "correlation": with_sample(9.97e36),
                "mask": ~LEFT_OUT,
                "source": "simulation",
            },
            "correlation, got 1 others",
        ),
        ({"correlation": stack().astype("datetime64[s]")}, "numbers as correlation"),
        ({"frequencies": (7.15e9, 10**400)}, "numbers as frequency"),
        *WRONG["measurements"],
    ],
)
def test_impossible_arrays_are_refused(arrays, message):
    with refused(message):
        made(**arrays)


def test_counts_below_the_saturation_are_valid():
    assert made(saturation=16383.0).mask.all()


@mark.parametrize(
    "variables, message",
    [
        ({"depth": (("x", "y"), ONES.T)}, "depth with dimensions"),
        ({"depth": (("y", "x"), ONES, {"units": "K"})}, "depth in m"),
        ({"camera": (("parameter",), [1.0, 2.0])}, "camera"),
        ({"mask": (("y", "x"), ONES + 0j)}, "numbers as mask"),
        (
            {"raw_counts": (("frequency", "step", "y", "x"), -stack())},
            "raw_counts >= 0, got 240 others",
        ),
    ],
)
def test_impossible_variables_are_refused(variables, message):
    with refused(message):
        Measurement(changed(**variables))


@mark.parametrize("change, what, message", WRONG["datasets"])
def test_misshapen_datasets_are_refused(change, what, message):
    with refused(message):
        Measurement(getattr(changed(), change)(*what))


def test_a_header_that_claims_too_much_is_refused_before_it_is_read():
    huge = h5netcdf.File("huge.nc", "w")
    huge.dimensions = {"y": 10**6, "x": 10**6}
    huge.create_variable("depth", ("y", "x"), "f8", chunks=(1000, 1000))
    huge.close()
    with refused("its header claims 8e[+]12 bytes"):
        cmtof.open("huge.nc")


def test_files_that_are_no_measurement_are_refused(tilted_wall):
    with refused("got no file at", FileNotFoundError):
        cmtof.open("none.nc")
    Path("a.txt").touch()
    with refused(r"named \*.nc"):
        cmtof.open("a.txt")
    tilted_wall.save("frame.npz")
    with refused("cmtof simulate"):
        cmtof.open("frame.npz")


def test_nothing_half_written_is_left():
    broken = changed(bad=("x", np.array([object()] * 6)))
    with refused(r"named \*.nc"):
        save_dataset(broken, "m.h5")
    with raises(Exception):  # noqa: B017 - whatever the writer raises
        save_dataset(broken, "m.nc")
    assert not [*Path().iterdir()]


def with_stray_light(scene, psi):
    """Correlations of a scene, of a share of its light, and of light that comes straight back."""
    known = correlation_from_phase(ONES, psi, amplitude=600, offset=1000)
    stray = correlation_from_phase(2.5 * ONES, psi, amplitude=30, offset=400)
    return made(correlation=[scene * known + stray] * 2, psi=psi)


def test_stray_light_is_taken_away_at_any_psi():
    """Phase, amplitude and offset are those of the scene alone."""
    covered = with_stray_light(0, PSI + 0.3)
    found = with_stray_light(1, PSI).without_stray_light(covered).decoded
    for image, value in zip(found, (1, 600, 1000), strict=True):
        assert_allclose(image, value, rtol=1e-6)


@mark.parametrize(
    "covered",
    [
        Measurement.from_phase([ONES, ONES], FREQUENCIES),
        made(frequencies=(7e9, 14e9 + 1e7)),
        made(mask=0 * ONES),
    ],
    ids=["phases", "other frequencies", "no valid pixel"],
)
def test_stray_light_is_measured_as_the_scene_is(covered):
    with refused("Expected valid correlations at the same frequencies"):
        made().without_stray_light(covered)
