"""Offsets between the frequencies: their cost in closed form, and how they are found again."""

import numpy as np
import pytest

import cmtof
from cmtof import metrics
from cmtof import offset_calibration as calibration
from cmtof.baselines import find_method
from cmtof.bounds import wrap_noise
from cmtof.constants import FREQUENCIES
from cmtof.correlation import (
    TAU,
    centred,
    depth_from_phase,
    phase_from_depth,
    wrap_length,
)
from cmtof.measurement import Measurement
from cmtof.offset_calibration import Closures
from cmtof.scenes.frame import Frame, rays_from_camera
from cmtof.simulation import simulate

PERIOD = calibration.closure_period(FREQUENCIES)
LENGTH = float(wrap_length(FREQUENCIES[0]))


def wall(side, *, half_angle=0.5, tilt=(0.1, -0.15), distance=0.9, brightness=1.0):
    """A plane ``m . x = 1`` seen by a square camera: frame, rays (P, 3) and m."""
    focal = side / 2 / half_angle
    camera = np.array([focal, focal, side / 2, side / 2])
    rays = rays_from_camera((side, side), camera)
    plane = np.array([*tilt, 1.0]) / distance
    depth = np.linalg.norm(rays, axis=-1) / (rays @ plane)
    frame = Frame(depth, np.full((side, side), brightness), camera, "wall")
    return frame, rays.reshape(-1, 3), plane


# ------------------------------------------------------------------ what an offset costs


@pytest.mark.parametrize("limit", [1, 2, 3])
@pytest.mark.parametrize(("moved", "spread"), [(0.0, 0.4), (0.57, 0.2), (-1.14, 0.7), (2.5, 1.5)])
def test_odds_are_those_of_counting(rng, moved, spread, limit):
    place = rng.uniform(0, 1, 200_000)
    error = moved + spread * rng.standard_normal(place.size)
    counted = np.mean(np.abs(np.floor(place + error)) < limit)
    assert calibration.count_odds(moved, spread, limit=limit) == pytest.approx(counted, abs=0.004)


def test_odds_of_a_faultless_beat_are_a_triangle():
    moved = np.linspace(-1.5, 1.5, 7)
    odds = calibration.count_odds(moved, 1e-9)
    np.testing.assert_allclose(odds, np.maximum(0, 1 - np.abs(moved)), atol=1e-8)
    consistent = calibration.consistent_odds(np.array([0.0, 0.49, 0.51]), 1e-9)
    np.testing.assert_allclose(consistent, [1, 1, 0], atol=1e-8)


def test_rate_of_moved_answers_is_that_of_counting(rng):
    place, error = rng.uniform(0, 1, 200_000), rng.integers(-3, 4, 200_000)
    shares = np.bincount(error + 3) / error.size
    for moved in (0.0, -0.57, 1.14, 2.0):
        counted = np.mean(np.floor(place + error + moved) == 0)
        assert calibration.moved_rate(shares, moved) == pytest.approx(counted, abs=0.004)
    assert calibration.moved_rate(shares, 5.0) == 0


@pytest.mark.parametrize("frequencies", [FREQUENCIES, (7.15e9, 14.28e9), (1.0e9, 1.1e9)])
def test_closure_and_beat_differ_by_the_phase_itself(rng, frequencies):
    offset = rng.normal(0, 0.01, (2, 50))
    low, high = frequencies
    turns = TAU * (high - round(high / low) * low) / low
    closure = calibration.closure_of(offset, frequencies) / turns
    moved = calibration.wraps_moved(offset, frequencies)
    np.testing.assert_allclose(moved - closure, offset[0] / TAU, atol=1e-12)


def test_an_offset_along_the_frequencies_is_a_range_error():
    offset = 0.3 * np.array(FREQUENCIES) / FREQUENCIES[0]
    assert abs(calibration.closure_of(offset, FREQUENCIES)) < 1e-12


@pytest.mark.parametrize("offset", [(0.0, 0.004), (-0.003, 0.0), (0.01, 0.0)])
def test_the_beat_moves_as_foretold(offset):
    frame, _, _ = wall(32, half_angle=0.02, tilt=(0, 0))
    held = [simulate(frame, noise_free=True, phase_offset=d, protocol="full") for d in (0, offset)]
    depth = [find_method("beat")(m, window=1).depth for m in held]
    moved = calibration.wraps_moved(offset, FREQUENCIES)
    np.testing.assert_allclose((depth[1] - depth[0]) / LENGTH, moved, atol=0.01)


@pytest.mark.parametrize("offset", [(0.0, 0.0), (0.0, 0.01), (0.01, 0.0)])
def test_rates_of_the_averaged_beat_on_a_wall(offset):
    """Averages of known noise are right as often as the closed form says."""
    frame, _, _ = wall(256, half_angle=0.25)
    m = simulate(frame, protocol="full", phase_offset=offset, seed=5)
    low, high = m.amplitude * np.exp(1j * m.phase)
    k = phase_from_depth(m.depth.astype(float), 20e6)
    size = 16
    sums = np.add.reduceat(np.add.reduceat(high * low.conj() ** 2 * np.exp(-1j * k),
                           np.arange(0, 256, size), 0), np.arange(0, 256, size), 1)  # fmt: skip
    error = np.angle(sums) / TAU * 357.5
    place = m.depth[8::size, 8::size] / LENGTH
    right = np.floor(place + error) == np.floor(place)
    spread = wrap_noise(0.1349, 0.1349, frequencies=FREQUENCIES) / size
    odds = calibration.count_odds(calibration.wraps_moved(offset, FREQUENCIES), spread)
    assert right.mean() == pytest.approx(float(odds), abs=4 * np.sqrt(0.25 / right.size))


# ------------------------------------------------------------------ the closure, modulo a wrap


@pytest.mark.parametrize("protocol", ["released", "full"])
@pytest.mark.parametrize("offset", [(0.0, 0.003), (0.01, 0.0), (-0.02, 0.05)])
def test_windows_without_noise_show_the_closure_modulo_a_wrap(offset, protocol):
    frame, _, _ = wall(128, distance=0.85, half_angle=0.4)
    m = simulate(frame, protocol=protocol, noise_free=True, phase_offset=offset)
    windows = calibration.window_closures(m, side=32)
    found = windows.value[np.isfinite(windows.spread)]
    assert found.size > 3
    turns = (found - calibration.closure_of(offset, FREQUENCIES)) / PERIOD
    assert np.abs(turns - np.rint(turns)).max() < 0.02


@pytest.mark.parametrize("spread", [0.3, 1.0, 1.8])
def test_pooled_closure_is_as_sure_as_it_says(rng, spread):
    """Against theory, a few hundred times over; spreads in radians of the circle."""
    scale, size = PERIOD / TAU, 300
    widths = scale * spread * rng.uniform(0.8, 1.2, size)
    errors = []
    for _ in range(400):
        value = scale * centred(2.5 + widths / scale * rng.standard_normal(size))
        found = calibration.pooled_closure(Closures(value, widths), FREQUENCIES)
        errors.append(centred(found.value / scale - 2.5) * scale)
    assert np.std(errors) == pytest.approx(found.spread, rel=0.12)
    assert abs(np.mean(errors)) < 4 * found.spread / np.sqrt(len(errors))


def test_spread_of_the_closure_in_its_two_limits():
    scale = PERIOD / TAU
    one = calibration.pooled_closure(Closures(np.zeros(25), np.full(25, 0.01 * scale)), FREQUENCIES)
    assert one.spread == pytest.approx(0.01 * scale / 5, rel=1e-3)
    vague = Closures(np.zeros(25), np.full(25, 9 * scale))
    assert calibration.pooled_closure(vague, FREQUENCIES).spread == PERIOD / np.sqrt(12)
    blind = Closures(np.zeros(2), np.full(2, np.inf))
    assert calibration.pooled_closure([blind, blind], FREQUENCIES).windows == 0


def test_windows_with_noise_know_how_sure_they_are():
    frame, _, _ = wall(256)
    scale, closure = PERIOD / TAU, 0.003
    errors, spreads = [], []
    for seed in range(6):
        m = simulate(frame, protocol="full", phase_offset=(0, closure), seed=seed)
        windows = calibration.window_closures(m, side=128)
        errors += list(centred((windows.value - closure) / scale))
        spreads += list(windows.spread / scale)
    # one window of 128 px: 107 rad of a pixel's closure over 128
    assert np.median(spreads) == pytest.approx(107 / 128, rel=0.03)
    assert np.std(errors) == pytest.approx(107 / 128, rel=0.4)


def test_edges_and_darkness_tell_nothing(rng):
    frame, _, _ = wall(64)
    depth = np.where(np.arange(64) < 30, frame.depth, frame.depth + 0.1234)
    edge = simulate(Frame(depth, frame.intensity), protocol="full")
    dark = simulate(Frame(depth, np.zeros((64, 64))), protocol="full")
    assert np.isinf(calibration.window_closures(edge, side=64).spread).all()
    vague = calibration.pooled_closure(calibration.window_closures(dark), FREQUENCIES)
    assert vague.spread == PERIOD / np.sqrt(12)


@pytest.mark.parametrize("offset", [0.004, -0.0085, 0.01])
def test_correction_restores_the_beat_up_to_whole_wraps(offset):
    """Within half a period all is as before; beyond it every wrap is off by the same whole one."""
    frame, _, _ = wall(96, half_angle=0.2)
    m = simulate(frame, protocol="full", noise_free=True, phase_offset=(0, offset))
    found = calibration.pooled_closure(calibration.window_closures(m, side=48), FREQUENCIES)
    better = calibration.corrected(m, (0, found.value))
    turns = round((offset - found.value) / PERIOD)
    assert turns == (abs(offset) > PERIOD / 2)
    scored = metrics.scored_pixels(cmtof.unwrap(better, method="beat", window=1), better)
    delta = scored["consistent"].astype(int) - scored["true_consistent"]
    assert np.mean(delta == turns) > 0.99


def test_correction_of_phases_is_that_of_psi(measured):
    offset = (0.3, -0.2)
    phases = Measurement.from_phase(measured.phase, measured.frequencies)
    two = [calibration.corrected(m, offset).phase for m in (measured, phases)]
    assert np.abs(centred(two[0] - two[1])).max() < 1e-4


# ------------------------------------------------------------------ whole wraps


@pytest.mark.parametrize("tangent", [0.05, 0.2, 0.4])
def test_bend_of_a_plane_seen_head_on(tangent):
    _, rays, plane = wall(64, half_angle=tangent, tilt=(0, 0))
    # fourth-order terms shrink it by about tan^2
    expected = np.sqrt(2 / 45) * tangent**2
    assert calibration.plane_bend(rays, plane) == pytest.approx(
        expected, rel=1.2 * tangent**2 + 2e-3
    )
    assert calibration.plane_bend(3 * rays, plane / 7) == pytest.approx(
        calibration.plane_bend(rays, plane)
    )


@pytest.mark.parametrize("error", [0.0, LENGTH, -3 * LENGTH])
def test_a_plane_tells_its_range_error(error):
    frame, rays, plane = wall(48)
    exact = 1 / (rays / np.linalg.norm(rays, axis=1, keepdims=True) @ plane)
    found = calibration.range_error_of_plane(exact + error, rays, noise=1e-4)
    assert found.error == pytest.approx(error, abs=1e-9)
    np.testing.assert_allclose(found.plane, plane, rtol=1e-6)
    assert frame.depth.shape == (48, 48)


def test_range_error_is_as_sure_as_it_says(rng):
    _, rays, plane = wall(24, half_angle=0.3)
    exact = 1 / (rays / np.linalg.norm(rays, axis=1, keepdims=True) @ plane)
    noise = 0.45e-3
    found = [
        calibration.range_error_of_plane(
            exact + LENGTH + noise * rng.standard_normal(exact.size), rays, noise=noise
        )
        for _ in range(200)
    ]
    errors = np.array([one.error for one in found])
    assert np.std(errors) == pytest.approx(found[0].spread, rel=0.2)
    assert errors.mean() == pytest.approx(LENGTH, abs=4 * found[0].spread / np.sqrt(200))
    wraps, odds = calibration.whole_wraps(found, FREQUENCIES[0])
    assert wraps == 1
    assert odds > 0.999


def test_small_planes_do_not_decide():
    _, rays, plane = wall(24, half_angle=0.01)
    exact = 1 / (rays / np.linalg.norm(rays, axis=1, keepdims=True) @ plane)
    found = calibration.range_error_of_plane(exact, rays, noise=0.45e-3)
    assert calibration.whole_wraps([found], FREQUENCIES[0])[1] < 0.05


# ------------------------------------------------------------------ a known target


@pytest.mark.parametrize("wrong", [0.0, 0.008])
def test_a_known_target_tells_both_offsets(wrong):
    """A target 8 mm off moves every range by 8 mm, and no wrap."""
    offset = np.array([0.04, -0.07])
    frame, _, _ = wall(128, half_angle=0.3)
    m = simulate(frame, protocol="full", phase_offset=offset, seed=1)
    found = calibration.offsets_at_known_range(m, m.depth.astype(float) + wrong)
    range_error = phase_from_depth(wrong, np.array(FREQUENCIES))
    assert np.abs(centred(found + range_error - offset)).max() < 4 * 0.135 / 128
    other, _, _ = wall(64, half_angle=0.1, distance=1.1)
    later = simulate(other, protocol="full", noise_free=True, phase_offset=offset)
    depth = cmtof.unwrap(calibration.corrected(later, found), method="beat", window=1)["depth"]
    error = depth.to_numpy() - other.depth
    assert np.median(error) == pytest.approx(wrong, abs=depth_from_phase(0.02, FREQUENCIES[0]))
    assert np.mean(np.abs(error - np.median(error)) < LENGTH / 4) > 0.95


# ------------------------------------------------------------------ bad input


def test_bad_input(measured):
    with pytest.raises(ValueError, match="Expected windows of 8 px or more"):
        calibration.window_closures(measured, side=4)
    phases = Measurement.from_phase(measured.phase, measured.frequencies)
    with pytest.raises(ValueError, match="Expected correlations, which tell the noise"):
        calibration.window_closures(phases)
    with pytest.raises(ValueError, match="Expected at least 4 pixels"):
        calibration.range_error_of_plane([1, 1, 1], np.eye(3), noise=1e-3)
