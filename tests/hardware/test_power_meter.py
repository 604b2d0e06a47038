"""The power meter's driver: written dialogues, and an independent simulated device behind VISA."""

from pathlib import Path

import pytest

from cmtof.hardware.codecs.scpi import SensorFlags
from cmtof.hardware.drivers.power_meter import PowerMeter
from cmtof.hardware.errors import BadReply, InstrumentTimeout, Refused
from cmtof.hardware.transport import ReplayTransport, VisaTransport

IDENTITY = "THORLABS,PM100D,P0012345,2.6.0"
SENSOR = 'S140C,11041301,"13-Apr-2011",1,18,289'
LIMITS = [("SENS:CORR:WAV? MIN", "3.5E+02"), ("SENS:CORR:WAV? MAX", "1.1E+03")]


def meter(*steps):
    transport = ReplayTransport(
        [(q.encode() + b"\n", r.encode() + b"\n" if r else b"") for q, r in steps]
    )
    return PowerMeter(transport, timeout=0.01), transport


def test_identity():
    power_meter, transport = meter(("*IDN?", IDENTITY), ("SYST:SENS:IDN?", SENSOR))
    device, sensor = power_meter.identify()
    assert (device.model, sensor.name, sensor.serial) == ("PM100D", "S140C", "11041301")
    assert SensorFlags.WAVELENGTH in sensor.flags
    transport.finish()


def test_the_wavelength_is_given_in_metres():
    power_meter, transport = meter(
        *LIMITS, ("SENS:CORR:WAV 532", ""), ("SENS:CORR:WAV?", "5.320000E+02")
    )
    assert power_meter.set_wavelength(532e-9) == pytest.approx(532e-9)
    transport.finish()


def test_zeroing_waits_for_its_end():
    state = "SENS:CORR:COLL:ZERO:STAT?"
    power_meter, transport = meter(
        ("SENS:CORR:COLL:ZERO:INIT", ""),
        (state, "1"),
        (state, "0"),
        ("SENS:CORR:COLL:ZERO:MAGN?", "1.2E-08"),
    )
    assert power_meter.zero() == 1.2e-8
    transport.finish()


def test_a_power():
    power_meter, transport = meter(("MEAS:POW?", "3.01E-03"))
    assert power_meter.power() == 3.01e-3
    power_meter.safe_state()
    transport.finish()


FAULTS = [
    ("identify", (), [("*IDN?", "THORLABS,PM400,1,1")], Refused, "got THORLABS PM400"),
    ("identify", (), [("*IDN?", "Newport,PM100D,1,1")], Refused, "Expected a Thorlabs PM100D"),
    ("identify", (), [("*IDN?", "THORLABS,CLD1015,1,1")], Refused, "got THORLABS CLD1015"),
    (
        "identify",
        (),
        [("*IDN?", IDENTITY), ("SYST:SENS:IDN?", "no sensor,,,0,0,0")],
        Refused,
        "a head that measures power",
    ),
    ("set_wavelength", (1.5e-6,), LIMITS, ValueError, "350 to 1100 nm"),
    (
        "set_wavelength",
        (532e-9,),
        [*LIMITS, ("SENS:CORR:WAV 532", ""), ("SENS:CORR:WAV?", "6.35E+02")],
        Refused,
        "wavelength to 532 nm, got 635 nm",
    ),
    (
        "set_averaging",
        (300,),
        [("SENS:AVER:COUN 300", ""), ("SENS:AVER:COUN?", "1")],
        Refused,
        "averaging to 300 readings, got 1",
    ),
    ("set_averaging", (0,), [], ValueError, "1 to 10000 readings"),
    (
        "zero",
        (0.0,),
        [("SENS:CORR:COLL:ZERO:INIT", ""), ("SENS:CORR:COLL:ZERO:STAT?", "1")],
        InstrumentTimeout,
        "zeroed within 0 s",
    ),
    ("power", (), [("MEAS:POW?", ""), ("*IDN?", "")], InstrumentTimeout, "ends in"),
    (
        "power",
        (),
        [("MEAS:POW?", "9.9E+37"), ("*IDN?", IDENTITY), ("MEAS:POW?", "9.9E+37")],
        BadReply,
        "Check the range",
    ),
    (
        "power",
        (),
        [("MEAS:POW?", ""), ("*IDN?", "1E-3"), ("MEAS:POW?", "2E-3")],
        InstrumentTimeout,
        "ends in",
    ),
]


@pytest.mark.parametrize(("call", "arguments", "steps", "error", "words"), FAULTS)
def test_faults(call, arguments, steps, error, words):
    power_meter, _ = meter(*steps)
    with pytest.raises(error, match=words):
        getattr(power_meter, call)(*arguments)


def test_a_late_reading_is_not_taken_for_the_next_answer():
    power_meter, transport = meter(
        ("MEAS:POW?", ""), ("*IDN?", f"1E-3\n{IDENTITY}"), ("MEAS:POW?", "2E-3")
    )
    assert power_meter.power() == 2e-3
    transport.finish()


def test_against_pyvisa_sim():
    pytest.importorskip("pyvisa_sim")
    device = Path(__file__).with_name("visa") / "pm100d.yaml"
    line = VisaTransport("USB0::0x1313::0x8078::P0012345::INSTR", backend=f"{device}@sim")
    with PowerMeter(line, timeout=0.2) as power_meter:
        assert power_meter.identify()[1].name == "S140C"
        assert power_meter.set_wavelength(532e-9) == pytest.approx(532e-9)
        assert power_meter.set_averaging(100) == 100
        assert power_meter.zero() == 1.2345e-8
        assert power_meter.power() == 3.012345e-3
