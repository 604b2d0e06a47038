"""Interferometer: contrast, phase reading, counting and its limit, vibration, speckle, bound."""

from dataclasses import replace

import numpy as np
import pytest

from cmtof.correlation import correlation_from_phase, decode
from cmtof.instrument.optics import group_index
from cmtof.instrument.settings import Air, Optics, TwinSettings
from cmtof.ranging import michelson as light
from cmtof.ranging.disturbance import Speckle, drift, vibration, vibration_spread
from cmtof.ranging.fringes import (
    apparent_step,
    fringe_phase,
    fringe_range,
    lost_fringes,
    slip_rate,
    step_response,
)
from cmtof.ranging.interferometer import Interferometer
from cmtof.ranging.michelson import Michelson
from cmtof.ranging.target import StageTarget

WAVELENGTH = 532e-9
SMOOTH = TwinSettings(optics=Optics(speckle=False))
SILENT = replace(SMOOTH, noise=False)
MIRROR, PLATE = StageTarget.mirror(), StageTarget()


# --- light ---------------------------------------------------------------------------------------


def test_the_phase_index_gives_back_the_group_index():
    air, step = Air(), 1e-11
    index = [light.phase_index(air, WAVELENGTH + d) for d in (-step, 0, step)]
    slope = (index[2] - index[0]) / (2 * step)
    assert index[1] - WAVELENGTH * slope == pytest.approx(group_index(air, WAVELENGTH), abs=1e-9)
    assert light.phase_index(Air(pressure=0.0), WAVELENGTH) == pytest.approx(1, abs=1e-15)


def test_the_line_halves_at_its_coherence_length():
    ruler = Michelson()
    # |gamma|^2 of a Gaussian line is 1/2 at tau = sqrt(2) ln 2 / (pi dnu)
    half = np.sqrt(2) * np.log(2) / (np.pi * ruler.linewidth) * light.SPEED_OF_LIGHT / 2
    assert light.coherence(ruler, 0.6 + half, 0.6) ** 2 == pytest.approx(0.5)
    assert light.coherence(replace(ruler, linewidth=0.0), 5.0, 0.6) == 1


def test_modes_that_match():
    focused = Optics(divergence=0.0, exit_radius=0.25e-3)
    whole = light.matched_share(focused, Michelson(), MIRROR, WAVELENGTH)
    assert whole == pytest.approx(1.0)  # the same waist comes back
    # one mode against the number of speckle cells, where the mode is far smaller than a cell
    narrow = Michelson(reference_radius=1e-5)
    area = np.pi * Optics().aperture ** 2 / 4
    share = light.matched_share(Optics(), narrow, PLATE, WAVELENGTH)
    assert share == pytest.approx(2 * np.pi * narrow.reference_radius**2 / area, rel=0.01)


def test_the_mean_share_of_speckle_in_the_reference_mode():
    """Draw speckle fields of the stated coherence and project them onto the mode."""
    rng = np.random.default_rng(3)
    optics, ruler = Optics(), Michelson()
    side, count = 1.6e-3, 40
    x = (np.arange(count) + 0.5) / count * side - side / 2
    inverse = (np.pi * float(light.spot_radius(optics, 0.6)) / (WAVELENGTH * 0.6)) ** 2
    gap = x[:, None] - x
    values, vectors = np.linalg.eigh(np.exp(-inverse * gap**2 / 2))
    root = vectors * np.sqrt(np.maximum(values, 0))
    mode = np.exp(-((x / ruler.reference_radius) ** 2)) * np.sqrt(2 / np.pi)
    mode = mode / np.sqrt(ruler.reference_radius) * (2 / np.pi) ** -0.25 * side / count
    # one axis; the share of both axes is the product
    draws = (rng.standard_normal((20000, count)) @ root.T) @ mode
    area = np.pi * optics.aperture**2 / 4
    share = light.matched_share(optics, ruler, PLATE, WAVELENGTH)
    assert np.mean(draws**2) ** 2 / area == pytest.approx(share, rel=0.06)


def test_grey_filters_keep_both_arms_off_saturation():
    for target in (MIRROR, PLATE):
        found = light.fringes(SMOOTH, Michelson(), target, 0.6)
        assert float(found.offset + found.amplitude) < SMOOTH.detector.saturation
        assert 0 < found.amplitude < found.offset
    assert light.fringes(SILENT, Michelson(), MIRROR, 0.6).variance == 0


# --- reading and counting ------------------------------------------------------------------------


def test_the_gains_of_steps_with_a_scale_error_are_exact():
    psi, error = Michelson().psi, 0.07
    phase = np.linspace(-3, 3, 13)
    read = decode(correlation_from_phase(phase, (1 + error) * psi, amplitude=2.0, offset=5.0), psi)
    plus, minus = step_response(psi, error)
    turned = np.exp(1j * phase)
    # uniform nominal steps keep the offset out
    expected = 2.0 * (plus * turned + minus * np.conj(turned))
    np.testing.assert_allclose(read.amplitude * np.exp(1j * read.phase), expected, atol=1e-12)


def test_range_and_phase_are_inverse():
    z = np.array([0.0, 1e-7, 0.6])
    np.testing.assert_allclose(fringe_range(fringe_phase(z, WAVELENGTH), WAVELENGTH), z)
    assert fringe_phase(WAVELENGTH / 2, WAVELENGTH) == pytest.approx(2 * np.pi)


@pytest.mark.parametrize("share", [0.2, 0.999, -0.999, 1.001, -1.001, 2.9, 3.1])
def test_unwrapping_ends_at_a_quarter_wavelength_exactly(share):
    step = share * WAVELENGTH / 4
    phase = fringe_phase(step * np.arange(200), WAVELENGTH)
    found = fringe_range(np.unwrap(np.angle(np.exp(1j * phase))), WAVELENGTH)
    np.testing.assert_allclose(np.diff(found), apparent_step(step, WAVELENGTH), atol=1e-15)
    right = abs(share) < 1
    assert np.allclose(np.diff(found), step) == right


def test_fifty_micrometres_cannot_be_unwrapped_in_one_step():
    ruler = Interferometer(SILENT, Michelson.steady(speed=1.0))
    positions = 50e-6 * np.arange(21)
    assert ruler.path(positions).places.size == 21
    found = ruler.sweep(MIRROR, positions, repeats=1, seed=0)[0] - MIRROR.distance
    expected = apparent_step(50e-6, ruler.wavelength) * np.arange(21)
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert 2 * 50e-6 / ruler.wavelength == pytest.approx(188, abs=0.1)


@pytest.mark.parametrize("margin", [0.99, 1.01])
def test_a_move_is_counted_right_below_the_limit_and_backwards_above(margin):
    ruler = Interferometer(SILENT)
    speed = margin * ruler.wavelength / 4 / ruler.michelson.reading_time
    ruler = Interferometer(SILENT, Michelson.steady(speed=speed))
    travel = 400 * ruler.michelson.stride
    found = ruler.sweep(MIRROR, [0.0, travel], repeats=1, seed=0)[0, 1] - MIRROR.distance
    right = travel if margin < 1 else 400 * apparent_step(ruler.michelson.stride, ruler.wavelength)
    assert found == pytest.approx(right, abs=1e-12)


def test_without_disturbance_every_position_is_found():
    positions = np.array([3e-5, -2e-5, -2e-5, 4e-5])
    found = Interferometer(SILENT, Michelson.steady()).sweep(PLATE, positions, repeats=2, seed=1)
    np.testing.assert_allclose(found, np.tile(PLATE.distance + positions, (2, 1)), atol=1e-13)


def test_a_wrong_wavelength_scales_the_travel():
    ruler = Interferometer(SILENT, Michelson.steady(wavelength_error=1e-3))
    found = ruler.sweep(MIRROR, [0.0, 4e-6, 8e-6], repeats=200, seed=5) - MIRROR.distance
    scale = found[:, 2] / 8e-6 - 1
    np.testing.assert_allclose(found[:, 1] / 4e-6 - 1, scale, atol=1e-9)
    assert scale.std() == pytest.approx(1e-3, rel=0.15)  # 3 standard errors of 200


# --- disturbances --------------------------------------------------------------------------------


def test_vibration_has_its_rms_and_its_change():
    rng = np.random.default_rng(0)
    shape = {"rms": 2e-8, "frequency": 30.0, "quality": 5.0}
    found = vibration(rng, 400_000, 2e-3, **shape)
    assert found.std() == pytest.approx(2e-8, rel=0.02)
    for lag in (1, 5, 40):
        spread = np.std(found[lag:] - found[:-lag])
        assert spread == pytest.approx(float(vibration_spread(lag * 2e-3, **shape)), rel=0.02)
    assert vibration_spread(1e3, **shape) == pytest.approx(2e-8 * np.sqrt(2))


def test_drift_begins_at_zero_and_forgets():
    rng = np.random.default_rng(1)
    runs = np.array([drift(rng, 200, 1.0, rms=0.3, time=20.0) for _ in range(2000)])
    assert not runs[:, 0].any()
    expected = 0.3 * np.sqrt(2 * (1 - np.exp(-np.array([10, 199]) / 20.0)))
    np.testing.assert_allclose(runs[:, [10, 199]].std(0), expected, rtol=0.05)


def test_speckle_is_circular_gaussian_with_its_length():
    rng = np.random.default_rng(2)
    places = np.linspace(0, 6e-3, 61)
    speckle = Speckle(places, 1e-3)
    field = np.array([speckle.draw(rng) for _ in range(20_000)])
    intensity = np.abs(field) ** 2
    np.testing.assert_allclose(intensity.mean(0), 1, atol=0.03)
    assert np.mean(intensity < 0.1) == pytest.approx(1 - np.exp(-0.1), rel=0.05)
    assert abs(np.mean(field**2)) < 0.02
    together = np.mean(field[:, 30:] * np.conj(field[:, 30:31]), axis=0)
    expected = np.exp(-(((places[30:] - places[30]) / 1e-3) ** 2))
    np.testing.assert_allclose(together, expected, atol=0.03)


def test_fringes_lost_to_vibration():
    """Mean loss and rate of slips of whole sweeps against the closed forms, 400 runs."""
    ruler = Interferometer(SILENT, Michelson.steady(table_rms=120e-9, speed=3e-5))
    travel, repeats = 400 * ruler.michelson.stride, 400
    found = ruler.sweep(MIRROR, [0.0, travel], repeats=repeats, seed=7)[:, 1] - MIRROR.distance
    spread = ruler.change_spread
    # rounding leaves the mean alone: vibration at the last reading is symmetric
    lost = np.rint((travel - found) / (ruler.wavelength / 2))
    expected = 400 * lost_fringes(ruler.michelson.stride, spread, ruler.wavelength)
    assert expected > 0.5
    assert lost.mean() == pytest.approx(expected, abs=4 * lost.std() / np.sqrt(repeats))
    both = slip_rate(ruler.michelson.stride, spread, ruler.wavelength)
    assert lost_fringes(ruler.michelson.stride, spread, ruler.wavelength) <= both
    assert lost_fringes(0.0, spread, ruler.wavelength) == 0


def test_a_frozen_reading_stands_for_the_full_simulation():
    """Slips of readings as phasors and step by step agree: 40 runs of 1000 readings each."""
    rough = TwinSettings()
    ruler = Interferometer(rough, Michelson(table_rms=120e-9, speckle_length=1e-4, mount_rms=0.0))
    positions = [0.0, 1000 * ruler.michelson.stride]
    lost = {}
    for full in (False, True):
        runs = [ruler.record(PLATE, positions, seed=s, full=full) for s in range(40)]
        off = np.array([run.truth[-1] - run.counted[-1] for run in runs])
        lost[full] = np.rint(off / (ruler.wavelength / 2))
    error = np.hypot(lost[False].std(), lost[True].std()) / np.sqrt(40)
    assert lost[False].mean() > 5 * error
    assert lost[True].mean() == pytest.approx(lost[False].mean(), abs=3 * error)
    assert lost[True].std() == pytest.approx(lost[False].std(), rel=0.5)


def test_frozen_and_full_readings_agree_without_vibration():
    ruler = Interferometer(SILENT, Michelson.steady(sweep_error=0.02))
    runs = [ruler.record(MIRROR, [0.0, 2e-6], seed=4, full=full) for full in (False, True)]
    np.testing.assert_allclose(runs[0].counted, runs[1].counted, atol=1e-14)


def test_speckle_turns_phase_and_count_where_it_is_dark():
    quick = Interferometer(TwinSettings(), Michelson.steady(speckle_length=2e-6))
    slow = Interferometer(TwinSettings(), Michelson.steady(speckle_length=20e-3))
    positions = np.linspace(0, 1e-4, 3)
    found = [r.sweep(PLATE, positions, repeats=20, seed=3)[:, -1] for r in (quick, slow)]
    error = [np.median(np.abs(f - PLATE.distance - 1e-4)) for f in found]
    assert error[0] > 3e-7 > 3e-9 > error[1]


# --- bound and interface -------------------------------------------------------------------------


@pytest.mark.parametrize("target", [MIRROR, PLATE])
@pytest.mark.parametrize("full", [False, True])
def test_monte_carlo_reaches_the_bound(target, full):
    ruler = Interferometer(SMOOTH, Michelson.steady(speed=1e-6))
    run = ruler.record(target, [0.0, 2e-5], seed=0, full=full)
    error = run.counted - run.truth
    bound = ruler.bound(target, [0.0])[0]
    # 12 000 readings tell a standard deviation to 0.65 %
    assert run.truth.size > 11_000
    assert error.std() == pytest.approx(bound, rel=0.03)
    assert abs(error.mean()) < 0.05 * bound


def test_the_bound_rises_with_the_lost_contrast():
    ruler = Interferometer(SMOOTH)
    near, far = ruler.bound(PLATE, [1e-3, 5e-3])
    ratio = light.coherence(ruler.michelson, 0.601, 0.601) / light.coherence(
        ruler.michelson, 0.605, 0.601
    )
    assert far / near == pytest.approx(float(ratio), rel=0.03)


def test_repeats_are_the_same_however_many():
    ruler = Interferometer(TwinSettings())
    positions = np.linspace(0, 1e-5, 4)
    many = ruler.sweep(PLATE, positions, repeats=5, seed=11)
    np.testing.assert_array_equal(ruler.sweep(PLATE, positions, repeats=2, seed=11), many[:2])
    assert not np.array_equal(ruler.sweep(PLATE, positions, repeats=2, seed=12), many[:2])
    run = ruler.record(PLATE, positions, seed=11)
    np.testing.assert_allclose(run.counted[run.stations][1:] + PLATE.distance, many[0, 1:])
    assert ruler.sweep(PLATE, [2e-4], repeats=2, seed=0).tolist() == [[0.6002]] * 2


@pytest.mark.parametrize("positions", [[], [[0.0, 1.0]], [0.0, np.nan]])
def test_bad_positions(positions):
    ruler = Interferometer(TwinSettings())
    with pytest.raises(ValueError, match="Expected finite positions of shape"):
        ruler.sweep(PLATE, positions, repeats=1, seed=0)
    with pytest.raises(ValueError, match="Expected finite positions of shape"):
        ruler.bound(PLATE, positions)


def test_bad_repeats_and_settings():
    with pytest.raises(ValueError, match="Expected at least 1 repeat, got 0"):
        Interferometer(TwinSettings()).sweep(PLATE, [0.0], repeats=0, seed=0)
    with pytest.raises(ValueError, match=r"Expected interferometer\.steps to be a whole number"):
        Michelson(steps=8.5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"Expected interferometer\.table_rms from 0 to 0\.001"):
        Michelson(table_rms=-1.0)
