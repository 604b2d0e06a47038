"""Surfaces that a reader can turn: one self-contained HTML file, and a still of the same view.

PyVista draws in a process of its own, off screen: without a working OpenGL it may crash, and then
only there. Its trame component writes the file, with viewer and data in it.
"""

import html
import os
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.book import provenance
from cmtof.files import written_whole
from cmtof.pointcloud import mesh_triangles

Array = NDArray[np.float64]

STATIC = "_static/scenes"  # where `tools/stage.py` puts the files, in the book
_MOST_POINTS = 20_000  # of a file; denser maps lose rows and columns


def save_scene(
    name: str, points: Array, colours: Array, *, title: str, longest: float, eye: tuple
) -> Array | None:
    """Write a surface as ``name.html``, below 3 MB, beside the run's figures; return its `still`.

    Without OpenGL that is None, with a line on stderr.
    """
    step = int(np.ceil(np.sqrt(points[..., 0].size / _MOST_POINTS)))
    every = (slice(None, None, step),) * 2
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "scene.html"
        drawn = still(points[every], colours[every], longest=step * longest, eye=eye, page=page)
        text = page.read_text("utf-8")
    # the viewer's page gets its own title; the icons that it would fetch are left out
    icons = "https://kitware.github.io/vtk-js/icon/favicon-${t}x${t}.png"
    named = "<title>VTK.js | Example - OfflineLocalView</title>"
    text = text.replace(icons, "data:,").replace(named, f"<title>{html.escape(title)}</title>")
    with written_whole(provenance.output_folder() / f"{name}.html") as part:
        part.write_text(text, encoding="utf-8")
    if drawn is None:
        print("No still: OpenGL is missing (apt-get install libegl1 libgl1).", file=sys.stderr)
    return drawn


def show_scene(name: str, *, title: str) -> None:
    """Put a saved scene on the notebook's page, folded until it is opened."""
    from IPython.display import HTML, display

    source, words = f"../{STATIC}/{name}.html", html.escape(title)
    block = (
        f'<details class="scene"><summary>Turn it: {words}</summary>\n'
        f'<iframe loading="lazy" title="{words}, interactive" src="{source}"></iframe>\n'
        f'<p>Drag to turn, pinch or scroll to zoom. <a href="{source}">Open it on a page of its '
        "own</a>.</p></details>"
    )
    display(HTML(block))


def still(
    points: ArrayLike, colours: ArrayLike, *, longest: float, eye: tuple, page: Path | None = None
) -> Array | None:
    """Shaded still (h, w, 3), 0 to 1, of a surface, cropped to it; None where none can be drawn.

    Points (H, W, 3), m, are x right, y down, z forward, NaN for none; colours (H, W, 3) are 0 to 1.
    Neighbours further apart than ``longest``, m, are not joined; ``eye`` (3,), m, is where the
    surface is seen from; ``page`` is an HTML file to write, which needs no OpenGL.
    """
    used, faces = np.unique(mesh_triangles(points, longest=longest), return_inverse=True)
    chosen = (np.reshape(values, (-1, 3))[used] for values in (points, colours))
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        try:
            return pool.submit(_drawn, *chosen, faces.reshape(-1, 3), eye, page).result()
        except BrokenProcessPool:
            return None


def _drawn(points: Array, colours: Array, faces: NDArray, eye: tuple, page: Path | None) -> Array:
    """Draw what `still` describes; runs in its own process."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # VTK's complaints about a missing screen
    import pyvista as pv

    mesh = pv.PolyData.from_regular_faces(points, faces)
    mesh["colours"] = np.rint(255 * colours).astype(np.uint8)
    plotter = pv.Plotter(off_screen=True, window_size=[900, 900], lighting="none")
    plotter.renderer.SetBackground(1, 1, 1)
    look = {"ambient": 0.25, "diffuse": 0.8, "specular": 0.25, "specular_power": 12}
    plotter.add_mesh(mesh, scalars="colours", rgb=True, smooth_shading=True, **look)
    centre = 0.5 * (points.min(0) + points.max(0))
    for place, strength in (((-0.5, -0.6, -0.1), 0.75), ((0.6, -0.1, 0.0), 0.35)):
        plotter.add_light(pv.Light(position=place, focal_point=centre, intensity=strength))
    plotter.camera_position = [list(eye), centre.tolist(), (0.0, -1.0, 0.0)]
    if page:  # first: without OpenGL the still ends this process
        plotter.trame.export_html(str(page))
    plotter.enable_anti_aliasing("ssaa")
    image = np.asarray(plotter.screenshot(None, return_img=True))
    drawn = np.argwhere((image < 250).any(axis=-1))
    (top, left), (bottom, right) = drawn.min(0), drawn.max(0) + 1  # without the empty margins
    return image[top:bottom, left:right] / 255
