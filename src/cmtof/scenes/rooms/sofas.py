"""Upholstered seats: sofas and armchairs with cushions that have been sat on, m."""

import numpy as np

from cmtof.scenes.rooms.cabinetry import timber
from cmtof.scenes.rooms.joinery import (
    beams,
    copies,
    corners,
    placed,
    raised,
    rods,
    shifted,
)  # fmt: skip
from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.solids import cylinder, joined
from cmtof.scenes.rooms.thing import Mesh, Support, Thing
from cmtof.scenes.rooms.upholstery import covering, dented, loft, pad, pillow


def short_feet(rng: np.random.Generator, half: tuple[float, float], height: float) -> Mesh:
    """Four short feet under an upholstered frame."""
    kind, place = int(rng.integers(3)), corners(half[0] - 0.07, half[1] - 0.07)
    if kind == 0:
        return beams(place, raised(place, height), 0.06, 0.06, taper=0.75)
    if kind == 1:
        spread = corners(half[0] - 0.05, half[1] - 0.05)
        return rods(spread, raised(place, height), 0.022, taper=0.6, sides=10)
    return copies(cylinder(0.028, height, (0, 0, height / 2), top=0.034, sides=14), place)


def _arm(rng: np.random.Generator, kind: str, depth: float, width: float, high: float) -> Mesh:
    """One upholstered arm, its length along y, standing on z = 0."""
    if kind == "rolled":
        body = pad((0.7 * width, depth, high - 0.05), radius=0.03, crown=0.0, side=2)
        roll = loft(high * 0.34, width, 0.48 * min(width, 0.34 * high),
                    [(0.08, 0), (0.02, 0.004), (0, 0.02), (0, depth - 0.02), (0.02, depth - 0.004),
                     (0.08, depth)], corner=6)  # fmt: skip
        roll = placed(placed(roll, tilt=np.pi / 2), turn=-np.pi / 2)
        low, top = roll.vertices.min(0), roll.vertices.max(0)
        x, y = (low + top)[:2] / 2
        return joined([body, shifted(roll, -x, -y, high - top[2])])
    soft = 0.05 if kind == "soft" else 0.02
    return pad((width, depth, high), radius=soft, edge=soft, crown=0.5 * soft, side=2)


def upholstered(
    rng: np.random.Generator, style: Style, seats: int, seat_width: float, cover: Material
) -> Thing:
    """A sofa or armchair for so many: base, arms, back, cushions that have been sat on."""
    kind = str(rng.choice(["block", "soft", "rolled", "slim"]))
    arm_width = {"block": 0.16, "soft": 0.22, "rolled": 0.22, "slim": 0.09}[kind]
    arm_width *= float(rng.uniform(0.85, 1.2))
    inner = seats * seat_width
    width, depth = inner + 2 * arm_width, float(rng.uniform(0.80, 0.98))
    foot, seat = float(rng.uniform(0.05, 0.16)), float(rng.uniform(0.40, 0.46))
    arm_high, back_high = seat + float(rng.uniform(0.12, 0.24)), float(rng.uniform(0.72, 0.92))
    thick, back_deep = float(rng.uniform(0.12, 0.18)), float(rng.uniform(0.13, 0.2))
    x, y = width / 2, depth / 2
    thing = Thing("sofa" if seats > 1 else "armchair")
    thing.add(
        short_feet(rng, (x, y), foot + 0.005), style.wood if rng.uniform() < 0.6 else style.metal, 2
    )
    arm = _arm(rng, kind, depth - 0.02, arm_width, arm_high - foot)
    place = inner / 2 + arm_width / 2
    arms = copies(arm, [(-place, -0.005, foot), (place, -0.005, foot)])
    base = pad((inner + 0.01, depth - 0.05, seat - thick - foot + 0.01), (0, 0, foot), radius=0.02,
               edge=0.015, crown=0.0)  # fmt: skip
    back = pad((inner + 0.01, back_high - foot, back_deep), radius=0.04, edge=0.04, crown=0.01)
    stand = (0, y - 0.002, foot + (back_high - foot) / 2)
    back = placed(back, stand, lean=np.pi / 2)
    thing.add(joined([arms, base, back]), cover)
    front = -y + (0.0 if kind == "slim" else 0.01)
    deep = depth - back_deep - 0.01
    _cushions(thing, rng, seats, seat_width, (front, deep, seat, thick), cover, back_high)
    _scatter(thing, rng, style, seats, seat_width, front + deep - 0.2, seat)
    for k in range(seats):
        x = (k - (seats - 1) / 2) * seat_width
        y = (front + 0.07, front + 0.36 * deep)
        thing.supports.append(Support(x - 0.2, x + 0.2, *y, seat + 0.010, clearance=0.5))
    return thing


def _cushions(
    thing: Thing,
    rng: np.random.Generator,
    seats: int,
    wide: float,
    place: tuple[float, float, float, float],
    cover: Material,
    back_high: float,
) -> None:
    """Seat cushions with dents and back cushions that lean."""
    front, deep, seat, thick = place
    pieces, tall = [], max(back_high - seat + float(rng.uniform(-0.04, 0.06)), 0.25)
    for k in range(seats):
        x = (k - (seats - 1) / 2) * wide
        cushion = pad((wide - 0.006, deep, thick), radius=0.05, edge=0.04, crown=0.02, side=3)
        spot = rng.normal(0, 0.04, (1, 2))
        cushion = dented(cushion, spot, float(rng.uniform(0.0, 0.022)), 0.2)
        pieces.append(placed(cushion, (x, front + deep / 2, seat - thick)))
        rest = pad((wide - 0.012, tall, 0.15), radius=0.07, edge=0.06, crown=0.04, side=3)
        lean = np.pi / 2 - float(rng.uniform(0.10, 0.22))
        at = (x, front + deep + 0.0, seat + tall / 2 - 0.015)
        pieces.append(placed(rest, at, lean=lean, turn=float(rng.normal(0, 0.02))))
    thing.add(joined(pieces), cover)


def _scatter(
    thing: Thing,
    rng: np.random.Generator,
    style: Style,
    seats: int,
    wide: float,
    y: float,
    seat: float,
) -> None:
    """Throw pillows leaning against the back."""
    if rng.uniform() < 0.25:
        return
    reach = seats * wide / 2 - 0.26
    spots = [-reach, reach, reach - 0.3, 0.0][: int(rng.integers(1, 2 + min(seats, 3)))]
    for k, x in enumerate(spots):
        size = float(rng.uniform(0.38, 0.5))
        mesh = pillow(rng, size, size * float(rng.choice([1.0, 0.7])), 0.14, count=9)
        turn, roll = float(rng.normal(0, 0.15)), float(rng.normal(0, 0.12))
        mesh = placed(placed(mesh, turn=roll), lean=np.pi / 2 - 0.42, turn=turn)
        low = float(mesh.vertices[:, 2].min())
        at = (x, y - 0.06 * (k % 2) - 0.02, seat - low - 0.012)
        cover = (style.second_fabric, style.accent, style.fabric)[int(rng.integers(3))]
        thing.add(placed(mesh, at), cover)


def sofa(rng: np.random.Generator, style: Style, *, seats: int | None = None) -> Thing:
    """A sofa for two to four, in cloth or leather, now and then with a blanket over an arm."""
    seats = int(rng.choice([2, 3, 4], p=[0.45, 0.42, 0.13])) if seats is None else seats
    cover = (style.fabric, style.fabric, style.leather, style.second_fabric)[int(rng.integers(4))]
    thing = upholstered(rng, style, seats, float(rng.uniform(0.56, 0.78 - 0.05 * seats)), cover)
    if rng.uniform() < 0.3:
        low, high = thing.bounds
        side, top = float(rng.choice([-1, 1])), _arm_top(thing)
        x = (high[0] - 0.17, high[0] - 0.005) if side > 0 else (low[0] + 0.005, low[0] + 0.17)
        y0 = low[1] + float(rng.uniform(0.08, 0.2))
        mesh = covering(rng, x, (y0, y0 + 0.42), top, (0.25, 0.25, 0.0, 0.0), thickness=0.008,
                        folds=0.01, spacing=0.05)  # fmt: skip
        thing.add(mesh, style.second_fabric)
    return thing


def _arm_top(thing: Thing) -> float:
    """Height of the arms of an upholstered piece: its outermost points' top."""
    points = thing.parts[1].mesh.vertices
    outer = np.abs(points[:, 0]) > np.abs(points[:, 0]).max() - 0.1
    return float(points[outer, 2].max()) - 0.002


def armchair(rng: np.random.Generator, style: Style) -> Thing:
    """Upholstered, in a wooden frame, or a moulded tub with a cushion."""
    kind = int(rng.integers(4))
    if kind < 2:
        cover = style.fabric if rng.uniform() < 0.6 else style.leather
        return upholstered(rng, style, 1, float(rng.uniform(0.52, 0.66)), cover)
    return _wooden_armchair(rng, style) if kind == 2 else _tub(rng, style)


def _wooden_armchair(rng: np.random.Generator, style: Style) -> Thing:
    """An open frame with flat arms and two loose cushions."""
    w, d, seat, back = float(rng.uniform(0.62, 0.72)), 0.72, 0.38, float(rng.uniform(0.78, 0.92))
    material, x, y = timber(rng, style), w / 2, d / 2
    cover = style.fabric if rng.uniform() < 0.7 else style.leather
    arm, t = 0.56, 0.04
    feet = np.array([(s * (x - t / 2), p, 0.0) for s in (-1, 1) for p in (-y + 0.06, y - 0.16)])
    legs = beams(feet, raised(feet, arm - 0.012), t, 0.055, taper=0.75)
    side = [(s * (x - t / 2), -y, arm) for s in (-1, 1)]
    stop = [(s * (x - t / 2), y - 0.1, arm - 0.03) for s in (-1, 1)]
    arms = beams(side, stop, 0.065, 0.024, chamfer=0.006)
    rail = beams([(s * (x - t - 0.01), -y + 0.02, seat - 0.11) for s in (-1, 1)],
                 [(s * (x - t - 0.01), y - 0.08, seat - 0.20) for s in (-1, 1)], 0.024,
                     0.07)  # fmt: skip
    z = np.linspace(0, 1, 7)
    at = np.stack([0 * z, y - 0.15 + 0.14 * z, 0.26 + (back - 0.26) * z], -1)
    half = x - t - 0.02
    slats = beams(at - np.array([half, 0, 0]), at + np.array([half, 0, 0]), 0.014, 0.045)
    posts = beams([(s * half, *at[0, 1:] + [0.018, -0.06]) for s in (-1, 1)],
                  [(s * half, *at[-1, 1:] + [0.018, 0.03]) for s in (-1, 1)], 0.028,
                      0.03)  # fmt: skip
    bars = beams([(-half, p, q) for p, q in ((-y + 0.05, seat - 0.115), (y - 0.13, seat - 0.19))],
                 [(half, p, q) for p, q in ((-y + 0.05, seat - 0.115), (y - 0.13, seat - 0.19))],
                 0.024, 0.06)  # fmt: skip
    thing = Thing("armchair").add(joined([legs, posts]), material, 2)
    thing.add(joined([arms, rail]), material, 1).add(joined([slats, bars]), material)
    sit = pad((2 * half, 0.56, 0.12), (0, 0, 0), radius=0.05, edge=0.04, crown=0.015)
    sit = dented(sit, [(0, 0)], float(rng.uniform(0, 0.02)), 0.18)
    rest = pad((2 * half, 0.5, 0.12), (0, 0, 0), radius=0.05, edge=0.045, crown=0.02)
    tilt = float(np.arctan2(0.14, back - 0.26))
    thing.add(
        joined(
            [
                placed(sit, (0, -0.09, seat - 0.115), lean=-0.12),
                placed(rest, (0, y - 0.13, seat + 0.28), lean=np.pi / 2 - tilt),
            ]
        ),
        cover,
    )
    reach = half - 0.1
    thing.supports.append(Support(-reach, reach, -0.2, 0.02, seat + 0.01))
    return thing


def _tub(rng: np.random.Generator, style: Style) -> Thing:
    """A padded bucket that wraps around, with a round cushion, on splayed legs."""
    width, seat = float(rng.uniform(0.66, 0.78)), 0.42
    depth, low = 0.94 * width, 0.17
    high, front = float(rng.uniform(0.30, 0.42)), float(rng.uniform(0.08, 0.22))
    cover = style.fabric if rng.uniform() < 0.7 else style.leather
    angle = np.linspace(-0.22 * np.pi, 1.22 * np.pi, 29)
    out = np.stack([width / 2 * np.cos(angle), depth / 2 * np.sin(angle)], -1)
    top = front + (high - front) * np.clip(0.5 + 0.9 * np.sin(angle), 0, 1) ** 1.2
    section = np.array([(0.05, 0.0), (0.0, 0.06), (-0.005, 0.5), (0.0, 0.92), (0.05, 1.0),
                        (0.10, 0.93), (0.115, 0.5), (0.11, 0.1)])  # fmt: skip
    unit = out / np.linalg.norm(out, axis=1, keepdims=True)
    wall = np.empty((29, len(section), 3))
    wall[..., :2] = out[:, None] - section[:, :1] * unit[:, None]
    wall[..., 2] = low + section[:, 1] * (seat - low + top[:, None])
    ends = wall.mean(1, keepdims=True).repeat(len(section), 1)
    body = np.concatenate([ends[:1], wall, ends[-1:]])
    from cmtof.scenes.rooms.solids import sheet

    disc = [(0.3, low + 0.002), (0.06, low + 0.002), (0.05, low + 0.012), (0.05, seat - 0.11),
            (0.3, seat - 0.11)]  # fmt: skip
    base = loft(width, depth, 0.32, disc, corner=7)
    sit = pad((width - 0.2, depth - 0.10, 0.13), (0, -0.03, seat - 0.13), radius=0.2, edge=0.04,
              crown=0.02)  # fmt: skip
    thing = Thing("armchair").add(joined([sheet(body, closed=True), base, sit]), cover)
    foot, head = (
        corners(0.42 * width, 0.42 * depth),
        corners(0.28 * width, 0.28 * depth, low + 0.01),
    )
    thing.add(rods(foot, head, 0.02, taper=0.6, sides=10), timber(rng, style), 2)
    thing.supports.append(Support(-0.17, 0.17, -0.2, 0.1, seat + 0.008))
    return thing
