"""Paper: loose sheets, magazines, folders and files, m."""

import numpy as np

from cmtof.scenes.rooms.joinery import boards, copies, placed
from cmtof.scenes.rooms.materials import Material, Style, darker, hue
from cmtof.scenes.rooms.pliant import Points, ripples
from cmtof.scenes.rooms.shaping import pick, stood
from cmtof.scenes.rooms.solids import cylinder, joined, quads, sheet
from cmtof.scenes.rooms.thing import Mesh, Thing
from cmtof.scenes.rooms.vessels import Maker, between

PAPER = Material((0.8, 0.8, 0.77), (0.08, 0.08, 0.1), "marks", 0.006, specular=0.02)


STEEL = Material((0.45, 0.45, 0.46), specular=0.6, gloss=120.0)


def cover(rng: np.random.Generator) -> Material:
    """Cloth, leather or printed card, marked in a lighter or a darker ink."""
    value = pick(rng, 0.03, 0.08, 0.2, 0.45, 0.75)
    base = hue(float(rng.uniform()), between(rng, 0.0, 0.75 if value < 0.3 else 0.4), value)
    ink = (0.75, 0.7, 0.55) if value < 0.3 else darker(hue(float(rng.uniform()), 0.5, 0.1), 1.0)
    pattern = str(rng.choice(["marks", "marks", "marks", "plain", "stripes", "picture"]))
    scale = between(rng, 0.008, 0.02) if pattern == "marks" else between(rng, 0.03, 0.1)
    return Material(base, ink, pattern, scale, between(rng, 0.01, 0.1), between(rng, 15, 60))


def _curled(rng: np.random.Generator, w: float, h: float, curl: float) -> Points:
    """A sheet of paper (9, 9, 3) whose edges and corners come off the table, m."""
    u, v = np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9), indexing="ij")
    z = curl * (np.clip(np.abs(u * v), 0, 1) ** 2 + 0.3 * u**2)
    z += 0.4 * curl * ripples(rng, 0.5 * u, 0.5 * v, 4, 1.5)
    return np.stack([u * w / 2, v * h / 2, z - z.min()], -1)


def _strewn(
    rng: np.random.Generator,
    count: int,
    w: float,
    h: float,
    pitch: float,
    slide: float,
    curl: float,
) -> Points:
    """Sheets on top of each other, the upper ones curled, each a little off, (K, 9, 9, 3), m."""
    made = []
    for k in range(count):
        points = _curled(rng, w, h, curl * (0.25 + 0.75 * (k == count - 1)))
        a = float(rng.normal(0, 0.1 + 0.2 * (slide > 0.02)))
        c, s = np.cos(a), np.sin(a)
        x, y, z = np.moveaxis(points, -1, 0)
        dx, dy = rng.normal(0, slide, 2)
        made.append(np.stack([c * x - s * y + dx, s * x + c * y + dy, z + k * pitch], -1))
    return np.array(made)


def paper_sheets(rng: np.random.Generator, style: Style) -> Thing:
    """Loose sheets with writing, slightly curled, sometimes with a pencil on them, m."""
    count = int(rng.integers(2, 9))
    slide = pick(rng, 0.006, 0.03)
    stack = _strewn(rng, count, 0.21, 0.297, 0.0022, slide, between(rng, 0.003, 0.011))
    thing = Thing("paper")
    ink = hue(float(rng.uniform()), 0.6, 0.05)
    for k in range(count):
        tint = between(rng, 0.72, 0.84)
        kind = str(rng.choice(["marks", "marks", "plain", "checks"]))
        scale = between(rng, 0.005, 0.009)
        sheet_ = Material((tint, tint, 0.97 * tint), ink if kind == "marks" else (0.6, 0.66, 0.75),
            kind, scale, specular=0.02)  # fmt: skip
        thing.add(sheet(stack[k], thickness=4e-4), sheet_)
    return stood(thing)


def magazine_pile(rng: np.random.Generator, style: Style) -> Thing:
    """Magazines: thin, glossy, slid over each other, the topmost's cover coming up, m."""
    count = int(rng.integers(2, 10))
    thing, z = Thing("magazines"), 0.0
    for k in range(count):
        t = between(rng, 0.003, 0.008)
        w, h = pick(rng, 0.21, 0.2, 0.23), pick(rng, 0.28, 0.297, 0.265)
        at = (*rng.normal(0, 0.014, 2), z)
        turn = float(rng.normal(0, 0.15))
        face = Material(hue(float(rng.uniform()), between(rng, 0, 0.7), between(rng, 0.1, 0.75)),
            hue(float(rng.uniform()), 0.6, between(rng, 0.05, 0.7)),
            str(rng.choice(["picture", "marks", "picture"])), between(rng, 0.02, 0.09),
            specular=0.12, gloss=60.0)  # fmt: skip
        thing.add(
            placed(boards([(-w / 2, w / 2, -h / 2, h / 2, 0, t)], 0.0006), at, turn=turn), face
        )
        z += t + 0.0006
        if k == count - 1:
            leaf = _curled(rng, w, h, between(rng, 0.004, 0.016))
            thing.add(placed(sheet(leaf, thickness=4e-4), (at[0], at[1], z), turn=turn), face)
    return stood(thing)


def folder_row(rng: np.random.Generator, style: Style) -> Thing:
    """Lever-arch files beside each other, with labels and finger holes, some leaning, m."""
    count = int(rng.integers(2, 8))
    h, d = 0.318, 0.285
    thing, x = Thing("folders"), 0.0
    tints = [
        hue(float(rng.uniform()), pick(rng, 0, 0.7), pick(rng, 0.02, 0.3, 0.75)) for _ in range(2)
    ]
    for k in range(count):
        w = pick(rng, 0.08, 0.08, 0.05)
        lean = between(rng, 0.04, 0.16) if k == count - 1 and k and rng.uniform() < 0.5 else 0.0
        if lean:
            x += h * np.sin(lean)
        body = boards([(0, 0.003, -d / 2, d / 2, 0, h), (w - 0.003, w, -d / 2, d / 2, 0, h),
            (0.001, w - 0.001, -d / 2 - 0.002, -d / 2 + 0.001, 0.001, h - 0.001)],
            0.001)  # fmt: skip
        leaves = boards(
            [(0.004, w * between(rng, 0.4, 0.9), -d / 2 + 0.02, d / 2 - 0.03, 0.012, h - 0.016)], 0
        )
        label = boards([(0.16 * w, 0.84 * w, -d / 2 - 0.0026, -d / 2 - 0.0015, 0.12, 0.28)], 0)
        ring = placed(
            cylinder(0.0135, 0.003, sides=16), (w / 2, -d / 2 - 0.0018, 0.065), lean=np.pi / 2
        )
        hole = placed(
            cylinder(0.0105, 0.003, sides=16), (w / 2, -d / 2 - 0.0023, 0.065), lean=np.pi / 2
        )
        at = {"at": (x, between(rng, 0, 0.006), 0.0), "tilt": -lean}
        tint = tints[int(rng.integers(2))]
        card = Material(tint, darker(tint, 0.7), "noise", 0.008, specular=0.04)
        thing.add(placed(body, **at), card).add(placed(leaves, **at), PAPER)
        thing.add(placed(label, **at), PAPER, 2).add(placed(ring, **at), STEEL)
        thing.add(placed(hole, **at), Material((0.01, 0.01, 0.01), specular=0.0))
        x += w + 0.0015
    return stood(thing)


def box_file(rng: np.random.Generator, style: Style) -> Thing:
    """One to four cut-away magazine files full of issues, m."""
    count = int(rng.integers(1, 5))
    thing = Thing("magazine files")
    w, d, h, t = 0.085, 0.25, 0.31, 0.004
    tone = hue(float(rng.uniform()), pick(rng, 0, 0.5), pick(rng, 0.04, 0.4, 0.78))
    shell = style.wood if rng.uniform() < 0.25 else Material(tone, specular=0.04)
    cut = [(-d / 2, 0), (d / 2, 0), (d / 2, h), (d / 2 - 0.09, h), (-d / 2, 0.12)]
    outline = np.array(cut)
    side = np.stack([np.zeros(5), outline[:, 0], outline[:, 1]], -1)
    wall = _panel(side, t)
    for k in range(count):
        x = k * (w + 0.003)
        rest = boards([(x + t, x + w - t, d / 2 - t, d / 2, 0.001, h - 0.001),
            (x + t, x + w - t, -d / 2, -d / 2 + t, 0.001, 0.118),
            (x + t, x + w - t, -d / 2 + t, d / 2 - t, 0.001, 0.005)], 0.0008)  # fmt: skip
        thing.add(joined([copies(wall, [(x, 0, 0), (x + w - t, 0, 0)]), rest]), shell)
        n = int(rng.integers(2, 8))
        at = x + t + 0.001
        issues = []
        for _ in range(n):
            thick = between(rng, 0.004, 0.011)
            if at + thick > x + w - t:
                break
            deep = between(rng, 0.2, 0.23)
            issues.append((at, at + thick - 0.0005, d / 2 - t - deep, d / 2 - t - 0.001, 0.0055,
                between(rng, 0.25, 0.3)))  # fmt: skip
            at += thick
        for limits in issues:
            thing.add(boards([limits], 0.0006), cover(rng), 2)
    return stood(thing)


def _panel(outline: Points, thickness: float) -> Mesh:
    """A flat convex outline in the plane x = 0, counter-clockwise seen from +x, made thick."""
    n = len(outline)
    fan = np.array([(0, k, k + 1) for k in range(1, n - 1)], np.int32)
    near, far = outline, outline + np.array([thickness, 0, 0])
    nxt = np.roll(np.arange(n), -1)
    rim = quads(np.stack([near, near[nxt], far[nxt], far], 1))
    return joined(
        [Mesh(near.astype(np.float32), fan[:, ::-1].copy()), Mesh(far.astype(np.float32), fan), rim]
    )


CATALOGUE: dict[str, Maker] = {
    "paper_sheets": paper_sheets,
    "magazine_pile": magazine_pile,
    "folder_row": folder_row,
    "box_file": box_file,
}
