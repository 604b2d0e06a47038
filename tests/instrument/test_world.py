"""Bursts of the whole instrument: numbers, noise, and the devices' interfaces."""

import inspect
from dataclasses import replace

import numpy as np
import pytest
from instrument_panels import EDGES, MODES, profile, psi, ready

from cmtof.correlation import centred, decode
from cmtof.hardware import apt, rf, scpi, t7
from cmtof.instrument import devices
from cmtof.instrument.electronics import chain
from cmtof.instrument.settings import TwinSettings
from cmtof.instrument.targets import Plane
from cmtof.instrument.world import World

NOISY = replace(TwinSettings.ideal(), noise=True)
ANGLES = np.random.default_rng(0).uniform(-0.1, 0.1, (40, 2))


def test_a_burst_depends_on_its_label_alone():
    world, panel = World(TwinSettings(), Plane(0.8), seed=3), ready("single")
    labels = np.arange(5, 45)
    together = world.bursts(panel, ANGLES, labels=labels, pulses=EDGES)
    for n in (39, 0, 17):
        fresh = World(TwinSettings(), Plane(0.8), seed=3)
        alone = fresh.bursts(panel, ANGLES[n : n + 1], labels=[labels[n]], pulses=EDGES)
        assert np.array_equal(alone[0], together[n])
    other = World(TwinSettings(), Plane(0.8), seed=4)
    assert (other.bursts(panel, ANGLES, labels=labels, pulses=EDGES) != together).any()


@pytest.mark.parametrize("mode", MODES)
def test_phase_noise_of_a_point_meets_the_closed_form(mode):
    world, count = World(NOISY, Plane(0.8, reflectance=0.3), seed=1), 3000
    seen = profile(world, ready(mode), np.zeros((count, 2)))
    found = decode(np.moveaxis(seen, 1, 0), psi())
    detector = NOISY.detector
    mean = seen.mean(0)
    filters = chain(detector, 1 / 24000)
    settled, carried, lags = filters.settled @ filters.settled.T, np.eye(3), []
    for _ in range(12):
        lags.append((carried @ settled)[-1, -1])
        carried = filters.transition @ carried
    weights = np.where(np.arange(12) == 0, 1, 2) * (12 - np.arange(12)) / 144
    variance = world.conversion.density(mean) * (weights @ lags)
    variance += (detector.converter_noise**2 + 1 / 12) * 3.158e-4**2 / 12
    turn = np.sin(psi() + np.angle(np.exp(1j * found.phase).mean()))
    wanted = np.sqrt((variance * turn**2).sum()) * 2 / 16 / found.amplitude.mean()
    spread = centred(found.phase - np.angle(np.exp(1j * found.phase).mean())).std()
    assert spread == pytest.approx(wanted, rel=4 / np.sqrt(2 * count))


def test_saturation_flattens_the_correlation():
    world = World(TwinSettings(), {"kind": "mirror", "distance": 0.6, "reflectance": 0.9})
    assert profile(world, ready("single")).max() == pytest.approx(4.1, abs=0.02)


def test_ranges_are_the_scene_s():
    world = World(TwinSettings(), Plane(0.8))
    np.testing.assert_allclose(world.ranges([[0.0, 0.0], [0.1, 0.0]]), [0.8, 0.8 / np.cos(0.1)])
    assert np.isnan(World(TwinSettings()).ranges(ANGLES)).all()


@pytest.mark.parametrize("bad", [{"pulses": np.arange(3)}, {"stage": [0.0]}])
def test_numbers_that_do_not_fit_are_refused(bad):
    with pytest.raises(ValueError, match="Expected 320 trigger edges and 40 stage positions"):
        World(TwinSettings()).bursts(ready("single"), ANGLES, **{"pulses": EDGES} | bad)


@pytest.mark.parametrize(
    ("driver", "simulated"),
    [
        (rf.RfDriver, devices.SimulatedRf),
        (scpi.SignalGenerator, devices.SimulatedClock),
        (scpi.PowerMeter, devices.SimulatedPowerMeter),
        (apt.Motor, devices.SimulatedMotor),
        (t7.LabJackT7, devices.SimulatedReadOut),
    ],
    ids=lambda kind: kind.__name__,
)
def test_simulated_devices_have_the_drivers_interfaces(driver, simulated):
    own = {name for name in vars(simulated) if name[0] not in "_" and name.islower()}
    for name in own - {"edges", "knobs", "homed"}:
        theirs = getattr(driver, name)
        if inspect.isfunction(theirs) and getattr(simulated, name).__name__ != "nothing":
            wanted = list(inspect.signature(theirs).parameters)
            assert list(inspect.signature(getattr(simulated, name)).parameters) == wanted, name
    missing = {"stop", "close", "lock_phases" if driver is rf.RfDriver else "stop"}
    public = {name for name in vars(driver) if name[0] not in "_" and name.islower()}
    assert public - set(dir(simulated)) <= missing
