"""The RF driver and its lock. Its lines are in the transcripts."""

from peers import Firmware, Port, simulated
from refusals import refused

from cmtof.hardware.device import Unsafe
from cmtof.hardware.rf import RfDriver


def test_rf_without_a_lock_is_switched_off_again():
    device = simulated("rf_emission")
    rf = RfDriver(Port(Firmware(device)), "rf")
    device.panel.clock_on = True
    rf.output(True)
    assert rf.status().on
    device.panel.clock_on = False
    with refused(r"Expected rf to lock within 0\.05 s, got RfStatus", Unsafe):
        rf.output(True, lock_timeout=0.05)
    assert not rf.status().on
