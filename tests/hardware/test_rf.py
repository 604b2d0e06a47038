"""The RF driver's lines: settings, lock, trips, and lines that go wrong."""

import numpy as np
import pytest
from peers import Firmware, Port, dialogue

from cmtof.hardware.device import BadReply, InstrumentTimeout, Refused, Unsafe
from cmtof.hardware.rf import RfDriver, code_from_phase, framed


@pytest.fixture
def firmware():
    return Firmware()


@pytest.fixture
def rf(firmware):
    return RfDriver(Port(firmware), "rf")


def test_settings_arrive_and_are_read_back(firmware, rf):
    assert framed(">7 PING") == b">7 PING*9555\n"
    assert rf.identify()["serial_number"] == "R0001"
    rf.set_frequency(7.15e9)
    rf.set_power(np.float64(30.5))
    assert rf.set_phase(np.pi / 2) == pytest.approx(np.pi / 2)
    assert [firmware.values[one] for one in ("FREQ", "POWR", "PHAS")] == [
        "7150000000",
        "30.5",
        "16384",
    ]
    rf.load_table(-2 * np.pi * np.arange(16) / 16 % (2 * np.pi))
    assert firmware.codes[1] == 65536 - 4096
    assert [code_from_phase(phase) for phase in (0.0, np.pi, -np.pi / 2)] == [0, 32768, 49152]


def test_rf_comes_on_only_behind_a_dead_man_s_time_and_with_a_lock(firmware, rf):
    with pytest.raises(Unsafe, match="Expected rf to have a dead man's time"):
        rf.output(True)
    rf.set_dead_man(5.0)
    rf.output(True)
    assert firmware.values["RF"] == "ON"
    firmware.locked = False
    with pytest.raises(Unsafe, match=r"Expected rf to lock within 0\.05 s, got no lock"):
        rf.output(True, lock_timeout=0.05)
    assert firmware.values["RF"] == "OFF"


def test_a_trip_comes_unasked_and_late_answers_are_passed_over():
    lines = framed("<99 OK 1") + framed("!TRIP DEADMAN") + framed("<0 OK")
    talk = dialogue(Port, (framed(">0 PING"), lines))
    with talk as port, pytest.raises(Unsafe, match=r"got a trip \(DEADMAN\)"):
        RfDriver(port, "rf").ping()


@pytest.mark.parametrize(
    ("reply", "error", "text"),
    [
        (framed("<0 ERR RANGE high"), Refused, "got ERR RANGE high"),
        (framed("<0 ERR TRIPPED"), Unsafe, "got ERR TRIPPED"),
        (framed("<0 OK 7150000001.9"), Refused, r"FREQ to 7.15e\+09"),
        (framed("<0 OK"), BadReply, "a whole answer"),
        (framed("<?? ERR CHECKSUM"), BadReply, "got other lines"),
        (b"<0 OK 7150000000*0000\n", BadReply, "with its checksum"),
        (b"<0 OK 71", InstrumentTimeout, "got b'<0 OK 71'"),
    ],
)
def test_a_setting_that_goes_wrong_is_sent_once(reply, error, text):
    talk = dialogue(Port, (framed(">0 FREQ 7150000000"), reply))
    with talk as port, pytest.raises(error, match=text):
        RfDriver(port, "rf").set_frequency(7.15e9)


def test_safe_is_sent_again_and_rf_that_stays_on_is_unsafe():
    with dialogue(
        Port,
        (framed(">0 SAFE"), b"\x00" * 5 + b"\n"),
        (framed(">1 SAFE"), b""),
        (framed(">2 SAFE"), framed("<2 OK")),
        (framed(">3 STAT?"), framed("<3 OK OFF 0 0 0 0")),
        (framed(">4 SAFE"), framed("<4 OK")),
        (framed(">5 STAT?"), framed("<5 OK ON 1 0 0 0")),
    ) as port:
        rf = RfDriver(port, "rf")
        rf.safe_state()
        with pytest.raises(Unsafe, match="Switch it off by hand"):
            rf.safe_state()


def test_a_table_that_arrived_otherwise_is_refused():
    talk = dialogue(Port, (framed(">0 TABL 2 0 32768"), framed("<0 OK 2 FFFF")))
    with talk as port, pytest.raises(Refused, match="table's checksum"):
        RfDriver(port, "rf").load_table([0.0, np.pi])
