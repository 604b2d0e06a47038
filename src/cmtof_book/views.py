"""Surfaces that a reader can turn: their points for the viewer of the book's pages, and a still."""

import html
import json
import sys
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import to_hex

from cmtof.files import atomic_output
from cmtof.pointcloud import mesh_triangles
from cmtof.types import Array, Fields, Pair
from cmtof_book import live
from cmtof_book.provenance import letters, output_folder


class Layer(NamedTuple):
    """A surface, points (H, W, 3), m, coloured by values (H, W) on a scale between two ends."""

    points: Array
    values: Array
    scale: str
    ends: Pair
    meaning: str

    def colours(self) -> Array:
        """Colours (H, W, 3), 0 to 1, of the points."""
        low, high = self.ends
        return plt.get_cmap(self.scale)((self.values - low) / (high - low))[..., :3]

    def pack(self, step: int) -> Fields:
        """Every ``step``-th point and its colour for the page, and the key to the colours."""
        colours = self.colours()[::step, ::step]
        key = plt.get_cmap(self.scale)(np.linspace(0, 1, 9))
        return {
            "shape": colours.shape[:2],
            "points": letters(self.points[::step, ::step].astype("<f4")),
            "colours": letters(np.rint(255 * colours).astype(np.uint8)),
            "meaning": self.meaning,
            "ends": [f"{end:.3g}" for end in self.ends],
            "scale": ", ".join(map(to_hex, key)),
        }


def save_scene(
    name: str, layers: Mapping[str, Layer], *, longest: float, eye: tuple, step: int
) -> None:
    """Write surfaces by name to ``name.js``, every ``step``-th point along both axes.

    Neighbours further apart than ``longest``, m, are not joined; ``eye`` (3,), m, is where they are
    seen from. Points are x right, y down, z forward, NaN for none.
    """
    about = {
        "longest": step * longest,
        "eye": eye,
        "layers": {label: layer.pack(step) for label, layer in layers.items()},
    }
    call = f"cmtofScene({json.dumps(name)}, {json.dumps(about)});\n"
    with atomic_output(output_folder() / f"{name}.js") as part:
        part.write_text(call, "utf-8")


def show_scene(name: str, *, title: str) -> None:
    """Show a saved scene to turn, folded until it is opened."""
    live.show(
        f'<details class="scene" id="{name.replace("_", "-")}">'
        f"<summary>Turn it: {html.escape(title)}</summary><p></p></details>",
        output_folder() / f"{name}.js",
    )


def still(layer: Layer, *, longest: float, eye: tuple) -> Array | None:
    """Shaded still (h, w, 3), 0 to 1, of a surface, seen as in `save_scene`; None without OpenGL.

    PyVista draws in a process of its own, off screen: without OpenGL it may crash, and only there.
    """
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        try:
            return pool.submit(_draw_still, layer, longest, eye).result()
        except BrokenProcessPool:
            print(
                "No still: OpenGL is missing (apt-get install libegl1 libgl1).",
                file=sys.stderr,
            )
            return None


def _draw_still(layer: Layer, longest: float, eye: tuple) -> Array:
    """Draw what `still` describes; runs in its own process."""
    import pyvista as pv

    pv.vtk_verbosity("off")  # complaints about a missing screen
    mesh = pv.PolyData.from_regular_faces(
        layer.points.reshape(-1, 3), mesh_triangles(layer.points, longest=longest)
    )
    mesh["values"] = layer.values.ravel()
    mesh.clean(inplace=True)
    plotter = pv.Plotter(off_screen=True, lighting="three lights")
    plotter.camera_position = eye, mesh.center, (0, -1, 0)
    mesh.transform(plotter.camera.GetModelViewTransformMatrix(), inplace=True)
    plotter.add_mesh(
        mesh,
        smooth_shading=True,
        cmap=layer.scale,
        clim=layer.ends,
        show_scalar_bar=False,
    )
    plotter.enable_anti_aliasing("ssaa")
    plotter.camera.tight()
    return np.asarray(plotter.screenshot()) / 255
