"""The beat averaged by a guided filter: windows that stop at edges of amplitude and of phase.

Within each window the beat's unit phasor is fitted by a linear function of a guide,
``q = a . g + b``, and each pixel takes the mean of the fits of all windows that hold it (He et al.
2013). Where the guide is flat that is a plain average; where it steps, both sides are fitted apart.

The wrapped phase itself cannot guide: it steps at every wrap. Its local slope can, as the phasor
``exp(i s)`` that wraps with it, and so can the coherence of that slope, which sinks at edges.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cmtof.baselines import Estimate
from cmtof.baselines.beat import beat_depth, beat_phasor, box, confidence_from_coherence
from cmtof.measurement import Measurement

WINDOW = 41
"""Side of the windows that are fitted, px; on 10 views of validation rooms 31 is 0.2 points of
delta < 1 better in full and 0.8 worse in released."""

SMOOTHING = 0.02
"""Variance of a guide below which a window is averaged rather than fitted."""

_LOCAL = 11  # side of the windows that tell slope and coherence, px
_LEAST = 1e-6  # weight of a pixel without light, in units of the mean


def beat_guided(
    measurement: Measurement, *, window: int = WINDOW, smoothing: float = SMOOTHING
) -> Estimate:
    r"""Depth of the beat after a guided filter with several guides.

    .. math:: a = (\Sigma_w + \epsilon 1)^{-1}\,\mathrm{cov}_w(g, e^{i\theta}),\quad
              b = \bar e - a \cdot \bar g,\quad q = \overline{a}\cdot g + \overline{b}

    with all means weighted by ``|p_1| |p_2|``, the inverse variance of the beat's phase theta.
    The confidence is that of a plain average over as many pixels (see `cmtof.baselines.beat`).

    Parameters
    ----------
    measurement : Measurement
        At two frequencies.
    window : int
        Odd side of the windows, px.
    smoothing : float
        epsilon: the guides are a logarithm and numbers within the unit circle.

    Raises
    ------
    ValueError
        If the window is not odd or the smoothing not positive.

    References
    ----------
    He, Sun, Tang: Guided image filtering. IEEE TPAMI 35(6), 2013.
    """
    if window < 1 or window % 2 == 0:
        raise ValueError(f"Expected an odd window of 1 px or more, got {window}. Try {WINDOW}.")
    if not smoothing > 0:
        raise ValueError(f"Expected a smoothing > 0, got {smoothing:g}. Try {SMOOTHING:g}.")
    phasor = beat_phasor(measurement).astype(complex)  # the fit wants double precision
    weight = np.abs(phasor) / (np.abs(phasor).mean() or 1.0) + _LEAST
    unit = np.divide(phasor, np.abs(phasor), out=np.zeros_like(phasor), where=phasor != 0)
    filtered = guided_filter(unit, guides(measurement), weight, window, smoothing)
    depth = beat_depth(np.angle(filtered), measurement)
    mean = filtered * box(np.abs(phasor), window)
    return Estimate(
        depth,
        confidence_from_coherence(mean, box(np.abs(phasor) ** 2, window), window, measurement),
    )


def guides(measurement: Measurement, *, window: int = _LOCAL) -> NDArray[np.floating]:
    """Guides (6, H, W): log amplitude, coherence, and both slopes' cosine and sine.

    The slope along an axis is the angle of ``sum p(x+1) conj p(x)`` over a window, p the phasor of
    the lowest frequency: free of wraps. Coherence is that sum's length over the sum of lengths.
    """
    amplitude = np.nan_to_num(measurement.amplitude[:2].astype(float), posinf=0, neginf=0)
    phase = np.nan_to_num(measurement.phase[0].astype(float), posinf=0, neginf=0)
    phasor = amplitude[0] * np.exp(1j * phase)
    coherence, slopes = np.ones(phase.shape), []
    for axis in (0, 1):
        pairs = np.zeros_like(phasor)
        ahead, behind = np.moveaxis(phasor, axis, 0)[1:], np.moveaxis(phasor, axis, 0)[:-1]
        np.moveaxis(pairs, axis, 0)[:-1] = ahead * np.conj(behind)
        total, length = box(pairs, window), box(np.abs(pairs), window)
        coherence *= _ratio(np.abs(total), length)
        slope = _ratio(total, np.abs(total))
        slopes += [np.real(slope), np.imag(slope)]
    bright = box(amplitude.sum(axis=0), 5)
    # a tenth of the mean keeps the logarithm of noise in the dark from guiding anything
    bright = np.log(0.1 + np.maximum(bright, 0) / (bright.mean() or 1.0))
    return np.stack([bright, coherence, *slopes])


def guided_filter(
    values: NDArray[np.complexfloating],
    guide: NDArray[np.floating],
    weight: NDArray[np.floating],
    window: int,
    smoothing: float,
) -> NDArray[np.complexfloating]:
    """Guided filter of complex values (H, W) by guides (G, H, W), weights > 0 (H, W)."""
    total = box(weight, window)

    def mean(image: NDArray[Any]) -> NDArray[Any]:
        return box(weight * image, window) / total

    count = len(guide)
    middle = np.stack([mean(one) for one in guide])
    centre = mean(values)
    spread = np.empty((*values.shape, count, count))
    for i in range(count):
        for j in range(i, count):
            spread[..., i, j] = mean(guide[i] * guide[j]) - middle[i] * middle[j]
            spread[..., j, i] = spread[..., i, j]
    spread[..., range(count), range(count)] += smoothing
    shared = [mean(one * values) - m * centre for one, m in zip(guide, middle, strict=True)]
    both = np.stack([np.stack([s.real, s.imag], axis=-1) for s in shared], axis=-2)
    fit = np.linalg.solve(spread, both)  # (H, W, G, 2)
    slope = np.moveaxis(fit[..., 0] + 1j * fit[..., 1], -1, 0)
    result = mean(centre - (slope * middle).sum(axis=0))
    for one, part in zip(guide, slope, strict=True):
        result = result + mean(part) * one
    return result


def _ratio(part: NDArray[Any], whole: NDArray[np.floating]) -> NDArray[Any]:
    """Quotient, zero where there is nothing to divide by."""
    return np.divide(part, whole, out=np.zeros_like(part), where=whole > 0)
