"""Unwrapping by any method: from a measurement to wrap count, depth and confidence."""

import shutil
from collections.abc import Iterator
from typing import Any

import numpy as np
from xarray import Dataset

from cmtof import __version__
from cmtof.contract import with_coordinates
from cmtof.correlation import (
    TAU,
    consistent_wrap_count,
    depth_from_wraps,
    wrap_count_from_depth,
    wrap_length,
)
from cmtof.estimate import Components, Estimate, sets_of_wraps, within_range
from cmtof.files import AnyPath, atomic_output
from cmtof.measurement import Measurement, open_measurement, tiles
from cmtof.methods import DEFAULT, find_method
from cmtof.storage import open_netcdf, save_dataset, storable
from cmtof.types import Fields, Pair

# Share of the image, measurement, result.
Unwrapped = tuple[float, Measurement, Dataset]


def unwrap(
    measurement: Measurement,
    *,
    method: str = DEFAULT,
    range: Pair | None = None,
    min_confidence: float = 0.0,
    covered: Measurement | None = None,
    **options: Any,
) -> Dataset:
    """Wrap count, depth and confidence of a measurement, by a method out of `METHODS`.

    ``range`` holds the depths to choose from, ``min <= z < max``, m, by default the measurement's
    own; pixels below ``min_confidence`` are masked; with a measurement of a ``covered`` beam stray
    light is taken away before. Methods use the two lowest frequencies; ``options`` are theirs, as
    ``window=81`` of ``beat``. A ValueError says what is unknown, wrong, or does not suit them.

    On (y, x) the result has ``wrap_count``, the estimate of ``floor(phi / 2 pi)`` at the lowest
    frequency, -1 where masked; ``depth``, m, of the measured phase with the wraps consistent with
    it, NaN there; ``confidence`` in [0, 1]. ``surfaces`` and ``hybrid`` add

    - ``within_90`` and ``within_95``: how far, in wraps, the true count lies from ``wrap_count`` at
      most, in 90 and 95 % of the pixels of an average room; -1 where masked;
    - ``component``: pixels that share one offset, numbered from 1, the largest first, 0 for none;
    - ``component_odds`` (number, offset): probability that the component lies so many wraps
      farther than its depth; it is right at offset 0.

    >>> import cmtof
    >>> measurement = cmtof.simulate(cmtof.load_frame("still_life"), noise_free=True)
    >>> result = cmtof.unwrap(measurement, method="crt")
    >>> bool(abs(result.depth - measurement.depth).max() < 1e-4)
    True
    """
    chosen = find_method(method)
    if not 0 <= min_confidence <= 1:
        raise ValueError(
            f"Expected min_confidence from 0 to 1, got {min_confidence}. Choose 0.5, say."
        )
    if covered is not None:
        measurement = measurement.without_stray_light(covered)
    if range is not None:
        measurement = _change_range(measurement, *range)
    estimate = chosen(measurement, **options)
    attributes = {
        "method": chosen.name,
        "method_source": chosen.source,
        "frequency": measurement.frequencies[0],
        "range_min": measurement.range[0],
        "range_max": measurement.range[1],
        "min_confidence": float(min_confidence),
        "stray_light_removed": int(covered is not None),
        **{f"option_{name}": storable(value) for name, value in options.items()},
        "version": __version__,
    }
    images = _result_variables(estimate, measurement, min_confidence)
    if chosen.sets:
        images |= _interval_variables(images, estimate.components, measurement)
    result = Dataset(images, attrs=attributes)
    for variable in result.variables.values():
        variable.attrs.setdefault("units", "1")
    return result


def _interval_variables(
    images: Fields, components: Components | None, measurement: Measurement
) -> Fields:
    """Intervals of wraps and, if the method returned any, components: variables by name."""
    known = images["wrap_count"][1] >= 0
    variables: Fields = {
        name: (("y", "x"), np.where(known, most, -1).astype(np.int16))
        for name, most in sets_of_wraps(images["confidence"][1], measurement).items()
    }
    if components:
        label, odds = components
        variables["component"] = ("y", "x"), np.where(known, label, 0).astype(np.int32)
        variables["component_odds"] = ("number", "offset"), odds.astype(np.float32)
        variables["number"] = "number", np.arange(len(odds)) + 1
        variables["offset"] = "offset", np.arange(odds.shape[1]) - odds.shape[1] // 2
    return variables


def _result_variables(
    estimate: Estimate, measurement: Measurement, min_confidence: float
) -> Fields:
    """Wrap count, depth and confidence by name; depth is the measured phase plus whole wraps."""
    frequency = measurement.frequencies[0]
    phase = measurement.phase[0]
    mask = measurement.mask
    # the estimate of a masked pixel may be NaN
    estimated_depth = within_range(
        np.where(mask, estimate.depth, measurement.range[0]), measurement
    )
    # wraps whose depth obeys min <= z < max
    ends = np.asarray(measurement.range) / wrap_length(frequency)
    first, last = np.ceil(ends[:, None, None] - phase / TAU - 1e-9)
    wraps = consistent_wrap_count(estimated_depth, phase, frequency)
    wraps = np.clip(wraps, first, np.maximum(first, last - 1))
    depth = depth_from_wraps(phase, wraps, frequency)
    confidence = np.where(mask, estimate.confidence, 0).astype(
        np.float32
    )  # as it is stored and scored
    mask &= confidence >= min_confidence
    count = np.where(mask, wrap_count_from_depth(estimated_depth, frequency), -1)
    dims = ("y", "x")
    return {
        "wrap_count": (dims, count.astype(np.int32)),
        "depth": (
            dims,
            np.where(mask, depth, np.nan).astype(np.float32),
            {"units": "m"},
        ),
        "confidence": (dims, confidence),
    }


def _change_range(measurement: Measurement, low: float, high: float) -> Measurement:
    """The measurement with another range, m; a ValueError unless it overlaps the old one."""
    old = measurement.range
    if not (0 <= low < high and high > old[0] and low < old[1]):
        raise ValueError(
            f"Expected a range 0 <= MIN < MAX in m that meets the data's {old[0]:.3f} to "
            f"{old[1]:.3f}, got {low:g} to {high:g}. "
            "Widen or move it."
        )
    return measurement.between(low, high)


def unwrap_file(
    source: AnyPath, output: AnyPath, *, tile: int = 0, margin: int = 128, **how: Any
) -> Iterator[Unwrapped]:
    """Unwrap a file into a ``.nc``; with ``tile`` in square tiles, for a ``.nc`` beyond memory.

    A tile of ``tile`` px is unwrapped together with ``margin`` px around it, by `unwrap` with the
    options ``how``. Yields the share of each tile in the image, its measurement and its result;
    the output is there after the last one. OSError if the disk cannot hold it.
    """
    if tile > 0:
        yield from _unwrap_tiles(source, output, tile, margin, **how)
    else:
        opened = open_measurement(source)
        yield 1.0, opened, (result := unwrap(opened, **how))
        save_dataset(result, output)


def _unwrap_tiles(
    source: AnyPath, output: AnyPath, tile: int, margin: int, **how: Any
) -> Iterator[Unwrapped]:
    """Unwrap a file in tiles, each with a margin, px; yields as `unwrap_file` does."""
    import h5netcdf

    if not str(source).endswith(".nc"):
        raise ValueError(
            f"Expected a .nc to read by tiles, got {source}. Leave the tiles out."
        )
    with open_netcdf(source) as handle, atomic_output(output, ".nc") as part:
        dataset = with_coordinates(handle)
        height = dataset.sizes["y"]
        width = dataset.sizes["x"]
        if shutil.disk_usage(part.parent).free < (
            need := 16 * height * width + 2**20
        ):  # or HDF5 ends all
            raise OSError(
                f"Expected {need} bytes of disk space for {output}, got less. Free some."
            )
        with h5netcdf.File(part, "w") as file:
            file.dimensions = {"y": height, "x": width}
            for seen, inner, place in tiles(dataset, tile, margin):
                result = (
                    unwrap(seen, **how)
                    .drop_vars(
                        ["component", "component_odds", "number", "offset"],
                        errors="ignore",
                    )
                    .isel(inner)
                )
                _write_tile(file, result, place)
                file.attrs.update(result.attrs | {"tile": tile, "margin": margin})
                yield (
                    result.depth.size / (height * width),
                    Measurement(seen.dataset.isel(inner)),
                    result,
                )


def _write_tile(file: Any, result: Dataset, place: tuple[slice, slice]) -> None:
    """Write the images of a tile to their place in an open h5netcdf file."""
    for name, image in result.items():
        if name not in file.variables:
            file.create_variable(
                name,
                ("y", "x"),
                image.dtype,
                chunks=image.shape,
                compression="gzip",
                compression_opts=1,
            ).attrs.update(image.attrs)
        file.variables[name][place] = image.to_numpy()
