"""Information of pixels: by the noise of their samples, by noise that none of these shows."""

import numpy as np
from exact_scenes import COLUMNS, SHAPE, plane_frame
from numpy.testing import assert_allclose
from pytest import approx, mark

from cmtof.bounds import simulated_phase_noise
from cmtof.constants import FREQUENCIES
from cmtof.estimate import hidden_noise, seen_noise
from cmtof.measurement import Measurement
from cmtof.simulation import simulate
from cmtof.surfaces.field import CELL, field_from_measurement


def test_information_is_one_over_the_variance_of_the_phase_and_darkness_has_none():
    """|p|^2 / s^2 of a dark pixel is 2 by its noise alone."""
    half = SHAPE[1] // 2
    frame = plane_frame((0, 0, 1), 1.0 * (half > COLUMNS))
    field = field_from_measurement(simulate(frame, protocol="full"))
    assert field.information[:, :, half + 40 :].mean() < 0.1
    bright = field.information[:, :, : half - 8].mean()
    assert bright == approx(1 / simulated_phase_noise(1.0) ** 2, rel=0.05)


@mark.parametrize("bright", [0.15, 0.3, 1.0])
def test_a_dim_wall_loses_little_of_its_information(bright):
    """Pooled by their square roots, wrong weights K leave <sqrt K>^2 / <K> of the information."""
    m = simulate(plane_frame((0, 0, 1), bright), noise=4000)
    weight = field_from_measurement(m).information
    assert np.sqrt(weight).mean() ** 2 > 0.95 * weight.mean()


@mark.parametrize("hidden", [0.0, 0.12])
def test_noise_that_no_residual_shows_is_found_by_the_beats_of_neighbours(hidden, rng):
    """A phase error that is the same in all samples of a pixel, as by vibration."""
    seen = simulated_phase_noise(1.0, sigma=50)
    m = simulate(plane_frame((0.2, 0.1, 1)), noise=50)
    angle = m.phase[:, None] + m.dataset["psi"].to_numpy()[..., None, None]
    off = rng.normal(0, hidden, m.phase.shape)[:, None]
    cosine = np.cos(angle + off) - np.cos(angle)
    moved = m.dataset["correlation"] + m.amplitude[:, None] * cosine
    field = field_from_measurement(Measurement(m.dataset.assign(correlation=moved)))
    told = np.median(field.information)
    assert told == approx(1 / (seen**2 + hidden**2), rel=0.1)
    assert np.median(abs(field.phasor)) == approx(told, rel=0.02)


@mark.parametrize("noise", [300.0, 1200.0])
def test_phases_and_amplitudes_tell_the_noise_that_residuals_show(noise):
    m = simulate(plane_frame((0.2, 0.1, 1), 0.2 + 0.005 * COLUMNS), noise=noise)
    kept = Measurement.from_phase(m.phase, FREQUENCIES, amplitude=1e-9 * m.amplitude)
    assert_allclose(seen_noise(kept), seen_noise(m), rtol=0.03)


@mark.parametrize(
    "how",
    [
        {"noise_free": True},  # steps of the beat without any noise to expect
        {"noise": 30, "frequencies": (7.15e9, 14.5e9)},  # steps of 10 mrad a wrap more
        {"noise": 1200},  # too dark to tell
    ],
)
def test_a_steep_wall_hides_no_noise(how):
    """At 45 degrees, 0.85 wraps a pixel."""
    m = simulate(plane_frame((1, 0, 1), 0.1), **how)
    assert hidden_noise(m, seen_noise(m)) == 0


@mark.parametrize("shape", [(1, 1), (63, 65)])
def test_padding_and_unknown_pixels_weigh_nothing(shape):
    phase = np.ones((2, *shape))
    phase[1, 0, 0] = np.nan
    field = field_from_measurement(
        Measurement.from_phase(phase, FREQUENCIES, mask=np.isfinite(phase).all(0))
    )
    sides = np.array(field.cosine.shape)
    assert not (sides % CELL).any()
    assert sides.min() >= 64
    rows, columns = shape
    for image in (field.phasor, field.information):
        assert np.isfinite(image).all()
        assert image[:, :rows, 1:columns].all()
        assert not image[:, 0, 0].any()
        assert not image[:, rows:].any()
        assert not image[:, :, columns:].any()
