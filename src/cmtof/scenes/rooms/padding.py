"""Soft things with a filling: pillows, beanbags, poufs."""

import numpy as np

from cmtof.scenes.rooms.materials import Material, Style, darker, fabric
from cmtof.scenes.rooms.pliant import Points, centred, ripples
from cmtof.scenes.rooms.shades import Maker
from cmtof.scenes.rooms.solids import ball, joined, revolve, sheet, tube
from cmtof.scenes.rooms.thing import Mesh, Thing


def _cover(rng: np.random.Generator, style: Style) -> Material:
    kinds = (style.fabric, style.second_fabric, style.leather)
    return fabric(rng) if rng.uniform() < 0.5 else kinds[int(rng.integers(3))]


def cushion_pillow(rng: np.random.Generator, style: Style, *, lean: float = 0.0) -> Thing:
    """A square, oblong or round pillow or a bolster, lying on z = 0.

    Parameters
    ----------
    lean : float
        Angle by which its back edge is raised, rad: 1.2 for a pillow against a backrest.
    """
    thing = Thing("cushion_pillow")
    cover = _cover(rng, style)
    kind = int(rng.integers(6))
    if kind == 4:
        _bolster(rng, thing, cover)
    elif kind == 5:
        _round(rng, thing, cover)
    else:
        side = float(rng.choice([0.4, 0.45, 0.5]))
        deep = side if kind < 3 else 0.65 * side
        _square(rng, thing, cover, side, deep)
    if lean:
        c, s = np.cos(lean), np.sin(lean)
        turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        thing.parts = [
            p._replace(mesh=Mesh((p.mesh.vertices @ turn.T).astype(np.float32), p.mesh.faces))
            for p in thing.parts
        ]
    return centred(thing)


def _square(
    rng: np.random.Generator, thing: Thing, cover: Material, length: float, deep: float
) -> None:
    """Two panels sewn at the edge: full in the middle, thin at the pointed corners."""
    t = np.sin(np.linspace(-np.pi / 2, np.pi / 2, 17))
    u, v = np.meshgrid(t, t, indexing="ij")
    # the filling draws the middles of the edges in
    x = length / 2 * u * (1 - 0.07 * (1 - v**2))
    y = deep / 2 * v * (1 - 0.07 * (1 - u**2))
    full = ((1 - u**2) * (1 - v**2)) ** 0.42
    height = float(rng.uniform(0.065, 0.1))
    crease = 1 + 0.12 * ripples(rng, 6 * u, 6 * v, 8, 4.0) * np.sqrt(u**2 + v**2)
    dent = 1 - float(rng.uniform(0.0, 0.35)) * np.exp(-4 * ((u - 0.1) ** 2 + (v + 0.2) ** 2))
    top = np.stack([x, y, height * full * crease * dent], -1)
    bottom = np.stack([x, y, -0.8 * height * full**0.8], -1)
    upper, lower = sheet(top), sheet(bottom)
    back = Mesh(lower.vertices, lower.faces[:, ::-1].copy())
    thing.add(upper, cover)
    thing.add(back, cover)
    if rng.uniform() < 0.6:
        loop = np.concatenate([top[:, 0], top[-1, 1:], top[-2::-1, -1], top[0, -2::-1]])
        trim = cover if rng.uniform() < 0.5 else Material(darker(cover.colour, 0.4), specular=0.0)
        thing.add(tube(loop, 0.004, 6), trim)
        if rng.uniform() < 0.2:
            corners = [top[i, j] for i in (0, -1) for j in (0, -1)]
            thing.add(joined([ball(0.018, c, 2) for c in corners]), trim)


def _bolster(rng: np.random.Generator, thing: Thing, cover: Material) -> None:
    length, r = float(rng.uniform(0.4, 0.65)), float(rng.uniform(0.07, 0.1))
    at = np.array([0, 0.0, 0.02, 0.06, 0.3, 0.7, 0.94, 0.98, 1.0, 1.0]) - 0.5
    girth = r * np.array([0.1, 0.72, 0.9, 0.99, 1.02, 1.02, 0.99, 0.9, 0.72, 0.1])
    body = revolve(np.column_stack([girth, at * length]), 28)
    thing.add(_laid(body), cover)
    for side in (-1, 1):
        ring = np.linspace(0, 2 * np.pi, 25)
        path = np.stack([np.full(25, side * 0.485 * length), 0.86 * r * np.cos(ring), 0.86 * r * np.sin(ring)], -1)  # fmt: skip  # noqa: E501
        trim = Material(darker(cover.colour, 0.5), specular=0.0)
        thing.add(tube(path, 0.004, 6), trim)
        thing.add(ball(0.015, (side * 0.495 * length, 0, 0), 1), trim)


def _laid(mesh: Mesh) -> Mesh:
    """A turned body with its axis along x."""
    turn = np.array([[0, 0, -1], [0, 1, 0], [1, 0, 0]], np.float32)
    return Mesh(mesh.vertices @ turn, mesh.faces)


def _round(rng: np.random.Generator, thing: Thing, cover: Material) -> None:
    """A round pillow in pleats about a button."""
    r, h = float(rng.uniform(0.19, 0.24)), float(rng.uniform(0.045, 0.06))
    angle = np.linspace(-np.pi / 2, np.pi / 2, 17)
    girth = r * np.cos(angle) ** 0.55
    z = h * np.sin(angle) * (0.45 + 0.55 * np.clip(girth / (0.5 * r), 0, 1))
    body = revolve(np.column_stack([girth, z]), 36)
    pleat = 1 + 0.05 * np.cos(18 * np.arctan2(body.vertices[:, 1], body.vertices[:, 0]))
    thing.add(Mesh((body.vertices * [1, 1, 0] + np.outer(body.vertices[:, 2] * pleat, [0, 0, 1])).astype(np.float32), body.faces), cover)  # fmt: skip  # noqa: E501
    thing.add(ball(0.014, (0, 0, 0.5 * h), 2), Material(darker(cover.colour, 0.5), specular=0.05))


def _sewn(points: Points, panels: int, depth: float) -> Points:
    """Draw the surface in at ``panels`` upright seams, m."""
    angle = np.arctan2(points[..., 1], points[..., 0])
    seam = np.abs(np.cos(0.5 * panels * angle)) ** 0.35
    far = np.linalg.norm(points[..., :2], axis=-1, keepdims=True) + 1e-9
    return points * [1, 1, 1] - depth * (1 - seam[..., None]) * points * [1, 1, 0] / far


def beanbag(rng: np.random.Generator, style: Style) -> Thing:
    """A sagging bag with a hollow where one sat."""
    thing = Thing("beanbag")
    r, h = float(rng.uniform(0.36, 0.48)), float(rng.uniform(0.5, 0.75))
    s, t = np.meshgrid(
        np.linspace(0, 1, 20), np.linspace(0, 2 * np.pi, 48, endpoint=False), indexing="ij"
    )
    girth = r * np.interp(
        s, [0, 0.04, 0.2, 0.4, 0.7, 0.9, 1.0], [0, 0.75, 1.0, 0.97, 0.66, 0.34, 0.0]
    )
    z = h * np.interp(s, [0, 0.04, 0.2, 0.4, 0.7, 0.9, 1.0], [0, 0.0, 0.14, 0.36, 0.72, 0.94, 1.0])
    points = np.stack([girth * np.cos(t), girth * np.sin(t), z], -1)
    points[..., 1] += 0.24 * r * s**2  # leans back
    front = np.clip(-np.sin(t), 0, 1) * np.exp(-(((s - 0.6) / 0.22) ** 2))
    points[..., 1] += 0.36 * r * front
    points[..., 2] -= 0.2 * h * front
    points += (
        0.012
        * ripples(rng, 5 * t / 6.28, 4 * s, 8, 1.5)[..., None]
        * np.clip(z / 0.1, 0, 1)[..., None]
    )
    points[:, :, :] = _sewn(points, 6, 0.014)
    points[..., 2] = np.maximum(points[..., 2], 0)
    cover = _cover(rng, style)
    thing.add(sheet(points[:, ::-1], closed=True), cover)
    return centred(thing)


def pouf(rng: np.random.Generator, style: Style) -> Thing:
    """A round seat: sewn leather in panels, knitted cord, or a plain drum with piping."""
    thing = Thing("pouf")
    r, h = float(rng.uniform(0.22, 0.3)), float(rng.uniform(0.3, 0.42))
    cover = _cover(rng, style)
    kind = int(rng.integers(3))
    n, m = (36, 40) if kind == 1 else (18, 48)
    s, t = np.meshgrid(
        np.linspace(0, np.pi, n), np.linspace(0, 2 * np.pi, m, endpoint=False), indexing="ij"
    )
    square = 0.35 if kind == 2 else 0.6
    girth = r * np.abs(np.sin(s)) ** square
    z = h / 2 * (1 - np.sign(np.cos(s)) * np.abs(np.cos(s)) ** square)
    points = np.stack([girth * np.cos(t), girth * np.sin(t), z], -1)
    if kind == 0:
        points = _sewn(points, 8, 0.02)
    elif kind == 1:  # rows of knit
        knit = 0.006 * np.cos(np.pi * np.arange(n))[:, None] * np.sin(s)
        points += knit[..., None] * np.stack([np.cos(t), np.sin(t), 0 * t], -1)
    points[..., 2] += (
        0.006
        * ripples(rng, points[..., 0], points[..., 1], 5, 0.4)
        * np.clip(4 * z / h - 2.4, 0, 1)
    )
    points[..., 2] -= points[..., 2].min()
    thing.add(sheet(points[:, ::-1], closed=True), cover)
    if kind == 2:
        ring = np.linspace(0, 2 * np.pi, 37)
        for height in (0.06, 0.94):
            wide = (
                r * np.sin(np.arccos(np.clip(abs(1 - 2 * height) ** (1 / square), 0, 1))) ** square
            )
            path = np.stack([wide * np.cos(ring), wide * np.sin(ring), np.full(37, height * h)], -1)
            thing.add(tube(path, 0.005, 6), Material(darker(cover.colour, 0.5), specular=0.0))
    elif kind == 0:
        thing.add(ball(0.03, (0, 0, h - 0.012), 2), cover)
    return thing


CATALOGUE: dict[str, Maker] = {
    "cushion_pillow": cushion_pillow,
    "beanbag": beanbag,
    "pouf": pouf,
}
