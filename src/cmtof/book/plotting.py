"""One figure style for the whole book, its recurring plots, and figures saved with their numbers.

Colours are those of Okabe and Ito (2008), which stay apart for colour-blind readers and in grey.
Figures keep a white ground of their own, so they read the same on light and dark pages.
"""

import re
import sys
from collections.abc import Iterable, Mapping, Sequence
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

GREY = "#8A97A3"
"""Colour of reference lines."""

PHASE_CMAP = "twilight"
"""Cyclic colour map: 0 and 2π look alike, lightness carries the rest."""

DEPTH_CMAP = "cividis"
"""Sequential colour map for depth, amplitude and counts."""

INVALID_COLOUR = "#B0B0B0"
"""Colour of pixels without a value."""

TURN = (0.0, 2 * np.pi)
"""Limits of a wrapped phase, rad."""

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


def begin(*, profile: str = "book", seed: int = 0) -> provenance.Run:
    """Begin a run: set the style, and the seed and profile stored with every result.

    From then on a notebook shows a figure when it is saved, and only then. Parameters, result and
    errors are those of `cmtof.book.provenance.begin`.
    """
    mpl.rcdefaults()
    mpl.rcParams.update(_STYLE)
    plt.switch_backend("agg")
    return provenance.begin(profile=profile, seed=seed)


# --- images ------------------------------------------------------------------------------------


def image(
    ax: Axes,
    values: ArrayLike,
    *,
    label: str,
    title: str = "",
    cmap: str = DEPTH_CMAP,
    limits: tuple[float, float] | None = None,
    bar: bool = True,
) -> AxesImage:
    """Image (H, W) with square pixels, no ticks, and a colour bar that names the unit; NaN is grey.

    ``label`` is quantity and unit, as in ``"depth (m)"``; ``limits`` are the values at the ends of
    the colour bar, by default those of the image. Raises ValueError unless ``values`` has two axes.
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
    if bar:  # inside the panel's own frame it is exactly as high as the image, whatever its aspect
        _colour_bar(drawn, cax=ax.inset_axes((1.03, 0, 0.05, 1)), label=label)
    return drawn


def phase_image(
    ax: Axes, phase: ArrayLike, *, title: str = "", label: str = "phase (rad)"
) -> AxesImage:
    """Wrapped phase (H, W) in [0, 2π), rad, with cyclic colours; otherwise as `image`."""
    return image(ax, phase, label=label, title=title, cmap=PHASE_CMAP, limits=TURN)


def maps(
    images: Sequence[ArrayLike],
    *,
    label: str,
    titles: Sequence[str] = (),
    cmap: str = DEPTH_CMAP,
    limits: tuple[float, float] | None = None,
    columns: int | None = None,
    width: float = 2.8,
) -> tuple[Figure, list[Axes]]:
    """Grid of images (H, W) on one scale, row by row, with one colour bar at the right.

    ``label``, ``cmap`` and ``limits`` as in `image`, the limits by default those of all images;
    phase takes ``cmap=PHASE_CMAP, limits=TURN``. All panels stand in one row unless ``columns`` is
    given; ``width`` is that of a panel in inches.
    """
    arrays = [np.asarray(values, float) for values in images]
    columns = columns or len(arrays)
    rows = -(-len(arrays) // columns)
    height, across = arrays[0].shape
    size = (columns * width + 0.9, rows * (width * height / across + 0.35))
    fig, grid = plt.subplots(rows, columns, figsize=size, squeeze=False)
    if limits is None:
        limits = min(np.nanmin(a) for a in arrays), max(np.nanmax(a) for a in arrays)
    axes = list(grid.flat)
    for ax, values, title in zip(axes, arrays, [*titles, *len(arrays) * [""]], strict=False):
        image(ax, values, label="", title=title, cmap=cmap, limits=limits, bar=False)
    for ax in axes[len(arrays) :]:
        ax.remove()
    axes = axes[: len(arrays)]
    _colour_bar(axes[0].images[0], ax=axes, label=label)
    return fig, axes


def _colour_bar(drawn: AxesImage, *, label: str, **where: Any) -> None:
    figure = drawn.get_figure(root=True)
    assert isinstance(figure, Figure)
    bar = figure.colorbar(drawn, label=label, **where)
    if drawn.get_clim() == TURN:
        bar.set_ticks([0, np.pi, 2 * np.pi], labels=["0", "π", "2π"])


# --- lines, dots and bars ----------------------------------------------------------------------


def mark(ax: Axes, *, x: float | None = None, y: float | None = None, text: str = "") -> None:
    """Thin grey reference line at ``x`` or at ``y``, with a text at its end."""
    style: Any = {"color": GREY, "lw": 1, "ls": ":", "zorder": 0}
    note: Any = {"color": "#59646E", "size": "small", "xytext": (3, 2)}
    if x is not None:
        ax.axvline(x, **style)
        where: Any = ((x, 0), ("data", "axes fraction"))
    else:
        ax.axhline(0 if y is None else y, **style)
        where = ((0, y), ("axes fraction", "data"))
    if text:
        ax.annotate(text, where[0], xycoords=where[1], textcoords="offset points", **note)


def sweep(
    ax: Axes,
    x: ArrayLike,
    values: ArrayLike,
    *,
    errors: ArrayLike | None = None,
    bound: ArrayLike | tuple[ArrayLike, ArrayLike] | None = None,
    label: str = "",
    bound_label: str = "",
    color: str = PALETTE["blue"],
    log: str = "xy",
) -> None:
    """Dots (N,) of a sweep, with error bars, and the line of a bound or theory.

    ``errors`` are half-lengths (N,) or (2, N); ``bound`` is theory at ``x``, or a pair of its own
    settings and values; ``log`` names the axes with a logarithmic scale.
    """
    if bound is not None:
        line = bound if isinstance(bound, tuple) else (x, bound)
        ax.plot(*map(np.asarray, line), color=color, lw=1.4, label=bound_label or None)
    ax.errorbar(x, values, errors, fmt="o", ms=4.5, color=color, label=label or None, lw=1.2)
    ax.set(**{f"{axis}scale": "log" for axis in log})


def intervals(
    ax: Axes,
    rows: Mapping[str, tuple[float, float, float]],
    *,
    colors: Mapping[str, str] | str = PALETTE["blue"],
    published: Mapping[str, float] | None = None,
    published_label: str = "the paper, its own scenes",
) -> None:
    """Dots with interval bars (value, low, high), one row a name, the first on top.

    ``colors`` is one colour or one for each name; diamonds show what the paper has ``published``.
    """
    theirs = published or {}
    for place, (name, (value, low, high)) in enumerate(rows.items()):
        color = colors if isinstance(colors, str) else colors[name]
        ax.plot([low, high], [place, place], color=color, lw=3, alpha=0.45)
        ax.plot(value, place, "o", color=color, ms=5)
        if name in theirs:
            ax.plot(theirs[name], place, "D", mfc="none", mec="black", ms=5)
    if theirs:
        ax.plot([], [], "D", mfc="none", mec="black", ms=5, label=published_label)
    ax.set_yticks(range(len(rows)), list(rows))
    ax.invert_yaxis()


def bars(
    ax: Axes,
    series: Mapping[str, ArrayLike],
    groups: Sequence[str],
    *,
    errors: Mapping[str, ArrayLike] | None = None,
    colors: Mapping[str, str] | None = None,
) -> None:
    """Grouped vertical bars: one colour a series of heights (G,), one place for each of G groups.

    ``errors`` are half-lengths (G,) or (2, G) by series; ``colors`` by default those of `PALETTE`.
    """
    place, width = np.arange(len(groups)), 0.8 / len(series)
    for number, (name, heights) in enumerate(series.items()):
        left = place + width * (number + 0.5) - 0.4
        color = colors[name] if colors else list(PALETTE.values())[number]
        error = errors.get(name) if errors else None
        ax.bar(left, heights, 0.94 * width, yerr=error, color=color, label=name)
    ax.set_xticks(place, groups)
    ax.grid(axis="x", visible=False)


def label_panels(axes: Iterable[Axes]) -> None:
    """Put (a), (b), … before the titles of panels, in the order given."""
    for number, ax in enumerate(axes):
        title = ax.get_title()
        ax.set_title("")
        ax.set_title(f"({chr(ord('a') + number)}) {title}".rstrip(), loc="left")


# --- saving ------------------------------------------------------------------------------------


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
    numbers and provenance into `cmtof.book.provenance.output_folder`. The same run writes the same
    bytes.

    Parameters
    ----------
    name : str
        File stem: ``figNN_topic`` with the paper's number, or ``topic_name``.
    numbers : Mapping
        The numbers drawn, finite: scalars and short lists. Tests hold them against references.
    caption, alt : str
        One or two sentences in MyST Markdown, and what the figure shows to one who cannot see it.
    format : {"svg", "png"}
        ``png`` for figures made of large images.

    Raises
    ------
    ValueError
        If the name, the format, a text or a number cannot be used.
    """
    if not _STEM.fullmatch(name):
        raise ValueError(
            f"Expected a stem like 'fig03_precision', got {name!r}. "
            "Use lower-case words joined by underscores."
        )
    if format not in ("svg", "png"):
        raise ValueError(f"Expected the format 'svg' or 'png', got {format!r}. Choose one of them.")
    for role, text in (("caption", caption), ("alternative text", alt)):
        if not text.strip():
            raise ValueError(f"Expected a {role} for {name}, got an empty text. Write one.")
    record = {
        "figure": f"{name}.{format}",
        "caption": caption,
        "alt": alt,
        "numbers": provenance.plain(numbers),
        "provenance": provenance.as_dict(),
    }
    folder = provenance.output_folder()
    # without this a file would carry the date or the version of the library that drew it
    metadata = {"Date": None, "Creator": None} if format == "svg" else {"Software": None}
    with written_whole(folder / f"{name}.{format}") as part:
        fig.savefig(part, format=format, metadata=metadata)
    provenance.write_json(folder / f"{name}.json", record)
    plt.close(fig)
    _display(folder / f"{name}.{format}", name=name, caption=caption, alt=alt)


def _display(target: Path, *, name: str, caption: str, alt: str) -> None:
    """Show the saved file in a running notebook, with what the book needs to place it."""
    if "IPython" not in sys.modules:
        return
    from IPython.core.getipython import get_ipython
    from IPython.display import publish_display_data

    if get_ipython() is None:
        return
    about = {"cmtof": {"name": name, "caption": caption, "alt": alt}}
    if target.suffix == ".svg":
        shown = {"image/svg+xml": target.read_text("utf-8"), "text/plain": alt}
    else:
        shown = {"image/png": target.read_bytes(), "text/plain": alt}
    publish_display_data(shown, about)
