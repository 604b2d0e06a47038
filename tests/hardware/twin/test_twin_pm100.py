"""The simulated PM100D by SCPI lines, by PyVISA, and under garbage."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from twin_stand_in import StandInWorld, ask, on_terminal

from cmtof.hardware.twin.faults import Fault, Watch
from cmtof.hardware.twin.pm100_server import DARK_OFFSET, PowerMeterServer
from cmtof.instrument.panel import Panel


class Bench:
    def __init__(self, folder):
        self.panel, self.world, self.watch = Panel(), StandInWorld(), Watch("power_meter")
        self.context = on_terminal(
            PowerMeterServer(self.panel, self.world, self.watch).serve, folder
        )
        self.line, self.client = self.context.__enter__()

    def send(self, text):
        self.client.send(text.encode() + b"\n")

    def ask(self, text):
        return ask(self.client, text)

    def close(self):
        self.context.__exit__(None, None, None)


@pytest.fixture
def bench(tmp_path):
    made = Bench(tmp_path)
    yield made
    made.close()


@pytest.mark.parametrize(
    ("query", "reply"),
    [
        ("*IDN?", "THORLABS,PM100D,P0TWIN001,2.7.0"),
        ("SYST:SENS:IDN?", "S140C,TWIN001,01-Jan-2024,1,7,49"),
        ("system:sensor:idn?", "S140C,TWIN001,01-Jan-2024,1,7,49"),
        ("SYST:ERR?", '+0,"No error"'),
        ("SENS:CORR:WAV? MIN", "3.500000E+02"),
        ("SENSe:CORRection:WAVelength? MAX", "1.100000E+03"),
        ("CORR:WAV?", "6.350000E+02"),
        ("SENS1:AVER:COUN?", "1"),
        ("SENS:POW:RANG:AUTO?", "1"),
        ("SENS:POW:DC:RANG:UPP?", "5.000000E-01"),
        ("SENS:POW:UNIT?", "W"),
        ("*OPC?;SENS:AVER?", "1;1"),
        (":SENS:CORR:COLL:ZERO:STAT?", "0"),
    ],
)
def test_queries(bench, query, reply):
    assert bench.ask(query) == reply


@pytest.mark.parametrize(
    ("command", "query", "reply", "error"),
    [
        ("SENS:CORR:WAV 532", "SENS:CORR:WAV?", "5.320000E+02", '+0,"No error"'),
        ("SENS:CORR:WAV MAX", "SENS:CORR:WAV?", "1.100000E+03", '+0,"No error"'),
        ("SENS:CORR:WAV 200", "SENS:CORR:WAV?", "6.350000E+02", '-222,"Data out of range"'),
        ("SENS:CORR:WAV 1100.1", "SENS:CORR:WAV?", "6.350000E+02", '-222,"Data out of range"'),
        ("SENS:CORR:WAV", "SENS:CORR:WAV?", "6.350000E+02", '-109,"Missing parameter"'),
        ("SENS:CORR:WAV green", "SENS:CORR:WAV?", "6.350000E+02", '-104,"Data type error"'),
        ("SENS:AVER:COUN 100", "SENS:AVER:COUN?", "100", '+0,"No error"'),
        ("SENS:AVER 0", "SENS:AVER?", "1", '-222,"Data out of range"'),
        ("SENS:POW:RANG 2e-3", "SENS:POW:RANG?", "5.000000E-03", '+0,"No error"'),
        ("SENS:POW:RANG:AUTO OFF", "SENS:POW:RANG:AUTO?", "0", '+0,"No error"'),
        ("SENS:POW:UNIT DBM", "SENS:POW:UNIT?", "W", '-224,"Illegal parameter value"'),
        ("POWER", "*OPC?", "1", '-113,"Undefined header"'),
        ("FROB:NICATE?", "*OPC?", "1", '-113,"Undefined header"'),
        ("SENS:AVER 7;*RST", "SENS:AVER?", "1", '+0,"No error"'),
    ],
)
def test_settings_and_the_error_queue(bench, command, query, reply, error):
    bench.send(command)
    assert bench.ask(query) == reply
    assert bench.ask("SYST:ERR?") == error
    assert bench.ask("SYST:ERR:NEXT?") == '+0,"No error"'


def test_errors_queue_up_and_are_cleared(bench):
    bench.send("NOSUCH;SENS:AVER x")
    assert bench.ask("SYST:ERR?").startswith("-113")
    assert bench.ask("SYST:ERR?").startswith("-104")
    bench.send("NOSUCH")
    bench.send("*CLS")
    assert bench.ask("SYST:ERR?").startswith("+0")


def test_readings_take_their_time_and_zeroing_takes_the_offset(bench):
    assert float(bench.ask("MEAS:POW?")) == pytest.approx(DARK_OFFSET)
    bench.send("SENS:CORR:COLL:ZERO:INIT")
    assert float(bench.ask("SENS:CORR:COLL:ZERO:MAGN?")) == pytest.approx(DARK_OFFSET)
    assert float(bench.ask("READ?")) == 0
    bench.panel.laser_on = bench.panel.shutter_open = True
    before = bench.panel.time
    bench.send("CONF:POW")
    bench.send("SENS:AVER 100")
    assert float(bench.ask("READ?")) == pytest.approx(1e-3)
    assert bench.panel.time - before == pytest.approx(0.3)


def test_overload_is_infinity(bench):
    bench.panel.laser_on = bench.panel.shutter_open = True
    bench.send("SENS:POW:RANG 1e-4")
    assert float(bench.ask("MEAS:POW?")) == 9.9e37


def test_pyvisa_reads_it(bench):
    pyvisa = pytest.importorskip("pyvisa")
    pytest.importorskip("pyvisa_py")
    manager = pyvisa.ResourceManager("@py")
    try:
        meter = manager.open_resource(
            f"ASRL{bench.line.link}::INSTR", read_termination="\n", write_termination="\n"
        )
        assert meter.query("*IDN?").startswith("THORLABS,PM100D")
        meter.write("SENS:CORR:WAV 532")
        assert float(meter.query("SENS:CORR:WAV?")) == 532
        meter.close()
    finally:
        manager.close()


@pytest.mark.parametrize(("kind", "reply"), [("ignore", 635.0), ("clamp", 457.0)])
def test_setting_that_is_not_taken(bench, kind, reply):
    bench.watch.add(Fault("power_meter", kind))
    bench.send("SENS:CORR:WAV 532")
    assert float(bench.ask("SENS:CORR:WAV?")) == reply


@given(garbage=st.binary(max_size=300))
@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_garbage_is_survived(bench, garbage):
    bench.client.send(garbage + b"\n*CLS\n")
    while bench.client.read(0.001):
        pass
    assert bench.ask("*IDN?").startswith("THORLABS")
    assert bench.ask("SYST:ERR?").startswith("+0")
