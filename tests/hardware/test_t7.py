"""The read-out against pymodbus' own server with the T7's map."""

import struct

import numpy as np
import pytest
from peers import T7Peer

from cmtof.hardware.device import (
    BadReply,
    ConnectionLost,
    InstrumentError,
    InstrumentTimeout,
    Refused,
)
from cmtof.hardware.rf import open_serial
from cmtof.hardware.t7 import LabJackT7, open_modbus

BURST = {
    "channel": "AIN0",
    "rate": 24000.0,
    "scans": 320,
    "range": 10.0,
    "pulse_line": "FIO4",
    "pulse": 20,
}


@pytest.fixture
def peer():
    one = T7Peer()
    yield one
    one.close()


@pytest.fixture
def daq(peer):
    safe = {"FIO0": False, "FIO1": False}
    one = LabJackT7(
        open_modbus(peer.address, 0.2), open_serial(f"socket://{peer.stream}"), "daq", safe
    )
    yield one
    one.close()


def test_identity_and_calibration(peer, daq):
    assert daq.identify() == {"serial_number": 470010001, "firmware": 1.0292, "hardware": 0.0}
    assert daq.gain(10.0) == pytest.approx((3.16e-4, -3.16e-4, 33520.0))
    peer.flash[0x3C4000] = struct.pack(">4f", 1.0, -1.0, 0.0, 0.0)
    with pytest.raises(BadReply, match="Expected a calibration"):
        daq.gain(10.0)
    peer.set("PRODUCT_ID", 4.0)
    with pytest.raises(Refused, match="Expected a LabJack T7"):
        daq.identify()


def test_lines_are_set_and_checked(peer, daq):
    daq.set_line("FIO1", True)
    assert peer.get("FIO_STATE") == 2
    assert daq.line("FIO7")
    peer._write = lambda *_: None
    with pytest.raises(Refused, match="Expected FIO1 of daq to go low"):
        daq.set_line("FIO1", False)


def test_bursts_carry_mirrors_and_label_in_one_frame(peer, daq):
    daq.configure_burst(**BURST)
    peer.written.clear()
    requests = [{"USER_RAM0_U32": 7, "TDAC2": 2.5}, {"USER_RAM0_U32": 1000}]
    first, second = daq.bursts(requests)
    assert first.tolist() == list(range(7, 327))
    assert second[0] == 1000
    assert peer.pulses == 32
    addresses = [address for address, _ in peer.written]
    assert addresses[:3] == [46100, 30004, 4990]
    assert struct.pack(">2H", *peer.written[1][1]) == struct.pack(">f", 2.5)
    assert peer.get("STREAM_ENABLE") == 0


def test_the_pulse_leaves_the_other_lines_alone(peer, daq):
    daq.configure_burst(**BURST)
    (states,) = [words for address, words in peer.written if address == 4420]
    assert states == (0xEF10,) * 10 + (0xEF00,) * 10


def test_a_setting_that_the_device_changes_is_refused(peer, daq):
    write = peer._write

    def clamped(address, words):
        write(address, words)
        peer.set("STREAM_SCANRATE_HZ", 20000.0)

    peer._write = clamped
    with pytest.raises(Refused, match="STREAM_SCANRATE_HZ to 24000, got 20000"):
        daq.configure_burst(**BURST)


@pytest.mark.parametrize(
    ("fault", "error", "text"),
    [
        ("lost packet", BadReply, "some missing"),
        ("skipped", BadReply, "skipped scans"),
        ("short", InstrumentTimeout, "all samples"),
    ],
)
def test_a_broken_burst_is_an_error_and_the_next_one_is_whole(peer, daq, fault, error, text):
    daq.configure_burst(**BURST)
    peer.fault = fault
    with pytest.raises(error, match=text):
        list(daq.bursts([{"USER_RAM0_U32": 1}]))
    assert peer.get("STREAM_ENABLE") == 0
    (counts,) = daq.bursts([{"USER_RAM0_U32": 2}])
    assert np.array_equal(counts, np.arange(2, 322))


@pytest.mark.parametrize("bad", [{"pulse": 300}, {"scans": 321}, {"rate": 1e6}])
def test_a_burst_that_no_t7_can_take(daq, bad):
    with pytest.raises(ValueError, match="Expected whole pulses"):
        daq.configure_burst(**{**BURST, **bad})


def test_watchdog_guards_the_safe_lines(peer, daq):
    daq.watchdog(30)
    assert peer.get("WATCHDOG_ENABLE_DEFAULT") == 1
    assert peer.get("WATCHDOG_TIMEOUT_S_DEFAULT") == 30
    assert peer.get("WATCHDOG_DIO_DIRECTION_DEFAULT") == 3
    assert peer.get("WATCHDOG_DIO_INHIBIT_DEFAULT") == 0x7FFFFC
    peer.written.clear()
    daq.watchdog(30)
    assert not peer.written
    daq.watchdog(0)
    assert peer.get("WATCHDOG_ENABLE_DEFAULT") == 0


@pytest.mark.parametrize(
    ("fault", "error"),
    [("drop", InstrumentTimeout), ("garbage", InstrumentError), ("refuse", Refused)],
)
def test_a_write_is_never_repeated(peer, daq, fault, error):
    peer.fault = fault
    with pytest.raises(error):
        daq.set_line("FIO0", True)
    daq.safe_state()
    assert peer.get("STREAM_ENABLE") == 0


def test_a_read_is_asked_once_more(peer, daq):
    peer.fault = "drop"
    assert daq.line("FIO7")


def test_a_peer_that_has_gone(peer, daq):
    daq.configure_burst(**BURST)
    peer.close()
    with pytest.raises(InstrumentError):
        daq.set_line("FIO0", False)
    with pytest.raises(ConnectionLost, match="Expected a T7 at"):
        open_modbus(peer.address, 0.2)
