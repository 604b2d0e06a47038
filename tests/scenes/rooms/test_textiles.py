"""Cloth: rugs lie, tablecloths cover, blankets hang over edges, pillows are filled."""

import numpy as np
import pytest
from furnishing import assert_repeatable, closed_volumes, draw

from cmtof.scenes.rooms import hangings, padding, textiles
from cmtof.scenes.rooms.materials import Material
from cmtof.scenes.rooms.pliant import grid, loft, ripples, slab
from cmtof.scenes.rooms.thing import Mesh, Thing

ALL = {**textiles.CATALOGUE, **hangings.CATALOGUE, **padding.CATALOGUE}
LIES = (
    "rug", "doormat", "crumpled_cloth", "laundry_pile", "folded_towels",
    "cushion_pillow", "beanbag", "pouf",
)  # fmt: skip
HANGS = tuple(hangings.CATALOGUE)


def made(name: str, seed: int, **options) -> Thing:
    return draw(ALL[name], seed, **options)


def volume(mesh: Mesh) -> float:
    """Of one mesh, which must be closed."""
    (found,) = closed_volumes(Thing("mesh").add(mesh, Material((1, 1, 1))))
    return found


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("name", LIES)
def test_what_lies_lies_on_the_floor(check_thing, name, seed):
    check_thing(made(name, seed))


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("name", HANGS)
def test_what_hangs_touches_the_wall(check_thing, name, seed):
    check_thing(made(name, seed), standing="wall")


@pytest.mark.parametrize("name", ALL)
def test_same_seed_same_cloth_and_another_seed_another(name):
    assert_repeatable(ALL[name])


@pytest.mark.parametrize("seed", range(8))
def test_a_rug_is_thin_and_as_large_as_asked(seed):
    thing = made("rug", seed, width=1.5, length=2.0)
    size = thing.bounds[1] - thing.bounds[0]
    assert size[2] < 0.022
    assert 1.45 < size[1] < 1.55
    assert 1.45 < size[0] < 2.2  # fringes; a round one takes its width


@pytest.mark.parametrize("seed", range(8))
def test_a_tablecloth_covers_its_table_and_leaves_room_for_it(seed):
    thing = made("tablecloth", seed, length=1.4, width=0.8, drop=0.25)
    points = np.concatenate([part.mesh.vertices for part in thing.parts])
    assert points[:, 2].max() == pytest.approx(0.0025, abs=1e-4)
    assert -0.36 < points[:, 2].min() < -0.25
    below = points[points[:, 2] < -0.01]
    outside = (np.abs(below[:, 0]) > 0.7) | (np.abs(below[:, 1]) > 0.4)
    assert outside.all()  # no hanging part within the table


@pytest.mark.parametrize("seed", range(8))
def test_a_blanket_lies_on_the_level_and_hangs_beyond_its_edge(seed):
    thing = made("throw_blanket", seed, width=0.8, length=0.6, hang=0.3)
    points = thing.parts[0].mesh.vertices
    assert points[:, 2].min() == pytest.approx(-0.3, abs=0.05)
    lying = points[points[:, 1] > -0.27]
    assert lying[:, 2].min() > -0.006
    assert (points[points[:, 2] < -0.05][:, 1] < -0.28).all()


def test_a_blanket_that_only_lies_has_no_hanging_side():
    assert made("throw_blanket", 1, hang=0.0).bounds[0, 2] > -0.006


@pytest.mark.parametrize("seed", range(8))
def test_a_leaning_pillow_stands_on_its_edge(seed):
    thing = made("cushion_pillow", seed, lean=1.2)
    flat = made("cushion_pillow", seed)
    assert thing.bounds[0, 2] == pytest.approx(0, abs=1e-3)
    assert thing.bounds[1, 2] >= flat.bounds[1, 2] - 0.06


def test_a_slab_holds_its_area_times_its_thickness():
    x, y = grid(0, 2, 0, 3, 4, 5)
    assert volume(slab(np.stack([x, y, 0 * x], -1), 0.1)) == pytest.approx(0.6, rel=1e-5)


def test_a_loft_of_two_squares_is_a_box():
    square = np.array([(0, -1, -1), (0, 1, -1), (0, 1, 1), (0, -1, 1)], float) / 2
    assert volume(loft(np.stack([square, square + np.array([2, 0, 0])]))) == pytest.approx(
        2, rel=1e-5
    )


def test_ripples_stay_of_order_one_about_zero():
    x, y = grid(-5, 5, -5, 5, 200, 200)
    field = ripples(np.random.default_rng(0), x, y, 8, 0.5)
    assert abs(field.mean()) < 0.05
    assert 0.3 < field.std() < 0.7


@pytest.mark.parametrize("name", ["rug", "doormat", "throw_blanket", "pouf", "flag"])
def test_closed_cloth_has_its_outside_out(name):
    for seed in range(6):
        volumes = closed_volumes(made(name, seed))
        assert volumes
        assert min(volumes) > 0
