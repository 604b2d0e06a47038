"""Cables, cords and hoses: on the floor, in coils, out of power strips, behind desks."""

from collections.abc import Sequence

import numpy as np

from cmtof.scenes.rooms.materials import Colour, Material, Style, hue
from cmtof.scenes.rooms.pliant import Points, against_wall, centred, hung, moved_by, spline
from cmtof.scenes.rooms.shades import BLACK, Maker
from cmtof.scenes.rooms.solids import ball, box, cushion, cylinder, joined, revolve, rod, tube
from cmtof.scenes.rooms.thing import Mesh, Thing

WHITE = Material((0.75, 0.75, 0.73), specular=0.06, gloss=30.0)


def _sheath(rng: np.random.Generator) -> Material:
    """Rubber or plastic of a cable: mostly black, white or grey."""
    grey = float(rng.choice([0.02, 0.02, 0.3, 0.75]))
    colour: Colour = (grey, grey, grey)
    if rng.uniform() < 0.2:
        colour = hue(float(rng.choice([0.03, 0.08, 0.6])), 0.85, 0.4)
    return Material(colour, specular=0.05, gloss=25.0)


def _wander(rng: np.random.Generator, start: Points, end: Points, length: float) -> Points:
    """A path from start to end, (72, 2), that strays about as much as ``length`` asks."""
    away = float(np.linalg.norm(end - start))
    t = np.linspace(0, 1, 72)[:, None]
    spare = np.sqrt(max(length**2 - away**2, 0.0))
    k = np.arange(1, 6)
    walk = np.sin(np.pi * k * t) @ (rng.normal(size=(5, 2)) / k[:, None] ** 1.2)
    walk *= spare / (np.linalg.norm(np.diff(walk, axis=0), axis=1).sum() + 1e-9)
    return start + t * (end - start) + walk


def _lying(path: Points, radius: float, count: int) -> Points:
    """A floor path (N, 2) as a curve (count, 3) that rests on z = 0, one stretch over another."""
    fine = spline(np.column_stack([path, np.full(len(path), radius)]), count)
    # where an earlier stretch lies below, the cable passes over it
    gap = np.linalg.norm(fine[:, None, :2] - fine[None, :, :2], axis=-1)
    steps = np.abs(np.arange(count)[:, None] - np.arange(count))
    spacing = np.median(np.linalg.norm(np.diff(fine, axis=0), axis=1)) + 1e-9
    apart = np.maximum(8, np.ceil(6 * radius / spacing))
    near = (gap < 1.2 * spacing + 2 * radius) & (steps > apart) & np.tri(count, k=-1).astype(bool)
    lift = near.any(axis=1) * 2.1 * radius
    kernel = np.array([0.5, 0.8, 1.0, 0.8, 0.5])
    wide = np.max([np.roll(lift, k - 2) * kernel[k] for k in range(5)], axis=0)
    fine[:, 2] = radius + np.maximum(lift, wide)
    return fine


def cable_on_floor(
    rng: np.random.Generator,
    style: Style,
    *,
    length: float | None = None,
    start: Sequence[float] | None = None,
    end: Sequence[float] | None = None,
) -> Thing:
    """A cable that wanders over the floor.

    Parameters
    ----------
    length : float, optional
        About how long it is, m.
    start, end : sequence of two float, optional
        Where it begins and ends, (x, y), m; about the origin by default.
    """
    thing = Thing("cable_on_floor")
    drawn = float(rng.uniform(1.0, 3.0))
    length = drawn if length is None else length
    angle, share = rng.uniform(0, 2 * np.pi), rng.uniform(0.3, 0.75)
    half = 0.5 * share * length * np.array([np.cos(angle), np.sin(angle)])
    given = start is not None or end is not None
    first = -half if start is None else np.asarray(start, float)
    last = half if end is None else np.asarray(end, float)
    path = _wander(rng, first, last, length)
    radius = float(rng.uniform(0.002, 0.004))
    curve = _lying(path, radius, 72)
    if not given:
        low, high = curve[:, :2].min(0), curve[:, :2].max(0)
        curve[:, :2] -= (low + high) / 2
    sheath = _sheath(rng)
    thing.add(tube(curve, radius, 6), sheath)
    if rng.uniform() < 0.6:
        _plug_end(thing, curve[-1], curve[-1] - curve[-3], sheath)
    return thing


def _plug_end(thing: Thing, at: Points, along: Points, skin: Material) -> None:
    """A plug that lies on the floor at a cable's end."""
    along = along * [1, 1, 0]
    along /= np.linalg.norm(along) + 1e-9
    z = np.array([0, 0, 0.013 - at[2]])
    tip = at + 0.045 * along
    thing.add(tube([at, at + 0.01 * along + 0.6 * z, tip + z], [0.004, 0.009, 0.013], 10), skin)
    side = 0.0095 * np.array([-along[1], along[0], 0])
    pins = [rod(tip + z + s * side, tip + z + s * side + 0.019 * along, 0.0022, 6) for s in (-1, 1)]
    thing.add(joined(pins), Material((0.5, 0.5, 0.5), specular=0.6, gloss=60.0))


def power_strip(rng: np.random.Generator, style: Style) -> Thing:
    """A strip of sockets with plugs in some, and the cables that leave them."""
    thing = Thing("power_strip")
    count = int(rng.integers(3, 7))
    length = 0.055 * count + 0.06
    body = WHITE if rng.uniform() < 0.6 else BLACK
    thing.add(box((length, 0.055, 0.038), (0, 0, 0.0205), bevel=0.006), body)
    feet = [box((0.02, 0.04, 0.004), (s * 0.4 * length, 0, 0.002)) for s in (-1, 1)]
    thing.add(joined(feet), BLACK)
    hole = Material((0.1, 0.1, 0.1), specular=0.03)
    places = (np.arange(count) - (count - 1) / 2 + 0.3) * 0.055
    wells = [cylinder(0.019, 0.002, (x, 0, 0.0397), sides=18) for x in places]
    thing.add(joined(wells), hole)
    thing.add(box((0.022, 0.015, 0.008), (-length / 2 + 0.025, 0, 0.041), bevel=0.002),
              Material((0.5, 0.03, 0.02), emission=0.3))  # fmt: skip
    chosen = rng.permutation(count)[: int(rng.integers(2, 5))]
    for x in places[np.sort(chosen)]:
        sheath = _sheath(rng)
        if rng.uniform() < 0.25:
            thing.add(box((0.045, 0.05, 0.06), (x, 0, 0.071), bevel=0.005), BLACK)
            continue
        side = float(rng.choice([-1, 1]))
        thing.add(cylinder(0.019, 0.03, (x, 0, 0.0555), top=0.012, sides=14), sheath)
        far = side * float(rng.uniform(0.25, 0.5))
        way = [(x, 0, 0.068), (x, 0.02 * side, 0.085), (x, 0.06 * side, 0.04),
               (x + rng.normal(0, 0.03), 0.12 * side, 0.004),
               (x + rng.normal(0, 0.12), 0.6 * far, 0.004),
               (x + rng.normal(0, 0.25), far, 0.004)]  # fmt: skip
        curve = spline(way, 26)
        curve[:, 2] = np.maximum(curve[:, 2], 0.004)
        thing.add(tube(curve, 0.0034, 6), sheath)
    aside = [0.0, 0.01, rng.normal(0, 0.1), rng.normal(0, 0.15)]
    way = np.column_stack([length / 2 + np.array([-0.005, 0.08, 0.2, 0.35]), aside])
    tail = _lying(way, 0.0042, 24)
    tail[:4, 2] = np.linspace(0.02, tail[4, 2], 4)
    thing.add(tube(tail, 0.0042, 6), body)
    return centred(thing)


def lamp_cable(rng: np.random.Generator, style: Style) -> Thing:
    """A thin flex with its switch, in a few bends on the floor."""
    thing = cable_on_floor(rng, style, length=float(rng.uniform(1.2, 2.0)))
    thing.kind = "lamp_cable"
    curve = thing.parts[0].mesh.vertices.reshape(-1, 6, 3).mean(axis=1)
    at = curve[len(curve) // 2]
    turn = float(np.arctan2(*(curve[len(curve) // 2 + 1] - at)[1::-1]))
    c, s = np.cos(turn), np.sin(turn)
    switch = box((0.06, 0.026, 0.02), bevel=0.006)
    vertices = switch.vertices @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + [
        at[0],
        at[1],
        0.0102,
    ]
    thing.add(Mesh(vertices.astype(np.float32), switch.faces), WHITE)
    return centred(thing)


def _coil(
    rng: np.random.Generator, turns: int, radius: float, cord: float, per_turn: int = 20
) -> Points:
    """Loops that lie on one another a little out of line, from z = cord upwards."""
    n = turns * per_turn
    t = np.arange(n) * (2 * np.pi / per_turn)
    lap = np.arange(n) / per_turn
    layer = np.minimum(lap, lap.max())
    out = radius + 1.6 * cord * np.sin(1.7 * lap) + 0.4 * cord * np.sin(3.1 * t + 1)
    drift = rng.normal(0, 0.8 * cord, (turns + 2, 2))
    shift = np.stack([np.interp(lap, np.arange(turns + 2), drift[:, k]) for k in range(2)], -1)
    path = np.column_stack([out * np.cos(t), out * np.sin(t)]) + shift
    return np.column_stack([path, cord + 1.25 * cord * layer])


def garden_hose(rng: np.random.Generator, style: Style) -> Thing:
    """A hose in loops with its brass or plastic nozzle."""
    thing = Thing("garden_hose")
    cord = float(rng.uniform(0.009, 0.011))
    curve = _coil(rng, int(rng.integers(4, 7)), float(rng.uniform(0.2, 0.28)), cord)
    tail = curve[-1] + np.array(
        [(0.05, 0.1, -0.3 * curve[-1, 2]), (0.12, 0.22, cord - curve[-1, 2])]
    )
    path = np.concatenate([curve, spline(np.concatenate([curve[-1:], tail]), 8)[1:]])
    skin = (Material((0.03, 0.22, 0.05), specular=0.06), Material((0.55, 0.4, 0.03), specular=0.06))
    thing.add(tube(path, cord, 7), skin[int(rng.integers(2))])
    end, way = path[-1], (path[-1] - path[-4]) * [1, 1, 0]
    way /= np.linalg.norm(way)
    tip = [end, end + 0.03 * way, end + 0.04 * way, end + 0.11 * way]
    thing.add(tube(tip, [0.0125, 0.0125, 0.008, 0.005], 10), style.accent)
    return centred(thing)


def rope_coil(rng: np.random.Generator, style: Style) -> Thing:
    """A rope in loops, bound across with its own end."""
    thing = Thing("rope_coil")
    cord, radius = float(rng.uniform(0.005, 0.008)), float(rng.uniform(0.1, 0.16))
    curve = _coil(rng, int(rng.integers(4, 7)), radius, cord)
    fibre = Material((0.5, 0.4, 0.25), (0.32, 0.24, 0.13), "stripes", 0.02, specular=0.0, bump=0.8)
    thing.add(tube(curve, cord, 6), fibre)
    top = curve[:, 2].max() + cord
    t = np.linspace(0, 6 * np.pi, 44)
    bind = np.stack([radius + 0.03 * np.cos(t), 0.012 * (t / np.pi - 3), top / 2 + (top / 2 + 0.2 * cord) * np.sin(t)], -1)  # fmt: skip  # noqa: E501
    bind[:, 2] = np.maximum(bind[:, 2], cord)
    thing.add(tube(bind, cord, 6), fibre)
    return centred(thing)


def extension_reel(rng: np.random.Generator, style: Style) -> Thing:
    """A drum of cable in a stand with a handle."""
    thing = Thing("extension_reel")
    r, w = float(rng.uniform(0.11, 0.14)), 0.1
    z = r + 0.045
    shell = Material((0.03, 0.03, 0.03), specular=0.06)
    flange = [(0, 0), (r, 0), (r, 0), (r, 0.008), (r, 0.008), (0, 0.008)]
    for side in (-1, 1):
        disc = revolve(np.array(flange) - [0, 0.004], 36)
        skin = shell if side > 0 else style.accent
        thing.add(moved_by(against_wall(disc), 0, side * w / 2, z), skin)
    orange = Material((0.6, 0.14, 0.02), specular=0.05) if rng.uniform() < 0.5 else BLACK
    full = float(rng.uniform(0.6, 0.9)) * r
    t = np.linspace(0, 1, 33)
    wound = np.column_stack(
        [full + 0.0045 * np.abs(np.sin(8 * np.pi * t)), (t - 0.5) * (w - 0.012)]
    )
    turns = revolve(
        np.concatenate([[(0.2 * r, wound[0, 1])], wound, [(0.2 * r, wound[-1, 1])]]), 28
    )
    thing.add(moved_by(against_wall(turns), 0, 0, z), orange)
    steel = Material((0.4, 0.4, 0.4), specular=0.5, gloss=60.0)
    for side in (-1, 1):
        y = side * (w / 2 + 0.02)
        foot = spline(
            [(-0.13, y, 0.008), (-0.1, y, 0.008), (0, y, z), (0.1, y, 0.008), (0.13, y, 0.008)], 5
        )
        thing.add(tube(foot, 0.007, 8), steel)
        thing.add(rod((0, y, z), (0, y, z + r + 0.05), 0.007), steel)
    thing.add(rod((0, -w / 2 - 0.02, z), (0, w / 2 + 0.02, z), 0.01, 10), steel)
    thing.add(
        rod((0, -w / 2 - 0.025, z + r + 0.05), (0, w / 2 + 0.025, z + r + 0.05), 0.012, 12), BLACK
    )
    socket = against_wall(cylinder(0.02, 0.004, sides=16))
    sockets = [
        moved_by(socket, 0.045 * np.cos(a), -w / 2 - 0.005, z + 0.045 * np.sin(a))
        for a in (0.5, 2.1, 3.7, 5.2)
    ]
    thing.add(joined(sockets), BLACK)
    way = [(full, 0, z), (full + 0.03, 0, 0.5 * z), (0.24, 0.05, 0.005), (0.4, 0.14, 0.005)]
    tail = spline(way, 16)
    tail[:, 2] = np.maximum(tail[:, 2], 0.005)
    thing.add(tube(tail, 0.0048, 6), orange)
    _plug_end(thing, tail[-1], tail[-1] - tail[-3], orange)
    return centred(thing)


def cable_bundle(rng: np.random.Generator, style: Style) -> Thing:
    """Cables that hang against a wall in bows and end on the floor of a desk, tied together."""
    thing = Thing("cable_bundle")
    tall = float(rng.uniform(0.5, 0.7))
    count = int(rng.integers(4, 8))
    tie = np.array([float(rng.normal(0, 0.05)), -0.03, float(rng.uniform(-0.1, 0.05))])
    for k in range(count):
        angle = 2 * np.pi * k / count
        at = tie + 0.008 * np.array([np.cos(angle), np.sin(angle), 0])
        top = np.array([float(rng.uniform(-0.45, 0.45)), -0.03, tall / 2])
        sag = np.array([(top[0] + at[0]) / 2, -0.035, min(at[2], 0.1) + 0.1 * rng.uniform()])
        end = np.array([at[0] + rng.normal(0, 0.12), -0.04 + rng.normal(0, 0.01), -tall / 2])
        curve = spline([top, top + np.array([0, 0, -0.08]), sag, at + np.array([0, 0, 0.02]), at - [0, 0, 0.02], (at + end) / 2, end], 30)  # fmt: skip  # noqa: E501
        curve[:, 1] = np.minimum(curve[:, 1], -0.006)
        thing.add(tube(curve, float(rng.uniform(0.002, 0.004)), 6), _sheath(rng))
    thing.add(cylinder(0.017, 0.012, tie, sides=14), BLACK)
    return hung(thing)


def headphones(rng: np.random.Generator, style: Style) -> Thing:
    """A headband with two cups, lying on its side, some with a cable."""
    thing = Thing("headphones")
    skin = (BLACK, WHITE, style.metal, style.accent)[int(rng.integers(4))]
    r = float(rng.uniform(0.078, 0.09))
    angle = np.linspace(-0.15, 1.15, 20) * np.pi
    band = np.stack([1.0 * r * np.cos(angle), 1.25 * r * np.sin(angle), np.full(20, 0.042)], -1)
    thing.add(tube(band, 0.005, 8), skin)
    thing.add(tube(band[5:15] * [0.96, 0.96, 1], np.full(10, 0.009), 8), BLACK)
    for side, end in ((1, band[0]), (-1, band[-1])):
        at = end + np.array([-side * 0.008, -0.005, 0])
        at[2] = 0.042
        cup = cushion((0.03, 0.082, 0.082), at, square=0.75)
        pad = cushion((0.026, 0.078, 0.078), at - [side * 0.02, 0, 0], square=0.6)
        thing.add(cup, skin)
        thing.add(pad, Material((0.03, 0.03, 0.03), specular=0.03))
    if rng.uniform() < 0.6:
        start = band[0] + [0, -0.045, -0.03]
        steps = [(0, 0), (0.03, -0.06), (-0.06, -0.1), (-0.12, -0.05), (-0.2, -0.11)]
        path = start[:2] + np.array(steps)
        thing.add(
            tube(_lying(path + rng.normal(0, 0.01, path.shape), 0.0018, 36), 0.0018, 5), BLACK
        )
        thing.add(ball(0.004, (*start[:2], 0.005), 1), BLACK)
    return centred(thing)


CATALOGUE: dict[str, Maker] = {
    "cable_on_floor": cable_on_floor,
    "power_strip": power_strip,
    "lamp_cable": lamp_cable,
    "extension_reel": extension_reel,
    "cable_bundle": cable_bundle,
    "headphones": headphones,
    "garden_hose": garden_hose,
    "rope_coil": rope_coil,
}
