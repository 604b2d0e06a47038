"""Surfaces of a raster scan: the wall behind everything, a mesh, and a still of it.

A scan whose angles were not kept still shows a flat wall, and a wall's range tells the angles:
``r = |ray| / (a + b u + c v)`` with ``ray = (u, v, 1)`` in units of the focal length.
"""

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.files import written_whole

Array = NDArray[np.float64]

RENDER_SECONDS = 120
"""How long a still may take before it is given up, s."""


class Wall(NamedTuple):
    """The flat wall that a scan sees behind its objects."""

    depth: Array
    """Range of the fitted wall (H, W), m."""
    mask: NDArray[np.bool_]
    """True where the scan lies on it, (H, W)."""
    camera: Array
    """fx, fy, cx, cy that the wall's bend tells, px; pixel centres at +0.5."""


def fit_wall(depth: ArrayLike, *, tolerance: float = 0.01) -> Wall:
    """Fit a flat wall, and the scan's angles, to what lies farthest in a range image.

    Ranges in front of the wall are objects: they first weigh little, then nothing once they
    lie further than ``tolerance`` off.

    Parameters
    ----------
    depth : array_like, shape (H, W)
        Range along the ray, m, all finite.
    tolerance : float
        Greatest distance from the wall, m, that still belongs to it.

    Raises
    ------
    ValueError
        If the image is not two-dimensional or holds anything but positive ranges.

    Examples
    --------
    >>> y, x = (np.mgrid[:40, :40] + 0.5 - 20) / 100  # a scan with a focal length of 100 px
    >>> wall = fit_wall(0.7 * np.sqrt(1 + x**2 + y**2) / (1 + 0.1 * x))
    >>> round(float(wall.camera[0]), 3), bool(wall.mask.all())
    (100.0, True)
    """
    from scipy.optimize import least_squares

    depth = np.asarray(depth, float)
    if depth.ndim != 2 or not (np.isfinite(depth).all() and depth.min() > 0):
        raise ValueError(
            f"Expected a range image (H, W) of positive metres, got shape {depth.shape}. "
            "Fill or crop its holes."
        )
    height, width = depth.shape
    y, x = np.mgrid[:height, :width] + 0.5
    u, v = (x - width / 2) / width, (y - height / 2) / width

    def wall_depth(q: Array) -> Array:
        return np.sqrt(1 + q[0] ** 2 * (u**2 + v**2)) / (q[1] + q[2] * u + q[3] * v)

    def fitted(q: Array, weight: Array) -> Array:
        return least_squares(lambda q: (weight * (depth - wall_depth(q))).ravel(), q).x

    q = np.array([0.5, 1 / np.percentile(depth, 90), 0.0, 0.0])
    for _ in range(6):  # what lies behind pulls, what lies in front hardly does
        q = fitted(q, np.where(depth > wall_depth(q), 1.0, 0.1))
    for _ in range(6):
        q = fitted(q, np.where(np.abs(depth - wall_depth(q)) < tolerance, 1.0, 0.0))
    focal = width / abs(q[0])
    near = np.abs(depth - wall_depth(q)) < tolerance
    return Wall(wall_depth(q), near, np.array([focal, focal, width / 2, height / 2]))


def mesh_triangles(points: ArrayLike, *, longest: float) -> NDArray[np.int64]:
    """Triangles (T, 3) between neighbouring pixels of a map of points, cut open at edges.

    Parameters
    ----------
    points : array_like, shape (H, W, 3)
        m; NaN where there is none.
    longest : float
        Greatest side of a triangle, m: longer ones bridge an edge.
    """
    points = np.asarray(points, float)
    number = np.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    triangles = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, c, b), (b, c, d))])
    corners = points.reshape(-1, 3)[triangles]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1)
    return triangles[(sides < longest).all(axis=1)]  # false for NaN as well


def render_surface(
    points: ArrayLike,
    values: ArrayLike,
    path: Path,
    *,
    longest: float,
    eye: tuple[float, float, float],
    cmap: str = "cividis",
    size: tuple[int, int] = (1400, 1400),
    html: Path | None = None,
) -> bool:
    """Write a shaded still of a surface as PNG, cropped to it; tell whether one could be drawn.

    PyVista draws in a process of its own, off screen: without a working OpenGL it may crash, and
    then only there.

    Parameters
    ----------
    points : array_like, shape (H, W, 3)
        m, x right, y down, z forward.
    values : array_like, shape (H, W) or (H, W, 3)
        What the colours show, the 1st to 99th percentile spans the colour map; or RGB, 0 to 1.
    path : Path
        PNG file.
    longest : float
        See `mesh_triangles`, m.
    eye : tuple of float
        Where the surface is seen from, m.
    cmap : str
        Name of a Matplotlib colour map.
    size : tuple of int
        Width and height before it is cropped, px.
    html : Path, optional
        Write the scene there as well, for a browser; that needs no OpenGL.
    """
    values, triangles = np.asarray(values, float), mesh_triangles(points, longest=longest)
    with tempfile.TemporaryDirectory() as folder:
        job, still = Path(folder) / "job.npz", Path(folder) / "still.png"
        np.savez(
            job,
            points=np.nan_to_num(np.asarray(points, float)).reshape(-1, 3),
            triangles=triangles,
            values=values.reshape(-1, *values.shape[2:]),
            eye=eye,
            cmap=cmap,
            size=size,
            html=str(html or ""),
        )
        command = [sys.executable, "-m", "cmtof.book.surface", str(job), str(still)]
        try:
            subprocess.run(command, capture_output=True, check=True, timeout=RENDER_SECONDS)
        except (OSError, subprocess.SubprocessError):
            return False
        if not still.is_file():
            return False
        with written_whole(path) as part:
            part.write_bytes(still.read_bytes())
    return True


def _draw(job: Path, still: Path) -> None:
    """Draw what `render_surface` stored; runs in its own process."""
    import matplotlib.pyplot as plt
    import pyvista as pv

    held = np.load(job)
    used = np.unique(held["triangles"])
    faces = np.searchsorted(used, held["triangles"])
    mesh = pv.PolyData.from_regular_faces(held["points"][used], faces)
    values = held["values"][used]
    coloured = values.ndim == 2
    mesh["values"] = np.rint(255 * values).astype(np.uint8) if coloured else values
    plotter = pv.Plotter(off_screen=True, window_size=held["size"].tolist(), lighting="none")
    plotter.renderer.SetBackground(1, 1, 1)
    plotter.add_mesh(
        mesh,
        scalars="values",
        rgb=coloured,
        cmap=None if coloured else str(held["cmap"]),
        clim=None if coloured else np.percentile(values, [1, 99]).tolist(),
        smooth_shading=True,
        ambient=0.25,
        diffuse=0.8,
        specular=0.25,
        specular_power=12,
        show_scalar_bar=False,
    )
    centre = 0.5 * (held["points"][used].min(0) + held["points"][used].max(0))
    for place, strength in (((-0.5, -0.6, -0.1), 0.75), ((0.6, -0.1, 0.0), 0.35)):
        plotter.add_light(pv.Light(position=place, focal_point=centre, intensity=strength))
    plotter.camera_position = [held["eye"].tolist(), centre.tolist(), (0.0, -1.0, 0.0)]
    if held["html"]:  # first: without OpenGL the still ends this process
        plotter.trame.export_html(str(held["html"]))
    plotter.enable_anti_aliasing("ssaa")
    image = np.asarray(plotter.screenshot(None, return_img=True))
    drawn = np.argwhere((image < 250).any(axis=-1))
    (top, left), (bottom, right) = drawn.min(0), drawn.max(0) + 1  # without the empty margins
    plt.imsave(still, image[top:bottom, left:right])


if __name__ == "__main__":
    _draw(Path(sys.argv[1]), Path(sys.argv[2]))
