"""Empty rooms: closed but for their windows, and truthful about floor, walls, doors and light."""

from collections.abc import Iterator

import numpy as np
import pytest
import trimesh

from cmtof.scenes.rooms.architecture import shell
from cmtof.scenes.rooms.house import Shell
from cmtof.scenes.rooms.layouts import SIZES
from cmtof.scenes.rooms.materials import style as draw_style
from cmtof.scenes.rooms.plan import cross
from cmtof.scenes.rooms.thing import Pose, Thing, pose, transformed

OUTSIDE = ("ground", "façade", "hedge", "balcony")
KINDS = list(SIZES)


def make(seed: int, kind: str | None = None) -> Shell:
    rng = np.random.default_rng(seed)
    return shell(rng, draw_style(rng), kind=kind or KINDS[seed % len(KINDS)])


@pytest.fixture(scope="module")
def shells() -> list[Shell]:
    return [make(seed) for seed in range(30)]


def parts(thing: Thing, motion: Pose | None = None) -> Iterator[tuple]:
    motion = pose() if motion is None else motion
    yield from ((part, motion) for part in thing.parts)
    for child, at in thing.children:
        yield from parts(child, motion @ at)


def body(empty: Shell, leave_out: tuple[str, ...] = (), panes: float = 0.0) -> trimesh.Trimesh:
    """All triangles of a shell; its windows closed by panes grown by a factor, if given."""
    vertices, faces, count = [], [], 0
    for thing, motion in empty.things:
        if thing.kind in leave_out:
            continue
        for part, at in parts(thing, motion):
            vertices.append(transformed(part.mesh.vertices, at))
            faces.append(part.mesh.faces + count)
            count += len(part.mesh.vertices)
    for light in empty.lights if panes else []:
        c, u, v = (np.array(a) for a in (light.centre, light.half_u, light.half_v))
        signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
        vertices.append(c + panes * (signs[:, :1] * u + signs[:, 1:] * v))
        faces.append(np.array([[0, 1, 2], [0, 2, 3]]) + count)
        count += 4
    return trimesh.Trimesh(np.concatenate(vertices), np.concatenate(faces), process=False)


def packed(empty: Shell) -> bytes:
    pieces = [motion.tobytes() for _, motion in empty.things]
    for thing, motion in empty.things:
        for part, at in parts(thing, motion):
            pieces += [part.mesh.vertices.tobytes(), part.mesh.faces.tobytes(), at.tobytes()]
            pieces.append(repr(part.material).encode())
    told = (empty.floor, empty.walls, empty.lights, empty.sun, empty.doorways, empty.annexes)
    return b"".join([*pieces, repr(told).encode()])


def somewhere(empty: Shell, rng: np.random.Generator, count: int) -> np.ndarray:
    """Points over the free floor, away from what lines the walls."""
    pick = rng.integers(len(empty.floor), size=count)
    rects = np.array(empty.floor)[pick]
    margin = np.minimum(
        0.05, 0.2 * np.stack([rects[:, 1] - rects[:, 0], rects[:, 3] - rects[:, 2]])
    )
    u = rng.uniform(size=(3, count))
    x = rects[:, 0] + margin[0] + u[0] * (rects[:, 1] - rects[:, 0] - 2 * margin[0])
    y = rects[:, 2] + margin[1] + u[1] * (rects[:, 3] - rects[:, 2] - 2 * margin[1])
    return np.stack([x, y, 0.1 + u[2] * (min(empty.height, 2.0) - 0.2)], -1)


@pytest.mark.parametrize("seed", range(40))
def test_no_ray_leaves_a_room_whose_windows_are_closed(seed):
    empty = make(seed)
    closed = body(empty, OUTSIDE, panes=1.5)
    rng = np.random.default_rng(seed)
    start = somewhere(empty, rng, 3000)
    towards = rng.normal(size=start.shape)
    hit = closed.ray.intersects_first(start, towards)
    assert (hit >= 0).all(), f"{empty.features}: {start[hit < 0][:2]} to {towards[hit < 0][:2]}"


@pytest.mark.parametrize("seed", range(0, 40, 3))
def test_no_ray_leaves_the_rooms_beyond_either(seed):
    empty = make(seed)
    closed = body(empty, OUTSIDE, panes=1.5)
    rng = np.random.default_rng(seed)
    for annex in empty.annexes:
        x0, x1, y0, y1 = annex.floor
        start = np.stack(
            [rng.uniform(x0 + 0.1, x1 - 0.1, 500), rng.uniform(y0 + 0.1, y1 - 0.1, 500),
             rng.uniform(0.2, min(0.9, annex.height - 0.2), 500)], -1,
        )  # fmt: skip
        hit = closed.ray.intersects_first(start, rng.normal(size=start.shape))
        assert (hit >= 0).all(), annex.kind


def test_daylight_comes_in_where_the_panes_are_left_out(shells):
    lit = 0
    for empty in shells:
        if not empty.lights:
            continue
        rng = np.random.default_rng(1)
        open_body = body(empty, OUTSIDE)
        start = somewhere(empty, rng, 4000)
        lit += bool((open_body.ray.intersects_first(start, rng.normal(size=start.shape)) < 0).any())
    assert lit > 20


def test_walls_have_the_room_on_their_left(shells):
    for empty in shells:
        solid = body(empty, OUTSIDE)
        for run in empty.walls:
            start, end = np.array(run.start), np.array(run.end)
            along = (end - start) / run.length
            left = np.array([-along[1], along[0]])
            a = np.linspace(0.08, run.length - 0.08, 5) if run.length > 0.3 else [run.length / 2]
            free = [x for x in a if not any(p - 0.1 < x < q + 0.1 for p, q, _ in run.blocked)]
            for x in free:
                point = np.append(start + x * along + 0.06 * left, run.height - 0.03)
                inward, back = np.append(left, 0.0), np.append(-left, 0.0)
                hits = solid.ray.intersects_location([point], [back], multiple_hits=False)[0]
                assert len(hits) == 1
                assert np.linalg.norm(hits[0] - point) < 0.1, (empty.features, run)
                index = solid.ray.intersects_first([point], [inward])[0]
                assert index >= 0 or empty.lights


def test_blocked_pieces_lie_within_their_walls(shells):
    for empty in shells:
        for run in [*empty.walls, *(w for annex in empty.annexes for w in annex.walls)]:
            assert run.height > 0
            for a, b, sill in run.blocked:
                assert 0 <= a < b <= run.length + 1e-6
                assert 0 <= sill < run.height


def test_one_can_look_through_the_middle_of_every_open_doorway(shells):
    count = 0
    for empty in shells:
        solid = body(empty, OUTSIDE)
        for (x, y), (dx, dy) in empty.doorways:
            assert np.hypot(dx, dy) == pytest.approx(1)
            point, inward = np.array([x, y, 1.2]), np.array([dx, dy, 0.0])
            for way in (inward, -inward):
                hits = solid.ray.intersects_location([point], [way], multiple_hits=False)[0]
                reach = np.linalg.norm(hits[0] - point) if len(hits) else np.inf
                assert reach > 0.4, (empty.kind, empty.features)
                count += 1
    assert count > 30


def test_doorways_lie_in_walls_that_are_blocked_there(shells):
    for empty in shells:
        runs = [*empty.walls, *(w for annex in empty.annexes for w in annex.walls)]
        for (x, y), (dx, dy) in empty.doorways:
            found = False
            for run in runs:
                start, end = np.array(run.start), np.array(run.end)
                along = (end - start) / run.length
                a, off = (np.array([x, y]) - start) @ along, cross(along, np.array([x, y]) - start)
                if abs(off) < 0.3 and abs(along @ [dx, dy]) < 1e-6:
                    found |= any(p < a < q and sill == 0.0 for p, q, sill in run.blocked)
            assert found


def test_window_lights_shine_inwards_from_within_their_openings(shells):
    for empty in shells:
        solid, glazed = body(empty, OUTSIDE), body(empty, OUTSIDE, panes=1.5)
        for light in empty.lights:
            normal = np.array(light.normal)
            assert np.linalg.norm(normal) == pytest.approx(1)
            assert normal @ light.half_u == pytest.approx(0, abs=1e-9)
            assert normal @ light.half_v == pytest.approx(0, abs=1e-9)
            area = 4 * np.linalg.norm(np.cross(light.half_u, light.half_v))
            assert 3 <= light.power / area <= 6
            rng = np.random.default_rng(0)
            u, v = rng.uniform(-0.97, 0.97, (2, 200, 1))
            start = np.array(light.centre) + u * light.half_u + v * light.half_v
            inwards = glazed.ray.intersects_first(start + 0.001 * normal, np.tile(normal, (200, 1)))
            assert (inwards >= 0).all()
            out = solid.ray.intersects_first(start, np.tile(-normal, (200, 1)))
            assert (out < 0).mean() > 0.95  # nothing of the house stands before its own window


def test_the_sun_shines_into_the_room(shells):
    sunny = [empty for empty in shells if empty.sun]
    assert 8 <= len(sunny) <= 26
    for empty in sunny:
        assert empty.sun is not None
        towards, strength = np.array(empty.sun[0]), empty.sun[1]
        assert np.linalg.norm(towards) == pytest.approx(1)
        assert strength > 0
        assert np.sin(np.radians(14.9)) < towards[2] < np.sin(np.radians(60.1))
        reached, rng = 0, np.random.default_rng(2)
        solid = body(empty)
        for light in empty.lights:
            if towards @ np.array(light.normal) > -0.05:
                continue
            u, v = rng.uniform(-1, 1, (2, 600, 1))
            start = np.array(light.centre) + u * light.half_u + v * light.half_v
            out = solid.ray.intersects_first(start, np.tile(towards, (600, 1))) < 0
            hits, index, _ = solid.ray.intersects_location(
                start, np.tile(-towards, (600, 1)), multiple_hits=False
            )
            depth = (start[index] - hits) @ np.array(light.normal) * -1
            reached += int((out[index] & (depth > 0.45)).sum())
        assert reached > 0, (empty.kind, empty.features)


def test_free_floor_is_floor_and_free(shells):
    for empty in shells:
        rng = np.random.default_rng(3)
        solid = body(empty, OUTSIDE)
        for x0, x1, y0, y1 in empty.floor:
            assert 0 <= x0 < x1 <= empty.width + 1e-6
            assert 0 <= y0 < y1 <= empty.depth + 1e-6
        start = somewhere(empty, rng, 400)
        start[:, 2] = 0.5
        down = np.tile([0.0, 0.0, -1.0], (400, 1))
        hits, _, _ = solid.ray.intersects_location(start, down, multiple_hits=False)
        assert len(hits) == 400
        assert np.quantile(np.abs(hits[:, 2]), 0.97) < 0.03  # radiators may reach in


def test_ceiling_spots_touch_the_ceiling(shells):
    spots = 0
    for empty in shells:
        solid = body(empty, OUTSIDE)
        for x, y, z in empty.ceiling_spots:
            start = [[x, y, z - 0.3]]
            hits = solid.ray.intersects_location(start, [[0, 0, 1]], multiple_hits=False)[0]
            assert hits[0, 2] == pytest.approx(z, abs=0.06), (empty.features, empty.kind)
            spots += 1
    assert spots > 30


def test_headroom_is_what_a_ray_upwards_finds():
    for seed in range(4):
        empty = make(seed, "attic")
        bare = body(empty, (*OUTSIDE, "beams", "curtain", "wall", "smoke detector"))
        rng = np.random.default_rng(seed)
        x, y = rng.uniform(0.2, [[empty.width - 0.2], [empty.depth - 0.2]], (2, 200))
        start, up = np.stack([x, y, 0 * x + 0.4], -1), np.tile([0.0, 0.0, 1.0], (200, 1))
        hits, index, _ = bare.ray.intersects_location(start, up, multiple_hits=False)
        told = np.array([empty.headroom(*start[k, :2]) for k in index])
        assert (np.abs(hits[:, 2] - told) < 1e-3).mean() > 0.7  # the others see roof windows


def test_same_seed_same_bytes_and_another_seed_another_room():
    assert packed(make(11)) == packed(make(11))
    assert packed(make(11)) != packed(make(12))


def test_thirty_rooms_differ_in_plan(shells):
    features = {feature for empty in shells for feature in empty.features}
    assert len(features) >= 8
    assert len({round(empty.width * empty.depth, 1) for empty in shells}) > 20
    assert sum(bool(empty.annexes) for empty in shells) > 15
    assert any(
        np.hypot(*(np.array(a.floor)[[1, 3]] - np.array(b.floor)[[0, 2]])) > 9
        for empty in shells
        for a in empty.annexes
        for b in empty.annexes
    )


def test_shells_keep_to_their_budget(shells):
    for empty in shells:
        count = sum(len(p.mesh.faces) for t, m in empty.things for p, _ in parts(t, m))
        assert 200 < count <= 40_000


@pytest.mark.parametrize("kind", KINDS)
def test_sizes_that_are_asked_for_are_kept(kind):
    rng = np.random.default_rng(8)
    empty = shell(rng, draw_style(rng), width=6.0, depth=5.0, height=2.9, kind=kind)
    assert (empty.width, empty.depth, empty.kind) == (6.0, 5.0, kind)
    assert empty.height <= 2.9
    assert max(run.height for run in empty.walls) <= 2.9


def test_meshes_are_sound(shells):
    for empty in shells[:12]:
        for thing, motion in empty.things:
            for part, at in parts(thing, motion):
                vertices, faces = part.mesh.vertices, part.mesh.faces
                assert vertices.dtype == np.float32
                assert faces.dtype == np.int32
                assert np.isfinite(vertices).all()
                assert np.isfinite(at).all()
                assert faces.min() >= 0
                assert faces.max() < len(vertices)
