"""Depth to points in space, and to a PLY file that any viewer opens."""

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.files import written_whole
from cmtof.scenes.frame import ray_lengths, rays_from_camera


def points_from_depth(depth: ArrayLike, camera: ArrayLike) -> NDArray[np.float64]:
    """Points (H, W, 3), m, of ranges along the rays; x right, y down, z forward.

    Parameters
    ----------
    depth : array_like, shape (H, W)
        Range along the ray, m; NaN stays NaN.
    camera : array_like, shape (4,) or (5,)
        fx, fy, cx, cy, px, pixel centres at +0.5.

    Examples
    --------
    >>> points_from_depth([[2.0]], [1.0, 1.0, 0.5, 0.5]).ravel().tolist()
    [0.0, 0.0, 2.0]
    """
    depth = np.asarray(depth, float)
    rays = rays_from_camera(depth.shape, camera)
    return rays * (depth / ray_lengths(depth.shape, camera))[..., None]


def normals_from_points(points: ArrayLike) -> NDArray[np.float64]:
    """Unit normals (H, W, 3) towards the scanner, from neighbouring points.

    Beside a hole no neighbour tells the slope: there, as if it faced the scanner.

    Parameters
    ----------
    points : array_like, shape (H, W, 3)
        m, from the scanner; NaN for none.

    Examples
    --------
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
    path: str | Path,
    depth: ArrayLike,
    camera: ArrayLike,
    *,
    brightness: ArrayLike,
    confidence: ArrayLike,
) -> int:
    """Write the finite pixels as a binary PLY point cloud; return their number.

    Each vertex has ``x y z`` (float, m), ``red green blue`` (uchar, a grey of the brightness,
    99th percentile white, gamma 2.2) and ``confidence`` (float).

    Parameters
    ----------
    depth, brightness, confidence : array_like, shape (H, W)
        Range, m (NaN is left out); linear brightness, any unit; probability.
    camera : array_like, shape (4,) or (5,)
        fx, fy, cx, cy, px.
    """
    points = points_from_depth(depth, camera)
    kept = np.isfinite(points).all(axis=-1)
    light = np.asarray(brightness, float)[kept]
    white = np.percentile(light, 99) if light.size else 1.0
    grey = 255 * np.clip(light / max(float(white), 1e-12), 0, 1) ** (1 / 2.2)
    layout = [(axis, "<f4") for axis in "xyz"]
    layout += [(colour, "u1") for colour in ("red", "green", "blue")] + [("confidence", "<f4")]
    vertices = np.empty(int(kept.sum()), layout)
    for i, axis in enumerate("xyz"):
        vertices[axis] = points[kept][:, i]
    for colour in ("red", "green", "blue"):
        vertices[colour] = grey.astype(np.uint8)
    vertices["confidence"] = np.asarray(confidence)[kept]
    names = {"<f4": "float", "u1": "uchar"}
    properties = "".join(f"property {names[kind]} {name}\n" for name, kind in layout)
    header = (
        "ply\nformat binary_little_endian 1.0\ncomment range in metres, x right, y down\n"
        f"element vertex {vertices.size}\n{properties}end_header\n"
    )
    with written_whole(path) as part:
        part.write_bytes(header.encode("ascii") + vertices.tobytes())
    return vertices.size


def mesh_triangles(points: ArrayLike, *, longest: float = np.inf) -> NDArray[np.int64]:
    """Triangles (T, 3) between neighbouring pixels of a map of points (H, W, 3), m; NaN for none.

    Longer sides than ``longest``, m, bridge an edge and are left out.
    """
    points = np.asarray(points, float)
    number = np.arange(points[..., 0].size).reshape(points.shape[:2])
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    triangles = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, c, b), (b, c, d))])
    corners = points.reshape(-1, 3)[triangles]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1)
    return triangles[(sides < longest).all(axis=1)]  # false for NaN as well
