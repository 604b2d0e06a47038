"""The array behind a modulator: étendue, the gate over the field, noise against its bound."""

from dataclasses import replace

import numpy as np
import pytest

from cmtof.instrument.settings import Optics, TwinSettings
from cmtof.modulator import DOUBLED, SINGLE
from cmtof.ranging.array_sensor import ArrayImager, Electrons, Sensor
from cmtof.ranging.crystal import LITHIUM_NIOBATE, LITHIUM_TANTALATE, Crystal

IMAGER = ArrayImager(pixels=8)


def test_retardance_is_a_saddle():
    crystal, wavelength = LITHIUM_NIOBATE, 532e-9
    gamma = crystal.retardance(0, 0, wavelength)
    assert gamma == pytest.approx(2 * np.pi * 5e-3 / wavelength * (2.234 - 2.323))
    s = 0.02
    x = crystal.retardance(s, 0, wavelength) - gamma
    z = crystal.retardance(0, s, wavelength) - gamma
    assert x == pytest.approx(gamma * s**2 / (2 * 2.323 * 2.234), rel=1e-3)
    assert z == pytest.approx(-gamma * s**2 / (2 * 2.323**2), rel=1e-3)


@pytest.mark.parametrize("crystal", [LITHIUM_NIOBATE, LITHIUM_TANTALATE])
def test_square_field_keeps_to_the_tolerance(crystal):
    s = crystal.acceptance(0.2, 532e-9)
    grid = np.linspace(-s, s, 41)
    change = crystal.retardance(*np.meshgrid(grid, grid), 532e-9)
    change = np.abs(change - crystal.retardance(0, 0, 532e-9))
    assert change.max() == pytest.approx(0.2, rel=0.02)


def test_acceptance_scales_with_the_root_of_tolerance_over_length():
    s = LITHIUM_NIOBATE.acceptance(0.1, 532e-9)
    assert LITHIUM_NIOBATE.acceptance(0.4, 532e-9) == pytest.approx(2 * s)
    assert replace(LITHIUM_NIOBATE, length=2e-2).acceptance(0.4, 532e-9) == pytest.approx(s)
    assert Crystal(ordinary=2.2, extraordinary=2.2).acceptance(0.1, 532e-9) == 1.0


def test_transit():
    assert Crystal(length=1e-5).transit(7.15e9) == pytest.approx(1, abs=1e-4)
    full = Crystal(group_index=2.0, length=299792458 / 2e10 / 2)
    assert full.transit(1e10) == pytest.approx(2 / np.pi, rel=1e-6)


def test_etendue_is_conserved_and_counts_points():
    wide, narrow = replace(IMAGER, half_field=0.4), replace(IMAGER, half_field=0.1)
    for imager in (wide, narrow):
        scene = (2 * imager.pupil * np.sin(imager.half_field)) ** 2
        assert scene == pytest.approx(imager.etendue)
    assert wide.resolvable == narrow.resolvable == pytest.approx(IMAGER.etendue / 532e-9**2)
    # a tantalate is ended by its aperture, not by its retardance
    tantalate = replace(IMAGER, crystal=LITHIUM_TANTALATE)
    assert tantalate.acceptance == pytest.approx(2.5e-3 / tantalate.way)
    assert tantalate.unvignetted(tantalate.acceptance, 0) == pytest.approx(0, abs=1e-12)
    assert tantalate.unvignetted(0, 0) == 1


@pytest.mark.parametrize("mode", ["single", "doubled"])
def test_gate_is_that_of_the_jones_matrices(mode):
    imager = replace(IMAGER, mode=mode)
    base, order = (SINGLE, 1) if mode == "single" else (DOUBLED, 2)
    wavelength, eta = imager.twin.laser.wavelength, imager.twin.drive.eta
    for sines in ((0.0, 0.0), (0.018, 0.0), (0.0, 0.015), (0.02, 0.01)):
        change = imager.crystal.retardance(*sines, wavelength)
        change = float(change - imager.crystal.retardance(0, 0, wavelength))
        delay = float(imager.pass_delay(*sines))
        distance = delay * 299792458 / (4 * np.pi * base.frequency)
        jones = replace(base, eta=eta, static_retardance=change, mirror_distance=distance)
        w = jones.harmonics(2)
        mean, fundamental = imager.gate(*sines)
        assert mean == pytest.approx(w[0].real, abs=1e-9)
        assert fundamental == pytest.approx(w[order], abs=1e-9)


@pytest.mark.parametrize("mode", ["single", "doubled"])
def test_field_error_is_a_quarter_of_the_longer_way(mode):
    # the middle of the passes comes later by half the way, the range by half of that
    imager = replace(IMAGER, mode=mode)
    s = 0.02
    way = 2 * imager.twin.detection.mirror_distance * (1 / np.sqrt(1 - s**2) - 1)
    way += 5e-3 * 2.5 * (1 / np.sqrt(1 - (s / 2.323) ** 2) - 1)
    assert imager.field_error(s, 0) == pytest.approx(way / 4, rel=1e-6)
    assert imager.field_error(0, 0) == 0


def test_light_of_a_pixel():
    rates, far = IMAGER.electrons(1.0), IMAGER.electrons(2.0)
    assert rates.amplitude == pytest.approx(4 * far.amplitude)
    # a pixel's light is the field's, whatever the number of pixels
    many = replace(IMAGER, pixels=16).electrons(1.0)
    assert rates.amplitude == pytest.approx(4 * many.amplitude)
    # twice the field: a quarter of the pupil's area
    wide = replace(IMAGER, half_field=float(np.arcsin(2 * np.sin(0.2)))).electrons(1.0)
    assert rates.amplitude == pytest.approx(4 * wide.amplitude)
    quiet = replace(
        IMAGER,
        twin=TwinSettings(optics=Optics(ambient_radiance=0.0)),
        sensor=Sensor(dark_current=0.0),
    )
    dark = quiet.electrons(1.0)
    from cmtof.correlation import correlation_contrast
    from cmtof.modulator import single_mode_harmonics

    w = single_mode_harmonics(quiet.twin.drive.eta, 2)
    assert dark.amplitude / dark.mean == pytest.approx(correlation_contrast(w, w))


def test_time_for_a_precision():
    rates = IMAGER.electrons(1.0)
    time = float(IMAGER.time_for(rates, 0.01))
    t = time / 16
    noise = np.sqrt(2 / 16 * (rates.mean * t + IMAGER.sensor.noise**2)) / (rates.amplitude * t)
    assert noise == pytest.approx(0.01, rel=1e-9)
    # photon noise alone: four times the time for half the noise
    quiet = replace(IMAGER, sensor=Sensor(read_noise=0.0, full_well=1.0, bits=16))
    assert quiet.time_for(rates, 0.005) == pytest.approx(4 * quiet.time_for(rates, 0.01), rel=1e-4)


def _spread(reflectance, time):
    """Rms error of 96 000 draws over the bound: known to 0.3 % with a confidence of 95 %."""
    z = np.linspace(0.9, 1.1, 64).reshape(8, 8)
    frame = IMAGER.frames(
        z, reflectance=reflectance, time=time, repeats=1500, seed=3, speckle=False
    )
    pull = frame.error.mean(0) / frame.bound[0] * np.sqrt(1500)
    assert np.abs(pull).max() < 4.5
    return np.sqrt(np.mean(frame.error**2) / np.mean(frame.bound**2))


def test_frames_reach_the_bound():
    # a dark surface: room light and dark current make the noise of all phases alike
    assert _spread(0.02, 200.0) == pytest.approx(1, abs=0.03)


def test_least_squares_loses_a_little_where_the_light_itself_swings():
    # variance v (1 + m cos): weights would gain 2 (1 - sqrt(1 - m^2)) / m^2 of the variance
    rates = IMAGER.electrons(1.0, across=0.01, along=0.01)
    m = rates.amplitude / rates.mean
    gain = np.sqrt(2 * (1 - np.sqrt(1 - m**2)) / m**2)
    assert gain > 1.03
    assert _spread(0.5, 20.0) == pytest.approx(gain, abs=0.01)


def test_multipath_moves_the_range():
    z = np.full((8, 8), 1.0)
    ratio = np.full((8, 8), 1 + 0.1j)
    frame = IMAGER.frames(z, ratio=ratio, time=1e3, speckle=False)
    wrap = 299792458 / (2 * 7.15e9)
    expected = -np.angle(1 + 0.1j) / (2 * np.pi) * wrap
    assert frame.error.mean() == pytest.approx(expected, rel=0.02)


def test_readings_and_speckle():
    assert IMAGER.readings(Electrons(np.array(100.0), np.array(50.0)), 16.0) == 1
    assert IMAGER.readings(Electrons(np.array(1e4), np.array(5e3)), 16.0) == 2
    z = np.full((8, 8), 1.0)
    light = IMAGER.frames(z, repeats=400, seed=2).electrons[:, 4, 4]
    room = IMAGER.electrons(1e6, across=IMAGER.grid()[0][4, 4], along=IMAGER.grid()[1][4, 4])
    signal = light - room.mean / 16
    contrast = signal.std() / signal.mean()
    assert contrast == pytest.approx(1 / np.sqrt(IMAGER.speckle_cells), rel=0.15)


def test_bad_input():
    with pytest.raises(ValueError, match="ranges of 8 x 8 pixels"):
        IMAGER.frames(np.ones((4, 4)))
    with pytest.raises(ValueError, match=r"array\.mode out of"):
        ArrayImager(mode="triple")
    with pytest.raises(ValueError, match=r"crystal\.length from"):
        Crystal(length=-1.0)
    with pytest.raises(ValueError, match=r"sensor\.efficiency from"):
        Sensor(efficiency=2.0)
