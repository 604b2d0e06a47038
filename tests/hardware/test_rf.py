"""The RF driver's lines: settings, lock, trips, and lines that go wrong."""

import numpy as np
import pytest
from peers import Firmware, Port, dialogue
from pytest import approx

from cmtof.correlation import TAU
from cmtof.hardware.device import BadReply, InstrumentTimeout, Refused, Unsafe
from cmtof.hardware.rf import RfDriver, framed


def test_settings_arrive_and_are_read_back():
    assert framed(">7 PING") == b">7 PING*9555\n"
    firmware = Firmware()
    rf = RfDriver(Port(firmware), "rf")
    assert rf.identify()["serial_number"] == "R0001"
    rf.set_frequency(7.15e9)
    rf.set_power(np.float64(30.5))
    assert rf.set_phase(-3 * np.pi / 2) == approx(np.pi / 2)
    words = [firmware.values[one] for one in ("FREQ", "POWR", "PHAS")]
    assert words == ["7150000000", "30.5", "16384"]
    rf.load_table(-2 * np.pi * np.arange(16) / 16 % TAU)
    assert firmware.codes == [0, *range(61440, 0, -4096)]


def test_rf_without_a_lock_is_switched_off_again():
    firmware = Firmware()
    rf = RfDriver(Port(firmware), "rf")
    rf.output(True)
    assert rf.status().on
    firmware.locked = False
    with pytest.raises(Unsafe, match=r"Expected rf to lock within 0\.05 s, got RfStatus"):
        rf.output(True, lock_timeout=0.05)
    assert not rf.status().on


def test_late_and_unasked_lines_are_passed_over_and_a_trip_is_unsafe():
    lines = framed("<99 OK 1") + framed("!TRIP DEADMAN") + framed("<0 OK 0 0 0 0 1")
    talk = dialogue(Port, (framed(">0 STAT?"), lines))
    with talk as port, pytest.raises(Unsafe, match="to keep RF on, got a trip"):
        RfDriver(port, "rf").ping()


@pytest.mark.parametrize(
    ("reply", "error", "text"),
    [
        (framed("<0 ERR RANGE high"), Refused, "got ERR RANGE high"),
        (framed("<0 OK 7150000001.9"), Refused, r"FREQ to 7.15e\+09"),
        (b"<0 OK 7150000000*0000\n", BadReply, "a whole line"),
        (b"<0 OK 71", InstrumentTimeout, "got b'<0 OK 71'"),
    ],
)
def test_a_setting_that_goes_wrong_is_sent_once(reply, error, text):
    talk = dialogue(Port, (framed(">0 FREQ 7150000000"), reply))
    with talk as port, pytest.raises(error, match=text):
        RfDriver(port, "rf").set_frequency(7.15e9)


def test_safe_is_sent_again_and_rf_that_stays_on_is_unsafe():
    with (
        dialogue(
            Port,
            (framed(">0 SAFE"), b"\x00" * 5 + b"\n"),
            (framed(">1 SAFE"), b""),
            (framed(">2 SAFE"), framed("<2 OK")),
            (framed(">3 STAT?"), framed("<3 OK 1 1 0 0 0")),
        ) as port,
        pytest.raises(Unsafe, match="Switch it off by hand"),
    ):
        RfDriver(port, "rf").safe_state()
