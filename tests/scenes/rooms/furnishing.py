"""What furniture and small things are held to, and the households that they are drawn for."""

from collections.abc import Callable, Sequence
from pickle import dumps

import numpy as np

from cmtof.scenes.rooms.materials import style as draw_style
from cmtof.scenes.rooms.solids import joined
from cmtof.scenes.rooms.thing import Thing

Maker = Callable[..., Thing]
Limits = Sequence[tuple[float, float]]
"""Least and greatest width, depth and height, m."""


def draw(maker: Maker, seed: int, **options) -> Thing:
    """One draw, for a household of its own."""
    household = draw_style(np.random.default_rng(1000 + seed))
    return maker(np.random.default_rng(seed), household, **options)


def sizes(maker: Maker, count: int = 20, **options) -> np.ndarray:
    """Widths, depths and heights of so many draws, (N, 3), m."""
    bounds = [draw(maker, seed, **options).bounds for seed in range(count)]
    return np.array([high - low for low, high in bounds])


def assert_made_well(
    name: str,
    maker: Maker,
    limits: Limits,
    check_thing: Callable[..., None],
    *,
    budget: int = 6000,
    standing: str = "floor",
) -> None:
    """It stands and carries, is as large as a real one, looks outwards and repeats itself."""
    for seed in range(8):
        thing = draw(maker, seed)
        check_thing(thing, standing, triangles=budget)
        outward = [volume > -1e-9 for volume in closed_volumes(thing)]
        assert all(outward), f"{name}, seed {seed}: a part is inside out"
    assert_within(name, sizes(maker), limits)
    assert_repeatable(maker)


def assert_within(name: str, measured: np.ndarray, limits: Limits) -> None:
    """Every width, depth and height, (N, 3), lies within its limits, m."""
    low, high = np.array(limits, float).T
    assert (measured >= low).all(), f"{name} is too small: {measured.min(0)}"
    assert (measured <= high).all(), f"{name} is too large: {measured.max(0)}"


def assert_repeatable(maker: Maker) -> None:
    """Same seed, same bytes; other seed, others."""
    assert dumps(draw(maker, 3)) == dumps(draw(maker, 3))
    household = draw_style(np.random.default_rng(0))
    one, two = (maker(np.random.default_rng(seed), household) for seed in (4, 5))
    assert dumps(one) != dumps(two)


def closed_volumes(thing: Thing) -> list[float]:
    """Signed volumes of the parts that have no open edge: positive if they look outwards, m³."""
    found = []
    for part in thing.parts:
        vertices, faces = part.mesh.vertices.astype(float), part.mesh.faces
        places = np.unique((vertices * 1e5).round().astype(int), axis=0, return_inverse=True)[1]
        ring = places.reshape(-1)[faces]
        edges = np.concatenate([ring[:, [0, 1]], ring[:, [1, 2]], ring[:, [2, 0]]])
        edges = edges[edges[:, 0] != edges[:, 1]]
        code = len(vertices) + 1
        forth = np.sort(edges[:, 0] * code + edges[:, 1])
        if not np.array_equal(forth, np.sort(edges[:, 1] * code + edges[:, 0])):
            continue
        corners = vertices[faces] - vertices.mean(0)
        a, b, c = np.moveaxis(corners, 1, 0)
        found.append(float((a * np.cross(b, c)).sum() / 6))
    return found


def distinct(maker: Maker, count: int = 12) -> int:
    """How many different shapes so many draws have, told by their numbers of triangles."""
    return len({sum(len(p.mesh.faces) for p in draw(maker, seed).parts) for seed in range(count)})


def drop(thing: Thing, x, y) -> np.ndarray:
    """Heights of the first surfaces below points (x, y), m."""
    import trimesh

    whole = joined([part.mesh for part in thing.parts])
    body = trimesh.Trimesh(whole.vertices, whole.faces, process=False)
    x, y = np.broadcast_arrays(np.atleast_1d(x), np.atleast_1d(y))
    start = np.column_stack([x, y, np.full(len(x), 3.0)])
    down = np.tile([0.0, 0.0, -1.0], (len(x), 1))
    hits, rays, _ = body.ray.intersects_location(start, down, multiple_hits=False)
    return hits[np.argsort(rays), 2]
