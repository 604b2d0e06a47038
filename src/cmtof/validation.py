"""What a measurement must be before anything is computed from it; each fault in one sentence."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from cmtof.correlation import check_psi, residual_noise

if TYPE_CHECKING:
    import xarray as xr


def numbers(values: ArrayLike, what: str, dtype: DTypeLike = np.float64) -> NDArray[np.floating]:
    """Values as a new array of floats; text, complex, structured and time types are refused.

    Examples
    --------
    >>> numbers(["1.0"], "depth")
    Traceback (most recent call last):
    ...
    ValueError: Expected numbers as depth, got values of type <U3. Store them as float.
    """
    array = np.asarray(values)
    if array.dtype.kind not in "biuf":
        raise ValueError(
            f"Expected numbers as {what}, got values of type {array.dtype}. Store them as float."
        )
    with np.errstate(over="ignore"):  # beyond float32 is infinite, and refused as such
        return array.astype(dtype)


def check_claim(claimed: int, stored: int) -> None:
    """Raise a ValueError if a header claims far more bytes than its file can hold.

    Up to 256 MiB pass; beyond, 200 times the bytes on disk: real images are packed less.
    """
    if claimed > max(2**28, 200 * stored):
        raise ValueError(f"its header claims {claimed:.3g} bytes, it holds {stored}")


def check_frequencies(frequencies: NDArray[np.floating]) -> None:
    """Raise a ValueError unless frequencies (F,) in Hz are finite, positive and rising."""
    if not (np.isfinite(frequencies).all() and (frequencies > 0).all() and frequencies.size):
        raise ValueError(
            f"Expected modulation frequencies > 0 Hz, got {frequencies.tolist()}. "
            "State them in Hz, for instance 7.15e9."
        )
    if (np.diff(frequencies) <= 0).any():
        raise ValueError(
            f"Expected frequencies in rising order, got {frequencies.tolist()}. "
            "Sort them, and the images with them."
        )


def validate(dataset: "xr.Dataset") -> None:
    """Raise a ValueError that says what is wrong with a dataset, and how to mend it."""
    data = "correlation" if "correlation" in dataset else "phase"
    dims = ("frequency", "step", "y", "x") if data == "correlation" else ("frequency", "y", "x")
    if data not in dataset:
        raise ValueError(
            f"Expected a variable 'correlation' (frequency, step, y, x), got {list(dataset)}. "
            "See the page «Bring your own data»."
        )
    if dataset[data].dims != dims or 0 in dataset[data].shape:
        raise ValueError(
            f"Expected {data} with dimensions {dims}, none of them empty, got "
            f"{dict(dataset[data].sizes)}. Transpose or rename them."
        )
    if "frequency" not in dataset.coords:
        raise ValueError("Expected a coordinate 'frequency' in Hz, got none. Add it.")
    check_frequencies(dataset["frequency"].to_numpy())
    _check_companions(dataset)
    if data == "correlation":
        if "psi" not in dataset.coords or dataset["psi"].dims != ("frequency", "step"):
            raise ValueError(
                "Expected a coordinate 'psi' (frequency, step) in rad, got "
                f"{list(dataset.coords)}. State the reference phase of every image."
            )
        for steps in dataset["psi"].to_numpy():
            check_psi(np.asarray(steps, float))
    _check_range(dataset)
    _check_values(dataset, data)


def _check_companions(dataset: "xr.Dataset") -> None:
    for name in ("depth", "mask"):
        if name in dataset and dataset[name].dims != ("y", "x"):
            raise ValueError(
                f"Expected {name} with dimensions ('y', 'x'), got {dataset[name].dims}. "
                "Transpose it."
            )
    if "camera" in dataset:
        camera = dataset["camera"].to_numpy()
        if camera.shape not in ((4,), (5,)) or not (
            np.isfinite(camera).all() and (camera[:2] > 0).all()
        ):
            raise ValueError(
                f"Expected camera [fx, fy, cx, cy] in px, got {camera.tolist()}. Correct it."
            )


def _check_range(dataset: "xr.Dataset") -> None:
    low, high = (dataset.attrs.get(key) for key in ("range_min", "range_max"))
    if low is None or high is None or not 0 <= float(low) < float(high) < np.inf:
        raise ValueError(
            f"Expected attributes 0 <= range_min < range_max in m, got {low} and {high}. "
            "Set the depths to choose from."
        )


def _check_values(dataset: "xr.Dataset", data: str) -> None:
    """Look at valid pixels only: finite everywhere, raw counts within the converter's scale."""
    valid = dataset["mask"].to_numpy().astype(bool) if "mask" in dataset else np.True_
    values = dataset[data].to_numpy()
    bad = ~np.isfinite(values) & valid
    if bad.any():
        raise ValueError(
            f"Expected finite {data}, got NaN or inf in {bad.sum()} of {values.size} samples. "
            "Mask those pixels."
        )
    if data == "correlation":
        _check_offset(values, dataset["psi"].to_numpy(), valid)
        if np.issubdtype(values.dtype, np.integer) or "raw_counts" in dataset:
            _check_counts(dataset.get("raw_counts", dataset["correlation"]).to_numpy(), valid)
        _check_saturation(dataset, values, valid)


def _check_counts(counts: NDArray, valid: NDArray | np.bool_) -> None:
    if (bad := (counts < 0) & valid).any():
        raise ValueError(
            f"Expected counts >= 0, got {bad.sum()} negative ones, the least {counts[bad].min()}. "
            "Check the sign of the read-out or mask those pixels."
        )


def _check_saturation(dataset: "xr.Dataset", values: NDArray, valid: NDArray | np.bool_) -> None:
    limit = dataset.attrs.get("saturation")
    counts = dataset["raw_counts"].to_numpy() if "raw_counts" in dataset else values
    if limit is not None and (bad := (counts >= float(limit)) & valid).any():
        raise ValueError(
            f"Expected counts below the saturation {limit}, got {bad.sum()} of {counts.size} at or "
            "above it. Lower gain or exposure, or mask those pixels."
        )


def _check_offset(correlation: NDArray, psi: NDArray, valid: NDArray | np.bool_) -> None:
    """Light is never negative: no pixel's mean over psi may lie below zero by more than noise.

    The noise is read off the data: what the fit of offset and first harmonic leaves over.
    Single noisy samples may well be negative (Eq. 8 adds Gaussian noise).
    """
    for images, steps in zip(correlation, psi, strict=True):
        if steps.size < 4:
            continue  # three steps are fitted exactly and tell nothing of the noise
        noise = residual_noise(images, steps) / np.sqrt(steps.size)
        mean = images.mean(axis=0)
        floor = -10 * noise - 1e-6 * np.abs(mean).max()
        if (bad := (mean < floor) & valid).any():
            raise ValueError(
                f"Expected counts >= 0 up to noise, got {bad.sum()} pixels whose mean over psi is "
                f"negative, the least {mean[bad].min():.4g}. Check the dark frame or mask them."
            )
