"""What things hang on: coat stands, clothes rails, wall shelves, screens, m."""

import numpy as np

from cmtof.scenes.rooms.cabinetry import BLACK, CHROME, Maker, timber
from cmtof.scenes.rooms.joinery import (
    beams,
    bent,
    boards,
    centred,
    copies,
    frame,
    placed,
    plank,
    raised,
    rods,
    rounded,
)  # fmt: skip
from cmtof.scenes.rooms.materials import Material, Style, fabric, leather
from cmtof.scenes.rooms.solids import ball, joined, tube
from cmtof.scenes.rooms.thing import Mesh, Support, Thing
from cmtof.scenes.rooms.upholstery import garment, shell


def coat_stand(rng: np.random.Generator, style: Style) -> Thing:
    """A post with hooks on three or four feet, and up to three coats on it."""
    height, count = float(rng.uniform(1.65, 1.9)), int(rng.integers(4, 7))
    material = style.metal if rng.uniform() < 0.4 else timber(rng, style)
    thing = Thing("coat stand")
    turn = np.arange(count) * 2 * np.pi / count
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], -1)
    pieces = [rods([(0, 0, 0.05)], [(0, 0, height)], 0.019, taper=1.2, sides=12)]
    pieces.append(ball(0.03, (0, 0, height + 0.015), 2))
    foot = rounded([(0.0, 0, 0.26), (0.1, 0, 0.2), (0.2, 0, 0.03), (0.29, 0, 0.014)])
    feet = int(rng.integers(3, 5))
    pieces += [placed(tube(foot, 0.014, 8), turn=k * 2 * np.pi / feet) for k in range(feet)]
    hook = rounded([(0.0, 0, -0.02), (0.08, 0, -0.05), (0.13, 0, 0.0), (0.14, 0, 0.06)])
    for k in range(count):
        level = height - 0.06 - 0.22 * (k % 2)
        pieces.append(placed(tube(hook, 0.008, 7), (0, 0, level), turn=float(turn[k])))
    thing.add(joined(pieces), material, 2)
    for k in rng.permutation(count)[: int(rng.integers(1, 4))]:
        level, length = height - 0.06 - 0.22 * (k % 2), float(rng.uniform(0.7, 1.15))
        coat = _hung(rng, min(length, level - 0.25))
        at = 0.115 * ring[k] + [0, 0, level + 0.03]
        cover = fabric(rng) if rng.uniform() < 0.8 else leather(rng)
        thing.add(placed(coat, at, turn=float(turn[k] + np.pi / 2)), cover, 2)
    thing.parts[0].mesh.vertices[:, 2] -= thing.parts[0].mesh.vertices[:, 2].min()
    return thing


def _hung(rng: np.random.Generator, length: float) -> Mesh:
    """A coat on a hook by its loop: it falls in from one point, with deep folds."""
    angle = np.arange(28) * (2 * np.pi / 28)
    t = np.concatenate([[0, 0.02, 0.06], np.linspace(0.12, 1, 8)])[::-1]
    wide = 0.02 + 0.15 * np.clip(t / 0.28, 0, 1) ** 0.7 + rng.uniform(0.0, 0.07) * t
    deep = 0.02 + 0.055 * np.clip(t / 0.2, 0, 1) ** 0.8 + rng.uniform(0.01, 0.05) * t
    number, phase = int(rng.integers(5, 8)), rng.uniform(0, 6)
    wave = 1 + (0.10 + 0.2 * t[:, None]) * np.sin(number * angle + phase + 1.2 * t[:, None])
    rings = np.empty((len(t), 28, 3))
    rings[..., 0] = wide[:, None] * np.cos(angle) * wave
    rings[..., 1] = deep[:, None] * np.sin(angle) * wave
    rings[..., 2] = -length * t[:, None] - 0.03 * np.abs(np.sin(1.5 * angle)) * t[:, None]
    rings[..., 1] -= 0.8 * deep[:, None] - 0.03
    ends = np.stack([rings[0].mean(0)[None].repeat(28, 0), rings[-1].mean(0)[None].repeat(28, 0)])
    body = shell(np.concatenate([ends[:1], rings[:1], rings, ends[1:]]))
    z = np.linspace(0.0, -0.58, 5)
    pieces = [body]
    for s in (-1, 1):
        x = s * np.interp(z, [-0.58, -0.15, 0], [0.13, 0.15, 0.09])
        line = np.stack([x, -0.075 - 0.03 * np.sin(np.linspace(0, 3, 5)), z - 0.17 * length], -1)
        pieces.append(tube(line, np.linspace(0.062, 0.048, 5), 8))
    return joined(pieces)


def clothes_rail(rng: np.random.Generator, style: Style) -> Thing:
    """A steel rail on feet with castors or a wooden A, with clothes on hangers."""
    w, h = float(rng.uniform(0.8, 1.3)), float(rng.uniform(1.45, 1.7))
    x = w / 2
    thing = Thing("clothes rail")
    if rng.uniform() < 0.5:
        line = [(-x, 0, 0.05), (-x, 0, h), (x, 0, h), (x, 0, 0.05)]
        feet = [rods([(s * x, -0.22, 0.05)], [(s * x, 0.22, 0.05)], 0.0125) for s in (-1, 1)]
        wheel = rods([(-0.01, 0, 0.024)], [(0.01, 0, 0.024)], 0.024, sides=12)
        pins = rods([(0, 0, 0.024)], [(0, 0, 0.06)], 0.005, sides=6)
        places = [(s * x, t * 0.21, 0) for s in (-1, 1) for t in (-1, 1)]
        thing.add(joined([tube(bent(line, 0.06), 0.0125, 10), *feet]), style.metal)
        thing.add(copies(joined([wheel, pins]), places), BLACK)
    else:
        ends = [(s * x, t * 0.24, 0.0) for s in (-1, 1) for t in (-1, 1)]
        heads = [(s * (x - 0.02), -t * 0.03, h + 0.06) for s in (-1, 1) for t in (-1, 1)]
        legs = beams(ends, heads, 0.022, 0.032)
        shelf = boards([(-x + 0.03, x - 0.03, -0.19, 0.19, 0.17, 0.188)])
        material = timber(rng, style)
        bar = rods([(-x, 0, h)], [(x, 0, h)], 0.014)
        thing.add(legs, material, 2).add(joined([shelf, bar]), material)
        thing.supports.append(Support(-x + 0.1, x - 0.1, -0.15, 0.15, 0.188, 0.25))
    count = int(rng.integers(4, 9))
    place = np.sort(rng.uniform(-x + 0.12, x - 0.12, count))
    hanger = _hanger()
    for k in range(count):
        at = (float(place[k]), 0.0, h - 0.075)
        turn = np.pi / 2 + float(rng.normal(0, 0.09))
        thing.add(placed(hanger, at, turn=turn), style.second_wood if k % 2 else CHROME)
        length = float(rng.choice([0.65, 0.75, 1.0, 1.15]))
        body = garment(rng, length, float(rng.uniform(0.4, 0.46)), 0.05)
        cover = fabric(rng) if rng.uniform() < 0.85 else leather(rng)
        thing.add(placed(body, at, turn=turn), cover, 2)
    return thing


def _hanger() -> Mesh:
    """Shoulders and a hook; the collar is at the origin."""
    bow = plank([(-0.21, 0, -0.075), (-0.1, 0, -0.02), (0, 0, 0), (0.1, 0, -0.02), (0.21, 0,
        -0.075)],
                (0, 0.012, 0), 0.018)  # fmt: skip
    turn = np.linspace(-0.5 * np.pi, 0.9 * np.pi, 6)
    hook = np.stack([0.018 * np.cos(turn), 0 * turn, 0.07 + 0.018 * np.sin(turn)], -1)
    return joined([bow, tube(np.concatenate([[[0, 0, 0]], hook]), 0.002, 5)])


def wall_shelf(rng: np.random.Generator, style: Style) -> Thing:
    """On a wall: a floating board, a board on brackets, a box, or stepped boards."""
    w, d = float(rng.uniform(0.5, 1.2)), float(rng.uniform(0.16, 0.26))
    kind, material, x = int(rng.integers(4)), timber(rng, style), w / 2
    thing = Thing("wall shelf")
    if kind == 0:
        thing.add(boards([(-x, x, -d, 0, -0.02, 0.02)], 0.003), material)
        thing.supports.append(Support(-x + 0.02, x - 0.02, -d + 0.02, -0.01, 0.02, 0.5))
    elif kind == 1:
        thing.add(boards([(-x, x, -d, 0, 0.0, 0.022)], 0.003), material)
        line = [(0, -0.005, -0.17), (0, -0.005, -0.005), (0, -0.85 * d, -0.005)]
        bracket = plank(bent(line, 0.01, steps=3), (0.022, 0, 0), 0.006)
        strut = rods([(0, -0.006, -0.14)], [(0, -0.7 * d, -0.006)], 0.005)
        places = [(-x + 0.12, 0, 0), (x - 0.12, 0, 0)]
        thing.add(copies(joined([bracket, strut]), places), style.metal)
        thing.supports.append(Support(-x + 0.02, x - 0.02, -d + 0.02, -0.01, 0.022, 0.5))
    elif kind == 2:
        h, t = float(rng.uniform(0.24, 0.34)), 0.018
        thing.add(frame((-x, x), (-d, 0), (-h / 2, h / 2), t), material)
        split = float(rng.uniform(-0.15, 0.15)) * w
        wall = (split - 0.008, split + 0.008, -d + 0.002, -0.001, -h / 2 + t, h / 2 - t)
        thing.add(boards([wall], 0), material, 2)
        thing.supports.append(Support(-x + 0.03, x - 0.03, -d + 0.02, -0.02, h / 2, 0.4))
        low, free = -h / 2 + t, h - 2 * t
        thing.supports += [Support(a, b, -d + 0.02, -0.02, low, free)
                           for a, b in ((-x + 0.03, split - 0.02), (split + 0.02,
                               x - 0.03))]  # fmt: skip
    else:
        levels, shift = np.array([-0.3, 0.0, 0.3]), rng.uniform(-0.1, 0.1, 3) * w
        rows = [(-0.4 * w + s, 0.4 * w + s, -d, 0, z - 0.011, z + 0.011)
                for z, s in zip(levels, shift, strict=True)]  # fmt: skip
        thing.add(boards(rows, 0.003), material)
        posts = [(-0.22 * w, -0.02, -0.42), (0.22 * w, -0.02, -0.42)]
        thing.add(beams(posts, raised(posts, 0.86), 0.02, 0.012), style.metal)
        thing.supports += [Support(-0.38 * w + s, 0.38 * w + s, -d + 0.02, -0.03,
            float(z) + 0.011, 0.26)
                           for z, s in zip(levels, shift, strict=True)]  # fmt: skip
    return thing


def room_divider(rng: np.random.Generator, style: Style) -> Thing:
    """A folding screen of three or four leaves: paper, cane or louvres in frames."""
    count, wide = int(rng.integers(3, 5)), float(rng.uniform(0.4, 0.5))
    high, fold = float(rng.uniform(1.55, 1.85)), float(rng.uniform(0.3, 0.6))
    material, kind = timber(rng, style), int(rng.integers(3))
    leaf = frame((0, wide), (-0.011, 0.011), (0.02, high), 0.035)
    legs = boards([(a, a + 0.034, -0.0105, 0.0105, 0, 0.03) for a in (0.0005, wide - 0.0345)])
    inner, fill = (0.034, wide - 0.034), []
    if kind == 2:
        z = np.arange(0.07, high - 0.05, 0.042)
        ends = np.stack([np.full_like(z, inner[0]), 0 * z, z], -1)
        lath = plank([(inner[0], 0, 0), (inner[1], 0, 0)], (0, 0.026, 0.032), 0.005)
        fill = copies(lath, ends * [0, 1, 1])
    else:
        fill = boards([(*inner, -0.002, 0.002, 0.054, high - 0.034)], 0)
        bars = [(wide / 2 - 0.006, wide / 2 + 0.006, -0.008, 0.008, 0.05, high - 0.03)]
        bars += [
            (*inner, -0.007, 0.007, q - 0.006, q + 0.006) for q in np.linspace(0.05, high, 6)[1:-1]
        ]
        if kind == 0:
            leaf = joined([leaf, boards(bars)])
    paper = Material((0.78, 0.75, 0.68), (0.7, 0.66, 0.58), "noise", 0.05, 0.0)
    cover = material if kind == 2 else (paper if kind == 0 else style.second_fabric)
    frames, fills, at, turn = [], [], np.zeros(3), fold / 2
    for k in range(count):
        angle = turn if k % 2 == 0 else -turn
        frames.append(placed(joined([leaf, legs]), at, turn=angle))
        fills.append(placed(fill, at, turn=angle))
        at = at + (wide + 0.004) * np.array([np.cos(angle), np.sin(angle), 0])
    thing = Thing("room divider").add(joined(frames), material, 2).add(joined(fills), cover)
    return centred(thing)


CATALOGUE: dict[str, Maker] = {
    "coat_stand": coat_stand,
    "clothes_rail": clothes_rail,
    "wall_shelf": wall_shelf,
    "room_divider": room_divider,
}
