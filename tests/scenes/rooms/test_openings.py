"""Holes in walls, and the windows and doors that fill them."""

from pickle import dumps

import numpy as np
import pytest
import trimesh

from cmtof.scenes.rooms.bars import bars
from cmtof.scenes.rooms.doors import door
from cmtof.scenes.rooms.openings import window
from cmtof.scenes.rooms.panels import Opening, panel, reveals, swept
from cmtof.scenes.rooms.plan import free_rectangles, offset, outline, triangulated

DESIGNS = ["casement", "sash", "grid", "strip", "french"]


def area(mesh) -> np.ndarray:
    a, b, c = (mesh.vertices[mesh.faces[:, k]].astype(float) for k in range(3))
    return np.cross(b - a, c - a) / 2


def volume(mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, k]].astype(float) for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6)


@pytest.mark.parametrize(("shape", "hole"), [("rectangle", 1.5), ("round", np.pi * 1.0 * 1.5 / 4)])
def test_a_panel_covers_its_rectangle_but_for_the_hole(shape, hole):
    mesh = panel([Opening(1.0, 2.0, 0.5, 2.0, shape)], [(0.0, 2.5), (4.0, 2.5)])
    facing = area(mesh)
    assert (facing[:, 1] < 0).all()  # towards the room
    assert -facing[:, 1].sum() == pytest.approx(10.0 - hole, rel=0.01)


def test_an_arch_has_a_half_round_head():
    mesh = panel([Opening(1.0, 2.0, 0.0, 2.0, "arch")], [(0.0, 2.5), (4.0, 2.5)])
    assert -area(mesh)[:, 1].sum() == pytest.approx(10 - 1.5 - np.pi / 8, rel=0.01)


def test_a_gable_follows_its_slopes():
    mesh = panel([], [(0.0, 1.0), (2.0, 3.0), (4.0, 1.0)])
    assert -area(mesh)[:, 1].sum() == pytest.approx(8.0)


@pytest.mark.parametrize("shape", ["rectangle", "arch", "round"])
def test_reveals_look_into_the_hole(shape):
    hole = Opening(1.0, 2.0, 0.5, 2.0, shape)
    mesh = reveals(hole, 0.3)
    normal = area(mesh)
    middle = mesh.vertices[mesh.faces].mean(1)
    x, z = hole.centre
    assert ((normal * ([x, 0.15, z] - middle)).sum(1) > 0).all()


def test_a_moulding_is_mitred_around_a_corner():
    path = [(0.0, 0.0), (2.0, 0.0), (2.0, 3.0)]
    mesh = swept(path, [(0.1, 0.0), (0.1, 0.2), (0.0, 0.2), (0.0, 0.0)])
    assert volume(mesh) == pytest.approx(0.1 * 0.2 * (2 + 3 - 0.1), rel=1e-5)


def test_bars_are_closed_and_as_long_as_asked():
    ends = np.random.default_rng(0).normal(size=(40, 3))
    mesh = bars(np.zeros((40, 3)), ends, 0.05, sides=12)
    polygon = 6 * np.sin(np.pi / 6) * 0.05**2
    assert volume(mesh) == pytest.approx(polygon * np.linalg.norm(ends, axis=1).sum(), rel=1e-4)


def test_an_outline_is_triangulated_without_gap_or_overlap():
    points = outline(6, 5, [(4, 6, 3, 5), (1, 2, 0, 0.5), (0, 1.5, 4.2, 5)])
    faces = triangulated(points)
    a, b, c = (points[faces[:, k]] for k in range(3))
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert (twice > 0).all()
    assert twice.sum() / 2 == pytest.approx(30 - 4 - 0.5 - 1.2)


def test_an_outline_grows_by_the_same_distance_on_all_sides():
    points = outline(4, 3, [(3, 4, 2, 3)])
    grown = offset(points, 0.2)
    assert grown.min(0).tolist() == pytest.approx([-0.2, -0.2])
    assert grown.max(0).tolist() == pytest.approx([4.2, 3.2])
    assert [3.2, 2.2] in grown.round(9).tolist()  # the corner that stands in


def test_an_outline_that_crosses_itself_is_refused():
    with pytest.raises(ValueError, match="simple outline"):
        triangulated(np.array([(0, 0), (0, 1), (1, 1), (1, 0)], float))


def test_free_rectangles_cover_the_floor_and_nothing_else():
    cuts = [(3.0, 4.0, 2.0, 3.0), (1.0, 1.5, 1.0, 1.4)]
    found = free_rectangles(4, 3, cuts)
    x, y = np.random.default_rng(0).uniform(0, [[4], [3]], (2, 2000))
    covered = np.any([(a < x) & (x < b) & (c < y) & (y < d) for a, b, c, d in found], axis=0)
    cut = np.any([(a < x) & (x < b) & (c < y) & (y < d) for a, b, c, d in cuts], axis=0)
    assert (covered ^ cut).all()


@pytest.mark.parametrize("design", DESIGNS)
@pytest.mark.parametrize("seed", range(3))
def test_a_window_fills_its_opening_and_lets_light_through(design, seed, style, check_thing):
    foot = 0.02 if design == "french" else 0.9
    hole = Opening(1.0, 2.6, foot, 2.1)
    made = window(
        np.random.default_rng(seed), style, opening=hole, depth=0.3, design=design, sill=foot > 0.5
    )
    check_thing(made, standing="free", triangles=3000)
    mesh = joined_body(made)
    u = np.random.default_rng(1).uniform(-0.78, 0.78, 400)
    v = np.random.default_rng(2).uniform(0.02, hole.z1 - hole.z0 - 0.02, 400)
    start = np.stack([u, 0 * u + 1.5, v], -1)
    hit = mesh.ray.intersects_first(start, np.tile([0.0, -1.0, 0.0], (400, 1))) >= 0
    assert 0.08 < hit.mean() < 0.75


@pytest.mark.parametrize("shape", ["arch", "round"])
def test_curved_windows_keep_within_their_opening(shape, style):
    hole = Opening(0.0, 1.0, 0.8, 2.0 if shape == "arch" else 1.8, shape)
    made = window(np.random.default_rng(0), style, opening=hole, depth=0.3, sill=False)
    low, high = made.bounds
    assert low[0] == pytest.approx(-0.5, abs=0.01)
    assert high[2] == pytest.approx(hole.z1 - hole.z0, abs=0.01)


def joined_body(thing) -> trimesh.Trimesh:
    from cmtof.scenes.rooms.solids import joined
    from cmtof.scenes.rooms.thing import moved

    meshes = [part.mesh for part in thing.parts]
    meshes += [moved(part.mesh, at) for child, at in thing.children for part in child.parts]
    whole = joined(meshes)
    return trimesh.Trimesh(whole.vertices, whole.faces, process=False)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("angle", [0.0, 0.8, 1.5, None])
def test_a_door_stands_in_its_frame(seed, angle, style, check_thing):
    rng = np.random.default_rng(seed)
    made = door(rng, style, width=0.9, height=2.05, depth=0.2, threshold=style.wood, angle=angle)
    check_thing(made, standing="free", triangles=3000)
    mesh = joined_body(made)
    x, z = np.meshgrid(np.linspace(-0.3, 0.3, 9), np.linspace(0.1, 1.9, 9))
    start = np.stack([x.ravel(), 0 * x.ravel() + 1.5, z.ravel()], -1)
    hit = mesh.ray.intersects_first(start, np.tile([0.0, -1.0, 0.0], (81, 1))) >= 0
    if angle == 0.0:
        assert hit.mean() > 0.05  # glazed leaves have no panes
    elif angle != 0.8:
        assert hit.mean() < 0.2


def test_a_leaf_opens_into_the_room_or_away_from_it(style):
    for inwards, sign in ((True, -1), (False, 1)):
        rng = np.random.default_rng(4)
        made = door(
            rng, style, width=0.9, height=2.05, depth=0.2, threshold=style.wood, angle=1.4,
            inwards=inwards,
        )  # fmt: skip
        leaf, at = made.children[0]
        far = np.stack([leaf.bounds[k] for k in (0, 1)]).mean(0)
        assert np.sign((at[:3, :3] @ far + at[:3, 3])[1]) == sign


def test_the_same_seed_makes_the_same_door_and_window(style):
    hole = Opening(0, 1.2, 0.9, 2.1)
    one, two = (
        dumps(window(np.random.default_rng(3), style, opening=hole, depth=0.3)) for _ in range(2)
    )
    assert one == two
    options = {"width": 0.9, "height": 2.0, "depth": 0.2, "threshold": style.wood}
    doors = [dumps(door(np.random.default_rng(s), style, **options)) for s in (1, 1, 2)]
    assert doors[0] == doors[1] != doors[2]
