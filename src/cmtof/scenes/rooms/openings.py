"""Windows: frames, sashes with glazing bars, sills; the panes are left out.

Windows and doors stand in the frame of their wall: x along it from the middle of the opening, the
room's face of the wall at y = 0, the reveal from there to y = depth, z = 0 at the opening's foot.
"""

import numpy as np
from numpy.typing import NDArray

from cmtof.scenes.rooms.bars import bar
from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.panels import Opening
from cmtof.scenes.rooms.plan import offset
from cmtof.scenes.rooms.solids import box, joined, quads
from cmtof.scenes.rooms.thing import Mesh, Support, Thing, moved, pose

Points = NDArray[np.float64]


def border(ring: Points, width: float, y0: float, y1: float, *, rim: bool = False) -> Mesh:
    """A mitred frame inside a ring (N, 2) of x and z, from y0 to y1, m; ``rim`` adds its edge."""
    inner = offset(ring, -width)
    near, far = _at(ring, y0), _at(ring, y1)
    near_in, far_in = _at(inner, y0), _at(inner, y1)
    nxt = np.roll(np.arange(len(ring)), -1)
    strips = [
        np.stack([near, near[nxt], near_in[nxt], near_in], 1),
        np.stack([near_in, near_in[nxt], far_in[nxt], far_in], 1),
        np.stack([far_in, far_in[nxt], far[nxt], far], 1),
    ]
    if rim:
        strips.append(np.stack([near, far, far[nxt], near[nxt]], 1))
    return quads(np.concatenate(strips))


def _at(flat: Points, y: float) -> Points:
    return np.stack([flat[:, 0], np.full(len(flat), y), flat[:, 1]], -1)


def rectangle(width: float, height: float, x: float = 0.0, z: float = 0.0) -> Points:
    """Ring of a rectangle centred on x, its foot at z, m."""
    a = width / 2
    return np.array([(x - a, z), (x + a, z), (x + a, z + height), (x - a, z + height)])


def sash(
    width: float,
    height: float,
    *,
    stile: float = 0.055,
    thickness: float = 0.045,
    columns: int = 1,
    rows: int = 1,
    muntin: float = 0.025,
    chamfer: float = 0.006,
) -> Mesh:
    """A glazed frame centred in x, foot at z = 0, between y = 0 and ``thickness``, with bars."""
    ring = rectangle(width, height)
    inner = offset(ring, -stile)
    pieces = [
        border(ring, stile, 0.0, thickness, rim=True),
        border(inner, chamfer, 0.3 * thickness, 0.7 * thickness),  # the rebate that holds the pane
    ]
    w, h = width - 2 * stile, height - 2 * stile
    for k in range(1, columns):
        x = -w / 2 + w * k / columns
        pieces.append(box((muntin, 0.7 * thickness, h), (x, thickness / 2, height / 2)))
    for k in range(1, rows):
        z = stile + h * k / rows
        pieces.append(box((w, 0.6 * thickness, muntin), (0, thickness / 2, z)))
    return joined(pieces)


def hung(mesh: Mesh, x: float, y: float, z: float, turn: float = 0.0) -> Mesh:
    """A mesh turned about the vertical and put at a place, m."""
    return moved(mesh, pose(x, y, z, turn))


def window(
    rng: np.random.Generator,
    style: Style,
    *,
    opening: Opening,
    depth: float,
    design: str | None = None,
    sill: bool = True,
) -> Thing:
    """A window that fills an opening in a wall ``depth`` m thick.

    Parameters
    ----------
    design : str
        casement, sash, grid, strip, french, round or roof; drawn to fit when None.
    sill : bool
        Add a board inside and a ledge outside.
    """
    width, height = opening.x1 - opening.x0, opening.z1 - opening.z0
    design = design or _design(rng, opening)
    frame_y = float(rng.uniform(0.3, 0.75)) * (depth - 0.09)
    material = _frame_material(rng, style)
    thing = Thing("window")
    own = Opening(-width / 2, width / 2, 0.0, height, opening.shape)
    border_width = float(rng.uniform(0.035, 0.06))
    thing.add(border(own.ring(), border_width, frame_y, frame_y + 0.075), material)
    inside = (width - 2 * border_width, height - 2 * border_width, border_width, frame_y + 0.012)
    if opening.shape != "rectangle":
        _round_bars(rng, thing, own, border_width, frame_y, material)
    else:
        _SASHES[design](rng, style, thing, inside, material)
    if sill:
        _sills(rng, style, thing, width, depth, frame_y)
    return thing


def _design(rng: np.random.Generator, opening: Opening) -> str:
    width, height = opening.x1 - opening.x0, opening.z1 - opening.z0
    if opening.z0 < 0.1:
        return "french"
    if width > 2.2 * height:
        return "strip"
    return str(rng.choice(["casement", "casement", "sash", "grid"]))


def _frame_material(rng: np.random.Generator, style: Style) -> Material:
    dark = Material((0.03, 0.03, 0.032), specular=0.05, gloss=30.0)
    white = Material((0.8, 0.8, 0.79), specular=0.06, gloss=60.0)
    return (style.trim, white, dark, style.wood)[int(rng.choice(4, p=[0.4, 0.3, 0.15, 0.15]))]


Inside = tuple[float, float, float, float]
"""Width, height, foot and front of the clear opening, m."""


def _bars(rng: np.random.Generator, width: float, height: float) -> tuple[int, int]:
    """Panes across and up: a lattice in old houses, none in new ones."""
    if rng.uniform() < 0.45:
        return 1, 1
    size = float(rng.uniform(0.28, 0.55))
    return max(1, round(width / size)), max(1, round(height / size))


def _casements(
    rng: np.random.Generator, style: Style, thing: Thing, inside: Inside, material: Material
) -> None:
    """Leaves side by side, one of which may stand open."""
    width, height, z, y = inside
    leaves = max(1, round(width / float(rng.uniform(0.6, 1.0))))
    each = width / leaves
    columns, rows = _bars(rng, each, height)
    leaf = sash(each - 0.004, height - 0.004, columns=columns, rows=rows)
    ajar = int(rng.integers(-2, leaves))
    for k in range(leaves):
        x = -width / 2 + each * (k + 0.5)
        handle = _handle((0.42 if k % 2 == 0 else -0.42) * each, height / 2)
        piece = joined([leaf, handle])
        if k == ajar and z < 5:
            side = -1 if k % 2 == 0 else 1
            piece = hung(piece, -side * each / 2, 0, 0)
            turn = side * float(rng.uniform(0.2, 1.3))
            thing.add(hung(piece, x + side * each / 2, y, z + 0.002, turn), material)
        else:
            thing.add(hung(piece, x, y, z + 0.002), material)


def _handle(x: float, z: float) -> Mesh:
    """A small lever on the room's side of a sash."""
    return joined(
        [
            box((0.028, 0.010, 0.07), (x, -0.005, z), bevel=0.003),
            bar((x, -0.008, z), (x, -0.045, z), 0.008, 8),
            bar((x, -0.045, z + 0.01), (x, -0.045, z - 0.12), 0.009, 8),
        ]
    )


def _sliding_sashes(
    rng: np.random.Generator, style: Style, thing: Thing, inside: Inside, material: Material
) -> None:
    """Two sashes that slide up and down past one another."""
    width, height, z, y = inside
    columns, rows = _bars(rng, width, height / 2)
    half = height / 2 + 0.02
    leaf = sash(width - 0.004, half, thickness=0.03, columns=columns, rows=rows)
    raised = float(rng.choice([0.0, 0.0, 0.15, 0.35])) * height / 2
    thing.add(hung(leaf, 0, y + 0.033, z + height - half - 0.002), material)
    thing.add(hung(leaf, 0, y, z + 0.002 + raised), material)


def _grid(
    rng: np.random.Generator, style: Style, thing: Thing, inside: Inside, material: Material
) -> None:
    """One fixed sash with a lattice, as in workshops and lofts."""
    width, height, z, y = inside
    size = float(rng.uniform(0.25, 0.6))
    leaf = sash(
        width - 0.004,
        height - 0.004,
        stile=0.03,
        columns=max(1, round(width / size)),
        rows=max(1, round(height / size)),
        muntin=float(rng.uniform(0.018, 0.03)),
    )
    thing.add(hung(leaf, 0, y, z + 0.002), material)


def _strip(
    rng: np.random.Generator, style: Style, thing: Thing, inside: Inside, material: Material
) -> None:
    """A ribbon of panes between mullions."""
    width, height, z, y = inside
    panes = max(2, round(width / float(rng.uniform(0.8, 1.4))))
    each = width / panes
    leaf = sash(each - 0.006, height - 0.004, stile=0.04)
    for k in range(panes):
        thing.add(hung(leaf, -width / 2 + each * (k + 0.5), y, z + 0.002), material)


def _french(
    rng: np.random.Generator, style: Style, thing: Thing, inside: Inside, material: Material
) -> None:
    """Glazed doors in pairs down to the floor; the last pair may stand open inwards."""
    width, height, z, y = inside
    leaves = max(2, 2 * round(width / 1.7))
    each = width / leaves
    rows = int(rng.choice([1, 1, 2, 4, 5]))
    leaf = sash(each - 0.004, height - 0.006, stile=0.08, rows=rows, columns=1 + (rows > 3))
    opened = float(rng.choice([0.0, 0.0, 0.6, 1.4]))
    for k in range(leaves):
        side = -1 if k % 2 == 0 else 1
        x = -width / 2 + each * (k + 0.5) + side * each / 2
        turn = side * opened if k >= leaves - 2 else 0.0
        piece = joined([leaf, _handle(-side * 0.42 * each, 1.0)])
        thing.add(hung(hung(piece, -side * each / 2, 0, 0), x, y, z + 0.003, turn), material)


def _roof(
    rng: np.random.Generator, style: Style, thing: Thing, inside: Inside, material: Material
) -> None:
    """One sash in a slope, with a bar to open it."""
    width, height, z, y = inside
    leaf = sash(width - 0.006, height - 0.006, stile=0.07)
    thing.add(hung(leaf, 0, y, z + 0.003), material)
    top = z + height - 0.05
    grip = bar((-0.35 * width, y - 0.03, top), (0.35 * width, y - 0.03, top), 0.01)
    thing.add(grip, style.metal)


_SASHES = {
    "casement": _casements,
    "sash": _sliding_sashes,
    "grid": _grid,
    "strip": _strip,
    "french": _french,
    "roof": _roof,
}


def _round_bars(
    rng: np.random.Generator,
    thing: Thing,
    opening: Opening,
    inset: float,
    y: float,
    material: Material,
) -> None:
    """A cross or a star of bars behind a round or arched frame."""
    z = opening.centre[1]
    a, b = (opening.x1 - opening.x0) / 2 - inset / 2, (opening.z1 - opening.z0) / 2 - inset / 2
    size = (0.03, 0.045)
    if opening.shape == "round":
        bars = [box((size[0], size[1], 2 * b), (0, y + 0.035, z))]
        bars.append(box((2 * a, 0.9 * size[1], size[0]), (0, y + 0.035, z)))
        if a > 0.45:
            bars.append(
                border(offset(opening.ring(), -a / 2), 0.028, y + 0.015, y + 0.053, rim=True)
            )
        thing.add(joined(bars), material)
        return
    spring = opening.z1 - min(a, opening.z1)
    bars = [box((2 * a, 0.9 * size[1], 0.05), (0, y + 0.035, spring))]
    columns = max(2, round(2 * a / 0.45))
    for k in range(1, columns):
        at = -a + 2 * a * k / columns
        bars.append(box((size[0], size[1], spring), (at, y + 0.035, spring / 2)))
    for k in range(1, int(spring / 0.5)):
        high = spring * k / int(spring / 0.5)
        bars.append(box((2 * a, 0.8 * size[1], 0.025), (0, y + 0.035, high)))
    for angle in np.linspace(0, np.pi, int(rng.integers(3, 6)) + 1)[1:-1]:
        tip = (a * np.cos(angle), y + 0.035, spring + a * np.sin(angle))
        bars.append(bar((0, y + 0.035, spring), tip, 0.014, 6))
    thing.add(joined(bars), material)


def _sills(
    rng: np.random.Generator, style: Style, thing: Thing, width: float, depth: float, y: float
) -> None:
    """A board inside, on which pots may stand, and a ledge outside."""
    stone = Material((0.6, 0.58, 0.55), (0.4, 0.38, 0.36), "marble", 0.2, 0.08, 80.0)
    inner = (style.trim, style.wood, stone)[int(rng.integers(3))]
    nose = float(rng.uniform(0.02, 0.12))
    board = box((width - 0.004, y + 0.02, 0.025), (0, (y + 0.02) / 2, 0.0095), bevel=0.003)
    lip = box((width + 0.1, nose, 0.026), (0, -nose / 2 + 0.002, 0.0095), bevel=0.004)
    thing.add(joined([board, lip]), inner)
    reach = depth + 0.05 - (y + 0.07)
    ledge = box((width - 0.004, reach, 0.02), (0, y + 0.07 + reach / 2, 0.001))
    thing.add(ledge, Material((0.35, 0.34, 0.33)))
    if nose + y > 0.1:
        clear = (-width / 2 + 0.05, width / 2 - 0.05, -nose + 0.01, y - 0.03, 0.022)
        thing.supports.append(Support(*clear, clearance=0.35))
