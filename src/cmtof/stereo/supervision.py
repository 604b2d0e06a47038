"""Pseudo-true wrap maps from stereo (Sec. 6.4, Fig. 9): what a network may be fine-tuned on.

A triangulated spot has a range z along the scanner's ray, and so a wrap count ``floor(2 f z / c)``.
It is a label where its uncertainty leaves no doubt about the whole number. Alone, stereo is in
doubt near every boundary of two wraps; together with the measured phase it need only be right to
half a wrap, and then the phase says where in the wrap it is.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import consistent_wrap_count, depth_from_wraps, wrap_length
from cmtof.scenes.frame import Frame
from cmtof.stereo.pose import turned
from cmtof.stereo.rig import SCANNER, StereoRig
from cmtof.stereo.sensor import Sensor
from cmtof.stereo.spot import Spots, Status
from cmtof.stereo.triangulation import Triangulated, triangulate
from cmtof.stereo.views import Lighting, record, view_scene

Array = NDArray[np.floating]

SIGMAS = 3.0
"""Standard deviations k of a range that must fit: a Gaussian error is beyond in 0.3 % of cases."""

MISFIT = 12.0
"""Largest chi^2 across the epipolar line, 1 degree of freedom: a right pair exceeds it in 0.05 %
of cases, with a calibration that is right."""


class Reason(IntEnum):
    """Why a pixel has a label, or none; the first that applies."""

    LABELLED = 0
    UNKNOWN = 1
    """Nothing came back from there."""
    OUTSIDE = 2
    """A camera does not see there."""
    HIDDEN = 3
    """Something stands between the spot and a camera, or the spot is too dim."""
    SATURATED = 4
    DOUBLE = 5
    MISMATCHED = 6
    """The rays of both spots pass each other too far apart."""
    UNCERTAIN = 7
    """The range leaves a doubt about the wrap."""


class PseudoTruth(NamedTuple):
    """Labels from stereo; all arrays (H, W)."""

    wraps: NDArray[np.int64]
    """Wrap count of the frequency; -1 where masked."""
    mask: NDArray[np.bool_]
    """True where a pixel is labelled."""
    range: Array
    """Along the scanner's ray, m, from stereo alone; NaN where no spot was triangulated."""
    uncertainty: Array
    """Standard deviation of the range, m."""
    depth: Array
    """Best range, m: by the phase within the labelled wrap, or stereo's where there is no phase."""
    reason: NDArray[np.int8]
    """Out of `Reason`."""

    @property
    def share(self) -> float:
        """Labelled share of the pixels that a scan can label, those where light came back."""
        lit = self.reason != Reason.UNKNOWN
        return float(self.mask.sum() / max(int(lit.sum()), 1))


def ranges(rig: StereoRig, spots: Triangulated) -> tuple[Array, Array, Array]:
    """Ranges from the scanner, m, their variance by the spots, and by the rig's parameters.

    Parameters
    ----------
    rig : StereoRig
        Without a covariance the third is 0.
    spots : Triangulated

    Returns
    -------
    ranges, by_spots, by_calibration : ndarray, shape (...)
        m, m^2, m^2. An error of the calibration is shared by all pixels, those of spots are not.
    """
    scanner = rig.scanner_from_left
    rotated, by_turn = turned(scanner.vector[:3], spots.points)
    seen = rotated + scanner.translation
    found = np.linalg.norm(seen, axis=-1)
    along = seen / found[..., None]
    by_point = along @ scanner.rotation
    by_spots = np.einsum("...i,...ij,...j->...", by_point, spots.covariance, by_point)
    if rig.covariance is None:
        return found, by_spots, np.zeros_like(found)
    slope = np.einsum("...i,...ij->...j", by_point, spots.by_rig)
    turns = np.einsum("...i,...ij->...j", along, by_turn)
    slope[..., SCANNER] += np.concatenate([turns, along], -1)
    return found, by_spots, np.einsum("...i,ij,...j->...", slope, rig.covariance, slope)


def truth_from_spots(
    spots: tuple[Spots, Spots],
    rig: StereoRig,
    frequency: float,
    *,
    phase: ArrayLike | None = None,
    phase_noise: ArrayLike = 0.0,
    sigmas: float = SIGMAS,
    lit: ArrayLike | None = None,
) -> PseudoTruth:
    """Wrap map, mask and uncertainty from the spots of a scan.

    Parameters
    ----------
    spots : (Spots, Spots)
        Of left and right, (H, W).
    rig : StereoRig
        Calibrated, the scanner located; with a covariance its errors count too.
    frequency : float
        Hz.
    phase : array_like, shape (H, W), optional
        Wrapped phase that the scan measured at this frequency, rad. With it the label is the wrap
        that brings the phase nearest to the stereo range, and pixels are masked whose k standard
        deviations exceed half a wrap. Without it the label is ``floor(2 f z / c)``, and pixels are
        masked whose k standard deviations reach into another wrap.
    phase_noise : array_like
        Standard deviation of that phase, rad.
    sigmas : float
        k.
    lit : array_like, shape (H, W), optional
        False where no light came back; by default True.

    Raises
    ------
    ValueError
        If shapes disagree, or frequency or k are not positive.
    """
    left, right = spots
    if not (frequency > 0 and sigmas > 0):
        raise ValueError(
            f"Expected a frequency and a number of sigmas above 0, got {frequency} Hz and "
            f"{sigmas}. Correct them."
        )
    shape = left.status.shape
    for name, other in (("right spots", right.status), ("phase", phase), ("lit", lit)):
        if other is not None and np.shape(other) != shape:
            raise ValueError(
                f"Expected {name} of the left spots' shape {shape}, got {np.shape(other)}. Take "
                "them from one scan."
            )
    points = triangulate(rig, left.pixels, right.pixels, (left.covariance, right.covariance))
    found, by_spots, by_rig = ranges(rig, points)
    deviation = np.sqrt(by_spots + by_rig)
    reason = _reasons(left.status, right.status, points.misfit, lit)
    wrap = float(wrap_length(frequency))
    sure, wraps, depth = _labels(found, deviation, wrap, frequency, phase, phase_noise, sigmas)
    reason[(reason == Reason.LABELLED) & ~sure] = Reason.UNCERTAIN
    mask = reason == Reason.LABELLED
    return PseudoTruth(
        np.where(mask, wraps, -1), mask, found, deviation, np.where(mask, depth, np.nan), reason
    )


def pseudo_truth(
    frame: Frame,
    rig: StereoRig,
    *,
    rng: np.random.Generator,
    calibrated: StereoRig | None = None,
    frequency: float = FREQUENCY_SINGLE,
    phase: ArrayLike | None = None,
    phase_noise: ArrayLike = 0.0,
    sigmas: float = SIGMAS,
    sensor: Sensor | None = None,
    lighting: Lighting | None = None,
) -> PseudoTruth:
    """Pseudo-true wrap map of a frame, from cameras that watch the scan (simulated).

    Parameters
    ----------
    frame : Frame
        With a camera: the rays of the scan.
    rig : StereoRig
        As it really is; it makes the images.
    rng : Generator
        Of shot, read and speckle noise.
    calibrated : StereoRig, optional
        As it was calibrated: what the spots are triangulated with. By default without error.
    frequency, phase, phase_noise, sigmas
        As in `truth_from_spots`.
    sensor, lighting
        As in `cmtof.stereo.views.view_scene`.

    Returns
    -------
    PseudoTruth
        Wrap map, mask, range and its uncertainty; `cmtof.network.finetuning` trains on it.

    Raises
    ------
    ValueError
        If the frame has no camera, or a shape or setting cannot be used.

    Examples
    --------
    >>> from cmtof.stereo import simulated_rig
    >>> wall = Frame(np.full((4, 6), 1.5), np.full((4, 6), 0.5), np.array([9.0, 9.0, 3.0, 2.0]))
    >>> truth = pseudo_truth(wall, simulated_rig(), rng=np.random.default_rng(0))
    >>> truth.wraps.shape, truth.mask.dtype.name
    ((4, 6), 'bool')
    """
    scene = view_scene(frame, rig, sensor=sensor, lighting=lighting)
    return truth_from_spots(
        record(scene, rng=rng),
        calibrated or rig,
        frequency,
        phase=phase,
        phase_noise=phase_noise,
        sigmas=sigmas,
        lit=scene.lit,
    )


def _labels(
    found: Array,
    deviation: Array,
    wrap: float,
    frequency: float,
    phase: ArrayLike | None,
    phase_noise: ArrayLike,
    sigmas: float,
) -> tuple[NDArray[np.bool_], NDArray[np.int64], Array]:
    """Whether a wrap is beyond doubt, its count, and the best range, m."""
    known = np.isfinite(found) & np.isfinite(deviation)
    safe = np.where(known, found, 0.0)
    spread = np.where(known, sigmas * deviation, np.inf)
    if phase is None:
        low, high = np.floor((safe - spread) / wrap), np.floor((safe + spread) / wrap)
        wraps = np.floor(safe / wrap).astype(np.int64)
        return known & (low == high) & (wraps >= 0), wraps, safe
    phase = np.asarray(phase, float)
    own = sigmas * np.asarray(phase_noise) * wrap / (2 * np.pi)
    wraps = consistent_wrap_count(safe, np.nan_to_num(phase), frequency)
    sure = known & np.isfinite(phase) & (np.hypot(spread, own) < wrap / 2) & (wraps >= 0)
    return sure, wraps, depth_from_wraps(phase, wraps, frequency)


def _reasons(
    left: NDArray, right: NDArray, misfit: Array, lit: ArrayLike | None
) -> NDArray[np.int8]:
    """Why pixels have no point; those of lesser number win."""
    reason = np.zeros(left.shape, np.int8)
    with np.errstate(invalid="ignore"):
        reason[~(misfit <= MISFIT)] = Reason.MISMATCHED
    for status, why in (
        (Status.DOUBLE, Reason.DOUBLE),
        (Status.SATURATED, Reason.SATURATED),
        (Status.ABSENT, Reason.HIDDEN),
        (Status.OUTSIDE, Reason.OUTSIDE),
    ):
        reason[(left == status) | (right == status)] = why
    if lit is not None:
        reason[~np.asarray(lit, bool)] = Reason.UNKNOWN
    return reason
