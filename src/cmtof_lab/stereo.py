r"""Stereo supervision (Sec. 6.4, Fig. 9): two cameras triangulate the laser spot of the scan.

A checkerboard calibrates both cameras, the spots of a scan locate the scanner between them, and the
range of each spot gives its wrap count. What the cameras see is simulated; geometry is OpenCV's.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform, Rotation
from scipy.special import ndtr

from cmtof.constants import FREQUENCY_SINGLE, LASER_WAVELENGTH
from cmtof.correlation import TAU, consistent_wrap_count, depth_from_wraps, wrap_length
from cmtof.frame import Frame
from cmtof.pointcloud import mesh_triangles, normals_from_points, points_from_depth
from cmtof.validation import expect
from cmtof_lab.targets import MeshTarget

Array = NDArray[np.floating]

COLUMNS, ROWS, SQUARE = 9, 6, 0.04  # inner corners of the checkerboard; side of a square, m
# those corners (54, 3), m, row by row about the middle of the board
BOARD = SQUARE * (np.mgrid[:COLUMNS, :ROWS, :1].T.reshape(-1, 3) - [4, 2.5, 0])
WINDOW = 11  # side of the window in which a spot is placed, px


@dataclass(frozen=True)
class Sensor:
    """Camera, lens and laser spot, the pixel of Sony's IMX252 (assumed)."""

    shape: tuple[int, int] = (1536, 2048)  # height and width, px
    pitch: float = 3.45e-6  # m
    focal_length: float = 8e-3  # m (Sec. 6.4)
    f_number: float = 4.0  # assumed
    full_well: float = 10_700.0  # electrons
    read_noise: float = 2.9  # electrons
    ambient: float = 5.0  # electrons of other light in a pixel (assumed)
    beam: float = 0.6e-3  # standard deviation of the spot on a surface, m (assumed)
    blur: float = 0.8  # standard deviation of the lens's blur, px (assumed)
    contrast: float = 0.7071  # of speckle on a surface that depolarises (assumed)

    @property
    def speckle(self) -> float:
        r"""Deviation of a spot's centroid by speckle of contrast C, px: C lambda N / (sqrt(2) pi).

        (Dorsch, Haeusler and Herrmann, Applied Optics 33, 1306, 1994, found this limit.)
        """
        grain = LASER_WAVELENGTH * self.f_number / self.pitch
        return self.contrast * grain / float(np.sqrt(2) * np.pi)


SENSOR = Sensor()


@dataclass(frozen=True, eq=False)
class StereoRig:
    """Left and right camera, seen from the scanner between them."""

    matrices: Array  # (2, 3, 3): focal lengths and centres, px
    distortions: Array  # (2, 5): Brown's, in OpenCV's order
    poses: tuple[RigidTransform, RigidTransform]  # from the scanner's frame, m, to each camera's
    shape: tuple[int, int]  # height and width of the images, px

    @property
    def centres(self) -> Array:
        """Places of both cameras (2, 3), m."""
        return np.stack([pose.inv().translation for pose in self.poses])

    def project(self, points: ArrayLike) -> Array:
        """Pixels (2, ..., 2) of points (..., 3), m; NaN behind a camera."""
        import cv2

        points, still = np.asarray(points, float), np.zeros(3)
        seen = np.empty((2, *points.shape[:-1], 2))
        for k, pose in enumerate(self.poses):
            inside = np.ascontiguousarray(pose.apply(points.reshape(-1, 3)))
            inside[~(inside[:, 2] > 0)] = np.nan
            lens = self.matrices[k], self.distortions[k]
            seen[k] = cv2.projectPoints(inside, still, still, *lens)[0].reshape(seen.shape[1:])
        return seen

    def undistorted(self, pixels: ArrayLike, k: int) -> Array:
        """Points (N, 2) on the plane z = 1 of camera k, of its pixels (N, 2)."""
        import cv2

        stop = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 20, 1e-12)
        lens = self.matrices[k], self.distortions[k]
        pixels = np.ascontiguousarray(pixels, float)[:, None]
        return cv2.undistortPoints(pixels, *lens, criteria=stop).reshape(-1, 2)

    def triangulate(self, pixels: ArrayLike) -> Array:
        """Points (..., 3), m, of pairs of pixels (2, ..., 2); NaN without a pair."""
        import cv2

        pixels = np.asarray(pixels, float)
        flat = pixels.reshape(2, -1, 2)
        known = np.isfinite(flat).all(axis=(0, 2))
        points = np.full((flat.shape[1], 3), np.nan)
        if known.any():
            matrices = [pose.as_matrix()[:3] for pose in self.poses]
            planes = [self.undistorted(flat[k, known], k).T for k in (0, 1)]
            found = cv2.triangulatePoints(*matrices, *planes)
            points[known] = np.where(found[2] * found[3] > 0, found[:3] / found[3], np.nan).T
        return points.reshape(*pixels.shape[1:-1], 3)


def simulated_rig(
    *, baseline: float = 0.3, converge: float = 3.0, sensor: Sensor = SENSOR
) -> StereoRig:
    """Rig like Fig. 9a: cameras on either side of the scanner, axes meeting ``converge`` m away."""
    focal, (height, width) = sensor.focal_length / sensor.pitch, sensor.shape
    matrix = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
    turn, half = np.arctan2(baseline / 2, converge), baseline / 2
    left, right = (
        RigidTransform.from_components([s * half, 0, 0], Rotation.from_rotvec([0, -s * turn, 0]))
        for s in (-1, 1)
    )
    bent = np.outer([1.0, 1.05], [-0.09, 0.11, 3e-4, -2e-4, 0.0])
    return StereoRig(np.stack([matrix] * 2), bent, (left.inv(), right.inv()), sensor.shape)


def board_poses(rig: StereoRig, count: int, *, rng: np.random.Generator) -> list[RigidTransform]:
    """Poses of a board about 1.1 m away, tilted by 15 to 40 degrees, whole in both images."""
    poses: list[RigidTransform] = []
    while len(poses) < count:
        tilt, about = rng.uniform(np.deg2rad(15), np.deg2rad(40)), rng.uniform(0, TAU)
        lean = Rotation.from_rotvec([tilt * np.cos(about), tilt * np.sin(about), 0])
        turn = lean * Rotation.from_rotvec([0, 0, rng.uniform(-0.4, 0.4)])
        place = np.append(rng.uniform(-1, 1, 2) * [0.14, 0.10], 1) * rng.uniform(0.9, 1.3)
        pose = RigidTransform.from_components(place, turn)
        outline = rig.project(pose.apply(1.6 * BOARD))
        if ((outline > 0) & (outline < rig.shape[::-1])).all():
            poses.append(pose)
    return poses


def find_corners(image: NDArray[np.uint8]) -> Array:
    """Inner corners (54, 2), px, of the checkerboard in a picture (H, W); ValueError if unseen."""
    import cv2

    found, seen = cv2.findChessboardCornersSB(image, (COLUMNS, ROWS), flags=cv2.CALIB_CB_ACCURACY)
    expect(found, f"a board of {COLUMNS} x {ROWS} corners", "none", "Show it whole.")
    return seen.reshape(-1, 2).astype(float) + 0.5  # OpenCV's centres lie at whole numbers


def calibrate(corners: ArrayLike, shape: tuple[int, int]) -> tuple[StereoRig, float]:
    """Rig in the left camera's frame and a corner's rms residual, px, of corners (2, V, 54, 2)."""
    import cv2

    corners = np.asarray(corners, np.float32)
    expect((views := corners.shape[1]) > 2, "at least 3 views", views, "Show more.")
    board = [BOARD.astype(np.float32)] * views
    lenses = np.eye(3), np.zeros(5), np.eye(3), np.zeros(5)  # it writes into them
    seen = map(list, corners)
    rms, *found = cv2.stereoCalibrate(board, *seen, *lenses, shape[::-1], flags=cv2.CALIB_FIX_K3)
    between = RigidTransform.from_components(found[5].ravel(), Rotation.from_matrix(found[4]))
    distortions = np.stack([found[1].ravel()[:5], found[3].ravel()[:5]])
    poses = (RigidTransform.identity(), between)
    return StereoRig(np.stack([found[0], found[2]]), distortions, poses, shape), rms / 2**0.5


def locate_scanner(rig: StereoRig, pixels: ArrayLike, directions: ArrayLike) -> StereoRig:
    """Rig in the scanner's frame, by resection from spots (2, ..., 2) and their beams (..., 3)."""
    import cv2

    points = rig.triangulate(pixels).reshape(-1, 3)
    beams = np.asarray(directions, float).reshape(-1, 3)
    known = np.isfinite(points).all(-1) & (beams[:, 2] > 0)
    expect(known.sum() > 5, "at least 6 spots", known.sum(), "Scan more of the scene.")
    plane = beams[known, :2] / beams[known, 2:]
    _, turn, shift = cv2.solvePnP(points[known], plane, np.eye(3), np.zeros(4))
    scanner = RigidTransform.from_components(shift.ravel(), Rotation.from_rotvec(turn.ravel()))
    left, right = (pose * scanner.inv() for pose in rig.poses)
    return StereoRig(rig.matrices, rig.distortions, (left, right), rig.shape)


class Spots(NamedTuple):
    """Pixels (2, ..., 2) of spots in both images and their deviations (2, ...), px; NaN: none."""

    pixels: Array
    sigma: Array


def place_spots(windows: ArrayLike, sensor: Sensor) -> tuple[Array, Array]:
    r"""Centres (N, 2) and their standard deviations (N,), px, of the spots in windows (N, S, S).

    The centroid under a Gaussian weight w of width s that moves with it (XWIN of SExtractor):

    .. math:: x \leftarrow x + 2\frac{\sum w I (u - x)}{\sum w I}, \qquad
              \sigma_x = \frac{\sqrt{\sum w^2 (u - x)^2 v}}{\sum w I\,(1 - (u - x)^2/s^2)}.

    Windows hold electrons of variance v. NaN for spots saturated or below six deviations.
    """
    light, width = np.asarray(windows, float), 1.3
    middle = light.shape[-1] / 2
    grid, centre = np.arange(light.shape[-1]) + 0.5, np.full((len(light), 2), middle)
    for _ in range(12):
        x, y = (grid - centre[:, k, None] for k in (0, 1))
        weight = np.exp(-(x[:, None, :] ** 2 + y[:, :, None] ** 2) / 2 / width**2)
        lit = weight * light
        total = np.maximum(lit.sum((1, 2)), 1e-9)
        step = np.stack([(lit.sum(1) * x).sum(1), (lit.sum(2) * y).sum(1)], 1) / total[:, None]
        centre = centre + np.clip(2 * step, -1, 1)
    noise = weight**2 * (np.maximum(light, 0) + sensor.ambient + sensor.read_noise**2)
    slope = np.maximum((lit.sum(1) * (1 - x**2 / width**2)).sum(1), 1e-9)
    sigma = np.hypot(np.sqrt((noise.sum(1) * x**2).sum(1)) / slope, sensor.speckle)
    lost = (total < 6 * np.sqrt(noise.sum((1, 2)))) | (np.abs(centre - middle) > 2).any(1)
    lost |= light.max((1, 2)) >= sensor.full_well - sensor.ambient
    return np.where(lost[:, None], np.nan, centre), np.where(lost, np.nan, sigma)


def visible_from(points: ArrayLike, centre: ArrayLike) -> NDArray[np.bool_]:
    """Points (H, W, 3), m, of a scan that nothing hides from a place (3,), neighbours joined."""
    points = np.asarray(points, float)
    known, faces = np.isfinite(points).all(-1), mesh_triangles(points)
    points = np.nan_to_num(points)
    return known & ~MeshTarget(points.reshape(-1, 3), faces).hidden(points, centre)


def scan_spots(
    frame: Frame, rig: StereoRig, *, rng: np.random.Generator, sensor: Sensor = SENSOR
) -> Spots:
    """Spots (H, W) that both cameras find while a frame with a camera is scanned (simulated).

    Lambertian spots with speckle, shot and read noise; the 99th percentile peaks at 70 % of a well.
    """
    expect(frame.camera is not None, "a frame with a camera", "none", "State fx, fy, cx, cy.")
    points = points_from_depth(frame.depth, frame.camera)
    normals, pixels = normals_from_points(points), rig.project(points)
    spots = Spots(np.full(pixels.shape, np.nan), np.full(pixels.shape[:-1], np.nan))
    for k, centre in enumerate(rig.centres):
        away = centre - points
        distance = np.linalg.norm(away, axis=-1)
        cosine = np.clip((normals * away).sum(-1) / distance, 0.02, 1)
        rate = np.clip(frame.intensity, 0, 1) * cosine / distance**2
        width = np.hypot(sensor.blur, sensor.beam * rig.matrices[k, 0, 0] / distance)
        rate *= 0.7 * sensor.full_well / np.nanpercentile(rate / TAU / width**2, 99)
        rate[~visible_from(points, centre)] = 0
        inside = ((pixels[k] > WINDOW) & (pixels[k] < np.array(rig.shape[::-1]) - WINDOW)).all(-1)
        corner = np.floor(pixels[k][inside]) - WINDOW // 2
        true = pixels[k][inside] - corner + sensor.speckle * rng.standard_normal(corner.shape)
        edges = (np.arange(WINDOW + 1) - true[..., None]) / width[inside][:, None, None]
        across, down = np.moveaxis(np.diff(ndtr(edges), axis=-1), 1, 0)
        mean = rate[inside][:, None, None] * down[:, :, None] * across[:, None, :] + sensor.ambient
        drawn = rng.poisson(mean) + sensor.read_noise * rng.standard_normal(mean.shape)
        light = np.minimum(drawn, sensor.full_well) - sensor.ambient
        place, spots.sigma[k, inside] = place_spots(light, sensor)
        spots.pixels[k, inside] = place + corner
    return spots


class PseudoTruth(NamedTuple):
    """Labels (H, W) from stereo."""

    wraps: NDArray[np.int64]  # -1 without a label
    mask: NDArray[np.bool_]  # True where a pixel is labelled
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
    found, spread = _ranges(spots, rig)
    if draws:
        others = [np.linalg.norm(one.triangulate(spots.pixels), axis=-1) for one in draws]
        spread = np.hypot(spread, np.std(others, axis=0, ddof=1))
    wrap = float(wrap_length(FREQUENCY_SINGLE))
    known = np.isfinite(found + spread)
    safe, reach = np.where(known, found, 0.0), np.where(known, sigmas * spread, np.inf)
    if phase is None:
        wraps, depth = np.floor(safe / wrap).astype(np.int64), safe
        sure = np.floor((safe - reach) / wrap) == np.floor((safe + reach) / wrap)
    else:
        phase = np.asarray(phase, float)
        wraps = consistent_wrap_count(safe, np.nan_to_num(phase), FREQUENCY_SINGLE)
        depth = depth_from_wraps(phase, wraps, FREQUENCY_SINGLE)
        own = sigmas * np.asarray(phase_noise) * wrap / TAU
        sure = np.isfinite(phase) & (np.hypot(reach, own) < wrap / 2)
    mask = known & sure & (wraps >= 0)
    wraps, depth = np.where(mask, wraps, -1), np.where(mask, depth, np.nan)
    return PseudoTruth(wraps, mask, found, spread, depth)


def _ranges(spots: Spots, rig: StereoRig) -> tuple[Array, Array]:
    """Ranges from the scanner, m, and their standard deviations by the spots' noise."""
    points = rig.triangulate(spots.pixels)
    missed = ((spots.pixels - rig.project(points)) / spots.sigma[..., None]) ** 2
    # chi^2 across the epipolar line: a right pair exceeds 12 in 0.05 % of cases
    points[missed.sum((0, -1)) > 12] = np.nan
    found, variance, step = np.linalg.norm(points, axis=-1), 0.0, 0.05
    for index in np.ndindex(2, 2):
        moved = spots.pixels.copy()
        moved[index[0], ..., index[1]] += step
        slope = (np.linalg.norm(rig.triangulate(moved), axis=-1) - found) / step
        variance = variance + (slope * spots.sigma[index[0]]) ** 2
    return found, np.sqrt(variance)
