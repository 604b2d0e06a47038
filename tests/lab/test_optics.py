"""Air, spot, returned light, speckle and losses."""

from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose
from pytest import approx

from cmtof.correlation import TAU
from cmtof_lab.optics import (
    returned_fractions,
    speckle_cells,
    trace,
    uniform_from_places,
)
from cmtof_lab.settings import TwinSettings
from cmtof_lab.targets import Plane, RayEnds

REAL = TwinSettings()


def returned(z, cosine=1.0, mirrored=0.0):
    """Share that returns from ranges, m."""
    hits = RayEnds(np.asarray(z), np.array(cosine), np.array(0.5), mirrored)
    return sum(returned_fractions(REAL, hits))


def test_diffuse_light_falls_with_the_square_of_the_range():
    area = np.pi * REAL.aperture**2 / 4
    expected = 0.5 * 0.8 * area / (TAU * np.array([1, 4]))
    assert_allclose(returned([1.0, 2.0], cosine=0.8), expected)


def test_a_mirror_returns_more_and_turns_away():
    straight, tilted = (
        returned(1.0, np.cos(t), mirrored=1.0) for t in (0.0, np.deg2rad(1))
    )
    paper = returned(1.0)
    assert straight > 1e3 * paper
    assert tilted == approx(0.02 * paper, rel=1e-2)
    assert returned(1.0, mirrored=0.3) == approx(0.7 * paper + 0.3 * straight)


def test_speckle_has_its_mean_and_contrast(rng):
    angles = rng.uniform(-0.05, 0.05, (20000, 2))
    rough = trace(Plane(1.0), angles, REAL, seed=5).fraction.sum(1)
    plain = replace(REAL, speckle=False)
    relative = rough / trace(Plane(1.0), angles, plain, seed=5).fraction.sum(1)
    cells = speckle_cells(REAL, 1.0)
    assert relative.mean() == approx(1, abs=4 / np.sqrt(20000 * cells))
    assert relative.std() == approx(1 / np.sqrt(cells), rel=0.05)


def test_numbers_of_places_depend_on_the_place_alone():
    places = np.indices((100, 100)).reshape(2, -1).T
    numbers = uniform_from_places(1, places, 3)
    assert np.array_equal(numbers[::-1], uniform_from_places(1, places[::-1], 3))
    assert numbers.mean() == approx(0.5, abs=0.01)
    assert np.corrcoef(numbers.T)[0, 1] == approx(0, abs=0.03)
