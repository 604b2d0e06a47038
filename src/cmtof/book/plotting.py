"""One figure style for the whole book, and figures saved with their numbers.

Colours are those of Okabe and Ito (2008), which stay apart for colour-blind readers and in grey.
Figures keep a white ground of their own, so they read the same on light and dark pages.
"""

import re
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from numpy.typing import ArrayLike

from cmtof.book import provenance
from cmtof.files import written_whole

PALETTE: dict[str, str] = {
    "blue": "#0072B2",
    "vermillion": "#D55E00",
    "green": "#009E73",
    "purple": "#CC79A7",
    "orange": "#E69F00",
    "sky": "#56B4E9",
    "black": "#000000",
    "yellow": "#F0E442",
}
"""Okabe–Ito colours, in the order in which lines take them."""

PHASE_CMAP = "twilight"
"""Cyclic colour map: 0 and 2π look alike, lightness carries the rest."""

DEPTH_CMAP = "cividis"
"""Sequential colour map for depth, amplitude and counts."""

INVALID_COLOUR = "#B0B0B0"
"""Colour of pixels without a value."""

_STYLE: Any = {
    "figure.figsize": (6.4, 3.8),
    "figure.dpi": 100,
    "figure.facecolor": "white",
    "figure.constrained_layout.use": True,
    "savefig.facecolor": "white",
    "savefig.dpi": 160,
    "axes.facecolor": "white",
    "axes.prop_cycle": cycler(color=list(PALETTE.values())),
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": "medium",
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 10.5,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.7,
    "image.cmap": DEPTH_CMAP,
    "image.interpolation": "nearest",
    "legend.frameon": False,
    "lines.linewidth": 1.7,
    "svg.fonttype": "path",
    "svg.hashsalt": "cmtof",
}

_STEM = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)+")
# without these a file would carry the date or the version of the library that drew it
_FORMATS: dict[str, tuple[str, dict[str, None]]] = {
    "svg": ("image/svg+xml", {"Date": None, "Creator": None}),
    "png": ("image/png", {"Software": None}),
}


def use_style() -> None:
    """Set Matplotlib to the style of the book.

    Examples
    --------
    >>> use_style()
    >>> mpl.rcParams["svg.hashsalt"]
    'cmtof'
    """
    mpl.rcdefaults()
    mpl.rcParams.update(_STYLE)


def begin(*, profile: str = "book", seed: int = 0) -> provenance.Run:
    """Begin a run: set the style, and the seed and profile stored with every result.

    From then on a notebook shows a figure when it is saved, and only then. Parameters, result and
    errors are those of :func:`cmtof.book.provenance.begin`.

    Examples
    --------
    >>> begin(profile="ci", seed=1).profile
    'ci'
    """
    use_style()
    plt.switch_backend("agg")
    return provenance.begin(profile=profile, seed=seed)


def image(
    ax: Axes,
    values: ArrayLike,
    *,
    label: str,
    title: str = "",
    cmap: str = DEPTH_CMAP,
    limits: tuple[float, float] | None = None,
) -> AxesImage:
    """Draw an image with square pixels, no ticks, and a colour bar that names the unit.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    values : ArrayLike
        (H, W); NaN is drawn grey.
    label : str
        Quantity and unit, as in ``"depth (m)"``; it stands beside the colour bar.
    title : str
        Title of the panel.
    cmap : str
        Name of a Matplotlib colour map.
    limits : tuple of float, optional
        Values at the ends of the colour bar; by default those of the image.

    Returns
    -------
    AxesImage
        The image drawn.

    Raises
    ------
    ValueError
        If ``values`` is not two-dimensional.

    Examples
    --------
    >>> fig, ax = plt.subplots()
    >>> image(ax, np.eye(3), label="depth (m)").get_array().shape
    (3, 3)
    >>> plt.close(fig)
    """
    array = np.asarray(values)
    if array.ndim != 2:
        raise ValueError(f"Expected an image of shape (H, W), got {array.shape}. Pick one plane.")
    low, high = limits if limits is not None else (None, None)
    colours = mpl.colormaps[cmap].with_extremes(bad=INVALID_COLOUR)
    drawn = ax.imshow(array, cmap=colours, vmin=low, vmax=high)
    ax.set(xticks=[], yticks=[], title=title)
    ax.grid(visible=False)
    ax.spines[:].set_visible(False)
    # a bar inside the panel's own frame is exactly as high as the image, whatever its aspect
    _figure_of(ax).colorbar(drawn, cax=ax.inset_axes((1.03, 0, 0.05, 1)), label=label)
    return drawn


def phase_image(
    ax: Axes, phase: ArrayLike, *, title: str = "", label: str = "phase (rad)"
) -> AxesImage:
    """Draw wrapped phase in [0, 2π) with cyclic colours.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    phase : ArrayLike
        (H, W) wrapped phase, rad.
    title, label : str
        Title of the panel and text beside the colour bar.

    Returns
    -------
    AxesImage
        The image drawn.

    Examples
    --------
    >>> fig, ax = plt.subplots()
    >>> phase_image(ax, np.eye(3)).get_clim() == (0.0, 2 * np.pi)
    True
    >>> plt.close(fig)
    """
    turn = 2 * np.pi
    drawn = image(ax, phase, label=label, title=title, cmap=PHASE_CMAP, limits=(0.0, turn))
    if drawn.colorbar is not None:
        drawn.colorbar.set_ticks([0, turn / 2, turn], labels=["0", "π", "2π"])
    return drawn


def label_panels(axes: Iterable[Axes]) -> None:
    """Put (a), (b), … before the titles of panels, in the order given.

    Examples
    --------
    >>> fig, axes = plt.subplots(1, 2)
    >>> label_panels(axes)
    >>> axes[1].get_title(loc="left")
    '(b)'
    >>> plt.close(fig)
    """
    for number, ax in enumerate(axes):
        title = ax.get_title()
        ax.set_title("")
        ax.set_title(f"({chr(ord('a') + number)}) {title}".rstrip(), loc="left")


def save(
    fig: Figure,
    name: str,
    *,
    numbers: Mapping[str, Any],
    caption: str,
    alt: str,
    format: Literal["svg", "png"] = "svg",
) -> None:
    """Save a figure with the numbers it shows, close it, and display it in a notebook.

    Writes ``name.svg`` or ``name.png`` and beside it ``name.json`` with caption, alternative text,
    numbers and provenance into :func:`cmtof.book.provenance.output_folder`. The same run writes the
    same bytes.

    Parameters
    ----------
    fig : Figure
        The figure.
    name : str
        File stem: ``figNN_topic`` with the paper's number, or ``topic_name``.
    numbers : Mapping
        The numbers drawn, finite: scalars and short lists. Tests hold them against references.
    caption : str
        One or two sentences in MyST Markdown; the book numbers it.
    alt : str
        What the figure shows, for a reader who cannot see it.
    format : {"svg", "png"}
        ``png`` for figures made of large images.

    Raises
    ------
    ValueError
        If the name, the format, a text or a number cannot be used.

    Examples
    --------
    >>> import os, tempfile
    >>> os.environ["CMTOF_OUTPUT"] = tempfile.mkdtemp()
    >>> fig, ax = plt.subplots()
    >>> save(fig, "fig00_empty", numbers={}, caption="Nothing.", alt="Empty axes.")
    >>> sorted(os.listdir(os.environ.pop("CMTOF_OUTPUT")))
    ['fig00_empty.json', 'fig00_empty.svg']
    """
    _check_save(name, caption, alt, format)
    record = {
        "figure": f"{name}.{format}",
        "caption": caption,
        "alt": alt,
        "numbers": provenance.plain(numbers),
        "provenance": provenance.as_dict(),
    }
    folder = provenance.output_folder()
    target = folder / f"{name}.{format}"
    mime, metadata = _FORMATS[format]
    with written_whole(target) as part:
        fig.savefig(part, format=format, metadata=metadata)
    provenance.write_json(folder / f"{name}.json", record)
    plt.close(fig)
    _display(target, mime, name=name, caption=caption, alt=alt)


def _check_save(name: str, caption: str, alt: str, format: str) -> None:
    if not _STEM.fullmatch(name):
        raise ValueError(
            f"Expected a stem like 'fig03_precision', got {name!r}. "
            "Use lower-case words joined by underscores."
        )
    if format not in _FORMATS:
        raise ValueError(f"Expected the format 'svg' or 'png', got {format!r}. Choose one of them.")
    for role, text in (("caption", caption), ("alternative text", alt)):
        if not text.strip():
            raise ValueError(f"Expected a {role} for {name}, got an empty text. Write one.")


def _display(target: Path, mime: str, *, name: str, caption: str, alt: str) -> None:
    """Show the saved file in a running notebook, with what the book needs to place it."""
    if "IPython" not in sys.modules:
        return
    from IPython.core.getipython import get_ipython
    from IPython.display import publish_display_data

    if get_ipython() is None:
        return
    raw = target.read_bytes()
    data = raw.decode("utf-8") if mime == "image/svg+xml" else raw
    publish_display_data(
        {mime: data, "text/plain": alt},
        {"cmtof": {"name": name, "caption": caption, "alt": alt}},
    )


def _figure_of(ax: Axes) -> Figure:
    figure = ax.get_figure(root=True)
    if figure is None:
        raise ValueError("Expected axes that lie in a figure, got loose ones. Draw on a figure.")
    return figure
