"""RGB-D frame -> Measurement: the paper's simulator (Sec. 5.3, Eq. 8)."""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from cmtof.constants import (
    FREQUENCIES,
    FULL_SIGNAL,
    GAIN,
    INTEGRATION_TIME,
    NOISE_SIGMA,
)
from cmtof.correlation import TAU, wrap_length
from cmtof.detector import NoiseOrder, poisson_gaussian
from cmtof.frame import Frame
from cmtof.measurement import Measurement, unambiguous_range
from cmtof.types import Array, Flags, Pair, Single
from cmtof.validation import checked_frequencies

Protocol = Literal["released", "full"]

# Wraps [first, last) of the lowest frequency that the released code tells apart, N = 21.
RELEASED_WRAPS = (36, 57)

# Depth to which the released code shrinks each scene's 99.9th percentile, m.
RELEASED_FAR_DEPTH = 1.195

_FAR = 2.7  # nearest depth, over the farthest in range, beyond which depths seem to be no metres

# The four reference phases of Eq. 8 in rising order, rad.
QUADRATURES = tuple(k * np.pi / 2 for k in range(4))


def simulate(
    frame: Frame,
    *,
    protocol: Protocol = "released",
    frequencies: ArrayLike = FREQUENCIES,
    noise: float = NOISE_SIGMA,
    noise_free: bool = False,
    psi: ArrayLike = QUADRATURES,
    order: NoiseOrder = "paper",
    phase_offset: ArrayLike = 0.0,
    seed: int = 0,
    frame_number: int = 0,
) -> Measurement:
    """Noisy correlation images of a frame, with its true depth and mask, in float32 (Eq. 8).

    The frame's intensity is clipped to [0, 1]. ``protocol`` is that of `staged_depth`; pixels out
    of its range are masked, and keep their signal. Frequencies (F,), Hz, lowest first; ``psi``
    (K,), rad; ``noise`` is the Gaussian sigma, counts, beside photon noise; ``order`` is that of
    `cmtof.detector.poisson_gaussian`.
    ``phase_offset`` (F,) is an error of calibration added to every phase of a frequency, rad
    (Table 3). The noise is drawn from ``default_rng([seed, frame_number])``.
    """
    frequencies = checked_frequencies(frequencies)
    try:
        depth, mask, limits = staged_depth(
            frame.depth, protocol=protocol, frequencies=frequencies
        )
    except ValueError as error:  # a note may tell why
        raise ValueError(f"{error} {frame.note}".strip()) from None
    phase_offset = np.broadcast_to(phase_offset, frequencies.shape)
    # an error of the phase is one of the reference phase that the file does not know of
    means = _means(frame, depth, frequencies, np.add(psi, phase_offset[:, None]))
    if not noise_free:
        rng = np.random.default_rng([seed, frame_number])
        means = poisson_gaussian(means, rng=rng, sigma=noise, order=order)
    return Measurement.from_arrays(
        means,
        psi,
        frequencies,
        depth=depth.astype(np.float32),
        mask=mask,
        camera=frame.camera,
        range_min=limits[0],
        range_max=limits[1],
        source="simulation",
        frame=frame.name,
        frame_note=frame.note,
        protocol=protocol,
        seed=seed,
        frame_number=frame_number,
        noise_sigma=0.0 if noise_free else float(noise),
        photon_noise=int(not noise_free),
        noise_order=order,
        phase_offset=phase_offset,
        gain=GAIN,
        integration_time_ms=INTEGRATION_TIME,
    )


def _means(frame: Frame, depth: Array, frequencies: Array, psi: Array) -> Single:
    """Expected counts ``G T I (1/2 + cos(phi + psi) / pi)`` (F, K, H, W) at psi (F, K), float32."""
    # where no depth is known no light returns
    signal = np.where(np.isnan(depth), 0, np.clip(frame.intensity, 0, 1))
    signal = FULL_SIGNAL * signal.astype(np.float32)
    turns = np.nan_to_num(depth) / wrap_length(frequencies)[:, None, None]
    # turns are reduced in double precision: 700 wraps in float32 would lose a milliradian
    angle = (TAU * (turns % 1)).astype(np.float32)[:, None]
    x = np.cos(angle) * signal / np.pi
    y = np.sin(angle) * signal / np.pi
    step = psi[..., None, None]
    c = np.cos(step).astype(np.float32)
    s = np.sin(step).astype(np.float32)
    means = x * c
    means -= y * s
    means += signal / 2
    return np.maximum(means, 0)  # rounding must not make a rate negative


def staged_depth(
    depth: Array, *, protocol: Protocol, frequencies: Array
) -> tuple[Array, Flags, Pair]:
    """Depth (H, W) as a protocol sees it, m, the mask of pixels it scores, and its range, m.

    ``"released"``: the scene is shrunk until 99.9 % lie within 1.195 m, and pixels outside wraps 36
    to 56 are masked, as the authors' released code does. ``"full"``: nothing is scaled, pixels
    beyond the beat's range (7.495 m) are masked. The depth is NaN where unknown; the range is
    ``min <= z < max``. ValueError for another protocol, or if no pixel lies in the range.
    """
    depth = np.asarray(depth, float)
    known = np.isfinite(depth)
    if protocol == "released":
        step = float(wrap_length(frequencies[0]))
        limits = (RELEASED_WRAPS[0] * step, RELEASED_WRAPS[1] * step)
        depth = depth * released_scale(np.percentile(depth[known], 99.9))  # pyright: ignore[reportArgumentType]
    elif protocol == "full":
        limits = (0.0, unambiguous_range(frequencies))
    else:
        raise ValueError(
            f"Expected protocol 'released' or 'full', got {protocol!r}. Choose one."
        )
    low, high = limits
    mask = known & (depth >= low) & (depth < high)
    if not mask.any():
        nearest = np.nanmin(depth)
        advice = (
            "Are they in millimetres?"
            if nearest > _FAR * max(high, 1.0)
            else "Use another protocol or frame."
        )
        raise ValueError(
            f"Expected depths between {low:.3f} and {high:.3f} m, "
            f"got {nearest:.3f} to {np.nanmax(depth):.3f} m. {advice}"
        )
    return depth, mask, limits


def released_scale(far: float) -> float:
    """Factor by which the released code shrinks a scene with the 99.9th percentile ``far``, m."""
    return float(np.clip(RELEASED_FAR_DEPTH / far, 0.01, 1.0))
