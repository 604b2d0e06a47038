"""SCPI drivers against pyvisa-sim, and in recorded dialogues."""

from pathlib import Path

import pytest
from peers import Visa, dialogue

from cmtof.hardware.device import ConnectionLost, Refused
from cmtof.hardware.scpi import PowerMeter, SignalGenerator, open_visa

VISA = Path(__file__).with_name("visa")


def simulated(kind, name, address):
    """Driver of a device of pyvisa-sim."""
    return kind(open_visa(address, f"{VISA / name}@sim"), "device")


def test_generator_of_pyvisa_sim_becomes_the_clock():
    clock = simulated(SignalGenerator, "sdg2042x.yaml", "TCPIP0::127.0.0.1::5025::SOCKET")
    assert clock.identify()["serial_number"] == "SDG2XCAX1R0001"
    for channel in (1, 2):
        clock.sine(channel, frequency=10e6, amplitude=1.0)
        clock.output(channel, True)
    clock.lock_phases()
    clock.safe_state()
    assert clock._pairs("C1:OUTP?")["C1:OUTP"] == "OFF"
    clock.close()


def test_power_meter_of_pyvisa_sim():
    meter = simulated(PowerMeter, "pm100d.yaml", "USB0::0x1313::0x8078::P0012345::INSTR")
    assert meter.identify()["sensor"] == "S140C"
    meter.wavelength = 532e-9
    assert meter.wavelength == pytest.approx(532e-9)
    with pytest.raises(Refused, match="SENS:CORR:WAV to 1.55e-06, got 5.32e-07"):
        meter.wavelength = 1550e-9
    meter.averaging = 10
    assert meter.averaging == 10
    meter.zero()
    assert meter.power == 3.012345e-3
    meter.close()


def test_an_address_where_nothing_is():
    with pytest.raises(ConnectionLost, match="Expected"):
        SignalGenerator(open_visa("TCPIP::127.0.0.1::9::SOCKET"), "clock").identify()
    with pytest.raises(ConnectionLost, match="Expected an instrument at nonsense to be there"):
        open_visa("nonsense")


SINE = b"C2:BSWV WVTP,SINE,FRQ,39000000,AMP,1,OFST,0,PHSE,0"


@pytest.mark.parametrize(
    ("load", "wave", "text"),
    [
        (b"50", b"SINE,FRQ,38000000HZ,AMP,1V,OFST,0V,PHSE,0", "FRQ to 39000000, got 38000000"),
        (b"50", b"SQUARE,FRQ,39000000HZ,AMP,1V,OFST,0V,PHSE,0", "its sine to 1"),
        (b"50", b"SINE,FRQ,39000000HZ,AMP,0.5V,OFST,0V,PHSE,0", "AMP to 1, got 0.5"),
        (b"75", b"SINE,FRQ,39000000HZ,AMP,1V,OFST,0V,PHSE,0", "LOAD to 50, got 75"),
    ],
)
def test_a_clamped_setting_is_refused(load, wave, text):
    with (
        dialogue(
            Visa,
            (b"C2:OUTP LOAD,50", b""),
            (SINE, b""),
            (b"C2:OUTP?", b"C2:OUTP OFF,LOAD,%s,PLRT,NOR" % load),
            (b"C2:BSWV?", b"C2:BSWV PERI,2.6e-08S,WVTP," + wave),
        ) as talk,
        pytest.raises(Refused, match=text),
    ):
        SignalGenerator(talk, "clock").sine(2, frequency=39e6, amplitude=1.0)


def test_after_a_lost_answer_old_lines_are_dropped():
    with dialogue(
        Visa,
        (b"MEAS:POW?", b""),
        (b"*IDN?", b"2.0E-3\nTHORLABS,PM100D,P0012345,2.6.0"),
        (b"MEAS:POW?", b"2.5E-3"),
    ) as talk:
        assert PowerMeter(talk, "meter").power == 2.5e-3


def test_a_generator_that_locks_by_neither_spelling():
    answer = (b"MODE?", b"MODE INDEPENDENT")
    talk = dialogue(Visa, (b"MODE PHASE-LOCKED", b""), answer, (b"MODE PHASELOCKED", b""), answer)
    with talk as resource, pytest.raises(Refused, match="neither spelling"):
        SignalGenerator(resource, "clock").lock_phases()


def test_safe_state_switches_the_second_output_off_even_if_the_first_fails():
    first = [(b"C1:OUTP OFF", b""), (b"C1:OUTP?", b"C1:OUTP ON,LOAD,50,PLRT,NOR")] * 2
    second = [(b"C2:OUTP OFF", b""), (b"C2:OUTP?", b"C2:OUTP OFF,LOAD,50,PLRT,NOR")]
    with dialogue(Visa, *first, *second) as talk, pytest.raises(Refused, match="output 1 to 0"):
        SignalGenerator(talk, "clock").safe_state()
