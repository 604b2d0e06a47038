"""The contract of every driver: faults, limits, other devices, safe states."""

from types import SimpleNamespace

import pytest
import serial
from peers import T7, Controller, Firmware, Port, Visa, Wire, modbus
from pyvisa import VisaIOError
from pyvisa.constants import StatusCode
from wire import Generator, Meter

from cmtof.hardware.apt import MOTORS, Motor
from cmtof.hardware.device import BadReply, ConnectionLost, InstrumentTimeout, Refused, number
from cmtof.hardware.rf import RfDriver
from cmtof.hardware.scpi import PowerMeter, SignalGenerator
from cmtof.hardware.t7 import LabJackT7
from cmtof_lab.devices import simulated_devices
from cmtof_lab.instrument import SimulatedInstrument
from cmtof_lab.settings import TwinSettings

LOST = serial.SerialException("gone")
VISA_LOST = VisaIOError(StatusCode.error_connection_lost)


def simulated(role):
    """A device of an instrument that is switched off."""
    return simulated_devices(SimulatedInstrument(TwinSettings()))[role]


# model, driver, a question and a change with the bytes sent for them, faults on the wire, a value
# beyond the limits
CONTRACTS = {
    "rf": SimpleNamespace(
        model=Firmware,
        driver=lambda wire, *number: RfDriver(Port(wire), "device", *number),
        ask=lambda one: one.status().edges == 16,
        question=b"STAT?",
        change=lambda one: one.set_power(30.0),
        command=b"POWR",
        faults={"silence": b"", "garbage": b"\xff\xfe\n", "lost": LOST},
        beyond=lambda one: one.set_frequency(8e9),
    ),
    "clock": SimpleNamespace(
        model=lambda: Generator(simulated("clock")),
        driver=lambda wire, *number: SignalGenerator(Visa(wire), "device", *number),
        ask=lambda one: one.output(1, True) is None,
        question=b"C1:OUTP?",
        change=lambda one: one.output(1, True),
        command=b"C1:OUTP ON",
        faults={"silence": b"", "garbage": b"C1:BSWV ON", "lost": VISA_LOST},
        beyond=lambda one: one.sine(1, frequency=41e6, amplitude=1.0),
    ),
    "meter": SimpleNamespace(
        model=lambda: Meter(simulated("power_meter")),
        driver=lambda wire, *number: PowerMeter(Visa(wire), "device", *number),
        ask=lambda one: one.power == 0,
        question=b"MEAS:POW?",
        change=lambda one: one.set_up(wavelength=532e-9, readings=10),
        command=b"SENS:CORR:WAV 532",
        faults={"silence": b"", "garbage": b"nonsense", "lost": VISA_LOST},
        beyond=lambda one: one.set_up(wavelength=1e-7, readings=10),
    ),
    "motor": SimpleNamespace(
        model=Controller,
        driver=lambda wire, *number: Motor(Port(wire), MOTORS["mts50-z8"], "device", *number),
        ask=lambda one: one.position == 0,
        question=b"\x11\x04",
        change=lambda one: one.move_to(0.01),
        command=b"\x53\x04",
        faults={"silence": b"", "garbage": b"\xff" * 12, "lost": LOST},
        beyond=lambda one: one.move_to(0.06),
    ),
    "daq": SimpleNamespace(
        model=T7,
        driver=lambda wire, *number: LabJackT7(modbus(wire), Port(), "device", *number),
        ask=lambda one: one.line("FIO7"),
        question=b"\x00\x07\xd7",
        change=lambda one: one.set_line("FIO0", True),
        command=b"\x01\x07\xd0",
        faults={"silence": TimeoutError(), "garbage": b"\xff", "lost": ConnectionResetError()},
        beyond=lambda one: one.configure_burst(
            channel="AIN0", rate=1e6, scans=20, range=10.0, pulse_line="FIO4", pulse=20
        ),
    ),
}


@pytest.fixture(params=CONTRACTS)
def contract(request, monkeypatch):
    monkeypatch.setattr("cmtof.hardware.apt.LONGEST", 0.1)
    return CONTRACTS[request.param]


@pytest.fixture
def wire(contract):
    return Wire(contract.model())


@pytest.fixture
def driver(contract, wire):
    return contract.driver(wire)


def sent(wire, request):
    return sum(request in one for one in wire.sent)


@pytest.mark.parametrize("fault", ["silence", "garbage"])
def test_a_question_is_asked_once_more(contract, wire, driver, fault):
    wire.fail(contract.question, contract.faults[fault], times=1)
    assert contract.ask(driver)
    assert sent(wire, contract.question) == 2


ERRORS = {
    "silence": InstrumentTimeout,
    "garbage": (BadReply, InstrumentTimeout),
    "lost": ConnectionLost,
}


@pytest.mark.parametrize("fault", ERRORS)
def test_a_fault_that_stays_is_one_error(contract, wire, driver, fault):
    wire.fail(contract.question, contract.faults[fault])
    with pytest.raises(ERRORS[fault], match=r"^Expected .*, got .*\. [A-Z].*\.$") as found:
        contract.ask(driver)
    assert "\n" not in str(found.value)


@pytest.mark.parametrize("fault", ERRORS)
def test_a_change_is_sent_once(contract, wire, driver, fault):
    wire.fail(contract.command, contract.faults[fault])
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


def test_another_serial_number_is_refused(contract, wire):
    with pytest.raises(Refused, match="OTHER, got .* Check the address"):
        contract.driver(wire, "OTHER").identify()


def test_a_value_beyond_the_limits_is_not_sent(contract, wire, driver):
    with pytest.raises(ValueError, match="Expected .* of device from .* Stay within"):
        contract.beyond(driver)
    assert not wire.sent


def test_a_safe_state_is_tried_again(contract, wire, driver):
    wire.fail(b"", contract.faults["lost"], times=1)
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
