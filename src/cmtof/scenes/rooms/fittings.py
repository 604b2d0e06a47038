"""What the house itself carries on its walls: radiators, fireplaces, switches, pipes, vents.

All but the smoke detector, which hangs from z = 0, have their back at y = 0 and z = 0 at their
centre height; a fireplace stands on z = 0.
"""

from collections.abc import Callable

import numpy as np

from cmtof.scenes.rooms.bars import bar
from cmtof.scenes.rooms.materials import Material, Style, darker
from cmtof.scenes.rooms.solids import box, cylinder, joined, tube
from cmtof.scenes.rooms.thing import Mesh, Support, Thing, moved, pose

Maker = Callable[..., Thing]

WHITE = Material((0.8, 0.8, 0.78), specular=0.05, gloss=50.0)
SOOT = Material((0.02, 0.018, 0.016), (0.05, 0.045, 0.04), "noise", 0.1, specular=0.0)


def _lying(mesh: Mesh) -> Mesh:
    """An upright mesh turned so that its top looks towards -y."""
    turn = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])
    return moved(mesh, turn)


def radiator(
    rng: np.random.Generator,
    style: Style,
    *,
    width: float | None = None,
    height: float | None = None,
    design: str | None = None,
) -> Thing:
    """A radiator: cast ribs, a pressed panel or a ladder of tubes, with valve and pipes."""
    width = float(rng.uniform(0.6, 1.4)) if width is None else width
    height = float(rng.uniform(0.45, 0.6)) if height is None else height
    design = design or str(rng.choice(["ribs", "panel", "panel", "ladder"]))
    material = WHITE if rng.uniform() < 0.7 else style.metal
    thing = Thing("radiator")
    if design == "ribs":
        thing.add(_ribs(width, height), material)
    elif design == "panel":
        thing.add(_pressed(width, height), material)
    else:
        thing.add(_ladder(width, height), material)
    low, x = -height / 2, width / 2
    valve = [
        bar((x, -0.07, low + 0.06), (x + 0.05, -0.07, low + 0.06), 0.010),
        bar((x + 0.05, -0.07, low + 0.04), (x + 0.05, -0.07, low + 0.11), 0.018, 12),
        tube(
            [
                (x + 0.05, -0.07, low + 0.05),
                (x + 0.05, -0.07, low - 0.06),
                (x + 0.05, 0.0, low - 0.075),
            ],
            0.008,
        ),
        tube(
            [
                (-x, -0.07, low + 0.06),
                (-x - 0.04, -0.07, low + 0.05),
                (-x - 0.04, -0.07, low - 0.05),
                (-x - 0.04, 0.0, low - 0.075),
            ],
            0.008,
        ),
    ]
    hangers = [box((0.03, 0.05, 0.03), (s * 0.35 * width, -0.024, 0)) for s in (-1, 1)]
    return thing.add(joined([*valve, *hangers]), WHITE)


def _ribs(width: float, height: float) -> Mesh:
    count = max(4, round(width / 0.062))
    pitch = width / count
    pieces = []
    for k in range(count):
        x = -width / 2 + pitch * (k + 0.5)
        for y in (-0.06, -0.14):
            pieces.append(box((0.6 * pitch, 0.055, height), (x, y, 0), bevel=0.014))
    for z in (0.5 * height - 0.04, -0.5 * height + 0.04):
        pieces.append(box((width - 0.01, 0.09, 0.045), (0, -0.1, z), bevel=0.01))
    return joined(pieces)


def _pressed(width: float, height: float) -> Mesh:
    """Two plates with grooves, a grille on top, closed ends."""
    count = max(6, round(width / 0.04))
    pitch = width / count
    pieces = [
        box(
            (0.72 * pitch, 0.012, height - 0.06),
            (-width / 2 + pitch * (k + 0.5), -0.098, 0),
            bevel=0.004,
        )
        for k in range(count)
    ]
    pieces += [box((width, 0.012, height), (0, y, 0), bevel=0.004) for y in (-0.094, -0.042)]
    pieces += [
        box((0.004, 0.07, height - 0.01), (s * (width / 2 + 0.002), -0.068, 0)) for s in (-1, 1)
    ]
    slots = max(8, round(width / 0.03))
    for k in range(slots):
        x = -width / 2 + width * (k + 0.5) / slots
        pieces.append(box((0.012, 0.05, 0.004), (x, -0.068, height / 2 - 0.003)))
    return joined(pieces)


def _ladder(width: float, height: float) -> Mesh:
    """Two uprights and many rungs, as in bathrooms."""
    x, y = width / 2 - 0.02, -0.075
    pieces = [bar((s * x, y, -height / 2), (s * x, y, height / 2), 0.018, 10) for s in (-1, 1)]
    count = max(5, round(height / 0.065))
    for k in range(count):
        if k % 6 == 5:
            continue
        z = -height / 2 + height * (k + 0.5) / count
        pieces.append(bar((-x, y, z), (x, y, z), 0.011))
    return joined(pieces)


def fireplace(
    rng: np.random.Generator,
    style: Style,
    *,
    width: float | None = None,
) -> Thing:
    """A mantel around a hearth in front of the wall, with grate, logs and a slab."""
    width = float(rng.uniform(1.15, 1.4)) if width is None else width
    height, deep = float(rng.uniform(1.0, 1.25)), float(rng.uniform(0.18, 0.26))
    leg = float(rng.uniform(0.16, 0.24))
    marble = Material((0.72, 0.7, 0.66), (0.35, 0.33, 0.32), "marble", 0.25, 0.1, 120.0)
    stone = Material((0.35, 0.33, 0.3), (0.22, 0.21, 0.2), "noise", 0.06, 0.02)
    material = (marble, stone, style.trim, style.wood)[int(rng.integers(4))]
    open_w, open_h = width - 2 * leg, 0.62 * height
    thing = Thing("fireplace")
    y = -deep / 2
    pieces = []
    for s in (-1, 1):
        x = s * (width - leg) / 2
        pieces.append(box((leg, deep, height - 0.05), (x, y, (height - 0.05) / 2), bevel=0.005))
        pieces.append(box((leg + 0.03, 0.02, 0.12), (x, -deep - 0.008, 0.06), bevel=0.004))
        pieces.append(
            box(
                (0.55 * leg, 0.024, open_h - 0.2),
                (x, -deep - 0.004, 0.08 + open_h / 2),
                bevel=0.008,
            )
        )
        pieces.append(box((leg + 0.02, 0.03, 0.05), (x, -deep - 0.006, height - 0.1), bevel=0.008))
    lintel = height - 0.05 - open_h
    pieces.append(
        box((open_w + 0.01, deep - 0.012, lintel), (0, y, open_h + lintel / 2), bevel=0.004)
    )
    pieces.append(
        box((0.6 * open_w, 0.02, 0.5 * lintel), (0, -deep, open_h + 0.5 * lintel), bevel=0.008)
    )
    shelf = box((width + 0.16, deep + 0.08, 0.05), (0, y - 0.04, height - 0.025), bevel=0.008)
    thing.add(joined([*pieces, shelf]), material)
    inner = [
        box((open_w + 0.02, 0.008, open_h + 0.02), (0, -0.006, open_h / 2 + 0.01)),
        *[
            box((0.006, deep - 0.02, open_h), (s * (open_w / 2 - 0.004), y, open_h / 2))
            for s in (-1, 1)
        ],
    ]
    thing.add(joined(inner), SOOT)
    thing.add(
        box((width + 0.1, deep + 0.42, 0.03), (0, -(deep + 0.42) / 2, 0.015), bevel=0.004), stone
    )
    _grate(rng, thing, style, open_w, deep)
    reach = (-width / 2 - 0.05, width / 2 + 0.05, -deep - 0.06, -0.02, height)
    thing.supports.append(Support(*reach, clearance=0.6))
    return thing


def _grate(rng: np.random.Generator, thing: Thing, style: Style, width: float, deep: float) -> None:
    """Iron bars with logs on them, and a fender."""
    iron = Material((0.03, 0.03, 0.03), specular=0.08, gloss=20.0)
    y = -deep / 2 - 0.02
    irons = [
        bar((x * width, y - 0.07, 0.11), (x * width, y + 0.09, 0.11), 0.008)
        for x in np.linspace(-0.3, 0.3, 7)
    ]
    irons += [
        bar((s * 0.3 * width, y - 0.07, 0.03), (s * 0.3 * width, y - 0.07, 0.24), 0.01)
        for s in (-1, 1)
    ]
    rail = tube(
        [
            (-0.5 * width, -deep - 0.05, 0.16),
            (-0.5 * width, -deep - 0.3, 0.16),
            (0.5 * width, -deep - 0.3, 0.16),
            (0.5 * width, -deep - 0.05, 0.16),
        ],
        0.008,
    )
    posts = [
        bar((x * width, -deep - 0.3, 0.03), (x * width, -deep - 0.3, 0.16), 0.006)
        for x in np.linspace(-0.5, 0.5, 5)
    ]
    thing.add(joined([*irons, rail, *posts]), iron)
    bark = Material((0.2, 0.13, 0.08), (0.1, 0.06, 0.04), "noise", 0.02, 0.0)
    for k in range(4):
        r, half = float(rng.uniform(0.028, 0.05)), float(rng.uniform(0.18, 0.28)) * width
        tilt = float(rng.normal(0, 0.025))
        z = 0.12 + r + 0.075 * (k // 3)
        at = y + (-0.045, 0.05, 0.0, 0.005)[k]
        thing.add(bar((-half, at - tilt, z), (half, at + tilt, z + tilt), r, 10), bark)


def light_switch(rng: np.random.Generator, style: Style) -> Thing:
    """One to three rockers in a frame."""
    gangs = int(rng.choice([1, 1, 2, 3]))
    pieces = [box((0.082, 0.009, 0.082 + 0.071 * (gangs - 1)), (0, -0.0045, 0), bevel=0.003)]
    for k in range(gangs):
        z = 0.071 * (k - (gangs - 1) / 2)
        pieces.append(box((0.055, 0.008, 0.055), (0, -0.0105, z), bevel=0.003))
    material = WHITE if rng.uniform() < 0.75 else style.metal
    return Thing("light switch").add(joined(pieces), material)


def socket(rng: np.random.Generator, style: Style) -> Thing:
    """One to four round sockets side by side, now and then with a plug and its cable."""
    gangs = int(rng.choice([1, 1, 2, 2, 3, 4]))
    material = WHITE if rng.uniform() < 0.85 else style.metal
    thing = Thing("socket")
    plates = [box((0.082 + 0.071 * (gangs - 1), 0.009, 0.082), (0, -0.0045, 0), bevel=0.003)]
    cups = []
    for k in range(gangs):
        x = 0.071 * (k - (gangs - 1) / 2)
        plates.append(bar((x, -0.008, 0), (x, -0.0145, 0), 0.026, 18))
        cups.append(bar((x, -0.01, 0), (x, -0.015, 0), 0.0195, 18))
    thing.add(joined(plates), material)
    thing.add(joined(cups), Material(darker(material.colour, 0.6)))
    if rng.uniform() < 0.3:
        black = Material((0.03, 0.03, 0.03))
        x = 0.071 * (int(rng.integers(gangs)) - (gangs - 1) / 2)
        plug = moved(_lying(cylinder(0.019, 0.04, top=0.014, sides=14)), pose(x, -0.035, 0))
        drop = [
            (x, -0.055, 0),
            (x, -0.08, -0.01),
            (x + 0.01, -0.08, -0.1),
            (x + 0.04, -0.03, -0.2),
            (x + 0.1, -0.02, -0.26),
        ]
        thing.add(joined([plug, tube(drop, 0.003, 6)]), black)
    return thing


def vent(rng: np.random.Generator, style: Style) -> Thing:
    """A louvred grille."""
    wide, high = float(rng.uniform(0.15, 0.35)), float(rng.uniform(0.12, 0.25))
    pieces = [box((wide, 0.004, high), (0, -0.002, 0))]
    for s in (-1, 1):
        pieces.append(box((0.018, 0.014, high), (s * (wide - 0.018) / 2, -0.009, 0), bevel=0.003))
        pieces.append(
            box((wide - 0.036, 0.014, 0.018), (0, -0.009, s * (high - 0.018) / 2), bevel=0.003)
        )
    count = max(4, round((high - 0.036) / 0.016))
    slat = box((wide - 0.034, 0.014, 0.002))
    c, s = np.cos(0.7), np.sin(0.7)
    for k in range(count):
        z = -(high - 0.036) / 2 + (high - 0.036) * (k + 0.5) / count
        tilt = np.array([[1, 0, 0, 0], [0, c, -s, -0.010], [0, s, c, z], [0, 0, 0, 1.0]])
        pieces.append(moved(slat, tilt))
    return Thing("vent").add(joined(pieces), WHITE if rng.uniform() < 0.7 else style.metal)


def thermostat(rng: np.random.Generator, style: Style) -> Thing:
    """A small box with a dial or a display."""
    thing = Thing("thermostat")
    if rng.uniform() < 0.5:
        thing.add(box((0.08, 0.026, 0.08), (0, -0.013, 0), bevel=0.005), WHITE)
        dial = moved(_lying(cylinder(0.027, 0.014, sides=24)), pose(0, -0.031, 0))
        return thing.add(dial, Material((0.55, 0.55, 0.53)))
    thing.add(box((0.12, 0.022, 0.085), (0, -0.011, 0), bevel=0.005), WHITE)
    screen = box((0.075, 0.002, 0.04), (-0.01, -0.0225, 0.008))
    return thing.add(screen, Material((0.1, 0.13, 0.1), emission=0.4))


def boiler(rng: np.random.Generator, style: Style) -> Thing:
    """A wall-mounted boiler with its panel, pipes below and a flue."""
    w, d, h = (
        float(rng.uniform(0.4, 0.48)),
        float(rng.uniform(0.3, 0.38)),
        float(rng.uniform(0.7, 0.8)),
    )
    thing = Thing("boiler")
    thing.add(box((w, d, h), (0, -d / 2, 0), bevel=0.012), WHITE)
    thing.add(
        box((0.9 * w, 0.008, 0.12), (0, -d - 0.001, -h / 2 + 0.09), bevel=0.003),
        Material((0.12, 0.12, 0.13)),
    )
    knobs = [
        moved(_lying(cylinder(0.018, 0.016)), pose(x, -d - 0.011, -h / 2 + 0.09))
        for x in (-0.11, 0.11)
    ]
    thing.add(joined(knobs), Material((0.6, 0.6, 0.6)))
    pipes = [
        tube(
            [
                (x, -0.1, -h / 2 + 0.02),
                (x, -0.1, -h / 2 - 0.15),
                (x, -0.04, -h / 2 - 0.18),
                (x, -0.04, -h / 2 - 0.45),
            ],
            0.009,
        )
        for x in (-0.14, -0.07, 0.0, 0.07, 0.14)
    ]
    copper = Material((0.55, 0.27, 0.15), specular=0.4, gloss=60.0)
    thing.add(joined(pipes), copper)
    flue = [
        bar((0, -d / 2, h / 2 - 0.01), (0, -d / 2, h / 2 + 0.18), 0.05, 16),
        bar((0, -d / 2, h / 2 + 0.16), (0, 0, h / 2 + 0.16), 0.05, 16),
    ]
    return thing.add(joined(flue), WHITE)


def pipes(rng: np.random.Generator, style: Style, *, height: float = 2.4) -> Thing:
    """Two to four rising pipes with clips, for a corner; z = 0 is at half their height."""
    count = int(rng.integers(1, 5))
    radii = rng.choice([0.008, 0.011, 0.014, 0.03, 0.055], count)
    xs = np.cumsum(np.concatenate([[0.0], (radii[1:] + radii[:-1]) + 0.03]))
    xs -= xs.mean()
    tubes, clips = [], []
    for x, r in zip(xs.tolist(), radii.tolist(), strict=True):
        y = -0.012 - r
        tubes.append(bar((x, y, -height / 2), (x, y, height / 2), r, 12))
        for z in np.arange(-height / 2 + 0.3, height / 2 - 0.1, 0.9).tolist():
            clips.append(bar((x, y, z), (x, y, z + 0.016), r + 0.003, 12))
            clips.append(box((0.012, -y, 0.014), (x, y / 2, z + 0.008)))
    copper = Material((0.55, 0.27, 0.15), specular=0.4, gloss=60.0)
    thing = Thing("pipes").add(joined(tubes), WHITE if rng.uniform() < 0.6 else copper)
    return thing.add(joined(clips), style.metal)


def cable_duct(rng: np.random.Generator, style: Style, *, length: float | None = None) -> Thing:
    """A trunking along the wall with boxes of sockets in it."""
    length = float(rng.uniform(1.0, 3.0)) if length is None else length
    high = float(rng.choice([0.03, 0.06, 0.1]))
    pieces = [box((length, 0.022, high), (0, -0.011, 0), bevel=0.002)]
    pieces.append(box((length - 0.01, 0.004, 0.6 * high), (0, -0.0235, 0), bevel=0.001))
    if high > 0.05:
        for k in range(int(length / 0.7)):
            x = -length / 2 + 0.4 + 0.7 * k
            pieces.append(box((0.16, 0.012, 0.085), (x, -0.028, 0), bevel=0.003))
    return Thing("cable duct").add(joined(pieces), WHITE)


def skirting_heater(
    rng: np.random.Generator, style: Style, *, length: float | None = None
) -> Thing:
    """A low convector along the foot of a wall; z = 0 at half its height of 18 cm."""
    length = float(rng.uniform(0.8, 2.0)) if length is None else length
    case = [
        box((length, 0.008, 0.12), (0, -0.066, -0.01), bevel=0.003),
        box((length, 0.05, 0.008), (0, -0.028, 0.082), bevel=0.002),
        box((length, 0.006, 0.17), (0, -0.003, 0)),
        *[
            box((0.012, 0.068, 0.165), (s * (length / 2 + 0.004), -0.036, 0), bevel=0.003)
            for s in (-1, 1)
        ],
    ]
    fins = [
        box((0.002, 0.045, 0.07), (x, -0.034, 0.0))
        for x in np.arange(-length / 2 + 0.03, length / 2, 0.03)
    ]
    return Thing("heater").add(joined(case), WHITE).add(joined(fins), Material((0.3, 0.3, 0.3)))


def smoke_detector(rng: np.random.Generator, style: Style) -> Thing:
    """A disc under the ceiling."""
    r = float(rng.uniform(0.04, 0.06))
    pieces = [cylinder(r, 0.012, (0, 0, -0.006), sides=28)]
    pieces.append(cylinder(0.65 * r, 0.022, (0, 0, -0.022), top=0.9 * r, sides=28))
    return Thing("smoke detector").add(joined(pieces), WHITE)


CATALOGUE: dict[str, Maker] = {
    "radiator": radiator,
    "fireplace": fireplace,
    "light_switch": light_switch,
    "socket": socket,
    "vent": vent,
    "thermostat": thermostat,
    "boiler": boiler,
    "pipes": pipes,
    "cable_duct": cable_duct,
    "skirting_heater": skirting_heater,
    "smoke_detector": smoke_detector,
}
