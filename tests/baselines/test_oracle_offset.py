"""True surfaces, one offset each."""

import numpy as np
import pytest

import cmtof
from cmtof.baselines.oracle_offset import bodies, oracle_contact, oracle_offset, surfaces
from cmtof.constants import FREQUENCIES
from cmtof.correlation import phase_from_depth
from cmtof.measurement import Measurement
from cmtof.scenes.frame import Frame
from cmtof.simulation import simulate


def exact(depth, truth=None, **attributes):
    """Phases of known depths without noise; another truth may be claimed."""
    depth = np.atleast_2d(np.asarray(depth, float))
    phase = np.stack([phase_from_depth(depth, f) for f in FREQUENCIES])
    truth = depth if truth is None else truth
    return Measurement.from_phase(phase, FREQUENCIES, depth=truth, **attributes)


@pytest.fixture
def bent(rng):
    """A bent wall with a box in front of it, m."""
    x, y = np.meshgrid(np.linspace(-1, 1, 60), np.linspace(-1, 1, 50))
    depth = 3 + 0.2 * x + 0.1 * y**2
    depth[15:35, 20:40] -= 0.5
    return depth


def test_surfaces_are_cut_at_steps_and_not_at_slopes(bent):
    number, boundary = surfaces(bent)
    assert len(np.unique(number[~boundary])) == 2
    assert number[0, 0] == number[-1, -1] != number[25, 30]
    edge = np.zeros_like(boundary)
    edge[15:35, [19, 20, 39, 40]] = True
    edge[[14, 15, 34, 35], 20:40] = True
    np.testing.assert_array_equal(boundary, edge)
    assert np.unique(number).size == 2 + boundary.sum()


def test_unknown_depth_belongs_to_no_surface(bent):
    bent[:, 50] = np.nan
    number, boundary = surfaces(bent)
    assert boundary[:, 49:52].all()
    assert number[0, 0] != number[0, -1]
    estimate = oracle_offset(exact(np.nan_to_num(bent, nan=1.0), truth=bent))
    assert np.isfinite(estimate.depth).all()
    assert not estimate.confidence[:, 50].any()


def test_exact_without_noise_everywhere(bent):
    estimate = oracle_offset(exact(bent))
    assert np.abs(estimate.depth - bent).max() < 1e-8
    _, boundary = surfaces(bent)
    assert estimate.confidence[~boundary].min() > 0.999


def test_where_a_surface_lies_is_not_read_from_the_truth(bent):
    """Any offset of a whole surface's truth, not only whole wraps, changes nothing."""
    number, boundary = surfaces(bent)
    moved = bent + np.where(number == number[0, 0], 0.0123, 0.517)
    estimate = oracle_offset(exact(bent, truth=moved))
    assert np.abs(estimate.depth - bent)[~boundary].max() < 1e-8


def test_noise_that_one_pixel_cannot_bear_is_pooled_away():
    x = np.linspace(0, 1, 200)
    frame = Frame(2 + 0.3 * x[None, :] + 0.2 * x[:, None] ** 2, np.ones((200, 200)))
    m = simulate(frame, protocol="full", seed=5)
    estimate = oracle_offset(m)
    assert np.abs(estimate.depth - m.depth).max() < 1e-4
    assert estimate.confidence.min() > 0.95


def test_boundaries_are_left_alone_or_given_to_their_neighbours(rng):
    x = np.arange(120)
    depth = np.broadcast_to(2 + np.where(x < 60, 0, 1), (120, 120)).astype(float)
    m = simulate(Frame(depth, np.ones_like(depth)), protocol="full", seed=2)
    _, boundary = surfaces(m.depth.astype(float))
    alone, given = (np.abs(oracle_offset(m, extend=e).depth - depth) for e in (False, True))
    assert np.mean(alone[boundary] < 0.01) < 0.2
    assert given[boundary].max() < 0.01


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (7, 1), (2, 2)])
@pytest.mark.parametrize("valid", [True, False])
@pytest.mark.parametrize("amplitude", [0.0, 1.0])
def test_any_size_darkness_and_mask(shape, valid, amplitude):
    m = exact(
        np.full(shape, 1.0), mask=np.full(shape, valid), amplitude=np.full((2, *shape), amplitude)
    )
    estimate = oracle_offset(m, extend=True)
    assert np.isfinite(estimate.depth).all()
    assert ((estimate.confidence >= 0) & (estimate.confidence <= 1)).all()
    if valid and amplitude:
        assert np.abs(estimate.depth - 1.0).max() < 1e-8


def test_all_boundary_is_single_pixels(rng):
    depth = rng.uniform(1, 3, (8, 8))
    for extend in (False, True):
        inner = oracle_offset(exact(depth), extend=extend).depth[1:-1, 1:-1]
        assert inner.shape == (6, 6)
        assert np.isfinite(inner).all()


def test_needs_the_truth_and_a_step():
    m = exact(np.full((4, 4), 1.0))
    with pytest.raises(ValueError, match="step > 0"):
        cmtof.unwrap(m, method="oracle-offset", step=0.0)
    blind = Measurement(m.dataset.drop_vars("depth"))
    with pytest.raises(ValueError, match="true depth for method oracle-offset"):
        cmtof.unwrap(blind, method="oracle-offset")


def test_bodies_end_at_jumps_and_not_at_creases():
    """A floor and a wall are one body, a box that hides part of the wall another."""
    y = np.arange(40)[:, None] * np.ones((1, 50))
    room = np.where(y < 20, 3.0, 3.0 - 0.02 * (y - 19))  # a crease of 20 mm a pixel
    room[5:12, 20:30] = 2.0
    room[0, 0] = np.nan
    number = bodies(room)
    assert number[2, 2] == number[39, 49] != number[8, 25]
    assert np.unique(number).size == 3  # the unknown pixel is alone
    assert np.unique(surfaces(room)[0]).size > 3


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (2, 1), (2, 2), (1, 9)])
def test_flat_things_of_any_size_are_one_body(shape):
    assert not bodies(np.ones(shape)).any()


def test_contact_carries_an_offset_across_a_crease():
    """A small dark facet is placed by the bright wall that it touches."""
    y = np.arange(120)[:, None] * np.ones((1, 120))
    depth = np.where(y < 100, 3.0, 3.0 - 0.01 * (y - 99))
    frame = Frame(depth, np.where(y < 100, 1.0, 0.05))
    m = simulate(frame, protocol="full", seed=1)
    tied, alone = (
        np.abs(oracle(m).depth - depth)[105:].max() for oracle in (oracle_contact, oracle_offset)
    )
    assert tied < 0.01 < alone


def test_contact_needs_a_step_too():
    with pytest.raises(ValueError, match="step > 0"):
        cmtof.unwrap(exact(np.full((4, 4), 1.0)), method="oracle-contact", step=0.0)
