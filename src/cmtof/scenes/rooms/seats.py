"""What one sits on besides chairs at a table: stools, benches, chairs that turn or rock, m."""

from itertools import pairwise

import numpy as np

from cmtof.scenes.rooms.cabinetry import BLACK, CHROME, Maker, timber, turned_leg
from cmtof.scenes.rooms.chairs import (
    Build,
    back_line,
    back_posts,
    curved_slat,
    dining_chair,
    flared,
    front_legs,
    seat_board,
    shell_grid,
)  # fmt: skip
from cmtof.scenes.rooms.joinery import (
    beams,
    bent,
    boards,
    copies,
    corners,
    mirrored,
    placed,
    plank,
    raised,
    rods,
    rounded,
    shifted,
)  # fmt: skip
from cmtof.scenes.rooms.materials import Style
from cmtof.scenes.rooms.sofas import armchair, short_feet, sofa
from cmtof.scenes.rooms.solids import joined, revolve, tube
from cmtof.scenes.rooms.thing import Mesh, Support, Thing
from cmtof.scenes.rooms.upholstery import cloth, dented, loft, pad


def stool(rng: np.random.Generator, style: Style, *, height: float | None = None) -> Thing:
    """A stool: round on splayed legs, a milking stool, a square one, with or without a pad."""
    height = float(rng.uniform(0.42, 0.5)) if height is None else height
    return _stool(rng, style, height, "stool")


def bar_stool(rng: np.random.Generator, style: Style) -> Thing:
    """A high stool with a foot rest, on four legs or on a gas lift."""
    height = float(rng.uniform(0.62, 0.78))
    if rng.uniform() < 0.35:
        r = 0.19
        disc = rounded([(r, 0.0), (r, 0.012), (0.6 * r, 0.022), (0.035, 0.04), (0.028, 0.12)])
        rows = np.concatenate([[(0, 0)], disc, [(0.028, height - 0.08), (0, height - 0.08)]])
        turn = np.linspace(0, 2 * np.pi, 25)
        rest = np.stack([0.13 * np.sin(turn), -0.06 - 0.13 * np.cos(turn), 0 * turn + 0.26], -1)
        steel = joined([revolve(rows, 24), tube(rest, 0.009, 8)])
        thing = Thing("bar stool").add(steel, CHROME)
        b = Build(0.40, 0.36, height, height + 0.25, 0.04)
        grid = shell_grid(b, arms=False)
        thing.add(cloth(grid, 0.03), style.leather, 1)
        thing.supports.append(Support(-0.1, 0.1, -0.1, 0.06, height - 0.005))
        return thing
    return _stool(rng, style, height, "bar stool")


def _stool(rng: np.random.Generator, style: Style, height: float, kind: str) -> Thing:
    """A seat on three or four splayed legs with rungs."""
    material, size = timber(rng, style), float(rng.uniform(0.30, 0.38))
    round_one, padded = rng.uniform() < 0.6, rng.uniform() < 0.35
    thick = 0.07 if padded else 0.032
    corner = 0.49 * size if round_one else 0.04
    if padded:
        seat = pad((size, size, thick), radius=corner, edge=0.03, crown=0.012, side=0)
        seat = shifted(seat, 0, 0, height - thick)
        thing = Thing(kind).add(seat, style.leather)
    else:
        rows = [(size / 2, -thick), (0.01, -thick), (0, -thick + 0.01), (0, -0.008), (0.003,
            -0.002),
                (0.01, 0), (0.05, -0.003), (size / 2, -0.006)]  # fmt: skip
        thing = Thing(kind).add(loft(size, size, corner, rows, (0, 0, height), corner=8), material)
    count = 3 if round_one and height < 0.55 and rng.uniform() < 0.4 else 4
    turn = np.arange(count) * 2 * np.pi / count + np.pi / 4
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], -1)
    head, foot = 0.38 * size * ring, (0.52 if height < 0.55 else 0.6) * size * ring
    head = raised(head, height - thick + 0.008)
    legs = rods(foot, head, 0.015, taper=0.75, sides=10)
    pieces = [legs]
    for k, share in enumerate((0.32, 0.40) if count == 4 else (0.4,)):
        at = (1 - share) * foot + share * head
        pairs = [(k, k + 1), (k + 2, (k + 3) % 4)] if count == 4 else [(0, 1), (1, 2), (2, 0)]
        pieces.append(rods([at[p] for p, _ in pairs], [at[q] for _, q in pairs], 0.009))
    thing.add(joined(pieces), material if rng.uniform() < 0.7 else style.metal, 2)
    thing.supports.append(Support(-0.3 * size, 0.3 * size, -0.3 * size, 0.3 * size, height - 0.003))
    return thing


def office_chair(rng: np.random.Generator, style: Style) -> Thing:
    """A swivel chair: five-star base on castors, gas lift, seat, back on a bracket, arms."""
    seat, width = float(rng.uniform(0.44, 0.52)), float(rng.uniform(0.46, 0.52))
    frame_material = BLACK if rng.uniform() < 0.6 else CHROME
    turn = np.arange(5) * 2 * np.pi / 5 + np.pi / 2
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], -1)
    star = rods(raised(0.3 * ring, 0.075), raised(0.03 * ring, 0.10), 0.028, taper=0.55, sides=8)
    lift = revolve([(0, 0.06), (0.045, 0.06), (0.045, 0.13), (0.03, 0.135), (0.028, 0.26),
                    (0.018, 0.262), (0.018, seat - 0.08), (0, seat - 0.08)], 12)  # fmt: skip
    plate = boards([(-0.13, 0.13, -0.12, 0.12, seat - 0.095, seat - 0.055)], 0.008)
    stand = Thing("office chair").add(joined([star, lift, plate]), frame_material)
    wheels = []
    for centre, angle in zip(0.31 * ring, turn + rng.uniform(0, 6, 5), strict=True):
        pair = rods([(-0.024, 0, 0.03), (0.006, 0, 0.03)], [(-0.006, 0, 0.03), (0.024, 0, 0.03)],
                    0.03, sides=10)  # fmt: skip
        pin = rods([(0, 0, 0.03)], [(0, 0, 0.085)], 0.006, sides=6)
        wheels.append(placed(joined([pair, pin]), centre, turn=float(angle)))
    stand.add(joined(wheels), BLACK)
    cover = (style.fabric, style.leather, BLACK)[int(rng.integers(3))]
    sit = pad((width, 0.47, 0.085), (0, -0.01, seat - 0.07), radius=0.1, edge=0.035, crown=0.01)
    sit = dented(sit, [(0, 0)], 0.012, 0.18)
    tall = float(rng.choice([0.42, 0.55, 0.7]))
    rest = pad((0.9 * width, tall, 0.065), radius=0.09, edge=0.03, crown=0.012, side=3)
    v = rest.vertices.astype(float)
    v[:, 2] += 0.35 * v[:, 0] ** 2 - 0.03 * np.cos(5 * v[:, 1] / tall) + 0.02
    rest = Mesh(v.astype(np.float32), rest.faces)
    rest = placed(rest, (0, 0.25, seat + 0.13 + tall / 2), lean=np.pi / 2 - 0.12)
    stand.add(joined([sit, rest]), cover)
    line = [(0, 0.05, seat - 0.08), (0, 0.27, seat - 0.07), (0, 0.33, seat + 0.3)]
    bracket = plank(bent(line, 0.09), (0.06, 0, 0), 0.015)
    pieces = [bracket]
    if rng.uniform() < 0.65:
        x = width / 2 + 0.035
        post = beams([(x, 0.0, seat - 0.065)], [(x, 0.0, seat + 0.19)], 0.03, 0.055)
        foot = beams([(0.1, 0, seat - 0.066)], [(x + 0.014, 0, seat - 0.066)], 0.055, 0.02)
        top = pad((0.085, 0.26, 0.03), (x, -0.02, seat + 0.188), radius=0.03, edge=0.012, crown=0)
        side = joined([post, foot, top])
        pieces += [side, mirrored(side)]
    stand.add(joined(pieces), BLACK)
    stand.supports.append(Support(-0.14, 0.14, -0.15, 0.08, seat + 0.014))
    return stand


def bench(rng: np.random.Generator, style: Style) -> Thing:
    """A bench for a hall or a long table: planks on frames, or padded on legs."""
    length, depth = float(rng.uniform(0.9, 1.5)), float(rng.uniform(0.30, 0.38))
    height, material = float(rng.uniform(0.43, 0.48)), timber(rng, style)
    half, kind = (length / 2, depth / 2), int(rng.integers(3))
    thing = Thing("bench")
    if kind == 0:
        count = int(rng.choice([1, 3, 5]))
        at = np.linspace(-half[1], half[1], count + 1)
        rows = [(-half[0], half[0], p + 0.004, q - 0.004, height - 0.03, height)
                for p, q in pairwise(at)]  # fmt: skip
        x = half[0] - 0.18
        ends = [(s * x - 0.018, s * x + 0.018, -half[1] + 0.015, half[1] - 0.015, 0.0,
            height - 0.029)
                for s in (-1, 1)]  # fmt: skip
        bar = (-x, x, -0.02, 0.02, 0.15, 0.23)
        thing.add(boards([*rows, bar], 0.004), material).add(boards(ends), material, 2)
    else:
        under = height - (0.075 if kind == 2 else 0.03)
        if kind == 2:
            mesh = pad((length, depth, 0.085), (0, 0, height - 0.09), radius=0.03, edge=0.025)
            thing.add(dented(mesh, [(-0.25, 0), (0.25, 0)], 0.008, 0.2), style.fabric)
        else:
            thing.add(
                boards([(-half[0], half[0], -half[1], half[1], under, height)], 0.006), material
            )
        if rng.uniform() < 0.5:
            leg = turned_leg(rng, under + 0.002, 0.03)
            legs = copies(leg, corners(half[0] - 0.06, half[1] - 0.05))
        else:
            foot = corners(half[0] - 0.04, half[1] - 0.03)
            legs = beams(
                foot, raised(foot * [0.95, 0.9, 1], under + 0.002), 0.045, 0.045, taper=0.7
            )
        x, y = half[0] - 0.08, half[1] - 0.055
        apron = boards([(-x, x, s * y - 0.01, s * y + 0.01, under - 0.06, under + 0.001)
                        for s in (-1, 1)])  # fmt: skip
        thing.add(legs, material, 2).add(apron, material)
    thing.supports.append(Support(-0.45 * length, 0.45 * length, -0.4 * depth, 0.4 * depth, height,
                                  clearance=0.8))  # fmt: skip
    return thing


def ottoman(rng: np.random.Generator, style: Style) -> Thing:
    """A padded stool for the feet: cube, drum, or a knitted ball that has been sat on."""
    kind, height = int(rng.integers(3)), float(rng.uniform(0.36, 0.45))
    size = float(rng.uniform(0.42, 0.6))
    cover = (style.fabric, style.second_fabric, style.leather)[int(rng.integers(3))]
    thing = Thing("ottoman")
    if kind == 2:
        rows = np.array([(0, 0), (0.55, 0.0), (0.8, 0.08), (0.97, 0.3), (1.0, 0.5), (0.93, 0.74),
                         (0.75, 0.92), (0.5, 0.99), (0.2, 0.985), (0, 0.975)])  # fmt: skip
        mesh = revolve(np.concatenate([rows[:1], rounded(rows[1:-1]), rows[-1:]])
                       * [size / 2, 0.85 * height], 40)  # fmt: skip
        turn = np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0])
        mesh.vertices[:, :2] *= (1 + 0.012 * np.cos(16 * turn))[:, None].astype(np.float32)
        thing.add(mesh, cover, 2)
        thing.supports.append(Support(-0.1, 0.1, -0.1, 0.1, 0.83 * height))
        return thing
    width = size * float(rng.choice([1.0, 1.0, 1.5])) if kind == 0 else size
    foot = float(rng.uniform(0.03, 0.12))
    radius = 0.04 if kind == 0 else 0.49 * size
    mesh = pad((width, size, height - foot - 0.015), (0, 0, foot), radius=radius, edge=0.03,
               crown=0.015, side=4 if kind == 0 else 0)  # fmt: skip
    thing.add(mesh, cover)
    reach = (width / 2, size / 2) if kind == 0 else (0.8 * size / 2, 0.8 * size / 2)
    thing.add(short_feet(rng, reach, foot + 0.005), style.wood, 2)
    thing.supports.append(
        Support(-0.25 * width, 0.25 * width, -0.25 * size, 0.25 * size, height - 0.003)
    )
    return thing


def rocking_chair(rng: np.random.Generator, style: Style) -> Thing:
    """A chair with arms and slats or rungs on two bent rockers."""
    material, lift = timber(rng, style), 0.055
    b = Build(float(rng.uniform(0.5, 0.56)), 0.46, 0.40, float(rng.uniform(1.0, 1.12)) - lift, 0.16)
    size = 0.035
    frame = joined([back_posts(b, size), front_legs(b, size, True)])
    x, y = b.width / 2 - size, b.depth / 2
    post = rods([(s * x, -y + size, b.seat - 0.02) for s in (-1, 1)],
                [(s * x, -y + size, b.seat + 0.22) for s in (-1, 1)], 0.014)  # fmt: skip
    inner = 0.45 * b.width - size / 2
    rear = float(back_line(b, np.array([b.seat + 0.23]))[0])
    arms = beams([(s * (x + 0.01), -y - 0.02, b.seat + 0.225) for s in (-1, 1)],
                 [(s * (inner + 0.006), rear, b.seat + 0.24) for s in (-1, 1)], 0.06,
                     0.02)  # fmt: skip
    half, span = 0.45 * b.width - size, b.back - b.seat
    if rng.uniform() < 0.5:
        level = b.seat + span * np.linspace(0.2, 0.95, 6)
        rest = joined([curved_slat(b, float(z), 0.06, half, 0.035) for z in level])
    else:
        low, high = b.seat + 0.06, b.back - 0.04
        u = np.linspace(-0.85, 0.85, 7)
        y0, y1 = back_line(b, np.array([low, high]))
        sticks = rods([(k * half, y0, low) for k in u], [(k * half, y1, high) for k in u], 0.008)
        rest = joined(
            [sticks, curved_slat(b, high, 0.08, half, 0.0), curved_slat(b, low, 0.03, half, 0)]
        )
    parts = [frame, post, arms, rest]
    parts = [shifted(m, 0, 0, lift) for m in parts]
    turn = np.linspace(-0.42, 0.36, 17)
    bow = 1.05
    curve = np.stack([0 * turn, 0.06 + bow * np.sin(turn), 0.017 + bow * (1 - np.cos(turn))], -1)
    rocker = plank(curve, (0.028, 0, 0), 0.034)
    rocker.vertices[:, 2] -= rocker.vertices[:, 2].min()
    rockers = copies(rocker, [(-inner, 0, 0), (inner, 0, 0)])
    thing = Thing("rocking chair").add(joined([*parts[:2], parts[3]]), material, 2)
    thing.add(joined([rockers, parts[2]]), material, 1)
    seat = flared(pad((b.width, b.depth, 0.05), radius=0.05), b) if rng.uniform() < 0.5 else None
    if seat is None:
        board = seat_board(b)
        thing.add(shifted(board, 0, 0, lift), material, 1)
        level = b.seat + lift - 0.004
    else:
        thing.add(shifted(seat, 0, 0, b.seat + lift - 0.028), style.fabric)
        level = b.seat + lift + 0.029
    thing.supports.append(Support(-0.14, 0.14, -0.13, 0.1, level))
    return thing


CATALOGUE: dict[str, Maker] = {
    "dining_chair": dining_chair,
    "armchair": armchair,
    "sofa": sofa,
    "stool": stool,
    "bar_stool": bar_stool,
    "office_chair": office_chair,
    "bench": bench,
    "ottoman": ottoman,
    "rocking_chair": rocking_chair,
}
