"""Pieces of the instrument's drawing: rays, cubes, lenses, mirrors, boxes, tags and wires."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Ellipse, FancyBboxPatch, Polygon, Rectangle

from cmtof.book.plotting import PALETTE

BEAM, BACK, BACK_ARROW = "#00A86B", "#8FD9BC", "#4FBF94"
"""532 nm darkened to be seen on white; the same, returned; and its arrows."""

GLASS, GLASS_EDGE, METAL, INK = "#DCEBF7", "#6B8CA8", "#9AA4AD", "#3C454C"
"""Fills and edges of optics, mirrors, text."""

SMALL = 7.6
"""Size of most texts, points."""

Points = list[tuple[float, float]]


def ray(ax: Axes, points: Points, *, colour: str = BEAM, alpha: float = 1.0) -> None:
    """Draw a beam along points."""
    x, y = zip(*points, strict=True)
    ax.plot(x, y, color=colour, lw=2.4, alpha=alpha, zorder=2, solid_joinstyle="miter")


def arrow(ax: Axes, at: tuple[float, float], step: tuple[float, float], colour: str) -> None:
    """Draw an arrow head that begins at a place and points along a unit step."""
    tail, along = np.array(at), np.array(step)
    across = np.array([-along[1], along[0]]) * 0.105
    corners = [tail + 0.25 * along, tail + across, tail - across]
    ax.add_patch(Polygon(corners, fc=colour, lw=0, zorder=4))


def wire(ax: Axes, points: Points, colour: str) -> None:
    """Draw a cable along points, with an arrow at its end."""
    x, y = zip(*points, strict=True)
    ax.plot(x, y, color=colour, lw=1.5, zorder=2)
    step = np.array(points[-1]) - np.array(points[-2])
    step = step / np.hypot(*step)
    tail = np.array(points[-1]) - 0.25 * step
    arrow(ax, (tail[0], tail[1]), (step[0], step[1]), colour)


def cube(ax: Axes, x: float, y: float, diagonal: str, name: str) -> None:
    """Draw a beam splitter; its layer rises ("/") or falls to the right."""
    half = 0.36
    place = (x - half, y - half)
    ax.add_patch(
        Rectangle(place, 0.72, 0.72, fc=GLASS, ec=GLASS_EDGE, lw=1.2, alpha=0.85, zorder=3)
    )
    rise = half if diagonal == "/" else -half
    ax.plot([x - half, x + half], [y - rise, y + rise], color=GLASS_EDGE, lw=1.6, zorder=4)
    ax.text(x - 0.4, y + 0.4, name, ha="right", va="bottom", fontsize=SMALL, weight="bold")


def lens(ax: Axes, x: float, y: float, size: float, *, upright: bool = True) -> None:
    """Draw a lens, or a plate: a thin ellipse across the beam."""
    width, height = (0.16, size) if upright else (size, 0.16)
    ax.add_patch(Ellipse((x, y), width, height, fc=GLASS, ec=GLASS_EDGE, lw=1.2, zorder=3))


def mirror(ax: Axes, x: float, y: float, degrees: float, *, alpha: float = 1.0) -> None:
    """Draw a mirror through a point, its surface at an angle to the horizontal."""
    turn = np.deg2rad(degrees)
    dx, dy = 0.42 * np.cos(turn), 0.42 * np.sin(turn)
    line = ax.plot([x - dx, x + dx], [y - dy, y + dy], color=METAL, lw=5, alpha=alpha, zorder=5)
    line[0].set_solid_capstyle("butt")


def box(
    ax: Axes,
    at: tuple[float, float],
    size: tuple[float, float],
    text: str,
    *,
    fill: str = "#F3F5F7",
) -> None:
    """Draw a device, centred, with a text in it."""
    (x, y), (width, height) = at, size
    outline = FancyBboxPatch(
        (x - width / 2, y - height / 2),
        width,
        height,
        boxstyle="round,pad=0,rounding_size=0.1",
        fc=fill,
        ec="#7C8A96",
        lw=1.1,
        zorder=3,
    )
    ax.add_patch(outline)
    ax.text(x, y, text, ha="center", va="center", fontsize=SMALL, zorder=6, linespacing=1.3)


def region(ax: Axes, low: tuple[float, float], high: tuple[float, float], name: str) -> None:
    """Shade a part of the table and name it in its lower right corner."""
    (x, y), width, height = low, high[0] - low[0], high[1] - low[1]
    style = "round,pad=0,rounding_size=0.25"
    shade = FancyBboxPatch((x, y), width, height, boxstyle=style, fc="#F4F8F6", ec="none", zorder=0)
    ax.add_patch(shade)
    text = ax.text(high[0] - 0.1, y + 0.07, name, ha="right", va="bottom", fontsize=8.5)
    text.set(color="#5C7A6C", style="italic")


def tag(ax: Axes, x: float, y: float, text: str) -> None:
    """Write the terminal that switches something."""
    frame = {"boxstyle": "round,pad=0.22", "fc": "#FFF6E0", "ec": PALETTE["orange"], "lw": 0.9}
    ax.text(x, y, text, ha="center", va="center", fontsize=7, bbox=frame, zorder=7)


def badge(ax: Axes, x: float, y: float, number: int) -> None:
    """Write the number of a controlled device."""
    ax.add_patch(Circle((x, y), 0.19, fc=PALETTE["blue"], ec="none", zorder=7))
    text = ax.text(x, y - 0.01, str(number), ha="center", va="center", color="white", fontsize=7.5)
    text.set(weight="bold", zorder=8)
