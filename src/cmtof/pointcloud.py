"""Depth to points in space, and to a PLY file that any viewer opens."""

import numpy as np
from numpy.typing import ArrayLike

from cmtof.files import AnyPath, atomic_output
from cmtof.frame import ray_lengths, rays_from_camera
from cmtof.types import Array, Numbers

# Header of a point cloud, but for the number of its points.
PLY_HEADER = b"""\
ply
format binary_little_endian 1.0
comment range in metres, x right, y down
element vertex %d
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
property float confidence
end_header
"""


def points_from_depth(depth: ArrayLike, camera: ArrayLike) -> Array:
    """Points (H, W, 3), m, of ranges (H, W) along the rays; x right, y down, z forward.

    ``camera`` is fx, fy, cx, cy in px, pixel centres at +0.5. NaN stays NaN.

    >>> points_from_depth([[2.0]], [1.0, 1.0, 0.5, 0.5]).ravel().tolist()
    [0.0, 0.0, 2.0]
    """
    depth = np.asarray(depth, float)
    rays = rays_from_camera(depth.shape, camera)
    return rays * (depth / ray_lengths(depth.shape, camera))[..., None]


def normals_from_points(points: ArrayLike) -> Array:
    """Unit normals (H, W, 3) towards the scanner from points (H, W, 3), m, NaN where unknown.

    Beside a hole, where no neighbour gives the slope, they face the scanner.

    >>> points = points_from_depth(np.ones((3, 3)), [1e6, 1e6, 1.5, 1.5])
    >>> normals_from_points(points)[1, 1].round(3).tolist()
    [0.0, 0.0, -1.0]
    """
    points = np.asarray(points, float)
    down, right = np.gradient(points, axis=(0, 1))
    normal = np.cross(down, right)
    with np.errstate(all="ignore"):
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    facing = -points / np.linalg.norm(points, axis=-1, keepdims=True)
    normal = np.where(np.isfinite(normal), normal, facing)
    return normal * np.where(np.sum(normal * points, -1, keepdims=True) > 0, -1, 1)


def write_ply(
    path: AnyPath,
    depth: ArrayLike,
    camera: ArrayLike | None,
    *,
    brightness: ArrayLike,
    confidence: ArrayLike,
) -> int:
    """Write the finite pixels as a binary PLY point cloud; return their number.

    Images (H, W): range, m (NaN is left out), linear brightness in any unit, probability. A vertex
    has ``x y z`` (float, m), ``red green blue`` (uchar, a grey of the brightness, 99th percentile
    white, gamma 2.2) and ``confidence`` (float).
    """
    if camera is None:
        raise ValueError(
            "Expected a camera for points, got none. Leave --ply out or add one."
        )
    points = points_from_depth(depth, camera)
    kept = np.isfinite(points).all(axis=-1)
    light = np.nan_to_num(np.asarray(brightness, float)[kept])
    white = np.percentile(light, 99) if light.size else 1.0
    share = np.clip(light / max(white, 1e-12), 0, 1)
    grey = (255 * share ** (1 / 2.2)).astype(np.uint8)
    position = points[kept].T.astype("<f4")
    probability = np.asarray(confidence, "<f4")[kept]
    vertices = np.rec.fromarrays([*position, grey, grey, grey, probability])
    with atomic_output(path) as part:
        part.write_bytes(PLY_HEADER % vertices.size + vertices.tobytes())
    return vertices.size


def mesh_triangles(points: ArrayLike, *, longest: float = np.inf) -> Numbers:
    """Triangles (T, 3), as indices of pixels, between neighbouring points (H, W, 3), m.

    Triangles with a NaN or a side above ``longest``, m, which bridges an edge, are left out.
    """
    points = np.asarray(points, float)
    number = np.arange(points[..., 0].size).reshape(points.shape[:2])
    first = number[:-1, :-1].reshape(-1, 1)  # pixel of each square of four
    below = points.shape[1]
    triangles = np.concatenate(
        [np.add(first, [0, below, 1]), np.add(first, [1, below, below + 1])]
    )
    corners = points.reshape(-1, 3)[triangles]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1)
    return triangles[(sides < longest).all(axis=1)]  # false for NaN as well
