"""Books and paper: lying, stacked, in rows, open, m."""

import numpy as np

from cmtof.scenes.rooms import papers
from cmtof.scenes.rooms.joinery import boards, placed
from cmtof.scenes.rooms.materials import Material, Style
from cmtof.scenes.rooms.papers import PAPER, cover
from cmtof.scenes.rooms.pliant import Points
from cmtof.scenes.rooms.shaping import stood
from cmtof.scenes.rooms.solids import joined, quads, sheet
from cmtof.scenes.rooms.thing import Mesh, Thing
from cmtof.scenes.rooms.vessels import Maker, between

PAGES = Material((0.72, 0.68, 0.56), (0.6, 0.56, 0.45), "stripes", 0.0012, specular=0.0)

# corner number of the eight that `_bound` makes, for each quadrilateral of one upright book:
# outsides, spine with its two bevels, the boards' tops, fore edges, feet
_COVER = ((0, 1, 9, 8), (1, 2, 10, 9), (2, 3, 11, 10), (3, 4, 12, 11), (4, 5, 13, 12), (5, 6, 14,
    13), (6, 7, 15, 14), (7, 0, 8, 15))  # fmt: skip


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
    tops = [face((zero, bevel, z), (u, e, z), (u, depth, z), (zero, depth, z)),
        face((v, e, z), (width, bevel, z), (width, depth, z), (v, depth, z)),
        face((zero, bevel, z), (bevel, zero, z), (width - bevel, zero, z), (width, bevel, z)),
        face((zero, bevel, z), (width, bevel, z), (v, e + bevel, z), (u, e + bevel, z)),
        face((zero, depth, zero), (zero, depth, z), (u, depth, z), (u, depth, zero)),
        face((v, depth, zero), (v, depth, z), (width, depth, z), (width, depth, zero)),
        face((zero, depth, zero), (width, depth, zero), (width, bevel, zero),
        (zero, bevel, zero))]  # fmt: skip
    inner = [face((u, e, z), (u, depth, z), (u, depth, z - down), (u, e, z - down)),
        face((v, depth, z), (v, e, z), (v, e, z - down), (v, depth, z - down)),
        face((v, e, z), (u, e, z), (u, e, z - down), (v, e, z - down))]  # fmt: skip
    pages = [face((u, e, z - down), (v, e, z - down), (v, depth - down, z - down),
        (u, depth - down, z - down)), face((u, depth - down, zero), (u, depth - down, z - down),
        (v, depth - down, z - down), (v, depth - down, zero))]  # fmt: skip
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
    w[1 : int(n * common)] = np.where(rng.uniform(size=int(n * common) - 1 if n * common > 1 else 0)
        < 0.5, w[0], w[1 : int(n * common)])  # fmt: skip
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
    block = boards([(-d / 2 + 0.001, d / 2 - 0.004, -h / 2 + 0.004, h / 2 - 0.004, t - 0.0005,
        w - t + 0.0005)], 0)  # fmt: skip
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
        thing.add(sheet(edge[:, ::side]), PAGES, 1)
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


CATALOGUE: dict[str, Maker] = {
    "book": book,
    "book_stack": book_stack,
    "open_book": open_book,
    "book_row": book_row,
    **papers.CATALOGUE,
}
