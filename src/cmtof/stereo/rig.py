"""Two cameras and the scanner between them: the geometry, and what is not known of it.

Everything is told in the frame of the left camera. The 30 parameters, in their order: nine of each
camera (`cmtof.stereo.camera.INTRINSICS`), and two poses as rotation vector, rad, and translation,
m: the right camera's and the scanner's, both of the left frame in theirs.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.stereo.camera import PinholeCamera
from cmtof.stereo.pose import Pose

Array = NDArray[np.floating]

LEFT, RIGHT, BETWEEN, SCANNER = slice(0, 9), slice(9, 18), slice(18, 24), slice(24, 30)
"""Where the parts of a rig stand among its 30 parameters."""

PIXEL_PITCH = 3.45e-6
"""Pixel of the Sony IMX252, m: table "Specifications and Frame Rates" of FLIR's BFS-U3-32S4 (2048 x
1536, 3.45 um, global shutter, 12 bit). That the Grasshopper3 GS3-U3-32S4C of Section 6.4 has the
same sensor is not verified against its own data sheet."""

SENSOR_SHAPE = (1536, 2048)
"""Height and width of the same sensor, px."""

FOCAL_LENGTH = 8e-3
"""Of both lenses, m (Sec. 6.4)."""


@dataclass(frozen=True, eq=False)
class StereoRig:
    """Two cameras, and where the right one and the scanner stand.

    Attributes
    ----------
    left, right : PinholeCamera
    right_from_left, scanner_from_left : Pose
        Take points of the left camera's frame, m, to theirs.
    covariance : ndarray, shape (30, 30), optional
        Of the parameters, after a calibration.

    Raises
    ------
    ValueError
        If both cameras stand in one place, or the covariance has another shape.
    """

    left: PinholeCamera
    right: PinholeCamera
    right_from_left: Pose
    scanner_from_left: Pose
    covariance: Array | None = None

    def __post_init__(self) -> None:
        if not self.baseline > 0:
            raise ValueError("Expected two cameras apart, got a baseline of 0 m. Move one.")
        if self.covariance is not None and np.shape(self.covariance) != (30, 30):
            raise ValueError(
                f"Expected a covariance (30, 30), got {np.shape(self.covariance)}. Take that of "
                "the calibration."
            )

    @property
    def baseline(self) -> float:
        """Distance of the cameras' centres, m."""
        return float(np.linalg.norm(self.right_from_left.translation))

    @property
    def parameters(self) -> Array:
        """All 30 numbers."""
        poses = (self.right_from_left.vector, self.scanner_from_left.vector)
        return np.concatenate([self.left.intrinsics, self.right.intrinsics, *poses])

    def with_parameters(self, parameters: ArrayLike) -> "StereoRig":
        """Return a rig of the same sensors with other numbers, and no covariance."""
        numbers = np.asarray(parameters, float)
        return StereoRig(
            PinholeCamera(numbers[LEFT], self.left.shape),
            PinholeCamera(numbers[RIGHT], self.right.shape),
            Pose.from_vector(numbers[BETWEEN]),
            Pose.from_vector(numbers[SCANNER]),
        )

    def moved(self, **changes: float) -> "StereoRig":
        """Return a rig with single parameters changed, by the names of `PARAMETERS`.

        Examples
        --------
        >>> rig = simulated_rig()
        >>> round(rig.moved(right_tx=-1e-3).baseline - rig.baseline, 5)
        0.001
        """
        numbers = self.parameters
        for name, change in changes.items():
            if name not in PARAMETERS:
                raise ValueError(
                    f"Expected a parameter out of {', '.join(PARAMETERS)}, got {name}. Choose one."
                )
            numbers[PARAMETERS.index(name)] += change
        return replace(self.with_parameters(numbers), covariance=self.covariance)

    def centres(self) -> Array:
        """Left camera, right camera and scanner in the scanner's frame, (3, 3), m."""
        places = [np.zeros(3), self.right_from_left.inverse.translation]
        return np.stack([*self.scanner_from_left.apply(places), np.zeros(3)])

    def project(self, points: ArrayLike) -> tuple[Array, Array]:
        """Pixels (..., 2) in both images of points (..., 3), m, of the scanner's frame."""
        inside = self.scanner_from_left.inverse.apply(points)
        return self.left.project(inside), self.right.project(self.right_from_left.apply(inside))


def _names() -> tuple[str, ...]:
    from cmtof.stereo.camera import INTRINSICS

    pose = ("rx", "ry", "rz", "tx", "ty", "tz")
    return (
        *(f"left_{name}" for name in INTRINSICS),
        *(f"right_{name}" for name in INTRINSICS),
        *(f"right_{name}" for name in pose),
        *(f"scanner_{name}" for name in pose),
    )


PARAMETERS = _names()
"""Names of the 30 parameters, such as ``left_fx``, ``right_ry`` or ``scanner_tz``."""


def simulated_rig(
    *,
    baseline: float = 0.3,
    converge: float = 3.0,
    focal_length: float = FOCAL_LENGTH,
    pitch: float = PIXEL_PITCH,
    shape: tuple[int, int] = SENSOR_SHAPE,
    distortion: ArrayLike = (-0.09, 0.11, 0.0, 3e-4, -2e-4),
    forward: float = 0.0,
) -> StereoRig:
    """Rig like Fig. 9a, simulated: a camera on either side of the scanner, turned inwards.

    The paper states cameras and lenses (Sec. 6.4), neither baseline nor angle: those are ours, and
    so is the distortion, that of a common machine-vision lens.

    Parameters
    ----------
    baseline : float
        Between the cameras, m.
    converge : float
        Distance at which their axes meet, m.
    focal_length, pitch : float
        m.
    shape : (int, int)
        px.
    distortion : array_like, shape (5,)
        k1, k2, k3, p1, p2; the right lens has slightly more of it.
    forward : float
        How far the cameras stand before the scanner, m.

    Raises
    ------
    ValueError
        If baseline or convergence is not positive.

    Examples
    --------
    >>> rig = simulated_rig(baseline=0.4)
    >>> round(rig.baseline, 6), rig.centres()[:, 0].round(3).tolist()
    (0.4, [-0.2, 0.2, 0.0])
    """
    if not (baseline > 0 and converge > 0):
        raise ValueError(
            f"Expected a baseline and a convergence above 0 m, got {baseline} and {converge}. "
            "Correct them."
        )
    bent = np.asarray(distortion, float)
    left, right = (
        PinholeCamera.from_lens(focal_length, pitch, shape, bent * scale) for scale in (1.0, 1.05)
    )
    places = np.array([[-baseline / 2, 0, forward], [baseline / 2, 0, forward]])
    in_left, in_right = (Pose.looking(place, (0, 0, converge)) for place in places)
    return StereoRig(left, right, in_right.after(in_left.inverse), in_left.inverse)
