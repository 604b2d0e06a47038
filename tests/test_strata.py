import numpy as np
import pytest

import cmtof
from cmtof.metrics import scored_pixels
from cmtof.scenes.frame import Frame
from cmtof.strata import bin_of, counted, strata_of, strata_values


@pytest.fixture
def step():
    """Two walls in the range of ``released``, the right one bright; 30 x 40."""
    depth, intensity = np.full((30, 40), 0.9), np.full((30, 40), 0.1)
    depth[:, 20:], intensity[:, 20:] = 1.1, 2.0
    frame = Frame(depth, intensity)
    return frame, cmtof.simulate(frame, noise_free=True)


def test_values_of_a_step_are_known(step):
    frame, measurement = step
    found = strata_values(frame, measurement)
    assert {name: values.size for name, values in found.items()} == dict.fromkeys(found, 1200)
    picture = {name: values.reshape(30, 40) for name, values in found.items()}
    assert np.unique(picture["intensity"]) == pytest.approx([0.1, 1.0])  # clipped as simulated
    wraps = np.floor(np.array([0.9, 1.1]) / float(cmtof.correlation.wrap_length(7.15e9)))
    assert sorted(np.unique(picture["wrap"])) == sorted(wraps)
    # the two columns beside the step are the edge
    assert picture["edge"][7].tolist() == [*range(19, 0, -1), 0, 0, *range(1, 20)]
    assert picture["patch"][7].tolist() == [19 * 30] * 19 + [1, 1] + [19 * 30] * 19


def test_they_stand_in_the_order_of_the_scored_pixels(tilted_wall, measured):
    found = strata_values(tilted_wall, measured)
    truth = scored_pixels(cmtof.unwrap(measured), measured)["true_count"]
    assert (found["wrap"] == truth).all()


def test_a_scene_without_an_edge_is_far_from_any():
    frame = Frame(np.full((8, 8), 0.9), np.ones((8, 8)))
    measurement = cmtof.simulate(frame, noise_free=True)
    found = strata_values(frame, measurement)
    edges = strata_of(36, 56)["edge"].edges
    assert (bin_of(found["edge"], edges) == len(edges) - 2).all()
    assert (found["patch"] == 64).all()


def test_no_pixel_is_lost_or_counted_twice(step):
    frame, measurement = step
    for name, values in strata_values(frame, measurement).items():
        edges = strata_of(36, 56)[name].edges
        place, bins = bin_of(values, edges), len(edges) - 1
        right = np.arange(values.size) % 3 == 0
        assert counted(place, bins).sum() == 1200
        both = counted(place, bins, right) + counted(place, bins, ~right)
        assert (both == counted(place, bins)).all()


@pytest.mark.parametrize(("first", "last"), [(36, 56), (0, 357), (5, 6)])
def test_wraps_of_any_range_have_a_bin(first, last):
    edges = strata_of(first, last)["wrap"].edges
    assert edges[0] == first - 0.5 and edges[-1] > last
    assert len(edges) <= 22


def test_middles_lie_within_their_bins():
    for stratum in strata_of(36, 56).values():
        edges = np.asarray(stratum.edges)
        assert ((stratum.middles > edges[:-1]) & (stratum.middles < edges[1:])).all()


def test_without_a_truth_there_is_nothing_to_sort_by(step):
    frame, measurement = step
    bare = cmtof.Measurement(measurement.dataset.drop_vars("depth"))
    with pytest.raises(ValueError, match="true depth"):
        strata_values(frame, bare)
