"""One figure style for the whole book, its recurring plots, and figures saved with their numbers.

Colours are those of Okabe and Ito (2008), which stay apart for colour-blind readers and in grey.
"""

import csv
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from string import ascii_lowercase
from typing import Any, Literal

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patheffects import withStroke
from numpy.typing import ArrayLike
from PIL import Image

from cmtof.files import written_whole
from cmtof_book import provenance, record

PALETTE: dict[str, str] = {  # in the order in which lines take them
    "blue": "#0072B2",
    "vermillion": "#D55E00",
    "green": "#009E73",
    "purple": "#CC79A7",
    "orange": "#E69F00",
    "sky": "#56B4E9",
    "black": "#000000",
    "yellow": "#F0E442",
}

GREY = "#8A97A3"  # of reference lines
PHASE_CMAP = "twilight"  # cyclic: 0 and 2π look alike, lightness carries the rest
DEPTH_CMAP = "cividis"  # for depth, amplitude and counts
Limits = tuple[float, float]
TURN: Limits = (0.0, 2 * np.pi)  # of a wrapped phase, rad


def begin(*, profile: str = "book", seed: int = 0) -> None:
    """Set the style, and the profile and seed stored with every result."""
    mpl.rcdefaults()
    plt.style.use(["cmtof_book.book", {"axes.prop_cycle": cycler(color=list(PALETTE.values()))}])
    plt.switch_backend("agg")  # a notebook shows a figure when it is saved, and only then
    provenance.RUN.update(profile=profile, seed=seed)


def image(
    ax: Axes,
    values: ArrayLike,
    *,
    label: str,
    title: str = "",
    cmap: str = DEPTH_CMAP,
    limits: Limits | None = None,
    bar: bool = True,
) -> AxesImage:
    """Image (H, W) with square pixels, no ticks, and a colour bar that names the unit; NaN is grey.

    ``label`` is quantity and unit, as in ``"depth (m)"``; ``limits`` are the values at the ends of
    the colour bar, by default those of the image.
    """
    low, high = limits or (None, None)
    colours = mpl.colormaps[cmap].with_extremes(bad="#B0B0B0")
    drawn = ax.imshow(np.asarray(values), cmap=colours, vmin=low, vmax=high)
    ax.set(xticks=[], yticks=[], title=title)
    ax.grid(visible=False)
    ax.spines[:].set_visible(False)
    if bar:  # inside the panel's own frame it is exactly as high as the image, whatever its aspect
        _colour_bar(drawn, cax=ax.inset_axes((1.03, 0, 0.05, 1)), label=label)
    return drawn


def phase_image(ax: Axes, phase: ArrayLike, *, title: str = "", label: str = "phase (rad)") -> None:
    """Wrapped phase (H, W) in [0, 2π), rad, with cyclic colours; otherwise as `image`."""
    image(ax, phase, label=label, title=title, cmap=PHASE_CMAP, limits=TURN)


def maps(
    images: Sequence[ArrayLike],
    *,
    label: str,
    titles: Sequence[str] = (),
    cmap: str = DEPTH_CMAP,
    limits: Limits | None = None,
    columns: int | None = None,
    width: float = 2.8,
) -> tuple[Figure, list[Axes]]:
    """Grid of images (H, W) on one scale, in one row or so many columns, and one colour bar.

    ``label``, ``cmap`` and ``limits`` as in `image`; phase takes ``cmap=PHASE_CMAP, limits=TURN``.
    ``width`` is that of a panel, inches.
    """
    arrays = np.asarray(images, float)
    aspect = arrays.shape[1] / arrays.shape[2]
    fig, axes = grid(len(arrays), int(columns or len(arrays)), width, aspect)
    limits = limits or (np.nanmin(arrays), np.nanmax(arrays))
    for ax, values, title in zip(axes, arrays, titles or len(arrays) * [""], strict=True):
        image(ax, values, label="", title=title, cmap=cmap, limits=limits, bar=False)
    _colour_bar(axes[0].images[0], ax=axes, label=label)
    return fig, axes


def grid(count: int, columns: int, width: float, aspect: float) -> tuple[Figure, list[Axes]]:
    """So many panels in columns, with space for titles and one colour bar; sizes in inches."""
    rows = -(-count // columns)
    size = (columns * width + 0.9, rows * (width * aspect + 0.35))
    fig, made = plt.subplots(rows, columns, figsize=size, squeeze=False)
    shown, empty = np.split(made.ravel(), [count])
    for ax in empty:
        ax.remove()
    return fig, shown.tolist()


def _colour_bar(drawn: AxesImage, *, label: str, **where: Any) -> None:
    """A colour bar, for a turn with ticks in π."""
    bar = drawn.get_figure(root=True).colorbar(drawn, label=label, **where)
    if drawn.get_clim() == TURN:
        bar.set_ticks([0, np.pi, 2 * np.pi], labels=["0", "π", "2π"])


def mark(ax: Axes, *, x: float | None = None, y: float | None = None, text: str = "") -> None:
    """Thin grey reference line at ``x`` or at ``y``, with a text at its end."""
    style: Any = {"color": GREY, "lw": 1, "ls": ":", "zorder": 0}
    if x is not None:
        ax.axvline(x, **style)
        place, within = (x, 0), ax.get_xaxis_transform()
    else:
        ax.axhline(y, **style)
        place, within = (0, y), ax.get_yaxis_transform()
    note: Any = {"color": "#59646E", "size": "small", "xytext": (3, 2), "zorder": 4}
    note["path_effects"] = [withStroke(linewidth=2.5, foreground="white")]  # readable on lines
    ax.annotate(text, place, xycoords=within, textcoords="offset points", **note)


def sweep(
    ax: Axes,
    x: ArrayLike,
    values: ArrayLike,
    *,
    errors: ArrayLike | None = None,
    bound: ArrayLike | tuple[ArrayLike, ArrayLike] | None = None,
    bound_label: str = "",
    log: str = "xy",
    **style: Any,
) -> None:
    """Dots (N,) of a sweep, with error bars, and the line of a bound or theory.

    ``errors`` are half-lengths; ``bound`` holds values, or its own settings and values. ``style``
    is that of the dots; the line has their ``color``.
    """
    dots = {"fmt": "o", "ms": 4.5, "color": PALETTE["blue"], "lw": 1.2} | style
    if bound is not None:
        line = bound if isinstance(bound, tuple) else (x, bound)
        ax.plot(*line, color=dots["color"], lw=1.4, label=bound_label or None)
    ax.errorbar(x, values, errors, **dots)
    ax.set(**{f"{axis}scale": "log" for axis in log})


def intervals(
    ax: Axes,
    rows: Mapping[str, tuple[float, float, float]],
    *,
    colors: Mapping[str, str],
    published: Mapping[str, float],
) -> None:
    """Dots with bars (value, low, high), a row a name, the first on top; diamonds of the paper."""
    for place, (name, (value, low, high)) in enumerate(rows.items()):
        ax.plot([low, high], [place, place], color=colors[name], lw=3, alpha=0.45)
        ax.plot(value, place, "o", color=colors[name], ms=5)
    if published:
        theirs = [published.get(name, np.nan) for name in rows]
        words = "the paper, its own scenes"
        ax.plot(theirs, range(len(rows)), "D", mfc="none", mec="black", ms=5, label=words)
    ax.set_yticks(range(len(rows)), list(rows))
    ax.invert_yaxis()


def bars(ax: Axes, series: Mapping[str, ArrayLike], groups: Sequence[str]) -> None:
    """Grouped vertical bars: a colour a series of heights (G,), a place for each of G groups."""
    import pandas as pd

    pd.DataFrame(dict(series), index=list(groups)).plot.bar(ax=ax, rot=0, width=0.8, legend=False)
    ax.grid(axis="x", visible=False)


def label_panels(axes: Iterable[Axes]) -> None:
    """Put (a), (b), … before the titles of panels, in the order given."""
    for letter, ax in zip(ascii_lowercase, axes, strict=False):
        title = ax.get_title()
        ax.set_title("")
        ax.set_title(f"({letter}) {title}".rstrip(), loc="left")


def points(fig: Figure) -> Iterator[tuple[int, str, float, float]]:
    """Panel, line, x and y of every point of a figure, without clouds of more than 10,000."""
    for panel, ax in enumerate(fig.axes):
        for line in ax.lines:
            if len(line.get_xydata()) <= 10_000:
                name = str(line.get_label()).lstrip("_")
                yield from ((panel, name, *xy) for xy in line.get_xydata().round(9))


def _save_space(path: Path) -> None:
    """Keep 256 colours of a picture if that changes them by less than a level on average."""
    drawn = Image.open(path).convert("RGB")
    few = drawn.quantize(256, kmeans=1, dither=Image.Dither.NONE)
    lost = np.subtract(few.convert("RGB"), drawn, dtype=float)
    kept = few if np.abs(lost).max(-1).mean() < 1 else drawn
    kept.save(path, "PNG", optimize=True)


def save(
    fig: Figure,
    name: str,
    *,
    numbers: Mapping[str, Any] | None = None,
    caption: str,
    alt: str,
    format: Literal["svg", "png"] = "svg",
) -> None:
    """Save a figure with the numbers it shows, close it, and display it in a notebook.

    Writes ``name.svg`` or ``name.png`` (for large images), the same bytes on every run,
    ``name.json`` with ``numbers``, and ``name.csv`` with the points of every line. ``name`` is
    ``figNN_topic`` with the paper's number, or ``topic_name``; ``numbers`` are finite scalars and
    short lists that others use: tests compare those with a kind (`cmtof_book.compared`);
    ``caption`` is in MyST Markdown. Raises ValueError if the name or one of the numbers cannot be
    used.
    """
    if not re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)+", name):
        raise ValueError(f"Expected a stem like fig03_precision, got {name!r}. Use underscores.")
    target = provenance.output_folder() / f"{name}.{format}"
    words = {"caption": caption, "alt": alt}
    record.write(name, numbers or {}, figure=target.name, **words)
    with target.with_suffix(".csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([("panel", "line", "x", "y"), *points(fig)])
    # without this a file would carry the date or the version of the library that drew it
    metadata = {"Date": None, "Creator": None} if format == "svg" else {"Software": None}
    with written_whole(target) as part:
        fig.savefig(part, format=format, metadata=metadata)
        if format == "png":
            _save_space(part)
    plt.close(fig)
    from IPython.core.getipython import get_ipython

    if shell := get_ipython():  # in a notebook, with what the book needs to place it
        kind = "image/svg+xml" if format == "svg" else "image/png"
        drawn = target.read_text("utf-8") if format == "svg" else target.read_bytes()
        shown = {kind: drawn, "text/plain": alt}
        shell.display_pub.publish(shown, {"cmtof": {"name": name} | words})
