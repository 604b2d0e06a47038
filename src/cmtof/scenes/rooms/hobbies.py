"""What people do at home: a rocking horse, a music stand, an easel, a sewing machine, m."""

import numpy as np

from cmtof.scenes.rooms.bicycles import bicycle, exercise_bike, wheel
from cmtof.scenes.rooms.cabinetry import (
    BLACK,
    CHROME,
    Maker,
    timber,
)
from cmtof.scenes.rooms.joinery import (
    beams,
    boards,
    centred,
    copies,
    corners,
    frame,
    placed,
    plank,
    raised,
    rods,
    rounded,
)  # fmt: skip
from cmtof.scenes.rooms.materials import Material, Style, hue
from cmtof.scenes.rooms.pianos import MUSIC, grand_piano, music_sheets, upright_piano
from cmtof.scenes.rooms.solids import ball, cushion, joined, revolve, tube
from cmtof.scenes.rooms.tables import slab, top_support
from cmtof.scenes.rooms.thing import Thing


def rocking_horse(rng: np.random.Generator, style: Style) -> Thing:
    """A wooden horse on rockers: body, legs, head, mane, saddle, handles."""
    material, mane = timber(rng, style), style.accent
    body = cushion((0.52, 0.2, 0.22), (0, 0, 0.46), square=0.75)
    feet = np.array([(s * 0.27, t * 0.12, 0.075) for s in (-1, 1) for t in (-1, 1)])
    hips = np.array([(s * 0.18, t * 0.06, 0.44) for s in (-1, 1) for t in (-1, 1)])
    legs = rods(feet, hips, 0.04, taper=0.5, sides=10)
    bow = rounded([(0.17, 0, 0.48), (0.27, 0, 0.6), (0.33, 0, 0.76)])
    neck = tube(bow, np.linspace(0.085, 0.05, len(bow)), 12)
    head = placed(cushion((0.25, 0.095, 0.115), square=0.8), (0.40, 0, 0.75), tilt=0.35)
    ears = rods([(0.33, s * 0.025, 0.78) for s in (-1, 1)], [(0.32, s * 0.035, 0.87) for s in (-1,
        1)], 0.006,
                taper=2.5)  # fmt: skip
    thing = Thing("rocking horse").add(joined([body, legs, neck, head, ears]), material)
    turn = np.linspace(-0.5, 0.5, 17)
    curve = np.stack([0.95 * np.sin(turn), 0 * turn, 0.02 + 0.95 * (1 - np.cos(turn))], -1)
    rocker = plank(curve, (0, 0.028, 0), 0.045)
    rocker.vertices[:, 2] -= rocker.vertices[:, 2].min()
    bars = beams(
        [(x, -0.14, 0.06) for x in (-0.3, 0.3)], [(x, 0.14, 0.06) for x in (-0.3, 0.3)], 0.06, 0.02
    )
    thing.add(joined([copies(rocker, [(0, -0.125, 0), (0, 0.125, 0)]), bars]), style.second_wood)
    tail = rounded([(-0.24, 0, 0.52), (-0.33, 0, 0.54), (-0.38, 0, 0.4), (-0.37, 0, 0.25)])
    crest = rounded([(0.38, 0, 0.83), (0.27, 0, 0.8), (0.2, 0, 0.66), (0.12, 0, 0.56)])
    hair = [tube(tail, np.interp(np.linspace(0, 1, len(tail)), [0, 0.5, 1], [0.02, 0.035, 0.006]),
        8),
            tube(crest, 0.024, 8)]  # fmt: skip
    thing.add(joined(hair), mane)
    seat = cushion((0.24, 0.215, 0.07), (-0.02, 0, 0.56), square=0.6)
    handle_ = rods([(0.3, -0.13, 0.7)], [(0.3, 0.13, 0.7)], 0.011)
    thing.add(seat, style.leather).add(handle_, style.second_wood)
    eyes = [ball(0.01, (0.41, s * 0.042, 0.775), 2) for s in (-1, 1)]
    thing.add(joined(eyes), BLACK)
    size = np.float32(rng.uniform(0.85, 1.1))
    for part in thing.parts:
        part.mesh.vertices[:] *= size
    return centred(thing)


def music_stand(rng: np.random.Generator, style: Style) -> Thing:
    """A tripod with a desk of sheet metal or of wires, and music on it."""
    h = float(rng.uniform(0.95, 1.25))
    turn = np.arange(3) * 2 * np.pi / 3 + np.pi / 2
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], -1)
    legs = rods(raised(0.3 * ring, 0.008), raised(0.015 * ring, 0.3), 0.008, sides=7)
    braces = rods(raised(0.16 * ring, 0.16), np.repeat([[0, 0, 0.1]], 3, 0), 0.005, sides=6)
    post = rods([(0, 0, 0.08), (0, 0, 0.5)], [(0, 0, 0.7), (0, 0, h)], 0.011)
    metal = BLACK if rng.uniform() < 0.6 else CHROME
    thing = Thing("music stand").add(joined([legs, braces, post]), metal)
    thing.parts[0].mesh.vertices[:, 2] -= thing.parts[0].mesh.vertices[:, 2].min()
    lean, y = float(rng.uniform(0.25, 0.5)), -0.015
    if rng.uniform() < 0.5:
        desk = boards(
            [(-0.25, 0.25, -0.002, 0.002, -0.08, 0.26), (-0.25, 0.25, -0.05, 0, -0.082, -0.078)], 0
        )
    else:
        bars = [((-0.24, 0, z), (0.24, 0, z)) for z in (-0.08, 0.05, 0.2)]
        bars += [((x, 0, -0.08), (0.8 * x, 0, 0.26)) for x in (-0.24, -0.08, 0.08, 0.24)]
        bars += [((-0.24, -0.04, -0.08), (0.24, -0.04, -0.08))]
        bars += [((x, 0, -0.08), (x, -0.04, -0.08)) for x in (-0.24, 0.24)]
        ends = np.array(bars)
        desk = rods(ends[:, 0], ends[:, 1], 0.004, sides=6)
    thing.add(placed(desk, (0, y, h), lean=-lean), metal)
    sheets = music_sheets(rng, 0.0, 0.0, 0.0, 0.0)
    sheets = placed(sheets, (0, -0.006, -0.076))
    return thing.add(placed(sheets, (0, y, h), lean=-lean), MUSIC)


def easel(rng: np.random.Generator, style: Style) -> Thing:
    """A painter's easel, an A with a rear leg, with a canvas on its tray."""
    h, w = float(rng.uniform(1.6, 1.95)), 0.32
    material = timber(rng, style)
    front = beams([(-w, -0.22, 0), (w, -0.22, 0)], [(-0.05, 0.1, h), (0.05, 0.1, h)], 0.04, 0.022)
    back = beams([(0, 0.5, 0)], [(0, 0.11, h - 0.04)], 0.045, 0.022)
    middle = beams([(0, -0.1, 0.45)], [(0, 0.12, h + 0.05)], 0.05, 0.02)
    lean = float(np.arctan2(0.32, h))

    def on(z: float) -> float:
        return -0.22 + 0.32 * z / h

    tray = float(rng.uniform(0.6, 0.85))
    rail = w * (1 - 0.85 * 0.35 / h)
    bars = [(-rail, rail, on(0.35) - 0.011, on(0.35) + 0.011, 0.33, 0.37)]
    bars += [(-0.33, 0.33, on(tray) - 0.065, on(tray) + 0.01, tray - 0.025, tray - 0.003)]
    thing = (
        Thing("easel").add(joined([front, back, middle]), material, 2).add(boards(bars), material)
    )
    cw, ch = float(rng.uniform(0.45, 0.8)), float(rng.uniform(0.5, min(0.9, h - tray)))
    tone = hue(float(rng.uniform()), float(rng.uniform(0.1, 0.6)), float(rng.uniform(0.3, 0.8)))
    paint = Material(
        tone, hue(float(rng.uniform()), 0.6, 0.3), "picture", float(rng.uniform(0.08, 0.3)), 0.03
    )
    canvas = boards([(-cw / 2, cw / 2, -0.03, -0.008, 0.0, ch)])
    thing.add(placed(canvas, (0, on(tray) - 0.012, tray - 0.002), lean=-lean), paint)
    frame_ = [(-cw / 2 + 0.003, cw / 2 - 0.003, -0.0085, 0.004, 0.003, 0.04)]
    thing.add(
        placed(boards(frame_), (0, on(tray) - 0.012, tray - 0.002), lean=-lean), style.second_wood
    )
    clamp = boards([(-0.03, 0.03, -0.05, 0.012, ch, ch + 0.025)])
    thing.add(placed(clamp, (0, on(tray) - 0.012, tray - 0.002), lean=-lean), material)
    return centred(thing, along="y")


def sewing_machine_table(rng: np.random.Generator, style: Style) -> Thing:
    """A machine on its table: cast-iron stand with treadle and wheel, or a plain desk."""
    w, d, h = float(rng.uniform(0.85, 1.05)), float(rng.uniform(0.42, 0.5)), 0.75
    material = style.wood
    thing = Thing("sewing table").add(slab(w, d, h, 0.025, "square"), material)
    x, y = w / 2 - 0.12, d / 2 - 0.06
    if rng.uniform() < 0.6:
        bars = []
        for s in (-1, 1):
            p = np.array(
                [(s * x, -y, 0), (s * x, y, 0), (s * x, y, h - 0.025), (s * x, -y, h - 0.025)]
            )
            q = [(0, 2), (1, 3), (3, 2), (0, 3), (1, 2)]
            bars += [(p[a], p[b]) for a, b in q]
            bars += [(p[0] * 0.5 + p[1] * 0.5 + [0, 0, 0.1], (p[2] + p[3]) / 2)]
        ends = np.array(bars)
        stand = beams(ends[:, 0], ends[:, 1], 0.016, 0.022)
        cross = beams([(-x, 0, 0.1), (-x, y, 0.4)], [(x, 0, 0.1), (x, y, 0.4)], 0.02, 0.02)
        treadle = frame((-0.2, 0.2), (-0.008, 0.008), (-0.13, 0.13), 0.02)
        grate = beams([(-0.19, 0, z) for z in np.linspace(-0.1, 0.1, 6)], [(0.19, 0, z) for z in
                      np.linspace(-0.1, 0.1, 6)], 0.008, 0.008)  # fmt: skip
        treadle = placed(joined([treadle, grate]), (0, -0.02, 0.12), lean=np.pi / 2 + 0.15)
        tyre, spokes = wheel(0.16, 8)
        thing.add(joined([stand, cross, treadle]), BLACK)
        thing.add(placed(joined([tyre, spokes]), (x - 0.05, 0.05, 0.32)), BLACK)
    else:
        place = corners(w / 2 - 0.04, d / 2 - 0.04)
        thing.add(beams(place, raised(place, h - 0.024), 0.045, 0.045, taper=0.7), material, 2)
    body = BLACK if rng.uniform() < 0.4 else Material((0.75, 0.74, 0.7), specular=0.1, gloss=80.0)
    parts = [boards([(-0.19, 0.2, -0.085, 0.085, 0.001, 0.045)], 0.008),
             boards([(0.10, 0.19, -0.05, 0.05, 0.04, 0.25)], 0.015),
             boards([(-0.17, 0.19, -0.045, 0.045, 0.2, 0.29)], 0.02),
             boards([(-0.185, -0.09, -0.05, 0.05, 0.13, 0.292)], 0.015)]  # fmt: skip
    steel = [rods([(-0.14, 0, 0.046), (-0.12, -0.02, 0.05)], [(-0.14, 0, 0.14), (-0.12, -0.02,
        0.14)], 0.004),
             placed(revolve([(0, 0), (0.055, 0), (0.06, 0.012), (0.05, 0.03), (0, 0.032)], 24),
                    (0.19, 0, 0.22), tilt=np.pi / 2),
             rods([(0.05, 0, 0.28)], [(0.05, 0, 0.34)], 0.003)]  # fmt: skip
    at = (float(rng.uniform(-0.05, 0.05)), 0.03, h)
    thing.add(placed(joined(parts), at), body).add(placed(joined(steel), at), CHROME)
    spool = revolve(
        [
            (0, 0),
            (0.016, 0),
            (0.016, 0.004),
            (0.011, 0.005),
            (0.011, 0.035),
            (0.016, 0.037),
            (0, 0.04),
        ],
        14,
    )
    thing.add(placed(spool, (at[0] + 0.05, at[1], h + 0.29)), style.accent)
    support = top_support(w, d, h, "square")
    thing.supports.append(support._replace(x1=at[0] - 0.24) if at[0] - 0.24 > support.x0 + 0.1 else
                          support._replace(x0=at[0] + 0.27))  # fmt: skip
    return thing


CATALOGUE: dict[str, Maker] = {
    "upright_piano": upright_piano,
    "grand_piano": grand_piano,
    "exercise_bike": exercise_bike,
    "bicycle": bicycle,
    "rocking_horse": rocking_horse,
    "music_stand": music_stand,
    "easel": easel,
    "sewing_machine_table": sewing_machine_table,
}
