"""Drivers and simulated devices fulfil the same roles."""

import inspect

import pytest

from cmtof.hardware import apt, rf, scpi, t7
from cmtof.hardware.rig import DRIVERS
from cmtof.hardware.roles import ROLES, DeviceRole
from cmtof_lab.devices import KINDS, SimulatedDevice

ON_A_WIRE = {
    "rf-driver": rf.RfDriver,
    "k10cr1": apt.Motor,
    "prm1-z8": apt.Motor,
    "mts50-z8": apt.Motor,
    "labjack-t7": t7.LabJackT7,
    "sdg2042x": scpi.SignalGenerator,
    "pm100d": scpi.PowerMeter,
}
CASES = [(role, ON_A_WIRE[driver]) for role, names in DRIVERS.items() for driver in names]
CASES += list(KINDS.items())


@pytest.mark.parametrize(("role", "kind"), CASES)
def test_a_device_does_what_its_role_asks(role, kind):
    for name in {*vars(ROLES[role]), *vars(DeviceRole)}:
        if name.startswith("_"):
            continue
        asked = getattr(ROLES[role], name)
        offered = getattr(kind, name)
        if isinstance(asked, property) or offered is SimulatedDevice.nothing:
            continue
        wanted = inspect.signature(asked).parameters.values()
        found = inspect.signature(offered).parameters.values()
        assert [(p.name, p.kind, p.default) for p in found] == [
            (p.name, p.kind, p.default) for p in wanted
        ], name


def test_every_role_has_drivers_and_a_simulated_device():
    assert list(ROLES) == list(KINDS)
    assert set(ROLES) == set(DRIVERS)
