"""What a measurement tells, per pixel, in the form in which it adds up.

A pixel's phasor ``p_f = a_f exp(i phi_f)`` at frequency f carries noise s_f in each component.
Against a depth z its log-likelihood is ``Re(P_f exp(-i k_f z))`` up to a constant, where ``P_f =
a_f p_f / s_f^2`` and ``k_f = 4 pi f / c``; noise aside it reaches ``K_f = a_f^2 / s_f^2`` at the
true depth. Both sum over pixels and frequencies, so a surface is as likely as the sum over it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.baselines import phase_noise
from cmtof.constants import SPEED_OF_LIGHT
from cmtof.correlation import TAU
from cmtof.measurement import Measurement

CELL = 8
"""Side, px, of the cells in which surfaces grow."""

SMALLEST = 64
"""Side, px, up to which smaller images are padded with pixels that tell nothing."""

_SCALES = ((1.5, 1.0), (4.0, 0.15), (12.0, 0.0))
# Amplitudes are averaged over 1.5 px; where that leaves less than 1, over the dark pixels within
# 4 px, and below 0.15 within 12 px: a dark pixel's own amplitude is nothing but noise.

_SHARPEST = 3e-3
"""Least phase noise believed, rad; without noise the surfaces' own shape is what limits a fit."""

_FOCAL_LENGTH = 1.2
"""Assumed without a camera, in widths of the image."""


class Field(NamedTuple):
    """Weighted phasors on a grid of whole cells; padding and unknown pixels weigh nothing."""

    real: NDArray[np.float32]
    """Real part of P (2, H, W)."""
    imaginary: NDArray[np.float32]
    """Imaginary part of P (2, H, W)."""
    information: NDArray[np.float32]
    """K (2, H, W): one over the variance of each phase, 1 / rad^2."""
    wavenumber: NDArray[np.float64]
    """k of both frequencies (2,), rad / m."""
    turns: NDArray[np.float64]
    """Phase (2,), rad, that a step of one wrap of the lower frequency adds, in whole turns."""
    u: NDArray[np.float64]
    """Direction to the right of each column (W,): x / z of its ray."""
    v: NDArray[np.float64]
    """Direction down of each row (H,): y / z of its ray."""
    cosine: NDArray[np.float64]
    """Cosine between each ray and the optical axis (H, W)."""
    limits: tuple[float, float]
    """Depths to choose from, m."""

    @property
    def period(self) -> float:
        """Length of a wrap of the lower frequency, m."""
        return float(TAU / self.wavenumber[0])

    @property
    def multiple(self) -> int:
        """Multiple of the lower frequency that is nearest to the higher one."""
        return round(float(self.wavenumber[1] / self.wavenumber[0]))

    @property
    def excess(self) -> float:
        """Turns that a wrap of the lower frequency adds to the beat."""
        return float(self.wavenumber[1] / self.wavenumber[0]) - self.multiple

    def arrays(self) -> tuple[NDArray, ...]:
        """What the kernels take, in their order."""
        return self[:8]


def field_from_measurement(measurement: Measurement) -> Field:
    """Weigh both phasors of a measurement; masked pixels count, for they were measured as well."""
    phase, amplitude = measurement.phase[:2].astype(float), measurement.amplitude[:2].astype(float)
    spread = phase_noise(measurement)
    known = np.all(np.isfinite(phase) & np.isfinite(amplitude) & np.isfinite(spread), axis=0)
    ratio = np.where(known, 1 / np.maximum(np.where(known, spread, 1), _SHARPEST), 0)
    if "correlation" in measurement.dataset and measurement.dataset.sizes["step"] > 3:
        information = _information(ratio**2, known)
    else:  # phases alone do not say how noisy they are
        information = ratio**2
    # P = a p / s^2 with the smoothed a / s and this pixel's own p / s
    size = np.sqrt(information) * ratio
    turned = np.where(known, phase, 0)
    focal = _camera(measurement)
    shape = measurement.shape
    side = [max(-(-n // CELL) * CELL, SMALLEST) for n in shape]
    u = (np.arange(side[1]) + 0.5 - focal[2]) / focal[0]
    v = (np.arange(side[0]) + 0.5 - focal[3]) / focal[1]

    def padded(images: NDArray) -> NDArray[np.float32]:
        width = [(0, 0), (0, side[0] - shape[0]), (0, side[1] - shape[1])]
        return np.pad(images.astype(np.float32), width)

    wavenumber = 2 * TAU * measurement.frequencies[:2] / SPEED_OF_LIGHT
    return Field(
        padded(size * np.cos(turned)),
        padded(size * np.sin(turned)),
        padded(information),
        wavenumber,
        TAU * np.rint(wavenumber / wavenumber[0]),
        u,
        v,
        1 / np.sqrt(1 + u**2 + v[:, None] ** 2),
        measurement.range,
    )


def _camera(measurement: Measurement) -> NDArray[np.float64]:
    """[fx, fy, cx, cy], px; a common one where none is known."""
    if measurement.camera is not None:
        return np.asarray(measurement.camera, float)
    height, width = measurement.shape
    focal = _FOCAL_LENGTH * max(height, width)
    return np.array([focal, focal, width / 2, height / 2])


def _information(power: NDArray[np.floating], known: NDArray[np.bool_]) -> NDArray[np.float64]:
    """a^2 / s^2 (2, H, W) without the noise's share, from |p|^2 / s^2 (2, H, W).

    Both frequencies see the same surface: one image for both, times the share of each.
    """
    from scipy.ndimage import gaussian_filter

    share = np.array(
        [max(float(np.mean(p[known])) - 2, 1e-3) if known.any() else 1.0 for p in power]
    )
    share /= share.mean()
    excess = power.mean(axis=0) - 2  # each component's noise adds 1 to |p|^2 / s^2
    left, mean = known.copy(), np.zeros(known.shape)
    for width, least in _SCALES:
        weight = gaussian_filter(left.astype(float), width, mode="constant")
        total = gaussian_filter(np.where(left, excess, 0), width, mode="constant")
        found = np.maximum(total / np.maximum(weight, 1e-6), 1e-4)
        mean = np.where(left, found, mean)
        left &= found < least
    return share[:, None, None] * mean
