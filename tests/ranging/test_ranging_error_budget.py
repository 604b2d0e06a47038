"""The error budget: each closed form against the simulated instrument, and how parts add up."""

from dataclasses import replace

import numpy as np
import pytest

from cmtof.correlation import TAU, cyclic_error, decode, depth_from_phase
from cmtof.instrument.optics import group_index
from cmtof.instrument.settings import TwinSettings
from cmtof.modulator import DOUBLED, single_mode_harmonics
from cmtof.ranging import cyclic
from cmtof.ranging.budget_forms import (
    air_spread,
    back_ratio,
    drift_spread,
    foretold,
    power_slope,
    ramp_error,
    residual_ratio,
)
from cmtof.ranging.budget_needs import (
    drive_of_aliasing,
    offset_needs,
    plate_of_ratio,
    scatter_needs,
)
from cmtof.ranging.budget_terms import TERMS, TOGETHER, Term, with_real
from cmtof.ranging.error_budget import (
    errors,
    over_a_wrap,
    ranger_of,
    rms,
    slope_errors,
    slope_scatter,
)
from cmtof.ranging.optical import FREQUENCY
from cmtof.ranging.sweep import offset_and_scatter, parts
from cmtof.ranging.target import StageTarget

PLATE = StageTarget()
SWEEP = np.linspace(-5e-4, 5e-4, 21)
FEW = np.linspace(-5e-4, 5e-4, 5)
MODES = ("single", "doubled")


def changed(section, **values):
    """A term that sets fields of one section."""

    def change(settings):
        return replace(settings, **{section: replace(getattr(settings, section), **values)})

    return Term(label="", change=change)


def along_a_wrap(term, mode, **rest):
    """Phase errors (64,), rad, over a wrap, and the turn that they belong to."""
    turn = over_a_wrap(term, PLATE, mode=mode, seed=3, **rest)
    return turn.error * 4 * np.pi * FREQUENCY[mode] / 299792458.0, turn


def centred(values):
    return values - values.mean()


# --- cyclic errors: the simulated instrument follows the closed form ------------------------------


@pytest.mark.parametrize("mode", MODES)
def test_a_back_reflection_errs_as_an_arcsine(mode):
    ratio = 0.05
    share = ratio / back_ratio(PLATE) * TwinSettings().optics.back_fraction
    found, turn = along_a_wrap(changed("optics", back_fraction=share), mode)
    # the target gets fainter over the wrap
    fading = ratio * ((0.6 + turn.positions) / 0.6) ** 2
    exact = cyclic.back_reflection(turn.phase, turn.stray, fading)
    np.testing.assert_allclose(found, centred(exact), atol=1e-3)
    fine = cyclic.back_reflection(np.linspace(0, TAU, 100001), 0.0, ratio)
    assert fine.max() == pytest.approx(np.arcsin(ratio), rel=1e-6)
    assert rms(exact) == pytest.approx(ratio / np.sqrt(2), rel=0.01)


def test_an_imbalance_errs_as_sin_two_phi_in_the_single_mode():
    found, turn = along_a_wrap(changed("drive", iq_imbalance=0.01), "single")
    # rounding, and the square of the imbalance
    np.testing.assert_allclose(found, cyclic.imbalance(turn.phase, 0.01), atol=5e-4)


def test_an_imbalance_leaves_the_doubled_mode_alone():
    found, _ = along_a_wrap(changed("drive", iq_imbalance=0.02), "doubled")
    # second order in the imbalance, and rounding
    assert rms(found) < 1e-3


def test_four_steps_alias_the_third_harmonic():
    found, turn = along_a_wrap(TERMS["four"], "single")
    eta = TwinSettings().drive.eta
    form = cyclic.aliasing(turn.phase, eta, steps=4)
    np.testing.assert_allclose(found, form, atol=1e-3)
    assert np.abs(form).max() == pytest.approx(0.015, rel=0.02)
    wave = single_mode_harmonics(eta, 16)
    exact = cyclic_error(wave, wave, phase=turn.phase, samples=4)
    np.testing.assert_allclose(form, exact, atol=3e-4)
    assert np.abs(cyclic.aliasing(turn.phase, eta, steps=16)).max() < 1e-20


@pytest.mark.parametrize("mode", MODES)
def test_leaking_drives_bend_the_doubled_mode_only(mode):
    leak, eta = 2e-3, TwinSettings().drive.eta
    found, turn = along_a_wrap(changed("drive", leakage=leak), mode)
    form = cyclic.leakage(
        turn.phase, np.full(64, turn.lag), leak * turn.leak, eta, steps=16, mode=mode
    )
    np.testing.assert_allclose(found, centred(form), atol=1e-3)
    if mode == "single":
        assert rms(form) < 1e-12
    else:
        assert rms(found) > 2e-3


def test_plates_out_of_place_leave_the_drive_itself_in_the_doubled_mode():
    found, turn = along_a_wrap(TERMS["modulators"], "doubled")
    form = cyclic.residual_fundamental(turn.phase, residual_ratio(), steps=16)
    np.testing.assert_allclose(found, centred(form), atol=1.5e-3)
    # two wraps later it is the same, one wrap later the other way round
    again = cyclic.residual_fundamental(turn.phase + TAU, residual_ratio(), steps=16)
    np.testing.assert_allclose(again, -form, atol=1e-15)


def test_random_codes_err_as_the_square_root_of_their_number():
    rng = np.random.default_rng(0)
    psi, phase = cyclic.uniform_steps(16), TAU * np.arange(64) / 64
    off = rng.normal(0, 1e-3, (4000, 1, 16))
    found = decode(np.moveaxis(np.cos(phase[:, None] + psi + off), -1, 0), psi).phase - phase
    found = np.angle(np.exp(1j * found))
    constant, wave = cyclic.code_noise(1e-3, steps=16)
    assert found.mean(1).std() == pytest.approx(constant, rel=0.03)
    assert rms(found - found.mean(1, keepdims=True)) == pytest.approx(wave, rel=0.03)


def test_a_ramp_of_the_power_errs_as_told():
    psi, phase, ramp = cyclic.uniform_steps(16), np.linspace(0, TAU, 50), 1e-3
    power = 1 + ramp * ((np.arange(16) + 0.5) / 16 - 0.5)
    signal = power * (1 / 0.6 + np.cos(phase[:, None] + psi))
    found = np.angle(np.exp(1j * (decode(signal.T, psi).phase - phase)))
    np.testing.assert_allclose(
        found, cyclic.power_ramp(phase, np.full(50, ramp), 0.6, steps=16), atol=2e-7
    )


# --- each term alone, over days -------------------------------------------------------------------


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", ["drift", "laser", "codes", "back", "weather"])
def test_a_term_is_as_large_as_foretold(name, mode):
    days = 30
    found = rms(errors(TERMS[name], PLATE, FEW, mode=mode, days=days, seed=5).zeroed)
    floor = rms(errors(TERMS["sixteen"], PLATE, FEW, mode=mode, days=8, seed=5).zeroed)
    # a cyclic error is one number a day: 3 standard errors of its rms
    form = foretold(name, PLATE, mode=mode)
    assert found == pytest.approx(np.hypot(form, floor), rel=3 / np.sqrt(2 * days))


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("target", [StageTarget(), StageTarget.mirror()], ids=["plate", "mirror"])
def test_photon_noise_reaches_the_bound(mode, target):
    places = np.linspace(-5e-4, 5e-4, 512)
    found = errors(TERMS["photons"], target, places, mode=mode, days=8, seed=1).raw
    form = foretold("photons", target, mode=mode) / np.sqrt(1 + 1 / 8)
    # 4000 readings: a standard error of 1.1 %
    assert rms(found - found.mean()) == pytest.approx(form, rel=0.03)


def test_air_that_is_ignored_is_a_constant_and_a_scale():
    air = TwinSettings().air
    excess = group_index(air, 532e-9) - 1
    found = errors(TERMS["air"], PLATE, SWEEP, days=4, seed=0)
    raw = parts(found.raw, SWEEP)
    assert raw.offset == pytest.approx(excess * 0.6, rel=0.01)
    assert raw.ratio.min() > 0.999
    # the reference stood at the same range, and the same air
    assert rms(parts(found.zeroed, SWEEP).offset) < 0.2e-6
    kelvin = air_spread(0.6) / np.hypot(0.5 / air.temperature, 100 / air.pressure)
    assert kelvin == pytest.approx(excess * 0.6)


def test_a_slope_scatters_by_the_spot_and_its_speckle():
    settings = TwinSettings()
    for tilt in (0.1, 0.4):
        found = slope_errors(settings, tilt, distance=0.6, count=4000, seed=0)
        # the spot stretches along a slope, so its mean moves as well
        form = slope_scatter(settings, tilt, distance=0.6)
        assert found.std() == pytest.approx(form, rel=0.04)
    flat = slope_errors(settings, 0.0, distance=0.6, count=400, seed=0)
    assert np.abs(flat).max() < 1e-6


def test_drift_since_the_reference():
    assert drift_spread(np.zeros(1), np.zeros(1)) == pytest.approx(0)
    one = drift_spread(np.arange(500) + 5e4, np.zeros(1))
    assert one == pytest.approx(np.sqrt(2), rel=0.05)


# --- all together ---------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", MODES)
def test_squares_add_up(mode):
    found = errors(TOGETHER, PLATE, FEW, mode=mode, days=40, seed=2).zeroed
    apart = [foretold(name, PLATE, mode=mode)
             for name in ("photons", "amplifier", "converter", "laser", "drift", "codes",
                          "imbalance", "leakage", "back", "weather", "stage")]  # fmt: skip
    total = np.sqrt(np.sum(np.square(apart)))
    assert rms(found) == pytest.approx(total, rel=0.2)


def test_scatter_alone_adds_up():
    noisy = ("photons", "amplifier", "converter")
    each = [rms(parts(errors(TERMS[n], PLATE, SWEEP, days=10, seed=4).raw, SWEEP).scatter)
            for n in noisy]  # fmt: skip
    both = Term(label="", change=lambda s: replace(s, noise=True, detector=TwinSettings().detector))
    found = rms(parts(errors(both, PLATE, SWEEP, days=10, seed=9).raw, SWEEP).scatter)
    assert found == pytest.approx(np.sqrt(np.sum(np.square(each))), rel=0.1)


def test_the_ratio_tells_constants_from_scatter():
    rng = np.random.default_rng(0)
    noise = rng.normal(0, 1e-5, (400, 200))
    at = np.linspace(0, 1e-3, 200)
    assert np.median(parts(noise, at).ratio) == pytest.approx(np.sqrt(2 / np.pi), rel=0.01)
    assert parts(noise + 1e-3, at).ratio.min() > 0.999
    found = parts(noise + 5e-5, at)
    implied = [offset_and_scatter(r, m)[1] for r, m in zip(found.rmse, found.mae, strict=True)]
    assert np.mean(implied) == pytest.approx(1e-5, rel=0.02)


def test_the_reference_hands_its_noise_on_as_a_constant():
    found = errors(TERMS["reference"], PLATE, FEW, days=36, seed=3)
    form = foretold("reference", PLATE, mode="single")
    assert rms(parts(found.zeroed, FEW).offset) == pytest.approx(form, rel=0.35)
    assert rms(parts(found.raw, FEW).offset) < 0.2e-6


def test_the_first_reading_as_zero_is_exact_there():
    assert not errors(TERMS["photons"], PLATE, SWEEP, days=2, seed=0).first[:, 0].any()


def test_the_same_seed_gives_the_same_errors():
    first = errors(TOGETHER, PLATE, SWEEP, days=2, seed=7)
    again = errors(TOGETHER, PLATE, SWEEP, days=2, seed=7)
    for one, other in zip(first, again, strict=True):
        np.testing.assert_array_equal(one, other)


def test_small_numbers():
    assert 3e-4 < power_slope() < 2e-3
    assert np.abs(ramp_error([0.0, 1.0], "single")).max() < 1e-3
    assert with_real("drive.leakage", "optics.speckle")(TwinSettings.ideal()).optics.speckle
    assert foretold("air", PLATE, mode="single") is None
    assert depth_from_phase(foretold("stage", PLATE, mode="single"), 1.0) > 0


# --- what it would take ---------------------------------------------------------------------------


def needs(error, mode, which=offset_needs):
    return {need.label: need for need in which(error, PLATE, mode=mode)}


def test_needed_sizes_make_the_error_again():
    error = 33.5e-6
    phase = 4 * np.pi * FREQUENCY["single"] * error / 299792458.0
    ways = needs(error, "single")
    ratio = ways["back-reflection over target"].size
    crest = cyclic.back_reflection(np.linspace(0, TAU, 10001), 0.0, ratio).max()
    assert crest == pytest.approx(phase, rel=1e-5)
    assert 10 * np.log10(ratio) == pytest.approx(-20, abs=0.1)
    eta = ways["drive, with 4 steps"].size
    crest = cyclic.aliasing(np.linspace(0, TAU, 10001), eta, steps=4).max()
    assert crest == pytest.approx(phase, rel=1e-4)
    skew = ways["I/Q imbalance"].size
    assert cyclic.imbalance(np.pi / 4, skew) == pytest.approx(phase)
    path = ways["air left out, path in it"].size
    assert path * (group_index(TwinSettings().air, 532e-9) - 1) == pytest.approx(error)


def test_needed_plates_leave_what_they_should():
    eta, tilt = TwinSettings().drive.eta, plate_of_ratio(0.01)
    plates = {"half_wave_angle": np.pi / 8 + tilt, "eta": eta, "mirror_distance": None}
    wave = np.abs(replace(DOUBLED, **plates).harmonics(4))
    assert (wave[1] / wave[2]) ** 2 == pytest.approx(0.01, rel=1e-6)


@pytest.mark.parametrize("mode", MODES)
def test_less_light_scatters_as_needed(mode):
    light = needs(7.5e-6, mode, scatter_needs)["light"].size
    dim = replace(TwinSettings.ideal(), noise=True)
    dim = replace(dim, laser=replace(dim.laser, power=dim.laser.power * light))
    found = ranger_of(dim, mode, {}).bound(PLATE, [0.0])[0]
    assert found == pytest.approx(7.5e-6, rel=0.02)


# --- bad inputs -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: cyclic.uniform_steps(2), "at least 3 steps"),
        (lambda: cyclic.imbalance(0.0, 0.1, mode="triple"), "mode single or doubled, got 'triple'"),
        (lambda: errors(TERMS["back"], PLATE, SWEEP, days=0, seed=0), "at least 1 day"),
        (lambda: errors(TERMS["back"], PLATE, SWEEP, days=1, seed=0, visits=2), "3 visits"),
        (lambda: errors(Term(label="", ranging={"colour": 1}), PLATE, SWEEP, days=1, seed=0),
         "fields of OpticalRanger, got colour"),
        (lambda: foretold("weight", PLATE, mode="single"), "a term out of photons"),
        (lambda: offset_needs(0.0, PLATE, mode="single"), "an error above 0 m, got 0"),
        (lambda: drive_of_aliasing(0.5), "a phase error from 0 to"),
        (lambda: with_real("drive.colour"), "names like drive.leakage, got 'drive.colour'"),
    ],
)  # fmt: skip
def test_bad_inputs_say_what_to_do(call, message):
    with pytest.raises(ValueError, match=message):
        call()
