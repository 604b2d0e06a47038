"""What each pixel tells: its information, and that what is unknown tells nothing."""

import numpy as np
import pytest
from facet_scenes import CAMERA, SHAPE, WRAP, plane_depth, plane_frame

from cmtof.bounds import simulated_phase_noise
from cmtof.constants import FREQUENCIES
from cmtof.correlation import phase_from_depth
from cmtof.measurement import Measurement
from cmtof.simulation import simulate
from cmtof.surfaces.field import CELL, SMALLEST, field_from_measurement

HEIGHT, WIDTH = SHAPE


def phases(depth):
    return np.stack([phase_from_depth(depth, f) for f in FREQUENCIES])


def likelihood(field, depth):
    """S (2, H, W) of true depths, without the padding."""
    height, width = depth.shape
    p = (field.real + 1j * field.imaginary)[:, :height, :width]
    return np.real(p * np.exp(-1j * field.wavenumber[:, None, None] * depth))


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(("intensity", "within"), [(0.3, 0.08), (0.6, 0.05), (1.0, 0.05)])
def test_information_is_one_over_the_variance_of_the_phase(intensity, within, seed):
    m = simulate(plane_frame((0.2, -0.1, 1), 2.5, intensity), protocol="full", seed=seed)
    field = field_from_measurement(m)
    expected = 1 / simulated_phase_noise(intensity) ** 2
    found = field.information[:, :HEIGHT, :WIDTH].mean(axis=(1, 2))
    # the noise is a median of 20 480 residuals, known to 0.8 %; that squared, relative to
    # the information and the noise's share of 2, is 2.3 % at 0.3 and 1.7 % at 1: three sigma
    np.testing.assert_allclose(found, expected, rtol=within)


@pytest.mark.parametrize("intensity", [0.3, 1.0])
def test_the_true_depth_is_as_likely_as_it_can_be(intensity):
    """S averages E; its own noise is sqrt(E), here 2e-3 of it or less."""
    frame = plane_frame((-0.3, 0.2, 1), 2.2, intensity)
    m = simulate(frame, protocol="full", seed=4)
    field = field_from_measurement(m)
    total = likelihood(field, m.depth.astype(float)).sum()
    assert total / field.information.sum() == pytest.approx(1, abs=0.01)


def test_a_wrong_depth_is_less_likely():
    m = simulate(plane_frame((0, 0, 1), 2.2), protocol="full", seed=4)
    field = field_from_measurement(m)
    truth, other = (likelihood(field, m.depth.astype(float) + d).sum() for d in (0, 5 * WRAP))
    # after five wraps the beat has turned by 5 / 357.5 of a turn at the higher frequency only
    turned = (1 + np.cos(2 * np.pi * 5 * (FREQUENCIES[1] / FREQUENCIES[0] - 2))) / 2
    assert other / truth == pytest.approx(turned, abs=5e-4)


@pytest.mark.parametrize("shape", [(1, 1), (5, 7), (63, 65), (64, 72), (64, 64), (100, 130)])
def test_padding_weighs_nothing(shape):
    m = Measurement.from_phase(phases(np.full(shape, 2.0)), FREQUENCIES)
    field = field_from_measurement(m)
    for side, wanted in zip(field.cosine.shape, shape, strict=True):
        assert side % CELL == 0
        assert side == max(SMALLEST, -(-wanted // CELL) * CELL)
    for image in (field.real, field.imaginary, field.information):
        outside = image.copy()
        outside[:, : shape[0], : shape[1]] = 0
        assert not outside.any()
        assert np.isfinite(image).all()


@pytest.mark.parametrize("correlated", [True, False])
def test_unknown_pixels_weigh_nothing(correlated):
    clean = simulate(plane_frame((0.1, 0, 1), 2.5), protocol="full", seed=5)
    mask = np.ones(SHAPE, bool)
    mask[40:60, 50:70] = False
    if correlated:
        images = clean.dataset["correlation"].to_numpy().copy()
        images[..., ~mask] = np.nan
        m = Measurement.from_arrays(
            images, clean.dataset["psi"].to_numpy(), FREQUENCIES, mask=mask, camera=CAMERA
        )
    else:
        phase = clean.phase.copy()
        phase[:, ~mask] = np.nan
        m = Measurement.from_phase(phase, FREQUENCIES, mask=mask, camera=CAMERA)
    field, whole = field_from_measurement(m), field_from_measurement(clean)
    for image in (field.real, field.imaginary, field.information):
        assert np.isfinite(image).all()
        assert not image[:, ~mask].any()
    if correlated:  # and those beside them are worth what they were
        ratio = field.information[:, mask].sum() / whole.information[:, mask].sum()
        assert ratio == pytest.approx(1, abs=0.01)


def test_one_unknown_phase_silences_both():
    phase = phases(np.full((64, 64), 2.0))
    phase[1, 10, 20] = np.nan
    mask = np.ones((64, 64), bool)
    mask[10, 20] = False
    field = field_from_measurement(Measurement.from_phase(phase, FREQUENCIES, mask=mask))
    assert not field.information[:, 10, 20].any()
    assert not field.real[:, 10, 20].any()


def test_phases_alone_count_as_one_radian():
    depth, _ = plane_depth((0.1, 0.3, 1), 2.0)
    field = field_from_measurement(Measurement.from_phase(phases(depth), FREQUENCIES))
    np.testing.assert_array_equal(field.information, 1)
    p = field.real + 1j * field.imaginary
    np.testing.assert_allclose(p, np.exp(1j * phases(depth)), atol=1e-5)


def test_darkness_is_not_taken_for_light():
    """|p|^2 / s^2 of a dark pixel is 2 by its noise alone: that is no information."""
    intensity = np.broadcast_to(np.where(np.arange(WIDTH) < WIDTH // 2, 1.0, 0.0), SHAPE)
    m = simulate(plane_frame((0, 0, 1), 2.5, intensity), protocol="full", seed=6)
    field = field_from_measurement(m)
    dark = field.information[:, :, WIDTH // 2 + 40 :]
    bright = field.information[:, :, : WIDTH // 2 - 8]
    assert dark.mean() < 0.1
    # the dark half's noise is the bright half's: 3 sigma of it, as above
    assert bright.mean() == pytest.approx(1 / simulated_phase_noise(1.0) ** 2, rel=0.05)


@pytest.mark.parametrize("camera", [CAMERA, (200.0, 100.0, 10.0, 90.0)])
def test_rays_are_those_of_the_camera(camera):
    depth, q = plane_depth((0.2, -0.3, 1), 2.0, SHAPE, camera)
    field = field_from_measurement(
        Measurement.from_phase(phases(depth), FREQUENCIES, camera=camera)
    )
    inverse = field.cosine * (q[0] * field.u + q[1] * field.v[:, None] + q[2])
    np.testing.assert_allclose(1 / inverse, depth, rtol=1e-12)


def test_a_wrap_turns_the_lower_phase_once_and_the_higher_twice():
    field = field_from_measurement(Measurement.from_phase(phases(np.ones((2, 2))), FREQUENCIES))
    assert field.period == pytest.approx(WRAP, rel=1e-12)
    np.testing.assert_allclose(field.turns / (2 * np.pi), [1, 2])
