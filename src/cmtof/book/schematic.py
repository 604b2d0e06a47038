"""Drawing of the instrument: the light's path, and who commands whom, from rig file and settings.

A map of the optical table of Fig. 6, not to scale. Light goes out in strong green and comes back in
pale green. The numbers, terminals and addresses in it are read from the settings, so it shows the
rig that is there. What the read-out switches carries the name of its terminal; every controlled
device carries a number that stands again in the row of addresses below.
"""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch, Polygon, Rectangle

from cmtof.book.plotting import PALETTE
from cmtof.book.schematic_parts import (
    BACK,
    BACK_ARROW,
    BEAM,
    INK,
    METAL,
    SMALL,
    arrow,
    badge,
    box,
    cube,
    lens,
    mirror,
    ray,
    region,
    tag,
    wire,
)
from cmtof.hardware.rig import DeviceSettings, Rig
from cmtof.instrument.settings import Module, TwinSettings

SIZE = (17.2, 10.5)
"""Width and height of the drawing, in units of its axes."""

_OUT, _MAIN, _IN = 9.0, 6.7, 4.4  # heights of the three rows of light
_GAP = 0.08  # between light that goes and light that returns
_RF, _CLOCK, _SIGNAL = PALETTE["vermillion"], PALETTE["blue"], PALETTE["purple"]
_NAMES = {
    "rf_emission": "RF driver, emission",
    "rf_detection": "RF driver, detection",
    "clock": "function generator",
    "daq": "read-out, outputs",
    "plate_emission": "wave plate, emission",
    "plate_detection": "wave plate, detection",
    "stage": "target stage",
    "power_meter": "power meter",
}


def draw_instrument(ax: Axes, rig: Rig, twin: TwinSettings) -> None:
    """Draw the instrument of a rig file on axes of `SIZE`.

    Parameters
    ----------
    ax : Axes
        Empty axes; their frame is removed.
    rig : Rig
        Devices, addresses, lines, frequencies. A device that is missing is not drawn.
    twin : TwinSettings
        Powers and properties of the parts, for the simulated instrument.
    """
    ax.set(xlim=(0, SIZE[0]), ylim=(0.4, 0.4 + SIZE[1]), aspect="equal")
    ax.axis("off")
    numbers = {role: place for place, role in enumerate(rig.devices, 1)}
    region(ax, (4.75, 8.12), (10.05, 9.85), "emission module")
    region(ax, (9.95, 3.52), (15.25, 5.22), "detection module")
    _outward(ax, numbers)
    _return(ax)
    _source(ax, rig, twin)
    _module(ax, (5.4, _OUT), twin.emission, numbers.get("plate_emission"))
    _module(ax, (10.6, _IN), twin.detection, numbers.get("plate_detection"))
    _table(ax, rig, numbers)
    _scanner(ax, rig, twin)
    _detector(ax, twin)
    _radio(ax, rig, twin, numbers)
    _read_out(ax, rig, numbers)
    _legend(ax)
    _addresses(ax, rig.devices)


# --- light ------------------------------------------------------------------------------------


def _outward(ax: Axes, numbers: Mapping[str, int]) -> None:
    """Light to the scene, and what the splitters take of it."""
    up, down, m = _OUT + _GAP, _OUT - _GAP, _MAIN + _GAP
    ray(ax, [(3.75, up), (9.55, up)])
    ray(ax, [(9.55, down), (5.4, down), (5.4, m), (9.4, m)], alpha=0.75)
    ray(ax, [(9.4, m), (12.62, m), (12.62, 8.08), (15.5, 8.08)], alpha=0.75)
    for aim in (8.9, 7.1):  # where else the mirrors can send it
        ax.plot([13.0, 15.5], [8.0, aim], color=BEAM, lw=1.1, alpha=0.35, ls=(0, (4, 3)), zorder=1)
    for x, y in ((6.05, up), (9.1, up), (6.3, m), (8.3, m), (10.2, m), (14.0, 8.08)):
        arrow(ax, (x, y), (1, 0), BEAM)
    arrow(ax, (5.4, 7.9), (0, -1), BEAM)
    ray(ax, [(9.4, _MAIN), (9.4, 7.98)], alpha=0.3)
    if "power_meter" in numbers:
        ray(ax, [(7.2, _MAIN), (7.2, 5.75)], alpha=0.6)
        arrow(ax, (7.2, 6.15), (0, -1), BEAM)
    if "stage" in numbers:
        ray(ax, [(11.3, _MAIN), (11.3, 8.5)], alpha=0.3)


def _return(ax: Axes) -> None:
    """Light from the scene, through the splitter into the detection module."""
    m, low, high = _MAIN - _GAP, _IN - _GAP, _IN + _GAP
    to_scene = [(15.5, 7.92), (12.78, 7.92), (12.78, m), (9.4, m)]
    ray(ax, [*to_scene, (9.4, high), (14.75, high)], colour=BACK)
    ray(ax, [(14.75, low), (10.6, low), (10.6, 3.1)], colour=BACK)
    for x, y, dx, dy in ((14.6, 7.92, -1, 0), (12.2, m, -1, 0), (9.4, 6.1, 0, -1)):
        arrow(ax, (x, y), (dx, dy), BACK_ARROW)
    for x in (9.9, 11.2, 14.25):
        arrow(ax, (x, high), (1, 0), BACK_ARROW)
    arrow(ax, (10.6, 3.98), (0, -1), BACK_ARROW)


def _source(ax: Axes, rig: Rig, twin: TwinSettings) -> None:
    """Laser, shutter, fibre and beam reducer."""
    laser, y = twin.laser, _OUT
    text = f"laser\n{1e9 * laser.wavelength:.0f} nm, {1e3 * laser.power:.0f} mW"
    ray(ax, [(1.8, y), (2.6, y)])
    box(ax, (1.0, y), (1.7, 0.9), text)
    tag(ax, 0.62, y - 0.75, rig.lines.laser)
    tag(ax, 1.0, y + 0.72, f"{rig.lines.interlock} interlock")
    ax.add_patch(Rectangle((2.14, y - 0.36), 0.12, 0.72, fc=INK, zorder=4))
    ax.text(2.2, y + 0.48, "shutter", ha="center", va="bottom", fontsize=SMALL)
    tag(ax, 2.2, y - 0.75, rig.lines.shutter)
    along = np.linspace(0, 2 * np.pi, 200)
    x = 2.6 + 1.15 * along / (2 * np.pi) + 0.30 * np.sin(along)
    ax.plot(x, y + 0.21 * (1 - np.cos(along)), color=PALETTE["orange"], lw=2.2, zorder=3)
    low, high = 100 * laser.fibre_low, 100 * laser.fibre_high
    words = {"ha": "center", "fontsize": SMALL}
    ax.text(3.18, y - 0.25, f"fibre\n{low:.0f}–{high:.0f} %", va="top", **words)
    for place, height in ((4.0, 0.8), (4.5, 0.45)):
        lens(ax, place, y, height)
    ax.text(4.1, y + 0.48, "2.5×", va="bottom", **words)


def _module(ax: Axes, at: tuple[float, float], module: Module, plate: int | None) -> None:
    """Splitter, plates, crystal and mirror of a two-pass modulator, to the right of ``at``."""
    x, y = at
    cube(ax, x, y, "/", "PBS")
    for place, name in ((1.05, "HWP"), (1.6, "QWP")):
        lens(ax, x + place, y, 0.86)
        ax.text(x + place, y + 0.5, name, ha="center", va="bottom", fontsize=SMALL)
    if plate is not None:
        badge(ax, x + 1.05, y - 0.66, plate)
    style = {"fc": "#FFF1D6", "ec": "#C28A1B", "lw": 1.2, "zorder": 3}
    ax.add_patch(Rectangle((x + 2.1, y - 0.32), 1.3, 0.64, **style))
    ax.text(x + 2.75, y, "EOM", ha="center", va="center", fontsize=9, weight="bold", zorder=6)
    mirror(ax, x + 4.2, y, 90)
    bar = {"arrowstyle": "<->", "color": INK, "lw": 0.8, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", (x + 4.15, y - 0.5), (x + 2.75, y - 0.5), arrowprops=bar)
    spacing = f"{1e3 * module.mirror_distance:.0f} mm"
    ax.text(x + 2.65, y - 0.51, spacing, ha="right", va="center", fontsize=SMALL)


def _table(ax: Axes, rig: Rig, numbers: Mapping[str, int]) -> None:
    """What stands between the emission module and the scan mirrors."""
    m = _MAIN
    mirror(ax, 5.4, m, -45)
    if "power_meter" in numbers:
        cube(ax, 7.2, m, "\\", "NBS")
        box(ax, (7.2, 5.47), (1.5, 0.55), "power meter")
        badge(ax, 8.18, 5.47, numbers["power_meter"])
    cube(ax, 9.4, m, "/", "NBS")
    ax.add_patch(Rectangle((9.08, 7.36), 0.64, 0.11, fc=INK, zorder=4))
    tag(ax, 8.25, 7.42, f"{rig.lines.beam_block} beam block")
    mirror(ax, 9.4, 7.98, 0)
    ax.text(8.9, 7.93, "reference arm", ha="right", va="center", fontsize=SMALL)
    if "stage" in numbers:
        mirror(ax, 11.3, m, 45, alpha=0.55)
        tag(ax, 10.95, 6.18, f"{rig.lines.flip_mirror} flip mirror")
        ax.add_patch(Rectangle((10.95, 8.5), 0.7, 0.14, fc=METAL, ec=INK, zorder=4))
        words = f"target at {rig.reference.distance:.2f} m"
        ax.text(11.3, 8.8, words, ha="center", va="bottom", fontsize=SMALL)
        badge(ax, 11.95, 8.57, numbers["stage"])
    mirror(ax, 9.4, _IN, -45)
    for height, width in ((5.78, 0.8), (5.36, 0.5)):
        lens(ax, 9.4, height, width, upright=False)
    ax.text(8.9, 5.36, "1.6×", ha="right", va="center", fontsize=SMALL)


def _scanner(ax: Axes, rig: Rig, twin: TwinSettings) -> None:
    """Folding mirror, scan mirrors and the scene."""
    for height in (_MAIN, 8.0):
        mirror(ax, 12.7, height, 45)
    swing = {"arrowstyle": "<->", "mutation_scale": 8, "color": INK, "lw": 0.9}
    ax.add_patch(
        FancyArrowPatch((12.85, 8.5), (13.2, 8.15), connectionstyle="arc3,rad=-0.3", **swing)
    )
    ax.text(12.95, 8.9, "galvo", ha="right", va="bottom", fontsize=9, weight="bold")
    tag(ax, 13.75, 9.0, f"{rig.galvo.x} · {rig.galvo.y}")
    words = f"aperture\n{1e3 * twin.optics.aperture:.1f} mm"
    ax.text(13.05, 7.3, words, fontsize=SMALL, va="center", linespacing=1.3)
    y = np.linspace(6.9, 9.1, 120)
    x = 15.3 + 0.22 * np.sin(2.6 * y) + 0.12 * np.sin(7 * y)
    outline = np.concatenate([np.stack([x, y], 1), [[16.3, 9.1], [16.3, 6.9]]])
    ax.add_patch(Polygon(outline, fc="#ECE7DE", ec="#A79A84", lw=1.2, zorder=3))
    text = ax.text(15.9, 8.0, "scene", ha="center", va="center", fontsize=9, weight="bold")
    text.set(rotation=90, zorder=4)


def _detector(ax: Axes, twin: TwinSettings) -> None:
    """Lens, avalanche diode and the filters behind it."""
    detector, y = twin.detector, 2.72
    lens(ax, 10.6, 3.45, 0.7, upright=False)
    box(ax, (10.6, y), (1.5, 0.75), f"APD\nM = {detector.gain:.0f}", fill="#EFE6F1")
    box(ax, (8.55, y), (1.35, 0.75), f"low pass\n{detector.low_pass / 1e3:.0f} kHz")
    box(ax, (6.85, y), (1.15, 0.75), f"RC\n{1e6 * detector.rc_time:.0f} µs")
    for start, end in ((9.85, 9.225), (7.875, 7.425), (6.275, 5.6)):
        wire(ax, [(start, y), (end, y)], _SIGNAL)


# --- electronics ------------------------------------------------------------------------------


def _radio(ax: Axes, rig: Rig, twin: TwinSettings, numbers: Mapping[str, int]) -> None:
    """RF drivers, their clock, and the trigger of the phase table."""
    low, high = rig.drive.frequency_single / 1e9, rig.drive.frequency_doubled / 1e9
    text = f"RF driver, {low:.2f} or {high:.2f} GHz"
    for role, x, y, to in (
        ("rf_emission", 8.15, 10.45, _OUT + 0.32),
        ("rf_detection", 13.35, 5.68, _IN + 0.32),
    ):
        if role in numbers:
            box(ax, (x, y), (3.1, 0.5), text)
            badge(ax, x - 1.78, y, numbers[role])
            wire(ax, [(x, y - 0.25), (x, to)], _RF)
    ax.text(8.3, 10.03, rf"$\eta$ = {twin.drive.eta:.2f} rad", va="center", fontsize=SMALL)
    if "clock" in numbers:
        wire(ax, [(13.4, 10.45), (9.7, 10.45)], _CLOCK)
        wire(ax, [(13.4, 10.45), (16.8, 10.45), (16.8, 5.68), (14.9, 5.68)], _CLOCK)
        box(ax, (13.4, 10.45), (1.9, 0.5), "clock, 10 MHz")
        badge(ax, 13.4, 10.02, numbers["clock"])
    if "rf_detection" in numbers:
        tag(ax, 14.3, 5.42, f"{rig.lines.trigger} trigger")


def _read_out(ax: Axes, rig: Rig, numbers: Mapping[str, int]) -> None:
    if "daq" not in numbers:
        return
    reading = rig.detection
    text = (
        f"LabJack T7\n{reading.channel}: {reading.phases} phases × {reading.samples_per_phase} "
        f"samples\nat {reading.rate / 1e3:.0f} kS/s"
    )
    box(ax, (4.0, 2.85), (3.2, 1.05), text)
    badge(ax, 2.15, 2.85, numbers["daq"])


def _legend(ax: Axes) -> None:
    """What the colours mean, at the left of the table."""
    entries = (
        (BEAM, 2.4, "light to the scene"),
        (BACK, 2.4, "light from the scene"),
        (_RF, 1.5, "drive of the modulators"),
        (_CLOCK, 1.5, "clock"),
        (_SIGNAL, 1.5, "signal"),
    )
    for place, (colour, width, words) in enumerate(entries):
        y = 6.55 - 0.36 * place
        ax.add_line(Line2D([0.35, 0.95], [y, y], color=colour, lw=width))
        ax.text(1.1, y, words, va="center", fontsize=SMALL)
    tag(ax, 0.65, 4.72, "FIO")
    ax.text(1.1, 4.72, "terminal of the T7", va="center", fontsize=SMALL)
    badge(ax, 0.65, 4.33, 1)
    ax.text(1.1, 4.33, "device with an address", va="center", fontsize=SMALL)


def _addresses(ax: Axes, devices: Mapping[str, DeviceSettings]) -> None:
    """Row of every controlled device with its driver and address, wired to the host."""
    width = SIZE[0] / max(len(devices), 1)
    ax.plot([0.2, SIZE[0] - 0.2], [1.7, 1.7], color=INK, lw=1.4)
    ax.text(0.2, 1.78, "host", va="bottom", fontsize=9, weight="bold")
    for number, (role, device) in enumerate(devices.items(), 1):
        x = (number - 0.5) * width
        badge(ax, x, 1.7, number)
        lines = [_NAMES.get(role, role), device.driver, *_where(device)]
        ax.text(x, 1.42, "\n".join(lines), ha="center", va="top", fontsize=7, linespacing=1.4)


def _where(device: DeviceSettings) -> list[str]:
    """Address, and that of the stream, without what would not fit."""
    found = [device.address, *([device.stream] if device.stream else [])]
    return [one.partition("?")[0].removeprefix("tcp://").removeprefix("serial:") for one in found]
