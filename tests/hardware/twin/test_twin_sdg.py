"""The simulated SDG2042X by the strings of its manual, and by its bad habits."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from twin_stand_in import SocketClient, ask, on_port

from cmtof.hardware.twin.faults import Fault, Watch
from cmtof.hardware.twin.sdg_server import SdgServer
from cmtof.instrument.panel import Panel


class Bench:
    def __init__(self, **options):
        self.panel, self.watch = Panel(), Watch("clock")
        self.context = on_port(SdgServer(self.panel, self.watch, **options).serve)
        self.line, self.client = self.context.__enter__()

    def send(self, text):
        self.client.send(text.encode() + b"\n")

    def ask(self, text):
        return ask(self.client, text)

    def wave(self, channel="C1"):
        header, _, text = self.ask(f"{channel}:BSWV?").partition(" ")
        assert header == f"{channel}:BSWV"
        words = text.split(",")
        return dict(zip(words[::2], words[1::2], strict=True))

    def silent(self):
        return not self.client.read(0.03)

    def close(self):
        self.context.__exit__(None, None, None)


@pytest.fixture
def bench():
    made = Bench()
    yield made
    made.close()


def test_strings_of_the_manual(bench):
    assert bench.ask("*IDN?").startswith("Siglent Technologies,SDG2042X,")
    assert bench.ask("C1:BSWV?") == (
        "C1:BSWV WVTP,SINE,FRQ,1000HZ,PERI,0.001S,AMP,4V,OFST,0V,HLEV,2V,LLEV,-2V,PHSE,0"
    )
    assert bench.ask("C1:OUTP?") == "C1:OUTP OFF,LOAD,HZ,PLRT,NOR"
    bench.send("C1:OUTP ON")
    assert bench.ask("C1:OUTP?") == "C1:OUTP ON,LOAD,HZ,PLRT,NOR"
    assert bench.ask("ROSC?") == "ROSC INT,10MOUT,OFF"
    assert bench.ask("MODE?") == "MODE INDEPENDENT"
    assert bench.ask("COUP?") == "COUP PCOUP,OFF,PDEV,0,FCOUP,OFF,FDEV,0"


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        ("C1:BSWV FRQ,10000000", {"FRQ": "10000000HZ", "PERI": "1e-07S"}),
        ("C1:BSWV FRQ,2000HZ,AMP,1V", {"FRQ": "2000HZ", "AMP": "1V", "HLEV": "0.5V"}),
        ("C1:BSWV FRQ,2KHZ", {"FRQ": "2000HZ"}),
        ("C1:BSWV PERI,0.0005", {"FRQ": "2000HZ"}),
        ("C1:BSWV HLEV,5", {"AMP": "7V", "OFST": "1.5V", "LLEV": "-2V"}),
        ("C1:BSWV LLEV,0", {"AMP": "2V", "OFST": "1V", "HLEV": "2V"}),
        ("C1:BSWV LLEV,3", {"AMP": "4V", "OFST": "0V"}),  # above HLEV: dropped
        ("C1:BSWV OFST,1", {"HLEV": "3V", "LLEV": "-1V"}),
        ("C1:BSWV OFST,100", {"OFST": "8V", "HLEV": "10V"}),  # clamped, in silence
        ("C1:BSWV AMP,1000", {"AMP": "20V", "OFST": "0V"}),
        ("C1:BSWV AMP,0", {"AMP": "0.002V"}),
        ("C1:BSWV FRQ,1E9", {"FRQ": "40000000HZ"}),
        ("C1:BSWV FRQ,0", {"FRQ": "1e-06HZ"}),
        ("C1:BSWV PHSE,90", {"PHSE": "90"}),
        ("C1:BSWV WVTP,SQUARE", {"WVTP": "SQUARE"}),
        ("C1:BSWV WVTP,CIRCLE", {"WVTP": "SINE"}),  # unknown: dropped, in silence
        ("C1:BSWV FRQ,nan", {"FRQ": "1000HZ"}),
        ("C1:BSWV FRQ", {"FRQ": "1000HZ"}),
        ("C1:BSWV SPIN,3", {"FRQ": "1000HZ"}),
        ("c1:bswv frq,3000", {"FRQ": "3000HZ"}),
        ("*RST;C1:BSWV FRQ,4000", {"FRQ": "4000HZ"}),
    ],
)
def test_what_is_set_is_not_always_what_was_asked(bench, command, expected):
    bench.send(command)
    wave = bench.wave()
    assert {key: wave[key] for key in expected} == expected
    assert bench.wave("C2")["FRQ"] == "1000HZ"


def test_amplitude_follows_the_load(bench):
    bench.send("C1:OUTP LOAD,50")
    assert bench.wave()["AMP"] == "2V"  # the same voltage behind 50 ohm
    bench.send("C1:BSWV AMP,100")
    assert bench.wave()["AMP"] == "10V"
    bench.send("C1:OUTP LOAD,HZ")
    assert bench.wave()["AMP"] == "20V"
    bench.send("C1:OUTP LOAD,1")
    assert bench.ask("C1:OUTP?") == "C1:OUTP OFF,LOAD,50,PLRT,NOR"
    bench.send("C1:OUTP PLRT,INVT")
    assert bench.ask("C1:OUTP?").endswith("PLRT,INVT")


@pytest.mark.parametrize(("hyphen", "good", "ignored"), [
    (True, "PHASE-LOCKED", "PHASELOCKED"),
    (False, "PHASELOCKED", "PHASE-LOCKED"),
])  # fmt: skip
def test_one_spelling_of_the_mode_is_ignored(hyphen, good, ignored):
    bench = Bench(hyphen=hyphen)
    bench.send(f"MODE {ignored}")
    assert bench.ask("MODE?") == "MODE INDEPENDENT"
    bench.send(f"MODE {good}")
    assert bench.ask("MODE?") == f"MODE {good}"
    bench.close()


def test_reference_and_coupling(bench):
    for command in ("ROSC EXT", "EQPHASE", "COUP PCOUP,ON", "COUP PDEV,90", "COUP FDEV,x"):
        bench.send(command)
    assert bench.ask("ROSC?").startswith("ROSC EXT")
    assert bench.ask("COUP?") == "COUP PCOUP,ON,PDEV,90,FCOUP,OFF,FDEV,0"
    bench.send("ROSC MAYBE")
    assert bench.ask("ROSC?").startswith("ROSC EXT")


@pytest.mark.parametrize("query", ["SYST:ERR?", "C3:BSWV?", "C1:FOO?", "EQPHASE?", "*TST?", "?"])
def test_unknown_query_is_not_answered(bench, query):
    bench.send(query)
    assert bench.silent()
    assert bench.ask("MODE?") == "MODE INDEPENDENT"


def test_output_one_is_the_clock(bench):
    bench.send("C1:BSWV FRQ,10000000;C2:OUTP ON")
    bench.ask("MODE?")
    assert (bench.panel.clock_on, bench.panel.clock_frequency) == (False, 10e6)
    bench.send("C1:OUTP ON")
    bench.ask("MODE?")
    assert bench.panel.clock_on


def test_clients_share_the_device(bench):
    other = SocketClient(bench.line.port)
    bench.send("C1:BSWV FRQ,5000")
    bench.ask("MODE?")
    assert "FRQ,5000HZ" in ask(other, "C1:BSWV?")
    other.close()


@pytest.mark.parametrize(("kind", "frequency"), [("ignore", "1000HZ"), ("clamp", "6000000HZ")])
def test_setting_that_is_not_taken(bench, kind, frequency):
    bench.watch.add(Fault("clock", kind))
    bench.ask("*IDN?")  # a query is no occasion
    bench.send("C1:BSWV FRQ,10000000")
    assert bench.wave()["FRQ"] == frequency
    bench.send("C1:BSWV FRQ,10000000")
    assert bench.wave()["FRQ"] == "10000000HZ"


words = st.sampled_from(
    ["C1:", "C2:", "BSWV", "OUTP", "MODE", "ROSC", "COUP", "*RST", ";", ",", " ", "FRQ", "PERI",
     "AMP", "HLEV", "LLEV", "LOAD", "HZ", "0", "-1e308", "1e-300", "5", "PHASE-LOCKED", "\n"]
)  # fmt: skip


@given(st.one_of(st.binary(max_size=300), st.lists(words, max_size=40).map("".join)))
@settings(max_examples=80, deadline=None)
def test_garbage_is_survived(garbage):
    bench = Bench()
    bench.client.send(garbage if isinstance(garbage, bytes) else garbage.encode())
    bench.client.send(b"\n")
    good = SocketClient(bench.line.port)
    assert ask(good, "*IDN?").startswith("Siglent")
    wave = dict(zip(*[iter(ask(good, "C1:BSWV?").split(" ", 1)[1].split(","))] * 2, strict=True))
    assert 1e-6 <= float(wave["FRQ"].removesuffix("HZ")) <= 40e6
    good.close()
    bench.close()
