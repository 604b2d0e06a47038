"""Measurement: the noun that simulator and instrument hand over. Open, validate, save.

A thin wrap around an `xarray.Dataset`:

=================  ============================  ==========================================
variable           dimensions                    meaning, unit
=================  ============================  ==========================================
``correlation``    frequency, step, y, x         correlation images, counts
``phase``          frequency, y, x               instead of ``correlation``: wrapped phase, rad
``amplitude``      frequency, y, x               optional beside ``phase``, counts
``frequency``      frequency                     coordinate: modulation frequency, Hz
``psi``            frequency, step               coordinate: reference phase, rad
``depth``          y, x                          optional: true range along the ray, m
``mask``           y, x                          optional: True where a pixel is valid
``camera``         parameter                     optional: fx, fy, cx, cy (and skew), pixels
``raw_counts``     frequency, step, y, x         optional: ADC counts of a scan, >= 0
``dark``           any of the above              optional: dark frame, counts
=================  ============================  ==========================================

Attributes: ``range_min``, ``range_max`` (m), ``source``, ``protocol``, ``seed``, ``version``, and
``saturation``, the count at which the converter clips. Stored as netCDF4 (``.nc``).
"""

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import TAU, Decoded, decode, wrap_length
from cmtof.files import written_whole
from cmtof.validation import check_frequencies, validate

UNITS = {
    "correlation": "count",
    "raw_counts": "count",
    "dark": "count",
    "amplitude": "count",
    "phase": "rad",
    "psi": "rad",
    "frequency": "Hz",
    "depth": "m",
    "camera": "px",
    "time": "s",
}


class Measurement:
    """Correlation images with all that is needed to turn them into depth.

    Parameters
    ----------
    dataset : xarray.Dataset
        As described at the top of this module; it is validated.

    Raises
    ------
    ValueError
        If something is missing, misshapen, not finite, negative or saturated.
    """

    def __init__(self, dataset: xr.Dataset) -> None:
        for name in dataset.variables:
            if name in UNITS:
                dataset[name].attrs.setdefault("units", UNITS[str(name)])
        validate(dataset)
        self.dataset = dataset

    @classmethod
    def from_arrays(
        cls,
        correlation: ArrayLike,
        psi: ArrayLike,
        frequencies: ArrayLike,
        *,
        depth: ArrayLike | None = None,
        mask: ArrayLike | None = None,
        camera: ArrayLike | None = None,
        range_min: float = 0.0,
        range_max: float | None = None,
        **attributes: Any,
    ) -> "Measurement":
        """Build a measurement from one's own arrays.

        Parameters
        ----------
        correlation : array_like, shape (F, K, H, W)
            Correlation images, counts.
        psi : array_like, shape (K,) or (F, K)
            Reference phase of every image, rad.
        frequencies : array_like, shape (F,)
            Modulation frequencies, lowest first, Hz.
        depth, mask : array_like, shape (H, W)
            True range, m, and validity.
        camera : array_like, shape (4,) or (5,)
            fx, fy, cx, cy, px, and the skew where there is one.
        range_min, range_max : float
            Depths to choose from, m; the default ends where two frequencies repeat themselves.
        **attributes
            Anything else that should stand in the file.
        """
        frequencies = np.atleast_1d(np.asarray(frequencies, float))
        correlation = np.asarray(correlation)
        psi = np.asarray(psi, float)
        if psi.ndim == 1:
            psi = np.broadcast_to(psi, (frequencies.size, psi.size))
        if correlation.ndim != 4 or correlation.shape[:2] != psi.shape:
            raise ValueError(
                f"Expected correlation (F, K, H, W) for psi {psi.shape}, got {correlation.shape}. "
                "Put frequency and step first."
            )
        images = {"correlation": (("frequency", "step", "y", "x"), correlation)}
        attributes |= {"range_min": range_min, "range_max": range_max}
        coordinates = {"psi": (("frequency", "step"), psi)}
        return cls(_dataset(images, frequencies, coordinates, depth, mask, camera, attributes))

    @classmethod
    def from_phase(
        cls,
        phase: ArrayLike,
        frequencies: ArrayLike,
        *,
        amplitude: ArrayLike | None = None,
        depth: ArrayLike | None = None,
        mask: ArrayLike | None = None,
        camera: ArrayLike | None = None,
        range_min: float = 0.0,
        range_max: float | None = None,
        **attributes: Any,
    ) -> "Measurement":
        """Build a measurement from phase maps (F, H, W), rad, where correlations were not kept."""
        frequencies = np.atleast_1d(np.asarray(frequencies, float))
        images = {"phase": (("frequency", "y", "x"), np.mod(np.asarray(phase), TAU))}
        if amplitude is not None:
            images["amplitude"] = (("frequency", "y", "x"), np.asarray(amplitude))
        attributes |= {"range_min": range_min, "range_max": range_max}
        return cls(_dataset(images, frequencies, {}, depth, mask, camera, attributes))

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
        """fx, fy, cx, cy, px, where the file holds them."""
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


def _dataset(
    images: Mapping[str, Any],
    frequencies: NDArray[np.float64],
    coordinates: Mapping[str, Any],
    depth: ArrayLike | None,
    mask: ArrayLike | None,
    camera: ArrayLike | None,
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """Assemble variables that are there; the range ends by default where the phases repeat."""
    from cmtof import __version__

    variables = dict(images)
    if depth is not None:
        variables["depth"] = (("y", "x"), np.asarray(depth))
    if mask is not None:
        variables["mask"] = (("y", "x"), np.asarray(mask).astype(np.int8))
    if camera is not None:
        variables["camera"] = (("parameter",), np.asarray(camera, float))
    kept = {key: value for key, value in attributes.items() if value is not None}
    check_frequencies(frequencies)
    kept.setdefault("range_max", unambiguous_range(frequencies))
    try:
        dataset = xr.Dataset(variables, {"frequency": frequencies, **coordinates})
    except ValueError as error:
        raise ValueError(
            f"Expected arrays of one image size, got {str(error).splitlines()[0]}. Check shapes."
        ) from error
    dataset.attrs = {"version": __version__, **kept}
    return dataset


def unambiguous_range(frequencies: ArrayLike) -> float:
    """Range within which the phases do not repeat as far as noise lets one tell, m.

    Two frequencies: the beat's ``c / 2 |f2 - k f1|`` with ``k = round(f2 / f1)``, 7.495 m for the
    prototype; one frequency: a single wrap.
    """
    low, high = np.min(frequencies), np.max(frequencies)
    beat = abs(high - np.round(high / low) * low)
    return float(wrap_length(beat if beat > 0 else low))


# --- files -------------------------------------------------------------------------------------


def save_dataset(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a dataset as netCDF4, beside first and then renamed; floats are compressed."""
    path = Path(path)
    if path.suffix != ".nc":
        raise ValueError(f"Expected an output named *.nc, got {path.name}. Rename it.")
    encoding = {name: {"zlib": True, "complevel": 1} for name in dataset.data_vars}
    with written_whole(path) as part:
        dataset.to_netcdf(part, engine="h5netcdf", encoding=encoding)


def open_measurement(path: str | Path) -> Measurement:
    """Open a measurement: ``.nc``, ``.npz`` with the same names, or a GHz-FMCW ``*_phase.csv``.

    Parameters
    ----------
    path : str or Path
        An ``.npz`` holds ``correlation`` (F, K, H, W), ``psi``, ``frequency`` and optionally
        ``depth``, ``mask``, ``camera``, ``range_min``, ``range_max``.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If it is empty, truncated, of another kind, or its content is not a measurement.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"Expected a measurement file, got no file at {path}. Check it.")
    readers = {".nc": _open_netcdf, ".npz": _open_npz, ".csv": _read_capture}
    if path.suffix not in readers:
        raise ValueError(
            f"Expected a file named *.nc, *.npz or *_phase.csv, got {path.name}. Convert it first."
        )
    return readers[path.suffix](path)


def read_dataset(path: str | Path) -> xr.Dataset:
    """Read a netCDF4 file of any content into memory; one ValueError for whatever is wrong."""
    try:
        with xr.open_dataset(path, engine="h5netcdf") as handle:
            return handle.load()
    except Exception as error:
        raise ValueError(
            f"Expected a whole netCDF4 file, got {path} ({_reason(error)}). Write it anew."
        ) from error


def _open_netcdf(path: Path) -> Measurement:
    return Measurement(read_dataset(path))


def _open_npz(path: Path) -> Measurement:
    from cmtof.scenes.frame import read_npz

    arrays = read_npz(path)
    missing = {"correlation", "psi", "frequency"} - arrays.keys()
    if missing:
        raise ValueError(
            f"Expected arrays correlation, psi and frequency in {path}, got {sorted(arrays)}. "
            "A frame of depth and intensity is turned into a measurement by `cmtof simulate`."
        )
    known = {k: arrays[k] for k in ("depth", "mask", "camera") if k in arrays}
    limits = {k: float(arrays[k]) for k in ("range_min", "range_max") if k in arrays}
    return Measurement.from_arrays(
        arrays["correlation"],
        arrays["psi"],
        arrays["frequency"],
        source=path.name,
        **known,
        **limits,
    )


def _read_capture(path: Path) -> Measurement:
    from cmtof.scenes.captures import read_capture

    phase, reference = read_capture(path)
    measurement = Measurement.from_phase(
        phase[None],
        [FREQUENCY_SINGLE],
        range_max=1.0,
        source=f"GHz-FMCW capture {path.name}",
        protocol="measured",
    )
    if reference is not None:
        measurement.dataset["reference_depth"] = (("y", "x"), reference, {"units": "m"})
    return measurement


def _reason(error: BaseException) -> str:
    """First line of an error, short enough for one line."""
    return (str(error).splitlines() or [type(error).__name__])[0][:120]
