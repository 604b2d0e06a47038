"""The contract of every driver on its wire: faults, limits, other devices, safe states."""

from types import SimpleNamespace

import pytest
import serial
from peers import (
    DRIVERS,
    T7,
    Controller,
    Firmware,
    Generator,
    Meter,
    Port,
    Visa,
    Wire,
    modbus,
    simulated,
)
from pyvisa import VisaIOError
from pyvisa.constants import StatusCode

from cmtof.hardware.device import BadReply, ConnectionLost, InstrumentTimeout, Refused, number

BURST = {"channel": "AIN0", "rate": 1e6, "scans": 20, "range": 10.0}
BURST |= {"pulse_line": "FIO4", "pulse": 20}
# a question and a change with the bytes sent for them, and a value beyond the limits
CONTRACTS = {
    "rf": SimpleNamespace(
        model=lambda: Firmware(simulated("rf_emission")),
        ask=lambda one: one.status().edges == 0,
        question=b"STAT?",
        change=lambda one: one.set_power(30.0),
        command=b"POWR",
        beyond=lambda one: one.set_frequency(8e9),
    ),
    "sdg2042x": SimpleNamespace(
        model=lambda: Generator(simulated("clock")),
        ask=lambda one: one.output(1, False) is None,
        question=b"C1:OUTP?",
        change=lambda one: one.output(1, True),
        command=b"C1:OUTP ON",
        beyond=lambda one: one.sine(1, frequency=41e6, amplitude=1.0),
    ),
    "pm100d": SimpleNamespace(
        model=lambda: Meter(simulated("power_meter")),
        ask=lambda one: one.power == 0.0,
        question=b"MEAS:POW?",
        change=lambda one: one.set_up(wavelength=532e-9, readings=10),
        command=b"SENS:CORR:WAV 532",
        beyond=lambda one: one.set_up(wavelength=1e-7, readings=10),
    ),
    "apt": SimpleNamespace(
        model=lambda: Controller(simulated("stage")),
        ask=lambda one: one.position == 0,
        question=b"\x11\x04",
        change=lambda one: one.home(),
        command=b"\x43\x04",
        beyond=lambda one: one.move_to(0.06),
    ),
    "t7": SimpleNamespace(
        model=lambda: T7(simulated("daq")),
        ask=lambda one: one.line("FIO7"),
        question=b"\x00\x07\xd7",
        change=lambda one: one.set_line("FIO0", True),
        command=b"\x01\x07\xd0",
        beyond=lambda one: one.configure_burst(**BURST),
    ),
}
# what silence, and a device that has gone, look like on each kind of connection
SILENCE = {Port: b"", Visa: b"", modbus: TimeoutError()}
GONE = {
    Port: serial.SerialException("gone"),
    Visa: VisaIOError(StatusCode.error_connection_lost),
    modbus: ConnectionResetError(),
}


@pytest.fixture(params=CONTRACTS)
def device(request, monkeypatch):
    monkeypatch.setattr("cmtof.hardware.apt.LONGEST", 0.1)
    return request.param


@pytest.fixture
def contract(device):
    return CONTRACTS[device]


@pytest.fixture
def faults(device):
    kind = DRIVERS[device][0]
    return {"silence": SILENCE[kind], "garbage": b"\xff nonsense\n", "lost": GONE[kind]}


@pytest.fixture
def wire(contract):
    return Wire(contract.model())


@pytest.fixture
def make(device, wire):
    """Maker of the driver on its wire, by the serial number that it must have."""
    kind, driver = DRIVERS[device]
    return lambda *number: driver(kind(wire), *number)


@pytest.fixture
def driver(make):
    return make()


def sent(wire, request):
    return sum(request in one for one in wire.sent)


@pytest.mark.parametrize("fault", ["silence", "garbage"])
def test_a_question_is_asked_once_more(contract, wire, driver, faults, fault):
    wire.fail(contract.question, faults[fault], times=1)
    assert contract.ask(driver)
    assert sent(wire, contract.question) == 2


ERRORS = {
    "silence": InstrumentTimeout,
    "garbage": (BadReply, InstrumentTimeout),
    "lost": ConnectionLost,
}


@pytest.mark.parametrize("fault", ERRORS)
def test_a_fault_that_stays_is_one_error(contract, wire, driver, faults, fault):
    wire.fail(contract.question, faults[fault])
    with pytest.raises(ERRORS[fault], match=r"^Expected .*, got .*\. [A-Z].*\.$") as found:
        contract.ask(driver)
    assert "\n" not in str(found.value)


@pytest.mark.parametrize("fault", ERRORS)
def test_a_change_is_sent_once(contract, wire, driver, faults, fault):
    wire.fail(contract.command, faults[fault])
    with pytest.raises(OSError, match="Expected"):
        contract.change(driver)
    assert sent(wire, contract.command) == 1


def test_another_device_is_refused(wire, driver):
    assert driver.identify()["model"].startswith(driver.MODELS)
    model = wire.answer
    if isinstance(model, T7):
        model.set(60000, "f", 4.0)
    else:
        model.model = b"TDC9" if isinstance(model, Controller) else "OTHER"
    with pytest.raises(Refused, match="Expected device to be .* Check the address"):
        driver.identify()


def test_another_serial_number_is_refused(make):
    with pytest.raises(Refused, match="OTHER, got .* Check the address"):
        make("OTHER").identify()


def test_a_value_beyond_the_limits_is_not_sent(contract, wire, driver):
    with pytest.raises(ValueError, match="Expected .* of device from .* Stay within"):
        contract.beyond(driver)
    assert not wire.sent


def test_a_safe_state_is_tried_again(wire, driver, faults):
    wire.fail(b"", faults["lost"], times=1)
    driver.safe_state()
    assert len(wire.sent) != 1  # a power meter has no safe state and is asked nothing
    driver.close()
    driver.close()


@pytest.mark.parametrize(("text", "value"), [("1.5E+7HZ", 1.5e7), (" -0.25", -0.25)])
def test_a_number_may_have_a_unit(text, value):
    assert number(text) == value


@pytest.mark.parametrize("text", ["9.9E+37", "nan", "volts", ""])
def test_what_is_no_number_is_a_bad_reply(text):
    with pytest.raises(BadReply, match="Expected a number"):
        number(text)
