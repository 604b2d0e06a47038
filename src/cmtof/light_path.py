"""Pictures of the two-pass modulator: its light path, polarisation ellipses, Poincaré sphere."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Ellipse, FancyArrowPatch, Rectangle
from numpy.typing import ArrayLike

from cmtof.book.plotting import PALETTE
from cmtof.constants import FREQUENCY_SINGLE, SPEED_OF_LIGHT
from cmtof.jones import stokes
from cmtof.modulator import TwoPassModulator

DRIVE_COLOURS = (PALETTE["sky"], PALETTE["black"], PALETTE["orange"])
"""Colours of the drive at its least, none and its most."""

_BEAM = "#00A86B"  # what 532 nm looks like, darkened to be seen on white
_GLASS, _GLASS_EDGE = "#DCEBF7", "#6B8CA8"
# where the ellipses stand: before the HWP, before the QWP, before the EOM, before the mirror
_STATIONS = (3.15, 4.85, 6.6, 10.1)
_FORWARD = ("PBS in", "HWP", "QWP", "EOM")
_RETURN = ("HWP back", "QWP back", "EOM back", "mirror")


def draw_elements(ax: Axes) -> None:
    """Draw the elements and the folded beam of Fig. 7 on axes of 12.4 by about 3 units.

    Vertical light is what the splitter reflects, so the laser stands above it; what comes back
    horizontal passes straight through to the left.
    """
    ax.set(xlim=(-0.3, 12.2), aspect="equal")
    ax.axis("off")
    _draw_beam(ax)
    ax.add_patch(Rectangle((1.6, -0.5), 1, 1, fc=_GLASS, ec=_GLASS_EDGE, lw=1.4, zorder=1))
    ax.plot([1.6, 2.6], [0.5, -0.5], color=_GLASS_EDGE, lw=1.8, zorder=4)
    for x, name in ((4.0, "HWP"), (5.7, "QWP")):
        ax.add_patch(Ellipse((x, 0), 0.26, 1.3, fc=_GLASS, ec=_GLASS_EDGE, lw=1.4, zorder=3))
        ax.text(x, 0.85, name, ha="center", weight="bold")
    ax.add_patch(Rectangle((7.5, -0.42), 1.7, 0.84, fc="#FFF1D6", ec="#C28A1B", lw=1.4, zorder=3))
    wave = np.linspace(0, 1, 80)
    ax.plot(
        7.75 + 1.2 * wave, 0.85 + 0.14 * np.sin(4 * np.pi * wave), color=PALETTE["orange"], lw=2
    )
    ax.plot([8.35, 8.35], [0.42, 0.68], color="#C28A1B", lw=1.4)
    ax.text(8.35, 1.15, r"$V=\eta\,\sin\,\omega t$", ha="center", va="bottom")
    ax.text(8.35, 0, "EOM", ha="center", va="center", weight="bold", zorder=6)
    ax.add_patch(Rectangle((11.1, -0.62), 0.16, 1.24, fc="#9AA4AD", ec="#5A646D", zorder=5))
    ax.text(11.18, 0.85, "mirror", ha="center", weight="bold")
    ax.annotate(
        "", (11.1, -0.78), (8.35, -0.78), arrowprops={"arrowstyle": "<->", "color": "#5A646D"}
    )
    spacing = 1e3 * SPEED_OF_LIGHT / (2 * FREQUENCY_SINGLE)
    ax.text(9.75, -0.9, rf"$c/2f$ = {spacing:.0f} mm", ha="center", va="top", color="#3C454C")
    ax.text(1.45, 0.62, "PBS", ha="right", weight="bold")
    ax.text(2.35, 1.42, "laser", va="center", weight="bold")
    for x, name, colour in zip((2.9, 4.6, 5.9), ("−η", "0", "+η"), DRIVE_COLOURS, strict=True):
        ax.plot([x, x + 0.4], [-1.1, -1.1], color=colour, lw=3)
        ax.text(x + 0.5, -1.1, f"V = {name}", va="center")


def _draw_beam(ax: Axes) -> None:
    ax.plot([2.1, 2.1, 11.1], [1.7, 0.1, 0.1], color=_BEAM, lw=3.2, alpha=0.9, zorder=2)
    ax.plot([11.1, 0.55], [-0.1, -0.1], color=_BEAM, lw=3.2, alpha=0.45, zorder=2)
    for start, end in (((2.1, 1.5), (2.1, 0.9)), ((9.7, 0.1), (10.3, 0.1))):
        _arrow(ax, start, end, 0.9)
    for x in (10.0, 3.3):
        _arrow(ax, (x + 0.2, -0.1), (x - 0.3, -0.1), 0.6)
    x = np.linspace(-0.1, 0.9, 200)
    swing = 0.18 * np.sin(2 * np.pi * x / 0.3)
    ax.fill_between(x, -0.1 - np.abs(0.2 + swing), -0.1 + np.abs(0.2 + swing), color=_BEAM, lw=0)
    ax.text(0.4, -0.72, r"out, $I(t)$", ha="center", va="top", weight="bold")


def _arrow(ax: Axes, start: tuple[float, float], end: tuple[float, float], alpha: float) -> None:
    ax.add_patch(
        FancyArrowPatch(
            start,
            end,
            arrowstyle="-|>",
            mutation_scale=17,
            color=_BEAM,
            alpha=alpha,
            lw=0,
            zorder=4,
        )
    )


def draw_states(ax: Axes, modulator: TwoPassModulator, *, top: float, title: str) -> None:
    """Draw polarisation ellipses under the light path: the way out above, the way back below.

    Parameters
    ----------
    ax : Axes
        Axes of `draw_elements`.
    modulator : TwoPassModulator
        Setting; its drive at -eta, 0 and +eta gives the three colours.
    top : float
        Height of the upper row, in units of the axes.
    title : str
        Name of the mode, at the left of the rows.
    """
    states = modulator.states(modulator.eta * np.array([-1.0, 0.0, 1.0]))
    low = top - 1.25
    ax.text(-0.05, top, title, va="center", linespacing=1.5)
    bend = 11.0 + 0.625 * np.cos(np.linspace(np.pi / 2, -np.pi / 2, 40))
    level = (top + low) / 2 + 0.625 * np.sin(np.linspace(np.pi / 2, -np.pi / 2, 40))
    ax.plot([2.3, *bend, 0.4], [top, *level, low], color=_BEAM, lw=1.6, alpha=0.35, zorder=0)
    for x, y, step in ((8.4, top, 0.2), (8.4, low, -0.2), (1.75, low, -0.2)):
        _arrow(ax, (x, y), (x + step, y), 0.45)
    for y, names in ((top, _FORWARD), (low, _RETURN)):
        for x, name in zip(_STATIONS, names, strict=True):
            draw_ellipses(ax, states[name], centre=(x, y), radius=0.45)
    draw_ellipses(ax, states["PBS out"], centre=(0.4, low), radius=0.45, spread=0.14)


def draw_ellipses(
    ax: Axes,
    fields: ArrayLike,
    *,
    centre: tuple[float, float],
    radius: float,
    spread: float = 0.0,
) -> None:
    """Draw the polarisation ellipses of Jones vectors (3, 2) or (2,) in `DRIVE_COLOURS`.

    Horizontal to the right, vertical up; the path is Re(E exp(i w t)) with an arrow for its sense,
    and the grey circle is the size of full intensity in linear light. ``spread`` sets the three
    apart vertically where they would hide each other.
    """
    x, y = centre
    ax.add_patch(Circle(centre, radius, fc="#F4F4F4", ec="#C8C8C8", lw=0.8, zorder=1))
    turn = np.exp(1j * np.linspace(0, 2 * np.pi, 121))
    states = np.atleast_2d(np.asarray(fields, complex))
    if len(states) == 1:
        _draw_ellipse(ax, radius * np.real(states[0, :, None] * turn), x, y, PALETTE["black"])
        return
    for state, colour, place in zip(states, DRIVE_COLOURS, (1, 0, -1), strict=True):
        path = radius * np.real(state[:, None] * turn)
        _draw_ellipse(ax, path, x, y + place * spread, colour)


def _draw_ellipse(ax: Axes, path: np.ndarray, x: float, y: float, colour: str) -> None:
    ax.plot(x + path[0], y + path[1], color=colour, lw=1.8, solid_capstyle="round", zorder=5)
    size = np.hypot(*path)
    i = int(size[:-4].argmin())  # on the flat side, where arrows of several ellipses stay apart
    if size[i] > 0.03:  # an ellipse has a sense, a line has none
        arrow = {"arrowstyle": "-|>", "color": colour, "shrinkA": 0, "shrinkB": 0, "lw": 0}
        tip, tail = path[:, i + 3] + (x, y), path[:, i] + (x, y)
        ax.annotate("", (tip[0], tip[1]), (tail[0], tail[1]), arrowprops=arrow, zorder=6)


# --- Poincaré sphere ---------------------------------------------------------------------------


def sphere_points(fields: ArrayLike, *, azimuth: float) -> tuple[np.ndarray, np.ndarray]:
    """Horizontal place and depth (...) of Jones vectors on a sphere seen from ``azimuth``, rad.

    S1 points up, so the height of a state is S1/S0 and ``(1 + S1/S0)/2`` the fraction that a
    horizontal polariser passes. Depth is positive on the near side.
    """
    s = stokes(fields)
    s2, s3 = s[..., 2] / s[..., 0], s[..., 3] / s[..., 0]
    return s3 * np.cos(azimuth) - s2 * np.sin(azimuth), s2 * np.cos(azimuth) + s3 * np.sin(azimuth)


def draw_sphere(ax: Axes, *, azimuth: float) -> None:
    """Draw the empty sphere, horizontal light at the top, seen from ``azimuth``, rad."""
    ax.set(xlim=(-1.3, 1.3), aspect="equal")
    ax.axis("off")
    grid = np.linspace(-1, 1, 240)
    gx, gy = np.meshgrid(grid, grid)
    light = np.clip(1 - 0.55 * np.hypot(gx + 0.35, gy - 0.4), 0, 1)
    shade = np.dstack([0.80 + 0.18 * light, 0.86 + 0.13 * light, 0.92 + 0.08 * light])
    shown = ax.imshow(
        shade, extent=(-1, 1, -1, 1), origin="lower", interpolation="bilinear", zorder=0
    )
    rim = Circle((0, 0), 1, fc="none", ec="#7C8A96", lw=1.2, zorder=2)
    ax.add_patch(rim)
    shown.set_clip_path(rim)
    height = np.linspace(-np.pi / 2, np.pi / 2, 91)
    for meridian in np.arange(0, np.pi, np.pi / 6):
        for side in (0, np.pi):
            x = np.cos(height) * np.sin(meridian + side - azimuth)
            near = np.cos(meridian + side - azimuth) > 0
            ax.plot(x, np.sin(height), color="white" if near else "#B9C6D2", lw=0.8, zorder=1)
    for level in (-0.5, 0.0, 0.5):
        half = np.sqrt(1 - level**2)
        ax.plot([-half, half], [level, level], color="white", lw=0.8, zorder=1)
    for y, name in ((1, "H"), (-1, "V")):
        ax.plot(0, y, "o", ms=5, color="#3C454C", zorder=6)
        ax.text(0, 1.13 * y, name, ha="center", va="center", weight="bold")


def draw_trace(
    ax: Axes, fields: ArrayLike, *, azimuth: float, colour: str, width: float, label: str = ""
) -> None:
    """Draw the path of Jones vectors (N, 2) on the sphere of `draw_sphere`."""
    x, depth = sphere_points(fields, azimuth=azimuth)
    s = stokes(fields)
    y = s[..., 1] / s[..., 0]
    near = depth >= -1e-9
    options = {"color": colour, "lw": width, "solid_capstyle": "round"}
    ax.plot(np.where(near, x, np.nan), np.where(near, y, np.nan), zorder=5, label=label, **options)
    ax.plot(np.where(near, np.nan, x), np.where(near, np.nan, y), ls=":", zorder=4, **options)
