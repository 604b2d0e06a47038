"""A checkerboard: its corners, its picture in a camera (simulated), and its corners found again.

An inner corner of a checkerboard is a saddle of the image, which survives blur and slant and has no
shift from either, unlike the edge of a blob. It is found by the Hessian's determinant and refined
by the saddle of a fitted paraboloid (Lucchese and Mitra 2002, "Using saddle points for subpixel
feature detection in camera calibration targets").
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.stereo.camera import PinholeCamera
from cmtof.stereo.pose import Pose, rotation_from_vector

Array = NDArray[np.floating]


@dataclass(frozen=True)
class Board:
    """A checkerboard by its inner corners.

    One side has an odd, the other an even number of them, so that it looks different upside down.

    Attributes
    ----------
    rows, columns : int
        Inner corners.
    square : float
        Side of a square, m.

    Raises
    ------
    ValueError
        If the board is too small, or looks the same when it is turned by half a turn.
    """

    rows: int = 6
    columns: int = 9
    square: float = 0.04

    def __post_init__(self) -> None:
        odd = (self.rows + self.columns) % 2 == 1
        if min(self.rows, self.columns) < 3 or not odd or not self.square > 0:
            raise ValueError(
                f"Expected a board of at least 3 x 4 corners, one side odd, one even, and squares "
                f"above 0 m, got {self.rows} x {self.columns} of {self.square} m. Take another."
            )

    @property
    def corners(self) -> Array:
        """Inner corners (rows * columns, 3), m, row by row; z = 0, the middle of all at 0."""
        y, x = np.indices((self.rows, self.columns)).reshape(2, -1)
        middle = (self.columns - 1) / 2, (self.rows - 1) / 2
        return self.square * np.stack([x - middle[0], y - middle[1], np.zeros(x.shape)], -1)

    def brightness(self, places: ArrayLike) -> Array:
        """Reflectance (...) at places (..., 2), m, on the board: 0.05, 0.9, and a white margin."""
        places = np.asarray(places, float) / self.square
        x = places[..., 0] + (self.columns + 1) / 2
        y = places[..., 1] + (self.rows + 1) / 2
        on = (x >= 0) & (x < self.columns + 1) & (y >= 0) & (y < self.rows + 1)
        dark = on & ((np.floor(x) + np.floor(y)) % 2 == 0)
        return np.where(dark, 0.05, 0.9)

    def poses(self, count: int, *, rng: np.random.Generator, distance: float = 1.0) -> list[Pose]:
        """Draw poses in which a board may be held before a camera, as one does for calibration.

        Parameters
        ----------
        count : int
        rng : Generator
        distance : float
            About how far away, m; it varies by a fifth, the tilt is 15 to 40 degrees.
        """
        return [self._held(rng, distance) for _ in range(count)]

    def _held(self, rng: np.random.Generator, distance: float) -> Pose:
        tilt, about = rng.uniform(np.deg2rad(15), np.deg2rad(40)), rng.uniform(0, 2 * np.pi)
        turn = rotation_from_vector([0, 0, rng.uniform(-0.4, 0.4)])
        lean = rotation_from_vector(tilt * np.array([np.cos(about), np.sin(about), 0]))
        away = distance * rng.uniform(0.8, 1.2)
        aside = rng.uniform(-1, 1, 2) * np.array([0.14, 0.10]) * away
        return Pose(lean @ turn, np.array([*aside, away]))


def board_image(
    board: Board,
    camera: PinholeCamera,
    pose: Pose,
    *,
    rng: np.random.Generator,
    electrons: float = 6000.0,
    read_noise: float = 3.0,
    blur: float = 0.7,
    finer: int = 3,
) -> Array:
    """Image (H, W), electrons, of a lit board (simulated), with shot and read noise.

    Parameters
    ----------
    board : Board
    camera : PinholeCamera
    pose : Pose
        Of the board in the camera.
    rng : Generator
    electrons : float
        Of a white pixel.
    read_noise : float
        Electrons.
    blur : float
        Standard deviation of the lens's blur, px.
    finer : int
        Samples along each side of a pixel.
    """
    from scipy.ndimage import gaussian_filter

    height, width = camera.shape
    y, x = np.indices((height + 1, width + 1)).astype(float)
    plane = camera.undistorted(np.stack([x, y], -1))
    # the plane z = 1 of the camera to the plane z = 0 of the board
    onto = np.linalg.inv(np.column_stack([pose.rotation[:, :2], pose.translation]))
    places = np.concatenate([plane, np.ones_like(plane[..., :1])], -1) @ onto.T
    places = places[..., :2] / places[..., 2:]
    fine = board.brightness(_between(_between(places, finer, 0), finer, 1))
    whole = fine.reshape(height, finer, width, finer).mean(axis=(1, 3))
    mean = electrons * gaussian_filter(whole, blur, mode="nearest")
    return rng.poisson(mean) + read_noise * rng.standard_normal(mean.shape)


def _between(grid: Array, finer: int, axis: int) -> Array:
    """Values between the lines of a grid along an axis, `finer` of them, by linear interpolation.

    Places on a board bend so little within a pixel that a corner moves by 1e-4 px at most.
    """
    low, high = (
        np.take(grid, r, axis) for r in (range(grid.shape[axis] - 1), range(1, grid.shape[axis]))
    )
    shares = (np.arange(finer) + 0.5) / finer
    between = np.stack([low + share * (high - low) for share in shares], axis + 1)
    shape = list(grid.shape)
    shape[axis] = (grid.shape[axis] - 1) * finer
    return between.reshape(shape)


def find_corners(image: ArrayLike, board: Board, *, smooth: float = 1.5) -> Array:
    """Inner corners (rows * columns, 2), px, in the board's order.

    Parameters
    ----------
    image : array_like, shape (H, W)
    board : Board
        All of it must be seen.
    smooth : float
        Standard deviation of the smoothing before derivatives are taken, px.

    Raises
    ------
    ValueError
        If the corners of the whole board do not show.
    """
    from scipy.ndimage import gaussian_filter
    from skimage.feature import peak_local_max

    image = np.asarray(image, float)
    count = board.rows * board.columns
    orders = ((2, 0), (1, 1), (0, 2))
    yy, xy, xx = (gaussian_filter(image, smooth, order=o) for o in orders)  # type: ignore[arg-type]
    saddle = xy**2 - xx * yy  # positive where the image bends up one way and down the other
    border = int(4 * smooth) + 1
    peaks = peak_local_max(saddle, min_distance=int(3 * smooth), num_peaks=3 * count)
    kept = (peaks >= border) & (peaks < np.array(saddle.shape) - border)
    peaks = peaks[kept.all(axis=1)]
    strength = saddle[tuple(peaks.T)]
    if len(peaks) < count or strength[count - 1] < 0.1 * strength[0]:
        shown = int((strength > 0.1 * strength[0]).sum()) if len(peaks) else 0
        raise ValueError(_unseen(board, shown))
    smoothed = gaussian_filter(image, smooth)
    refined = np.array([_saddle_point(smoothed, peak, border) for peak in peaks[:count]])
    return _ordered(refined, board, smoothed)


def _unseen(board: Board, found: int) -> str:
    return (
        f"Expected {board.rows * board.columns} corners of a board of {board.rows} x "
        f"{board.columns}, got {found}. Show the whole board, sharp and evenly lit."
    )


def _saddle_point(image: Array, peak: Array, reach: int) -> Array:
    """Saddle (x, y), px, of the paraboloid that fits the image around a peak (row, column)."""
    row, column = peak
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1].reshape(2, -1).astype(float)
    patch = image[row - reach : row + reach + 1, column - reach : column + reach + 1].ravel()
    # the paraboloid holds near the saddle only, so what is near counts most
    weight = np.exp(-(x**2 + y**2) / (reach / 2) ** 2 / 2)
    terms = np.stack([x**2, x * y, y**2, x, y, np.ones_like(x)], -1)
    a, b, c, d, e, _ = np.linalg.lstsq(terms * weight[:, None], patch * weight, rcond=None)[0]
    offset = np.linalg.solve([[2 * a, b], [b, 2 * c]], [-d, -e])
    return np.array([column, row]) + 0.5 + np.clip(offset, -reach, reach)


def _ordered(found: Array, board: Board, image: Array) -> Array:
    """Corners in the board's order, by the projective map of its four outermost."""
    from scipy.spatial import ConvexHull

    from cmtof.stereo.homography import homography_from_points, mapped

    ideal = board.corners[:, :2]
    hull = found[ConvexHull(found).vertices]
    # a distorted outline has many vertices; its four corners span the largest quadrilateral
    choices = np.array(list(combinations(range(len(hull)), 4)))
    x, y = np.moveaxis(hull[choices], -1, 0)
    area = np.abs((x * np.roll(y, -1, 1) - y * np.roll(x, -1, 1)).sum(1))
    four = hull[choices[area.argmax()]]
    c, r = board.columns, board.rows
    outer = ideal[[0, c - 1, r * c - 1, (r - 1) * c]]
    for turn in range(4):
        for ring in (four, four[::-1]):
            onto = homography_from_points(outer, np.roll(ring, turn, axis=0))
            guess = mapped(onto, ideal)
            # seen from the front a board keeps its handedness
            if np.linalg.det(onto[:2, :2] / onto[2, 2]) <= 0:
                continue
            order = _nearest(guess, found)
            if order is not None and _first_is_dark(image, onto, board):
                return found[order]
    raise ValueError(_unseen(board, len(found)))


def _nearest(guess: Array, found: Array) -> NDArray[np.intp] | None:
    """Which corner each guess means; None if two mean the same, or one is far from all."""
    distance = np.linalg.norm(guess[:, None] - found[None], axis=-1)
    order = distance.argmin(axis=1)
    between = np.sort(np.linalg.norm(found[:, None] - found[None], axis=-1), axis=1)[:, 1]
    near = distance[np.arange(len(guess)), order] < 0.4 * between[order]
    return order if near.all() and len(set(order.tolist())) == len(order) else None


def _first_is_dark(image: Array, onto: Array, board: Board) -> bool:
    """Whether the square outside the first corner is darker than its neighbour."""
    from cmtof.stereo.homography import mapped

    first = board.corners[0, :2]
    half = board.square / 2
    places = mapped(onto, first + np.array([[-half, -half], [half, -half]]))
    columns, rows = np.clip(places.astype(int), 0, np.array(image.shape[::-1]) - 1).T
    dark, light = image[rows, columns]
    return bool(dark < light)
