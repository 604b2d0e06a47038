"""The read-out before a model of the T7, in process and on TCP."""

import struct
from dataclasses import replace

import numpy as np
import pytest
from peers import T7, modbus
from pytest import approx
from wire import Network, whole_frame

from cmtof.hardware.connect import connected_driver
from cmtof.hardware.device import BadReply, InstrumentTimeout, Refused
from cmtof.hardware.rig import DeviceSettings, Rig
from cmtof.hardware.t7 import LabJackT7
from cmtof_lab.devices import SimulatedDevice

BURST = {"channel": "AIN0", "rate": 24000.0, "scans": 320, "range": 10.0}
BURST |= {"pulse_line": "FIO4", "pulse": 20}


class Ramp(SimulatedDevice):
    """A read-out whose bursts are ramps that start at their labels."""

    write_many = configure_burst = set_line = SimulatedDevice.nothing

    def gain(self, volts_range):
        return 3.16e-4, -3.16e-4, 33520.0

    def line(self, dio):
        return True

    def bursts(self, requests):
        for one in requests:
            yield one["USER_RAM0_U32"] + np.arange(BURST["scans"])


@pytest.fixture
def peer():
    return T7(Ramp(None, None, "daq"))


@pytest.fixture
def daq(peer):
    lines = ["FIO0", "FIO1"]
    return LabJackT7(modbus(peer), peer.stream, "daq", safe_lines=lines, parked=["TDAC2"])


def test_calibration(peer, daq):
    assert daq.gain(10.0) == approx((3.16e-4, -3.16e-4, 33520.0))
    assert peer.get(61810) == 0x3C4000
    peer.set(61812, "fff", 1.0, -1.0, 0.0)
    with pytest.raises(Refused, match="its slope to 0.0003158, got 1"):
        daq.gain(10.0)


def test_lines_are_set_and_checked(peer, daq):
    daq.set_line("FIO1", True)
    assert peer.levels == 2
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
    assert states == b"\xef\x10" * 10 + b"\xef\x00" * 10  # the other lines are left alone
    addresses = [address for address, _ in peer.written]
    start = addresses.index(46100)
    assert addresses[start : start + 3] == [46100, 30004, 4990]
    assert peer.written[start + 1][1] == struct.pack(">f", 2.5)
    assert peer.get(4990) == 0


def test_nothing_of_the_stream_is_inherited(peer, daq):
    for address in (4014, 4018, 4022, 4024, 4028):
        peer.set(address, "I", 1)
    peer.set(4008, "f", 50.0)
    daq.configure_burst(**BURST)
    list(daq.bursts([{"USER_RAM0_U32": 1}]))
    assert not any(peer.get(address) for address in (4008, 4014, 4018, 4022, 4024, 4028))


def test_the_rate_that_the_converter_makes_is_kept_or_refused(peer, daq):
    daq.configure_burst(**BURST)
    works = peer.send_burst
    for rate in (23980.8, 23000.0):  # the first in steps of 100 ns
        peer.send_burst = lambda: peer.set(4002, "f", rate) or works()  # noqa: B023
        bursts = daq.bursts([{"USER_RAM0_U32": 1}])
        if rate == 23000.0:
            with pytest.raises(Refused, match="its rate to 24000, got 23000"):
                next(bursts)
        else:
            next(bursts)
            assert daq.rate == approx(rate)


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


def test_watchdog_guards_the_safe_lines_and_nothing_of_it_is_inherited(peer, daq):
    peer.set(61602, "I", 1)  # advanced
    peer.set(61620, "I", 1)  # resets the device, whose lines are high then
    peer.set(61640, "I", 1)  # sets DAC0
    daq.watchdog(5)
    wanted = {61600: 1, 61602: 0, 61604: 5, 61606: 0, 61610: 0, 61620: 0, 61640: 0, 61650: 0}
    wanted |= {61630: 1, 61632: 0, 61634: 3, 61636: 0x7FFFFC}
    assert {address: peer.get(address) for address in wanted} == wanted
    peer.written.clear()
    daq.watchdog(5)  # flash wears out: nothing is written twice
    assert not peer.written


def test_the_safe_state_lowers_all_light_lines_in_one_frame(peer, daq):
    for line in ("FIO0", "FIO1"):
        daq.set_line(line, True)
    daq.write_many({"TDAC2": 2.5})
    peer.written.clear()
    daq.safe_state()
    assert peer.written[:2] == [(2000, b"\0\0"), (2001, b"\0\0")]
    assert peer.levels & 3 == 0
    assert peer.get(30004) == 0


# --- on TCP --------------------------------------------------------------------------------------


@pytest.fixture
def network(peer):
    server = Network(whole_frame, peer)
    yield server
    server.close()


def at(network, **settings):
    """A rig whose T7 is on a network."""
    rig = Rig.default()
    daq = DeviceSettings("labjack-t7", network.address, **settings)
    return replace(rig, devices=rig.devices | {"daq": daq})


def test_a_refusal_tells_the_makers_code(peer, network):
    far = connected_driver(at(network), "daq")
    peer.fault = "refuse"
    with pytest.raises(Refused, match="got exception 6.*LabJack's error code is 2603"):
        far.set_line("FIO0", True)
    far.close()


def test_a_log_has_every_request_and_reply(network, tmp_path):
    with (tmp_path / "log.txt").open("w") as log:
        driver = connected_driver(at(network, timeout=0.05), "daq", log)
        driver.line("FIO7")
        network.wire.fail(b"", b"")
        with pytest.raises(InstrumentTimeout):
            driver.line("FIO7")
        driver.close()
    # head of Modbus TCP: number, protocol 0, bytes that follow, unit 1, function 76
    assert network.wire.sent[0] == bytes.fromhex("0001 0000 0006 01 4c 0007d701")
    lines = [line.split(" ", 1)[1] for line in (tmp_path / "log.txt").read_text().splitlines()]
    asked = "daq > 00 07 d7 01"
    assert lines == [asked, "daq < 00 01", asked, "daq ! timed out", asked, "daq ! timed out"]
