"""Books and paper: lying, stacked, in rows, open; magazines, sheets, folders, m."""

import numpy as np

from cmtof.scenes.rooms.joinery import boards, copies, placed
from cmtof.scenes.rooms.materials import Material, Style, darker, hue
from cmtof.scenes.rooms.pliant import Points, ripples
from cmtof.scenes.rooms.shaping import pick, stood
from cmtof.scenes.rooms.solids import cylinder, joined, quads, sheet
from cmtof.scenes.rooms.thing import Mesh, Thing
from cmtof.scenes.rooms.vessels import Maker, between

PAGES = Material((0.72, 0.68, 0.56), (0.6, 0.56, 0.45), "stripes", 0.0012, specular=0.0)
PAPER = Material((0.8, 0.8, 0.77), (0.08, 0.08, 0.1), "marks", 0.006, specular=0.02)
STEEL = Material((0.45, 0.45, 0.46), specular=0.6, gloss=120.0)

# corner number of the eight that `_bound` makes, for each quadrilateral of one upright book:
# outsides, spine with its two bevels, the boards' tops, fore edges, feet
_COVER = (
    (0, 1, 9, 8), (1, 2, 10, 9), (2, 3, 11, 10), (3, 4, 12, 11), (4, 5, 13, 12), (5, 6, 14, 13),
    (6, 7, 15, 14), (7, 0, 8, 15),
)  # fmt: skip


def cover(rng: np.random.Generator) -> Material:
    """Cloth, leather or printed card, marked in a lighter or a darker ink."""
    value = pick(rng, 0.03, 0.08, 0.2, 0.45, 0.75)
    base = hue(float(rng.uniform()), between(rng, 0.0, 0.75), value)
    ink = (0.75, 0.7, 0.55) if value < 0.3 else darker(hue(float(rng.uniform()), 0.5, 0.1), 1.0)
    pattern = str(rng.choice(["marks", "marks", "marks", "plain", "stripes", "picture"]))
    scale = between(rng, 0.008, 0.02) if pattern == "marks" else between(rng, 0.03, 0.1)
    return Material(base, ink, pattern, scale, between(rng, 0.01, 0.1), between(rng, 15, 60))


def _bound(width: Points, depth: Points, height: Points) -> tuple[Points, Points]:
    """Quadrilaterals of many upright books, (K, Q, 4, 3), m: covers, and blocks of pages.

    Spines look towards -y; a book covers x from 0 to its width and y from 0 to its depth.
    """
    t = np.minimum(0.0025, 0.2 * width)
    zero, bevel = 0 * width, np.minimum(0.3 * width, 0.005)
    # the outline as a U: outside around the spine, inside back along the boards
    xs = [zero, zero, bevel, width - bevel, width, width, width - t, t]
    ys = [depth, bevel, zero, zero, bevel, depth, depth, depth]
    ring = np.stack([np.stack(xs, -1), np.stack(ys, -1)], -1)
    low = np.concatenate([ring, np.zeros((*ring.shape[:2], 1))], -1)
    high = np.concatenate([ring, np.broadcast_to(height[:, None, None], (*ring.shape[:2], 1))], -1)
    corners = np.concatenate([low, high], 1)
    covers = corners[:, np.array(_COVER[:5])]
    z = height
    down = 0.004

    def face(*points: tuple[Points, Points, Points]) -> Points:
        return np.stack([np.stack(np.broadcast_arrays(*p), -1) for p in points], 1)

    u, v, e = t, width - t, zero + 0.004
    tops = [
        face((zero, bevel, z), (u, e, z), (u, depth, z), (zero, depth, z)),
        face((v, e, z), (width, bevel, z), (width, depth, z), (v, depth, z)),
        face((zero, bevel, z), (bevel, zero, z), (width - bevel, zero, z), (width, bevel, z)),
        face((zero, bevel, z), (width, bevel, z), (v, e + bevel, z), (u, e + bevel, z)),
        face((zero, depth, zero), (zero, depth, z), (u, depth, z), (u, depth, zero)),
        face((v, depth, zero), (v, depth, z), (width, depth, z), (width, depth, zero)),
        face((zero, depth, zero), (width, depth, zero), (width, bevel, zero), (zero, bevel, zero)),
    ]
    inner = [
        face((u, e, z), (u, depth, z), (u, depth, z - down), (u, e, z - down)),
        face((v, depth, z), (v, e, z), (v, e, z - down), (v, depth, z - down)),
        face((v, e, z), (u, e, z), (u, e, z - down), (v, e, z - down)),
    ]
    pages = [
        face((u, e, z - down), (v, e, z - down), (v, depth - down, z - down), (u, depth - down, z - down)),
        face((u, depth - down, zero), (u, depth - down, z - down), (v, depth - down, z - down),
             (v, depth - down, zero)),
    ]  # fmt: skip
    tops = [tops[0], tops[1], tops[2], *tops[4:]]
    return np.concatenate([covers, np.stack(tops + [q[:, ::-1] for q in inner], 1)], 1), np.stack(
        pages, 1
    )


def _turned(faces: Points, angle: Points, at: Points) -> Points:
    """Books (K, ..., 3) each leaning about y through x = 0 and shifted, m."""
    shape = (-1,) + (1,) * (faces.ndim - 2)
    c, s = np.cos(angle).reshape(shape), np.sin(angle).reshape(shape)
    x, y, z = np.moveaxis(faces, -1, 0)
    out = np.stack([c * x + s * z, y, c * z - s * x], -1)
    return out + at.reshape(-1, *shape[1:], 3)


def book_row(
    rng: np.random.Generator,
    style: Style,
    *,
    length: float | None = None,
    height: float | None = None,
    depth: float | None = None,
) -> Thing:
    """Upright books of different height, thickness and colour, some leaning, with gaps.

    Parameters
    ----------
    length : float, optional
        Of the row along x, m; never exceeded.
    height, depth : float, optional
        Of the largest book, m.
    """
    long = between(rng, 0.25, 0.9) if length is None else length
    tall = between(rng, 0.2, 0.3) if height is None else height
    deep = between(rng, 0.15, 0.22) if depth is None else depth
    n = 40
    common = between(rng, 0.0, 0.75)  # how alike the books are: collected works or flea market
    h = tall * (1 - rng.uniform(0, 0.38, n) * (1 - common))
    d = np.clip(h * rng.uniform(0.62, 0.78, n), 0.5 * deep, deep)
    w = rng.gamma(3.2, 0.009, n).clip(0.007, 0.06)
    w[1 : int(n * common)] = np.where(rng.uniform(size=int(n * common) - 1 if n * common > 1 else 0) < 0.5,
                                      w[0], w[1 : int(n * common)])  # fmt: skip
    angle, start, used = _arranged(rng, w, h, long)
    if used == 0:
        w[0], angle, start, used = min(w[0], 0.8 * long), np.zeros(n), np.zeros(n), 1
    y = -0.5 * deep + rng.uniform(0, 0.02, n) * rng.uniform()
    at = np.stack([start, np.minimum(y, 0.5 * deep - d), 0 * w], -1)[:used]
    covers, pages = _bound(w[:used], d[:used], h[:used])
    covers, pages = (_turned(f, angle[:used], at) for f in (covers, pages))
    thing = Thing("books")
    palette = [cover(rng) for _ in range(int(rng.integers(6, 12)))]
    of = rng.integers(0, len(palette), used)
    if rng.uniform() < 0.4:  # runs of one edition
        of = np.repeat(of, rng.integers(1, 6, used))[:used]
    for k, material in enumerate(palette):
        mine = np.flatnonzero(of == k)
        if len(mine):
            thing.add(quads(covers[mine].reshape(-1, 4, 3)), material, 2)
    thing.add(quads(pages.reshape(-1, 4, 3)), PAGES, 1)
    return stood(thing)


def _arranged(
    rng: np.random.Generator, w: Points, h: Points, long: float
) -> tuple[Points, Points, int]:
    """Angle and left foot of each book, and how many fit: upright, or leaning to the left."""
    angle, start = np.zeros(len(w)), np.zeros(len(w))
    x, free = 0.0, float(rng.uniform())
    for k in range(len(w)):
        lean, gap = 0.0, float(rng.uniform(0.0, 0.0015))
        if k and rng.uniform() < 0.12 and angle[k - 1] == 0:
            lean = float(rng.uniform(0.08, 0.3))
        elif k and angle[k - 1] < 0 and rng.uniform() < 0.6:
            lean = -float(angle[k - 1])
        elif rng.uniform() < 0.03 * free:
            gap = float(rng.uniform(0.03, 0.12))
        if lean and angle[k - 1] == 0:  # its upper left edge touches the book beside it
            low = min(float(h[k]), float(h[k - 1]) / np.cos(lean))
            gap += low * np.sin(lean) + 5e-4
        elif lean:
            gap += float(w[k - 1]) * (1 / np.cos(lean) - 1)
        end = x + gap + float(w[k]) * (1 / np.cos(lean) if lean else 1.0) + 0.001
        if end > long - 0.002:
            return angle, start, k
        start[k], angle[k] = x + gap, -lean
        x = end
    return angle, start, len(w)


def _one(w: float, d: float, h: float) -> tuple[Mesh, Mesh]:
    """Cover and pages of one upright book."""
    covers, pages = _bound(np.array([w]), np.array([d]), np.array([h]))
    return quads(covers.reshape(-1, 4, 3)), quads(pages.reshape(-1, 4, 3))


def _lying(thing: Thing, rng: np.random.Generator, h: float, w: float, z: float) -> float:
    """Add a closed book that lies on its side, rounded spine included; returns its top, m."""
    d = h * between(rng, 0.64, 0.8)
    t = 0.003
    turn = float(rng.normal(0, 0.12)) + (np.pi if rng.uniform() < 0.4 else 0.0)
    at = (*rng.normal(0, 0.006, 2), z)
    boards_ = boards(
        [(-d / 2, d / 2, -h / 2, h / 2, 0, t), (-d / 2, d / 2, -h / 2, h / 2, w - t, w)], 0.001
    )
    bulge = np.linspace(-np.pi / 2, np.pi / 2, 7)
    arc = np.stack(
        [-d / 2 - 0.12 * w * np.cos(bulge), w / 2 + (w / 2 - 0.0004) * np.sin(bulge)], -1
    )
    ends = np.array([-h / 2, h / 2])
    spine = np.empty((7, 2, 3))
    spine[..., 0], spine[..., 1], spine[..., 2] = arc[:, :1], ends, arc[:, 1:]
    block = boards(
        [
            (
                -d / 2 + 0.001,
                d / 2 - 0.004,
                -h / 2 + 0.004,
                h / 2 - 0.004,
                t - 0.0005,
                w - t + 0.0005,
            )
        ],
        0,
    )
    back = sheet(spine, thickness=0.0012)
    material = cover(rng)
    thing.add(placed(joined([boards_, back]), at, turn=turn), material, 1)
    thing.add(placed(block, at, turn=turn), PAGES, 2)
    return z + w


def book(rng: np.random.Generator, style: Style) -> Thing:
    """A closed book that lies there, m."""
    thing = Thing("book")
    _lying(thing, rng, between(rng, 0.17, 0.31), between(rng, 0.012, 0.05), 0.0)
    return stood(thing)


def book_stack(rng: np.random.Generator, style: Style, *, count: int | None = None) -> Thing:
    """Books upon each other, mostly the larger ones below, slightly turned.

    Parameters
    ----------
    count : int, optional
        2 to 9 by default.
    """
    n = int(rng.integers(2, 10)) if count is None else count
    sizes = np.sort(rng.uniform(0.16, 0.3, n))[::-1] * rng.uniform(0.92, 1.05, n)
    thing, z = Thing("books"), 0.0
    for size in sizes:
        z = _lying(thing, rng, float(size), between(rng, 0.012, 0.045), z) + 0.0006
    return stood(thing)


def open_book(rng: np.random.Generator, style: Style) -> Thing:
    """An open book: two swelling halves of pages over their boards, a leaf lifted, m."""
    h, d = between(rng, 0.2, 0.29), between(rng, 0.14, 0.2)
    t = between(rng, 0.01, 0.022)
    share = between(rng, 0.3, 0.7)
    thing = Thing("open book")
    s = np.linspace(0, 1, 14)
    y = np.array([-h / 2, h / 2])
    for side in (-1, 1):
        full = t * 2 * (share if side < 0 else 1 - share)
        x = side * d * s
        z = 0.004 + full * (np.clip(s / 0.18, 0, 1) ** 0.5) * (1 - 0.25 * s**2) * (s > 0)
        top = np.empty((14, 2, 3))
        top[..., 0], top[..., 1], top[..., 2] = x[:, None], y, z[:, None]
        top = top if side > 0 else top[::-1]
        thing.add(sheet(top), PAPER, 0)
        low = np.array([1, 1, 0]) * top + [0, 0, 0.0032]
        for k, way in ((0, 1), (1, -1)):
            strip = np.stack([low[:, k], top[:, k]], 1)[:, ::way]
            thing.add(sheet(strip), PAGES, 0)
        edge = np.stack([low[-1 if side > 0 else 0], top[-1 if side > 0 else 0]], 1)
        thing.add(sheet(edge[:, ::side] if side > 0 else edge[:, ::side]), PAGES, 1)
    board = boards([(-d - 0.004, -0.004, -h / 2 - 0.004, h / 2 + 0.004, 0, 0.003),
                    (0.004, d + 0.004, -h / 2 - 0.004, h / 2 + 0.004, 0, 0.003),
                    (-0.006, 0.006, -h / 2 - 0.004, h / 2 + 0.004, 0.0005, 0.002)], 0.0008)  # fmt: skip
    thing.add(board, cover(rng))
    if rng.uniform() < 0.6:
        lift = between(rng, 0.35, 1.0)
        a = lift * (1 - 0.5 * s)
        x = np.cumsum(np.cos(a)) * d / 14
        z = 0.006 + 1.2 * t + np.cumsum(np.sin(a)) * d / 14 * np.clip(1.2 - 0.6 * s, 0, 1)
        leaf = np.empty((14, 2, 3))
        leaf[..., 0], leaf[..., 1], leaf[..., 2] = x[:, None], 0.97 * y, z[:, None]
        thing.add(sheet(leaf, thickness=4e-4), PAPER)
    return stood(thing)


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
        sheet_ = Material((tint, tint, 0.97 * tint), ink if kind == "marks" else (0.6, 0.66, 0.75), kind, scale,
                          specular=0.02)  # fmt: skip
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
                       (0.001, w - 0.001, -d / 2 - 0.002, -d / 2 + 0.001, 0.001, h - 0.001)], 0.001)  # fmt: skip
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
            issues.append(
                (
                    at,
                    at + thick - 0.0005,
                    d / 2 - t - deep,
                    d / 2 - t - 0.001,
                    0.0055,
                    between(rng, 0.25, 0.3),
                )
            )
            at += thick
        for limits in issues:
            thing.add(boards([limits], 0.0006), cover(rng), 2)
    return stood(thing)


def _panel(outline: Points, thickness: float) -> Mesh:
    """A flat convex outline in the plane x = 0, counter-clockwise seen from +x, made thick."""
    n = len(outline)
    fan = np.array([(0, k, k + 1) for k in range(1, n - 1)], np.int32)
    near, far = outline, outline + [thickness, 0, 0]
    nxt = np.roll(np.arange(n), -1)
    rim = quads(np.stack([near, near[nxt], far[nxt], far], 1))
    return joined(
        [Mesh(near.astype(np.float32), fan[:, ::-1].copy()), Mesh(far.astype(np.float32), fan), rim]
    )


CATALOGUE: dict[str, Maker] = {
    "book": book,
    "book_stack": book_stack,
    "book_row": book_row,
    "open_book": open_book,
    "magazine_pile": magazine_pile,
    "paper_sheets": paper_sheets,
    "folder_row": folder_row,
    "box_file": box_file,
}
