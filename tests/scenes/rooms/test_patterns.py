import numpy as np
import pytest

from cmtof.scenes.rooms.materials import PATTERNS
from cmtof.scenes.rooms.patterns import lattice, pattern, turbulence, value_noise

RNG = np.random.default_rng(0)
PLACES = RNG.uniform(-30, 30, (400, 3))


def sampled(name, shift=(0.0, 0.0, 0.0)):
    kind = PATTERNS.index(name)
    moved = PLACES + shift
    return np.array([pattern(kind, x, y, z, x, y) for x, y, z in moved])


@pytest.mark.parametrize("name", PATTERNS)
def test_mixes_lie_between_the_colours_and_tints_are_positive(name):
    values = sampled(name)
    assert np.isfinite(values).all()
    assert 0 <= values[:, 0].min() <= values[:, 0].max() <= 1
    assert 0 < values[:, 1:].min() <= values[:, 1:].max() < 2


@pytest.mark.parametrize("name", [n for n in PATTERNS if n != "plain"])
def test_every_pattern_but_the_plain_one_varies(name):
    assert np.ptp(sampled(name), axis=0).max() > 0.1


@pytest.mark.parametrize("name", ["checks", "dots"])
def test_regular_patterns_repeat(name):
    assert sampled(name, shift=(2.0, 2.0, 0.0)) == pytest.approx(sampled(name))


def test_lattice_values_are_uniform_and_unlike_their_neighbours():
    values = np.array([lattice(i, j, 3) for i in range(60) for j in range(60)]).reshape(60, 60)
    assert values.mean() == pytest.approx(0.5, abs=4 / np.sqrt(12 * 3600))
    assert values.std() == pytest.approx(1 / np.sqrt(12), abs=0.01)
    assert abs(np.corrcoef(values[1:].ravel(), values[:-1].ravel())[0, 1]) < 4 / 60


def test_noise_is_continuous_and_passes_through_the_lattice():
    for x, y, z in PLACES[:50]:
        near = value_noise(x + 1e-5, y, z)
        assert value_noise(x, y, z) == pytest.approx(near, abs=1e-4)
        assert 0 <= turbulence(x, y, z) <= 1
    assert value_noise(4.0, -7.0, 2.0) == pytest.approx(lattice(4, -7, 2))
