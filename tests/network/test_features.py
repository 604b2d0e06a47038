"""Features: closed forms, no trace of where a phase was cut, NumPy and torch alike."""

import tracemalloc

import numpy as np
import torch
from numpy.testing import assert_allclose
from pytest import mark

from cmtof.correlation import TAU
from cmtof.network.features import (
    FEATURE_SETS,
    channels,
    features,
    fourier_features,
    phase_edges,
)

rng = np.random.default_rng(0)
PHASE = rng.uniform(0, TAU, (2, 12, 15))
AMPLITUDE = rng.uniform(0, 6000, (2, 12, 15))
CORRELATION = rng.normal(5000, 1000, (2, 4, 12, 15))


def test_fourier_features_are_cosines_and_sines_of_octaves():
    found = fourier_features(PHASE[0], order=4)
    octaves = 2.0 ** np.arange(5)[:, None, None] * PHASE[0]
    assert_allclose(found[::2] + 1j * found[1::2], np.exp(1j * octaves), atol=1e-12)


def test_edges_of_a_plane_are_its_slopes_wherever_it_wraps():
    y, x = np.mgrid[:20, :30]
    edges = phase_edges((0.7 * x - 0.4 * y) % TAU)
    assert np.allclose(edges[:, 1:-1, 1:].T, [0.7, -0.4, 0.3, 1.1])
    assert not np.concatenate([edges[0, :, 0], edges[1, 0], edges[3, -1]]).any()


@mark.parametrize("name", FEATURE_SETS)
def test_numpy_and_torch_agree_in_every_set(name):
    phase, amplitude = map(torch.from_numpy, (PHASE, AMPLITUDE))
    ours = features(PHASE, AMPLITUDE, name, CORRELATION)
    theirs = features(phase, amplitude, name, torch.from_numpy(CORRELATION))
    assert len(ours) == channels(name)
    assert_allclose(ours, theirs.numpy(), atol=1e-9)
    assert np.isfinite(features(PHASE, 0 * AMPLITUDE, name, CORRELATION)).all()


def test_beat_features_turn_with_the_beat():
    both = features(PHASE, AMPLITUDE, "beat")[-2:]
    expected = np.sqrt(AMPLITUDE.prod(0)) * np.exp(1j * (PHASE[1] - 2 * PHASE[0]))
    assert_allclose(both[0] + 1j * both[1], expected * np.pi / 20_000)


def test_inputs_are_laid_out_where_they_stay():
    tracemalloc.start()
    inputs = features(PHASE, AMPLITUDE, "beat")
    assert tracemalloc.get_traced_memory()[1] < 1.6 * inputs.nbytes
    tracemalloc.stop()
