"""Measurement: the product of simulator and instrument alike. Open, validate, save.

A thin wrap around an `xarray.Dataset` of the variables in `_VARIABLES`: ``correlation`` or
``phase``, with the coordinates ``frequency`` and ``psi`` (of correlations); the rest is optional.
Attributes: ``range_min``, ``range_max`` (m), ``source``, ``protocol``, ``seed``, ``version``, and
``saturation``, the count at which the converter clips. Stored as netCDF4 (``.nc``).
"""

import gc
import sys
from collections.abc import Iterator, Mapping
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import TAU, Decoded, check_psi, decode, residual_noise, wrap_length
from cmtof.files import check_input, check_output, written_whole
from cmtof.validation import check_claim, check_frequencies, expect, numbers

_STACK, _IMAGES = ("frequency", "step", "y", "x"), ("frequency", "y", "x")
_VARIABLES: dict[str, tuple[str, tuple[str, ...] | None]] = {
    "correlation": ("count", _STACK),  # correlation images
    "raw_counts": ("count", _STACK),  # of the converter in a scan, >= 0
    "dark": ("count", None),  # dark frame
    "phase": ("rad", _IMAGES),  # wrapped, instead of correlations
    "amplitude": ("count", _IMAGES),  # beside a phase
    "frequency": ("Hz", ("frequency",)),  # of the modulation
    "psi": ("rad", _STACK[:2]),  # reference phase
    "depth": ("m", ("y", "x")),  # true range along the ray
    "mask": ("1", ("y", "x")),  # True where a pixel is valid
    "camera": ("px", ("parameter",)),  # fx, fy, cx, cy (and skew)
    "time": ("s", None),
}  # unit and dimensions

MOST_WRAPS = 10_000
"""Greatest number of wraps of the lowest frequency to choose from; the prototype's beat has 358."""


class Measurement:
    """Correlation images with all that is needed to turn them into depth.

    ``dataset`` is described at the top of this module; a ValueError says if something in it is
    missing, misshapen, no number, not finite, negative or saturated.
    """

    def __init__(self, dataset: xr.Dataset) -> None:
        validate(dataset)
        for name in _VARIABLES.keys() & set(dataset.variables):
            dataset[name].attrs.setdefault("units", _VARIABLES[name][0])
        self.dataset = dataset

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
        frequencies = np.atleast_1d(numbers(frequencies, "frequencies"))
        correlation, psi = np.asarray(correlation), numbers(psi, "psi")
        if psi.ndim == 1:
            psi = np.broadcast_to(psi, (frequencies.size, psi.size))
        right = correlation.ndim == 4 and correlation.shape[:2] == psi.shape
        what = f"correlation (F, K, H, W), psi {psi.shape}"
        expect(right, what, correlation.shape, "Put frequency and step first.")
        variables = {"correlation": (_STACK, correlation)}
        coordinates = {"frequency": frequencies, "psi": (_STACK[:2], psi)}
        return cls(_dataset(variables, coordinates, more))

    @classmethod
    def from_phase(
        cls,
        phase: ArrayLike,
        frequencies: ArrayLike,
        *,
        amplitude: ArrayLike | None = None,
        **more: Any,
    ) -> "Measurement":
        """Measurement of phase maps (F, H, W), rad, where correlations were not kept."""
        frequencies = np.atleast_1d(numbers(frequencies, "frequencies"))
        variables = {"phase": (_IMAGES, np.mod(numbers(phase, "phase"), TAU))}
        if amplitude is not None:
            variables["amplitude"] = (_IMAGES, numbers(amplitude, "amplitude"))
        return cls(_dataset(variables, {"frequency": frequencies}, more))

    @property
    def frequencies(self) -> NDArray[np.float64]:
        """Modulation frequencies (F,), Hz."""
        return self.dataset["frequency"].to_numpy()

    @cached_property
    def decoded(self) -> Decoded:
        """Wrapped phase, rad, amplitude and offset, counts, each (F, H, W)."""
        if "correlation" in self.dataset:
            return decode(self.dataset["correlation"].to_numpy(), self.dataset["psi"].to_numpy())
        phase = self.dataset["phase"].to_numpy()
        amplitude = self._image("amplitude")
        amplitude = np.ones_like(phase) if amplitude is None else amplitude
        return Decoded(phase, amplitude, np.full_like(phase, np.nan))

    @property
    def phase(self) -> NDArray[np.floating]:
        """Wrapped phase (F, H, W) in [0, 2 pi), rad."""
        return self.decoded.phase

    @property
    def amplitude(self) -> NDArray[np.floating]:
        """Coefficient of the cosine (F, H, W), counts; ones where only phases were kept."""
        return self.decoded.amplitude

    @property
    def depth(self) -> NDArray[np.floating] | None:
        """True range along the ray (H, W), m, where the file holds it."""
        return self._image("depth")

    @property
    def mask(self) -> NDArray[np.bool_]:
        """Valid pixels (H, W)."""
        mask = self._image("mask")
        return np.ones(self.shape, bool) if mask is None else mask.astype(bool)

    @property
    def camera(self) -> NDArray[np.floating] | None:
        """Camera fx, fy, cx, cy (and skew), px, where the file holds it."""
        return self._image("camera")

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width, px."""
        return self.dataset.sizes["y"], self.dataset.sizes["x"]

    @property
    def range(self) -> tuple[float, float]:
        """Depths to choose from, ``min <= z < max``, m."""
        return float(self.dataset.attrs["range_min"]), float(self.dataset.attrs["range_max"])

    def between(self, range_min: float, range_max: float) -> "Measurement":
        """Return the same measurement with another range to choose from, m."""
        limits = {"range_min": float(range_min), "range_max": float(range_max)}
        return Measurement(self.dataset.assign_attrs(limits))

    def _image(self, name: str) -> NDArray | None:
        return self.dataset[name].to_numpy() if name in self.dataset else None

    def save(self, path: str | Path) -> None:
        """Write netCDF4; the file is there whole or not at all."""
        save_dataset(self.dataset, path)

    def __repr__(self) -> str:
        height, width = self.shape
        tones = ", ".join(f"{f / 1e9:g}" for f in self.frequencies)
        low, high = self.range
        return f"<Measurement {height}x{width} px at {tones} GHz, {low:.3f}-{high:.3f} m>"


def tiles(
    dataset: xr.Dataset, tile: int, margin: int
) -> Iterator[tuple[Measurement, dict[str, slice], tuple[slice, slice]]]:
    """Square parts of a measurement, each with ``margin`` px around it, loaded one by one.

    Yields what is seen, its rays those of the whole, the part in that, and the part in the image.
    """
    for y, x in product(range(0, dataset.sizes["y"], tile), range(0, dataset.sizes["x"], tile)):
        top, left = max(y - margin, 0), max(x - margin, 0)
        ends = {"y": slice(top, y + tile + margin), "x": slice(left, x + tile + margin)}
        seen = dataset.isel(ends).load()
        if "camera" in seen:
            seen["camera"] = seen["camera"] - np.resize([0, 0, left, top, 0], seen.camera.size)
        inner = {"y": slice(y - top, y - top + tile), "x": slice(x - left, x - left + tile)}
        yield Measurement(seen), inner, np.s_[y : y + tile, x : x + tile]


def _dataset(
    variables: dict[str, Any], coordinates: Mapping[str, Any], more: dict[str, Any]
) -> xr.Dataset:
    """Assemble variables that are there; the range ends by default where the phases repeat."""
    from cmtof import __version__

    for name in ("depth", "mask", "camera"):
        if (values := more.pop(name, None)) is not None:
            array = np.asarray(values)
            if name != "depth":
                array = numbers(values, name, np.int8 if name == "mask" else float)
            variables[name] = (_VARIABLES[name][1], array)
    check_frequencies(coordinates["frequency"])
    kept = {key: value for key, value in more.items() if value is not None}
    limits = {"range_min": 0.0, "range_max": unambiguous_range(coordinates["frequency"])}
    try:
        dataset = xr.Dataset(variables, coordinates)
    except ValueError as error:
        expect(False, "arrays of one image size", str(error).splitlines()[0], "Check shapes.")
    dataset.attrs = {"version": __version__, **limits, **kept}
    return dataset


def unambiguous_range(frequencies: ArrayLike) -> float:
    """Range within which the phases do not repeat, within their noise, m.

    Two frequencies: the beat's ``c / 2 |f2 - k f1|`` with ``k = round(f2 / f1)``, 7.495 m for the
    prototype; one frequency: a single wrap.
    """
    low, high = np.min(frequencies), np.max(frequencies)
    beat = abs(high - np.round(high / low) * low)
    return float(wrap_length(beat if beat > 0 else low))


# --- what a measurement must be ----------------------------------------------------------------


def validate(dataset: xr.Dataset) -> None:
    """Raise a ValueError that states what is wrong with a dataset, and how to mend it."""
    data = "correlation" if "correlation" in dataset else "phase"
    what, got = "a variable 'correlation' (frequency, step, y, x)", list(dataset)
    expect(data in dataset, what, got, "See the page «Bring your own data».")
    for name in ("frequency", "psi") if data == "correlation" else ("frequency",):
        got = list(dataset.coords)
        expect(name in dataset.coords, f"a coordinate '{name}'", got, "State it for every image.")
    for name, (_, dims) in _VARIABLES.items():
        if name in dataset.variables:
            found, kind = dataset[name], dataset[name].dtype
            expect(kind.kind in "biuf", f"numbers as {name}", f"type {kind}", "Store floats.")
            right = found.size and found.dims == (dims or found.dims)
            what = f"{name} with dimensions {dims}, none of them empty"
            expect(right, what, dict(found.sizes), "Transpose or rename them.")
    check_frequencies(dataset["frequency"].to_numpy())
    if "camera" in dataset:
        camera = dataset["camera"].to_numpy()
        right = camera.size in (4, 5) and np.isfinite(camera).all() and (camera[:2] > 0).all()
        expect(right, "camera [fx, fy, cx, cy] in px", camera.tolist(), "Correct it.")
    for steps in dataset["psi"].to_numpy() if data == "correlation" else ():
        check_psi(np.asarray(steps, float))
    _check_range(dataset)
    _check_values(dataset, data)


def _check_range(dataset: xr.Dataset) -> None:
    ends = [dataset.attrs.get(key, np.nan) for key in ("range_min", "range_max")]
    plain = all(np.size(end) == 1 and np.asarray(end).dtype.kind in "iuf" for end in ends)
    low, high = map(float, ends) if plain else (np.nan, np.nan)
    what = "attributes 0 <= range_min < range_max in m"
    expect(0 <= low < high < np.inf, what, ends, "Set the depths to choose from.")
    wraps = high / float(wrap_length(dataset["frequency"].to_numpy()[0]))
    what = f"at most {MOST_WRAPS} wraps of the lowest frequency within range_max"
    expect(wraps <= MOST_WRAPS, what, f"{wraps:.3g}", "Lower range_max or the frequency.")


def _check_values(dataset: xr.Dataset, data: str) -> None:
    """Valid pixels only: finite, no negative light, raw counts within the converter's scale."""
    valid = dataset["mask"].to_numpy().astype(bool) if "mask" in dataset else np.True_
    values = dataset[data].to_numpy()

    def refuse(bad: NDArray, what: str, got: str, advice: str) -> None:
        amount = int((bad & valid).sum())
        expect(not amount, what, f"{amount} {got}", advice)

    refuse(~np.isfinite(values), f"finite {data}", "NaN or inf", "Mask those pixels.")
    if data == "phase":
        return
    for images, steps in zip(values, dataset["psi"].to_numpy(), strict=True):
        if steps.size > 3:  # three steps are fitted exactly and show no noise
            # a noisy sample may be negative (Eq. 8), a pixel's mean only by as much as noise
            mean, noise = images.mean(axis=0), residual_noise(images, steps) / np.sqrt(steps.size)
            bad = mean < -10 * noise - 1e-6 * np.abs(mean).max()
            got, advice = "pixels whose mean over psi is negative", "Check the dark frame."
            refuse(bad, "counts >= 0 up to noise", got, advice)
    counts = dataset.get("raw_counts", dataset["correlation"]).to_numpy()
    if np.issubdtype(values.dtype, np.integer) or "raw_counts" in dataset:
        refuse(counts < 0, "counts >= 0", "negative ones", "Check the sign of the read-out.")
    if (limit := dataset.attrs.get("saturation")) is not None:
        most = float(np.min(numbers(limit, "the attribute saturation"), initial=np.inf))
        what, advice = f"counts below the saturation {most:g}", "Lower gain or exposure, or mask."
        refuse(counts >= most, what, "at or above it", advice)


# --- files -------------------------------------------------------------------------------------


def save_dataset(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a dataset as netCDF4, beside first and then renamed; arrays are compressed.

    The file is built in memory: HDF5 written to a full disk would end the process.
    """
    check_output(path, ".nc")
    encoding = {name: {"zlib": True, "complevel": 1} for name in dataset.data_vars}
    stored = dataset.to_netcdf(engine="h5netcdf", encoding=encoding)
    with written_whole(path) as part:
        part.write_bytes(stored)


def open_measurement(path: str | Path) -> Measurement:
    """Open a measurement: ``.nc``, ``.npz`` with the same names, or a GHz-FMCW ``*_phase.csv``.

    An ``.npz`` holds ``correlation`` (F, K, H, W), ``psi``, ``frequency`` and optionally ``depth``,
    ``mask``, ``camera``, ``range_min``, ``range_max``. FileNotFoundError if there is no such file,
    ValueError if it is empty, truncated, of another kind, or holds no measurement.
    """
    path = check_input(path, "a measurement file")
    if path.suffix == ".nc":
        return Measurement(read_dataset(path))
    if path.suffix == ".npz":
        return _open_npz(path)
    what = "a file named *.nc, *.npz or *_phase.csv"
    expect(path.suffix == ".csv", what, path.name, "Convert it first.")
    return _open_capture(path)


def read_dataset(path: str | Path) -> xr.Dataset:
    """Read a netCDF4 file of any content into memory; one ValueError for whatever is wrong."""
    check_input(path)
    heard, sys.unraisablehook = sys.unraisablehook, lambda _: None
    reason = ""
    try:  # h5netcdf's destructor would print a traceback of its own for a damaged file
        with xr.open_dataset(path, engine="h5netcdf", decode_times=False) as handle:
            check_claim(handle.nbytes, Path(path).stat().st_size)
            return handle.load()
    except Exception as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0][:120]
    finally:
        if reason:
            gc.collect()
        sys.unraisablehook = heard
    raise ValueError(f"Expected a whole netCDF4 file, got {path} ({reason}). Write it again.")


def _open_npz(path: Path) -> Measurement:
    from cmtof.frame import read_npz

    arrays = read_npz(path)
    needed = ("correlation", "psi", "frequency")
    what = f"arrays {', '.join(needed)} in {path}"
    advice = "A frame of depth and intensity becomes a measurement by `cmtof simulate`."
    expect(arrays.keys() >= set(needed), what, sorted(arrays), advice)
    images = {k: arrays[k] for k in ("depth", "mask", "camera") if k in arrays}
    limits = {k: float(arrays[k]) for k in ("range_min", "range_max") if k in arrays}
    return Measurement.from_arrays(
        *(arrays[k] for k in needed), source=path.name, **images, **limits
    )


def _open_capture(path: Path) -> Measurement:
    from cmtof.captures import read_capture

    phase, reference = read_capture(path)
    about = {"source": f"GHz-FMCW capture {path.name}", "protocol": "measured", "range_max": 1.0}
    measurement = Measurement.from_phase(phase[None], [FREQUENCY_SINGLE], **about)
    if reference is not None:
        measurement.dataset["reference_depth"] = (("y", "x"), reference, {"units": "m"})
    return measurement
