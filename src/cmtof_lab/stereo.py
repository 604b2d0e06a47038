r"""Stereo supervision (Sec. 6.4, Fig. 9): two cameras triangulate the laser spot of the scan.

A checkerboard calibrates both cameras, the spots of a scan locate the scanner between them, and the
range of each spot gives its wrap count. What the cameras see is simulated; geometry is OpenCV's.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.linalg import norm
from numpy.random import Generator
from numpy.typing import ArrayLike
from scipy.spatial.transform import RigidTransform, Rotation

from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import TAU, consistent_wrap_count, depth_from_wraps
from cmtof.frame import Frame
from cmtof.pointcloud import mesh_triangles, normals_from_points, points_from_depth
from cmtof.types import Array, Arrays, Flags, Numbers, Shape
from cmtof_lab.spots import SENSOR, WINDOW, Sensor, photographed_spots, place_spots
from cmtof_lab.sweep import WRAP
from cmtof_lab.targets import MeshTarget

COLUMNS = 9  # inner corners of the checkerboard
ROWS = 6
SQUARE = 0.04  # side of a square, m
# Those corners (54, 3), m, row by row about the middle of the board
BOARD = SQUARE * (np.mgrid[:COLUMNS, :ROWS, :1].T.reshape(-1, 3) - [4, 2.5, 0])


@dataclass(frozen=True, eq=False)
class StereoRig:
    """Left and right camera, seen from the scanner between them."""

    matrices: Array  # (2, 3, 3): focal lengths and centres, px
    distortions: Array  # (2, 5): Brown's, in OpenCV's order
    # From the scanner's frame, m, to each camera's
    poses: tuple[RigidTransform, ...]
    shape: Shape  # height and width of the images, px

    @property
    def centres(self) -> Array:
        """Places of both cameras (2, 3), m."""
        return np.stack([pose.inv().translation for pose in self.poses])

    def project(self, points: ArrayLike) -> Array:
        """Pixels (2, ..., 2) of points (..., 3), m; NaN behind a camera."""
        import cv2

        points = np.asarray(points, float)
        still = np.zeros(3)
        seen = []
        for pose, *lens in zip(
            self.poses, self.matrices, self.distortions, strict=True
        ):
            inside = np.ascontiguousarray(pose.apply(points.reshape(-1, 3)))
            inside[~(inside[:, 2] > 0)] = np.nan
            found, _ = cv2.projectPoints(inside, still, still, *lens)
            seen.append(found)
        return np.reshape(seen, (2, *points.shape[:-1], 2))

    def triangulate(self, pixels: Array) -> Array:
        """Points (..., 3), m, of pairs of pixels (2, ..., 2); NaN without a pair."""
        import cv2

        flat = pixels.reshape(2, -1, 1, 2)
        matrices = [pose.as_matrix()[:3] for pose in self.poses]
        stop = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 20, 1e-12)
        planes = [
            cv2.undistortPoints(np.nan_to_num(one), *lens, criteria=stop)
            for one, *lens in zip(flat, self.matrices, self.distortions, strict=True)
        ]
        *place, scale = cv2.triangulatePoints(*matrices, *planes)
        points = (place / scale).T
        known = np.isfinite(flat).all(axis=(0, 2, 3)) & (points[:, 2] > 0)
        points[~known] = np.nan
        return points.reshape(*pixels.shape[1:-1], 3)


def simulated_rig(*, baseline: float = 0.3, sensor: Sensor = SENSOR) -> StereoRig:
    """Rig like Fig. 9a: cameras on either side of the scanner, axes meeting 3 m away."""
    focal = sensor.focal_length / sensor.pitch
    height, width = sensor.shape
    matrix = [
        [focal, 0, width / 2],
        [0, focal, height / 2],
        [0, 0, 1],
    ]
    poses = []
    for x in (-baseline / 2, baseline / 2):
        turn = Rotation.from_rotvec([0, -np.arctan2(x, 3.0), 0])
        poses.append(RigidTransform.from_components([x, 0, 0], turn).inv())
    return StereoRig(
        np.array([matrix] * 2),
        np.outer([1.0, 1.05], [-0.09, 0.11, 3e-4, -2e-4, 0.0]),
        tuple(poses),
        sensor.shape,
    )


def board_poses(rig: StereoRig, count: int, *, rng: Generator) -> list[RigidTransform]:
    """Poses of a board about 1.1 m away, tilted by 15 to 40 degrees, whole in both images."""
    poses = []
    while len(poses) < count:
        tilt, about, roll, x, y, z = rng.uniform(
            [15, 0, -0.4, -0.14, -0.10, 0.9],
            [40, TAU, 0.4, 0.14, 0.10, 1.3],
        )
        # leaning about an axis in the board, then rolled
        turn = Rotation.from_euler("ZXZ", [about, np.deg2rad(tilt), roll - about])
        pose = RigidTransform.from_components([x * z, y * z, z], turn)
        outline = rig.project(pose.apply(1.6 * BOARD))
        if ((outline > 0) & (outline < rig.shape[::-1])).all():
            poses.append(pose)
    return poses


def calibrate(corners: ArrayLike, shape: Shape) -> tuple[StereoRig, float]:
    """Rig in the left camera's frame, and rms residual per axis, px, of corners (2, V, 54, 2)."""
    import cv2

    corners = np.asarray(corners, np.float32)
    rms, left, bent_left, right, bent_right, turn, shift, *_ = cv2.stereoCalibrate(  # pyright: ignore[reportCallIssue]
        [BOARD.astype(np.float32)] * corners.shape[1],
        *map(list, corners),
        *[None] * 4,  # nothing is known of the lenses
        shape[::-1],
        flags=cv2.CALIB_FIX_K3,
    )
    between = RigidTransform.from_components(shift.ravel(), Rotation.from_matrix(turn))
    rig = StereoRig(
        np.stack([left, right]),
        np.reshape([bent_left, bent_right], (2, -1))[:, :5],
        (RigidTransform.identity(), between),
        shape,
    )
    return rig, rms / 2**0.5


def locate_scanner(rig: StereoRig, pixels: Array, directions: Array) -> StereoRig:
    """Rig in the scanner's frame, by resection from spots (2, ..., 2) and their beams (..., 3)."""
    import cv2

    points = rig.triangulate(pixels).reshape(-1, 3)
    beams = directions.reshape(-1, 3)
    known = np.isfinite(points).all(-1) & (beams[:, 2] > 0)
    _, turn, shift = cv2.solvePnP(
        points[known], beams[known, :2] / beams[known, 2:], np.eye(3), np.zeros(4)
    )
    scanner = RigidTransform.from_components(
        shift.ravel(), Rotation.from_rotvec(turn.ravel())
    )
    return replace(rig, poses=tuple(pose * scanner.inv() for pose in rig.poses))


class Spots(NamedTuple):
    """Pixels (2, ..., 2) of spots in both images and their deviations (2, ...), px; NaN: none."""

    pixels: Array
    sigma: Array


def visible_from(points: Array, centre: Array) -> Flags:
    """Which points (H, W, 3), m, of a scan are seen from a place (3,), their mesh hiding others."""
    known = np.isfinite(points).all(-1)
    faces = mesh_triangles(points)
    points = np.nan_to_num(points)
    return known & ~MeshTarget(points.reshape(-1, 3), faces).is_hidden(points, centre)


def scan_spots(
    frame: Frame, rig: StereoRig, *, rng: Generator, sensor: Sensor = SENSOR
) -> Spots:
    """Spots (H, W) that both cameras find while a frame with a camera is scanned (simulated).

    Lambertian spots with speckle, shot and read noise; the 99th percentile peaks at 70 % of a well.
    """
    points = points_from_depth(frame.depth, frame.camera)  # pyright: ignore[reportArgumentType]
    pixels = rig.project(points)
    spots = Spots(np.full_like(pixels, np.nan), np.full_like(pixels[..., 0], np.nan))
    for k in range(2):
        rate, width = _spot_light(frame, points, rig, k, sensor)
        half = np.array(rig.shape[::-1]) / 2
        # the window lies in the image
        inside = (abs(pixels[k] - half) < half - WINDOW).all(-1)
        corner = np.floor(pixels[k, inside]) - WINDOW // 2
        place = pixels[k, inside] - corner
        place += sensor.speckle * rng.standard_normal(corner.shape)
        light = photographed_spots(place, rate[inside], width[inside], rng, sensor)
        place, spots.sigma[k, inside] = place_spots(light, sensor)
        spots.pixels[k, inside] = place + corner
    return spots


def _spot_light(
    frame: Frame, points: Array, rig: StereoRig, k: int, sensor: Sensor
) -> Arrays:
    """Electrons (H, W) of each spot in camera k, none where hidden, and its width, px."""
    away = rig.centres[k] - points
    distance = norm(away, axis=-1)
    facing = np.vecdot(normals_from_points(points), away)
    cosine = (facing / distance).clip(0.02, 1)
    rate = frame.intensity.clip(0, 1) * cosine / distance**2
    width = np.hypot(sensor.blur, sensor.beam * rig.matrices[k, 0, 0] / distance)
    peak = rate / TAU / width**2
    rate *= 0.7 * sensor.full_well / np.nanpercentile(peak, 99)
    rate[~visible_from(points, rig.centres[k])] = 0
    return rate, width


class PseudoTruth(NamedTuple):
    """Wrap labels and ranges (H, W) from stereo, and where they are certain."""

    wraps: Numbers  # -1 without a label
    mask: Flags  # True where a pixel is labelled
    range: Array  # m along the scanner's ray, from stereo alone; NaN without a pair of spots
    uncertainty: Array  # standard deviation of that range, m
    depth: Array  # best range, m: by the phase within the labelled wrap; NaN without a label


def truth_from_spots(
    spots: Spots,
    rig: StereoRig,
    *,
    phase: ArrayLike | None = None,
    phase_noise: ArrayLike = 0.0,
    sigmas: float = 3.0,
    draws: Sequence[StereoRig] = (),
) -> PseudoTruth:
    """Wrap map of the spots (H, W) of a scan, where the number of wraps is certain.

    The label is floor(2 f z / c) where ``sigmas`` deviations reach into no other wrap; with a
    measured phase (H, W), rad, the wrap that brings it nearest to the stereo range, where those of
    both fit into half a wrap. ``draws`` are rigs by other noise of calibration: their scatter adds.
    """
    depth, spread = _ranges(spots, rig, draws)
    reach = sigmas * spread
    if phase is None:
        best = depth
        wraps = np.floor((depth - reach) / WRAP)
        sure = wraps == np.floor((depth + reach) / WRAP)
    else:
        seen = np.asarray(phase, float)
        reach = np.hypot(reach, sigmas * np.multiply(phase_noise, WRAP / TAU))
        sure = np.isfinite(seen) & (reach < WRAP / 2)
        wraps = consistent_wrap_count(
            np.nan_to_num(depth), np.nan_to_num(seen), FREQUENCY_SINGLE
        )
        best = depth_from_wraps(seen, wraps, FREQUENCY_SINGLE)
    mask = sure & (wraps >= 0)
    wraps = np.where(mask, wraps, -1).astype(np.int64)
    return PseudoTruth(
        wraps,
        mask,
        depth,
        spread,
        np.where(mask, best, np.nan),
    )


def _ranges(spots: Spots, rig: StereoRig, draws: Sequence[StereoRig]) -> Arrays:
    """Ranges from the scanner, m, and their deviations by noise of spots and calibration."""
    points = rig.triangulate(spots.pixels)
    missed = (spots.pixels - rig.project(points)) / spots.sigma[..., None]
    # chi^2 across the epipolar line: a right pair exceeds 12 in 0.05 % of cases
    points[(missed**2).sum((0, -1)) > 12] = np.nan
    found = norm(points, axis=-1)
    variance = np.zeros(found.shape)
    step = 0.05  # px
    for camera, axis in np.ndindex(2, 2):
        moved = spots.pixels.copy()
        moved[camera, ..., axis] += step
        there = norm(rig.triangulate(moved), axis=-1)
        variance += ((there - found) / step * spots.sigma[camera]) ** 2
    spread = np.sqrt(variance)
    if draws:
        others = [norm(one.triangulate(spots.pixels), axis=-1) for one in draws]
        spread = np.hypot(spread, np.std(others, axis=0, ddof=1))
    return found, spread
