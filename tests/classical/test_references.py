"""References and trivial answers: what they use, what they find, how often they are right."""

import numpy as np
from numpy.testing import assert_array_equal
from pytest import approx, fixture, mark
from scores import scores
from walls import WRAP, flat_wall, lit

import cmtof
from cmtof import bounds
from cmtof.classical import references, trivial
from cmtof.classical.references import bodies, surfaces
from cmtof.correlation import TAU
from cmtof.frame import Frame
from cmtof.hardness import bends
from cmtof.simulation import simulate


@fixture
def bent():
    """A bent wall with a box in front of it, m."""
    x, y = np.meshgrid(np.linspace(-1, 1, 60), np.linspace(-1, 1, 50))
    depth = 3 + 0.2 * x + 0.1 * y**2
    depth[15:35, 20:40] -= 0.5
    return depth


def test_surfaces_end_at_steps_and_not_at_slopes(bent):
    boundary = bends(bent)
    assert len(np.unique(surfaces(bent)[~boundary])) == 2
    edge = np.zeros_like(boundary)
    edge[15:35, [19, 20, 39, 40]] = True
    edge[[14, 15, 34, 35], 20:40] = True
    assert_array_equal(boundary, edge)


def creased(side, row, slope):
    """A square wall at 3 m and, from a row on, a floor that comes nearer, m a pixel."""
    rows, _ = np.indices((side, side))
    return 3.0 - slope * np.maximum(rows - row, 0)


def test_bodies_end_at_jumps_and_not_at_creases():
    """A floor and a wall are one body, a box that hides part of the wall another."""
    room = creased(50, 19, 0.02)
    room[5:12, 20:30] = 2.0
    room[0, 0] = np.nan
    number = bodies(room)
    assert number[2, 2] == number[49, 49] != number[8, 25]
    assert np.unique(number).size == 3  # the unknown pixel is alone
    assert np.unique(surfaces(room)).size > 3


@mark.parametrize("offsets", [(0.0, 0.0), (0.0123, 0.517)])
@mark.parametrize("what", ["offset", "contact", "field"])
def test_shapes_are_known_and_places_are_not(exact, bent, what, offsets):
    """Exact without noise; an offset of a whole surface's truth changes nothing."""
    number = surfaces(bent)
    inside = ~bends(bent)
    truth = bent + np.where(number == number[0, 0], *offsets)
    estimate = getattr(references, f"reference_{what}")(exact(bent, depth=truth))
    assert abs(estimate.depth - bent)[inside].max() < 1e-6
    assert np.median(estimate.confidence[inside]) > 0.99


def test_contact_carries_an_offset_across_a_crease():
    """A small dark facet is placed by the bright wall that it touches."""
    depth = creased(120, 99, 0.01)
    light = np.where(depth == 3.0, 1.0, 0.05)
    m = simulate(Frame(depth, light), protocol="full", seed=1)
    methods = (references.reference_contact, references.reference_offset)
    tied, alone = (abs(run(m).depth - depth)[105:].max() for run in methods)
    assert tied < 0.01 < alone


def test_wider_windows_are_right_more_often():
    m = simulate(flat_wall(90, 3.0), protocol="full")
    rates = [
        scores(m, method="reference-field", side=side)["delta_lt_2"]
        for side in (1, 11, 41, 181)
    ]
    assert rates == sorted(rates)
    assert rates[-1] == 1.0


def test_true_depth_brings_the_phase_within_half_a_wrap():
    m = simulate(flat_wall(300, 4.0), protocol="full")
    depth = cmtof.unwrap(m, method="reference-depth").depth
    assert abs(depth - 4.0).max() < WRAP / 2
    noise = bounds.phase_spread(bounds.simulated_phase_noise(1.0))
    assert depth.std() == approx(noise * WRAP / TAU, rel=0.02)


@fixture(scope="module")
def even():
    """A measurement of depths that lie evenly over 21 wraps."""
    return simulate(
        lit(np.random.default_rng(4).uniform(36 * WRAP, 57 * WRAP, (300, 300)))
    )


def test_a_random_wrap_is_right_once_and_the_middle_within_two_five_times_in_21(even):
    assert scores(even, method="uniform")["delta_lt_1"] == approx(1 / 21, abs=0.005)
    assert scores(even, method="middle")["delta_lt_3"] == approx(5 / 21, abs=0.01)


def test_the_mode_is_right_as_often_as_its_share(even):
    share = trivial.mode(even).confidence[0, 0]
    assert scores(even, method="mode")["delta_lt_1"] == approx(share, abs=1e-3)


def test_every_frame_has_random_wraps_of_its_own(even):
    other = cmtof.Measurement(even.dataset.assign_attrs(frame_number=1))
    assert (trivial.uniform(even).depth != trivial.uniform(other).depth).mean() > 0.9
