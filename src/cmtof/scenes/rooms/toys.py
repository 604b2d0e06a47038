"""Toys and games: a bear, cars, a train, blocks, balls, a chess board, m."""

import numpy as np

from cmtof.scenes.rooms.cabinetry import BLACK
from cmtof.scenes.rooms.joinery import boards, copies, faceted_rings, placed, rods, shifted
from cmtof.scenes.rooms.materials import Material, Style, darker, hue
from cmtof.scenes.rooms.shaping import handle, laid, modelled, pick, stood, turned
from cmtof.scenes.rooms.solids import ball, cylinder, joined, prism, quads
from cmtof.scenes.rooms.thing import Mesh, Thing
from cmtof.scenes.rooms.vessels import Maker, between

WOODEN = Material((0.62, 0.47, 0.3), (0.52, 0.37, 0.21), "wood", 0.02, specular=0.05)


def painted(rng: np.random.Generator) -> Material:
    """A toy's strong lacquer."""
    tone = hue(float(rng.uniform()), between(rng, 0.6, 0.9), between(rng, 0.15, 0.65))
    return Material(tone, specular=0.08, gloss=80.0)


def teddy_bear(rng: np.random.Generator, style: Style) -> Thing:
    """A sitting bear: head with muzzle and ears, arms, legs with soles, m."""
    s = between(rng, 0.13, 0.3)
    shade = between(rng, 0.2, 0.7)
    base = ((shade, 0.62 * shade, 0.32 * shade), (shade, 0.9 * shade, 0.75 * shade),
        (0.5 * shade, 0.42 * shade, 0.36 * shade))[int(rng.integers(3))]  # fmt: skip
    fur = Material(base, darker(base, 0.7), "noise", 0.012, specular=0.0, bump=0.8)
    pale = Material(darker(base, 1.4), darker(base, 1.2), "noise", 0.01, specular=0.0, bump=0.5)
    tip = between(rng, -0.08, 0.08)
    body = modelled((0.62, 0.52, 0.74), [((0, -1, -0.3), 0.5, 0.08)], (0, 0, 0.36))
    head = modelled((0.54, 0.5, 0.48), [((0.8, -0.2, 0), 0.5, 0.06), ((-0.8, -0.2, 0), 0.5, 0.06)],
        (tip, -0.05, 0.9))  # fmt: skip
    ears = [modelled((0.19, 0.1, 0.19), [((0, -1, 0), 0.5, -0.25)], (tip + k * 0.21, -0.02, 1.1),
        subdivisions=1) for k in (-1, 1)]  # fmt: skip
    limbs = []
    soles = []
    for k in (-1, 1):
        up = between(rng, -0.1, 0.15)
        limbs.append(handle([(k * 0.22, -0.02, 0.62), (k * 0.38, -0.12, 0.48 + 0.5 * up),
            (k * 0.4, -0.24, 0.4 + up)], [0.1, 0.105, 0.11, 0.09], count=9, sides=9))  # fmt: skip
        limbs.append(
            modelled((0.19, 0.19, 0.19), centre=(k * 0.4, -0.25, 0.395 + up), subdivisions=2)
        )
        limbs.append(handle([(k * 0.16, -0.05, 0.15), (k * 0.26, -0.3, 0.13),
            (k * 0.3, -0.46, 0.14)], [0.13, 0.125, 0.11], count=7, sides=9))  # fmt: skip
        limbs.append(modelled((0.25, 0.16, 0.3), centre=(k * 0.31, -0.48, 0.15), subdivisions=2))
        soles.append(modelled((0.19, 0.05, 0.24), centre=(k * 0.31, -0.545, 0.15), subdivisions=1))
    muzzle = modelled((0.25, 0.2, 0.19), centre=(tip, -0.28, 0.84), subdivisions=2)
    nose = modelled((0.085, 0.06, 0.06), centre=(tip, -0.375, 0.885), subdivisions=1)
    eyes = [ball(0.032, (tip + k * 0.105, -0.265, 0.965), 1) for k in (-1, 1)]
    thing = Thing("teddy bear")
    meshes = [(joined([body, head, *ears, *limbs]), fur), (joined([muzzle, *soles]), pale),
        (joined([nose, *eyes]), BLACK)]  # fmt: skip
    if rng.uniform() < 0.5:
        bow = [modelled((0.17, 0.07, 0.13), [((k, 0, 0), 0.6, 0.3)],
            (tip / 2 + k * 0.1, -0.25, 0.68), subdivisions=1) for k in (-1, 1)]  # fmt: skip
        meshes.append((joined([*bow, ball(0.04, (tip / 2, -0.27, 0.68), 1)]), painted(rng)))
    for mesh, material in meshes:
        thing.add(Mesh(mesh.vertices * np.float32(s), mesh.faces), material)
    return stood(thing)


def _wheels(at: list[tuple[float, float]], y: float, r: float, wide: float) -> tuple[Mesh, Mesh]:
    """Tyres and hubs on both sides, their axles across."""
    tyre = laid(turned([(0, -wide / 2), (0.8 * r, -wide / 2), (r, -0.3 * wide), (r, 0.3 * wide),
        (0.8 * r, wide / 2), (0, wide / 2)], 18, 12), 1)  # fmt: skip
    hub = laid(cylinder(0.45 * r, 1.25 * wide, sides=12), 1)
    places = [(x, s * y, z) for x, z in at for s in (-1, 1)]
    return copies(tyre, places), copies(hub, places)


def toy_car(rng: np.random.Generator, style: Style) -> Thing:
    """A saloon, a pick-up or a bus, of tin, plastic or wood, m."""
    long = between(rng, 0.08, 0.26)
    kind = int(rng.integers(3))
    w, h = 0.42 * long, (0.3, 0.36, 0.4)[kind] * long
    r = 0.1 * long
    body = WOODEN if rng.uniform() < 0.2 else painted(rng)
    thing = Thing("toy car")
    low = 0.55 * r
    half = [(-long / 2, long / 2, -w / 2, w / 2, low, low + (0.42, 0.36, 0.9)[kind] * h)]
    thing.add(boards(half, 0.16 * h), body)
    top = low + (0.42, 0.36, 0.9)[kind] * h
    if kind < 2:
        x0, x1 = ((-0.26, 0.3), (-0.32, 0.05))[kind]
        z1 = low + h
        cab = np.array([[(x0, -0.46, top / h - 0.02), (x1, -0.46, top / h - 0.02),
            (x1, 0.46, top / h - 0.02), (x0, 0.46, top / h - 0.02)],
            [(x0 + 0.1, -0.38, z1 / h), (x1 - 0.07, -0.38, z1 / h), (x1 - 0.07, 0.38, z1 / h),
            (x0 + 0.1, 0.38, z1 / h)]]) * [long, w, h]  # fmt: skip
        glass_ = Material((0.02, 0.03, 0.04), specular=0.25, gloss=400.0)
        thing.add(faceted_rings(cab), glass_)
        roof = [((x0 + 0.09) * long, (x1 - 0.06) * long, -0.4 * w, 0.4 * w, z1 - 0.002,
            z1 + 0.03 * long)]  # fmt: skip
        thing.add(boards(roof, 0.02 * long), body)
        posts = rods(cab[0].reshape(-1, 3), cab[1].reshape(-1, 3), 0.018 * long, sides=5)
        thing.add(posts, body)
        if kind == 1:
            sides = [(0.05 * long, 0.48 * long, s * 0.46 * w - 0.02 * long,
                s * 0.46 * w + 0.02 * long, top - 0.01 * long, top + 0.1 * long) for s in (-1,
                1)]  # fmt: skip
            thing.add(boards(sides, 0.01 * long), body)
    else:
        panes = [(-0.4 * long + 0.17 * k * long, -0.28 * long + 0.17 * k * long, -w / 2 - 0.0005,
            w / 2 + 0.0005, 0.5 * h + low, 0.78 * h + low) for k in range(5)]  # fmt: skip
        thing.add(boards(panes, 0), Material((0.02, 0.03, 0.04), specular=0.25, gloss=400.0))
    tyres, hubs = _wheels([(-0.3 * long, r), (0.3 * long, r)], w / 2 - 0.02 * long, r, 0.09 * long)
    thing.add(tyres, BLACK).add(hubs, Material((0.6, 0.6, 0.6), specular=0.4))
    lamps = [shifted(laid(cylinder(0.028 * long, 0.02 * long, sides=10), 0), -long / 2,
        s * 0.34 * w, low + 0.2 * h) for s in (-1, 1)]  # fmt: skip
    return stood(thing.add(joined(lamps), Material((0.75, 0.7, 0.4), specular=0.2)))


def toy_train(rng: np.random.Generator, style: Style) -> Thing:
    """A wooden engine with its wagons, m."""
    u = between(rng, 0.035, 0.055)
    thing = Thing("toy train")
    colour = painted(rng)
    base = boards([(-1.3 * u, 1.3 * u, -0.5 * u, 0.5 * u, 0.42 * u, 0.65 * u)], 0.003)
    boiler = shifted(laid(turned([(0, -0.9 * u), (0.42 * u, -0.9 * u), (0.45 * u, -0.8 * u),
        (0.45 * u, 0.6 * u), (0, 0.6 * u)], 20, 12), 0), -0.35 * u, 0, 1.07 * u)  # fmt: skip
    chimney = turned(np.array([(0, 0), (0.14, 0), (0.13, 0.45), (0.22, 0.62), (0.22, 0.72),
        (0, 0.72)]) * u, 14, 10)  # fmt: skip
    dome = ball(0.19 * u, (-0.35 * u, 0, 1.5 * u), 2)
    cab = boards([(0.35 * u, 1.2 * u, -0.5 * u, 0.5 * u, 0.64 * u, 1.75 * u),
        (0.25 * u, 1.32 * u, -0.58 * u, 0.58 * u, 1.74 * u, 1.9 * u)], 0.003)  # fmt: skip
    thing.add(joined([base, dome]), WOODEN).add(boiler, colour)
    thing.add(shifted(chimney, -0.95 * u, 0, 1.45 * u), BLACK).add(cab, painted(rng))
    ends = [(-0.85 * u, 0.4 * u), (0.0, 0.4 * u), (0.85 * u, 0.4 * u)]
    x = 1.3 * u
    for _ in range(int(rng.integers(1, 4))):
        middle = x + 0.25 * u + 1.1 * u
        bed = boards(
            [(middle - 1.1 * u, middle + 1.1 * u, -0.5 * u, 0.5 * u, 0.42 * u, 0.65 * u)], 0.003
        )
        hook = rods([(x - 0.1 * u, 0, 0.52 * u)], [(x + 0.35 * u, 0, 0.52 * u)], 0.05 * u)
        thing.add(joined([bed, hook]), WOODEN)
        kind = int(rng.integers(3))
        if kind == 0:
            box_ = boards([(middle - u, middle + u, -0.48 * u, 0.48 * u, 0.64 * u, 1.5 * u)], 0.004)
            thing.add(box_, painted(rng))
        elif kind == 1:
            logs = rods([(middle - u, y * u, z * u) for y, z in ((-0.25, 0.88), (0.25, 0.88),
                (0, 1.28))], [(middle + u, y * u, z * u) for y,
                z in ((-0.25, 0.88), (0.25, 0.88), (0, 1.28))], 0.235 * u, sides=10)  # fmt: skip
            thing.add(logs, style.wood)
        else:
            cubes = boards([(middle + (2 * j - 2.4) * 0.36 * u,
                middle + (2 * j - 0.6) * 0.36 * u - 0.02 * u, -0.33 * u, 0.33 * u, 0.64 * u,
                1.27 * u) for j in range(3)], 0.003)  # fmt: skip
            thing.add(cubes, painted(rng))
        ends += [(middle - 0.65 * u, 0.33 * u), (middle + 0.65 * u, 0.33 * u)]
        x = middle + 1.1 * u
    tyre = laid(cylinder(0.33 * u, 0.16 * u, sides=14), 1)
    hub = laid(cylinder(0.14 * u, 0.22 * u, sides=6), 1)
    places = [(a, s * 0.52 * u, 0.33 * u) for a, _ in ends for s in (-1, 1)]
    thing.add(copies(tyre, places), painted(rng)).add(copies(hub, places), WOODEN)
    return stood(thing)


def building_blocks(rng: np.random.Generator, style: Style) -> Thing:
    """A tower, an arch and a dozen blocks about them: cubes, bricks, pillars, roofs, m."""
    u = between(rng, 0.03, 0.045)
    paints = [painted(rng) for _ in range(4)] + [WOODEN]
    thing = Thing("building blocks")
    g = 0.0006

    def lay(mesh: Mesh, x: float, y: float, z: float, turn: float = 0.0) -> None:
        thing.add(placed(mesh, (x, y, z), turn=turn), paints[int(rng.integers(5))])

    cube = boards([(-u / 2, u / 2, -u / 2, u / 2, 0, u)], 0.0015)
    brick = boards([(-u, u, -u / 2, u / 2, 0, u)], 0.0015)
    pillar = shifted(cylinder(0.48 * u, 2 * u, sides=16), 0, 0, u)
    roof = _wedge(2 * u, u, u)
    z = 0.0
    for _ in range(int(rng.integers(2, 6))):
        x, y = rng.normal(0, 0.05 * u, 2)
        lay(cube, x, y, z, float(rng.normal(0, 0.15)))
        z += u + g
    lay(roof, 0, 0, z, float(rng.normal(0, 0.2)))
    a = between(rng, -0.5, 0.5) + np.pi * pick(rng, 0, 1)
    c, s = np.cos(a), np.sin(a)
    for side in (-1, 1):
        lay(pillar, 3.2 * u * c - side * 0.75 * u * s, 3.2 * u * s + side * 0.75 * u * c, 0)
    lay(boards([(-1.3 * u, 1.3 * u, -u / 2, u / 2, 0, 0.6 * u)], 0.0015), 3.2 * u * c, 3.2 * u * s,
        2 * u + g, a + np.pi / 2)  # fmt: skip
    taken = [(0.0, 0.0), (3.2 * u * c, 3.2 * u * s)]
    for k in range(int(rng.integers(6, 12))):
        for _ in range(8):
            x, y = rng.uniform(-5 * u, 5 * u, 2)
            if all((x - p) ** 2 + (y - q) ** 2 > (2.4 * u) ** 2 for p, q in taken):
                lay((cube, brick, brick, roof, placed(pillar, (0, 0, 0.48 * u),
                    tilt=np.pi / 2))[k % 5], x, y, 0, between(rng, -3, 3))  # fmt: skip
                taken.append((x, y))
                break
    return stood(thing)


def _wedge(long: float, wide: float, high: float) -> Mesh:
    """A roof-shaped block."""
    tri = prism([(-long / 2, 0), (long / 2, 0), (0, high)], wide)
    turn = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], np.float32)
    points = tri.vertices @ turn
    return Mesh(points + np.array([0, wide / 2, 0], np.float32), tri.faces)


def ball_toy(rng: np.random.Generator, style: Style) -> Thing:
    """A football with panels, a beach ball, a tennis ball or a rubber ball, m."""
    kind = int(rng.integers(4))
    r = (0.11, between(rng, 0.12, 0.18), 0.033, between(rng, 0.04, 0.09))[kind] * between(
        rng, 0.98, 1.02
    )
    if kind == 0:
        return _football(r)
    tone = painted(rng).colour
    base = (0.62, 0.7, 0.08) if kind == 2 else tone
    pattern = "stripes" if kind == 1 else "plain"
    skin = Material(base, (0.8, 0.8, 0.78), pattern, 0.5 * r, 0.08, bump=0.4 * (kind == 2))
    return stood(Thing("ball").add(ball(r, subdivisions=3), skin))


def _football(r: float) -> Thing:
    """Twelve dark and twenty light panels with seams between them."""
    golden = (1 + 5**0.5) / 2
    sign = np.array([(a, b) for a in (-1, 1) for b in (-1, 1)])
    five = np.array([np.roll((0, a, b * golden), k) for a, b in sign for k in range(3)])
    cube = np.array([(a, b, c) for a in (-1, 1) for b, c in sign])
    six = np.array([np.roll((0, a / golden, b * golden), k) for a, b in sign for k in range(3)])
    six = np.concatenate([cube, six[:, [1, 0, 2]]])  # corners of the dodecahedron between them
    panels = np.concatenate([five, six])
    panels /= np.linalg.norm(panels, axis=1, keepdims=True)
    unit = ball(1.0, subdivisions=4)
    near = np.sort(unit.vertices @ panels.T, axis=1)
    depth = 0.025 * np.exp(-(((near[:, -1] - near[:, -2]) / 0.02) ** 2))
    points = (unit.vertices * (1 - depth[:, None]) * r).astype(np.float32)
    dark = (unit.vertices[unit.faces].mean(1) @ panels.T).argmax(1) < 12
    thing = Thing("ball")
    for shade, faces in ((0.78, unit.faces[~dark]), (0.03, unit.faces[dark])):
        used, index = np.unique(faces, return_inverse=True)
        skin = Material((shade, shade, shade), specular=0.06, gloss=60.0)
        thing.add(Mesh(points[used], index.reshape(-1, 3).astype(np.int32)), skin)
    return stood(thing)


_MEN = {
    "pawn": [(0, 0), (0.4, 0), (0.4, 0.08), (0.2, 0.25), (0.15, 0.6), (0.25, 0.68), (0.12, 0.74),
             (0.23, 0.9), (0.2, 1.06), (0, 1.12)],
    "rook": [(0, 0), (0.45, 0), (0.45, 0.1), (0.28, 0.3), (0.24, 0.9), (0.36, 1.05), (0.36, 1.35),
             (0, 1.35)],
    "bishop": [(0, 0), (0.45, 0), (0.45, 0.1), (0.22, 0.35), (0.16, 1.0), (0.3, 1.1), (0.16, 1.18),
               (0.26, 1.4), (0.1, 1.68), (0, 1.75)],
    "queen": [(0, 0), (0.48, 0), (0.48, 0.1), (0.25, 0.4), (0.17, 1.2), (0.33, 1.35), (0.2, 1.42),
              (0.36, 1.85), (0.1, 1.9), (0, 2.0)],
    "king": [(0, 0), (0.48, 0), (0.48, 0.1), (0.26, 0.4), (0.18, 1.35), (0.35, 1.48), (0.22, 1.55),
             (0.34, 2.0), (0.06, 2.06), (0.06, 2.3), (0, 2.3)],
}  # fmt: skip
"""Outlines of the men, radius and height, in shares of a field's width."""


def chess_board(rng: np.random.Generator, style: Style) -> Thing:
    """A board of 64 fields, the men as the opening or a late game left them, m."""
    field = between(rng, 0.04, 0.055)
    side = 8 * field
    thing = Thing("chess board")
    edge = style.wood if rng.uniform() < 0.5 else style.second_wood
    thing.add(boards([(-side / 2 - 0.025, side / 2 + 0.025, -side / 2 - 0.025, side / 2 + 0.025, 0,
        0.018)], 0.003), edge)  # fmt: skip
    x, y = (field * np.arange(9) - side / 2 for _ in "xy")
    squares = [[(x[i], y[j], 0.0186), (x[i + 1], y[j], 0.0186), (x[i + 1], y[j + 1], 0.0186),
        (x[i], y[j + 1], 0.0186)] for i in range(8) for j in range(8)]  # fmt: skip
    light = Material((0.65, 0.52, 0.34), (0.55, 0.42, 0.25), "wood", 0.03, specular=0.08)
    dark = Material((0.13, 0.06, 0.03), (0.08, 0.035, 0.02), "wood", 0.03, specular=0.08)
    both = np.array(squares)
    odd = np.add.outer(np.arange(8), np.arange(8)).ravel() % 2 == 1
    thing.add(quads(both[odd]), light).add(quads(both[~odd]), dark)
    late = rng.uniform() < 0.6
    back = ["rook", "knight", "bishop", "queen", "king", "bishop", "knight", "rook"]
    for colour, home, way in ((0, 0, 1), (1, 7, -1)):
        men: list[Mesh] = []
        for i in range(8):
            for j, name in ((home, back[i]), (home + way, "pawn")):
                x_, y_ = i, j
                if late:
                    if name != "king" and rng.uniform() < 0.5:
                        continue
                    y_ = j + way * int(rng.integers(0, 3)) if name == "pawn" else j
                at = ((x_ + 0.5) * field - side / 2 + float(rng.normal(0, 0.03 * field)),
                    (y_ + 0.5) * field - side / 2 + float(rng.normal(0, 0.03 * field)),
                    0.019)  # fmt: skip
                men.append(shifted(_man(name, 0.8 * field, way), *at))
        grey = (0.8, 0.03)[colour]
        painted_ = Material((grey, grey, grey), specular=0.08)
        thing.add(joined(men), (light, dark)[colour] if rng.uniform() < 0.7 else painted_)
    return stood(thing)


def _man(name: str, size: float, way: int) -> Mesh:
    """One of the men, six- to ten-sided: there are 32."""
    if name == "knight":
        foot = turned(
            np.array([(0, 0), (0.45, 0), (0.45, 0.1), (0.26, 0.3), (0, 0.32)]) * size, 10, 6
        )
        neck = handle(np.array([(0, 0.1 * way, 0.25), (0, 0.16 * way, 0.8), (0, 0.0, 1.35),
            (0, -0.3 * way, 1.15)]) * size * [1, -1, 1], np.array([0.26, 0.24, 0.22, 0.12]) * size,
            count=6, sides=6)  # fmt: skip
        return joined([foot, neck])
    return turned(np.array(_MEN[name]) * size, 10, 9)


CATALOGUE: dict[str, Maker] = {
    "teddy_bear": teddy_bear,
    "toy_car": toy_car,
    "toy_train": toy_train,
    "building_blocks": building_blocks,
    "ball_toy": ball_toy,
    "chess_board": chess_board,
}
