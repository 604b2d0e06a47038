"""Remainder theorem, look-up, beat of one pixel: exact without noise, as good as theory with it."""

import numpy as np
from numpy.testing import assert_allclose
from pytest import approx, mark
from scores import scores
from walls import WRAP, flat_wall

import cmtof
from cmtof import bounds
from cmtof.classical import crt
from cmtof.classical.phasor import match, phasor
from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU, phase_from_depth, wrap_length
from cmtof.frame import Frame
from cmtof.measurement import Measurement
from cmtof.simulation import simulate

CLOSE = (7.15e9, 7.16e9)


@mark.parametrize("pair", [FREQUENCIES, CLOSE, (3e9, 7e9)])
def test_search_is_that_over_all_wraps(rng, pair):
    """The wrap of least misfit, tried one after the other, at any pair of frequencies."""
    m = Measurement.from_phase(
        rng.uniform(0, TAU, (2, 30, 40)), pair, range_min=0.4, range_max=7.3
    )
    found, residual = crt.nearest_wrap(m)
    length = wrap_length(pair[0])
    wraps = np.arange(int(0.4 / length), int(np.ceil(7.3 / length)))
    low, high = m.phase / TAU
    misfit = high - pair[1] / pair[0] * np.add.outer(wraps, low)
    misfit -= np.rint(misfit)
    assert_allclose(abs(residual), TAU * abs(misfit).min(0), atol=6e-9)
    assert np.isin(found, wraps).all()


@mark.parametrize("offset", [0.49, 0.51])
def test_closed_form_survives_errors_up_to_its_bound(rng, offset):
    """An error of less than M/4 in each remainder, of opposite signs, is forgiven; more is not."""
    depth = rng.uniform(0.05, 7.0, (20, 20))
    unit = WRAP / 1432
    shift = phase_from_depth(offset * unit / 2, np.array(FREQUENCIES)) * [1, -1]
    inner = np.stack([phase_from_depth(depth, f) % TAU for f in FREQUENCIES])
    keep = np.all(abs(inner - np.pi) < np.pi - 0.01, axis=0)
    m = Measurement.from_phase(inner + shift[:, None, None], FREQUENCIES)
    error = abs(crt.crt_closed_form(m).depth - depth)
    assert (error[keep].max() < 1e-4) == (offset < 0.5)


def test_closed_form_beyond_its_bound_is_no_surer_than_a_guess(rng):
    """At 7 and 14 GHz depths repeat from wrap to wrap, 327 times within 7 m."""
    phase = rng.uniform(0, TAU, (4, 4))
    pair = [7e9, 14e9]
    m = Measurement.from_phase([phase, 2 * phase % TAU], pair, range_max=7.0)
    assert (crt.crt_closed_form(m).confidence * 327 <= 1).all()


@mark.parametrize(
    "method, pair, depth",
    [("crt", FREQUENCIES, 4.0), ("crt", FREQUENCIES, 0.05), ("phasor", CLOSE, 4.0)],
)
def test_single_pixels_are_right_as_often_as_theory_predicts(method, pair, depth):
    """To four standard deviations of 250 000 pixels; the confidence predicts the same."""
    m = simulate(flat_wall(500, depth), protocol="full", frequencies=pair)
    found = scores(m, method=method)
    noise = bounds.simulated_phase_noise(1.0)
    theory = bounds.wrap_probability_law(noise, noise, frequencies=pair)
    four_errors = 4 * np.sqrt(theory / m.mask.size)
    assert found["consistent_lt_1"] == approx(theory, abs=four_errors)
    assert found["mean_confidence"] == approx(theory, rel=0.15)


def test_look_up_is_exact_over_fifteen_metres_and_no_entry_is_nearer(exact, rng):
    depth = rng.uniform(0.0001, 14.9895, (90, 100))
    assert_allclose(phasor(exact(depth, CLOSE)).depth, depth, atol=1e-9)
    frame = Frame(rng.uniform(0.8, 1.1, (12, 12)), rng.uniform(0.05, 1, (12, 12)))
    m = simulate(frame, protocol="full", frequencies=CLOSE).between(0.75, 1.19)
    phase = m.phase.astype(float)
    amplitude = m.amplitude.astype(float)
    entries = np.arange(*m.range, 1e-4)
    table = np.stack(
        [match(phase, amplitude, np.full(m.shape, z), CLOSE) for z in entries]
    )
    ours = match(phase, amplitude, phasor(m).depth, CLOSE)
    assert (ours >= table.max(0) - 1e-7 * amplitude.sum(0)).all()


@mark.parametrize("pair", [FREQUENCIES, (7.16e9, 14.30e9)])
def test_the_beat_of_one_pixel_is_exact_on_either_side_of_the_multiple(
    exact, rng, pair
):
    depth = rng.uniform(0.1, 7.0, (9, 9))
    found = cmtof.unwrap(exact(depth, pair), method="beat", window=1).depth
    assert_allclose(found, depth, atol=1e-6)
