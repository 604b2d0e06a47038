"""Sculpture and curiosities: busts, figures, masks, skulls, stones, shells, globes, m."""

import numpy as np

from cmtof.scenes.rooms import figures
from cmtof.scenes.rooms.figures import lifted
from cmtof.scenes.rooms.joinery import boards
from cmtof.scenes.rooms.materials import Material, Style, darker
from cmtof.scenes.rooms.pliant import slab, spline
from cmtof.scenes.rooms.portraits import Face, draw_face, portrait, socle, statuary
from cmtof.scenes.rooms.shaping import handle, hollow, modelled, on_wall, pick, stood, turned
from cmtof.scenes.rooms.solids import ball, blob, faceted, joined, revolve, tube
from cmtof.scenes.rooms.tableware import BRASS
from cmtof.scenes.rooms.thing import Mesh, Thing
from cmtof.scenes.rooms.vessels import Maker, between


def bust(rng: np.random.Generator, style: Style) -> Thing:
    """A portrait on a socle, a herm, a head, a faceted head or an abstract one, m."""
    kind = int(pick(rng, 0, 0, 0, 1, 1, 2, 3, 4))
    scale = between(rng, 0.11, 0.22)
    stuff = statuary(rng)
    thing = Thing("bust")
    if kind == 4:
        return _abstract(rng, thing, stuff, scale)
    face = draw_face(rng, ("rounded", "square", "neck", "rounded")[kind])
    if kind == 3:
        body = faceted(portrait(rng, face._replace(curl=0.2), scale, 26, 20))
    else:
        body = portrait(rng, face, scale)
    foot = 0.0
    if kind != 1:
        foot = scale * between(rng, 0.45, 0.7)
        base = statuary(rng) if rng.uniform() < 0.4 else stuff
        width = scale * (0.62 if kind == 2 else 0.85)
        thing.add(socle(width, foot, kind == 2 or rng.uniform() < 0.3), base)
        foot -= 0.05 * scale
    return stood(thing.add(lifted(body, 0, 0, foot), stuff))


def _abstract(rng: np.random.Generator, thing: Thing, stuff: Material, scale: float) -> Thing:
    """An egg-shaped head with a ridge for its nose, on a long neck."""
    s = scale
    egg = modelled((0.72 * s, 0.8 * s, 1.15 * s), [((0, -1, -0.9), 0.5, 0.12),
        ((0, 1, 0.5), 0.6, 0.1), ((0.5, -1, 0.1), 0.25, -0.09), ((-0.5, -1, 0.1), 0.25, -0.09),
        ((0, -1, -0.12), 0.14, 0.14), ((0, -1, 0.12), 0.14, 0.09)], (0, 0, 1.35 * s),
        subdivisions=4)  # fmt: skip
    neck = handle([(0, 0.12 * s, 0.1 * s), (0, 0.14 * s, 0.5 * s), (0, 0.02 * s, 1.0 * s)],
        [0.2 * s, 0.13 * s, 0.17 * s], count=9, sides=18)  # fmt: skip
    base = boards([(-0.35 * s, 0.35 * s, -0.28 * s, 0.42 * s, 0, 0.13 * s)], 0.003)
    return stood(thing.add(joined([egg, neck]), stuff).add(base, statuary(rng)))


def statuette(rng: np.random.Generator, style: Style) -> Thing:
    """A standing, striding or dancing figure, or a ring-shaped abstract one, on a base, m."""
    h = between(rng, 0.18, 0.4)
    stuff = statuary(rng)
    thing = Thing("statuette")
    foot = 0.08 * h
    thing.add(turned(np.array([(0, 0), (0.2, 0), (0.21, 0.03), (0.18, 0.06), (0.18, 0.083),
        (0, 0.083)]) * h, 24, 12), statuary(rng) if rng.uniform() < 0.4 else stuff)  # fmt: skip
    if rng.uniform() < 0.25:
        return stood(thing.add(_ring(rng, h, foot), stuff))
    stride, sway = between(rng, -0.06, 0.1), between(rng, -0.03, 0.03)
    hip, chest = np.array([sway, 0, 0.52]), np.array([-sway, 0, 0.76])
    limbs = []
    for side in (-1, 1):
        toe = np.array([side * 0.045, -side * stride, 0.085])
        knee = np.array([side * 0.05, -0.5 * side * stride - 0.015, 0.29])
        limbs.append(handle(np.array([toe, knee, hip + np.array([side * 0.04, 0, 0])]),
            [0.022, 0.03, 0.028, 0.045], sides=9))  # fmt: skip
        limbs.append(
            modelled((0.04, 0.1, 0.04), centre=(toe[0], toe[1] - 0.02, 0.092), subdivisions=2)
        )
        raise_ = between(rng, -0.2, 0.25) if rng.uniform() < 0.5 else -0.2
        elbow = chest + np.array([side * 0.13, between(rng, -0.06, 0.04), 0.04 + 0.6 * raise_])
        hand = elbow + np.array([side * between(rng, -0.05, 0.09), between(rng, -0.1, 0.0),
            0.8 * raise_])  # fmt: skip
        limbs.append(handle([chest + np.array([side * 0.07, 0, 0.05]), elbow, hand],
            [0.026, 0.022, 0.017], sides=8))  # fmt: skip
    trunk = spline([hip + np.array([0, 0, -0.03]), (hip + chest) / 2, chest,
        chest + np.array([0, 0, 0.075])], 10)  # fmt: skip
    body = tube(trunk, np.interp(np.linspace(0, 1, 10), [0, 0.15, 0.45, 0.75, 1],
        [0.055, 0.068, 0.05, 0.072, 0.03]), 14)  # fmt: skip
    head = modelled((0.085, 0.1, 0.125), [((0, -1, -0.1), 0.18, 0.12), ((0, 1, 0.6), 0.5, 0.12)],
        chest + np.array([0, -0.005, 0.175]), subdivisions=2)  # fmt: skip
    neck = tube([chest + np.array([0, 0, 0.05]), chest + np.array([0, 0, 0.14])], 0.022, 8)
    figure = [*limbs, body, head, neck]
    if rng.uniform() < 0.35:  # a gown
        skirt = np.array([(0.14, 0.083), (0.12, 0.2), (0.085, 0.42), (0.062, 0.55), (0.055, 0.62)])
        gown = turned(skirt, 40, 14)
        x, y, z = gown.vertices.T.astype(float)
        fold = 1 + 0.09 * np.cos(9 * np.arctan2(y, x)) * np.clip((0.6 - z) / 0.4, 0, 1)
        figure.append(
            Mesh(np.stack([x * fold + sway, y * fold, z], -1).astype(np.float32), gown.faces)
        )
    whole = joined(figure)
    return stood(thing.add(Mesh(whole.vertices * np.float32(h), whole.faces), stuff))


def _ring(rng: np.random.Generator, h: float, foot: float) -> Mesh:
    """A loop whose thickness swells around it, twisted out of its plane."""
    t = np.linspace(0, 2 * np.pi, 41)
    r = 0.36 * h
    twist = between(rng, 0.0, 0.14) * h
    path = np.stack(
        [r * np.sin(t), twist * np.sin(2 * t), foot + 1.2 * r - 1.25 * r * np.cos(t)], -1
    )
    return tube(path, 0.05 * h * (1.25 + 0.6 * np.cos(t - 2.2)), 14)


def trophy(rng: np.random.Generator, style: Style) -> Thing:
    """A cup with two ears on a block, with or without a lid, m."""
    h = between(rng, 0.18, 0.4)
    metal = BRASS if rng.uniform() < 0.6 else Material((0.6, 0.6, 0.62), specular=0.75, gloss=200.0)
    base = 0.2 * h
    block = boards([(-0.2 * h, 0.2 * h, -0.2 * h, 0.2 * h, 0, base)], 0.004)
    stone = Material(
        (0.03, 0.03, 0.03), (0.2, 0.2, 0.2), "marble", 0.08, specular=0.15, gloss=200.0
    )
    cup = np.array([(0, 0.2), (0.15, 0.2), (0.15, 0.23), (0.04, 0.28), (0.03, 0.38), (0.06, 0.42),
        (0.17, 0.52), (0.21, 0.75), (0.23, 0.95)]) * h  # fmt: skip
    body = hollow(cup, 0.004, floor=0.47 * h)
    ears = []
    for side in (-1, 1):
        path = np.array(
            [(0.19, 0, 0.6), (0.3, 0, 0.62), (0.34, 0, 0.82), (0.27, 0, 0.92), (0.22, 0, 0.86)]
        )
        ears.append(handle(path * [side * h, h, h], 0.013 * h + 0.001, sides=7))
    thing = Thing("trophy").add(block, stone if rng.uniform() < 0.6 else style.wood)
    thing.add(joined([body, *ears]), metal)
    plate = boards(
        [(-0.11 * h, 0.11 * h, -0.2 * h - 0.0015, -0.19 * h, 0.3 * base, 0.75 * base)], 0.0004
    )
    thing.add(plate, Material((0.62, 0.5, 0.25), (0.1, 0.08, 0.04), "marks", 0.006, specular=0.3))
    if rng.uniform() < 0.4:
        lid = np.array([(0, 0.955), (0.235, 0.955), (0.2, 1.0), (0.05, 1.05), (0.03, 1.08),
            (0.05, 1.13), (0, 1.17)]) * h  # fmt: skip
        thing.add(turned(lid, 24, 14), metal)
    return stood(thing)


def skull(rng: np.random.Generator, style: Style) -> Thing:
    """A skull with eye sockets, nose hole, cheek bones, teeth and jaw, m."""
    s = between(rng, 0.85, 1.1)
    bumps = [((0.33, -1, -0.28), 0.15, -0.35), ((-0.33, -1, -0.28), 0.15, -0.35),
        ((0, -1, -0.55), 0.1, -0.12), ((0.4, -1, -0.02), 0.2, 0.1), ((-0.4, -1, -0.02), 0.2, 0.1),
        ((0.7, -0.8, -0.62), 0.16, 0.14), ((-0.7, -0.8, -0.62), 0.16, 0.14),
        ((1, -0.3, -0.1), 0.3, -0.08), ((-1, -0.3, -0.1), 0.3, -0.08), ((0, -1, -0.95), 0.28, 0.1),
        ((0, 0.6, -1), 0.5, -0.2)]  # fmt: skip
    cranium = modelled((0.14, 0.185, 0.15), bumps, (0, 0.015, 0.125), subdivisions=4)
    t = np.linspace(-1.35, 1.35, 15)
    arch = np.stack([0.031 * np.sin(t), -0.04 - 0.035 * np.cos(t), np.full(15, 0.03)], -1)
    line = [(-0.058, 0.012, 0.085), (-0.054, 0.0, 0.03), (-0.035, -0.05, 0.012), (0, -0.078, 0.011),
        (0.035, -0.05, 0.012), (0.054, 0.0, 0.03), (0.058, 0.012, 0.085)]  # fmt: skip
    mandible = handle(line, [0.008, 0.011, 0.0125, 0.0135, 0.0125, 0.011, 0.008], count=25, sides=9)
    chin = modelled((0.034, 0.02, 0.024), centre=(0, -0.082, 0.013), subdivisions=1)
    teeth = [boards([(x - 0.0029, x + 0.0029, y - 0.003, y + 0.004, z, z + 0.0105)], 0) for x, y,
        _ in arch for z in (0.022, 0.0335)]  # fmt: skip
    upper = modelled((0.064, 0.068, 0.1), [((0, -1, 0.5), 0.2, -0.55), ((0, -1, -0.5), 0.4, 0.1)],
        (0, -0.037, 0.078), subdivisions=2)  # fmt: skip
    cheeks = [handle([(s * 0.025, -0.055, 0.085), (s * 0.056, -0.056, 0.084),
        (s * 0.067, -0.01, 0.096)], [0.012, 0.0095, 0.005], count=8, sides=7) for s in (-1,
        1)]  # fmt: skip
    bone = Material((0.62, 0.55, 0.4), (0.5, 0.42, 0.28), "noise", 0.03, specular=0.03)
    if rng.uniform() < 0.4:
        bone = statuary(rng)
    whole = joined([cranium, upper, mandible, chin, *cheeks, *teeth])
    return stood(Thing("skull").add(Mesh(whole.vertices * np.float32(s), whole.faces), bone))


def stone(rng: np.random.Generator, style: Style) -> Thing:
    """A pebble, a broken rock, or a small pile of pebbles, m."""
    thing = Thing("stone")
    grey = between(rng, 0.08, 0.5)
    base = (grey, 0.97 * grey, 0.9 * grey)
    stuff = Material(base, darker(base, 0.65), "noise", 0.02, specular=0.03, bump=0.3)
    size = between(rng, 0.05, 0.14)
    kind = int(rng.integers(3))
    if kind == 1:
        return stood(thing.add(faceted(blob(rng, (size, 0.8 * size, 0.7 * size), roughness=0.3,
            subdivisions=2)), stuff))  # fmt: skip
    z = 0.0
    for k in range(1 if kind == 0 else int(rng.integers(3, 6))):
        w = size * 0.82**k
        mesh = blob(
            rng, (w, 0.8 * w, 0.42 * w), roughness=0.1, waves=6, subdivisions=3 if kind == 0 else 2
        )
        x, y = rng.normal(0, 0.03 * size, 2)
        thing.add(lifted(mesh, x, y, z), stuff)
        z += float(mesh.vertices[:, 2].max()) - 0.002
    return stood(thing)


def shell(rng: np.random.Generator, style: Style) -> Thing:
    """A sea snail's coil or a scallop's fan, m."""
    thing = Thing("shell")
    base = ((0.75, 0.62, 0.5), (0.72, 0.45, 0.38), (0.8, 0.77, 0.7))[int(rng.integers(3))]
    stuff = Material(base, darker(base, 0.55), "stripes", 0.012, specular=0.1, gloss=80.0)
    if rng.uniform() < 0.5:
        turns, n = between(rng, 3.5, 4.5), 70
        t = np.linspace(0, 1, n)
        grow = np.exp(3.2 * (t - 1))
        a = 2 * np.pi * turns * t
        size = between(rng, 0.03, 0.05)
        path = np.stack([0.62 * size * grow * np.cos(a), 0.62 * size * grow * np.sin(a),
            1.9 * size * (1 - grow)], -1)  # fmt: skip
        ribs = 1 + 0.06 * np.cos(26 * a / 2 / np.pi * 4)
        coil = tube(path, 0.6 * size * grow * ribs, 12)
        return stood(thing.add(Mesh(coil.vertices[:, [2, 0, 1]], coil.faces), stuff))
    r, n, m = between(rng, 0.04, 0.075), 13, 57
    u, v = np.meshgrid(np.linspace(0.04, 1, n), np.linspace(-1.15, 1.15, m), indexing="ij")
    edge = 1 + 0.03 * np.cos(13 * v * 2.1)
    x, y = r * u * edge * np.sin(v), r * u * edge * np.cos(v)
    z = 0.34 * r * np.sqrt(np.clip(1.05 - u**2, 0, 1)) * np.cos(0.9 * v) + 0.018 * r * u * np.cos(
        13 * v * 2.1
    )
    fan = slab(np.stack([x, y, z], -1)[:, ::-1], 0.0018)
    hinge = boards([(-0.28 * r, 0.28 * r, -0.05 * r, 0.1 * r, 0.2 * r, 0.28 * r)], 0.002)
    return stood(thing.add(joined([fan, hinge]), stuff))


def globe(rng: np.random.Generator, style: Style) -> Thing:
    """A tilted globe in its half ring on a turned foot, m."""
    r = between(rng, 0.07, 0.16)
    tilt = np.radians(23.4)
    axis = np.array([np.sin(tilt), 0, np.cos(tilt)])
    middle = np.array([0, 0, 1.55 * r + 0.03])
    sea = Material(((0.05, 0.2, 0.4), (0.5, 0.4, 0.22), (0.03, 0.04, 0.06))[int(rng.integers(3))],
        (0.35, 0.3, 0.12), "picture", 1.1 * r, specular=0.1, gloss=120.0)  # fmt: skip
    body = lifted(_sphere(r), *middle)
    a = np.linspace(0, np.pi, 21)
    side = np.array([np.cos(tilt), 0, -np.sin(tilt)])
    ring = middle + 1.07 * r * (np.cos(a)[:, None] * axis + np.sin(a)[:, None] * side)
    pins = [tube([middle + s * 0.97 * r * axis, middle + s * 1.1 * r * axis], 0.035 * r,
        8) for s in (-1, 1)]  # fmt: skip
    metal = style.metal if rng.uniform() < 0.5 else BRASS
    thing = Thing("globe").add(body, sea)
    thing.add(joined([tube(ring, 0.035 * r, 8), *pins]), metal)
    # the stem comes up to meet the lowest point of the ring
    low = ring[int(np.argmin(ring[:, 2]))]
    foot = turned(np.array([(0, 0), (0.62 * r, 0), (0.64 * r, 0.08 * r), (0.3 * r, 0.16 * r),
        (0.07 * r, 0.24 * r), (0.06 * r, low[2])]), 26, 16)  # fmt: skip
    thing.add(lifted(foot, float(low[0]), 0, 0), style.wood if rng.uniform() < 0.6 else metal)
    return stood(thing)


def _sphere(radius: float) -> Mesh:
    a = np.linspace(-np.pi / 2, np.pi / 2, 25)
    return revolve(radius * np.stack([np.cos(a), np.sin(a)], -1), 44)


def mask(rng: np.random.Generator, style: Style) -> Thing:
    """A carved or painted mask that hangs on a wall, m."""
    h = between(rng, 0.12, 0.2)
    face = Face(between(rng, 0.12, 0.2), between(rng, 0.02, 0.07), between(rng, 0.03, 0.07), 0.0,
        0.3, 0.0, 0.0, 0.0, 1.0, "neck")  # fmt: skip
    head = portrait(rng, face, h, 42, 42)
    p = head.vertices.astype(float)
    top = float(p[:, 2].max())
    chin = top - h
    corners = p[head.faces]
    keep = np.flatnonzero(
        ((corners[..., 1] < 0.1 * h) & (corners[..., 2] > chin - 0.02 * h)).all(1)
    )
    faces = head.faces[keep]
    long = between(rng, 1.0, 1.4)
    used, faces = np.unique(faces, return_inverse=True)
    q = p[used] * [1, 0.9, long]
    back = q * [0.94, 1, 0.96] + [0, 0.012, 0.02 * h * long]
    index = faces.reshape(-1, 3).astype(np.int32)
    front = Mesh(q.astype(np.float32), index)
    rear = Mesh(back.astype(np.float32), index[:, ::-1].copy())
    stuff = (style.wood, style.accent, statuary(rng))[int(rng.integers(3))]
    thing = Thing("mask").add(joined([front, rear]), stuff)
    pupils = []
    for side in (-1, 1):
        pupils.append(ball(0.055 * h, (side * 0.14 * h, -0.31 * h, (chin + 0.475 * h) * long), 2))
    thing.add(joined(pupils), Material((0.01, 0.01, 0.01), specular=0.0))
    for k in range(int(pick(rng, 0, 2))):
        side = 2 * k - 1
        path = [(side * 0.2 * h, -0.05 * h, (chin + 0.9 * h) * long),
            (side * 0.4 * h, -0.1 * h, (chin + 1.15 * h) * long),
            (side * 0.32 * h, -0.15 * h, (chin + 1.4 * h) * long)]  # fmt: skip
        thing.add(handle(path, [0.08 * h, 0.06 * h, 0.012 * h], sides=9), stuff)
    return on_wall(thing)


CATALOGUE: dict[str, Maker] = {
    "bust": bust,
    "statuette": statuette,
    "trophy": trophy,
    "skull": skull,
    "stone": stone,
    "shell": shell,
    "globe": globe,
    "mask": mask,
    **figures.CATALOGUE,
}
