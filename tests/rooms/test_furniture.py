"""Furniture: it fills its size, stands on the floor, and nothing stands in anything."""

from functools import partial
from itertools import combinations

import numpy as np
from pytest import approx, fixture, mark
from vectors import unit

from cmtof.correlation import TAU
from cmtof_rooms.boxes import Box
from cmtof_rooms.building import build_shell
from cmtof_rooms.kit import household
from cmtof_rooms.makers import MAKERS
from cmtof_rooms.materials import PATTERNS, Material, Palette
from cmtof_rooms.presets import presets
from cmtof_rooms.rendering import Settings
from cmtof_rooms.rooms import build_room
from cmtof_rooms.shell import THICKNESS
from cmtof_rooms.things import Light, Thing

KINDS = presets()["kinds"]
ROOMS = presets()["rooms"]
SEED = 31


def test_kinds_are_those_that_rooms_and_other_kinds_name():
    used = set().union(*(room["things"] for room in ROOMS.values()))
    for kind in KINDS.values():
        used.update(kind.get("upon", ()), kind.get("around", ()))
    assert used == set(KINDS)
    assert len(KINDS) >= 60


def test_kinds_have_no_unknown_key():
    known = {"maker", "at", "size", "clear", "make", "around", "upon", "over"}
    assert set().union(*KINDS.values()) == known


def test_every_maker_and_every_pattern_is_used():
    assert {kind["maker"] for kind in KINDS.values()} == set(MAKERS)
    patterns = {
        name for role in presets()["materials"].values() for name in role["patterns"]
    }
    assert patterns == {"plain", *PATTERNS}


@mark.parametrize("name", KINDS)
def test_a_kind_is_closed_and_stays_within_its_size(name, rng):
    kind = KINDS[name]
    kit = household(rng)
    size = np.array([kit.between(*limits) for limits in kind["size"]])
    made = [*MAKERS[kind["maker"]](kit, Box.standing(size), **kind.get("make", {}))]
    free = [one for one in made if isinstance(one, Box)]
    parts = [kit.part(*one) for one in made if not isinstance(one, Box | Light)]
    assert all(part.mesh.is_volume for part in parts)
    low, high = Thing(name, parts).bounds
    # handles, worktops and banisters reach a little further
    beyond = np.array([0.03, 0.04, 1.0 if kind["maker"] == "stairs" else 0.04])
    assert (low[:2] >= (-size / 2 - beyond)[:2] - 1e-3).all()
    assert (high <= size * [0.5, 0.5, 1] + beyond).all()
    assert abs(low[2]) < 2e-3
    assert all(space.z0 <= high[2] + 2e-3 for space in free)


@fixture(scope="module", params=range(24))
def room(request):
    return build_room(SEED, request.param)


def standing(room):
    """Kind and bounds of what takes up space: all but rugs and what lies on something."""
    return [
        (thing.kind, *thing.bounds)
        for thing in room.furniture
        if KINDS[thing.kind]["at"] not in ("flat", "top")
    ]


def test_furniture_shares_no_space(room):
    for (one, low, high), (other, low2, high2) in combinations(standing(room), 2):
        shared = np.minimum(high, high2) - np.maximum(low, low2)
        assert (shared < 0.03).any(), (one, other)


def test_furniture_stays_between_floor_ceiling_and_walls(room):
    corner = np.max([piece.high for piece in room.floor], axis=0)
    for name, low, high in standing(room):
        on_floor = KINDS[name]["at"] in ("wall", "corner", "free", "around")
        assert -2e-3 < low[2] < (2e-3 if on_floor else 99), name
        # a banister reaches into the storey above
        assert high[2] < corner[2] + 1.0, name
        middle = (low + high) / 2
        outside = np.maximum(-middle, middle - corner)
        if (outside < THICKNESS).all():
            assert (low > -0.01).all(), name
            assert (high < corner + 0.01)[:2].all(), name


def test_no_camera_stands_in_a_solid_or_close_to_a_surface(room):
    turn = np.linspace(0, TAU, 24, endpoint=False)
    tilt = 0.3 * np.sin(5 * turn)
    rays = unit(np.column_stack([np.cos(turn), np.sin(turn), tilt])).astype(np.float32)
    poses = room.cameras(4, Settings(SEED, height=48, width=64).lens(room.index))
    for pose in poses["cam_00"] + poses["cam_01"]:
        hits = room.interior.tracer.nearest(np.full_like(rays, pose.position), rays)
        met = hits.triangle >= 0
        facing = np.vecdot(room.interior.normals[hits.triangle[met]], rays[met])
        assert (facing > 0).mean() <= 0.1
        assert hits.distance[met].min() > 0.1


@fixture(scope="module")
def attics():
    kits = map(household, map(np.random.default_rng, range(40)))
    return [build_shell(kit, ROOMS["attic"]) for kit in kits]


def test_rooms_come_also_as_an_l_with_passages_and_by_night(attics):
    assert any(len(shell.floor) == 2 for shell in attics)
    assert any(shell.beyond for shell in attics)
    assert not all(shell.day for shell in attics)


def test_headroom_is_low_below_a_slope(attics):
    sloping = [shell for shell in attics if shell.eaves]
    assert len(sloping) > 20
    for shell in sloping:
        start = shell.depth - 0.2 if shell.eaves[0][0] > 0 else 0.0
        strip = Box(1.0, 2.0, start, start + 0.2, 0.0, 1.0)
        assert 0.8 < shell.headroom(strip) < 2.0


@mark.parametrize("pattern", ["plain", *PATTERNS])
def test_a_pattern_mixes_two_colours_and_fades_with_distance(pattern, rng):
    palette = Palette([Material((0.2,) * 3, (0.6,) * 3, pattern, 0.2)])
    points = rng.uniform(-2, 2, (4000, 3)).astype(np.float32)
    up = np.full_like(points, [0, 0, 1])
    look = partial(palette.albedo, np.zeros(4000, int), points, up)
    near = look(np.zeros(4000, np.float32))[:, 0]
    far = look(np.ones(4000, np.float32))[:, 0]
    assert 0.2 - 1e-6 <= near.min() <= near.max() <= 0.6 + 1e-6
    assert (np.ptp(near) > 0.2) == (pattern != "plain")
    assert np.ptp(far) < 1e-6
    assert far[0] == approx(palette.mean[0, 0])
