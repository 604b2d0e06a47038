"""Measurement: what simulator and instrument produce, and unwrapping reads.

A thin wrap around an `xarray.Dataset` of the variables in `cmtof.contract`: ``correlation`` or
``phase``, with the coordinates ``frequency`` and ``psi`` (of correlations); the rest is optional.
Attributes: ``range_min``, ``range_max`` (m), ``source``, ``protocol``, ``seed``, ``version``, and
``saturation``, the count at which the converter clips. Stored as netCDF4 (``.nc``).
"""

from collections.abc import Iterator, Mapping
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from xarray import Dataset

from cmtof.constants import FREQUENCY_SINGLE
from cmtof.contract import VARIABLES, checked_dataset
from cmtof.contract import unambiguous_range as unambiguous_range
from cmtof.correlation import Decoded, decode
from cmtof.files import AnyPath, check_input
from cmtof.storage import load_into_memory, open_netcdf, save_dataset
from cmtof.types import Array, Fields, Flags, Named, Pair, Shape
from cmtof.validation import numbers


class Measurement:
    """Correlation images, or phase maps, with all that is needed to turn them into depth.

    ``dataset`` is described at the top of this module; a ValueError says if something in it is
    missing, misshapen, no number, not finite or saturated. It is held in SI units and in floats,
    NaN where a pixel is masked, unless it was simulated.
    """

    def __init__(self, dataset: Dataset) -> None:
        self.dataset = checked_dataset(dataset)

    @classmethod
    def from_arrays(
        cls, correlation: ArrayLike, psi: ArrayLike, frequencies: ArrayLike, **more: Any
    ) -> "Measurement":
        """Measurement of correlation images (F, K, H, W), counts, at ``psi`` (K,) or (F, K), rad.

        Frequencies (F,), Hz, lowest first. ``more`` are ``depth`` (H, W), m, ``mask`` (H, W) and
        ``camera`` (4,) or (5,), px; ``range_min`` and ``range_max``, the depths to choose from, m
        (by default from 0 to where two frequencies repeat themselves); and anything else that the
        file should hold as an attribute.
        """
        steps = numbers(psi, "psi")
        if steps.ndim == 1:
            steps = np.broadcast_to(steps, (np.size(frequencies), steps.size))
        shape = np.shape(correlation)
        if shape[:-2] != steps.shape:
            raise ValueError(
                f"Expected correlation (F, K, H, W) and psi (F, K), got {shape}. "
                "Put frequency and step first."
            )
        coordinates = {
            "frequency": _variable("frequency", frequencies),
            "psi": (VARIABLES["psi"].dims, steps, getattr(psi, "attrs", {})),
        }
        return cls(_dataset({"correlation": correlation}, coordinates, more))

    @classmethod
    def from_phase(
        cls,
        phase: ArrayLike,
        frequencies: ArrayLike,
        *,
        amplitude: ArrayLike | None = None,
        **more: Any,
    ) -> "Measurement":
        """Measurement of phase maps (F, H, W), rad, where correlations were not kept.

        The noise of a pixel is taken to fall with its ``amplitude`` (F, H, W), in any unit. How
        large it is, the beats of neighbours tell.
        """
        variables = {"phase": phase, "amplitude": amplitude}
        coordinates = {"frequency": _variable("frequency", frequencies)}
        return cls(_dataset(variables, coordinates, more))

    @cached_property
    def frequencies(self) -> Array:
        """Modulation frequencies (F,), Hz."""
        return self.dataset["frequency"].to_numpy()

    @cached_property
    def decoded(self) -> Decoded:
        """Wrapped phase, rad, amplitude and offset, counts, each (F, H, W), in float64.

        Where nothing valid was measured the phase is 0 and the others NaN.
        """
        if "correlation" in self.dataset:
            images = decode(self.dataset["correlation"], self.dataset["psi"])
            return Decoded(*(image.astype(float) for image in images))
        phase = self.dataset["phase"].to_numpy().astype(float)
        stored = self.dataset.get("amplitude", np.ones_like(phase))
        amplitude = np.asarray(stored, float)
        known = np.isfinite(phase) & np.isfinite(amplitude)
        return Decoded(
            np.where(known, phase, 0),
            np.where(known, amplitude, np.nan),
            np.full_like(phase, np.nan),
        )

    @property
    def phase(self) -> Array:
        """Wrapped phase (F, H, W) in [0, 2 pi), rad; 0 where nothing valid was measured."""
        return self.decoded.phase

    @property
    def amplitude(self) -> Array:
        """Coefficient of the cosine (F, H, W), counts, or NaN; ones if only phases were stored."""
        return self.decoded.amplitude

    @property
    def depth(self) -> Array | None:
        """True range along the ray (H, W), m; None if the file does not hold it."""
        return self._image("depth")

    @property
    def mask(self) -> Flags:
        """True (H, W) where a pixel is valid."""
        return np.array(self.dataset.get("mask", np.ones(self.shape)), bool)

    @property
    def camera(self) -> Array | None:
        """Camera fx, fy, cx, cy (and skew), px; None if the file does not hold it."""
        return self._image("camera")

    @property
    def shape(self) -> Shape:
        """Height and width, px."""
        return self.dataset.sizes["y"], self.dataset.sizes["x"]

    @property
    def range(self) -> Pair:
        """Least and largest depth, m, among which methods choose: ``min <= z < max``."""
        return self.dataset.attrs["range_min"], self.dataset.attrs["range_max"]

    def between(self, range_min: float, range_max: float) -> "Measurement":
        """The same measurement with another `range` of depths, m."""
        return Measurement(
            self.dataset.assign_attrs(range_min=range_min, range_max=range_max)
        )

    def without_stray_light(self, covered: "Measurement") -> "Measurement":
        """The same measurement without light that never reached the scene, but came straight back.

        It is the mean of ``covered``, at any psi: measured by the same instrument with a covered
        beam. A ValueError says if one of both has no correlations, they differ in frequency, or
        no pixel of ``covered`` is valid.
        """
        alike = np.array_equal(self.frequencies, covered.frequencies)
        if not (
            alike
            and covered.mask.any()
            and "correlation" in self.dataset
            and "correlation" in covered.dataset
        ):
            raise ValueError(
                "Expected valid correlations at the same frequencies with and without a covered "
                "beam, got others. Scan the covered beam with the settings of the scene."
            )
        phase, amplitude, offset = covered.decoded
        images = [offset, amplitude * np.exp(1j * phase)]
        mean, phasor = np.nanmean(images, axis=(2, 3))[..., None]
        light = (mean + phasor * np.exp(1j * self.dataset["psi"])).real
        seen = self.dataset["correlation"]
        return Measurement(
            self.dataset.assign(correlation=seen - light.astype(seen.dtype))
        )

    def _image(self, name: str) -> NDArray | None:
        return self.dataset[name].to_numpy() if name in self.dataset else None

    def save(self, path: AnyPath) -> None:
        """Write a netCDF4 file, whole or not at all."""
        save_dataset(self.dataset, path)

    def __repr__(self) -> str:
        height, width = self.shape
        tones = ", ".join(f"{f / 1e9:g}" for f in self.frequencies)
        low, high = self.range
        return (
            f"<Measurement {height}x{width} px at {tones} GHz, {low:.3f}-{high:.3f} m>"
        )


def tiles(
    dataset: Dataset, tile: int, margin: int
) -> Iterator[tuple[Measurement, dict[str, slice], tuple[slice, slice]]]:
    """Square tiles of a measurement, each with ``margin`` px around it, loaded one by one.

    Yields the measurement of a tile with its margin, slices of the tile in it, by dimension, and
    slices of the tile in the image. The camera is moved, so that rays are those of the image.
    """
    for y, x in product(
        range(0, dataset.sizes["y"], tile), range(0, dataset.sizes["x"], tile)
    ):
        top = max(y - margin, 0)
        left = max(x - margin, 0)
        seen = load_into_memory(
            dataset.isel(
                y=slice(top, y + tile + margin), x=slice(left, x + tile + margin)
            )
        )
        if "camera" in seen:
            seen["camera"] = seen["camera"] - np.resize(
                [0, 0, left, top, 0], seen.camera.size
            )
        inner = {
            "y": slice(y - top, y - top + tile),
            "x": slice(x - left, x - left + tile),
        }
        yield Measurement(seen), inner, np.s_[y : y + tile, x : x + tile]


def _dataset(variables: Fields, coordinates: Named, more: Fields) -> Dataset:
    """Dataset of arrays by name without those that are None; masks of masked arrays are applied."""
    from cmtof import __version__

    depth = more.pop("depth", None)
    mask = more.pop("mask", None)
    if np.ma.is_masked(depth):
        depth = np.ma.filled(np.ma.asarray(depth, float), np.nan)
    variables = variables | {"camera": more.pop("camera", None), "depth": depth}
    arrays = {name: values for name, values in variables.items() if values is not None}
    attributes = {"version": __version__} | {
        key: value for key, value in more.items() if value is not None
    }
    try:
        if (valid := _valid_pixels(arrays, mask)) is not None:
            arrays["mask"] = valid
        images = {name: _variable(name, values) for name, values in arrays.items()}
        return Dataset(images, coordinates, attributes)
    except ValueError as error:
        if str(error).startswith("Expected"):
            raise
        reason = str(error).splitlines()[0]
        raise ValueError(
            f"Expected arrays of one image size, got others ({reason}). Check shapes."
        ) from None


def _variable(name: str, values: ArrayLike) -> tuple:
    """Dimensions, array, and attributes of given values; a ValueError if they have other axes."""
    dims: Any = VARIABLES[name].dims
    array = np.atleast_1d(np.asarray(values))
    if array.ndim != len(dims):
        raise ValueError(
            f"Expected {name} with dimensions {dims}, got shape {array.shape}. "
            "Add or take away an axis."
        )
    return dims, array, getattr(values, "attrs", {})


def _valid_pixels(
    images: Mapping[str, ArrayLike], mask: ArrayLike | None
) -> NDArray | None:
    """Mask (H, W), 0 or NaN where the mask or a masked array hides a pixel; None without either."""
    parts = []
    if mask is not None:
        parts.append(numbers(np.ma.filled(mask, 0), "mask"))
    for image in images.values():
        if np.ma.is_masked(image):
            hidden = np.ma.getmaskarray(image)  # pyright: ignore[reportArgumentType, reportCallIssue]
            parts.append(~hidden.any(axis=tuple(range(hidden.ndim - 2))))
    return np.prod(parts, axis=0) if parts else None


def open_measurement(path: AnyPath) -> Measurement:
    """Open a measurement: ``.nc``, ``.npz`` with the same names, or a GHz-FMCW ``*_phase.csv``.

    An ``.npz`` holds ``correlation`` (F, K, H, W), ``psi``, ``frequency`` and optionally ``depth``,
    ``mask``, ``camera``, ``range_min``, ``range_max``. FileNotFoundError if there is no such file,
    ValueError if it is empty, truncated, of another kind, or holds no measurement.
    """
    path = check_input(path, "a measurement file")
    if path.suffix == ".nc":
        with open_netcdf(path) as handle:
            return Measurement(load_into_memory(handle))
    if path.suffix == ".npz":
        return _open_npz(path)
    if path.suffix == ".csv":
        return _open_capture(path)
    raise ValueError(
        f"Expected a file named *.nc, *.npz or *_phase.csv, got {path.name}. Rename or convert it."
    )


def _open_npz(path: Path) -> Measurement:
    from cmtof.frame import read_npz

    arrays = read_npz(path)
    needed = ("correlation", "psi", "frequency")
    if not arrays.keys() >= set(needed):
        raise ValueError(
            f"Expected arrays {', '.join(needed)} in {path}, got {', '.join(sorted(arrays))}. "
            "A frame of depth and intensity becomes a measurement by `cmtof simulate`."
        )
    optional = ("depth", "mask", "camera", "range_min", "range_max")
    more = {name: arrays[name][()] for name in optional if name in arrays}
    return Measurement.from_arrays(
        *map(arrays.__getitem__, needed), source=path.name, **more
    )


def _open_capture(path: Path) -> Measurement:
    from cmtof.captures import read_capture

    phase, reference = read_capture(path)
    measurement = Measurement.from_phase(
        phase[None],
        [FREQUENCY_SINGLE],
        source=f"GHz-FMCW capture {path.name}",
        protocol="measured",
        range_max=1.0,
    )
    if reference is not None:
        measurement.dataset["reference_depth"] = (("y", "x"), reference, {"units": "m"})
    return measurement
