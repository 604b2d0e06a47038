"""The contract of every driver on its wire: faults, limits, other devices, safe states."""

from unittest.mock import Mock

import serial
from kinds import DEVICES, called
from peers import T7, Controller, Port, Visa, Wire, modbus, simulated
from pytest import fixture, mark, raises
from pyvisa import VisaIOError
from pyvisa.constants import StatusCode
from refusals import refused
from scpi_peers import Scpi

from cmtof.hardware.device import (
    BadReply,
    ConnectionLost,
    InstrumentTimeout,
    Refused,
    insist,
    number,
)
from cmtof.hardware.log import Logged
from cmtof.hardware.rf import RfDriver, line_with_checksum
from cmtof.hardware.scpi import SignalGenerator

# what silence, and a device that has gone, look like on each kind of connection
SILENCE = {Port: b"", Visa: b"", modbus: TimeoutError()}
GONE = {
    Port: serial.SerialException("gone"),
    Visa: VisaIOError(StatusCode.error_connection_lost),
    modbus: ConnectionResetError(),
}


@fixture(params=DEVICES, ids=lambda one: one.name)
def device(request, monkeypatch):
    monkeypatch.setattr("cmtof.hardware.apt.LONGEST", 0.1)
    return request.param


@fixture
def contract(device):
    """A question and a change with the bytes sent for them, and a value beyond the limits."""
    return device.file["contract"]


@fixture
def wire(device):
    return Wire(device.model(simulated(device.role)))


@fixture
def driver(device, wire):
    return device.driver(device.kind(wire), name="device")


@fixture
def fail(device, wire):
    """Have a written request meet a fault; what is returned counts how often it was sent."""
    kind = device.kind
    faults = {
        "silence": SILENCE[kind],
        "lost": GONE[kind],
        "garbage": b"\xff nonsense\n",
    }

    def meet(text, fault, **times):
        request, _ = device.pair(text, "00")
        wire.fail(request, faults[fault], **times)
        return lambda: sum(request in one for one in wire.sent)

    return meet


@mark.parametrize("fault", ["silence", "garbage"])
def test_a_question_is_asked_once_more(contract, driver, fail, fault):
    sent = fail(contract["question"], fault, times=1)
    assert called(driver, **contract["ask"]) == contract["ask"]["gives"]
    assert sent() == 2


ERRORS = {
    "silence": InstrumentTimeout,
    "garbage": (BadReply, InstrumentTimeout),
    "lost": ConnectionLost,
}


@mark.parametrize("fault", ERRORS)
def test_a_fault_that_stays_is_one_error(contract, driver, fail, fault):
    fail(contract["question"], fault)
    with refused(r"\. [A-Z].*\.$", ERRORS[fault]):
        called(driver, **contract["ask"])


@mark.parametrize("fault", ERRORS)
def test_a_change_is_sent_once(contract, driver, fail, fault):
    sent = fail(contract["command"], fault)
    with refused("Expected", OSError):
        called(driver, **contract["change"])
    assert sent() == 1


def test_another_device_is_refused(wire, driver):
    assert driver.identify()["model"].startswith(driver.MODELS)
    model = wire.answer
    if isinstance(model, T7):
        model.set(60000, "f", 4.0)
    elif isinstance(model, Scpi):
        wire.fail(b"*IDN?", b"MAKER,OTHER,1,2\n")
    else:
        model.model = b"TDC9" if isinstance(model, Controller) else "OTHER"
    with refused("Expected device to be .* Check the address", Refused):
        driver.identify()


def test_a_value_beyond_the_limits_is_not_sent(contract, wire, driver):
    with refused("Expected .* of device from .* Stay within"):
        called(driver, **contract["beyond"])
    assert not wire.sent


def test_a_safe_state_is_tried_again(wire, driver, fail):
    fail("", "lost", times=1)
    driver.safe_state()
    assert len(wire.sent) != 1  # a power meter has no safe state and is asked nothing
    driver.close()
    driver.close()


@mark.parametrize("error, calls", [(InstrumentTimeout, 0), (Refused, 1)])
def test_after_silence_the_rest_of_a_safe_state_is_left_out(error, calls):
    """Each act would wait as long for a device that does not answer."""
    first = Mock(side_effect=error("Expected an answer, got none. Check it."))
    last = Mock()
    with raises(error):
        insist(first, last)
    assert (first.call_count, last.call_count) == (2, calls)


@mark.parametrize("text", ["9.9E+37", "nan", "volts", ""])
def test_what_is_no_number_is_a_bad_reply(text):
    with refused("Expected a number", BadReply):
        number(text)


def test_a_reset_without_an_answer_keeps_the_usual_timeout():
    """A generator that is gone would delay the safe state by ten seconds a question."""
    resource = Visa(lambda request: b"")
    with raises(InstrumentTimeout):
        SignalGenerator(resource, "clock").reset()
    assert resource.timeout == 0


def test_a_log_on_a_full_disk_keeps_no_request_from_a_device():
    full = Mock(**{"write.side_effect": OSError})
    assert Logged(Mock(ask=str), "daq", full).ask(1) == "1"


def test_a_flood_of_unasked_lines_ends():
    with raises(BadReply):
        RfDriver(
            Mock(read_until=lambda *size: line_with_checksum("!TICK")), "rf"
        ).safe_state()
