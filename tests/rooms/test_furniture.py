"""Furniture: it fills its size, stands on the floor, and nothing stands in anything."""

import numpy as np
import pytest

from cmtof_rooms.furnishing import household, presets
from cmtof_rooms.makers import MAKERS
from cmtof_rooms.materials import PATTERNS, Material, Palette
from cmtof_rooms.rendering import Settings, build
from cmtof_rooms.shell import THICK, build_shell

KINDS, ROOMS = presets()["kinds"], presets()["rooms"]


def bounds(parts):
    boxes = np.stack([part.mesh.bounds for part in parts])
    return boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)


def test_presets_name_only_what_there_is():
    used = {name for room in ROOMS.values() for name in room["things"]}
    for kind in KINDS.values():
        assert kind.keys() <= {"maker", "at", "size", "clear", "make", "around", "upon", "over"}
        used |= kind.get("upon", {}).keys() | kind.get("around", {}).keys()
    assert used == set(KINDS)
    assert {kind["maker"] for kind in KINDS.values()} == set(MAKERS)
    assert len(KINDS) >= 60
    patterns = {name for role in presets()["materials"].values() for name in role["patterns"]}
    assert patterns == set(PATTERNS)


def test_every_kind_is_closed_and_stays_within_its_size():
    kit = household(np.random.default_rng(5))
    for name, kind in KINDS.items():
        maker = kind["maker"]
        size = np.array([kit.between(*pair) for pair in kind["size"]])
        made = MAKERS[maker](kit, size, **kind.get("make", {}))
        assert all(part.mesh.is_watertight and part.mesh.volume > 0 for part in made.parts), name
        low, high = bounds(made.parts)
        # handles, worktops and banisters reach a little further
        beyond = np.array([0.03, 0.04, 1.0 if maker == "stairs" else 0.04])
        assert (low >= -size / 2 * [1, 1, 0] - beyond * [1, 1, 0] - 1e-3).all(), name
        assert (high <= size * [0.5, 0.5, 1] + beyond).all(), name
        assert abs(low[2]) < 2e-3, name
        for top in made.tops:
            assert top.z <= high[2] + 2e-3, name


@pytest.fixture(scope="module")
def scenes():
    return [build(31, index) for index in range(24)]


def standing(scene):
    """Kind and bounds of what takes up room: all but rugs and what lies on something."""
    for number in scene.furniture:
        thing = scene.world.things[number - 1]
        if KINDS[thing.kind]["at"] not in ("flat", "top"):
            yield thing.kind, *bounds(thing.parts)


def test_furniture_shares_no_space_and_stays_between_floor_ceiling_and_walls(scenes):
    for scene in scenes:
        boxes, inside = list(standing(scene)), np.array(scene.floor)[:, [1, 3]].max(axis=0)
        for k, (name, low, high) in enumerate(boxes):
            where = (scene.name, name)
            for other, low2, high2 in boxes[:k]:
                shared = np.minimum(high, high2) - np.maximum(low, low2)
                assert (shared < 0.03).any(), (*where, other)
            on_floor = KINDS[name]["at"] in ("wall", "corner", "free", "around")
            assert -2e-3 < low[2] < (2e-3 if on_floor else 99), where
            assert high[2] < scene.height + 1.0, where  # a banister reaches into the storey above
            middle = (low + high)[:2] / 2
            if (middle > -THICK).all() and (middle < inside + THICK).all():  # not in a room beyond
                assert (low[:2] > -0.01).all(), where
                assert (high[:2] < inside + 0.01).all(), where


def test_no_camera_stands_in_a_solid_or_close_to_a_surface(scenes):
    for index, scene in enumerate(scenes[:12]):
        lens = Settings(31, height=48, width=64).lens(index)
        for poses in scene.cameras(4, lens).values():
            for pose in poses:
                turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
                rays = np.stack([np.cos(turn), np.sin(turn), 0.3 * np.sin(5 * turn)], 1)
                rays = (rays / np.linalg.norm(rays, axis=1, keepdims=True)).astype(np.float32)
                start = np.tile(pose.position.astype(np.float32), (24, 1))
                hits = scene.world.tracer.nearest(start, rays)
                met = hits.triangle >= 0
                facing = (scene.world.normals[hits.triangle[met]] * rays[met]).sum(axis=1)
                assert (facing > 0).mean() <= 0.1, scene.name
                assert hits.distance[met].min() > 0.1, scene.name


def test_rooms_come_in_all_kinds_also_as_an_l_with_slopes_and_passages():
    drawn = [
        build_shell(household(np.random.default_rng(seed)), ROOMS["attic"]) for seed in range(40)
    ]
    assert any(len(shell.floor) == 2 for shell in drawn)
    assert any(shell.beyond for shell in drawn)
    assert any(not shell.day for shell in drawn)
    sloping = [shell for shell in drawn if shell.eaves]
    assert len(sloping) > 20
    for shell in sloping:
        way, _, _ = shell.eaves[0]
        edge = shell.depth if way > 0 else 0.0
        area = (1.0, 2.0, edge - 0.2, edge) if way > 0 else (1.0, 2.0, 0.0, 0.2)
        assert 0.8 < shell.headroom(area) < 2.0


def test_patterns_mix_two_colours_and_fade_with_distance():
    points = np.random.default_rng(3).uniform(-2, 2, (4000, 3)).astype(np.float32)
    up, number = np.tile(np.array([0, 0, 1], np.float32), (4000, 1)), np.zeros(4000, int)
    for name in PATTERNS:
        palette = Palette([Material((0.2, 0.2, 0.2), (0.6, 0.6, 0.6), name, 0.2)])
        near, far = (
            palette.albedo(number, points, up, np.full(4000, pixel, np.float32))[:, 0]
            for pixel in (0.0, 1.0)
        )
        assert 0.2 - 1e-6 <= near.min() <= near.max() <= 0.6 + 1e-6
        assert np.ptp(far) < 1e-6
        assert (np.ptp(near) > 0.2) == (name != "plain")
        assert far[0] == pytest.approx(palette.mean[0, 0])
