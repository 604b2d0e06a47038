import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cmtof.scenes.rooms import solids
from cmtof.scenes.rooms.house import WallRun as Wall
from cmtof.scenes.rooms.house import facing
from cmtof.scenes.rooms.materials import Material
from cmtof.scenes.rooms.placing import Floor, fill_support, footprint, overlap
from cmtof.scenes.rooms.thing import Support, Thing, pose, transformed

WHITE = Material((0.8, 0.8, 0.8))


def crate(width, depth, height, kind="crate"):
    return Thing(kind).add(solids.box((width, depth, height), (0, 0, height / 2)), WHITE)


def empty_floor(seed=0, blocked=()):
    walls = [
        Wall((0, 0), (5, 0), 2.5, tuple(blocked)),
        Wall((5, 0), (5, 4), 2.5),
        Wall((5, 4), (0, 4), 2.5),
        Wall((0, 4), (0, 0), 2.5),
    ]
    return Floor([(0, 5, 0, 4)], walls, 2.5, np.random.default_rng(seed))


@given(st.floats(-3.1, 3.1))
def test_the_front_looks_where_it_is_told(angle):
    direction = np.array([np.cos(angle), np.sin(angle)])
    front = transformed([0.0, -1.0, 0.0], pose(turn=facing(direction)))
    assert front[:2] == pytest.approx(direction, abs=1e-9)


@given(st.integers(0, 50))
@settings(max_examples=20)
def test_things_against_walls_touch_none_and_look_into_the_room(seed):
    floor = empty_floor(seed)
    for _ in range(12):
        floor.against_wall(crate(1.0, 0.5, 0.8))
    assert len(floor.placed) >= 6
    for a, b in itertools.combinations(floor.taken, 2):
        assert not overlap(a, b)
    for thing, motion in floor.placed:
        x0, x1, y0, y1 = footprint(thing, motion)
        assert min(x0, y0) >= 0 and x1 <= 5 and y1 <= 4
        front = transformed([0.0, -0.6, 0.0], motion)[:2]
        assert np.linalg.norm(front - [2.5, 2.0]) < np.linalg.norm(motion[:2, 3] - [2.5, 2.0])


def test_a_door_is_kept_free_and_a_window_lets_low_things_stand_below():
    door = empty_floor(blocked=[(0.0, 5.0, 0.0)])
    door.walls = door.walls[:1]
    assert door.against_wall(crate(1, 0.5, 0.3)) is None
    window = empty_floor(blocked=[(0.0, 5.0, 0.9)])
    window.walls = window.walls[:1]
    assert window.against_wall(crate(1, 0.5, 1.2)) is None
    assert window.against_wall(crate(1, 0.5, 0.8)) is not None


def test_pictures_hang_above_low_furniture_and_never_on_tall():
    picture = Thing("painting").add(solids.box((0.6, 0.03, 0.4), (0, -0.015, 0)), WHITE)
    floor = empty_floor()
    floor.walls = [Wall((0, 0), (1.2, 0), 2.5)]
    floor.rectangles = [(0, 1.2, 0, 4)]
    assert floor.against_wall(crate(1.0, 0.5, 2.0), where=0.5) is not None
    assert not floor.on_wall(picture, 1.6)
    floor.hung.clear()
    floor.hung.append((0, 0.0, 1.2, 0.0, 0.9))
    assert floor.on_wall(picture, 1.6)
    _, motion = floor.placed[-1]
    assert motion[1, 3] == pytest.approx(0.002)
    assert motion[2, 3] == 1.6


def test_what_is_put_in_the_open_keeps_its_distance():
    floor = empty_floor(3)
    for _ in range(8):
        floor.somewhere(crate(0.6, 0.6, 0.5), gap=0.3)
    for a, b in itertools.combinations(floor.taken, 2):
        assert not overlap(a, b, gap=0.29)


@given(st.integers(0, 30))
@settings(max_examples=15)
def test_clutter_rests_on_its_support_within_edges_and_apart(seed):
    rng = np.random.default_rng(seed)
    support = Support(-0.5, 0.5, -0.2, 0.2, 0.75, clearance=0.25)

    def draw():
        return crate(*rng.uniform(0.03, 0.3, 2), rng.uniform(0.05, 0.4))

    resting = fill_support(support, draw, rng, most=12)
    assert resting
    areas = [footprint(thing, motion) for thing, motion in resting]
    for x0, x1, y0, y1 in areas:
        assert x0 >= -0.5 - 1e-9 and x1 <= 0.5 + 1e-9
        assert y0 >= -0.2 - 1e-9 and y1 <= 0.2 + 1e-9
    for a, b in itertools.combinations(areas, 2):
        assert not overlap(a, b)
    for thing, motion in resting:
        assert thing.bounds[1, 2] <= support.clearance
        assert motion[2, 3] == pytest.approx(0.75, abs=1e-3)
