"""Finding a laser spot in an image to a hundredth of a pixel, or saying that none can be found.

The spot is fitted by maximum likelihood with a pixel-integrated Gaussian, its brightness, width and
a residual ground; with the read noise taken as so many more photons (Huang et al. 2013, "Video-rate
nanoscopy using sCMOS camera-specific single-molecule localization algorithms") the likelihood is
Poisson's, and Fisher's information, of which the steps of the fit are made, gives the bound.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.stereo.sensor import OFFSET, Sensor, gaussian_spot

Array = NDArray[np.floating]

WINDOW = 15
"""Side of the window that is fitted, px."""

SIGNIFICANCE = 6.0
"""Standard deviations of its own brightness that a spot must reach."""

RIVAL = 0.25
"""Share of the spot's peak at which a second peak makes it a double."""

WIDTHS = (0.4, 3.0)
"""Standard deviations of a plausible spot, px."""


class Status(IntEnum):
    """What came of looking for a spot."""

    FOUND = 0
    ABSENT = 1
    SATURATED = 2
    DOUBLE = 3
    OUTSIDE = 4


class Spots(NamedTuple):
    """Spots as they were found."""

    pixels: Array
    """(..., 2), px; NaN where none was found."""
    covariance: Array
    """(..., 2, 2), px^2: the bound at what was found, and speckle; NaN where none was."""
    brightness: Array
    """(...), electrons, as green pixels would have them."""
    width: Array
    """Standard deviation (...), px."""
    status: NDArray[np.int8]
    """(...), out of `Status`."""


def spot_bound(
    sensor: Sensor,
    *,
    centre: ArrayLike,
    brightness: ArrayLike,
    width: ArrayLike,
    ground: float = 0.0,
    corners: ArrayLike = (0, 0),
    side: int = WINDOW,
) -> Array:
    r"""Cramér–Rao bound (..., 2, 2) of a spot's place, px^2, brightness, width, ground unknown.

    .. math:: I_{ab} = \sum_i \frac{1}{v_i} \frac{\partial\mu_i}{\partial a}
              \frac{\partial\mu_i}{\partial b}, \quad v_i = \mu_i + g + r^2

    Parameters
    ----------
    sensor : Sensor
    centre : array_like, shape (..., 2)
        In the window, px.
    brightness, width : array_like, shape (...)
        Electrons and px.
    ground : float
        Ambient light, electrons a pixel: known in the mean, but its photons are noise.
    corners : array_like, shape (..., 2)
        Column and row of the window, which say what colour its pixels have.
    side : int
        Of the window, px.
    """
    centre = np.asarray(centre, float)
    brightness, width = (
        np.broadcast_to(np.asarray(a, float), centre.shape[:-1]) for a in (brightness, width)
    )
    response = np.broadcast_to(sensor.response(corners, side), (*centre.shape[:-1], side, side))
    mean, slopes = _model(centre, brightness, width, np.zeros(width.shape), response)
    return np.linalg.inv(_information(slopes, mean + ground + sensor.variance))[..., :2, :2]


def fit_spots(
    windows: ArrayLike,
    sensor: Sensor,
    *,
    corners: ArrayLike = (0, 0),
    background: ArrayLike = float(OFFSET),
    ground: float = 0.0,
    speckle: float = 0.0,
) -> Spots:
    """Place of the one spot in each window.

    Parameters
    ----------
    windows : array_like, shape (..., S, S)
        Counts.
    sensor : Sensor
    corners : array_like, shape (..., 2)
        Column and row of each window in the image.
    background : array_like
        Counts with the laser off, broadcast against `windows`.
    ground : float
        Electrons of ambient light a pixel in that background.
    speckle : float
        Standard deviation that speckle adds, px (`Sensor.speckle`).

    Raises
    ------
    ValueError
        If windows are not square, or smaller than 7 px.
    """
    windows = np.asarray(windows, float)
    side = windows.shape[-1]
    if windows.ndim < 2 or windows.shape[-2] != side or side < 7:
        raise ValueError(
            f"Expected square windows of at least 7 px, got {windows.shape}. Cut larger ones."
        )
    shape = windows.shape[:-2]
    dark = np.asarray(background, float)
    light = ((windows - dark) * sensor.gain).reshape(-1, side, side)
    response = np.broadcast_to(sensor.response(corners, side), (*shape, side, side))
    response = response.reshape(-1, side, side)
    full = (windows >= sensor.top).any(axis=(-2, -1)).reshape(-1)
    noise = ground + sensor.variance
    parts = [_fit(light[i : i + CHUNK], response[i : i + CHUNK], noise, full[i : i + CHUNK])
             for i in range(0, len(light), CHUNK)]  # fmt: skip
    found = [np.concatenate(column) for column in zip(*parts, strict=True)] if parts else _none()
    place, covariance, brightness, width, status = found
    covariance = covariance + speckle**2 * np.eye(2)
    lost = status != Status.FOUND
    place, covariance = place.copy(), covariance.copy()
    place[lost], covariance[lost] = np.nan, np.nan
    return Spots(
        place.reshape(*shape, 2) + np.asarray(corners),
        covariance.reshape(*shape, 2, 2),
        brightness.reshape(shape),
        width.reshape(shape),
        status.reshape(shape),
    )


CHUNK = 2048
"""Windows fitted at a time."""


def _none() -> list[NDArray]:
    return [np.empty((0, 2)), np.empty((0, 2, 2)), np.empty(0), np.empty(0), np.empty(0, np.int8)]


def find_spot(
    image: ArrayLike,
    sensor: Sensor,
    *,
    background: ArrayLike = float(OFFSET),
    ground: float = 0.0,
    speckle: float = 0.0,
) -> Spots:
    """The laser spot in a whole image, with the laser off subtracted.

    Parameters
    ----------
    image : array_like, shape (H, W)
        Counts.
    sensor : Sensor
    background : array_like
        Counts with the laser off: a number or an image.
    ground, speckle : float
        As in `fit_spots`.

    Returns
    -------
    Spots
        Of no dimension. More than one significant peak of comparable height is `Status.DOUBLE`.

    Raises
    ------
    ValueError
        If the image is smaller than a window.
    """
    from scipy.ndimage import gaussian_filter
    from skimage.feature import peak_local_max

    image = np.asarray(image, float)
    if image.ndim != 2 or min(image.shape) < WINDOW:
        raise ValueError(
            f"Expected an image of at least {WINDOW} x {WINDOW} px, got {image.shape}. Use more of "
            "the sensor."
        )
    light = (image - np.asarray(background, float)) * sensor.gain
    # smoothed alike, the mosaic's pattern falls out of the ratio
    seen = gaussian_filter(light, 1.5)
    weight = gaussian_filter(sensor.response((0, 0), max(image.shape)), 1.5)
    seen = seen / weight[: image.shape[0], : image.shape[1]]
    scatter = 1.4826 * np.median(np.abs(seen - np.median(seen)))
    least = max(SIGNIFICANCE * scatter, RIVAL * seen.max())
    peaks = peak_local_max(seen, min_distance=4, threshold_abs=least, exclude_border=False)
    if len(peaks) == 0:
        return _absent()
    corner = np.clip(peaks[0] - WINDOW // 2, 0, np.array(image.shape) - WINDOW)
    inside = (slice(corner[0], corner[0] + WINDOW), slice(corner[1], corner[1] + WINDOW))
    dark = np.broadcast_to(np.asarray(background, float), image.shape)[inside]
    found = fit_spots(
        image[inside], sensor, corners=corner[::-1], background=dark, ground=ground, speckle=speckle
    )
    away = np.linalg.norm(peaks - peaks[0], axis=1) > 2 * WIDTHS[1]
    if found.status == Status.FOUND and away.any():
        return _absent(Status.DOUBLE)
    return found


def _absent(status: Status = Status.ABSENT) -> Spots:
    lost = np.array(np.nan)
    return Spots(np.full(2, np.nan), np.full((2, 2), np.nan), lost, lost, np.array(status, np.int8))


# --- the fit -------------------------------------------------------------------------------------


def _model(
    centre: Array, brightness: Array, width: Array, ground: Array, response: Array
) -> tuple[Array, Array]:
    """Mean (..., S, S), electrons, and slopes by x, y, brightness, width, ground."""
    share, by_x, by_y, by_width = gaussian_spot(response.shape[-1], centre, width)
    scale = brightness[..., None, None]
    slopes = np.stack(
        [scale * by_x, scale * by_y, share, scale * by_width, np.ones_like(share)], -3
    )
    slopes *= response[..., None, :, :]
    return scale * share * response + ground[..., None, None] * response, slopes


def _information(slopes: Array, variance: Array) -> Array:
    flat = slopes.reshape(*slopes.shape[:-2], -1)
    return (flat / variance.reshape(*variance.shape[:-2], 1, -1)) @ np.swapaxes(flat, -1, -2)


def _fit(
    light: Array, response: Array, noise: float, full: NDArray[np.bool_], steps: int = 15
) -> tuple[Array, Array, Array, Array, NDArray[np.int8]]:
    """Fit of windows (N, S, S), electrons: place, covariance, brightness, width, status."""
    side = light.shape[-1]
    p = _first_guess(light, response)
    low = np.array([0, 0, 0, WIDTHS[0] / 2, -np.inf])
    high = np.array([side, side, np.inf, 1.5 * WIDTHS[1], np.inf])
    information = np.empty((len(light), 5, 5))
    moving = np.arange(len(light))
    for _ in range(steps):
        now = p[moving]
        mean, slopes = _model(now[:, :2], now[:, 2], now[:, 3], now[:, 4], response[moving])
        variance = np.maximum(mean, 0) + noise
        information[moving] = _information(slopes, variance)
        pull = np.einsum("nkij,nij->nk", slopes, (light[moving] - mean) / variance)
        # a little damping keeps the step finite where there is no spot at all
        damped = information[moving] * (1 + 1e-9 * np.eye(5)) + 1e-12 * np.eye(5)
        step = np.linalg.solve(damped, pull[..., None])[..., 0]
        one = np.ones(len(now))
        largest = np.stack([one, one, now[:, 2] + 50, 0.3 * now[:, 3], 1e3 * one], 1)
        step = np.clip(step, -largest, largest)
        p[moving] = np.clip(now + step, low, high)
        moving = moving[(np.abs(step[:, :2]) > 1e-4).any(axis=1)]
        if moving.size == 0:
            break
    covariance = np.linalg.pinv(information, hermitian=True)
    status = _status(light, response, p, covariance, full, noise)
    return p[:, :2], covariance[:, :2, :2], p[:, 2], p[:, 3], status


def _first_guess(light: Array, response: Array) -> Array:
    """Place, brightness, width and ground to start from: the peak of the smoothed window."""
    from scipy.ndimage import gaussian_filter

    count, side, _ = light.shape
    near = (0, 1.5, 1.5)
    smooth = gaussian_filter(light * response, near) / gaussian_filter(response**2, near)
    row, column = np.divmod(smooth.reshape(count, -1).argmax(axis=1), side)
    peak = np.maximum(smooth[np.arange(count), row, column], 1.0)
    # smoothing of 1.5 px has widened a spot of 1.2 px to about 1.9
    brightness = 2 * np.pi * 1.9**2 * peak
    start = [column + 0.5, row + 0.5, brightness, np.full(count, 1.2), np.zeros(count)]
    return np.stack(start, 1).astype(float)


def _status(
    light: Array,
    response: Array,
    p: Array,
    covariance: Array,
    full: NDArray[np.bool_],
    noise: float,
) -> NDArray[np.int8]:
    """Which fits are spots: significant, of plausible width, alone, and off the window's border."""
    side = light.shape[-1]
    status = np.full(len(p), Status.FOUND, np.int8)
    status[_rivalled(light, response, p, noise)] = Status.DOUBLE
    status[p[:, 3] > WIDTHS[1]] = Status.DOUBLE
    weak = p[:, 2] < SIGNIFICANCE * np.sqrt(np.maximum(covariance[:, 2, 2], 0))
    cut = ((p[:, :2] < 1.5) | (p[:, :2] > side - 1.5)).any(axis=1)
    unsure = ~(np.trace(covariance[:, :2, :2], axis1=1, axis2=2) < 2.0)
    status[weak | cut | unsure | (p[:, 3] < WIDTHS[0])] = Status.ABSENT
    status[full] = Status.SATURATED
    return status


def _rivalled(light: Array, response: Array, p: Array, noise: float) -> NDArray[np.bool_]:
    """Whether something else in the window is bright: what the fit leaves, 3 widths away."""
    from scipy.ndimage import gaussian_filter

    side = light.shape[-1]
    mean, _ = _model(p[:, :2], p[:, 2], p[:, 3], p[:, 4], response)
    near = (0, 1.2, 1.2)
    weight = gaussian_filter(response**2, near)
    left = gaussian_filter((light - mean) * response, near) / weight
    y, x = np.indices((side, side)) + 0.5
    away = np.hypot(x - p[:, :1, None], y - p[:, 1:2, None]) > 3 * p[:, 3, None, None]
    rival = np.where(away, left, 0).reshape(len(p), -1).max(axis=1)
    peak = p[:, 2] / (2 * np.pi * (p[:, 3] ** 2 + 1.2**2))
    # smoothing over 1.2 px averages 4 pi 1.2^2 pixels
    scatter = np.sqrt(noise / (4 * np.pi * 1.2**2 * 0.4))
    return rival > np.maximum(RIVAL * peak, SIGNIFICANCE * scatter)
