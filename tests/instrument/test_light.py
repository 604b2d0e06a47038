"""Light, modulators and drives of the simulated instrument against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from instrument_panels import DRIVE, EDGES, MODES, ORDER, profile, psi, ready
from scipy.special import jv

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.correlation import centred, decode
from cmtof.instrument.light import amplitude
from cmtof.instrument.settings import Air, Drive, TwinSettings
from cmtof.instrument.targets import Plane
from cmtof.instrument.world import LABEL_TIME, World

IDEAL = TwinSettings.ideal()


def phase_of(settings, z, mode, **knobs):
    """Decoded phase, rad, of a plane at a distance, m."""
    seen = profile(World(settings, Plane(z, reflectance=0.5)), ready(mode, **knobs))
    return decode(seen[0], psi()).phase


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("step", [1e-3, 4e-3, 12e-3])
def test_phase_grows_with_the_range(mode, step):
    wanted = 4 * np.pi * ORDER[mode] * DRIVE[mode] * step / SPEED_OF_LIGHT
    turned = phase_of(IDEAL, 0.6 + step, mode) - phase_of(IDEAL, 0.6, mode)
    assert centred(turned - wanted) == pytest.approx(0, abs=3e-3)


@pytest.mark.parametrize("mode", MODES)
def test_air_slows_the_light(mode):
    excess = World(replace(IDEAL, air=Air())).light.group_index - 1
    wanted = 4 * np.pi * ORDER[mode] * DRIVE[mode] * excess * 1.0 / SPEED_OF_LIGHT
    turned = phase_of(replace(IDEAL, air=Air()), 1.0, mode) - phase_of(IDEAL, 1.0, mode)
    assert centred(turned - wanted) == pytest.approx(0, abs=3e-3)


@pytest.mark.parametrize("mode", MODES)
def test_contrast_is_that_of_the_closed_form(mode):
    two_eta = 2 * IDEAL.drive.eta
    wanted = 2 * jv(1, two_eta) ** 2
    if mode == "doubled":
        wanted = 2 * jv(2, two_eta) ** 2 / (1 - jv(0, two_eta)) ** 2
    seen = profile(World(IDEAL, Plane(0.6, reflectance=0.5)), ready(mode))
    found = decode(seen[0], psi())
    assert found.amplitude / found.offset == pytest.approx(wanted, rel=2e-2)


def test_amplitude_follows_power_and_resonance():
    drive = Drive()
    full = abs(amplitude(drive, 30.0, 7.15e9))
    assert full == pytest.approx(drive.eta) == pytest.approx(abs(amplitude(drive, 30.0, 7.16e9)))
    assert abs(amplitude(drive, 30.0 - 20 * np.log10(2), 7.15e9)) == pytest.approx(full / 2)
    edge = drive.resonance + drive.width / 2
    at_peak, at_edge = (abs(amplitude(drive, 30.0, f)) for f in (drive.resonance, edge))
    assert at_edge / at_peak == pytest.approx(np.sqrt(0.5))


@pytest.mark.parametrize(
    "knobs",
    [{"laser_on": False}, {"shutter_open": False}, {"interlock_closed": False}],
    ids=lambda knobs: next(iter(knobs)),
)
def test_no_light_without(knobs):
    assert not profile(World(IDEAL, Plane(0.6)), ready("single", **knobs)).round(3).any()


def test_without_the_clock_only_the_mean_is_left():
    seen = profile(World(IDEAL, Plane(0.6)), ready("single", clock_on=False))
    assert np.ptp(seen) < 1e-3 < seen.mean()


def test_drivers_make_the_errors_that_they_are_said_to_have():
    skewed = replace(IDEAL, drive=replace(IDEAL.drive, iq_imbalance=0.02))
    light, phases = World(skewed).light, np.linspace(0, 6, 50)
    np.testing.assert_allclose(
        light._made_phase(0, phases) - phases, 0.02 * np.sin(2 * phases), atol=1e-12
    )
    coded = replace(IDEAL, drive=replace(IDEAL.drive, phase_step_error=5e-4))
    every = np.arange(65536) * 2 * np.pi / 65536
    error = World(coded, seed=4).light._made_phase(1, every) - every
    assert error.std() == pytest.approx(5e-4, rel=0.02)


def test_back_reflection_adds_a_constant_phasor():
    strong = replace(IDEAL, optics=replace(IDEAL.optics, back_fraction=2e-8, back_range=-0.1))
    wrap = SPEED_OF_LIGHT / (2 * DRIVE["single"])
    ranges = 0.6 + wrap * np.arange(16) / 16
    error = [centred(phase_of(strong, z, "single") - phase_of(IDEAL, z, "single")) for z in ranges]
    spectrum = 2 * np.abs(np.fft.rfft(error)) / 16
    assert spectrum[1] > 5 * spectrum[2:].max()
    assert abs(np.mean(error)) < 0.2 * spectrum[1]


def test_drift_follows_the_clock_of_the_labels():
    drifting = replace(IDEAL, drive=replace(IDEAL.drive, phase_drift=0.1))
    world = World(drifting, Plane(0.6), seed=2)
    labels = np.array([1, 2000, 40000])
    seen = profile(world, ready("single"), np.zeros((3, 2)), labels=labels)
    middle = LABEL_TIME * labels + EDGES.size / 24000 / 2
    lag = 0.1 / world.light._phase.RMS * world.light._phase(middle)
    phases = [decode(one, psi()).phase for one in seen]
    np.testing.assert_allclose(centred(np.diff(phases) + np.diff(lag)), 0, atol=5e-3)


@pytest.mark.parametrize("mode", MODES)
def test_reference_target_moves_with_the_stage(mode):
    world, panel = World(IDEAL, Plane(3.0)), ready(mode, flip_mirror_in=True)
    zero = IDEAL.reference.stage_zero
    seen = profile(world, panel, np.zeros((2, 2)), stage=[zero, zero + 2e-3])
    wanted = 4 * np.pi * ORDER[mode] * DRIVE[mode] * 2e-3 / SPEED_OF_LIGHT
    turned = decode(seen[1], psi()).phase - decode(seen[0], psi()).phase
    assert centred(turned - wanted) == pytest.approx(0, abs=3e-3)


def test_fast_detector_sees_both_modulation_rates():
    theta = 2 * np.pi * np.arange(64) / 64
    for mode in MODES:
        seen = np.abs(np.fft.rfft(World(IDEAL).fast_detector(ready(mode), theta)))[1:6]
        assert seen.argmax() + 1 == ORDER[mode]
