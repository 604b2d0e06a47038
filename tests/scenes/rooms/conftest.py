"""What every maker of things promises, checked the same way."""

from collections.abc import Callable

import numpy as np
import pytest

from cmtof.scenes.rooms.materials import Style
from cmtof.scenes.rooms.materials import style as draw_style
from cmtof.scenes.rooms.thing import Thing, pose, transformed

Check = Callable[..., None]


@pytest.fixture
def style() -> Style:
    return draw_style(np.random.default_rng(5))


def flattened(thing: Thing, motion=None):
    """Every part of a thing and of what it carries, with its pose."""
    motion = pose() if motion is None else motion
    yield from ((part, motion) for part in thing.parts)
    for child, at in thing.children:
        yield from flattened(child, motion @ at)


def packed(thing: Thing) -> bytes:
    """All that a thing is made of, as bytes."""
    pieces = []
    for part, motion in flattened(thing):
        pieces += [part.mesh.vertices.tobytes(), part.mesh.faces.tobytes()]
        pieces += [motion.tobytes(), repr(part.material).encode()]
    return b"".join(pieces)


@pytest.fixture
def check_thing() -> Check:
    """Geometry that can be drawn: finite, indexed, standing, supports on something, in budget."""

    def check(thing: Thing, standing: str = "floor", triangles: int = 6000) -> None:
        parts = list(flattened(thing))
        assert parts, "no parts"
        count = 0
        for part, _ in parts:
            mesh = part.mesh
            assert mesh.vertices.dtype == np.float32
            assert mesh.faces.dtype == np.int32
            assert np.isfinite(mesh.vertices).all()
            assert mesh.faces.min() >= 0
            assert mesh.faces.max() < len(mesh.vertices)
            count += len(mesh.faces)
        assert 0 < count <= triangles
        low, high = thing.bounds
        if standing == "floor":
            assert low[2] == pytest.approx(0, abs=2e-3)
        elif standing == "ceiling":
            assert high[2] == pytest.approx(0, abs=2e-3)
        elif standing == "wall":
            assert high[1] == pytest.approx(0, abs=5e-3)
        if standing == "floor":
            assert np.abs((low + high)[:2] / 2).max() < 0.25 * (high - low)[:2].max() + 0.01
        for support in thing.supports:
            check_support(thing, support)

    return check


def check_support(thing: Thing, support) -> None:
    """Rays from above meet the thing where a support is said to be, at five points of it."""
    import trimesh

    from cmtof.scenes.rooms.solids import joined
    from cmtof.scenes.rooms.thing import Mesh

    meshes = [
        Mesh(transformed(part.mesh.vertices, motion).astype(np.float32), part.mesh.faces)
        for part, motion in flattened(thing)
    ]
    whole = joined(meshes)
    body = trimesh.Trimesh(whole.vertices, whole.faces, process=False)
    u = np.array([0.5, 0.1, 0.9, 0.1, 0.9])
    v = np.array([0.5, 0.1, 0.1, 0.9, 0.9])
    start = np.column_stack(
        [
            support.x0 + u * (support.x1 - support.x0),
            support.y0 + v * (support.y1 - support.y0),
            np.full(5, support.z + min(0.03, support.clearance / 2)),
        ]
    )
    where, rays, _ = body.ray.intersects_location(
        start, np.tile([0.0, 0.0, -1.0], (5, 1)), multiple_hits=False
    )
    assert sorted(rays) == list(range(5)), f"{thing.kind}: a support hangs in the air"
    assert np.abs(where[:, 2] - support.z).max() < 0.02, f"{thing.kind}: a support is off"
