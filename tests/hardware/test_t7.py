"""The read-out before a model of the T7, in process and on pymodbus' own server."""

import struct

import numpy as np
import pytest
from peers import T7, modbus, served

from cmtof.hardware.device import BadReply, InstrumentTimeout, Refused
from cmtof.hardware.t7 import LabJackT7, open_modbus

BURST = {"channel": "AIN0", "rate": 24000.0, "scans": 320, "range": 10.0}
BURST |= {"pulse_line": "FIO4", "pulse": 20}


@pytest.fixture
def peer():
    return T7()


@pytest.fixture
def daq(peer):
    return LabJackT7(modbus(peer), peer.stream, "daq", ["FIO0", "FIO1"])


def test_identity_and_calibration(peer, daq):
    assert daq.identify() == {"model": "T7", "serial_number": "470010001"}
    assert daq.gain(10.0) == pytest.approx((3.16e-4, -3.16e-4, 33520.0))
    assert peer.get(61810) == 0x3C4000
    peer.set(61812, "fff", 1.0, -1.0, 0.0)
    with pytest.raises(Refused, match="its slope to 0.0003158, got 1"):
        daq.gain(10.0)


def test_lines_are_set_and_checked(peer, daq):
    daq.set_line("FIO1", True)
    assert peer.words[2500] == 2
    assert daq.line("FIO7")
    peer.write = lambda *_: None
    with pytest.raises(Refused, match="Expected daq to set its FIO1 to 0, got 1"):
        daq.set_line("FIO1", False)


def test_bursts_carry_mirrors_and_label_in_one_frame(peer, daq):
    daq.configure_burst(**BURST)
    first, second = daq.bursts([{"USER_RAM0_U32": 7, "TDAC2": 2.5}, {"USER_RAM0_U32": 1000}])
    assert first.tolist() == list(range(7, 327))
    assert second[0] == 1000
    (states,) = [words for address, words in peer.written if address == 4420]
    assert states == (0xEF10,) * 10 + (0xEF00,) * 10  # the other lines are left alone
    addresses = [address for address, _ in peer.written]
    start = addresses.index(46100)
    assert addresses[start : start + 3] == [46100, 30004, 4990]
    assert struct.pack(">2H", *peer.written[start + 1][1]) == struct.pack(">f", 2.5)
    assert peer.get(4990) == 0


@pytest.mark.parametrize(
    ("fault", "error", "text"),
    [
        ("lost", BadReply, "status 2944 or a gap"),
        ("skipped", BadReply, "status 2941"),
        ("short", InstrumentTimeout, "all samples"),
    ],
)
def test_a_broken_burst_is_an_error_and_the_next_one_is_whole(peer, daq, fault, error, text):
    daq.configure_burst(**BURST)
    peer.fault = fault
    with pytest.raises(error, match=text):
        list(daq.bursts([{"USER_RAM0_U32": 1}]))
    assert peer.get(4990) == 0
    (counts,) = daq.bursts([{"USER_RAM0_U32": 2}])
    assert np.array_equal(counts, np.arange(2, 322))


def test_watchdog_guards_the_safe_lines(peer, daq):
    daq.watchdog(30)
    # enabled, seconds, direction, inhibit
    assert [peer.get(one) for one in (61600, 61604, 61634, 61636)] == [1, 30, 3, 0x7FFFFC]
    peer.written.clear()
    daq.watchdog(30)  # flash wears: nothing is written twice
    assert not peer.written


def test_function_76_passes_pymodbus_own_server(peer):
    daq = LabJackT7(open_modbus(served(peer), 0.2), peer.stream, "daq")
    assert daq.identify()["serial_number"] == "470010001"
    daq.configure_burst(**BURST)
    (counts,) = daq.bursts([{"USER_RAM0_U32": 3}])
    assert counts[0] == 3
    peer.fault = "refuse"
    with pytest.raises(Refused, match="Modbus exception 6"):
        daq.set_line("FIO0", True)
    daq.close()
