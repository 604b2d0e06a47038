"""Measurement: what goes in comes out; whatever is wrong is said in one line."""

import h5netcdf
import numpy as np
import pytest
import xarray as xr

import cmtof
from cmtof.correlation import correlation_from_phase
from cmtof.measurement import Measurement, save_dataset, unambiguous_range

PSI = np.arange(4) * np.pi / 2
FREQUENCIES = (7.15e9, 14.32e9)


def stack(height=5, width=6, phase=1.0):
    image = np.full((height, width), phase)
    one = correlation_from_phase(image, PSI, amplitude=600.0, offset=1000.0)
    return np.stack([one, one]).astype(np.float32)


def test_arrays_come_back_from_the_file(tmp_path, rng):
    depth = rng.uniform(1, 2, (5, 6))
    mask = depth > 1.2
    camera = [10.0, 11.0, 3.0, 2.5]
    made = Measurement.from_arrays(
        stack(), PSI, FREQUENCIES, depth=depth, mask=mask, camera=camera, range_max=3.0, note="hi"
    )
    made.save(tmp_path / "m.nc")
    read = cmtof.open(tmp_path / "m.nc")
    xr.testing.assert_equal(read.dataset, made.dataset)
    np.testing.assert_array_equal(read.mask, mask)
    assert read.dataset.attrs["note"] == "hi"
    assert read.dataset["depth"].attrs["units"] == "m"
    assert read.range == (0.0, 3.0)
    assert read.shape == (5, 6)
    np.testing.assert_allclose(read.phase, 1.0, atol=1e-5)
    np.testing.assert_allclose(read.amplitude, 600.0, rtol=1e-5)
    assert "7.15, 14.32 GHz" in repr(read)


def test_npz_of_the_same_names_opens(tmp_path):
    np.savez(tmp_path / "m.npz", correlation=stack(), psi=PSI, frequency=FREQUENCIES, range_max=2.0)
    assert cmtof.open(tmp_path / "m.npz").range == (0.0, 2.0)


def test_default_range_ends_where_the_phases_repeat():
    assert unambiguous_range(FREQUENCIES) == pytest.approx(7.4948, abs=1e-4)
    assert unambiguous_range([7.15e9]) == pytest.approx(0.0209645, abs=1e-7)


def test_units_stand_in_every_stored_array(measurement_file):
    with xr.open_dataset(measurement_file, engine="h5netcdf") as stored:
        for name in ("correlation", "psi", "frequency", "depth", "camera"):
            assert stored[name].attrs["units"], name


# --- what is wrong is said -----------------------------------------------------------------------


def changed(**changes):
    """A valid dataset with some things replaced."""
    dataset = Measurement.from_arrays(stack(), PSI, FREQUENCIES).dataset.copy(deep=True)
    return dataset.assign(changes)


def with_values(change):
    values = stack()
    change(values)
    return values


def test_bad_samples_are_refused():
    for values, message in (
        (with_values(lambda v: v.__setitem__((1, 2, 0, 0), np.inf)), "finite correlation"),
        (with_values(lambda v: v.__isub__(5000)), "counts >= 0 up to noise"),
        (with_values(lambda v: v.__setitem__((0, slice(None), 2, 2), -900)), "1 pixels whose mean"),
        (stack().astype(str), "numbers as correlation"),
        (stack().astype("datetime64[s]"), "numbers as correlation"),
        (np.zeros((2, 4, 5, 6), [("a", "f4")]), "numbers as correlation"),
    ):
        with pytest.raises(ValueError, match=message):
            Measurement.from_arrays(values, PSI, FREQUENCIES)


def test_bad_samples_under_the_mask_are_let_be():
    values = with_values(lambda v: v.__setitem__((0, 0, 1, 1), np.nan))
    mask = np.ones((5, 6), bool)
    mask[1, 1] = False
    assert Measurement.from_arrays(values, PSI, FREQUENCIES, mask=mask).mask.sum() == 29


def test_noise_may_push_dark_samples_below_zero(rng):
    dark = rng.normal(0, 1200, (2, 4, 50, 60)).astype(np.float32)
    Measurement.from_arrays(dark, PSI, FREQUENCIES)


def test_negative_raw_counts_are_refused():
    counts = stack().astype(np.int32)
    counts[0, 1, 2, 3] = -3
    with pytest.raises(ValueError, match="counts >= 0, got 1 negative"):
        Measurement.from_arrays(counts, PSI, FREQUENCIES)
    raw = (("frequency", "step", "y", "x"), counts)
    with pytest.raises(ValueError, match="counts >= 0, got 1 negative"):
        Measurement(changed(raw_counts=raw))


def test_saturated_counts_are_refused():
    with pytest.raises(ValueError, match="below the saturation 1300"):
        Measurement.from_arrays(stack(), PSI, FREQUENCIES, saturation=1300.0)
    Measurement.from_arrays(stack(), PSI, FREQUENCIES, saturation=16383.0)


def test_bad_frequencies_and_psi_are_refused():
    for frequencies, message in (
        ((-7.15e9, 14.32e9), "frequencies"),
        ((np.nan, 14.32e9), "frequencies"),
        ((14.32e9, 7.15e9), "rising order"),
        ((7.15e9, 1e15), "up to 1e[+]12 Hz"),
        ((7.15e9, 10**400), "numbers as frequencies"),
        ((7.15e9, 7.15e9 + 1), "at most 10000 wraps"),
    ):
        with pytest.raises(ValueError, match=message):
            Measurement.from_arrays(stack(), PSI, frequencies)
    for psi, message in (
        ([0.0, 1.0, 2.0], "correlation"),
        ([0.0, 1.0, 2.0, 2.0], "duplicates"),
        ([0.0, 1.0, 2.0, np.nan], "finite reference phases"),
    ):
        with pytest.raises(ValueError, match=message):
            Measurement.from_arrays(stack(), psi, FREQUENCIES)


def test_misshapen_datasets_are_refused():
    for change, message in (
        (lambda d: d.drop_vars("correlation"), "a variable 'correlation'"),
        (lambda d: d.drop_vars("psi"), "a coordinate 'psi'"),
        (lambda d: d.transpose("y", "x", "frequency", "step"), "with dimensions"),
        (lambda d: d.isel(y=slice(0, 0)), "none of them empty"),
        (lambda d: d.assign(depth=(("x", "y"), np.ones((6, 5)))), "depth with dimensions"),
        (lambda d: d.assign(camera=(("parameter",), [1.0, 2.0])), "camera"),
        (lambda d: d.assign_attrs(range_min=2.0, range_max=1.0), "range_min < range_max"),
        (lambda d: d.assign_attrs(range_max="far"), "range_min < range_max"),
        (lambda d: d.assign_attrs(range_max=1e6), "at most 10000 wraps"),
        (lambda d: d.assign(mask=(("y", "x"), np.ones((5, 6), complex))), "numbers as mask"),
    ):
        with pytest.raises(ValueError, match=message):
            Measurement(change(changed()))


def test_images_of_two_sizes_are_refused():
    with pytest.raises(ValueError, match="one image size"):
        Measurement.from_arrays(stack(), PSI, FREQUENCIES, depth=np.ones((2, 2)))


def test_a_header_that_claims_too_much_is_refused_before_it_is_read(tmp_path):
    huge = h5netcdf.File(tmp_path / "huge.nc", "w")
    huge.dimensions = {"y": 10**6, "x": 10**6}
    huge.create_variable("depth", ("y", "x"), "f8", chunks=(1000, 1000))
    huge.close()
    with pytest.raises(ValueError, match="its header claims 8e[+]12 bytes"):
        cmtof.open(tmp_path / "huge.nc")


def test_missing_and_misnamed_files(tmp_path):
    with pytest.raises(FileNotFoundError, match="got no file at"):
        cmtof.open(tmp_path / "none.nc")
    (tmp_path / "a.txt").write_text("x")
    with pytest.raises(ValueError, match=r"named \*.nc"):
        cmtof.open(tmp_path / "a.txt")


def test_a_frame_is_told_from_a_measurement(tmp_path, tilted_wall):
    tilted_wall.save(tmp_path / "frame.npz")
    with pytest.raises(ValueError, match="cmtof simulate"):
        cmtof.open(tmp_path / "frame.npz")


def test_nothing_half_written_is_left(tmp_path):
    dataset = Measurement.from_arrays(stack(), PSI, FREQUENCIES).dataset
    with pytest.raises(ValueError, match=r"named \*.nc"):
        save_dataset(dataset, tmp_path / "m.h5")
    broken = dataset.assign(bad=("x", np.array([object()] * 6)))
    with pytest.raises(Exception):  # noqa: B017 - whatever the writer raises
        save_dataset(broken, tmp_path / "m.nc")
    assert not list(tmp_path.iterdir())
