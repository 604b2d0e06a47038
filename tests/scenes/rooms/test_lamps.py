"""Lamps: standing, hanging and on walls; their light gets out of their shades."""

import numpy as np
import pytest
from furnishing import assert_repeatable, draw

from cmtof.scenes.rooms import hanging_lamps, lamps, wall_lamps
from cmtof.scenes.rooms.solids import joined
from cmtof.scenes.rooms.thing import Light, Thing

STANDING = lamps.CATALOGUE
HANGING = hanging_lamps.CATALOGUE
ON_WALLS = wall_lamps.CATALOGUE
ALL = {**STANDING, **HANGING, **ON_WALLS}
SEEDS = range(8)


def made(name: str, seed: int, **options) -> Thing:
    return draw(ALL[name], seed, **options)


def escaping(thing: Thing, light: Light, rays: int = 3000) -> float:
    """Share of what a light sends that leaves the lamp."""
    import trimesh

    rng = np.random.default_rng(0)
    whole = joined([part.mesh for part in thing.parts])
    body = trimesh.Trimesh(whole.vertices, whole.faces, process=False)
    a, b = rng.uniform(-1, 1, (2, rays, 1))
    start = np.array(light.centre) + a * np.array(light.half_u) + b * np.array(light.half_v)
    way = rng.normal(size=(rays, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    if np.any(light.normal):
        way *= np.sign(way @ np.array(light.normal))[:, None]
    return 1 - float(body.ray.intersects_any(start, way).mean())


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", STANDING)
def test_a_standing_lamp_stands(check_thing, name, seed):
    check_thing(made(name, seed))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", HANGING)
def test_a_ceiling_lamp_hangs_from_the_ceiling(check_thing, name, seed):
    check_thing(made(name, seed), standing="ceiling")


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", ON_WALLS)
def test_a_wall_lamp_touches_the_wall(check_thing, name, seed):
    check_thing(made(name, seed), standing="wall")


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("floor_lamp", 1.1, 2.1),
        ("table_lamp", 0.2, 0.75),
        ("desk_lamp", 0.3, 0.75),
        ("ceiling_lamp", 0.03, 0.3),
        ("chandelier", 0.5, 1.3),
    ],
)
def test_lamps_have_the_height_of_real_ones(name, low, high):
    for seed in range(20):
        bounds = made(name, seed).bounds
        assert low < bounds[1, 2] - bounds[0, 2] < high


@pytest.mark.parametrize("name", ALL)
def test_every_lamp_shines_and_something_of_it_glows(name):
    for seed in range(12):
        thing = made(name, seed)
        assert thing.lights
        assert 0.05 < sum(light.power for light in thing.lights) < 3.5
        assert max(part.material.emission for part in thing.parts) >= 0.5


@pytest.mark.parametrize("name", ALL)
def test_light_leaves_the_lamp(name):
    for seed in range(12):
        thing = made(name, seed)
        out = [escaping(thing, light) for light in thing.lights]
        assert min(out) > 0.12, f"{name} {seed}: {out}"


@pytest.mark.parametrize("drop", [0.6, 0.9, 1.4])
def test_a_pendant_ends_where_it_is_told(drop):
    for seed in range(20):
        assert made("pendant", seed, drop=drop).bounds[0, 2] == pytest.approx(-drop, abs=0.03)


@pytest.mark.parametrize("name", ALL)
def test_same_seed_same_lamp_and_another_seed_another(name):
    assert_repeatable(ALL[name])


def test_a_tilted_head_keeps_its_shape():
    thing = Thing("head")
    lamps.shade(thing, [(0.1, 0.0), (0.05, 0.1)], lamps.BLACK, axis=(0, 0, -1))
    low, high = thing.bounds
    assert low[2] == pytest.approx(-0.1, abs=3e-3)
    assert high[0] == pytest.approx(0.1, abs=3e-3)
