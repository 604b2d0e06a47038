"""True surfaces with an unknown offset and an unknown tilt each.

`cmtof.baselines.oracle_offset` knows the shape of a surface; who fits planes has to find their
slopes as well. Each true shape is tilted by an unknown plane, which is found as the joint peak of
both frequencies' spectra: a tilt of nu at the lower one is a tilt of (f_2 / f_1) nu at the other.
"""

import numpy as np
from numpy.typing import NDArray

from cmtof.baselines import Estimate
from cmtof.baselines.oracle_field import pieces
from cmtof.baselines.oracle_offset import STEP, demodulated, placed, surfaces
from cmtof.correlation import TAU, depth_from_phase
from cmtof.measurement import Measurement

_STEPS = 10
"""Of the refinement: each is a Gauss-Newton step from a bin of the spectrum."""


def oracle_plane(measurement: Measurement, *, step: float = STEP) -> Estimate:
    """Place every true surface, tilted by an unknown plane, by its phasors alone.

    Tilts are told up to a turn a pixel. The answer has the true shape with the tilt that was found
    wrongly, if it was.

    Parameters
    ----------
    measurement : Measurement
        With its true depth.
    step : float
        Second difference of depth that ends a surface, m.

    Raises
    ------
    ValueError
        If the step is not positive.
    """
    assert measurement.depth is not None  # `Method` has made sure
    truth = measurement.depth.astype(float)
    surface, _ = surfaces(truth, step)
    shape = np.where(np.isfinite(truth), truth, 0)
    phasors = demodulated(measurement, shape)
    low, high = (float(f) for f in measurement.frequencies[:2])
    tilt = np.zeros(shape.shape)
    for place, inside in pieces(surface):
        ours = [np.where(inside, phasor[place], 0) for phasor in phasors]
        tilt[place][inside] = tilt_of(ours, high / low)[inside]
    return placed(measurement, shape + depth_from_phase(tilt, low), surface)


def tilt_of(phasors: list[NDArray[np.complexfloating]], ratio: float) -> NDArray[np.floating]:
    """Plane (H, W), rad at the lower frequency, zero at the centroid, that two phasors lie on.

    Found is the peak over slopes nu of ``sum_i |sum_x p_i(x) exp(-i r_i nu x)|^2 / sum_x |p_i|^2``
    with r_i = 1 and ``ratio``, the likelihood where noise prevails.

    Parameters
    ----------
    phasors : two ndarrays, shape (H, W)
        Zero outside of the surface.
    ratio : float
        Higher frequency over the lower one.
    """
    power = [np.sum(np.abs(p) ** 2) or 1.0 for p in phasors]
    scaled = [p / np.sqrt(total) for p, total in zip(phasors, power, strict=True)]
    weight = np.sum(np.abs(scaled), axis=0)
    y, x = np.indices(weight.shape, dtype=float)
    mass = weight.sum() or 1.0
    y, x = y - (weight * y).sum() / mass, x - (weight * x).sum() / mass
    down, across = _peak(scaled, ratio)
    for _ in range(_STEPS):
        down, across = _refined(scaled, (1.0, ratio), (y, x), (down, across))
    return down * y + across * x


def _peak(scaled: list[NDArray[np.complexfloating]], ratio: float) -> tuple[float, float]:
    """Slopes, rad/px, of the largest bin of both spectra together."""
    from scipy.fft import fft2, fftfreq, next_fast_len

    sizes: list[int] = [int(next_fast_len(2 * n) or 1) for n in scaled[0].shape]
    spectra = [np.asarray(fft2(p.astype(np.complex64), sizes)) for p in scaled]
    first, second = (np.abs(one) ** 2 for one in spectra)
    whole = [np.rint(fftfreq(n) * n) for n in sizes]
    rows, columns = (np.rint(ratio * k).astype(int) % n for k, n in zip(whole, sizes, strict=True))
    best = int(np.argmax(first + second[np.ix_(rows, columns)]))
    place = np.unravel_index(best, sizes)
    return tuple(TAU * k[i] / n for k, i, n in zip(whole, place, sizes, strict=True))


def _refined(
    scaled: list[NDArray[np.complexfloating]],
    ratios: tuple[float, float],
    axes: tuple[NDArray, NDArray],
    slopes: tuple[float, float],
) -> tuple[float, float]:
    """One Gauss-Newton step towards the peak, no longer than a bin."""
    gradient, bends = np.zeros(2), np.zeros((2, 2, 2))
    for phasor, ratio in zip(scaled, ratios, strict=True):
        turned = phasor * np.exp(-1j * ratio * (slopes[0] * axes[0] + slopes[1] * axes[1]))
        along = turned * np.conj(turned.sum())
        for i, one in enumerate(axes):
            gradient[i] += ratio * np.sum(along.imag * one)
            for j, other in enumerate(axes):
                both = ratio**2 * one * other
                bends[:, i, j] += np.sum(along.real * both), np.sum(np.abs(along) * both)
    # off the summit the curvature may turn round; that of all phasors aligned never does
    bend = next((b for b in bends if np.linalg.eigvalsh(b)[0] > 0), np.eye(2))
    longest = np.pi / np.array(axes[0].shape)
    moved = np.clip(np.linalg.solve(bend, gradient), -longest, longest)
    return slopes[0] + moved[0], slopes[1] + moved[1]
