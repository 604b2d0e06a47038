"""Simulated devices offer what the drivers do."""

import inspect

import pytest

from cmtof.hardware import apt, rf, scpi, t7
from cmtof_lab import devices


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
    public = {name for name in vars(driver) if name[0] not in "_" and name.islower()}
    assert public - set(dir(simulated)) <= {"stop", "close", "lock"}
