"""SCPI drivers against pyvisa-sim, and on the way to nothing. Dialogues are in the transcripts."""

from pathlib import Path

import pytest

from cmtof.hardware.device import ConnectionLost, Refused
from cmtof.hardware.scpi import PowerMeter, SignalGenerator, open_visa

VISA = Path(__file__).with_name("visa")


def simulated(kind, name, address):
    """Driver of a device of pyvisa-sim."""
    return kind(open_visa(address, library=f"{VISA / name}@sim"), "device")


def test_generator_of_pyvisa_sim_becomes_the_clock():
    clock = simulated(SignalGenerator, "sdg2042x.yaml", "TCPIP0::127.0.0.1::5025::SOCKET")
    clock.reset()
    for channel in (1, 2):
        clock.sine(channel, frequency=10e6, amplitude=1.0)
        clock.output(channel, True)
    clock.lock_phases()
    with pytest.raises(Refused, match="its FRQ to 39000000, got 10000000"):
        clock.sine(2, frequency=39e6, amplitude=1.0)
    clock.safe_state()
    assert not clock.output_is_on(1)
    clock.close()


def test_power_meter_of_pyvisa_sim():
    meter = simulated(PowerMeter, "pm100d.yaml", "USB0::0x1313::0x8078::P0012345::INSTR")
    assert meter._ask("SENS:POW:UNIT?", str) == "DBM"  # as somebody has left it
    meter.set_up(wavelength=532e-9, readings=10)
    assert meter._ask("SENS:POW:UNIT?", str) == "W"
    assert meter.power == 3.012345e-3
    meter.close()


def test_an_address_where_nothing_is():
    with pytest.raises(ConnectionLost, match="Expected"):
        SignalGenerator(open_visa("TCPIP::127.0.0.1::9::SOCKET"), "clock").identify()
    with pytest.raises(ConnectionLost, match="Expected an instrument at nonsense to be there"):
        open_visa("nonsense")
