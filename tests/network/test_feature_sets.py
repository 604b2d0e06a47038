"""Sets of features: the rows of Table 1 exactly, in NumPy as in torch, and the beat's physics."""

import numpy as np
import pytest
import torch

import cmtof
from cmtof.constants import FREQUENCIES, SPEED_OF_LIGHT
from cmtof.correlation import TAU
from cmtof.network.features import (
    FEATURE_SETS,
    FULL_AMPLITUDE,
    TYPICAL_LOG_AMPLITUDE,
    beat_features,
    channels,
    features,
    fourier_features,
    log_amplitude,
    phase_edges,
)
from cmtof.scenes.frame import Frame

RNG = np.random.default_rng(11)
PHASE = RNG.uniform(0, TAU, (2, 9, 13)).astype(np.float32)
AMPLITUDE = RNG.uniform(0, 6500, (2, 9, 13)).astype(np.float32)
CORRELATION = RNG.uniform(0, 20_000, (2, 4, 9, 13)).astype(np.float32)


@pytest.mark.parametrize("name", FEATURE_SETS)
def test_torch_and_numpy_agree(name: str):
    expected = features(PHASE, AMPLITUDE, name, CORRELATION)
    tensors = [torch.from_numpy(one) for one in (PHASE, AMPLITUDE, CORRELATION)]
    found = features(*tensors[:2], name, tensors[2])
    assert isinstance(expected, np.ndarray) and isinstance(found, torch.Tensor)
    assert expected.dtype == np.float32 and found.dtype == torch.float32
    # the sixth octave squares five times: 32 roundings of a single
    np.testing.assert_allclose(found.numpy(), expected, atol=32 * 2e-7)


@pytest.mark.parametrize("name", FEATURE_SETS)
def test_channels_count_what_is_there(name: str):
    found = features(PHASE, AMPLITUDE, name, CORRELATION)
    assert found.shape == (channels(name), 9, 13)


@pytest.mark.parametrize("name", FEATURE_SETS)
def test_a_batch_is_its_frames_one_by_one(name: str):
    pairs = [np.stack([a, a[..., ::-1]]) for a in (PHASE, AMPLITUDE, CORRELATION)]
    phase, amplitude, correlation = (torch.from_numpy(pair.copy()) for pair in pairs)
    batch = features(phase, amplitude, name, correlation)
    for one, p, a, c in zip(batch, *pairs, strict=True):
        np.testing.assert_allclose(one.numpy(), features(p, a, name, c), atol=1e-5)


def parts() -> dict[str, np.ndarray]:
    """Each kind of feature, made by hand."""
    centre, spread = TYPICAL_LOG_AMPLITUDE
    return {
        "phase": PHASE / TAU,
        "fourier": np.concatenate([fourier_features(one) for one in PHASE]),
        "edges": np.concatenate([phase_edges(one) for one in PHASE]),
        "amplitude": (log_amplitude(AMPLITUDE) - centre) / spread,
        "beat": beat_features(PHASE, AMPLITUDE),
    }


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("phase", ["phase", "amplitude"]),
        ("fourier", ["phase", "fourier", "amplitude"]),
        ("proposed", ["phase", "fourier", "edges", "amplitude"]),
        ("released", ["phase", "fourier"]),
        ("beat", ["phase", "fourier", "edges", "amplitude", "beat"]),
    ],
)
def test_each_set_holds_its_row_of_table_1_and_nothing_else(name: str, kinds: list[str]):
    expected = np.concatenate([parts()[kind] for kind in kinds])
    np.testing.assert_allclose(features(PHASE, AMPLITUDE, name), expected, atol=1e-6)


@pytest.mark.parametrize("name", ["phase", "fourier", "proposed"])
def test_rows_of_table_1_do_not_multiply_the_two_phases(name: str):
    """Turning one phase leaves the channels of the other alone: no row is given the beat."""
    turned = PHASE.copy()
    turned[1] = (turned[1] + 1.0) % TAU
    kept = features(PHASE, AMPLITUDE, name) == features(turned, AMPLITUDE, name)
    assert kept.all(axis=(1, 2)).sum() >= channels(name) // 2


def test_what_the_released_code_reads_has_no_amplitude():
    brighter = features(PHASE, 2 * AMPLITUDE, "released")
    np.testing.assert_array_equal(brighter, features(PHASE, AMPLITUDE, "released"))


def test_typical_amplitudes_are_of_order_one():
    """From a twentieth of a white surface to all of it, at the paper's gain."""
    amplitude = FULL_AMPLITUDE * np.geomspace(0.05, 1, 32).reshape(1, 4, 8).repeat(2, 0)
    scaled = features(np.zeros((2, 4, 8)), amplitude, "phase")[2:]
    assert np.abs(scaled).max() < 3
    assert np.ptp(scaled) > 2


def test_the_beat_turns_by_twenty_megahertz():
    """phi_2 - 2 phi_1 of a noise-free measurement is 2 pi (f_2 - 2 f_1) 2 z / c, never wrapped."""
    depth = np.linspace(0.2, 7.3, 400).reshape(20, 20).astype(np.float32)
    measured = cmtof.simulate(
        Frame(depth, np.full((20, 20), 0.7)), protocol="full", noise_free=True
    )
    cosine, sine = beat_features(measured.phase, measured.amplitude)
    angle = TAU * (FREQUENCIES[1] - 2 * FREQUENCIES[0]) * 2 * depth.astype(float) / SPEED_OF_LIGHT
    assert FREQUENCIES[1] - 2 * FREQUENCIES[0] == 20e6
    np.testing.assert_allclose(cosine, 0.7 * np.cos(angle), atol=2e-3)
    np.testing.assert_allclose(sine, 0.7 * np.sin(angle), atol=2e-3)


def test_the_beat_of_the_dark_weighs_nothing():
    dark = AMPLITUDE.copy()
    dark[0, :, :5] = 0
    assert not beat_features(PHASE, dark)[:, :, :5].any()


def test_an_unknown_set_is_refused():
    with pytest.raises(ValueError, match=r"out of phase, fourier, .* got depth\. Choose one"):
        channels("depth")
    with pytest.raises(ValueError, match="got depth"):
        features(PHASE, AMPLITUDE, "depth")
