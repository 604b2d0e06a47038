"""SCPI drivers against pyvisa-sim, and in recorded dialogues."""

from pathlib import Path

import pytest
from peers import Dialogue, timeout

from cmtof.hardware.device import BadReply, ConnectionLost, InstrumentTimeout, Refused, number
from cmtof.hardware.scpi import PowerMeter, SignalGenerator, open_visa

VISA = Path(__file__).with_name("visa")
IDN = ("*IDN?", "Siglent Technologies,SDG2042X,SDG2XCAX1R0001,2.01.01.39R7T2")


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
    assert "OFF" in clock._pairs(1, "OUTP")
    clock.close()


def test_power_meter_of_pyvisa_sim():
    meter = simulated(PowerMeter, "pm100d.yaml", "USB0::0x1313::0x8078::P0012345::INSTR")
    assert meter.identify()["sensor"] == "S140C"
    meter.wavelength = 532e-9
    assert meter.wavelength == pytest.approx(532e-9)
    with pytest.raises(ValueError, match="Expected 350 to 1100 nm"):
        meter.wavelength = 1550e-9
    meter.averaging = 10
    assert meter.averaging == 10
    meter.zero()
    assert meter.power == 3.012345e-3
    meter.close()


def test_an_address_where_nothing_is():
    with pytest.raises(ConnectionLost, match="Expected"):
        SignalGenerator(open_visa("TCPIP::127.0.0.1::9::SOCKET"), "clock").identify()
    with pytest.raises(ConnectionLost, match="Expected an instrument at nonsense"):
        open_visa("nonsense")


@pytest.mark.parametrize(
    ("reply", "text"),
    [
        ("C1:BSWV WVTP,SINE,FRQ,40000000HZ,AMP,1V,OFST,0V,PHSE,0", "frequency to 41000000"),
        ("C1:BSWV WVTP,SQUARE,FRQ,41000000HZ,AMP,1V,OFST,0V,PHSE,0", "got another wave"),
        ("C1:BSWV WVTP,SINE,FRQ,41000000HZ,AMP,0.5V,OFST,0V,PHSE,0", "amplitude to 1, got 0.5"),
    ],
)
def test_a_clamped_setting_is_refused(reply, text):
    talk = Dialogue(
        ("C1:OUTP LOAD,50", None),
        ("C1:OUTP?", "C1:OUTP OFF,LOAD,50,PLRT,NOR"),
        ("C1:BSWV WVTP,SINE,FRQ,41000000,AMP,1,OFST,0,PHSE,0", None),
        ("C1:BSWV?", reply),
    )
    with pytest.raises(Refused, match=text):
        SignalGenerator(talk, "clock").sine(1, frequency=41e6, amplitude=1.0)
    talk.finish()


def test_keys_are_read_by_name():
    talk = Dialogue(
        ("C2:OUTP LOAD,50", None),
        ("C2:OUTP?", "C2:OUTP ON,LOAD,50,PLRT,NOR"),
        ("C2:BSWV WVTP,SINE,FRQ,10000000,AMP,1,OFST,0,PHSE,0", None),
        ("C2:BSWV?", "C2:BSWV WVTP,SINE,FRQ,1E+07HZ,PERI,1e-07S,AMP,1V,AMPVRMS,0.354Vrms,"
         "AMPDBM,4dBm,OFST,0V,HLEV,0.5V,LLEV,-0.5V,PHSE,0"),
    )  # fmt: skip
    SignalGenerator(talk, "clock").sine(2, frequency=10e6, amplitude=1.0)
    talk.finish()


def test_after_a_lost_answer_old_lines_are_dropped():
    talk = Dialogue(
        ("MEAS:POW?", timeout()),
        ("*IDN?", "3.0E-3"),
        ("MEAS:POW?", "2.5E-3"),
    )
    meter = PowerMeter(talk, "meter")
    talk.pairs[1] = ("*IDN?", "2.0E-3")
    read = talk.read

    def late():
        line = read()
        if line == "2.0E-3":
            talk.replies.append("THORLABS,PM100D,P0012345,2.6.0")
        return line

    talk.read = late
    assert meter.power == 2.5e-3
    talk.finish()


@pytest.mark.parametrize(
    "maker", ["RIGOL TECHNOLOGIES,DG4162,1,2", "Siglent Technologies,SSA3,1,2"]
)
def test_another_device_is_refused(maker):
    with pytest.raises(Refused, match="Expected a siglent SDG2 at clock"):
        SignalGenerator(Dialogue(("*IDN?", maker)), "clock").identify()


def test_a_generator_that_locks_by_neither_spelling():
    talk = Dialogue(
        ("MODE PHASE-LOCKED", None),
        ("MODE?", "MODE INDEPENDENT"),
        ("MODE PHASELOCKED", None),
        ("MODE?", "MODE INDEPENDENT"),
    )
    with pytest.raises(Refused, match="both spellings"):
        SignalGenerator(talk, "clock").lock_phases()


def test_safe_state_switches_the_second_output_off_even_if_the_first_fails():
    talk = Dialogue(
        ("C1:OUTP OFF", None),
        ("C1:OUTP?", "C1:OUTP ON,LOAD,50,PLRT,NOR"),
        ("C1:OUTP OFF", None),
        ("C1:OUTP?", "C1:OUTP ON,LOAD,50,PLRT,NOR"),
        ("C2:OUTP OFF", None),
        ("C2:OUTP?", "C2:OUTP OFF,LOAD,50,PLRT,NOR"),
    )
    with pytest.raises(Refused, match="Expected output 1 of clock OFF"):
        SignalGenerator(talk, "clock").safe_state()
    talk.finish()


@pytest.mark.parametrize("text", ["9.9E+37", "nan", "volts", ""])
def test_what_is_no_number(text):
    with pytest.raises(BadReply, match="Expected a number"):
        number(text)


def test_a_device_that_stays_silent():
    talk = Dialogue(
        ("MEAS:POW?", timeout()), ("*IDN?", "THORLABS,PM100D,1,2"), ("MEAS:POW?", timeout())
    )
    with pytest.raises(InstrumentTimeout):
        _ = PowerMeter(talk, "meter").power
