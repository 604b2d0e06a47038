"""The Siglent driver: written dialogues, and an independent simulated device behind VISA."""

import math
from pathlib import Path

import pytest

from cmtof.hardware.drivers.signal_generator import SignalGenerator
from cmtof.hardware.errors import BadReply, InstrumentError, InstrumentTimeout, Refused
from cmtof.hardware.transport import ReplayTransport, VisaTransport

IDENTITY = "Siglent Technologies,SDG2042X,SDG2XCAX1R0001,2.01.01.39R7T2"
SINE = "C1:BSWV WVTP,SINE,FRQ,10000000,AMP,1,OFST,0,PHSE,0"
WAVE = (
    "C1:BSWV WVTP,SINE,FRQ,10000000HZ,PERI,1e-07S,AMP,1V,AMPVRMS,0.354Vrms,AMPDBM,3.98dBm,"
    "OFST,0V,HLEV,0.5V,LLEV,-0.5V,PHSE,0"
)
LOAD = [("C1:OUTP LOAD,50", ""), ("C1:OUTP?", "C1:OUTP OFF,LOAD,50,PLRT,NOR")]


def generator(*steps):
    transport = ReplayTransport(
        [
            (request.encode() + b"\n", answer.encode() + b"\n" if answer else b"")
            if not isinstance(answer, InstrumentError)
            else (request.encode() + b"\n", answer)
            for request, answer in steps
        ]
    )
    return SignalGenerator(transport, timeout=0.01), transport


def set_sine(clock, **changes):
    clock.set_load(1, 50)
    return clock.set_sine(1, **{"frequency": 10e6, "amplitude": 1.0, **changes})


def test_the_load_comes_before_the_amplitude_and_all_is_read_back():
    clock, transport = generator(*LOAD, (SINE, ""), ("C1:BSWV?", WAVE))
    wave = set_sine(clock)
    assert (wave.frequency, wave.amplitude, wave.offset, wave.phase) == (10e6, 1.0, 0.0, 0.0)
    transport.finish()


def test_a_sine_without_a_load_is_not_sent():
    clock, transport = generator()
    with pytest.raises(ValueError, match="Expected the load of channel 1 before its amplitude"):
        clock.set_sine(1, frequency=10e6, amplitude=1.0)
    transport.finish()


def test_a_phase_is_given_in_rad_and_sent_in_degrees():
    sent = SINE.replace("PHSE,0", "PHSE,270")
    clock, transport = generator(*LOAD, (sent, ""), ("C1:BSWV?", WAVE[:-1] + "270"))
    assert set_sine(clock, phase=-math.pi / 2).phase == pytest.approx(1.5 * math.pi)
    transport.finish()


@pytest.mark.parametrize(
    ("wave", "words"),
    [
        (WAVE.replace("FRQ,10000000HZ", "FRQ,9MHZ"), "frequency to 10000000 Hz, got 9000000 Hz"),
        (WAVE.replace("AMP,1V", "AMP,0.5V"), "amplitude to 1 V, got 0.5 V"),
        (WAVE.replace("OFST,0V", "OFST,100mV"), "offset to 0 V, got 0.1 V"),
        (WAVE.replace("PHSE,0", "PHSE,3"), "phase to 0 degrees off, got 3"),
        (WAVE.replace("SINE", "SQUARE"), "make a SINE, got SQUARE"),
        (WAVE.replace("AMP,1V,", ""), "amplitude to 1 V, got nan V"),
    ],
)
def test_a_setting_that_is_clamped_or_ignored_is_found(wave, words):
    clock, _ = generator(*LOAD, (SINE, ""), ("C1:BSWV?", wave))
    with pytest.raises(Refused, match=words):
        set_sine(clock)


@pytest.mark.parametrize(
    ("ohm", "sent", "held"),
    [(50, "50", "50"), ("HZ", "HZ", "HZ"), (75.0, "75", "75"), (50, "50", "HZ")],
)
def test_loads(ohm, sent, held):
    clock, transport = generator(
        (f"C2:OUTP LOAD,{sent}", ""), ("C2:OUTP?", f"C2:OUTP OFF,LOAD,{held},PLRT,NOR")
    )
    if held != sent:
        with pytest.raises(Refused, match="load to 50 Ohm, got inf Ohm"):
            clock.set_load(2, ohm)
    else:
        clock.set_load(2, ohm)
    transport.finish()


@pytest.mark.parametrize("held", ["ON", "OFF"])
def test_an_output_that_stays_is_found(held):
    clock, transport = generator(
        ("C1:OUTP ON", ""), ("C1:OUTP?", f"C1:OUTP {held},LOAD,50,PLRT,NOR")
    )
    if held == "OFF":
        with pytest.raises(Refused, match="output 1 of clock ON, got the contrary"):
            clock.output(1, True)
    else:
        clock.output(1, True)
    transport.finish()


@pytest.mark.parametrize(
    ("steps", "error"),
    [
        ([("MODE PHASE-LOCKED", ""), ("MODE?", "MODE PHASE-LOCKED")], None),
        (
            [
                ("MODE PHASE-LOCKED", ""),
                ("MODE?", "MODE INDEPENDENT"),
                ("MODE PHASELOCKED", ""),
                ("MODE?", "MODE PHASELOCKED"),
            ],
            None,
        ),
        (
            [
                ("MODE PHASE-LOCKED", ""),
                ("MODE?", "MODE INDEPENDENT"),
                ("MODE PHASELOCKED", ""),
                ("MODE?", "MODE INDEPENDENT"),
            ],
            "with both spellings",
        ),
    ],
)
def test_both_spellings_of_phase_locked(steps, error):
    clock, transport = generator(*steps)
    if error:
        with pytest.raises(Refused, match=error):
            clock.phase_locked()
    else:
        clock.phase_locked()
    transport.finish()


@pytest.mark.parametrize("reply", ["ROSC EXT", "ROSC EXT,10MOUT,OFF"])
def test_the_reference(reply):
    clock, transport = generator(("ROSC EXT", ""), ("ROSC?", reply))
    clock.reference("EXT")
    transport.finish()
    clock, _ = generator(("ROSC INT", ""), ("ROSC?", reply))
    with pytest.raises(Refused, match="on the INT reference, got EXT"):
        clock.reference("INT")


def test_a_lost_answer_is_asked_for_again_behind_an_identity():
    """The late answer must not be taken for that to the next question."""
    late = "C1:OUTP ON,LOAD,50,PLRT,NOR\n"
    clock, transport = generator(
        ("C1:OUTP ON", ""),
        ("C1:OUTP?", ""),
        ("*IDN?", late + IDENTITY),
        ("C1:OUTP?", "C1:OUTP ON,LOAD,50,PLRT,NOR"),
    )
    clock.output(1, True)
    transport.finish()


@pytest.mark.parametrize(
    ("steps", "error", "words"),
    [
        ([("*IDN?", ""), ("*IDN?", "")], InstrumentTimeout, "ends in"),
        ([("*IDN?", "?"), ("*IDN?", IDENTITY), ("*IDN?", "?")], BadReply, "MAKER,MODEL"),
        ([("*IDN?", "Siglent,SDS1204X,1,2")], Refused, "Expected a Siglent SDG2042X"),
        ([("*IDN?", "Rigol,SDG2042X,1,2")], Refused, "got Rigol"),
    ],
)
def test_identity_faults(steps, error, words):
    clock, transport = generator(*steps)
    with pytest.raises(error, match=words):
        clock.identify()
    transport.finish()


def test_the_safe_state_switches_both_outputs_off():
    clock, transport = generator(
        ("C1:OUTP OFF", ""),
        ("C1:OUTP?", "C1:OUTP OFF,LOAD,50,PLRT,NOR"),
        ("C2:OUTP OFF", ""),
        ("C2:OUTP?", "C2:OUTP OFF,LOAD,HZ,PLRT,NOR"),
    )
    clock.safe_state()
    transport.finish()


@pytest.mark.parametrize("channel", [0, 3])
def test_there_are_two_channels(channel):
    with pytest.raises(ValueError, match="channel 1 or 2"):
        SignalGenerator(ReplayTransport([])).output(channel, True)


@pytest.fixture
def simulated():
    pytest.importorskip("pyvisa_sim")
    device = Path(__file__).with_name("visa") / "sdg2042x.yaml"
    with SignalGenerator(
        VisaTransport("TCPIP0::127.0.0.1::5025::SOCKET", backend=f"{device}@sim"), timeout=0.2
    ) as clock:
        yield clock


def test_against_pyvisa_sim(simulated):
    assert simulated.identify().model == "SDG2042X"
    for channel in (1, 2):
        simulated.set_load(channel, 50)
        wave = simulated.set_sine(channel, frequency=10e6, amplitude=1.0)
        assert (wave.kind, wave.frequency, wave.amplitude) == ("SINE", 10e6, 1.0)
    simulated.reference("EXT")
    simulated.phase_locked()
    simulated.align_phases()
    simulated.output(1, True)


def test_pyvisa_sim_does_not_take_what_is_out_of_range(simulated):
    simulated.set_load(1, 50)
    with pytest.raises(Refused, match="frequency to 90000000 Hz, got 1000000 Hz"):
        simulated.set_sine(1, frequency=90e6, amplitude=1.0)


def test_pyvisa_sim_is_silent_to_what_it_does_not_know(simulated):
    with pytest.raises(InstrumentTimeout):
        simulated._query("C3:WHAT?", bytes)
