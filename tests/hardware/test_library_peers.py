"""Drivers before what libraries know of their protocols: pyvisa-sim, and pymodbus's framing."""

import socket
from pathlib import Path

from pymodbus.framer import FramerSocket
from pymodbus.pdu import DecodePDU
from pytest import raises
from refusals import refused

from cmtof.hardware.device import Refused
from cmtof.hardware.modbus import Feedback
from cmtof.hardware.scpi import PowerMeter, SignalGenerator, open_visa

VISA = Path(__file__).with_name("visa")


def simulated(kind, name, address):
    """Driver of a device of pyvisa-sim."""
    return kind(open_visa(address, library=f"{VISA / name}@sim"), "device")


def test_generator_becomes_the_clock():
    clock = simulated(
        SignalGenerator, "sdg2042x.yaml", "TCPIP0::127.0.0.1::5025::SOCKET"
    )
    assert clock.identify()["serial_number"] == "SDG2XCAX1R0001"
    clock.reset()
    for channel in (1, 2):
        clock.sine(channel, frequency=10e6, amplitude=1.0)
        clock.output(channel, True)
    clock.lock_phases()
    with refused("its FRQ to 39000000, got 10000000", Refused):
        clock.sine(2, frequency=39e6, amplitude=1.0)
    clock.safe_state()
    assert not clock.output_is_on(1)
    clock.close()


def test_power_meter_measures_in_watts():
    meter = simulated(
        PowerMeter, "pm100d.yaml", "USB0::0x1313::0x8078::P0012345::INSTR"
    )
    assert meter._ask("SENS:POW:UNIT?", str) == "DBM"  # as somebody has left it
    found = meter.identify()
    assert (found["serial_number"], found["head"]) == ("P0012345", "S140C")
    meter.set_up(wavelength=532e-9, readings=10)
    assert meter._ask("SENS:POW:UNIT?", str) == "W"
    assert meter._ask("SENS:POW:RANG:AUTO?") == 1
    assert meter.power == 3.012345e-3
    meter.close()


def test_frames_are_those_of_modbus_tcp():
    """By pymodbus, whose framing knows nothing of function 76."""
    listener = socket.create_server(("127.0.0.1", 0))
    client = Feedback("{}:{}".format(*listener.getsockname()), timeout=0.05)
    with raises(TimeoutError):
        client.ask(b"\x00\xea\x60\x02")
    with listener, listener.accept()[0] as far_end:
        used, unit, number, body = FramerSocket(DecodePDU(True)).decode(
            far_end.recv(100)
        )
    assert (used, unit, number, body) == (12, 1, 1, b"\x4c\x00\xea\x60\x02")
