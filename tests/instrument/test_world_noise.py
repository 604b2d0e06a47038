"""Noise of whole bursts: its size against the formula, its keys, and what it never depends on."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from instrument_panels import MODES, ahead, edges, psi, ready

from cmtof.correlation import decode
from cmtof.instrument.drift import Drift, keyed_generator, uniform_from_places
from cmtof.instrument.electronics import SLOPE, chain
from cmtof.instrument.settings import Detector, TwinSettings
from cmtof.instrument.targets import Plane
from cmtof.instrument.world import LABEL_TIME, World

BURST = {"scans": 320, "rate": 24000.0, "pulses": edges()}


@pytest.fixture(scope="module")
def world():
    return World(TwinSettings(), "still_life", seed=11)


@pytest.mark.parametrize("distance", [0.7, 2.0, 6.0])
def test_variance_of_a_sample(distance):
    """Shot noise with excess, amplifier, converter and rounding; 1000 bursts, 5 sigma."""
    settings = replace(TwinSettings.ideal(), noise=True)
    world = World(settings, Plane(distance), seed=1)
    panel = ready("single")
    quiet = World(replace(settings, noise=False), Plane(distance), seed=1)
    kept = np.arange(16) * 20 + 19
    counts = world.bursts(panel, ahead(1000), pulses=edges())[:, kept].astype(float)
    light = quiet.light.on_detector(
        panel, ahead(), np.zeros(1), quiet.light.configuration(panel, edges(), 24000.0)
    )
    bandwidth = chain(settings.detector, 1 / 24000.0).noise_bandwidth
    density = world.conversion.density(world.conversion.volts(light))[0]
    expected = density * bandwidth / SLOPE**2 + 1 + 1 / 12
    np.testing.assert_allclose(counts.var(axis=0, ddof=1), expected, rtol=5 * np.sqrt(2 / 999))
    mean = quiet.bursts(panel, ahead(), pulses=edges())[0, kept]
    np.testing.assert_allclose(
        counts.mean(axis=0), mean, atol=0.5 + 5 * np.sqrt(expected.max() / 1000)
    )


def test_phase_noise_of_a_point():
    """sigma_phi = sqrt(2 / 16) sigma / a for the mean of the samples that a scan keeps."""
    settings = replace(TwinSettings.ideal(), noise=True)
    world = World(settings, Plane(3.0), seed=2)
    counts = world.image(ready("doubled"), ahead(1000))
    decoded = decode(counts.T, psi())
    sigma = np.sqrt(counts.var(axis=0, ddof=1).mean())
    expected = np.sqrt(2 / 16) * sigma / decoded.amplitude.mean()
    turned = np.exp(1j * decoded.phase)
    assert np.angle(turned / turned.mean()).std() == pytest.approx(expected, rel=0.12)


@given(
    history=st.lists(st.tuples(st.integers(0, 50), st.integers(1, 30)), max_size=4),
    label=st.integers(1, 2**32 - 1),
)
def test_labelled_bursts_forget_all_history(history, label):
    world = World(TwinSettings(), Plane(1.0), seed=5)
    fresh = ready("single", label=label)
    expected = world.burst(fresh, **BURST)
    panel = ready("single")
    for earlier, scans in history:
        panel.label = earlier
        world.burst(panel, scans=scans, rate=24000.0)
        panel.time += 3.7
    panel.label = label
    np.testing.assert_array_equal(world.burst(panel, **BURST), expected)
    assert panel.time == pytest.approx(label * LABEL_TIME + 320 / 24000)


def test_a_new_instrument_resumes(world):
    """What a crash and a restart must not change."""
    panel = ready("doubled", galvo_volts=[0.4, -0.3])
    taken = []
    for label in range(1, 5):
        panel.label = label
        taken.append(world.burst(panel, **BURST))
    again = World(TwinSettings(), "still_life", seed=11)
    panel = ready("doubled", galvo_volts=[0.4, -0.3], label=3, bursts=77, time=1e4)
    np.testing.assert_array_equal(again.burst(panel, **BURST), taken[2])
    assert len({row.tobytes() for row in taken}) == 4


def test_without_labels_noise_depends_on_the_count_of_bursts():
    world = World(TwinSettings(), Plane(1.0), seed=5)
    first, second = ready("single"), ready("single")
    rows = [world.burst(first, **BURST) for _ in range(3)]
    again = [world.burst(second, **BURST) for _ in range(3)]
    for row, same in zip(rows, again, strict=True):
        np.testing.assert_array_equal(row, same)
    assert not np.array_equal(rows[0], rows[1])
    assert first.bursts == 3
    assert first.time == pytest.approx(3 * 320 / 24000)


@pytest.mark.parametrize("shorter", [1, 20, 100])
def test_noise_of_a_sample_does_not_depend_on_those_after_it(world, shorter):
    long = world.burst(ready("single", label=9), **BURST)
    short = world.burst(
        ready("single", label=9), scans=shorter, rate=24000.0, pulses=edges()[:shorter]
    )
    # the middle of a cut phase is earlier: its light drifts by less than a count
    assert np.abs(long[:shorter].astype(int) - short.astype(int)).max() <= 1


def test_seeds_and_labels_are_independent():
    world = World(replace(TwinSettings.ideal(), noise=True), Plane(2.0), seed=0)
    panel = ready("single")
    rows = world.bursts(panel, ahead(400), pulses=edges()).astype(float)
    rows -= rows.mean(axis=0)
    neighbours = (rows[1:] * rows[:-1]).mean() / rows.var()
    assert abs(neighbours) < 5 / np.sqrt(399 * 320 / 8)
    other = World(replace(TwinSettings.ideal(), noise=True), Plane(2.0), seed=1)
    assert not np.array_equal(other.bursts(panel, ahead(2)), world.bursts(panel, ahead(2)))


def test_bursts_equal_burst_bit_for_bit(world):
    rng = np.random.default_rng(3)
    volts = rng.uniform(-3, 3, (40, 2))
    for mode in MODES:
        panel = ready(mode)
        angles = np.stack([world.angles(replace_volts(panel, pair)) for pair in volts])
        labels = np.arange(1000, 1040)
        many = world.bursts(panel, angles, labels=labels, pulses=edges())
        means = world.image(panel, angles, labels=labels)
        for row, pair, label in zip(range(40), volts, labels, strict=True):
            one = replace_volts(ready(mode, label=int(label)), pair)
            counts = world.burst(one, **BURST)
            np.testing.assert_array_equal(counts, many[row])
            kept = counts.reshape(16, 20)[:, 4:].mean(axis=1)
            np.testing.assert_array_equal(kept, means[row])


def replace_volts(panel, pair):
    panel.galvo_volts = [float(v) for v in pair]
    return panel


def test_bursts_leave_the_panel_alone(world):
    panel = ready("single", label=4, time=2.5, bursts=6)
    before = (panel.label, panel.time, panel.bursts, panel.detection.index, panel.detection.armed)
    world.image(panel, ahead(3))
    assert before == (
        panel.label,
        panel.time,
        panel.bursts,
        panel.detection.index,
        panel.detection.armed,
    )
    world.burst(panel, **BURST)
    assert panel.detection.armed
    assert panel.detection.index == 0


def test_no_directions_are_an_empty_image(world):
    assert world.bursts(ready("single"), np.empty((0, 2))).shape == (0, 320)


def test_a_converter_of_14_bits():
    world = World(TwinSettings(detector=Detector(bits=14)), Plane(1.0), seed=0)
    assert (world.burst(ready("single"), **BURST) % 4 == 0).all()


# --- keys and drift ----------------------------------------------------------------------------


def test_keyed_generators():
    draw = keyed_generator(3, "label", 7).standard_normal(5)
    np.testing.assert_array_equal(draw, keyed_generator(3, "label", 7).standard_normal(5))
    for other in ((4, "label", 7), (3, "count", 7), (3, "label", 8)):
        assert not np.array_equal(draw, keyed_generator(*other).standard_normal(5))
    keyed_generator(-1, "label", 2**70)  # any integer serves


def test_uniform_numbers_of_places():
    x, y = np.meshgrid(np.arange(-50, 50), np.arange(-50, 50))
    places = np.stack([x.ravel(), y.ravel()], axis=1)
    found = uniform_from_places(1, "speckle", places, 7)
    assert ((found > 0) & (found < 1)).all()
    assert np.unique(found).size == found.size
    assert found.mean() == pytest.approx(0.5, abs=5 / np.sqrt(12 * found.size))
    centred = found - 0.5
    for neighbour in (np.roll(centred, 1, axis=0), np.roll(centred, 1, axis=1)):
        assert abs((centred * neighbour).mean() * 12) < 5 / np.sqrt(found.size)


def test_drift_is_slow_bounded_and_has_a_1_over_f_spectrum():
    time = np.arange(0, 4096.0, 0.4)
    values = np.stack([Drift(seed, 0)(time) for seed in range(40)])
    assert np.abs(values).max() <= 1
    assert values.std() == pytest.approx(Drift.RMS, rel=0.05)
    assert np.abs(np.diff(Drift(0, 0)(np.arange(0, 10, 0.005)))).max() < 0.01
    power = (np.abs(np.fft.rfft(values)) ** 2).mean(axis=0)
    frequency = np.fft.rfftfreq(time.size, 0.4)
    bands = [power[(frequency >= f) & (frequency < 8 * f)].sum() for f in (1e-3, 8e-3, 64e-3)]
    assert max(bands) / min(bands) < 1.5  # the same in every three octaves
    assert not np.array_equal(Drift(0, 0)(time), Drift(0, 1)(time))
