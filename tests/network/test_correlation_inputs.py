"""Raw correlations as a network's input: made for training as the simulator and a file have them.

Statements on noise are wrong for one seed in a million (5 sigma); the seeds are fixed.
"""

import numpy as np
import pytest
import torch
from torch import Tensor

import cmtof
from cmtof.constants import FREQUENCIES, NOISE_SIGMA
from cmtof.correlation import TAU, decode
from cmtof.measurement import Measurement
from cmtof.network.configuration import Config
from cmtof.network.data import Views
from cmtof.network.features import DARK_AMPLITUDE, FULL_AMPLITUDE, features, scaled_correlation
from cmtof.network.frames import Pack
from cmtof.network.inference import quadrature_images, unwrap_with_network
from cmtof.network.measuring import Batch, measure, phasors, quadratures
from cmtof.scenes.frame import Frame
from cmtof.simulation import QUADRATURES


def image(*shape: int, seed: int = 0) -> Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed))


SIDE = 200
DEPTH = 0.9137


def drawn(intensity: float, sigma: float) -> np.ndarray:
    """Correlation images as training makes them, (2 tones, 4, SIDE^2)."""
    shape = (1, SIDE, SIDE)
    batch = Batch(torch.full(shape, DEPTH), torch.full(shape, intensity), torch.tensor([sigma]))
    noise = image(4, 1, 2, SIDE, SIDE, seed=5)
    found = quadratures(batch, *phasors(*batch, noise[:2]), noise[2:])
    return found[0].flatten(-2).double().numpy()


def simulated(intensity: float, sigma: float) -> np.ndarray:
    frame = Frame(np.full((SIDE, SIDE), DEPTH), np.full((SIDE, SIDE), intensity))
    measured = cmtof.simulate(frame, protocol="full", noise=sigma, seed=6)
    images = measured.dataset["correlation"].to_numpy().astype(float)
    return images.reshape(2, 4, -1)


@pytest.mark.parametrize("intensity", [0.0, 0.1, 1.0])
def test_images_of_training_have_the_moments_of_the_simulators(intensity: float):
    """Means and all covariances of the four images; 5 sigma of the mean and of the variance."""
    ours, theirs = drawn(intensity, NOISE_SIGMA), simulated(intensity, NOISE_SIGMA)
    variance = 20_000 * intensity / 2 + NOISE_SIGMA**2
    bound = 5 * np.sqrt(2 / SIDE**2)
    for one, other in zip(ours, theirs, strict=True):
        assert np.abs(one.mean(1) - other.mean(1)).max() < bound * np.sqrt(variance)
        # the photons' a cos(phi + psi) that is left out is 0.4 % of the variance
        assert np.abs(np.cov(one) - np.cov(other)).max() < (np.sqrt(2) * bound + 0.005) * variance
        assert np.abs(np.cov(one) - variance * np.eye(4)).max() < (bound + 0.005) * variance
    tones = np.corrcoef(ours.reshape(8, -1))[:4, 4:]
    assert np.abs(tones).max() < 5 / SIDE


@pytest.mark.parametrize("sigma", [0.0, NOISE_SIGMA])
def test_images_decode_to_the_phasor_that_they_were_made_for(sigma: float):
    depth, intensity = 0.2 + 7 * torch.rand(1, 8, 9), torch.rand(1, 8, 9)
    batch = Batch(depth, intensity, torch.tensor([sigma]))
    noise = image(4, 1, 2, 8, 9)
    phase, amplitude = phasors(*batch, noise[:2])
    images = quadratures(batch, phase, amplitude, noise[2:])
    again = decode(images[0].double().numpy(), QUADRATURES)
    apart = again.amplitude * np.exp(1j * again.phase) - (amplitude * torch.exp(1j * phase)).numpy()
    assert np.abs(apart).max() < 1e-2
    clean = quadratures(batch, *phasors(*batch))[0].double().numpy()
    frame = Frame(depth[0].numpy(), intensity[0].numpy())
    expected = cmtof.simulate(frame, protocol="full", noise_free=True).dataset["correlation"]
    np.testing.assert_allclose(clean, expected.to_numpy(), atol=2.0)


def test_the_further_noise_leaves_the_phasors_as_they_are():
    """Every model is trained and validated on the same measured phases."""
    batch = Batch(torch.full((1, 8, 9), 0.9), torch.ones(1, 8, 9), torch.tensor([1200.0]))
    noise = image(4, 1, 2, 8, 9)
    ours = measure(batch, noise, inputs="correlation", first=36, classes=21)
    theirs = measure(batch, noise[:2], inputs="proposed", first=36, classes=21)
    assert torch.equal(ours.phase, theirs.phase) and torch.equal(ours.label, theirs.label)
    frames = np.full((2, 40, 40), 1.0)
    pack = Pack(frames.astype(np.float32), frames.astype(np.float16), np.ones(2), ["a", "b"])
    views = [Views(pack, Config(model=model, crop=32))[0] for model in ("fast-scnn", "deep-tof")]
    (first, plain), (second, more) = views
    assert plain.shape == (2, 2, 32, 32) and more.shape == (4, 2, 32, 32)
    assert torch.equal(more[:2], plain) and torch.equal(first.depth, second.depth)
    assert abs(float((more[2:] * more[:2]).mean())) < 5 / np.sqrt(plain.numel())


def test_brightness_is_taken_off_correlations():
    """Of a bright surface cos(phi + psi) and the mean of pi / 2 are left; the dark is finite."""
    phase = np.array([0.3, 4.0]).reshape(2, 1, 1)
    psi = np.asarray(QUADRATURES).reshape(1, 4, 1, 1)
    for brightness in (10.0, 1000.0):
        amplitude = np.full((2, 1, 1), brightness * DARK_AMPLITUDE)
        images = amplitude[:, None] * (np.pi / 2 + np.cos(phase[:, None] + psi))
        expected = np.pi / 2 + np.cos(phase[:, None] + psi)
        found = scaled_correlation(images, amplitude)
        np.testing.assert_allclose(found, expected, rtol=0.6 / brightness**2, atol=1e-12)
    assert not scaled_correlation(np.zeros((2, 4, 3, 3)), np.zeros((2, 3, 3))).any()
    assert DARK_AMPLITUDE < FULL_AMPLITUDE / 10


def test_training_and_unwrapping_read_the_same(tilted_wall):
    """Frame to features in torch, and through a measurement in NumPy."""
    measured = cmtof.simulate(tilted_wall, protocol="full", noise_free=True)
    found = features(measured.phase, measured.amplitude, "correlation", quadrature_images(measured))
    depth, intensity = (
        torch.from_numpy(np.asarray(part, np.float32))[None]
        for part in (tilted_wall.depth, np.clip(tilted_wall.intensity, 0, 1))
    )
    batch = Batch(depth, intensity, torch.tensor([0.0]))
    sample = measure(batch, None, inputs="correlation", first=0, classes=358)
    known = np.isfinite(tilted_wall.depth)
    np.testing.assert_allclose(sample.inputs[0].numpy()[:, known], found[:, known], atol=2e-3)


def test_quadratures_are_found_in_any_order_and_among_others(measured):
    expected = quadrature_images(measured)
    images = measured.dataset["correlation"].to_numpy()
    psi = np.asarray(QUADRATURES)
    order = [2, 0, 3, 1]
    turned = Measurement.from_arrays(
        images[:, order], psi[order] + TAU * np.array([0, 1, -1, 2]), FREQUENCIES
    )
    assert np.array_equal(quadrature_images(turned), expected)
    more = np.concatenate([images[:, :1] + 5, images], 1)
    among = Measurement.from_arrays(more, np.concatenate([[0.7], psi]), FREQUENCIES)
    assert np.array_equal(quadrature_images(among), expected)


def test_without_quadratures_deep_tof_says_so(measured, tilted_wall, fresh):
    path = fresh("deep-tof")
    bare = Measurement.from_phase(
        measured.phase, FREQUENCIES, amplitude=measured.amplitude,
        range_min=measured.range[0], range_max=measured.range[1],
    )  # fmt: skip
    with pytest.raises(ValueError, match=r"^Expected raw correlations, .* got phases alone\. Keep"):
        unwrap_with_network(bare, weights=path)
    thirds = cmtof.simulate(tilted_wall, psi=TAU * np.arange(3) / 3)
    with pytest.raises(ValueError, match=r"^Expected correlations at psi = 0, .* got \[0\.0, 0\.3"):
        unwrap_with_network(thirds, weights=path)
    with pytest.raises(ValueError, match="raw correlations for the features correlation, got none"):
        features(measured.phase, measured.amplitude, "correlation")
