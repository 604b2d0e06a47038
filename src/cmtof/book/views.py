"""Surfaces that a reader can turn: one self-contained HTML file, and a still of the same view.

PyVista's trame component writes the file: viewer and data lie in it, and nothing is loaded from
elsewhere. PyVista draws in a process of its own, off screen: without a working OpenGL it may crash,
and then only there.
"""

import html
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.book import provenance
from cmtof.files import written_whole

Array = NDArray[np.float64]

MOST_BYTES = 3_000_000
"""Size that a scene's file must stay below."""

MOST_POINTS = 20_000
"""Points of a scene at most; denser maps lose rows and columns."""

STATIC = "_static/scenes"
"""Where the book keeps the files, relative to its root; `tools/stage.py` puts them there."""

NO_STILL = (
    "No still could be drawn: OpenGL is missing (Debian: apt-get install libegl1 libgl1). "
    "The interactive scene is whole."
)


def save_scene(
    name: str,
    points: ArrayLike,
    colours: ArrayLike,
    *,
    title: str,
    longest: float,
    eye: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Array | None:
    """Write a surface as ``name.html`` beside the run's figures, and return a still of it.

    Points (H, W, 3) in m are x right, y down, z forward, NaN for none; colours (H, W, 3) red, green
    and blue, 0 to 1. Neighbours further apart than ``longest``, m, are not joined; ``eye`` is where
    the surface is seen from at first. The still (h, w, 3) is cropped to the surface; without OpenGL
    it is None, with a line on stderr. Raises ValueError if the file would be too large, and
    RuntimeError if PyVista or trame is missing.
    """
    points, colours = np.asarray(points, float), np.asarray(colours, float)
    step = int(np.ceil(np.sqrt(points[..., 0].size / MOST_POINTS)))
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "scene.html"
        drawn = still(
            points[::step, ::step],
            colours[::step, ::step],
            longest=step * longest,
            eye=eye,
            page=page,
        )
        if not page.is_file():
            raise RuntimeError(
                "Expected PyVista and trame to write a scene, got none. "
                "Install them: pip install pyvista trame-pyvista."
            )
        _write(provenance.output_folder() / f"{name}.html", page.read_text("utf-8"), title)
    if drawn is None:
        print(NO_STILL, file=sys.stderr)
    return drawn


def show_scene(name: str, *, title: str) -> None:
    """Put a saved scene on the notebook's page, folded until it is opened."""
    from IPython.core.display import HTML
    from IPython.display import display

    display(HTML(scene_block(name, title=title)))


def scene_block(name: str, *, title: str) -> str:
    """HTML by which a page of the book's folder ``notebooks`` shows a scene."""
    source, words = f"../{STATIC}/{name}.html", html.escape(title)
    return (
        f'<details class="scene"><summary>Turn it: {words}</summary>\n'
        f'<iframe loading="lazy" title="{words}, interactive" src="{source}"></iframe>\n'
        f'<p>Drag to turn, pinch or scroll to zoom. <a href="{source}">Open it on a page of its '
        "own</a>.</p></details>"
    )


def depth_colours(depth: ArrayLike, *, limits: tuple[float, float], cmap: str) -> Array:
    """Colours (H, W, 3), 0 to 1, of a map of depths (H, W), m, between two limits."""
    import matplotlib as mpl

    low, high = limits
    share = np.clip((np.nan_to_num(np.asarray(depth, float)) - low) / (high - low), 0, 1)
    return np.asarray(mpl.colormaps[cmap](share))[..., :3]


def mesh_triangles(points: ArrayLike, *, longest: float) -> NDArray[np.int64]:
    """Triangles (T, 3) between neighbouring pixels of a map of points (H, W, 3), m; NaN for none.

    Longer sides than ``longest``, m, bridge an edge and are left out.
    """
    points = np.asarray(points, float)
    number = np.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    triangles = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, c, b), (b, c, d))])
    corners = points.reshape(-1, 3)[triangles]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1)
    return triangles[(sides < longest).all(axis=1)]  # false for NaN as well


def still(
    points: ArrayLike,
    colours: ArrayLike,
    *,
    longest: float,
    eye: tuple[float, float, float],
    page: Path | None = None,
) -> Array | None:
    """Shaded still (h, w, 3), 0 to 1, of a surface, cropped to it; None where none can be drawn.

    Parameters as in `save_scene`; ``page`` is an HTML file to write, which needs no OpenGL.
    """
    import matplotlib.pyplot as plt

    triangles = mesh_triangles(points, longest=longest)
    used, faces = np.unique(triangles, return_inverse=True)
    with tempfile.TemporaryDirectory() as folder:
        job, target = Path(folder) / "job.npz", Path(folder) / "still.png"
        np.savez(
            job,
            points=np.asarray(points, float).reshape(-1, 3)[used],
            faces=faces.reshape(-1, 3),
            colours=np.rint(255 * np.asarray(colours, float).reshape(-1, 3)[used]).astype(np.uint8),
            eye=eye,
            page=str(page or ""),
        )
        command = [sys.executable, "-m", "cmtof.book.views", str(job), str(target)]
        try:
            subprocess.run(command, capture_output=True, check=True, timeout=120)
            return np.asarray(plt.imread(target), float)[..., :3]
        except (OSError, subprocess.SubprocessError):
            return None


def _draw(job: Path, target: Path) -> None:
    """Draw what `still` stored; runs in its own process."""
    import matplotlib.pyplot as plt
    import pyvista as pv

    held = np.load(job)
    mesh = pv.PolyData.from_regular_faces(held["points"], held["faces"])
    mesh["colours"] = held["colours"]
    plotter = pv.Plotter(off_screen=True, window_size=[900, 900], lighting="none")
    plotter.renderer.SetBackground(1, 1, 1)
    look = {"ambient": 0.25, "diffuse": 0.8, "specular": 0.25, "specular_power": 12}
    plotter.add_mesh(mesh, scalars="colours", rgb=True, smooth_shading=True, **look)
    centre = 0.5 * (held["points"].min(0) + held["points"].max(0))
    for place, strength in (((-0.5, -0.6, -0.1), 0.75), ((0.6, -0.1, 0.0), 0.35)):
        plotter.add_light(pv.Light(position=place, focal_point=centre, intensity=strength))
    plotter.camera_position = [held["eye"].tolist(), centre.tolist(), (0.0, -1.0, 0.0)]
    if held["page"]:  # first: without OpenGL the still ends this process
        plotter.trame.export_html(str(held["page"]))
    plotter.enable_anti_aliasing("ssaa")
    image = np.asarray(plotter.screenshot(None, return_img=True))
    drawn = np.argwhere((image < 250).any(axis=-1))
    (top, left), (bottom, right) = drawn.min(0), drawn.max(0) + 1  # without the empty margins
    plt.imsave(target, image[top:bottom, left:right])


def _write(target: Path, text: str, title: str) -> None:
    """Store the viewer's page under its own title; the icons it would fetch are left out."""
    icons = "https://kitware.github.io/vtk-js/icon/favicon-${t}x${t}.png"
    named = "<title>VTK.js | Example - OfflineLocalView</title>"
    text = text.replace(icons, "data:,").replace(named, f"<title>{html.escape(title)}</title>")
    size = len(text.encode())
    if size >= MOST_BYTES:
        raise ValueError(
            f"Expected a scene below {MOST_BYTES / 1e6:g} MB, got {size / 1e6:.1f} MB. "
            "Lower MOST_POINTS."
        )
    with written_whole(target) as part:
        part.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    _draw(Path(sys.argv[1]), Path(sys.argv[2]))
