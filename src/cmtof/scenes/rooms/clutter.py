"""What stands about: tools, parcels, frames, umbrellas, toys, belongings, m."""

import numpy as np

from cmtof.scenes.rooms import belongings, containers, toys
from cmtof.scenes.rooms.cabinetry import BLACK, CHROME, STEEL
from cmtof.scenes.rooms.containers import crate, plastic
from cmtof.scenes.rooms.joinery import bent, boards, frame, placed, rods
from cmtof.scenes.rooms.materials import Material, Style, hue
from cmtof.scenes.rooms.pliant import spline
from cmtof.scenes.rooms.shaping import handle, hollow, modelled, pick, pipe, stood, turned
from cmtof.scenes.rooms.solids import (
    blob,
    faceted,
    joined,
    rod,
    sheet,
    tube,
)
from cmtof.scenes.rooms.thing import Mesh, Thing
from cmtof.scenes.rooms.vessels import Maker, between, ware


def crumpled_paper(rng: np.random.Generator, style: Style) -> Thing:
    """A ball of crumpled paper, sharp in its folds, m."""
    size = between(rng, 0.05, 0.09)
    mesh = blob(rng, (size, size, 0.9 * size), roughness=0.3, waves=50, subdivisions=3)
    jolt = 1 + 0.05 * rng.normal(size=(len(mesh.vertices), 1))
    points = mesh.vertices * jolt
    points[:, 2] -= points[:, 2].min()
    tint = Material((0.78, 0.77, 0.72), (0.1, 0.1, 0.12), str(rng.choice(["plain", "marks"])),
        0.008, specular=0.0)  # fmt: skip
    return stood(
        Thing("crumpled paper").add(faceted(Mesh(points.astype(np.float32), mesh.faces)), tint)
    )


def broom(rng: np.random.Generator, style: Style) -> Thing:
    """A broom that stands upright on its bristles, m."""
    h, w = between(rng, 1.25, 1.45), between(rng, 0.28, 0.38)
    thing = Thing("broom")
    thing.add(boards([(-w / 2, w / 2, -0.025, 0.025, 0.07, 0.1)], 0.008), toys.WOODEN)
    x, y = np.meshgrid(np.linspace(-w / 2 + 0.01, w / 2 - 0.01, 18), [-0.016, 0, 0.016])
    tops = np.stack([x.ravel(), y.ravel(), np.full(x.size, 0.072)], -1)
    spread = rng.normal(0, 0.004, (len(tops), 2))
    feet = tops * [1.06, 1.7, 0] + np.column_stack([spread, np.zeros(len(tops))])
    thing.add(rods(feet, tops, 0.005, taper=1.5, sides=5), plastic(rng))
    socket = turned([(0, 0.09), (0.021, 0.09), (0.02, 0.13), (0.016, 0.16), (0, 0.16)], 14, 8)
    thing.add(joined([socket, rods([(0, 0, 0.1)], [(0, 0, h)], 0.0125, sides=12)]), toys.WOODEN, 2)
    return stood(thing)


def toolbox(rng: np.random.Generator, style: Style) -> Thing:
    """A tool box with lid, catches and handle, or an open tray of hand tools, m."""
    w, d, h = between(rng, 0.34, 0.5), between(rng, 0.18, 0.23), between(rng, 0.13, 0.19)
    paint_ = Material(
        hue(pick(rng, 0.0, 0.04, 0.6, 0.15), 0.85, between(rng, 0.1, 0.5)), specular=0.12
    )
    thing = Thing("toolbox")
    if rng.uniform() < 0.6:
        thing.add(boards([(-w / 2, w / 2, -d / 2, d / 2, 0, h)], 0.006), paint_)
        thing.add(boards([(-w / 2 - 0.003, w / 2 + 0.003, -d / 2 - 0.003, d / 2 + 0.003, h + 0.0015,
            h + 0.04)], 0.01), paint_ if rng.uniform() < 0.4 else BLACK)  # fmt: skip
        catches = [(x - 0.015, x + 0.015, -d / 2 - 0.008, -d / 2 + 0.002, h - 0.035,
            h + 0.018) for x in (-0.3 * w, 0.3 * w)]  # fmt: skip
        thing.add(boards(catches, 0.002), STEEL)
        path = bent([(-0.07, 0, h + 0.035), (-0.07, 0, h + 0.075), (0.07, 0, h + 0.075),
            (0.07, 0, h + 0.035)], 0.02)  # fmt: skip
        return stood(thing.add(tube(path, 0.008, 8), BLACK))
    thing.add(crate(w, d, 0.6 * h, 0.008), style.wood if rng.uniform() < 0.6 else paint_)
    ends = [(s * (w / 2 - 0.004) - 0.004, s * (w / 2 - 0.004) + 0.004, -0.035, 0.035,
        0.6 * h - 0.001, h + 0.06) for s in (-1, 1)]  # fmt: skip
    thing.add(joined([boards(ends, 0.002), rod((-w / 2, 0, h + 0.045), (w / 2, 0, h + 0.045), 0.011,
        10)]), style.wood)  # fmt: skip
    x = np.linspace(-0.35 * w, 0.3 * w, 4)
    for k, a in enumerate(x):
        y = (-0.25, 0.2, -0.2, 0.25)[k] * d
        tall = between(rng, 0.09, 0.13)
        grip = turned(
            [(0, 0), (0.011, 0), (0.014, 0.03), (0.011, 0.075), (0.013, 0.095), (0, 0.1)], 12, 12
        )
        thing.add(placed(grip, (a, y, tall), tilt=between(rng, -0.2, 0.2)), plastic(rng))
        thing.add(rods([(a, y, 0.01)], [(a, y, tall + 0.01)], 0.004, sides=6), STEEL)
    hammer = [rods([(0.12 * w, 0.05, 0.02)], [(0.36 * w, 0.03, h + 0.06)], 0.012),
        rods([(0.36 * w - 0.06, 0.03, h + 0.05)], [(0.36 * w + 0.055, 0.03, h + 0.08)],
        0.014)]  # fmt: skip
    thing.add(hammer[0], toys.WOODEN).add(hammer[1], STEEL)
    return stood(thing)


def gift_box(rng: np.random.Generator, style: Style) -> Thing:
    """A wrapped parcel with crossing ribbons and a bow, m."""
    w, d, h = between(rng, 0.1, 0.32), between(rng, 0.1, 0.26), between(rng, 0.05, 0.2)
    tone = hue(float(rng.uniform()), between(rng, 0.2, 0.8), between(rng, 0.1, 0.7))
    pattern = str(rng.choice(["dots", "stripes", "checks", "plain"]))
    wrap = Material(tone, hue(float(rng.uniform()), 0.4, 0.75), pattern, between(rng, 0.015, 0.05),
        specular=0.12)  # fmt: skip
    ribbon = Material(
        hue(float(rng.uniform()), 0.8, between(rng, 0.1, 0.6)), specular=0.2, gloss=80.0
    )
    thing = Thing("parcel").add(boards([(-w / 2, w / 2, -d / 2, d / 2, 0, h)], 0.0015), wrap)
    t, b = 0.0009, 0.012
    bands = [(-b, b, -d / 2 - t, d / 2 + t, 0.0004, h + t), (-w / 2 - t, w / 2 + t, -b, b, 0.0003,
        h + 1.4 * t)]  # fmt: skip
    thing.add(boards(bands, 0), ribbon)
    loops = []
    for k, a in enumerate(np.arange(4) * np.pi / 2 + between(rng, 0, 1)):
        r = (0.045, 0.04)[k % 2]
        s = np.linspace(0, 1, 13)
        path = np.stack([r * np.sin(np.pi * s), 0 * s, h + 0.004 + 0.03 * np.sin(2 * np.pi * s) * (s
            < 0.5) + 0.012 * np.sin(np.pi * s)], -1)  # fmt: skip
        across = np.array([0, b * 0.8, 0])
        band = np.stack([path - across, path + across], 1)
        loops.append(placed(sheet(band, thickness=5e-4), turn=float(a)))
    return thing.add(joined([*loops, modelled((0.02, 0.02, 0.014), centre=(0, 0, h + 0.007),
        subdivisions=2)]), ribbon)  # fmt: skip


def watering_can(rng: np.random.Generator, style: Style) -> Thing:
    """A can with a long spout, rose or plain, and one or two handles, m."""
    r, h = between(rng, 0.07, 0.11), between(rng, 0.14, 0.22)
    stuff = STEEL if rng.uniform() < 0.4 else plastic(rng)
    body = hollow([(0, 0), (0.9 * r, 0), (r, 0.01), (r, 0.75 * h), (0.85 * r, 0.95 * h),
        (0.6 * r, h)], 0.003, sides=28)  # fmt: skip
    reach = between(rng, 1.4, 2.2) * r
    end = np.array([-r - reach, 0, 1.15 * h])
    path = spline(np.array([(-0.9 * r, 0, 0.18 * h), (-r - 0.4 * reach, 0, 0.5 * h), end]), 9)
    spout = pipe(path, np.linspace(0.02, 0.01, 9), 0.002)
    grip = handle([(0.2 * r, 0, 0.98 * h), (0.6 * r, 0, 1.35 * h), (1.5 * r, 0, 1.1 * h),
        (1.5 * r, 0, 0.5 * h), (0.95 * r, 0, 0.25 * h)], 0.0075, count=14)  # fmt: skip
    thing = Thing("watering can").add(joined([body, spout, grip]), stuff)
    if rng.uniform() < 0.5:
        rose = turned([(0, 0), (0.011, 0), (0.03, 0.03), (0.03, 0.034), (0, 0.038)], 18, 10)
        thing.add(placed(rose, tuple(end - [0.002, 0, 0.002]), tilt=-0.9), stuff)
    return stood(thing)


def picture_frame(rng: np.random.Generator, style: Style) -> Thing:
    """A framed photograph that leans back on its strut, m."""
    w, h = between(rng, 0.1, 0.22), between(rng, 0.13, 0.26)
    bar = between(rng, 0.01, 0.028)
    stuff = (style.wood, style.metal, style.accent, BLACK)[int(rng.integers(4))]
    thing = Thing("picture frame")
    lean = between(rng, 0.15, 0.3)
    edge = frame((-w / 2, w / 2), (-0.016, 0), (0, h), bar, 0.003)
    back = boards([(-w / 2 + bar - 0.003, w / 2 - bar + 0.003, -0.007, -0.002, bar - 0.003,
        h - bar + 0.003)], 0)  # fmt: skip
    photo = Material(hue(float(rng.uniform()), between(rng, 0, 0.6), between(rng, 0.2, 0.7)),
        hue(float(rng.uniform()), 0.4, 0.1), "picture", between(rng, 0.03, 0.1), specular=0.12,
        gloss=400.0)  # fmt: skip
    pivot = 0.7 * h
    thing.add(placed(edge, lean=-lean), stuff).add(placed(back, lean=-lean), photo)
    top = np.array([0, pivot * np.sin(lean) - 0.001, pivot * np.cos(lean)])
    strut = placed(boards([(-0.02, 0.02, 0, 0.003, -pivot * 1.0, 0)], 0), tuple(top),
        lean=between(rng, 0.25, 0.4))  # fmt: skip
    strut.vertices[:, 2] = np.maximum(strut.vertices[:, 2], 0.0)
    return stood(thing.add(strut, BLACK))


def umbrella_stand(rng: np.random.Generator, style: Style) -> Thing:
    """A stand with two or three furled umbrellas or sticks, m."""
    r, h = between(rng, 0.1, 0.14), between(rng, 0.42, 0.55)
    thing = Thing("umbrella stand")
    if rng.uniform() < 0.5:
        stuff = ware(rng, style)
        thing.add(hollow([(0, 0), (0.9 * r, 0), (r, 0.015), (0.94 * r, 0.5 * h), (r, h)], 0.006,
            sides=30), stuff)  # fmt: skip
    else:
        t = np.linspace(0, 2 * np.pi, 29)
        rings = [tube(np.stack([r * np.cos(t), r * np.sin(t), 0 * t + z], -1), 0.006, 6,
            capped=False) for z in (0.02, 0.5 * h, h)]  # fmt: skip
        a = np.arange(10) * 2 * np.pi / 10
        feet = np.stack([r * np.cos(a), r * np.sin(a), 0 * a + 0.01], -1)
        tray_ = turned(
            [(0, 0), (0.98 * r, 0), (r, 0.004), (r, 0.02), (0.96 * r, 0.006), (0, 0.006)], 28, 12
        )
        thing.add(joined([*rings, rods(feet, feet + np.array([0, 0, h - 0.01]), 0.004, sides=6),
            tray_]), style.metal)  # fmt: skip
    for k in range(int(rng.integers(1, 4))):
        a = 2.1 * k + between(rng, 0, 1)
        low = np.array([-0.45 * r * np.cos(a), -0.45 * r * np.sin(a), 0.012])
        top = np.array([0.7 * r * np.cos(a), 0.7 * r * np.sin(a), h])
        way = (top - low) / np.linalg.norm(top - low)
        long = between(rng, 0.78, 0.9)
        s = np.linspace(0, 0.8, 12)
        folds = np.interp(s, [0, 0.08, 0.3, 0.7, 0.8], [0.006, 0.012, 0.024, 0.028, 0.014])
        cloth = tube(low + long * s[:, None] * way, folds, 9)
        stick = rod(low - 0.01 * way, low + long * way, 0.005, 7)
        side = np.array([np.cos(a + 1), np.sin(a + 1), 0])
        end = low + long * way
        crook = handle([end - 0.02 * way, end + 0.03 * way + 0.005 * side,
            end + 0.05 * way + 0.045 * side, end + 0.01 * way + 0.075 * side], 0.009,
            count=10)  # fmt: skip
        thing.add(cloth, Material(hue(float(rng.uniform()), 0.6, pick(rng, 0.02, 0.02, 0.3)),
            specular=0.03))  # fmt: skip
        thing.add(stick, CHROME).add(crook, style.wood if rng.uniform() < 0.6 else BLACK)
    return stood(thing)


CATALOGUE: dict[str, Maker] = {
    "crumpled_paper": crumpled_paper,
    "broom": broom,
    "toolbox": toolbox,
    "gift_box": gift_box,
    "watering_can": watering_can,
    "picture_frame": picture_frame,
    "umbrella_stand": umbrella_stand,
    **containers.CATALOGUE,
    **toys.CATALOGUE,
    **belongings.CATALOGUE,
}
