"""Pictures and other things on walls: frames are closed, backs touch the wall."""

import numpy as np
import pytest
from furnishing import assert_repeatable, draw

from cmtof.scenes.rooms import wall_art, wall_things
from cmtof.scenes.rooms.thing import Thing

ALL = {**wall_art.CATALOGUE, **wall_things.CATALOGUE}


def made(name: str, seed: int, **options) -> Thing:
    return draw(ALL[name], seed, **options)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("name", ALL)
def test_its_back_touches_the_wall(check_thing, name, seed):
    check_thing(made(name, seed), standing="wall")


@pytest.mark.parametrize("name", wall_art.CATALOGUE)
def test_flat_things_are_flat_and_hang_about_their_centre(name):
    for seed in range(12):
        low, high = made(name, seed).bounds
        assert high[1] - low[1] < 0.09
        assert abs(low[0] + high[0]) < 0.02
        assert abs(low[2] + high[2]) < 0.35


@pytest.mark.parametrize("name", ALL)
def test_same_seed_same_thing_and_another_seed_another(name):
    assert_repeatable(ALL[name])


@pytest.mark.parametrize("width", [0.4, 1.0])
def test_a_painting_is_as_wide_as_asked(width):
    for seed in range(12):
        low, high = made("painting", seed, width=width).bounds
        assert high[0] - low[0] == pytest.approx(width, abs=1e-3)


def test_a_frame_leaves_its_opening_free_and_looks_to_the_room():
    mesh = wall_art.frame(0.6, 0.4, [(0.05, 0.0), (0.05, 0.03), (0.0, 0.03), (0.0, 0.0)])
    x, _, z = np.abs(mesh.vertices).T
    assert ((x >= 0.3 - 1e-6) | (z >= 0.2 - 1e-6)).all()
    corners = mesh.vertices[mesh.faces].astype(float)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    front = np.abs(normal[:, 1]) > 0.9 * np.linalg.norm(normal, axis=1)
    assert (normal[front, 1] < 0).all()


def test_a_mirror_mirrors():
    for seed in range(12):
        silver = [p for p in made("mirror", seed).parts if p.material.specular > 0.9]
        assert len(silver) >= 1
        assert silver[0].material.gloss == 3000


def test_the_frames_of_a_group_do_not_overlap():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        spots = np.array(wall_art._salon(rng, 7))
        for k, (x, z, w, h) in enumerate(spots):
            for u, v, a, b in spots[:k]:
                assert abs(x - u) > (w + a) / 2 or abs(z - v) > (h + b) / 2
