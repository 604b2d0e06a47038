"""The weighted phasors of a measurement, in the form in which likelihoods add up.

A pixel's phasor ``p = a exp(i phi)`` has noise s in each component. Against a depth z its
log-likelihood is ``Re(P exp(-i k z))`` up to a constant, with ``P = a p / s^2`` and ``k = 4 pi f /
c``; at the true depth it is ``K = a^2 / s^2`` on average. S and E are their sums over pixels and
frequencies: a surface is as likely as the sum over it.
"""

from typing import NamedTuple

import numpy as np
from scipy.ndimage import uniform_filter

from cmtof.compiled import njit
from cmtof.constants import SPEED_OF_LIGHT
from cmtof.correlation import TAU
from cmtof.estimate import hidden_noise, seen_noise
from cmtof.measurement import Measurement
from cmtof.types import Array, Complex, Flags, Numbers, Pair

CELL = 8  # side, px, of the cells in which surfaces grow
ENOUGH = 60.0  # information from which on what moves both phases alike is known
_SMALLEST = 64  # side, px, up to which smaller images are padded with pixels without information
_SHARPEST = 3e-3  # least phase noise assumed, rad: without noise the shapes limit a fit
_FOCAL_LENGTH = 1.2  # assumed without a camera, in widths of the image
# Sides, px, of squares over which signals are averaged, and how many deviations of noise a mean has
# to stand out; where it does not, the next square counts.
_SQUARES = (5, 15, 45, 135)
_CLEARLY = 4.0


class Field(NamedTuple):
    """Weighted phasors, padded to whole cells of 8 px; padding and unknown pixels weigh nothing."""

    phasor: Complex  # P at both frequencies (2, H, W)
    information: Array  # K (2, H, W): one over the variance of each phase, 1 / rad^2
    wavenumber: Array  # k (2,), rad / m
    turns: Array  # that one wrap of the lower frequency adds, in whole turns, rad
    u: Array  # directions x / z to the right of each column (W,)
    v: Array  # and y / z down of each row (H,)
    cosine: Array  # between each ray and the optical axis (H, W)
    limits: Pair  # depths to choose from, m
    period: float  # length of a wrap of the lower frequency, m

    @property
    def side(self) -> int:
        """Side, px, of squares to sum over: 1 if most pixels have clear phases, else `CELL`."""
        information = self.information.sum(axis=0)
        clear = information > ENOUGH
        return 1 if clear.sum() > (information > 0).sum() / 2 else CELL

    @property
    def ratio(self) -> float:
        """Higher frequency in units of the lower one."""
        return float(self.wavenumber[1] / self.wavenumber[0])

    @property
    def multiple(self) -> int:
        """Multiple of the lower frequency that is nearest to the higher one."""
        return round(self.ratio)

    @property
    def excess(self) -> float:
        """Turns that a wrap of the lower frequency adds to the beat."""
        return self.ratio - self.multiple


def field_from_measurement(measurement: Measurement) -> Field:
    """Weighted phasors of a measurement; masked pixels count where they keep their samples.

    A camera's skew is left out: one of 3 % of the focal length costs 0.3 % of the wraps.
    """
    height, width = measurement.shape
    rows, columns = (
        max(-(-size // CELL) * CELL, _SMALLEST) for size in measurement.shape
    )
    padding = ((0, 0), (0, rows - height), (0, columns - width))
    focal = _FOCAL_LENGTH * max(height, width)
    lens = measurement.camera
    if lens is None:
        lens = (focal, focal, width / 2, height / 2)
    u = (np.arange(columns) + 0.5 - lens[2]) / lens[0]
    v = (np.arange(rows) + 0.5 - lens[3]) / lens[1]
    wavenumber = 2 * TAU * measurement.frequencies / SPEED_OF_LIGHT
    phasor, information = _weighted_phasors(measurement)
    return Field(
        np.pad(phasor, padding),
        np.pad(information, padding),
        wavenumber,
        turns=TAU * np.rint(wavenumber / wavenumber[0]),
        u=u,
        v=v,
        cosine=1 / np.sqrt(1 + u**2 + v[:, None] ** 2),
        limits=measurement.range,
        period=float(TAU / wavenumber[0]),
    )


def _weighted_phasors(measurement: Measurement) -> tuple[Complex, Array]:
    """Weighted phasors P and information K, 1 / rad^2, of a measurement, (2, H, W) each."""
    spread = seen_noise(measurement)
    known = np.isfinite(spread).all(axis=0)
    ratio = np.where(known, 1 / np.maximum(spread, _SHARPEST), 0)
    information = ratio**2  # phases alone do not say how noisy they are
    if "correlation" in measurement.dataset and measurement.dataset.sizes["step"] > 3:
        information = _smooth_power(information, known)  # pyright: ignore[reportArgumentType]
    # P = a p / s^2 with the smoothed a / s and this pixel's own p / s
    left = 1 / (1 + information * hidden_noise(measurement, spread) ** 2)
    size = np.sqrt(information) * ratio * left
    phasor = size * np.exp(1j * measurement.phase)
    return phasor.astype(np.complex64), (information * left).astype(np.float32)


def _smooth_power(power: Array, known: Flags) -> Array:
    """Signal over noise a^2 / s^2 (2, H, W), by pixels' |p|^2 / s^2: one image, scaled by tone.

    The mean over the smallest square that shows a signal: |p|^2 / s^2 without one is chi-squared
    with two degrees of freedom, so that the mean of both tones over N pixels has the deviation
    ``sqrt(2 / N)``. In the dark a smaller square would take noise for signal.
    """
    share = np.array(
        [max(p[known].mean() - 2, 1e-3) if known.any() else 1.0 for p in power]
    )
    share /= share.mean()
    excess = power.mean(axis=0) - 2  # each component's noise adds 1 to |p|^2 / s^2
    left = known.copy()
    mean = np.zeros_like(excess)
    for side in _SQUARES:
        images = left.astype(float), np.where(left, excess, 0)
        weight, total = (uniform_filter(i, side, mode="constant") for i in images)
        weight = np.maximum(weight, 1e-6)
        found = np.maximum(total / weight, 1e-4)
        mean = np.where(left, found, mean)
        left &= found < _CLEARLY * np.sqrt(2 / weight) / side
    return share[:, None, None] * mean


def pixels_of_cells(cells: Numbers, side: int = CELL) -> Numbers:
    """Image (H, W) that shows the value of its cell (h, w) in each pixel."""
    return cells.repeat(side, 0).repeat(side, 1)


def sum_nearby(images: Array, main: Numbers, radius: int) -> Array:
    """Sum of images (..., h, w) over the cells of the same surface within a radius."""
    flat = images.reshape(-1, *main.shape)
    return sums_near(np.arange(main.size), flat, main, radius).reshape(images.shape)


@njit()
def sums_near(places, images, main, radius):  # pragma: no cover - compiled
    """Sums (n, P) of images (n, h, w) as `sum_nearby` has them, at cells by their numbers (P,)."""
    out = np.zeros((len(images), places.size), images.dtype)
    for i, place in enumerate(places):
        y, x = divmod(place, main.shape[1])
        top = max(0, y - radius)
        left = max(0, x - radius)
        near = main[top : y + radius + 1, left : x + radius + 1]
        for v, u in np.ndindex(near.shape):
            if near[v, u] == main[y, x]:
                for n in range(len(images)):
                    out[n, i] += images[n, top + v, left + u]
    return out
