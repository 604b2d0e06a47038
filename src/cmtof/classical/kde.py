"""Kernel density of depth hypotheses (Järemo Lawin, Forssén and Ovrén, ECCV 2016), for two tones.

Each pixel x has one hypothesis for each wrap in range. It is as good as its neighbours y have
good hypotheses at the same depth (their equation for the Kinect v2, three tones):

    D_i(x) = sum_y g(x - y) sum_j w_j(y) exp(-(d_i(x) - d_j(y))^2 / 2 h^2)

Adapted to two frequencies a GHz apart: all wraps in range are hypotheses, where the original keeps
the best two of 30. Weights ``w_j = exp(-r_j^2 / 2 s^2) exp(-(s_1^2 + s_2^2) / 2 s_0^2)`` are by the
misfit ``r_j = phi_2 - k (phi_1 + 2 pi j)``, k = f_2 / f_1, of variance ``s_2^2 + k^2 s_1^2``, and
by the phase variance, ``s_0^2 = 3``. Depths d are those of the lower phase, in wraps, and h is a
quarter of one, as theirs. The answer fuses both phases.
"""

from collections.abc import Iterator
from functools import partial
from math import ceil, prod

import numpy as np
from scipy.ndimage import gaussian_filter

from cmtof.classical.crt import fused_depth, nearest_wrap
from cmtof.correlation import TAU, centred
from cmtof.estimate import Estimate, guess_probability, phase_noise, wraps_in_range
from cmtof.measurement import Measurement
from cmtof.types import Array, Numbers, Single

KERNEL = 0.25  # kernel width h, wraps, as published
RADIUS = 5  # and radius of the window, px
# The same, of the largest delta < 1 on eight views of validation rooms (`released`) out of h = 0.25
# to 2 wraps and r = 5 to 40 px: 17.4 % against 7.7 % as published.
TUNED_KERNEL = 0.5
TUNED_RADIUS = 40
_RELIABILITY = 3.0  # s_0^2, rad^2, as published
_FINEST = 0.01  # least misfit, rad, that counts as one sigma


def kde(
    measurement: Measurement, *, kernel: float = KERNEL, radius: int = RADIUS
) -> Estimate:
    """Depth of each pixel by the wrap about which its neighbours' hypotheses are densest.

    ``kernel`` is the width h along depth, wraps of the lower frequency; ``radius`` that of the
    Gaussian window, px, with half of it as sigma. The confidence is the share of all densities.
    """
    if not 0 < kernel <= 100 or radius not in range(1, 1000):
        raise ValueError(
            "Expected a kernel of 0 to 100 wraps, a radius of 1 to 999 px, "
            f"got {kernel} and {radius}. Try {KERNEL} and {RADIUS}."
        )
    low, high = measurement.frequencies
    first, _ = wraps_in_range(measurement)
    label, best, total = _largest_density(measurement, kernel, radius)
    dense = best > 1e-32  # else no neighbour counts, and the least misfit decides
    wraps = np.where(dense, label + first, nearest_wrap(measurement)[0])
    phase = measurement.phase
    residual = centred(phase[1] - high / low * (phase[0] + TAU * wraps))
    share = np.minimum(best / np.where(dense, total, 1), 1)
    return Estimate(
        fused_depth(measurement, wraps, residual),
        np.where(dense, share, guess_probability(measurement)),
    )


def kde_tuned(measurement: Measurement) -> Estimate:
    """The method `kde` with the kernel and the window that did best on validation rooms."""
    return kde(measurement, kernel=TUNED_KERNEL, radius=TUNED_RADIUS)


def hypotheses(measurement: Measurement) -> Iterator[Single]:
    """Weight w_j (H, W), 0 to 1, of each wrap in range, one after the other."""
    low, high = measurement.frequencies
    first, last = wraps_in_range(measurement)
    phase = measurement.phase
    noise = phase_noise(measurement)
    ratio = high / low
    # at least a quarter of the step from wrap to wrap: without noise no weight may vanish
    step = TAU * abs(ratio - round(ratio))
    least = min(step / 4, _FINEST) if step > 1e-9 else _FINEST
    spread = (np.maximum(np.hypot(noise[1], ratio * noise[0]), least) / TAU).astype(
        np.float32
    )
    reliability = np.exp(-(noise**2).sum(axis=0) / (2 * _RELIABILITY)).astype(
        np.float32
    )
    misfit = np.mod((phase[1] - ratio * phase[0]) / TAU, 1).astype(np.float32)
    for j in range(first, last + 1):
        left = misfit - np.float32(np.mod(ratio * j, 1))
        left = (left - np.rint(left)) / spread
        yield reliability * np.exp(-left * left / 2)


def _largest_density(
    measurement: Measurement, kernel: float, radius: int
) -> tuple[Numbers, Array, Array]:
    """Index of the wrap of largest density, that density, and the densities' sum, each (H, W).

    A cubic through nodes h/2 apart, each a blurred image, gives the density at the depths
    ``turns + n`` of the pixel, wraps; it errs by 0.4 % of its peak.
    """
    turns = (measurement.phase[0] / TAU).astype(np.float32)
    nodes = max(2, ceil(2 / kernel))
    cubic = _cubic_shares(turns * nodes, nodes)
    images = _blurred_nodes(
        [*hypotheses(measurement)], _kernels(turns, kernel, nodes), radius
    )
    label = np.zeros(turns.shape, np.int64)
    best = np.zeros_like(turns)
    total = np.zeros_like(turns)
    before = next(images)
    here = next(images)
    for n, ahead in enumerate(images):
        density = np.einsum(
            "mhw,mhw->hw", cubic, np.stack([before[-1], *here, *ahead[:2]])
        )
        density = np.maximum(density, 0)
        label[density > best] = n
        best = np.maximum(best, density)
        total += density
        before = here
        here = ahead
    return label, best, total


def _kernels(turns: Single, kernel: float, nodes: int) -> Single:
    """Gaussian (node, wrap, H, W), 0 to 1, of distances of nearby wraps' depths to nodes."""
    reach = ceil(4 * kernel)
    apart = np.arange(-reach, reach + 1) - np.arange(nodes)[:, None] / nodes
    return np.exp(-(((turns + apart[..., None, None]) / kernel) ** 2) / 2).astype(
        np.float32
    )


def _blurred_nodes(
    weights: list[Single], kernels: Single, radius: int
) -> Iterator[list[Single]]:
    """Densities (H, W) at the nodes of each wrap, and of one more wrap at either end, blurred."""
    span = kernels.shape[1]
    beyond = [np.zeros_like(weights[0])] * (span // 2 + 1)
    padded = [*beyond, *weights, *beyond]
    blur = partial(
        gaussian_filter, sigma=max(radius / 2, 0.5), mode="constant", radius=radius
    )
    for first in range(len(padded) - span + 1):
        around = np.stack(padded[first : first + span])
        images = (np.einsum("khw,khw->hw", around, one) for one in kernels)
        yield [*map(blur, images)]  # pyright: ignore[reportReturnType]


def _cubic_shares(place: Single, nodes: int) -> Single:
    """Weights of the nodes -1 ... nodes + 1 in a cubic interpolation at places (H, W), in nodes."""
    cell = np.minimum(np.floor(place), nodes - 1)
    fraction = place - cell
    weights = np.zeros((nodes + 3, *place.shape), np.float32)
    around = range(-1, 3)
    for k in around:  # Lagrange's polynomials
        share = prod((fraction - other) / (k - other) for other in around if other != k)
        np.put_along_axis(weights, cell.astype(int)[None] + k + 1, share[None], axis=0)  # pyright: ignore[reportIndexIssue]
    return weights
