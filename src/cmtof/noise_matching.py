"""From the noise of a measured phase to the simulator's, so that both look alike (Fig. 11).

A phase map that comes without amplitudes tells its phase noise, not the counts behind it: one
relation ties the Gaussian noise sigma to the brightness I of the surface, and either may be
assumed.
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import optimize, stats

from cmtof.bounds import linear_phase_noise, phase_spread
from cmtof.constants import FREQUENCY_SINGLE, GAIN, INTEGRATION_TIME
from cmtof.correlation import consistent_wrap_count, depth_from_wraps
from cmtof.denoising import local_phase_noise
from cmtof.scenes.rgbd import Frame, load_frame

Array = NDArray[np.float64]

_LARGEST_LINEAR_NOISE = 50.0
"""Linear phase noise, rad, beyond which the phase tells nothing: it is uniform over the circle."""


def phase_noise_from_sigma(
    sigma: float,
    *,
    intensity: float = 1.0,
    gain: float = GAIN,
    integration_time: float = INTEGRATION_TIME,
    steps: int = 4,
) -> float:
    r"""Spread of the simulator's phase by its exact law, rad (Eq. 8 and 9).

    .. math:: \sigma_\varphi \approx \sqrt{\tfrac{2}{K}\left(\tfrac{GTI}{2}+\sigma^2\right)}
              \Big/ \tfrac{GTI}{\pi}

    with `cmtof.bounds.phase_spread` for what noise beyond the small adds.

    Parameters
    ----------
    sigma : float
        Gaussian noise, counts; photon noise comes with it.
    intensity : float
        Brightness I of the surface, above 0.
    gain, integration_time : float
        G and T of Eq. 8.
    steps : int
        Number K of uniform reference phases.

    Examples
    --------
    >>> round(phase_noise_from_sigma(1200.0), 3)
    0.135
    """
    signal = gain * integration_time * intensity
    if not (signal > 0 and sigma >= 0):
        raise ValueError(
            f"Expected a signal above 0 and sigma >= 0 counts, got {signal:g} and {sigma:g}. "
            "Check brightness and noise."
        )
    return phase_spread(float(linear_phase_noise(signal / np.pi, signal / 2 + sigma**2, steps)))


def sigma_from_phase_noise(
    phase_noise: float,
    *,
    intensity: ArrayLike = 1.0,
    gain: float = GAIN,
    integration_time: float = INTEGRATION_TIME,
    steps: int = 4,
) -> Array:
    """Gaussian noise of the simulator that gives a phase noise, counts.

    The inverse of `phase_noise_from_sigma`.

    Parameters
    ----------
    phase_noise : float
        rad.
    intensity : array_like
        Brightness I of the surface.
    gain, integration_time, steps
        As in `phase_noise_from_sigma`.

    Raises
    ------
    ValueError
        If no noise spreads a phase so far, or photon noise alone spreads it further.

    Examples
    --------
    >>> round(float(sigma_from_phase_noise(phase_noise_from_sigma(1200.0))), 6)
    1200.0
    """
    signal = gain * integration_time * np.asarray(intensity, float)
    variance = steps / 2 * (linear_from_spread(phase_noise) * signal / np.pi) ** 2
    rest = variance - signal / 2
    if not np.all(rest >= -1e-9 * variance):  # false for NaN as well
        least = intensity_from_phase_noise(
            phase_noise, 0.0, gain=gain, integration_time=integration_time, steps=steps
        )
        raise ValueError(
            f"Expected a brightness of {least:.4g} or more, got {np.min(intensity):.4g}: photon "
            f"noise alone is beyond {phase_noise:.4g} rad there. Assume a brighter surface."
        )
    return np.sqrt(np.maximum(rest, 0))


def intensity_from_phase_noise(
    phase_noise: float,
    sigma: ArrayLike,
    *,
    gain: float = GAIN,
    integration_time: float = INTEGRATION_TIME,
    steps: int = 4,
) -> Array:
    """Brightness at which the simulator's Gaussian noise gives a phase noise.

    The positive root of ``K/2 (l G T I / pi)^2 - G T I / 2 - sigma^2 = 0``, l the linear phase
    noise. It may exceed 1: then the surface measured is less noisy than white paper simulated.

    Parameters
    ----------
    phase_noise : float
        rad.
    sigma : array_like
        Gaussian noise, counts.
    gain, integration_time, steps
        As in `phase_noise_from_sigma`.

    Examples
    --------
    >>> noise = phase_noise_from_sigma(900.0, intensity=0.7)
    >>> round(float(intensity_from_phase_noise(noise, 900.0)), 9)
    0.7
    """
    square = steps / 2 * (linear_from_spread(phase_noise) / np.pi) ** 2
    sigma = np.asarray(sigma, float)
    signal = (0.5 + np.sqrt(0.25 + 4 * square * sigma**2)) / (2 * square)
    return signal / (gain * integration_time)


def linear_from_spread(spread: float) -> float:
    """Linear phase noise whose exact law spreads this far: inverse of `bounds.phase_spread`, rad.

    Raises
    ------
    ValueError
        If the spread is not between 0 and that of a uniform phase, pi/sqrt(3).

    Examples
    --------
    >>> round(linear_from_spread(phase_spread(0.445)), 9)
    0.445
    """
    if not 1e-6 < spread < phase_spread(_LARGEST_LINEAR_NOISE):
        raise ValueError(
            f"Expected a phase noise between 0 and {np.pi / np.sqrt(3):.2f} rad, got {spread:.4g}. "
            "A phase that spreads further is no more than a guess."
        )
    # the law spreads up to a third further than the linear noise, then ever less far
    low, high = 0.6 * spread, _LARGEST_LINEAR_NOISE
    root: Any = optimize.brentq(lambda linear: phase_spread(linear) - spread, low, high, xtol=1e-13)
    return float(root)


def typical_phase_noise(phase: ArrayLike, where: ArrayLike, *, window: int = 5) -> float:
    """Phase noise of a typical window of a phase map, rad.

    The median of `cmtof.denoising.local_phase_noise`, over the median that white noise of one
    radian would have there: edges and outliers do not count.

    Parameters
    ----------
    phase : array_like, shape (H, W)
        Wrapped phase, rad.
    where : array_like of bool, shape (H, W)
        Windows to count, by their centres.
    window : int
        Side of the fits, px.

    Raises
    ------
    ValueError
        If no window lies whole within the map there, or the shapes differ.
    """
    noise, where = local_phase_noise(phase, window=window), np.asarray(where, bool)
    _check_same(noise, where, "a region")
    held = noise[where & np.isfinite(noise)]
    if held.size == 0:
        raise ValueError(
            f"Expected whole windows of {window} px to fit, got none. Widen the region."
        )
    freedom = window**2 - 6
    return float(np.median(held) / np.sqrt(stats.chi2.median(freedom) / freedom))


def frame_from_phase(
    phase: ArrayLike,
    reference: ArrayLike,
    *,
    frequency: float = FREQUENCY_SINGLE,
    intensity: float = 1.0,
) -> Frame:
    """Scene whose true phase is a given (denoised) one, each pixel in the wrap nearest a reference.

    At this frequency the wraps do not show, so the reference may err by whole ones.

    Parameters
    ----------
    phase : array_like, shape (H, W)
        Wrapped phase, rad.
    reference : array_like, shape (H, W)
        Coarse depth, m.
    frequency : float
        Hz.
    intensity : float
        Brightness assumed everywhere.

    Raises
    ------
    ValueError
        If the shapes differ.
    """
    phase, reference = np.asarray(phase, float), np.asarray(reference, float)
    _check_same(phase, reference, "a reference")
    wraps = consistent_wrap_count(reference, phase, frequency)
    depth = depth_from_wraps(phase, wraps, frequency)
    return Frame(depth, np.full(depth.shape, intensity), name="measured surface")


def _check_same(phase: NDArray, other: NDArray, what: str) -> None:
    if phase.shape != other.shape:
        raise ValueError(
            f"Expected {what} of the phase's shape {phase.shape}, got {other.shape}. Crop one."
        )


def rehearsal_capture(folder: Path, *, seed: int = 0) -> Path:
    """Write a simulated scan in the layout of the published captures; return its phase file.

    A piece of an embedded frame, shrunk to the captures' distances, with photon and electronic
    noise. Its «reference» is the true range blurred and tilted by millimetres, as a coarse stereo
    pair would see it.

    Parameters
    ----------
    folder : Path
        Where ``phase/`` and ``depth/`` are made.
    seed : int
        Of the noise.
    """
    from scipy import ndimage

    from cmtof.scenes.captures import write_capture
    from cmtof.simulation import simulate

    frame = load_frame("still_life")
    view = slice(5, 105), slice(85, 185)
    piece = Frame(frame.depth[view] / 2, frame.intensity[view], name="rehearsal")
    scan = simulate(piece, protocol="full", noise=600.0, seed=seed)
    filled = np.where(np.isfinite(piece.depth), piece.depth, np.nanmax(piece.depth))
    tilt = 0.004 * np.linspace(-1, 1, 100)[:, None]
    return write_capture(scan.phase[0], ndimage.gaussian_filter(filled, 2) + tilt, folder)
