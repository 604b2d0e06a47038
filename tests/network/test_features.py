"""What a network sees of a phase: the same whatever its wraps."""

import numpy as np
import pytest

from cmtof.correlation import TAU, wrapped
from cmtof.network.features import fourier_features, log_amplitude, phase_edges

RNG = np.random.default_rng(3)
PHASE = RNG.uniform(0, TAU, (2, 7, 9))


def plane(down: float, right: float, shape: tuple[int, int] = (20, 30)) -> np.ndarray:
    return np.add.outer(down * np.arange(shape[0]), right * np.arange(shape[1]))


@pytest.mark.parametrize("turns", [1, -1, 57])
def test_features_do_not_know_of_whole_turns(turns: int):
    moved = fourier_features(PHASE + turns * TAU)
    assert np.allclose(moved, fourier_features(PHASE), atol=1e-11)


@pytest.mark.parametrize("order", [0, 2, 5])
def test_features_stand_in_the_order_of_equation_5(order: int):
    features = fourier_features(PHASE, order)
    assert features.shape == (2, 2 * (order + 1), 7, 9)
    for k in range(order + 1):
        assert np.allclose(features[:, 2 * k], np.cos(2**k * PHASE))
        assert np.allclose(features[:, 2 * k + 1], np.sin(2**k * PHASE))


def test_each_octave_lies_on_the_unit_circle():
    features = fourier_features(PHASE).reshape(2, 6, 2, 7, 9)
    assert np.allclose((features**2).sum(axis=2), 1)


def test_each_octave_is_the_square_of_the_one_below():
    features = fourier_features(PHASE).reshape(2, 6, 2, 7, 9)
    phasor = features[:, :, 0] + 1j * features[:, :, 1]
    assert np.allclose(phasor[:, 1:], phasor[:, :-1] ** 2, atol=1e-12)


def test_the_first_octave_gives_the_phase_back():
    cosine, sine = fourier_features(PHASE[0], 0)
    assert np.allclose(wrapped(np.arctan2(sine, cosine)), PHASE[0])


def test_noise_damps_octaves_as_a_gaussian_does():
    """The mean of cos(2^k e) is exp(-4^k sigma^2 / 2); 40 000 draws know it to five sigma."""
    sigma = 0.134
    noise = sigma * RNG.standard_normal((200, 200))
    cosines = fourier_features(noise)[::2].mean(axis=(1, 2))
    law = np.exp(-(4.0 ** np.arange(6)) * sigma**2 / 2)
    assert np.allclose(cosines, law, atol=5 * np.sqrt(0.5 / 40_000))


@pytest.mark.parametrize(("down", "right"), [(0.3, 1.2), (-2.0, 0.9), (0.0, -3.1)])
def test_edges_of_a_wrapped_ramp_are_its_slopes_everywhere(down: float, right: float):
    edges = phase_edges(wrapped(plane(down, right)))
    assert np.allclose(edges[0][:, 1:], right)
    assert np.allclose(edges[1][1:], down)
    if abs(down + right) < np.pi and abs(right - down) < np.pi:
        assert np.allclose(edges[2][1:, 1:], right + down)
        assert np.allclose(edges[3][:-1, 1:], right - down)


def test_naive_differences_of_the_same_ramp_jump_by_a_turn():
    phase = wrapped(plane(0.0, 0.9))
    naive = np.diff(phase, axis=1)
    assert np.unique(np.rint(naive / TAU)).tolist() == [-1, 0]
    assert np.allclose(phase_edges(phase)[0][:, 1:], 0.9)


def test_edges_do_not_know_of_whole_turns():
    turns = TAU * RNG.integers(-9, 9, PHASE.shape)
    assert np.allclose(phase_edges(PHASE + turns), phase_edges(PHASE), atol=1e-12)


def test_a_step_shows_once_in_every_direction_that_crosses_it():
    phase = np.zeros((6, 8))
    phase[:, 4:] = 1.5
    edges = phase_edges(phase)
    assert np.allclose(edges[0][:, 4], 1.5) and np.count_nonzero(edges[0]) == 6
    assert not edges[1].any()
    assert np.count_nonzero(edges[2]) == np.count_nonzero(edges[3]) == 5


def test_edges_are_zero_where_no_neighbour_is():
    edges = phase_edges(PHASE)
    assert not edges[:, 0, :, 0].any() and not edges[:, 1, 0].any()
    assert not edges[:, 2, 0].any() and not edges[:, 2, :, 0].any()
    assert not edges[:, 3, -1].any() and not edges[:, 3, :, 0].any()


def test_mirroring_the_image_turns_the_sign_of_its_edges():
    edges, mirrored = phase_edges(PHASE), phase_edges(PHASE[..., ::-1])
    assert np.allclose(mirrored[:, 0, :, 1:], -edges[:, 0, :, :0:-1])
    assert np.allclose(mirrored[:, 1], edges[:, 1, :, ::-1])


def test_a_factor_of_amplitude_is_a_step_of_its_logarithm():
    bright = RNG.uniform(2000, 6000, (5, 5))
    step = log_amplitude(bright) - log_amplitude(bright / 10)
    assert np.allclose(step, np.log(10), atol=5e-3)  # up to the 1 that keeps the dark finite
    assert log_amplitude(np.zeros((2, 2))).max() == 0


@pytest.mark.parametrize("function", [fourier_features, phase_edges, log_amplitude])
def test_single_precision_stays_single(function):
    assert function(PHASE.astype(np.float32)).dtype == np.float32


@pytest.mark.parametrize("function", [fourier_features, phase_edges, log_amplitude])
def test_a_row_of_pixels_is_refused(function):
    with pytest.raises(ValueError, match=r"Expected .* \(\.\.\., H, W\), got shape \(3,\)\. Keep"):
        function(np.ones(3))


def test_a_negative_octave_is_refused():
    with pytest.raises(ValueError, match="Expected a highest octave of 0 or more, got -1"):
        fourier_features(PHASE, -1)


@pytest.mark.parametrize("bad", [-1.0, np.nan])
def test_amplitudes_that_are_none_are_refused(bad: float):
    with pytest.raises(ValueError, match="Expected amplitudes of 0 counts or more"):
        log_amplitude([[1.0, bad]])
