"""Light: modulators, paths, air, collection, speckle, against closed forms and brute force."""

from dataclasses import replace

import numpy as np
import pytest
from instrument_panels import DRIVE, MODES, ORDER, PLATE, ahead, edges, psi, ready
from scipy.special import jv

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.correlation import centred, decode, phase_from_depth
from cmtof.instrument import optics as free_space
from cmtof.instrument.budget import photon_budget
from cmtof.instrument.drift import Drift
from cmtof.instrument.drives import RfDrivers, amplitude, lock_state, played_phases
from cmtof.instrument.modulation import harmonics_at
from cmtof.instrument.panel import RfKnobs
from cmtof.instrument.settings import Air, Drive, Laser, Module, Optics, TwinSettings
from cmtof.instrument.targets import Hits, Plane
from cmtof.instrument.world import World
from cmtof.modulator import DOUBLED, SINGLE, TwoPassModulator

IDEAL = TwinSettings.ideal()


def light(settings, panel, *, distance=1.0, steps=16, seed=0, angles=None):
    """Light on the detector at each phase, W: no electronics, no rounding."""
    world = World(settings, Plane(distance), seed=seed)
    configuration = world.light.configuration(panel, edges(steps), 24000.0)
    angles = ahead() if angles is None else angles
    return world.light.on_detector(panel, angles, np.zeros(len(angles)), configuration)


def ideal(**drive):
    return TwinSettings.ideal(drive=replace(IDEAL.drive, **drive))


# --- modulators --------------------------------------------------------------------------------


@pytest.mark.parametrize("eta", [0.26, np.pi / 4])
def test_contrasts_of_both_modes(eta):
    found = {m: decode(light(ideal(eta=eta), ready(m)).T, psi()).contrast[0] for m in MODES}
    assert found["single"] == pytest.approx(2 * jv(1, 2 * eta) ** 2, rel=2e-4)
    expected = 2 * jv(2, 2 * eta) ** 2 / (1 - jv(0, 2 * eta)) ** 2
    # the mirror's distance is matched to 7.15 GHz, so 7.16 GHz loses a little of its eta
    assert found["doubled"] == pytest.approx(expected, rel=2e-4)


@pytest.mark.parametrize("eta", [0.26, np.pi / 4])
def test_signal_of_the_doubled_mode_is_the_square_of_j2_over_j1(eta):
    amplitude_of = {m: decode(light(ideal(eta=eta), ready(m)).T, psi()).amplitude[0] for m in MODES}
    ratio = (jv(2, 2 * eta) / jv(1, 2 * eta)) ** 2
    assert amplitude_of["doubled"] / amplitude_of["single"] == pytest.approx(ratio, rel=2e-4)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("internal", [0.0, 0.5])
def test_phase_is_linear_in_depth_over_many_wraps(mode, internal):
    settings = TwinSettings.ideal(optics=replace(IDEAL.optics, internal_path=internal))
    frequency = ORDER[mode] * DRIVE[mode]
    for z in np.linspace(0.5, 7.4, 23):
        phase = decode(light(settings, ready(mode), distance=z).T, psi()).phase[0]
        assert abs(centred(phase - phase_from_depth(z + internal, frequency))) < 1e-9


@pytest.mark.parametrize(("mode", "sign"), [("single", -1), ("doubled", -2)])
def test_the_drive_of_the_detection_steps_down_when_psi_steps_up(mode, sign):
    """psi = -k phi_drive + const: the only sign that makes decoding give +4 pi f z / c."""
    table = ready(mode).detection.table
    moved = ready(mode)
    moved.detection.table = np.mod(table + 0.3, 2 * np.pi)
    phases = [decode(light(IDEAL, p).T, psi()).phase[0] for p in (ready(mode), moved)]
    assert centred(phases[1] - phases[0]) == pytest.approx(sign * 0.3, abs=1e-9)


@pytest.mark.parametrize(
    ("eta", "steps", "low", "high"),
    [
        (0.26, 4, 1.1e-4, 1.5e-4),
        (np.pi / 4, 4, 13e-3, 17e-3),
        (0.26, 16, 0, 1e-9),
        (0.9, 16, 0, 1e-9),
    ],
)
def test_cyclic_error_of_the_third_harmonic(eta, steps, low, high):
    """(J3/J1)^2 aliases into four steps of the single mode: 0.13 and 15 mrad; sixteen lose it."""
    distances = 1.0 + np.linspace(0, 0.02, 41)
    error = [
        centred(
            decode(
                light(ideal(eta=eta), ready("single", steps=steps), distance=z, steps=steps).T,
                psi(steps),
            ).phase[0]
            - phase_from_depth(z + 0.5, 7.15e9)
        )
        for z in distances
    ]
    assert low <= np.abs(error).max() <= high
    if low:
        assert np.abs(error).max() == pytest.approx(
            (jv(3, 2 * eta) / jv(1, 2 * eta)) ** 2, rel=0.05
        )


def brute_force(settings, panel, distance):
    """Average over a period of the product of both transmissions, V by V, light by light."""
    drives = RfDrivers(settings.drive, 0).at_crystals(panel, np.arange(16))
    theta = 2 * np.pi * np.arange(1024) / 1024
    delay = (
        4 * np.pi * drives.frequency / SPEED_OF_LIGHT * (distance + settings.optics.internal_path)
    )
    found = np.empty(16)
    for step in range(16):
        passed = []
        for module, phasor, lag, plate in (
            (settings.emission, drives.emission[step], delay, panel.plate_angle[0]),
            (settings.detection, drives.detection[step], 0.0, panel.plate_angle[1]),
        ):
            element = TwoPassModulator(
                half_wave_angle=plate,
                input_axis="horizontal",
                mirror_distance=module.mirror_distance,
                frequency=drives.frequency,
                quarter_wave_angle_error=module.quarter_wave_angle_error,
                half_wave_retardance_error=module.half_wave_retardance_error,
                mirror_reflectance=module.mirror_reflectance,
                transmitted_extinction=module.transmitted_extinction,
                reflected_extinction=module.reflected_extinction,
            )
            first = (phasor * np.exp(1j * (theta - lag))).imag
            second = (phasor * np.exp(1j * (theta - lag + element.pass_delay))).imag
            passed.append(element.transmission(first, second))
        found[step] = np.mean(passed[0] * passed[1])
    return found


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("leakage", [0.0, 0.05])
def test_harmonics_equal_a_brute_force_average(mode, leakage):
    module = Module(
        quarter_wave_angle_error=0.02,
        half_wave_retardance_error=-0.05,
        mirror_distance=0.0225,
        transmitted_extinction=500.0,
        reflected_extinction=50.0,
    )
    settings = TwinSettings.ideal(
        emission=module,
        detection=replace(module, quarter_wave_angle_error=-0.01, mirror_distance=0.02),
        drive=replace(IDEAL.drive, leakage=leakage, leakage_phase=0.8, iq_imbalance=0.02),
    )
    found = light(settings, ready(mode), distance=1.234)[0]
    expected = brute_force(settings, ready(mode), 1.234)
    # plane of reflectance 1/2, straight ahead; laser 0.15 W times 1/4 of fibre
    hits = Hits(np.array(1.234), np.array(1.0), np.array(0.5))
    share = free_space.returned_fraction(settings.optics, "diffuse", hits)
    loss = free_space.outward(settings.optics) * free_space.inward(settings.optics)
    np.testing.assert_allclose(found, 0.15 * 0.25 * share * loss * expected, rtol=3e-8)


@pytest.mark.parametrize("modulator", [SINGLE, DOUBLED])
def test_interpolated_harmonics(modulator):
    eta = np.array([0.0, 1e-3, 0.26, 0.7854, 1.1])
    exact = np.stack([replace(modulator, eta=e).harmonics(16) for e in eta])
    np.testing.assert_allclose(harmonics_at(modulator, eta), exact, atol=1e-9)


# --- drives ------------------------------------------------------------------------------------


def test_eta_follows_power_and_resonance():
    drive = Drive()
    stated = amplitude(drive, 30.0, 7.15e9)
    assert abs(stated) == pytest.approx(np.pi / 4)
    assert abs(amplitude(drive, 30.0, 7.16e9)) == pytest.approx(np.pi / 4)
    assert abs(amplitude(drive, 24.0, 7.15e9)) == pytest.approx(np.pi / 4 * 10 ** (-6 / 20))
    top = abs(amplitude(drive, 30.0, 7.155e9))
    for side in (-1, 1):  # half the power at half the width, on either side
        edge = amplitude(drive, 30.0, 7.155e9 + side * 10e6)
        assert abs(edge) ** 2 == pytest.approx(top**2 / 2)
        assert np.angle(edge) == pytest.approx(-side * np.pi / 4)


def test_lock_of_the_drivers():
    drive, on = Drive(), RfKnobs(on=True, power=30.0)
    near = lock_state(drive, on, 7.15e9, clocked=True)
    assert near.locked
    assert near.detuning == pytest.approx(-5e6)
    assert near.reflected == pytest.approx(30 + 10 * np.log10(0.2 + 1e-3))
    assert not lock_state(drive, on, 7.1399e9, clocked=True).locked
    assert not lock_state(drive, on, 7.1701e9, clocked=True).locked
    assert not lock_state(drive, on, 7.15e9, clocked=False).locked
    assert not lock_state(drive, RfKnobs(on=False), 7.15e9, clocked=True).locked


@pytest.mark.parametrize(
    ("armed", "index", "seen", "played"),
    [
        (True, 0, [-1, 0, 1, 3, 4], [0, 0, 1, 3, 0]),
        (False, 3, [-1, 0, 1], [3, 0, 1]),
        (False, 1, [-1, 0, 7], [1, 2, 1]),
    ],
)
def test_played_entries_of_the_table(armed, index, seen, played):
    knobs = RfKnobs(table=np.arange(4) / 10, index=index, armed=armed, trigger=True, phase=9.0)
    np.testing.assert_allclose(played_phases(knobs, np.array(seen)), np.array(played) / 10)
    idle = replace(knobs, trigger=False)
    np.testing.assert_allclose(played_phases(idle, np.array(seen)), 9.0)


def test_errors_of_the_phase_codes_are_fixed_by_seed_and_code():
    drive = replace(IDEAL.drive, phase_step_error=2e-3)
    made = RfDrivers(drive, 5)
    again = RfDrivers(drive, 5)
    asked = np.linspace(0, 2 * np.pi, 4000, endpoint=False)
    error = made.phase(1, asked) - asked
    np.testing.assert_array_equal(again.phase(1, asked), made.phase(1, asked))
    assert np.std(error) == pytest.approx(2e-3, rel=0.06)  # 5 sigma of 4000 draws
    assert not np.array_equal(error, made.phase(0, asked) - asked)
    skewed = RfDrivers(ideal(iq_imbalance=0.01).drive, 0)
    np.testing.assert_allclose(skewed.phase(0, asked) - asked, 0.01 * np.sin(2 * asked), atol=1e-15)


def test_leakage_turns_the_emission_as_the_detection_steps():
    """1 + l exp(-i phi_d): a phase of -l sin(phi_d), which repeats with the step of psi."""
    drives = RfDrivers(ideal(leakage=1e-3).drive, 0).at_crystals(ready("single"), np.arange(16))
    swing = np.angle(drives.emission)
    phi_d = ready("single").detection.table
    np.testing.assert_allclose(swing - swing.mean(), -1e-3 * np.sin(phi_d), atol=2e-6)


def test_phase_offset_is_the_same_for_every_depth():
    settings = ideal(phase_offset=0.4)
    for mode in MODES:
        shifts = [
            centred(
                decode(light(settings, ready(mode), distance=z).T, psi()).phase[0]
                - decode(light(IDEAL, ready(mode), distance=z).T, psi()).phase[0]
            )
            for z in (0.7, 1.9, 5.2)
        ]
        np.testing.assert_allclose(shifts, -ORDER[mode] * 0.4, atol=1e-9)


@pytest.mark.parametrize("mode", MODES)
def test_drift_of_the_phase_enters_as_often_as_the_drive(mode):
    settings = ideal(phase_drift=0.05)
    world = World(settings, Plane(1.0), seed=6)
    configuration = world.light.configuration(ready(mode), edges(), 24000.0)
    starts = np.array([0.0, 40.0, 300.0])
    found = world.light.on_detector(ready(mode), ahead(3), starts, configuration)
    turned = centred(
        decode(found.T, psi()).phase - phase_from_depth(1.5, ORDER[mode] * DRIVE[mode])
    )
    drift = 0.05 / Drift.RMS * Drift(6, 1)(starts + 320 / 24000 / 2)
    assert np.ptp(drift) > 0.02
    np.testing.assert_allclose(turned, -ORDER[mode] * drift, atol=2e-4)


# --- air, spot, collection ---------------------------------------------------------------------


def test_group_index_of_air():
    standard = Air(temperature=288.15, pressure=101325.0)
    step = 1e-12
    sides = [phase_index(532e-9 + s) for s in (-step, step)]
    expected = phase_index(532e-9) - 532e-9 * (sides[1] - sides[0]) / (2 * step)
    assert free_space.group_index(standard, 532e-9) == pytest.approx(expected, abs=1e-9)
    # the phase index that refractiveindex.info gives for Ciddor 1996
    assert phase_index(532e-9) == pytest.approx(1.00027820, abs=2e-8)
    assert free_space.group_index(Air(pressure=0.0), 532e-9) == 1.0
    thin = free_space.group_index(Air(temperature=288.15 * 1.1, pressure=50662.5), 532e-9) - 1
    assert thin == pytest.approx((expected - 1) / 2.2)


def phase_index(wavelength):
    square = (1e-6 / wavelength) ** 2
    return 1 + 0.05792105 / (238.0185 - square) + 0.00167917 / (57.362 - square)


@pytest.mark.parametrize("mode", MODES)
def test_air_stretches_ranges(mode):
    settings = TwinSettings.ideal(air=Air(), optics=replace(IDEAL.optics, internal_path=0.0))
    index = free_space.group_index(Air(), 532e-9)
    assert 160e-6 < (index - 1) * 0.6 < 180e-6  # metres at 60 cm: five times the claimed precision
    phase = decode(light(settings, ready(mode), distance=0.6).T, psi()).phase[0]
    expected = phase_from_depth(0.6 * index, ORDER[mode] * DRIVE[mode])
    assert abs(centred(phase - expected)) < 1e-9


def test_back_reflection_adds_a_constant_phasor():
    optics = replace(IDEAL.optics, back_fraction=2e-8, back_range=-0.123)
    with_it = TwinSettings.ideal(optics=optics)
    hits = Hits(np.array(1.0), np.array(1.0), np.array(0.5))
    for z in 1.0 + np.linspace(0, 0.02, 9):
        share = free_space.returned_fraction(optics, "diffuse", hits._replace(range=np.array(z)))
        ratio = 2e-8 / share
        assert 0.01 < ratio < 0.1
        phase = decode(light(with_it, ready("single"), distance=z).T, psi()).phase[0]
        wanted = phase_from_depth(z + 0.5, 7.15e9)
        stray = phase_from_depth(-0.123 + 0.5, 7.15e9)
        expected = np.angle(1 + ratio * np.exp(1j * (stray - wanted)))
        assert centred(phase - wanted) == pytest.approx(expected, abs=1e-9)


def test_returned_fractions():
    optics = IDEAL.optics
    z = np.array([0.5, 1.0, 2.0])
    hits = Hits(z, np.full(3, 0.8), np.full(3, 0.6))
    area = np.pi * optics.aperture**2 / 4
    diffuse = free_space.returned_fraction(optics, "diffuse", hits)
    np.testing.assert_allclose(diffuse, 0.5 * 0.6 * 0.8 * area / (np.pi * z**2))
    facing = hits._replace(cosine=np.ones(3))
    for material in ("specular", "retro"):
        found = free_space.returned_fraction(optics, material, facing)
        assert (np.diff(found) < 0).all()
        assert (found > 50 * diffuse).all()
    # a mirror that is 1 degree off sends the beam past; a retro-reflector does not care
    off = hits._replace(cosine=np.full(3, np.cos(np.deg2rad(1.0))))
    assert (free_space.returned_fraction(optics, "specular", off) < 0.1 * diffuse).all()
    np.testing.assert_array_equal(
        free_space.returned_fraction(optics, "retro", off),
        free_space.returned_fraction(optics, "retro", facing),
    )
    # nothing returns more than it got, nor from nowhere
    close = Hits(np.array([1e-6, np.nan]), np.ones(2), np.ones(2))
    for material in ("diffuse", "specular", "retro"):
        share = free_space.returned_fraction(optics, material, close)
        assert share[0] <= 1.02
        assert share[1] == 0


def test_spot_averages_phasors_over_a_slanted_plane():
    """A Gaussian spot on a slope damps the fundamental by exp(-(4 pi f s)^2 / 2 c^2)."""
    tilt, divergence = np.deg2rad(60.0), 1.5e-3
    optics = replace(IDEAL.optics, divergence=divergence)
    amplitudes = []
    for spread in (replace(optics, divergence=0.0), optics):
        world = World(TwinSettings.ideal(optics=spread), Plane(1.0, tilt_x=tilt), seed=0)
        configuration = world.light.configuration(ready("doubled"), edges(), 24000.0)
        found = world.light.on_detector(ready("doubled"), ahead(), np.zeros(1), configuration)
        amplitudes.append(decode(found.T, psi()).amplitude[0])
    # range changes by tan(tilt) per radian; the spot's sigma is half its 1/e^2 radius
    sigma = np.tan(tilt) * divergence / 2
    damped = np.exp(-0.5 * (4 * np.pi * 14.32e9 / SPEED_OF_LIGHT * sigma) ** 2)
    assert 0.5 < damped < 0.95
    assert amplitudes[1] / amplitudes[0] == pytest.approx(damped, rel=0.02)


@pytest.mark.parametrize("divergence", [0.7e-3, 3e-3])
def test_speckle_follows_the_gamma_law(divergence):
    optics = replace(IDEAL.optics, divergence=divergence, exit_radius=2e-4, speckle=True)
    settings = TwinSettings.ideal(optics=optics)
    angles = np.stack([np.linspace(-0.01, 0.01, 4000), np.zeros(4000)], axis=1)
    found = light(settings, ready("single"), angles=angles).mean(axis=1)
    calm = replace(optics, speckle=False)
    found /= light(TwinSettings.ideal(optics=calm), ready("single"), angles=angles).mean(axis=1)
    cells = float(free_space.speckle_cells(optics, 532e-9, 1.0))
    assert found.mean() == pytest.approx(1, abs=5 / np.sqrt(4000 * cells))
    # a gamma law of M cells has variance 1/M; its estimate scatters by sqrt((2 + 6/M)/n)
    assert found.var() * cells == pytest.approx(1, abs=5 * np.sqrt((2 + 6 / cells) / 4000))


def test_defocus_makes_more_cells():
    cells = [
        free_space.speckle_cells(Optics(divergence=d), 532e-9, 1.0) for d in (5e-4, 1e-3, 2e-3)
    ]
    assert cells[0] < cells[1] < cells[2]


def test_speckle_is_the_same_in_both_modes_and_for_ever():
    settings = replace(TwinSettings(), noise=False)
    angles = np.linspace(-0.01, 0.01, 50)[:, None] * [1.0, 0.5]
    worlds = [World(settings, Plane(1.0), seed=3) for _ in range(2)]
    fractions = [worlds[0].light.paths(ready(mode), angles).fraction for mode in MODES]
    np.testing.assert_array_equal(fractions[0], fractions[1])
    backwards = worlds[1].light.paths(ready("single"), angles[::-1]).fraction[::-1]
    np.testing.assert_array_equal(fractions[0], backwards)
    other = World(settings, Plane(1.0), seed=4).light.paths(ready("single"), angles).fraction
    assert not np.array_equal(fractions[0], other)


# --- budget ------------------------------------------------------------------------------------


def test_budget_agrees_with_the_world():
    settings = TwinSettings.ideal(laser=Laser(fibre_low=0.25, fibre_high=0.25, power=0.15))
    for mode in MODES:
        lines = {line.name: line for line in photon_budget(settings, mode=mode)}
        found = decode(light(settings, ready(mode)).T, psi())
        assert lines["On the detector"].value == pytest.approx(found.offset[0], rel=1e-3)
        assert lines["Correlation contrast"].value == pytest.approx(found.contrast[0], rel=1e-3)
        assert all(line.unit and line.source for line in lines.values())
        volts = found.offset[0] * World(settings, None).conversion.volts_per_watt
        assert lines["Detector output"].value == pytest.approx(volts, rel=1e-3)


def test_default_sends_the_paper_s_three_milliwatts():
    sent = {line.name: line.value for line in photon_budget(TwinSettings())}
    assert sent["Sent to the scene"] == pytest.approx(3e-3, rel=0.1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [({"mode": "triple"}, "Expected mode"), ({"distance": 0.0}, "Expected a range above 0 m")],
)
def test_budget_refuses_nonsense(arguments, message):
    with pytest.raises(ValueError, match=message):
        photon_budget(TwinSettings(), **arguments)


def test_plates_decide_the_mode():
    assert PLATE["doubled"] == 2 * PLATE["single"]
    turned = ready("single")
    turned.plate_angle = [PLATE["doubled"]] * 2
    single = decode(light(IDEAL, turned).T, psi()).amplitude[0]
    assert single < 1e-9 * decode(light(IDEAL, ready("single")).T, psi()).amplitude[0]
