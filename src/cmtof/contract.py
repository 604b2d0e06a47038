"""Format of a measurement (names, units, dimensions, values), checked once, where data enter."""

import tomllib
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from xarray import Dataset

from cmtof.correlation import check_psi, wrap_length, wrapped
from cmtof.types import Array, Flags
from cmtof.validation import checked_camera, checked_frequencies, numbers


class Kind(NamedTuple):
    """Unit and dimensions of a variable; None allows any dimensions."""

    unit: str
    dims: tuple[str, ...] | None


_TABLES = tomllib.loads(Path(__file__).with_name("contract.toml").read_text("utf-8"))
VARIABLES = {
    name: Kind(unit, tuple(dims) or None)
    for name, (unit, *dims) in _TABLES["variables"].items()
}

# Units that a file may state, and their size in SI units.
UNITS = _TABLES["units"]

# Greatest number of wraps of the lowest frequency to choose from; the prototype's beat has 358.
MOST_WRAPS = 10_000

# Samples from here on are netCDF's mark of what was never written.
_NOT_WRITTEN = 9.9e36


def unambiguous_range(frequencies: ArrayLike) -> float:
    """Range, m, over which the beat of the first two frequencies does not repeat.

    The beat's ``c / 2 |f2 - k f1|`` with ``k = round(f2 / f1)``, 7.495 m for the prototype; a
    single wrap of one frequency, or of two of which one is a multiple of the other.
    """
    low, high = np.resize(frequencies, 2)
    beat = abs(high - np.round(high / low) * low)
    return float(wrap_length(beat if beat > 0 else low))


def checked_dataset(dataset: Dataset) -> Dataset:
    """Checked dataset: SI units, floats, NaN where masked unless simulated; else a ValueError."""
    data = in_si_units(with_coordinates(dataset))
    frequencies = checked_frequencies(data["frequency"].to_numpy())
    data = data.assign_coords(frequency=data["frequency"].copy(data=frequencies))
    if "camera" in data:
        checked_camera(data["camera"].to_numpy(), "the measurement")
    if "correlation" in data:
        for steps in data["psi"].to_numpy():
            check_psi(steps)
    data.attrs = {
        "range_min": 0.0,
        "range_max": unambiguous_range(frequencies),
        **data.attrs,
    }
    _check_range(data)
    return _with_valid_values(data)


def with_coordinates(dataset: Dataset) -> Dataset:
    """The dataset with frequency and psi as coordinates.

    A ValueError if a variable is missing, or holds no numbers on the dimensions of `VARIABLES`.
    """
    main = "correlation" if "correlation" in dataset else "phase"
    if main not in dataset:
        raise ValueError(
            "Expected a variable 'correlation' (frequency, step, y, x), "
            f"got {list(dataset.variables)}. See the page «Bring your own data»."
        )
    needed = ("frequency", "psi") if main == "correlation" else ("frequency",)
    for name in needed:
        if name not in dataset.variables:
            raise ValueError(
                f"Expected a variable '{name}', got {list(dataset.variables)}. "
                "State it for every image."
            )
    for name in filter(dataset.variables.__contains__, VARIABLES):
        variable = dataset[name]
        if variable.dtype.kind not in "biuf":
            raise ValueError(
                f"Expected numbers as {name}, got type {variable.dtype}. Store floats."
            )
        dims = VARIABLES[name].dims or variable.dims
        if not variable.size or variable.dims != dims:
            raise ValueError(
                f"Expected {name} with dimensions {dims}, none of them empty, "
                f"got {dict(variable.sizes)}. Transpose, rename or repeat them."
            )
    # outside xarray a variable of two dimensions is no coordinate
    return dataset.set_coords(needed)


def in_si_units(dataset: Dataset) -> Dataset:
    """The dataset in the units of `VARIABLES`, converted from the ``units`` attributes."""
    data = dataset.copy()
    for name in filter(dataset.variables.__contains__, VARIABLES):
        unit = VARIABLES[name].unit
        variable = data[name]
        stated = str(variable.attrs.get("units", unit)).strip()
        if unit in UNITS:
            factor = UNITS[unit].get(stated)
            if factor is None:
                known = ", ".join(filter(str.isalpha, UNITS[unit]))
                raise ValueError(
                    f"Expected {name} in {known}, got units '{stated}'. Convert the values."
                )
            if factor != 1:
                data[name] = (
                    variable.dims,
                    variable.to_numpy() * factor,
                    variable.attrs,
                )
            stated = unit
        data[name].attrs["units"] = stated
    return data


def _check_range(dataset: Dataset) -> None:
    """Make the range's ends floats; a ValueError unless they rise within `MOST_WRAPS` wraps."""
    ends = [dataset.attrs[key] for key in ("range_min", "range_max")]
    plain = all(
        np.size(end) == 1 and np.asarray(end).dtype.kind in "iuf" for end in ends
    )
    low, high = (float(np.squeeze(end)) if plain else np.nan for end in ends)
    if not 0 <= low < high < np.inf:
        raise ValueError(
            f"Expected attributes 0 <= range_min < range_max in m, got {ends}. "
            "Set the depths to choose from."
        )
    dataset.attrs |= {"range_min": low, "range_max": high}
    wraps = high / wrap_length(dataset["frequency"].to_numpy()[0])
    if wraps > MOST_WRAPS:
        raise ValueError(
            f"Expected at most {MOST_WRAPS} wraps of the lowest frequency within range_max, "
            f"got {wraps:.3g}. Lower range_max or the frequency."
        )


def _with_valid_values(data: Dataset) -> Dataset:
    """Dataset of float samples, NaN if masked and not simulated; a ValueError for invalid ones."""
    valid = np.True_
    if "mask" in data:
        # a fill value arrives as NaN, and means that nobody called the pixel valid
        valid = np.nan_to_num(data["mask"].to_numpy()) != 0
        data["mask"] = (("y", "x"), valid.astype(np.int8), data["mask"].attrs)
    simulated = data.attrs.get("source") == "simulation"
    for name in ("correlation", "phase", "amplitude"):
        if name in data:
            variable = data[name]
            # the smallest floats, of 32 bits at least, that hold them exactly
            floats = variable.to_numpy() + np.float32(0)
            samples = _mask_samples(floats, valid, simulated)  # pyright: ignore[reportArgumentType]
            if name != "amplitude":
                _raise_if_any(
                    ~np.isfinite(samples) & valid,
                    f"finite {name}",
                    "Mask those pixels.",
                )
            if name == "phase":
                samples = wrapped(samples)
            data[name] = (variable.dims, samples, variable.attrs)
    if "raw_counts" in data:
        _raise_if_any(
            (data["raw_counts"].to_numpy() < 0) & valid,
            "raw_counts >= 0",
            "Check the sign of the read-out.",
        )
    if (limit := data.attrs.get("saturation")) is not None and "correlation" in data:
        saturation = np.min(numbers(limit, "the attribute saturation"), initial=np.inf)
        counts = data.get("raw_counts", data["correlation"]).to_numpy()
        _raise_if_any(
            (counts >= saturation) & valid,
            f"counts below the saturation {saturation:g}",
            "Lower gain or exposure, or mask.",
        )
    return data


def _mask_samples(samples: Array, valid: Flags, simulated: bool) -> Array:
    """Samples (..., H, W), NaN where a file was never written and, unless simulated, where masked.

    The simulator masks pixels that are not scored, although it measured them like the others. In
    its files a masked pixel keeps its samples, unless they exceed twice the largest valid one.
    """
    with np.errstate(invalid="ignore"):
        lost = abs(samples) >= _NOT_WRITTEN
        unknown = ~valid
        if simulated:
            largest = abs(samples).max(axis=tuple(range(samples.ndim - 2)))
            known = valid & (largest < _NOT_WRITTEN)
            unknown &= ~(largest <= 2 * largest[known].max(initial=0))
    return np.where(unknown | lost, np.float32(np.nan), samples)


def _raise_if_any(bad: Flags, what: str, advice: str) -> None:
    """Raise a ValueError with the number of bad samples, if there are any."""
    if amount := int(bad.sum()):
        raise ValueError(f"Expected {what}, got {amount} others. {advice}")
