"""Surfaces that a reader can turn: their points for the viewer of the book's pages, and a still.

PyVista draws in a process of its own, off screen: without a working OpenGL it may crash, and then
only there.
"""

import html
import json
import os
import sys
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.files import written_whole
from cmtof.pointcloud import mesh_triangles
from cmtof.types import Array
from cmtof_book import provenance

STATIC = "_static/scenes"  # where `cmtof_book.stage` puts the files
LIGHTS = {(-0.5, -0.6, -0.1): 0.75, (0.6, -0.1, 0.0): 0.35}
"""Where the lamps of a still stand, and how bright they are."""


def save_scene(
    name: str, layers: Mapping[str, tuple[Array, Array]], *, longest: float, eye: tuple
) -> None:
    """Write surfaces, points and colours by what they show, to ``name.js``, seen as in `still`."""
    shape = next(iter(layers.values()))[0].shape[:2]
    packed = {
        label: [
            provenance.letters(points.astype("<f4").tobytes()),
            provenance.letters(_levels(np.nan_to_num(colours)).tobytes()),
        ]
        for label, (points, colours) in layers.items()
    }
    about = {"shape": shape, "longest": longest, "eye": eye, "layers": packed}
    with written_whole(provenance.output_folder() / f"{name}.js") as part:
        part.write_text(f"cmtofScene({json.dumps(name)}, {json.dumps(about)});\n", "utf-8")


def _levels(colours: Array) -> NDArray[np.uint8]:
    """Colours from 0 to 1 in levels of a byte."""
    return np.rint(255 * np.clip(colours, 0, 1)).astype(np.uint8)


def show_scene(name: str, *, title: str) -> None:
    """Put a saved scene on the page of the book, folded until it is opened."""
    from IPython.display import HTML, display

    block = f'<details class="scene" data-scene="{name}"><summary>Turn it: {html.escape(title)}'
    display(HTML(f"{block}</summary><p>The page of the book draws it here.</p></details>"))


def still(points: ArrayLike, colours: ArrayLike, *, longest: float, eye: tuple) -> Array | None:
    """Shaded still (h, w, 3), 0 to 1, of a surface, cropped to it; None without OpenGL.

    Points (H, W, 3), m, are x right, y down, z forward, NaN for none; colours (H, W, 3) are 0 to 1.
    Neighbours further apart than ``longest``, m, are not joined; ``eye`` (3,), m, is where the
    surface is seen from.
    """
    used, faces = np.unique(mesh_triangles(points, longest=longest), return_inverse=True)
    chosen = (np.reshape(values, (-1, 3))[used] for values in (points, colours))
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        try:
            return pool.submit(_drawn, *chosen, faces.reshape(-1, 3), eye).result()
        except BrokenProcessPool:
            print("No still: OpenGL is missing (apt-get install libegl1 libgl1).", file=sys.stderr)
            return None


def _drawn(points: Array, colours: Array, faces: NDArray, eye: tuple) -> Array:
    """Draw what `still` describes; runs in its own process."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # VTK's complaints about a missing screen
    import pyvista as pv

    mesh = pv.PolyData.from_regular_faces(points, faces)
    plotter = pv.Plotter(off_screen=True, window_size=[900, 900], lighting="none")
    plotter.renderer.SetBackground(1, 1, 1)
    plotter.add_mesh(
        mesh,
        scalars=_levels(colours),
        rgb=True,
        smooth_shading=True,
        ambient=0.25,
        diffuse=0.8,
        specular=0.25,
        specular_power=12,
    )
    centre = 0.5 * (points.min(0) + points.max(0))
    for place, strength in LIGHTS.items():
        plotter.add_light(pv.Light(position=place, focal_point=centre, intensity=strength))
    plotter.camera_position = [list(eye), centre.tolist(), (0.0, -1.0, 0.0)]
    plotter.enable_anti_aliasing("ssaa")
    return _cropped(np.asarray(plotter.screenshot(None, return_img=True))) / 255


def _cropped(image: NDArray) -> NDArray:
    """A picture without its empty margins."""
    drawn = np.nonzero((image < 250).any(axis=-1))
    return image[tuple(slice(along.min(), along.max() + 1) for along in drawn)]
