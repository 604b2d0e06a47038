"""Doors: linings and architraves, leaves of many designs, handles; see `openings` for the frame."""

import numpy as np

from cmtof.scenes.rooms.bars import bar
from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.openings import hung, sash
from cmtof.scenes.rooms.solids import box, joined
from cmtof.scenes.rooms.thing import Mesh, Thing

LINING = 0.024
DESIGNS = ("flush", "panels", "panels", "glazed", "half glazed", "boards")


def door(
    rng: np.random.Generator,
    style: Style,
    *,
    width: float,
    height: float,
    depth: float,
    threshold: Material,
    angle: float | None = 0.0,
    inwards: bool = True,
    sliding: bool = False,
) -> Thing:
    """A door in an opening of a wall ``depth`` m thick.

    Parameters
    ----------
    threshold : Material
        Of the strip of floor inside the reveal.
    angle : float or None
        How far the leaf stands open, rad; without a leaf when None.
    inwards : bool
        The leaf opens into the room that is in front of the wall.
    sliding : bool
        The leaf hangs from a rail in front of the wall; ``angle`` > 0 pushes it aside.
    """
    thing = Thing("door")
    _lining(rng, style, thing, width, height, depth)
    strip = box((width - 0.002, depth + 0.05, 0.02), (0, depth / 2, -0.0065))
    thing.add(strip, threshold)
    if angle is None:
        return thing
    clear, tall = width - 2 * LINING - 0.006, height - LINING - 0.012
    side = 1 if rng.uniform() < 0.5 else -1
    material = style.paint if rng.uniform() < 0.3 else style.trim
    if rng.uniform() < 0.25:
        material = style.second_wood
    if sliding:
        _sliding(rng, style, thing, width, height, side, angle > 0, material)
        return thing
    leaf = _leaf(rng, style, clear, tall, material, side)
    swing = -side * angle if inwards else side * angle
    pivot_y = -0.004 if inwards else depth + 0.004
    own = Thing("door leaf")
    for part in leaf.parts:
        shift = (-side * clear / 2, 0.0 if inwards else -0.04, 0.0)
        own.add(hung(part.mesh, *shift), part.material, part.grain)
    hinge = side * clear / 2
    # seen from above a leaf hinged on the right swings clockwise into the room
    return thing.carry(own, hinge, pivot_y, 0.008, -swing)


def _lining(
    rng: np.random.Generator, style: Style, thing: Thing, width: float, height: float, depth: float
) -> None:
    """Boards inside the reveal and architraves on both faces of the wall."""
    y, deep = depth / 2, depth + 0.01
    jamb = [
        box((LINING, deep, height), (s * (width / 2 - LINING / 2), y, height / 2)) for s in (-1, 1)
    ]
    head = box((width - 2 * LINING, deep, LINING), (0, y, height - LINING / 2))
    stop = [
        box(
            (0.012, 0.03, height - LINING),
            (s * (width / 2 - LINING - 0.005), y, (height - LINING) / 2),
        )
        for s in (-1, 1)
    ]
    broad = float(rng.uniform(0.05, 0.1)) * (1.2 - 0.4 * style.modern)
    thick = float(rng.uniform(0.012, 0.022))
    boards = []
    for face in (-thick / 2 + 0.001, depth + thick / 2 - 0.001):
        x = width / 2 - 0.008 + broad / 2
        boards += [
            box((broad, thick, height), (s * x, face, height / 2), bevel=0.004) for s in (-1, 1)
        ]
        top = box((2 * x + broad, 1.05 * thick, broad), (0, face, height + broad / 2), bevel=0.004)
        boards.append(top)
    thing.add(joined([*jamb, head, *stop, *boards]), style.trim, grain=2)


def _leaf(
    rng: np.random.Generator,
    style: Style,
    width: float,
    height: float,
    material: Material,
    side: int,
) -> Thing:
    """A leaf centred in x, y from 0 to 4 cm, hinged on ``side``, with its handles."""
    design = str(rng.choice(DESIGNS))
    leaf = Thing("door leaf")
    if design == "flush":
        leaf.add(box((width, 0.04, height), (0, 0.02, height / 2), bevel=0.003), material, 2)
    elif design == "panels":
        leaf.add(_panelled(rng, width, height), material, 2)
    elif design == "boards":
        leaf.add(_ledged(rng, width, height), material, 2)
    else:
        columns, rows = int(rng.integers(1, 4)), int(rng.integers(1, 6))
        low = 0.0 if design == "glazed" else float(rng.uniform(0.8, 1.1))
        leaf.add(
            hung(
                sash(width, height - low, stile=0.11, thickness=0.04, columns=columns, rows=rows),
                0,
                0,
                low,
            ),
            material,
            2,
        )
        if low:
            leaf.add(_panelled(rng, width, low - 0.001, rows=1), material, 2)
    leaf.add(lever(rng, -side * (width / 2 - 0.06)), style.metal)
    return leaf


def _panelled(
    rng: np.random.Generator, width: float, height: float, rows: int | None = None
) -> Mesh:
    """Stiles and rails around sunk panels with raised fields."""
    rows = int(rng.integers(1, 5)) if rows is None else rows
    columns = int(rng.integers(1, 3))
    stile = 0.10
    frame = sash(
        width,
        height,
        stile=stile,
        thickness=0.04,
        columns=columns,
        rows=rows,
        muntin=0.09,
        chamfer=0.012,
    )
    w, h = width - 2 * stile, height - 2 * stile
    pieces = [frame, box((w, 0.014, h), (0, 0.02, height / 2))]
    raised = float(rng.choice([0.0, 0.022]))
    if raised:
        for i in range(columns):
            for j in range(rows):
                size = (w / columns - 0.16, raised, h / rows - 0.16)
                if min(size) > 0.01:
                    at = (-w / 2 + w * (i + 0.5) / columns, 0.02, stile + h * (j + 0.5) / rows)
                    pieces.append(box(size, at, bevel=0.006))
    return joined(pieces)


def _ledged(rng: np.random.Generator, width: float, height: float) -> Mesh:
    """Upright boards with gaps, on ledges and a brace."""
    count = max(4, round(width / 0.13))
    each = width / count
    pieces = [
        box(
            (each - 0.004, 0.024, height),
            (-width / 2 + each * (k + 0.5), 0.012, height / 2),
            bevel=0.003,
        )
        for k in range(count)
    ]
    for z in (0.2, 0.5, 0.85):
        pieces.append(box((0.94 * width, 0.018, 0.12), (0, 0.0325, z * height), bevel=0.003))
    return joined(pieces)


def lever(rng: np.random.Generator, x: float, z: float | None = None) -> Mesh:
    """Handles on both faces of a leaf 4 cm thick: levers, knobs or bars."""
    z = float(rng.uniform(0.98, 1.08)) if z is None else z
    towards = -np.sign(x) * 0.12
    kind = int(rng.integers(3))
    pieces = []
    for y, out in ((0.0, -1.0), (0.04, 1.0)):
        pieces.append(
            box(
                (0.045, 0.008, 0.22 if kind == 0 else 0.05),
                (x, y + out * 0.003, z - 0.03 * (kind == 0)),
                bevel=0.003,
            )
        )
        tip = (x, y + out * 0.055, z)
        pieces.append(bar((x, y, z), tip, 0.009))
        if kind == 1:
            pieces.append(bar((x, y + out * 0.04, z), (x, y + out * 0.07, z), 0.028, 14))
        else:
            pieces.append(bar((x - 0.08 * towards, tip[1], z), (x + towards, tip[1], z), 0.0095))
    return joined(pieces)


def _sliding(
    rng: np.random.Generator,
    style: Style,
    thing: Thing,
    width: float,
    height: float,
    side: int,
    aside: bool,
    material: Material,
) -> None:
    """A leaf that hangs from a rail in front of the wall."""
    broad, tall = width + 0.12, height + 0.06
    leaf = _leaf(rng, style, broad, tall, material, side)
    leaf.parts.pop()
    grip = bar((0, -0.03, 0.85), (0, -0.03, 1.25), 0.011)
    knobs = [bar((0, -0.03, z), (0, 0.002, z), 0.007) for z in (0.9, 1.2)]
    leaf.add(hung(joined([grip, *knobs]), -side * (broad / 2 - 0.07), 0, 0), style.metal)
    x = side * (broad - 0.02) if aside else 0.0
    rail = box((2 * broad, 0.008, 0.045), (side * broad / 2, -0.052, tall + 0.09), bevel=0.002)
    hangers = [
        box((0.035, 0.006, 0.18), (x + s * 0.35 * broad, -0.065, tall + 0.03)) for s in (-1, 1)
    ]
    thing.add(joined([rail, *hangers]), style.metal)
    thing.carry(leaf, x, -0.075, 0.012)
