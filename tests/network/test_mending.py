"""Wraps mended after a segmentation: votes as counted by hand, planes kept, noise followed."""

import numpy as np
import pytest

from cmtof.correlation import TAU, wrap_length, wrapped
from cmtof.network.inference import unwrap_with_network
from cmtof.network.rapid import congruent, mended, most_frequent

STEP = float(wrap_length(7.15e9))


def plane(down: float, right: float, shape: tuple[int, int] = (30, 40)) -> np.ndarray:
    """Unwrapped phase of a tilted plane, rad, more than 30 turns."""
    return 30.3 * TAU + np.add.outer(down * np.arange(shape[0]), right * np.arange(shape[1]))


def test_the_mode_is_that_of_counting():
    rng = np.random.default_rng(2)
    wraps = rng.integers(0, 4, (9, 11))
    found = most_frequent(wraps, 3)
    for y, x in np.ndindex(wraps.shape):
        square = wraps[max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2]
        numbers = np.bincount(square.ravel(), minlength=4)
        most = np.flatnonzero(numbers == numbers.max())
        assert found[y, x] == (wraps[y, x] if wraps[y, x] in most else most[0])


def test_votes_are_those_of_counting():
    rng = np.random.default_rng(4)
    wraps, phase = rng.integers(0, 3, (7, 8)), rng.uniform(0, TAU, (7, 8)).astype(np.float32)
    found = congruent(wraps, phase, 5)
    for y, x in np.ndindex(wraps.shape):
        rows, columns = slice(max(y - 2, 0), y + 3), slice(max(x - 2, 0), x + 3)
        said = wraps[rows, columns] + np.rint((phase[rows, columns] - phase[y, x]) / TAU)
        values, numbers = np.unique(said, return_counts=True)
        most = values[numbers == numbers.max()]
        assert found[y, x] == (wraps[y, x] if wraps[y, x] in most else most[0])


@pytest.mark.parametrize(("down", "right"), [(0.0, 0.0), (0.7, 0.0), (-0.4, 0.9), (0.5, 0.5)])
def test_the_true_wraps_of_a_plane_stay(down: float, right: float):
    """Slopes below half a turn over the reach of two pixels, with wrap lines in every direction."""
    truth = plane(down, right)
    wraps, phase = np.floor(truth / TAU).astype(int), wrapped(truth)
    np.testing.assert_array_equal(congruent(wraps, phase), wraps)
    np.testing.assert_array_equal(congruent(wraps + 5, phase), wraps + 5)


def test_single_wrong_pixels_are_mended_and_wrap_lines_kept():
    truth = plane(0.25, 0.35)
    wraps, phase = np.floor(truth / TAU).astype(int), wrapped(truth)
    wrong = wraps.copy()
    rng = np.random.default_rng(9)
    spoilt = rng.uniform(size=wraps.shape) < 0.08
    wrong[spoilt] = rng.integers(0, 60, spoilt.sum())
    assert (mended(wrong, phase) == wraps).all()
    assert (most_frequent(wrong) != wraps).any()  # the filter alone rounds the wrap lines off


def test_noise_along_a_wrap_line_is_followed():
    """The wrap that goes with each measured phase, not the smooth line between the labels."""
    truth = plane(0.0, 0.3) + np.random.default_rng(1).normal(0, 0.2, (30, 40))
    labels = np.floor(plane(0.0, 0.3) / TAU).astype(int)
    found = mended(labels, wrapped(truth))
    expected = np.floor(truth / TAU).astype(int)
    assert (found == expected).mean() > 0.99 > (labels == expected).mean()


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (7, 1), (2, 3)])
def test_mending_takes_any_size(shape: tuple[int, int]):
    wraps = np.full(shape, 4)
    assert (mended(wraps, np.zeros(shape)) == 4).all()
    with pytest.raises(ValueError, match=r"^Expected an odd side, .* got 4\. Add a pixel"):
        mended(wraps, np.zeros(shape), side=4)


def test_rapid_is_mended_within_the_range(fresh, measured):
    """A network that knows nothing is sure of nothing, whatever was voted for."""
    estimate = unwrap_with_network(measured, weights=fresh("rapid"))
    wraps = np.rint(estimate.depth / STEP - measured.phase[0] / TAU).astype(int)
    assert wraps.min() >= 36 and wraps.max() <= 56
    assert (estimate.confidence >= 0).all() and (estimate.confidence < 0.3).all()
