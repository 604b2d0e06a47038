"""Surfaces that a reader can turn: one self-contained HTML file, and a still of the same view.

PyVista's trame component writes the file: viewer and data lie in it, and nothing is loaded from
elsewhere. `save_scene` writes it beside the figures of a run, `show_scene` puts it on the page of
a notebook, folded away until somebody opens it. The still comes back as an image, to be drawn in a
figure.
"""

import html
import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.book import provenance
from cmtof.book.surface import render_surface
from cmtof.files import written_whole

Array = NDArray[np.float64]

MOST_BYTES = 3_000_000
"""Size that a scene's file must stay below."""

MOST_POINTS = 20_000
"""Points of a scene at most; denser maps lose rows and columns."""

STILL = (900, 900)
"""Width and height of a still before it is cropped, px."""

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

    Parameters
    ----------
    name : str
        File stem, as of a figure.
    points : array_like, shape (H, W, 3)
        m, x right, y down, z forward, as `cmtof.pointcloud.points_from_depth` gives them; NaN for
        none.
    colours : array_like, shape (H, W, 3)
        Red, green and blue, 0 to 1.
    title : str
        What the scene is, in a few words.
    longest : float
        Longest side of a triangle, m: neighbours further apart are not joined.
    eye : tuple of float
        Where it is seen from at first, m.

    Returns
    -------
    ndarray, shape (h, w, 3), or None
        Still, 0 to 1, cropped to the surface; None where OpenGL is missing, which is said.

    Raises
    ------
    ValueError
        If shapes do not fit, there is no surface, or the file would be too large.
    RuntimeError
        If PyVista or trame is missing.
    """
    points, colours = np.asarray(points, float), np.asarray(colours, float)
    _check(points, colours, longest)
    step = int(np.ceil(np.sqrt(points[..., 0].size / MOST_POINTS)))
    with tempfile.TemporaryDirectory() as folder:
        page, still = Path(folder) / "scene.html", Path(folder) / "still.png"
        drawn = render_surface(
            points[::step, ::step],
            colours[::step, ::step],
            still,
            longest=step * longest,
            eye=eye,
            size=STILL,
            html=page,
        )
        if not page.is_file():
            raise RuntimeError(
                "Expected PyVista and trame to write a scene, got none. "
                "Install them: pip install pyvista trame-pyvista."
            )
        _write(provenance.output_folder() / f"{name}.html", page.read_text("utf-8"), title)
        if not drawn:
            print(NO_STILL, file=sys.stderr)
            return None
        import matplotlib.pyplot as plt

        return np.asarray(plt.imread(still), float)[..., :3]


def show_scene(name: str, *, title: str) -> None:
    """Put a saved scene on the notebook's page, folded until it is opened.

    Parameters
    ----------
    name, title : str
        As given to `save_scene`.
    """
    from IPython.core.display import HTML
    from IPython.display import display

    display(HTML(scene_block(name, title=title)))


def scene_block(name: str, *, title: str) -> str:
    """HTML by which a page of the book's folder ``notebooks`` shows a scene.

    Examples
    --------
    >>> print(scene_block("bust", title="A bust").splitlines()[0])
    <details class="scene"><summary>Turn it: A bust</summary>
    """
    source, words = f"../{STATIC}/{name}.html", html.escape(title)
    return (
        f'<details class="scene"><summary>Turn it: {words}</summary>\n'
        f'<iframe loading="lazy" title="{words}, interactive" src="{source}"></iframe>\n'
        f'<p>Drag to turn, pinch or scroll to zoom. <a href="{source}">Open it on a page of its '
        "own</a>.</p></details>"
    )


def depth_colours(depth: ArrayLike, *, limits: tuple[float, float], cmap: str) -> Array:
    """Colours (H, W, 3), 0 to 1, of a map of depths (H, W), m, between two limits.

    Examples
    --------
    >>> depth_colours([[1.0, 2.0]], limits=(1.0, 2.0), cmap="gray").round(3).tolist()
    [[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]]
    """
    import matplotlib as mpl

    low, high = limits
    share = np.clip((np.nan_to_num(np.asarray(depth, float)) - low) / (high - low), 0, 1)
    return np.asarray(mpl.colormaps[cmap](share))[..., :3]


def _check(points: Array, colours: Array, longest: float) -> None:
    if points.ndim != 3 or points.shape[2] != 3 or colours.shape != points.shape:
        raise ValueError(
            f"Expected points and colours (H, W, 3), got {points.shape} and {colours.shape}. "
            "Give one colour a point."
        )
    if not (np.isfinite(colours).all() and colours.min() >= 0 and colours.max() <= 1):
        raise ValueError("Expected colours from 0 to 1, got others. Divide by 255 or clip.")
    steps = np.linalg.norm(np.diff(points, axis=1), axis=-1)
    if not (steps < longest).any():
        raise ValueError(
            f"Expected neighbours nearer than {longest:g} m, got none. Raise `longest`."
        )


def _write(target: Path, text: str, title: str) -> None:
    """Store the viewer's page under its own title; the icons it would fetch are left out."""
    text = text.replace(
        "https://kitware.github.io/vtk-js/icon/favicon-${t}x${t}.png", "data:,"
    ).replace(
        "<title>VTK.js | Example - OfflineLocalView</title>", f"<title>{html.escape(title)}</title>"
    )
    size = len(text.encode())
    if size >= MOST_BYTES:
        raise ValueError(
            f"Expected a scene below {MOST_BYTES / 1e6:g} MB, got {size / 1e6:.1f} MB. "
            "Lower MOST_POINTS."
        )
    with written_whole(target) as part:
        part.write_text(text, encoding="utf-8")
