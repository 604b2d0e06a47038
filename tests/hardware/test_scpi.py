"""SCPI drivers against pyvisa-sim, and in recorded dialogues."""

from pathlib import Path

import pytest
from peers import Visa, dialogue

from cmtof.hardware.device import ConnectionLost, Refused
from cmtof.hardware.scpi import PowerMeter, SignalGenerator, open_visa

VISA = Path(__file__).with_name("visa")


def simulated(kind, name, address):
    """Driver of a device of pyvisa-sim."""
    return kind(open_visa(address, library=f"{VISA / name}@sim"), "device")


def test_generator_of_pyvisa_sim_becomes_the_clock():
    clock = simulated(SignalGenerator, "sdg2042x.yaml", "TCPIP0::127.0.0.1::5025::SOCKET")
    assert clock.identify()["serial_number"] == "SDG2XCAX1R0001"
    clock.reset()
    for channel in (1, 2):
        clock.sine(channel, frequency=10e6, amplitude=1.0)
        clock.output(channel, True)
    clock.lock_phases()
    with pytest.raises(Refused, match="its FRQ to 39000000, got 10000000"):
        clock.sine(2, frequency=39e6, amplitude=1.0)
    clock.safe_state()
    assert clock._pairs("C1:OUTP?")["C1:OUTP"] == "OFF"
    clock.close()


def test_power_meter_of_pyvisa_sim():
    meter = simulated(PowerMeter, "pm100d.yaml", "USB0::0x1313::0x8078::P0012345::INSTR")
    found = meter.identify()
    assert (found["serial_number"], found["head"]) == ("P0012345", "S140C")
    assert meter._ask("SENS:POW:UNIT?", str) == "DBM"  # as somebody has left it
    meter.set_up(wavelength=532e-9, readings=10)
    assert meter._ask("SENS:POW:UNIT?", str) == "W"
    assert meter._ask("SENS:POW:RANG:AUTO?") == 1
    assert meter.power == 3.012345e-3
    meter.close()


def test_a_meter_that_stays_in_decibels_is_refused():
    talk = dialogue(Visa, (b"SENS:POW:UNIT W", b""), (b"SENS:POW:UNIT?", b"DBM"))
    with talk as port, pytest.raises(Refused, match="set SENS:POW:UNIT to W, got DBM"):
        PowerMeter(port, "meter").set_up(wavelength=532e-9, readings=10)


@pytest.mark.parametrize(
    "line",
    [
        "Siglent Technologies,SDG2042X,SDG2XCAX1R0001,2.01.01.39R7T2",
        "*IDN SDG,SDG2042X,SDG2XCAX1R0001,1.01.01.22,02-00-00-21-24",
    ],
)
def test_old_and_new_generators_are_identified(line):
    with dialogue(Visa, (b"*IDN?", line.encode())) as talk:
        found = SignalGenerator(talk, "clock", "SDG2XCAX1R0001").identify()
    assert found["model"] == "SDG2042X"


def test_a_burst_that_survives_a_reset_is_refused():
    pairs = [(b"*RST", b""), (b"*OPC?", b"1"), (b"ROSC INT", b"")]
    pairs.append((b"C1:BTWV?", b"C1:BTWV STATE,ON"))
    with (
        dialogue(Visa, *pairs) as talk,
        pytest.raises(Refused, match="BTWV of channel 1 to 0, got 1"),
    ):
        SignalGenerator(talk, "clock").reset()


def test_an_address_where_nothing_is():
    with pytest.raises(ConnectionLost, match="Expected"):
        SignalGenerator(open_visa("TCPIP::127.0.0.1::9::SOCKET"), "clock").identify()
    with pytest.raises(ConnectionLost, match="Expected an instrument at nonsense to be there"):
        open_visa("nonsense")


def test_after_a_lost_answer_old_lines_are_dropped():
    with dialogue(
        Visa,
        (b"MEAS:POW?", b""),
        (b"*IDN?", b"2.0E-3\nTHORLABS,PM100D,P0012345,2.6.0"),
        (b"MEAS:POW?", b"2.5E-3"),
    ) as talk:
        assert PowerMeter(talk, "meter").power == 2.5e-3
