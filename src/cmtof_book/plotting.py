"""One figure style for the whole book, its recurring plots, and figures saved with their numbers.

Colours are those of Okabe and Ito (2008), which stay apart for colour-blind readers and in grey.
"""

import csv
import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from string import ascii_lowercase
from typing import Any, Literal

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patheffects import withStroke
from matplotlib.text import Text
from numpy.typing import ArrayLike
from PIL import Image

from cmtof.correlation import TAU
from cmtof.files import atomic_output
from cmtof.types import Named, Pair, Texts, Values
from cmtof_book import provenance, record

PALETTE = {  # in the order in which lines take them
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
WIDTH = 8.4  # inches, of a figure as wide as a page
PAGE = 720  # px, of the book's text on a screen
LEGIBLE = 9  # px, of the smallest text there
TURN: Pair = (0.0, TAU)  # of a wrapped phase, rad


def begin(*, profile: str = "book", seed: int = 0) -> None:
    """Set the style, and the profile and seed stored with every result."""
    mpl.rcdefaults()
    plt.style.use("cmtof_book.book")
    mpl.rc("axes", prop_cycle=cycler(color=PALETTE.values()))
    # a notebook shows a figure when it is saved, and only then
    plt.switch_backend("agg")
    provenance.RUN.update(profile=profile, seed=seed)


def image(
    ax: Axes,
    values: ArrayLike,
    *,
    label: str = "",
    title: str = "",
    cmap: str = DEPTH_CMAP,
    limits: Pair | None = None,
    bar: bool = True,
) -> AxesImage:
    """Image (H, W) with square pixels, no ticks, and a colour bar that names the unit; NaN is grey.

    ``label`` is quantity and unit, as in ``"depth (m)"``; ``limits`` are the values at the ends of
    the colour bar, by default those of the image.
    """
    drawn = ax.imshow(
        values, cmap=mpl.colormaps[cmap].with_extremes(bad="#B0B0B0"), clim=limits
    )
    ax.set_title(title)
    ax.set_axis_off()
    if bar:  # inside the panel's own frame it is exactly as high as the image, whatever its aspect
        colour_bar(drawn, cax=ax.inset_axes((1.03, 0, 0.05, 1)), label=label)
    return drawn


# wrapped phase (H, W) in [0, 2π), rad, with cyclic colours
phase_image = partial(image, label="phase (rad)", cmap=PHASE_CMAP, limits=TURN)


def grid(count: int, columns: int, aspect: float) -> tuple[Figure, list[Axes]]:
    """Figure and its ``count`` panels; ``aspect`` is the height over the width of their images."""
    rows = -(-count // columns)
    fig = plt.figure(figsize=(WIDTH, rows * ((WIDTH - 0.9) / columns * aspect + 0.35)))
    return fig, [fig.add_subplot(rows, columns, n + 1) for n in range(count)]


def colour_bar(drawn: AxesImage, *, label: str, **where: Any) -> None:
    """Add a colour bar; if it runs from 0 to 2π, its ticks are 0, π and 2π."""
    bar = drawn.figure.colorbar(drawn, label=label, **where)
    if drawn.get_clim() == TURN:
        bar.set_ticks([0, np.pi, TAU], labels=["0", "π", "2π"])


def mark(
    ax: Axes, *, x: float | None = None, y: float | None = None, text: str = ""
) -> None:
    """Thin grey reference line at ``x`` or at ``y``, with a text at its end."""
    style: Any = {"color": GREY, "lw": 1, "ls": ":", "zorder": 0}
    line = ax.axvline(x, **style) if y is None else ax.axhline(y, **style)  # pyright: ignore[reportArgumentType]
    ax.annotate(
        text,
        (x or 0, y or 0),
        xycoords=line.get_transform(),
        color="#59646E",
        size="small",
        textcoords="offset points",
        xytext=(3, 2),
        zorder=4,
        path_effects=[withStroke(linewidth=2.5, foreground="white")],  # on lines
    )


def sweep(
    ax: Axes,
    x: ArrayLike,
    values: ArrayLike,
    *,
    errors: ArrayLike | None = None,
    bound: tuple[ArrayLike, ArrayLike] | None = None,
    bound_label: str = "",
    log: str = "xy",
    **style: Any,
) -> None:
    """Draw dots (N,) of a sweep, with error bars, and the line of a bound or theory.

    ``errors`` are half-lengths; ``bound`` holds settings and values. ``style`` is that of the dots;
    the line has their ``color``.
    """
    dots = {"fmt": "o", "ms": 4.5, "color": PALETTE["blue"], "lw": 1.2} | style
    if bound is not None:
        ax.plot(*bound, color=dots["color"], lw=1.4, label=bound_label)
    ax.errorbar(x, values, errors, **dots)
    ax.set(**{f"{axis}scale": "log" for axis in log})


def intervals(
    ax: Axes,
    rows: Named,
    *,
    colors: Texts,
    published: Values,
) -> None:
    """Draw (value, low, high) as dot and bar, a row a name, the first on top; paper: diamonds."""
    for place, (name, (value, *ends)) in enumerate(rows.items()):
        ax.plot(ends, [place, place], color=colors[name], lw=3, alpha=0.45)
        ax.plot(value, place, "o", color=colors[name], ms=5)
    ax.plot(
        [published.get(name, np.nan) for name in rows],
        range(len(rows)),
        "D",
        mfc="none",
        mec="black",
        ms=5,
        label="the paper, its own scenes",
    )
    _name_rows(ax, rows)


def dots(ax: Axes, series: Named, rows: Sequence[str]) -> None:
    """Draw dots of series (R,), each with its own marker, over R named rows, the first on top."""
    for number, (label, values) in enumerate(series.items()):
        ax.plot(
            values,
            np.arange(len(rows)) + 0.12 * number,
            "osD^vP"[number],
            ms=6,
            label=label,
        )
    _name_rows(ax, rows)


def _name_rows(ax: Axes, rows: Collection[str]) -> None:
    """Write names of rows at the left, the first on top."""
    ax.set_yticks(range(len(rows)), rows)
    ax.set_ylim(len(rows) - 0.3, -0.6)  # room for all dots of the first and last row


def label_panels(axes: Iterable[Axes]) -> None:
    """Put (a), (b), … before the titles of panels, in the order given."""
    for letter, ax in zip(ascii_lowercase, axes, strict=False):
        ax.set_title(f"({letter}) {ax.get_title()}".rstrip(), loc="left")
        ax.set_title("")


def points(fig: Figure) -> Iterator[tuple[int, str, float, float]]:
    """Panel, name, x and y of all points of lines and bands, without clouds of more than 10,000."""
    for panel, ax in enumerate(fig.axes):
        drawn = [(line, line.get_xydata()) for line in ax.lines]
        for band in ax.findobj(PolyCollection):
            drawn += [(band, path.vertices) for path in band.get_paths()]
        for artist, found in drawn:
            if len(found) <= 10_000:  # pyright: ignore[reportArgumentType]
                name = str(artist.get_label()).lstrip("_")
                yield from ((panel, name, *xy) for xy in np.round(found, 9))  # pyright: ignore[reportArgumentType, reportCallIssue]


def smallest_text(fig: Figure) -> float:
    """Size of the smallest text of a figure on a page, px; indices and powers have 0.7 of it."""
    fig.draw_without_rendering()  # or numbers at the axes would be no texts yet
    sizes = [
        text.get_fontsize() * 0.7 ** bool(re.search(r"\$.*[\^_]", text.get_text()))  # pyright: ignore[reportOperatorIssue]
        for text in fig.findobj(Text)
        if text.get_text().strip()
    ]
    return min(sizes, default=np.inf) * PAGE / 72 / max(fig.get_figwidth(), WIDTH)


def _save_space(path: Path) -> None:
    """Keep 256 colours of a picture if that changes them by less than 1 % on average."""
    drawn = Image.open(path).convert("RGB")
    few = drawn.quantize(256, kmeans=1, dither=Image.Dither.NONE)
    lost = np.subtract(few.convert("RGB"), drawn, dtype=float)  # pyright: ignore[reportArgumentType, reportCallIssue]
    kept = few if np.abs(lost).max(-1).mean() < 2.55 else drawn
    kept.save(path, "PNG", optimize=True)


def save(
    fig: Figure,
    name: str,
    *,
    numbers: Named | None = None,
    caption: str,
    alt: str,
    format: Literal["svg", "png"] = "svg",
    folded: bool = False,
) -> None:
    """Save a figure with the numbers it shows, close it, and display it in a notebook.

    Writes ``name.svg`` or ``name.png`` (for large images), the same bytes on every run,
    ``name.json`` with ``numbers``, and ``name.csv`` with the points of lines, if any. ``name`` is
    ``figNN_topic`` with the paper's number, or ``topic_name``; ``numbers`` are finite scalars and
    short lists that others use: tests compare those with a kind (`cmtof_book.compared`);
    ``caption`` is in MyST Markdown. A ``folded`` figure is shown on demand. Raises ValueError if
    the name or one of the numbers cannot be used, or text would be too small on a page.
    """
    if (smallest := smallest_text(fig)) < LEGIBLE:
        raise ValueError(
            f"Expected text of {LEGIBLE} px, got {smallest:.1f}. Narrow {name}."
        )
    if not re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)+", name):
        raise ValueError(
            f"Expected a stem like fig03_precision, got {name!r}. Use underscores."
        )
    target = provenance.output_folder() / f"{name}.{format}"
    words = {"caption": caption, "alt": alt}
    record.write(name, numbers or {}, figure=target.name, **words)
    if plotted := [*points(fig)]:
        with target.with_suffix(".csv").open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([("panel", "line", "x", "y"), *plotted])
    with atomic_output(target) as part:
        # a drawing would else carry the date and the version of the library that drew it
        fig.savefig(part, format=format, metadata={"Date": None, "Creator": None})
        if format == "png":  # which stores pixels alone
            _save_space(part)
    plt.close(fig)
    _publish(target, name=name, csv=bool(plotted), folded=folded, **words)


def _publish(picture: Path, **about: Any) -> None:
    """Display a picture and its caption in a notebook, with what the book needs to place them."""
    from IPython.core.getipython import get_ipython

    if get_ipython():
        if picture.suffix == ".svg":
            drawn = {"image/svg+xml": picture.read_text("utf-8")}
        else:
            drawn = {"image/png": picture.read_bytes()}
        record.show(drawn | {"text/plain": about["alt"]}, "figure", **about)
        # pages put captions themselves
        record.show({"text/markdown": f"*Figure.* {about['caption']}"}, "caption")
