"""The RF driver: settings and lock. Its lines are in the transcripts."""

import numpy as np
import pytest
from peers import Firmware, Port, simulated
from pytest import approx

from cmtof.correlation import TAU
from cmtof.hardware.device import Unsafe
from cmtof.hardware.rf import RfDriver


def test_settings_arrive_and_are_read_back():
    device = simulated("rf_emission")
    rf = RfDriver(Port(Firmware(device)), "rf")
    rf.set_frequency(7.15e9)
    rf.set_power(np.float64(30.5))
    assert rf.set_phase(-3 * np.pi / 2) == approx(np.pi / 2)
    knobs = device.knobs
    assert (knobs.frequency, knobs.power) == (7.15e9, 30.5)
    assert knobs.phase == approx(np.pi / 2)
    rf.load_table(-TAU * np.arange(16) / 16 % TAU)
    assert knobs.table == approx(TAU * np.array([0, *range(15, 0, -1)]) / 16)


def test_rf_without_a_lock_is_switched_off_again():
    device = simulated("rf_emission")
    rf = RfDriver(Port(Firmware(device)), "rf")
    device.panel.clock_on = True
    rf.output(True)
    assert rf.status().on
    device.panel.clock_on = False
    with pytest.raises(Unsafe, match=r"Expected rf to lock within 0\.05 s, got RfStatus"):
        rf.output(True, lock_timeout=0.05)
    assert not rf.status().on
