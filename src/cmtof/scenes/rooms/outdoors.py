"""What is seen through windows: ground, a house across the street, a hedge, a balcony's rail."""

import numpy as np

from cmtof.scenes.rooms.bars import bar, bars
from cmtof.scenes.rooms.finishes import facade
from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.openings import sash
from cmtof.scenes.rooms.panels import Opening, panel, reveals
from cmtof.scenes.rooms.plan import Rect
from cmtof.scenes.rooms.solids import box, joined, quads, sheet
from cmtof.scenes.rooms.thing import Pose, Thing, moved, pose

GROUND = -0.25
"""Height of the ground outside a ground-floor room, m."""


def ground(rng: np.random.Generator, rect: Rect, level: float) -> Thing:
    """Lawn, gravel or paving around the house."""
    x0, x1, y0, y1 = (v + d for v, d in zip(rect, (-14, 14, -14, 14), strict=True))
    face = quads([[(x0, y0, level), (x1, y0, level), (x1, y1, level), (x0, y1, level)]])
    kind = int(rng.integers(3))
    materials = (
        Material((0.08, 0.16, 0.04), (0.05, 0.1, 0.03), "noise", 0.05, 0.0),
        Material((0.4, 0.37, 0.33), (0.25, 0.23, 0.2), "noise", 0.03, 0.0),
        Material((0.35, 0.34, 0.33), (0.2, 0.2, 0.19), "tiles", 0.4, 0.0),
    )
    return Thing("ground").add(face, materials[kind])


def opposite_house(rng: np.random.Generator, width: float, level: float) -> Thing:
    """A façade with windows, front towards -y, its foot at ``level``."""
    material = facade(rng)
    storey, height = 2.8, float(rng.uniform(5.0, 9.0))
    columns = max(2, int(width / float(rng.uniform(2.0, 3.2))))
    each = width / columns
    wide, tall = min(float(rng.uniform(0.8, 1.3)), each - 0.5), float(rng.uniform(1.2, 1.7))
    thing = Thing("façade")
    trim = Material((0.7, 0.7, 0.68))
    rows = max(1, int(height / storey))
    leaf = moved(sash(wide, tall, columns=2, rows=2), pose(0, 0.12, 0))
    bands, frames, holes = [], [], []
    for j in range(rows):
        z = level + storey * j
        row = [
            Opening(
                each * (k + 0.5) - wide / 2, each * (k + 0.5) + wide / 2, z + 0.9, z + 0.9 + tall
            )
            for k in range(columns)
        ]
        top = z + storey if j < rows - 1 else level + height
        bands.append(panel(row, [(0.0, top), (width, top)], bottom=z))
        for hole in row:
            holes.append(reveals(hole, 0.2))
            frames.append(moved(leaf, pose(hole.centre[0], 0, hole.z0)))
            frames.append(box((wide + 0.1, 0.12, 0.05), (hole.centre[0], -0.03, hole.z0 - 0.026)))
    back = box((width, 0.1, height), (width / 2, 0.35, level + height / 2))
    thing.add(joined([*bands, *holes]), material).add(joined(frames), trim)
    thing.add(back, Material((0.03, 0.03, 0.035), specular=0.1, gloss=200.0))
    eaves = box((width + 0.6, 0.6, 0.15), (width / 2, 0.1, level + height + 0.075))
    return thing.add(eaves, trim)


def hedge(rng: np.random.Generator, width: float, level: float) -> Thing:
    """A clipped hedge, front towards -y."""
    height, deep = float(rng.uniform(1.5, 2.4)), 0.7
    across = max(8, int(width / 0.3))
    t = np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.0, 1.0])
    y = np.array([-1, -1, -1, -1, -0.9, 0.0, 1.0]) * deep / 2
    points = np.empty((len(t), across, 3))
    points[..., 0] = np.linspace(0, width, across)
    points[..., 1] = y[:, None] + rng.normal(0, 0.05, (len(t), across))
    points[..., 2] = level + t[:, None] * height + rng.normal(0, 0.04, (len(t), across))
    green = Material((0.05, 0.12, 0.03), (0.02, 0.05, 0.015), "noise", 0.04, 0.0, bump=0.8)
    return Thing("hedge").add(sheet(points[::-1]), green)


def balcony(rng: np.random.Generator, style: Style, width: float) -> Thing:
    """A slab with a railing in front of a glazed door: x centred, away towards +y from y = 0."""
    deep, high = float(rng.uniform(0.9, 1.6)), 1.0
    thing = Thing("balcony")
    slab = box((width, deep, 0.16), (0, deep / 2, -0.1), bevel=0.005)
    thing.add(slab, Material((0.4, 0.39, 0.38), (0.3, 0.3, 0.29), "noise", 0.2))
    a, y = width / 2 - 0.05, deep - 0.05
    rails = [bar((-a, y, high), (a, y, high), 0.02, 10), bar((-a, y, 0.1), (a, y, 0.1), 0.012)]
    for x in (-a, a):
        rails.append(bar((x, 0.0, high), (x, y, high), 0.02, 10))
        rails.append(bar((x, 0.0, 0.1), (x, y, 0.1), 0.012))
    count = max(6, round(2 * a / 0.11))
    front = np.linspace(-a, a, count)
    feet = [np.stack([front, 0 * front + y, 0 * front - 0.03], 1)]
    for x in (-a, a):
        at = np.arange(0.1, y, 0.11)
        feet.append(np.stack([0 * at + x, at, 0 * at + 0.1], 1))
    foot = np.concatenate(feet)
    rails.append(bars(foot, foot * [1, 1, 0] + [0, 0, high], 0.007, 6))
    return thing.add(joined(rails), style.metal)


def beyond_side(rect: Rect, side: int, away: float, width: float) -> Pose:
    """Pose of something ``width`` m wide, from x = 0, that faces a side of the house from afar."""
    x0, x1, y0, y1 = rect
    cx, cy = (x0 + x1) / 2, (y0 + y1) / 2
    return (
        pose(cx + width / 2, y0 - away, 0, np.pi),
        pose(x1 + away, cy + width / 2, 0, -np.pi / 2),
        pose(cx - width / 2, y1 + away, 0, 0.0),
        pose(x0 - away, cy - width / 2, 0, np.pi / 2),
    )[side]
