"""Siglent and Thorlabs text replies: as devices were seen to send them, round trips, garbage."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cmtof.hardware.codecs import scpi
from cmtof.hardware.codecs.scpi import Identity, Output, Sensor, SensorFlags, Wave
from cmtof.hardware.errors import BadReply, InstrumentError

# Default reply of an SDG2042X after *RST, "measured, hardware session 1" in the tests of
# siglent_sdg_openhtf.
SDG2042X = (
    b"C1:BSWV WVTP,SINE,FRQ,1000HZ,PERI,0.001S,AMP,4V,AMPVRMS,1.414Vrms,OFST,0V,"
    b"HLEV,2V,LLEV,-2V,PHSE,0\n"
)
# Reply in PyMeasure's test of the Teledyne T3AFG, a Siglent under another name.
T3AFG = (
    b"C1:BSWV WVTP,SINE,FRQ,0.3HZ,PERI,3.33333S,AMP,0.08V,AMPVRMS,0.02828Vrms,"
    b"MAX_OUTPUT_AMP,4.6V,OFST,-2V,HLEV,-1.96V,LLEV,-2.04V,PHSE,0"
)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (SDG2042X, Wave("SINE", 1000.0, 4.0, 0.0, 0.0)),
        (T3AFG, Wave("SINE", 0.3, 0.08, -2.0, 0.0)),
        # another order of the keys, prefixed units, phase with unit
        (
            b"c1:bswv PHSE,180deg,OFST,-250mV,AMP,500mVpp,FRQ,10MHZ,WVTP,sine",
            Wave("SINE", 1e7, 0.5, -0.25, math.pi),
        ),
        # what the wave does not have
        (b"C1:BSWV WVTP,DC,OFST,1V", Wave("DC", None, None, 1.0, None)),
        (b"C1:BSWV WVTP,NOISE,STDEV,0.5V,MEAN,0V", Wave("NOISE", None, None, None, None)),
    ],
)
def test_waves(line, expected):
    assert scpi.parse_wave(line, 1) == expected


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        (b"", "Expected a line of text, got b''"),
        (b"\n", "Expected a line of text"),
        (b"\xff\xfe\n", "Expected a line of text"),
        (b"C1:BSWV WVTP,\x07\n", "Expected a line of text"),
        (SDG2042X[:-1].replace(b"C1", b"C2"), "Expected a reply to C1:BSWV?, got 'C2:BSWV"),
        (b"C1:OUTP ON,LOAD,HZ,PLRT,NOR", "Expected a reply to C1:BSWV?"),
        (b"C1:BSWV", "Expected a reply to C1:BSWV?"),
        (b"C1:BSWV WVTP,SINE,FRQ", "Expected pairs of key and value"),
        (b"C1:BSWV WVTP,SINE,,1000HZ", "Expected pairs"),
        (b"C1:BSWV FRQ,1000HZ", "Expected a wave with WVTP"),
        (b"C1:BSWV WVTP,SINE,FRQ,1000V", "Expected a number (units: HZ, KHZ"),
        (b"C1:BSWV WVTP,SINE,FRQ,", "Expected a number"),
        (b"C1:BSWV WVTP,SINE,AMP,nanV", "Expected a number (units: V"),
        (b"C1:BSWV WVTP,SINE,AMP,1e999V", "Expected a reading in range"),
        (b"C1:BSWV WVTP,SINE,PHSE,1_0", "Expected a number (units: DEG)"),
        (SDG2042X[:45], "Expected a number (units: V"),  # the reply was cut
    ],
)
def test_bad_waves_by_their_message(line, problem):
    with pytest.raises(BadReply) as caught:
        scpi.parse_wave(line, 1)
    assert problem in str(caught.value)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        # the reply that the SDG Programming Guide and the measured fake above agree on
        (b"C1:OUTP OFF,LOAD,HZ,PLRT,NOR\n", Output(False, math.inf, False)),
        (b"C1:OUTP ON,LOAD,50,PLRT,INVT", Output(True, 50.0, True)),
        (b"C1:OUTP ON,LOAD,600OHM", Output(True, 600.0, False)),
        (b"C1:OUTP ON,POWERON_STATE,0,LOAD,50,PLRT,NOR", Output(True, 50.0, False)),
    ],
)
def test_outputs(line, expected):
    assert scpi.parse_output(line, 1) == expected


@pytest.mark.parametrize(
    "line",
    [
        b"C1:OUTP",
        b"C1:OUTP MAYBE,LOAD,HZ,PLRT,NOR",
        b"C1:OUTP ON",
        b"C1:OUTP ON,LOAD,,PLRT,NOR",
        b"C1:OUTP ON,LOAD,soft,PLRT,NOR",
        b"C1:OUTP ON,LOAD,HZ,PLRT,UPSIDE",
        b"C1:OUTP ON,LOAD",
        b"C2:OUTP ON,LOAD,HZ,PLRT,NOR",
    ],
)
def test_bad_outputs(line):
    with pytest.raises(BadReply, match="Expected "):
        scpi.parse_output(line, 1)


@pytest.mark.parametrize(
    ("parse", "line", "expected"),
    [
        (scpi.parse_reference, b"ROSC INT", "INT"),
        (scpi.parse_reference, b"ROSC EXT,10MOUT,OFF\n", "EXT"),
        (scpi.parse_mode, b"MODE PHASE-LOCKED", True),
        (scpi.parse_mode, b"MODE PHASELOCKED\n", True),
        (scpi.parse_mode, b"MODE INDEPENDENT", False),
        (
            scpi.parse_identity,
            b"Siglent Technologies,SDG2042X,SDG2XCAX1R0001,2.01.01.39R7T2\n",
            Identity("Siglent Technologies", "SDG2042X", "SDG2XCAX1R0001", "2.01.01.39R7T2"),
        ),
        # form THORLABS,MMM,SSS,X.X.X of the PM100D's manual
        (
            scpi.parse_identity,
            b"THORLABS,PM100D,P0000001,2.6.0",
            Identity("THORLABS", "PM100D", "P0000001", "2.6.0"),
        ),
        # a real S140C, as public Matlab drivers note beside their SYST:SENS:IDN?
        (
            scpi.parse_sensor,
            b"S140C,11040529,05-Apr-2011,1,18,289\n",
            Sensor(
                "S140C",
                "11040529",
                "05-Apr-2011",
                1,
                18,
                SensorFlags.POWER | SensorFlags.WAVELENGTH | SensorFlags.TEMPERATURE,
            ),
        ),
        # a real S170C (same source): no thermistor
        (
            scpi.parse_sensor,
            b'"S170C","701207","17-Dec-2014",1,2,33',
            Sensor(
                "S170C",
                "701207",
                "17-Dec-2014",
                1,
                2,
                SensorFlags.POWER | SensorFlags.WAVELENGTH,
            ),
        ),
        (scpi.parse_number, b"5.000000E-01\n", 0.5),
        (scpi.parse_number, b"-1.25e-9", -1.25e-9),
        (scpi.parse_number, b"532", 532.0),
        (scpi.parse_error, b'0,"No error"\n', (0, "No error")),
        (scpi.parse_error, b'-113,"Undefined header"', (-113, "Undefined header")),
    ],
)
def test_other_replies(parse, line, expected):
    assert parse(line) == expected


@pytest.mark.parametrize(
    ("parse", "line", "problem"),
    [
        (scpi.parse_reference, b"ROSC GPS", "Expected ROSC INT or EXT"),
        (scpi.parse_reference, b"INT", "Expected a reply to ROSC?"),
        (scpi.parse_mode, b"MODE LOCKED", "Expected PHASE-LOCKED or INDEPENDENT"),
        (scpi.parse_identity, b"Siglent Technologies,SDG2042X", "MAKER,MODEL,SERIAL,FIRMWARE"),
        (scpi.parse_identity, b",,,", "MAKER,MODEL,SERIAL,FIRMWARE"),
        (scpi.parse_sensor, b"S140C,11040529,05-Apr-2011,1,18", "NAME,SERIAL,CALIBRATION"),
        (scpi.parse_sensor, b"S140C,11040529,05-Apr-2011,1,18,0x21", "NAME,SERIAL,CALIBRATION"),
        (scpi.parse_sensor, "S140C,1,2,1,18,٢٨".encode(), "Expected a line of text"),
        (scpi.parse_number, b"", "Expected a line of text"),
        (scpi.parse_number, b"1.0E-3 W", "Expected a number (units: none)"),
        (scpi.parse_number, b"nan", "Expected a number"),
        (scpi.parse_number, b"inf", "Expected a number"),
        (scpi.parse_number, b"__import__('os')", "Expected a number"),
        # SCPI-99, 7.2.1.4 and 7.2.1.5: infinity and not a number
        (scpi.parse_number, b"9.90000000E+37", "Expected a reading in range"),
        (scpi.parse_number, b"-9.9E37", "Expected a reading in range"),
        (scpi.parse_number, b"9.91E+37", "Expected a reading in range"),
        (scpi.parse_error, b"No error", 'Expected CODE,"TEXT"'),
        (scpi.parse_error, b"x,y", 'Expected CODE,"TEXT"'),
    ],
)
def test_other_bad_replies_by_their_message(parse, line, problem):
    with pytest.raises(BadReply) as caught:
        parse(line)
    assert problem in str(caught.value)
    assert str(caught.value).startswith("Expected ")


@pytest.mark.parametrize(
    ("text", "hertz"),
    [("1000HZ", 1e3), ("1KHz", 1e3), ("7.15GHZ", 7.15e9), ("1e-06HZ", 1e-6), ("5uHZ", 5e-6)],
)
def test_frequencies(text, hertz):
    assert scpi.frequency(text) == pytest.approx(hertz, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "volts"),
    [("4V", 4.0), ("-2.5mV", -2.5e-3), ("10uV", 1e-5), (".5Vpp", 0.5), ("0", 0.0)],
)
def test_voltages(text, volts):
    assert scpi.voltage(text) == pytest.approx(volts, rel=1e-15)


FINITE = st.floats(-1e30, 1e30, allow_nan=False)


@given(FINITE)
def test_numbers_round_trip(value):
    assert scpi.parse_number(f"{value!r}\n".encode()) == value


@given(
    st.floats(1e-6, 4e7),
    st.floats(2e-3, 20),
    st.floats(-10, 10),
    st.floats(-360, 360),
    st.permutations(["WVTP", "FRQ", "PERI", "AMP", "OFST", "PHSE"]),
)
def test_waves_round_trip_in_any_order(frequency, amplitude, offset, phase, order):
    texts = {
        "WVTP": "SINE",
        "FRQ": f"{frequency!r}HZ",
        "PERI": f"{1 / frequency!r}S",
        "AMP": f"{amplitude!r}V",
        "OFST": f"{offset!r}V",
        "PHSE": f"{phase!r}",
    }
    line = "C2:BSWV " + ",".join(f"{key},{texts[key]}" for key in order)
    assert scpi.parse_wave(line.encode(), 2) == Wave(
        "SINE", frequency, amplitude, offset, math.radians(phase)
    )


PARSERS = [
    lambda line: scpi.parse_wave(line, 1),
    lambda line: scpi.parse_output(line, 1),
    scpi.parse_reference,
    scpi.parse_mode,
    scpi.parse_identity,
    scpi.parse_sensor,
    scpi.parse_number,
    scpi.parse_error,
]
GARBAGE = st.one_of(
    st.binary(max_size=60),
    st.text(max_size=60).map(lambda t: t.encode("utf-8", "replace")),
    st.lists(
        st.sampled_from(
            [
                "C1:BSWV ",
                "C1:OUTP ",
                "ROSC ",
                "MODE ",
                "WVTP",
                "FRQ",
                "ON",
                "LOAD",
                ",",
                "1e9",
                "HZ",
            ]
        ),
        max_size=12,
    ).map(lambda parts: "".join(parts).encode()),
)


@given(st.sampled_from(PARSERS), GARBAGE)
def test_garbage_is_a_bad_reply(parse, line):
    try:
        parse(line)
    except BadReply as error:
        assert isinstance(error, InstrumentError)
        assert str(error).startswith("Expected ")


def test_commands():
    assert scpi.line_from_text("C1:BSWV FRQ,1000") == b"C1:BSWV FRQ,1000\n"


@pytest.mark.parametrize("text", ["", "A\nB", "A\rB", "a\0", "50 Ω"])
def test_bad_commands_by_their_message(text):
    with pytest.raises(ValueError, match="Expected a command of printable ASCII, got"):
        scpi.line_from_text(text)
