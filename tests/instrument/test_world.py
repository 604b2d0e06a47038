"""The world as the servers ask it: gates, clock, galvo, frames, power meter, fast detector."""

from dataclasses import replace

import numpy as np
import pytest
from instrument_panels import DRIVE, MODES, ORDER, ahead, edges, psi, ready

from cmtof.correlation import centred, decode, phase_from_depth
from cmtof.instrument.electronics import CENTRE, volts_from_counts
from cmtof.instrument.settings import Galvo, Optics, Reference, TwinSettings
from cmtof.instrument.targets import Corner, Plane
from cmtof.instrument.world import World
from cmtof.scenes import load_frame
from cmtof.scenes.frame import Frame

BURST = {"scans": 320, "rate": 24000.0, "pulses": edges()}
IDEAL = TwinSettings.ideal()


def decoded(world, panel, **options):
    counts = world.burst(panel, **{**BURST, **options}).astype(float)
    return decode(counts.reshape(16, -1)[:, 4:].mean(axis=1), psi())


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("distance", [0.83, 1.2345, 2.5])
def test_calibrated_phase_is_the_range(mode, distance):
    """A target at known range takes the constant away, errors of the rig included."""
    settings = replace(TwinSettings(), noise=False, optics=Optics(speckle=False, back_fraction=0))
    frequency = ORDER[mode] * DRIVE[mode]
    phases = [
        decoded(World(settings, Plane(z), seed=1), ready(mode, label=1), volts_range=1.0).phase
        for z in (0.6, distance)
    ]
    index = World(settings, None).light.group_index
    expected = phase_from_depth(index * (distance - 0.6), frequency)
    # rounding to counts, table errors that depend on psi, drift
    assert abs(centred(phases[1] - phases[0] - expected)) < 8e-3


@pytest.mark.parametrize("knob", ["laser_on", "shutter_open", "interlock_closed"])
def test_each_gate_darkens(knob):
    world = World(TwinSettings.ideal(), Plane(1.0))
    dark = ready("single")
    setattr(dark, knob, False)
    assert (world.burst(dark, **BURST) == CENTRE).all()
    assert world.laser_power(dark) == 0
    assert world.burst(ready("single"), **BURST).mean() > CENTRE + 100


def test_room_light_stays_when_the_shutter_closes():
    world = World(replace(TwinSettings(), noise=False), Plane(1.0))
    dark = ready("single")
    dark.shutter_open = False
    counts = world.burst(dark, **BURST)
    assert np.ptp(counts) <= 1
    assert counts.mean() > CENTRE + 20


def test_open_arm_of_the_interferometer_saturates():
    world = World(TwinSettings(), Plane(1.0))
    panel = ready("single")
    panel.beam_block_in = False
    counts = world.burst(panel, **BURST)
    volts = volts_from_counts(counts, volts_range=10.0)
    assert np.abs(volts - 4.1).max() < 0.05


def test_close_white_paper_saturates_only_the_crest():
    volts = volts_from_counts(
        World(TwinSettings(), Plane(0.3, reflectance=0.9)).burst(ready("single"), **BURST),
        volts_range=10.0,
    )
    assert volts.max() < 4.1 + 0.01
    assert (volts > 4.0).mean() > 0.2
    assert volts.min() < 2.5


def test_flip_mirror_and_stage():
    settings = replace(IDEAL, reference=Reference(distance=0.6, stage_zero=0.025))
    world = World(settings, None)
    phases = []
    for position in (0.025, 0.0262):
        panel = ready("single", flip_mirror_in=True, stage_position=position)
        phases.append(decoded(world, panel).phase)
    assert abs(centred(phases[0] - phase_from_depth(0.6 + 0.5, 7.15e9))) < 1e-3
    assert centred(phases[1] - phases[0]) == pytest.approx(
        phase_from_depth(0.0012, 7.15e9), abs=1e-3
    )


def test_no_scene_returns_nothing():
    world = World(IDEAL, None)
    assert (world.burst(ready("single"), **BURST) == CENTRE).all()
    assert np.isnan(world.ranges(ahead())).all()


def test_galvo_angles():
    """0.5 V per mechanical degree: 4 optical degrees a volt; offsets; both signs alike."""
    world = World(replace(IDEAL, galvo=Galvo(offset_x=0.1)), None)
    found = world.angles(ready("single", galvo_volts=[1.1, -2.0]))
    np.testing.assert_allclose(np.rad2deg(found), [4.0, -8.0])
    plain = World(IDEAL, None)
    for volts in ([3.0, 1.0], [-3.0, 1.0]):
        mirrored = plain.angles(ready("single", galvo_volts=[-v for v in volts]))
        np.testing.assert_allclose(mirrored, -plain.angles(ready("single", galvo_volts=volts)))


def test_frames_are_seen_through_their_camera():
    frame = load_frame("room")
    world = World(IDEAL, frame)
    assert frame.camera is not None
    fx, fy, cx, cy = frame.camera
    for row, column in ((120, 160), (30, 40), (200, 300)):
        x, y = (column + 0.5 - cx) / fx, (row + 0.5 - cy) / fy
        angles = np.arctan([x, y])
        assert world.ranges(angles)[0] == pytest.approx(frame.depth[row, column], rel=1e-6)
    edge = np.arctan((320 - cx) / fx)
    inside, outside = world.ranges([[edge - 1e-6, 0.0], [edge + 1e-6, 0.0]])
    assert np.isfinite(inside)
    assert np.isnan(outside)


def test_scan_of_a_frame_gives_its_ranges_modulo_a_wrap():
    frame = load_frame("still_life")
    world = World(replace(IDEAL, laser=replace(IDEAL.laser, power=0.3)), frame)
    tangent = np.linspace(-0.15, 0.15, 12)
    x, y = np.meshgrid(np.arctan(tangent), np.arctan(tangent))
    angles = np.stack([x, y], axis=-1).reshape(-1, 2)
    phase = decode(world.image(ready("single"), angles).T, psi()).phase
    error = centred(phase - phase_from_depth(world.ranges(angles) + 0.5, 7.15e9))
    assert np.abs(error).max() < 0.01


def test_pixels_without_depth_return_nothing():
    depth = np.full((20, 20), 1.0)
    depth[:, 10:] = np.nan
    frame = Frame(depth, np.ones((20, 20)), np.array([50.0, 50.0, 10.0, 10.0]))
    world = World(IDEAL, frame)
    left, right = world.image(ready("single"), [[-0.1, 0.0], [0.1, 0.0]])
    assert left.mean() > CENTRE + 100
    assert (right == CENTRE).all()


def test_a_drive_that_is_off():
    world = World(IDEAL, Plane(1.0))
    panel = ready("single")
    panel.detection.on = False
    assert decoded(world, panel).amplitude < 0.1
    panel = ready("doubled")
    panel.emission.on = False  # the dark bias of the doubled mode lets nothing out
    assert (world.burst(panel, **BURST) == CENTRE).all()


def test_without_the_clock_the_drivers_drift_apart():
    world = World(IDEAL, Plane(1.0))
    panel = ready("single")
    panel.clock_on = False
    # 2.86 kHz of beat: it is seen in the samples, and averages out of a phase
    counts = world.burst(panel, **BURST).astype(float)
    assert counts.std() > 200
    kept = counts.reshape(16, 20)
    assert kept.mean(axis=1).std() < 0.2 * counts.std()
    assert not world.lock(panel, "emission").locked


def test_unequal_drives_beat():
    """Two drives 75 Hz apart sweep psi by themselves: one turn in a burst."""
    # at small eta the waveforms have no harmonics to speak of
    world = World(replace(IDEAL, drive=replace(IDEAL.drive, eta=0.26)), Plane(1.0))
    panel = ready("single")
    panel.detection.trigger = False
    panel.detection.frequency += 75.0
    counts = world.burst(panel, **BURST).astype(float) - CENTRE
    time = np.arange(320) / 24000
    phase = phase_from_depth(1.5, 7.15e9)
    mean = counts.mean()
    # its phase lags by -2 pi 75 t, so psi rises; the three poles delay by their time constants
    delay = 1 / (2 * np.pi * 1e5) + 1 / (2 * np.pi * 1e4) + 20e-6
    expected = mean * (1 + 0.1263 * np.cos(phase + 2 * np.pi * 75 * (time - delay)))
    assert np.abs(counts - expected)[5:].max() < 0.6 + 0.001 * mean


def test_the_clock_scales_both_drives():
    world = World(IDEAL, Plane(1.0))
    panel = ready("single", clock_frequency=10.01e6)
    assert world.lock(panel, "detection").detuning == pytest.approx(7.15e9 * 1.001 - 7.155e9)
    phase = decoded(world, ready("single", clock_frequency=10e6 * (1 + 1e-4))).phase
    assert abs(centred(phase - phase_from_depth(1.5, 7.15e9 * (1 + 1e-4)))) < 2e-3


def test_power_meter_follows_the_fibre():
    world = World(TwinSettings(), None, seed=4)
    times = np.arange(0, 1000.0, 5.0)
    read = np.array([world.laser_power(ready("single", time=t)) for t in times])
    # lenses, a mirror, a splitter, and the module's mean of a half through its silver mirror
    fibre = read / (0.15 * 0.99**2 * 0.97 * 0.45 * 0.5 * 0.97)
    assert fibre.min() > 0.195
    assert fibre.max() < 0.305
    assert np.ptp(fibre) > 0.02
    assert world.laser_power(ready("single", time=5.0)) == read[1]


def test_power_meter_normalises_a_burst():
    settings = replace(IDEAL, laser=TwinSettings().laser)
    world = World(settings, Plane(0.6, reflectance=0.9), seed=4)
    ratios = []
    for label in (1, 5000, 30000):
        panel = ready("single", label=label)
        power = world.laser_power(replace(panel, time=label * 0.02 + 0.0067))
        ratios.append(decoded(world, panel).amplitude / power)
    np.testing.assert_allclose(ratios, ratios[0], rtol=1e-3)


@pytest.mark.parametrize(("mode", "periods"), [("single", 1), ("doubled", 2)])
def test_fast_detector_sees_the_modulation(mode, periods):
    world = World(IDEAL, None)
    theta = 2 * np.pi * np.arange(256) / 256
    intensity = world.fast_detector(ready(mode), theta)
    spectrum = np.abs(np.fft.rfft(intensity))
    assert np.argmax(spectrum[1:]) + 1 == periods
    # the photodiode's 12 GHz take some of the swing
    damped = 1 / np.hypot(1, periods * DRIVE[mode] / 12e9)
    bare = {"single": 2 * 0.5668, "doubled": 2 * 0.2497 / 0.528}[mode]
    assert 2 * spectrum[periods] / spectrum[0] == pytest.approx(bare * damped, rel=1e-3)
    assert intensity.mean() < 0.15 * 0.25


def test_analog_input_reads_what_the_stream_reads():
    world = World(TwinSettings(), Plane(1.0), seed=2)
    panel = ready("single", time=12.0)
    reading = world.analog_input(panel, 0)
    stream = world.burst(replace(panel, label=600), scans=400, rate=24000.0)
    volts = volts_from_counts(stream, volts_range=10.0)
    assert reading == pytest.approx(volts.mean(), abs=6 * volts.std())
    assert world.analog_input(panel, 0) == reading  # nothing moved on
    assert world.analog_input(panel, 3) == 0.0
    quiet = World(replace(TwinSettings(), noise=False), Plane(1.0), seed=2)
    assert quiet.analog_input(panel, 0) == pytest.approx(volts.mean(), abs=volts.std())


def test_retro_reflector_outshines_paper():
    bright = World(IDEAL, Corner(2.0, reflectance=1e-3)).image(ready("single"), ahead())
    paper = World(IDEAL, Plane(2.0, reflectance=1e-3)).image(ready("single"), ahead())
    assert (bright - CENTRE).mean() > 100 * (paper - CENTRE).mean()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda w, p: w.lock(p, "laser"), "Expected a driver out of emission, detection"),
        (lambda w, p: w.burst(p, scans=5, rate=1e3, pulses=[0, 1]), "of each of 5 samples"),
        (lambda w, p: w.burst(p, scans=0, rate=1e3), "Expected the last edge"),
        (lambda w, p: w.burst(p, scans=5, rate=1e3, volts_range=7.0), "Expected a range out of"),
    ],
)
def test_nonsense_is_refused_by_message(call, message):
    with pytest.raises(ValueError, match=message):
        call(World(IDEAL, None), ready("single"))
