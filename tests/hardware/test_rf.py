"""The RF driver's lines, on pyserial's loop:// and in recorded dialogues."""

import numpy as np
import pytest
from peers import Port, script

from cmtof.hardware.device import BadReply, InstrumentTimeout, Refused, Unsafe
from cmtof.hardware.rf import RfDriver, code_from_phase, framed


class Firmware:
    """Behaviour of the driver's firmware: switch, lock, table, dead man's time."""

    def __init__(self):
        self.state = {"RF": "OFF", "TRIG": "OFF"}
        self.values, self.locked, self.table = {}, True, []

    def __call__(self, line):
        body, _, _ = line.decode().strip().rpartition("*")
        head, word, *arguments = body.split()
        sequence = head.removeprefix(">")
        return framed(f"<{sequence} {self.answer(word, arguments)}")

    def answer(self, word, arguments):
        if word in ("RF", "TRIG"):
            self.state[word] = arguments[0]
            return f"OK {arguments[0]}"
        if word in ("FREQ", "POWR", "PHAS", "DEAD"):
            self.values[word] = arguments[0]
            return f"OK {arguments[0]}"
        if word == "TABL":
            self.table = [int(code) for code in arguments[1:]]
            return "OK"
        if word == "SAFE":
            self.state = {"RF": "OFF", "TRIG": "OFF"}
            return "OK"
        from binascii import crc_hqx

        crc = crc_hqx(b"".join(code.to_bytes(2, "big") for code in self.table), 0xFFFF)
        lock = int(self.locked and self.state["RF"] == "ON")
        replies = {
            "ID?": "CMTOF-RF,R0001,1.2",
            "LOCK?": f"{lock} -5e6 10.0",
            "STAT?": f"{self.state['RF']} {lock} 0 16 0",
            "TABL?": f"{len(self.table)} {crc:04X}",
        }
        return f"OK {replies.get(word, '')}".strip()


@pytest.fixture
def firmware():
    return Firmware()


@pytest.fixture
def rf(firmware):
    return RfDriver(Port(firmware), "rf")


def test_settings_arrive_and_are_read_back(firmware, rf):
    assert rf.identify()["serial_number"] == "R0001"
    rf.set_frequency(7.15e9)
    rf.set_power(30.0)
    assert rf.set_phase(np.pi / 2) == pytest.approx(np.pi / 2)
    assert firmware.values == {"FREQ": "7150000000", "POWR": "30.0", "PHAS": "16384"}
    rf.load_table(-2 * np.pi * np.arange(16) / 16 % (2 * np.pi))
    assert firmware.table[1] == 65536 - 4096
    assert rf.status().edges == 16


def test_rf_comes_on_only_behind_a_dead_man_s_time(firmware, rf):
    with pytest.raises(Unsafe, match="Expected a dead man's time"):
        rf.output(True)
    rf.set_dead_man(5.0)
    rf.output(True)
    assert firmware.state["RF"] == "ON"


def test_rf_goes_off_where_no_lock_is_found(firmware, rf):
    firmware.locked = False
    rf.set_dead_man(5.0)
    with pytest.raises(Unsafe, match=r"Expected rf to lock within 0\.05 s, got no lock"):
        rf.output(True, lock_timeout=0.05)
    assert firmware.state["RF"] == "OFF"


def test_a_trip_that_comes_unasked_is_remembered():
    port = script((framed(">0 PING"), framed("!TRIP DEADMAN") + framed("<0 OK")))
    with pytest.raises(Unsafe, match="got a trip \\(DEADMAN\\)"):
        RfDriver(port, "rf").ping()


def test_late_answers_are_passed_over():
    port = script((framed(">0 STAT?"), framed("<99 OK 1") + framed("<0 OK ON 1 3 4 0")))
    assert RfDriver(port, "rf").status() == (True, True, 3, 4, False)
    port.finish()


@pytest.mark.parametrize(
    ("reply", "error", "text"),
    [
        (framed("<0 ERR RANGE high"), Refused, "got ERR RANGE high"),
        (framed("<0 ERR TRIPPED"), Unsafe, "got ERR TRIPPED"),
        (framed("<0 OK 7150000001.9"), Refused, "FREQ to 7.15e\\+09"),
        (framed("<0 OK"), BadReply, "Expected 1 values of FREQ"),
        (framed("<?? ERR CHECKSUM"), BadReply, "arrive whole"),
        (b"<0 OK 7150000000*0000\n", BadReply, "with its checksum"),
        (b"", InstrumentTimeout, "in time"),
        (b"<0 OK 71", InstrumentTimeout, "got b'<0 OK 71'"),
    ],
)
def test_a_setting_that_goes_wrong_is_sent_once(reply, error, text):
    port = script((framed(">0 FREQ 7150000000"), reply))
    with pytest.raises(error, match=text):
        RfDriver(port, "rf").set_frequency(7.15e9)
    port.finish()


def test_safe_is_sent_again():
    garbage = b"\x00" * 5 + b"\n"
    port = script(
        (framed(">0 SAFE"), garbage),
        (framed(">1 SAFE"), b""),
        (framed(">2 SAFE"), framed("<2 OK")),
        (framed(">3 STAT?"), framed("<3 OK OFF 0 0 0 0")),
    )
    RfDriver(port, "rf").safe_state()
    port.finish()


def test_rf_that_stays_on_is_unsafe():
    port = script(
        (framed(">0 SAFE"), framed("<0 OK")), (framed(">1 STAT?"), framed("<1 OK ON 1 0 0 0"))
    )
    with pytest.raises(Unsafe, match="Switch it off by hand"):
        RfDriver(port, "rf").safe_state()


def test_a_table_that_arrived_otherwise_is_refused(firmware, rf):
    answer = firmware.answer
    firmware.answer = lambda word, arguments: answer(
        word, arguments if word != "TABL" else ["1", "5"]
    )
    with pytest.raises(Refused, match="got another"):
        rf.load_table([0.0, 1.0])
    with pytest.raises(ValueError, match="Expected 1 to 64 phases"):
        rf.load_table([])


@pytest.mark.parametrize(("phase", "code"), [(0.0, 0), (np.pi, 32768), (-np.pi / 2, 49152)])
def test_phase_codes(phase, code):
    assert code_from_phase(phase) == code
