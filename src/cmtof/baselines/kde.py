"""Kernel density of depth hypotheses (Järemo Lawin, Forssén and Ovrén, ECCV 2016), for two tones.

Each pixel x has one hypothesis for each wrap in range. It is as good as its neighbours y have
good hypotheses at the same depth (their Eq. for the Kinect v2, three tones):

    D_i(x) = sum_y g(x - y) sum_j w_j(y) exp(-(d_i(x) - d_j(y))^2 / 2 h^2)

What was adapted to two frequencies a GHz apart:

- All N wraps in range are hypotheses. The original keeps the best two of 30; here they hold the
  truth in less than one pixel of twenty.
- ``w_j = exp(-J / 2 s^2) exp(-(sigma_1^2 + sigma_2^2) / 2 s_2^2)``. With two tones J has a single
  term, the misfit ``r_j = phi_2 - (f_2 / f_1)(phi_1 + 2 pi j)`` over its variance
  ``sigma_2^2 + (f_2 / f_1)^2 sigma_1^2`` of that pixel. The original's J is in units of one
  variance of three and has s^2 = 2; here J is in units of its own variance and s = 1, so that the
  first factor is the likelihood. The second is theirs, ``s_2^2 = 3``.
- The phase variances are ``(noise / amplitude)^2``, the noise from the residual of the fit, in
  place of their curve fitted to one sensor. No pixel is dropped for saturation or range.
- Depths d are in wraps of the lower frequency and come from its phase alone, which noise moves by
  0.02 wraps, far less than h. The answer fuses both phases by inverse variances.
- h is 0.25 wraps. Theirs, 0.32 m, is a quarter of their shortest wrap (1.25 m at 120 MHz).
- 11 x 11 px with sigma 2.5 px, not normalised, as theirs; beyond the border there is nothing.
- Nothing is rejected; the confidence is the winner's share of the density of all wraps. Theirs,
  the share of the weights under the winner's kernel, is the same where hypotheses coincide.
"""

import numpy as np
from numpy.typing import NDArray

from cmtof.baselines.crt import fused_depth
from cmtof.baselines.kde_kernels import Hypotheses, densest_wraps, direct_density
from cmtof.baselines.method import Estimate, wraps_in_range
from cmtof.baselines.noise import phase_noise
from cmtof.correlation import TAU, centred
from cmtof.kernels import nearest_wrap
from cmtof.measurement import Measurement

KERNEL, RADIUS = 0.25, 5
"""Kernel width h, wraps, and radius of the window, px, as published."""
TUNED_KERNEL, TUNED_RADIUS = 0.5, 40
"""The same, of the largest delta < 1 on validation rooms out of h = 0.25, 0.5, 1, 2 wraps and
r = 5, 11, 20, 40 px: delta < 1 / < 2 / < 3 / >= 10 of 17.4 / 40.4 / 54.8 / 14.1 % over eight views
of `released`, where (0.25, 5) scores 7.7 / 21.1 / 31.2 / 28.4, and 9.9 / 22.4 / 30.3 / 45.5 over
quarters of eight views of `full`, where that scores 3.5 / 10.3 / 16.7 / 58.4. Of `full` seven of
the sixteen were not run; h above 0.5 changes nothing there, and (0.5, 20) has the better
delta < 3, 32.9.
The largest radius won, so a larger one may do better."""
RELIABILITY = 3.0
"""s_2^2 of the weight by phase variance, rad^2, as published."""
_FINEST = 0.01
"""Least misfit, rad, that counts as one sigma: float32 phases err by 1e-5."""
ROWS = 256


def kde(
    measurement: Measurement, *, kernel: float = KERNEL, radius: int = RADIUS, rows: int = ROWS
) -> Estimate:
    """Choose for each pixel the wrap whose depth is the densest among its neighbours'.

    Parameters
    ----------
    measurement : Measurement
        At two frequencies.
    kernel : float
        Width h of the kernel along depth, wraps of the lower frequency, 0.01 or more.
    radius : int
        Radius of the Gaussian window, px; its sigma is half of it; 0 leaves every pixel alone.
    rows : int
        Height of the strips that are in memory at once; it changes no result.

    Raises
    ------
    ValueError
        If an option is out of its bounds.
    """
    if not (0.01 <= kernel < np.inf and radius >= 0 and rows >= 1):
        raise ValueError(
            f"Expected a kernel of 0.01 wraps or more, a radius of 0 px or more and rows of 1 or "
            f"more, got {kernel:g}, {radius} and {rows}. Try {KERNEL}, {RADIUS} and {ROWS}."
        )
    phase, noise = _phases(measurement)
    hypotheses = hypotheses_of(measurement, phase, noise)
    found = densest_wraps(hypotheses, kernel=kernel, radius=radius, rows=rows)
    return _estimate(measurement, phase, *found)


def kde_by_double_loop(
    measurement: Measurement, *, kernel: float = KERNEL, radius: int = RADIUS
) -> Estimate:
    """Answer as `kde` does by the sum as it is written: to test and to time `kde` against."""
    phase, noise = _phases(measurement)
    hypotheses = hypotheses_of(measurement, phase, noise)
    density = direct_density(hypotheses, kernel=kernel, radius=radius)
    found = density.argmax(axis=2), density.max(axis=2), density.sum(axis=2)
    return _estimate(measurement, phase, *found)


def tuned(
    measurement: Measurement,
    *,
    kernel: float = TUNED_KERNEL,
    radius: int = TUNED_RADIUS,
    rows: int = ROWS,
) -> Estimate:
    """Call `kde` with the kernel and the window that did best on validation rooms."""
    return kde(measurement, kernel=kernel, radius=radius, rows=rows)


def hypotheses_of(
    measurement: Measurement, phase: NDArray[np.floating], noise: NDArray[np.floating]
) -> Hypotheses:
    """Misfit and weight of every wrap in range, from phases and their noise (2, H, W), rad."""
    low, high = measurement.frequencies[:2]
    ratio = high / low
    first, last = wraps_in_range(measurement)
    misfit = (phase[1] - ratio * phase[0]) / TAU - ratio * first
    # a quarter of the step from wrap to wrap: noise-free data must not drive all weights to zero
    step = TAU * abs(ratio - round(ratio))
    least = min(step / 4, _FINEST) if step > 1e-9 else _FINEST
    spread = np.maximum(np.hypot(noise[1], ratio * noise[0]), least)
    reliability = np.exp(-np.sum(noise**2, axis=0) / (2 * RELIABILITY))
    fields = (
        phase[0] / TAU,
        misfit - np.rint(misfit),
        TAU**2 / (2 * spread**2),
        reliability,
        np.mod(ratio * np.arange(last - first + 1), 1),
    )
    return Hypotheses(*(field.astype(np.float32) for field in fields))


def _phases(measurement: Measurement) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Phases (2, H, W), rad, zero where unknown, and their noise."""
    phase = measurement.phase[:2].astype(float)
    phase = np.where(np.isfinite(phase).all(axis=0), phase, 0)
    return phase, phase_noise(measurement)


def _estimate(
    measurement: Measurement,
    phase: NDArray[np.floating],
    label: NDArray[np.integer],
    best: NDArray[np.floating],
    total: NDArray[np.floating],
) -> Estimate:
    """Depth of the densest wrap; where no neighbour has a say, of the least misfit."""
    low, high = measurement.frequencies[:2]
    first, last = wraps_in_range(measurement)
    alone, _ = nearest_wrap(phase[0], phase[1], ratio=high / low, first=first, last=last)
    dense = best > np.finfo(np.float32).tiny * 1e6
    wraps = np.where(dense, label + first, alone)
    share = best / np.where(dense, total, 1)
    confidence = np.where(dense, np.minimum(share, 1), 1 / (last - first + 1))
    residual = centred(phase[1] - high / low * (phase[0] + TAU * wraps))
    return Estimate(fused_depth(measurement, wraps, residual), confidence)
