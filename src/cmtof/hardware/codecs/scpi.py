"""Text commands: Siglent's generators, Thorlabs' power meters, and what they share.

Siglent: SDG Series Programming Guide, commands BSWV, OUTP, ROSC, MODE; replies echo the header and
carry units, and firmware versions add keys, so they are read as pairs, never by position. Thorlabs:
PM100D manual, SCPI commands; flags of the sensor as in PyMeasure's thorlabspm100usb.
"""

import math
import re
from dataclasses import dataclass
from enum import IntFlag

from cmtof.hardware.errors import BadReply

END = b"\n"
_NUMBER = re.compile(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*([A-Za-z%]*)")
_OVERFLOW = 9.9e37  # SCPI-99, 7.2.1: 9.9E37 is infinity, 9.91E37 not a number

_FREQUENCY = {"": 1.0, "HZ": 1.0, "KHZ": 1e3, "MHZ": 1e6, "GHZ": 1e9, "UHZ": 1e-6}
_VOLTAGE = {"": 1.0, "V": 1.0, "MV": 1e-3, "UV": 1e-6, "VPP": 1.0, "MVPP": 1e-3}
_PLAIN = {"": 1.0}
_DEGREES = {"": 1.0, "DEG": 1.0}


@dataclass(frozen=True)
class Identity:
    """Answer to ``*IDN?``."""

    maker: str
    model: str
    serial: str
    firmware: str


@dataclass(frozen=True)
class Wave:
    """Basic wave of a Siglent channel: frequency Hz, amplitude V peak to peak, offset V, phase rad.

    What the wave does not have is None.
    """

    kind: str
    frequency: float | None
    amplitude: float | None
    offset: float | None
    phase: float | None


@dataclass(frozen=True)
class Output:
    """Output of a Siglent channel; a load of infinity is high impedance, Ohm."""

    on: bool
    load: float
    inverted: bool


class SensorFlags(IntFlag):
    """What a sensor head can do."""

    POWER = 1
    ENERGY = 2
    RESPONSE = 16
    WAVELENGTH = 32
    TIME_CONSTANT = 64
    TEMPERATURE = 256


@dataclass(frozen=True)
class Sensor:
    """Answer of a PM100D to ``SYST:SENS:IDN?``."""

    name: str
    serial: str
    calibration: str
    type: int
    subtype: int
    flags: SensorFlags


def line_from_text(text: str) -> bytes:
    """Command with its newline.

    Raises
    ------
    ValueError
        If it is empty or holds what is not printable ASCII.
    """
    if not text or not text.isascii() or not text.isprintable():
        raise ValueError(f"Expected a command of printable ASCII, got {text!r}. Fix it.")
    return text.encode("ascii") + END


def text_from_line(line: bytes) -> str:
    """Text of a reply, without the line's end and quotes around it all left as they are.

    Raises
    ------
    BadReply
        If it is empty or not printable ASCII.
    """
    try:
        text = line.decode("ascii").strip()
    except UnicodeDecodeError:
        text = ""
    if not text or not text.isprintable():
        raise BadReply(f"Expected a line of text, got {line[:80]!r}. Flush and ask again.")
    return text


def number(text: str, units: dict[str, float] = _PLAIN) -> float:
    """Number with one of the units, in upper case, times the unit's factor.

    Raises
    ------
    BadReply
        If it is no finite number, an overflow (9.9E37) or has another unit.

    Examples
    --------
    >>> number("1.2E-3"), frequency("10MHZ"), voltage("250mV")
    (0.0012, 10000000.0, 0.25)
    """
    match = _NUMBER.fullmatch(text.strip())
    factor = units.get(match[2].upper()) if match else None
    if not match or factor is None:
        known = ", ".join(unit for unit in units if unit) or "none"
        raise BadReply(f"Expected a number (units: {known}), got {text[:80]!r}. Ask again.")
    value = float(match[1])
    if not math.isfinite(value) or abs(value) >= _OVERFLOW:
        raise BadReply(f"Expected a reading in range, got {text[:80]!r}. Check the range.")
    return value * factor


def frequency(text: str) -> float:
    """Hz of a text with unit; `BadReply` otherwise."""
    return number(text, _FREQUENCY)


def voltage(text: str) -> float:
    """V of a text with unit; `BadReply` otherwise."""
    return number(text, _VOLTAGE)


def parse_identity(line: bytes) -> Identity:
    """Maker, model, serial number and firmware; `BadReply` where they are not four."""
    parts = [part.strip() for part in text_from_line(line).split(",")]
    if len(parts) != 4 or not parts[0] or not parts[1]:
        raise BadReply(f"Expected MAKER,MODEL,SERIAL,FIRMWARE, got {line[:80]!r}. Ask again.")
    return Identity(*parts)


def _body(line: bytes, header: str) -> list[str]:
    """Fields behind the header that a Siglent echoes."""
    text = text_from_line(line)
    found, space, rest = text.partition(" ")
    if found.upper() != header or not space:
        raise BadReply(f"Expected a reply to {header}?, got {text[:80]!r}. Flush and ask again.")
    return [field.strip() for field in rest.split(",")]


def _pairs(fields: list[str], line: bytes) -> dict[str, str]:
    if len(fields) % 2 or not all(fields[::2]):
        raise BadReply(f"Expected pairs of key and value, got {line[:80]!r}. Ask again.")
    return {key.upper(): value for key, value in zip(fields[::2], fields[1::2], strict=True)}


def parse_wave(line: bytes, channel: int) -> Wave:
    """Wave of a reply to ``Cn:BSWV?``.

    Raises
    ------
    BadReply
        If it is no such reply, or a value is no number with a unit.

    Examples
    --------
    >>> reply = b"C1:BSWV WVTP,SINE,FRQ,1000HZ,PERI,0.001S,AMP,4V,OFST,0V,PHSE,90"
    >>> wave = parse_wave(reply, 1)
    >>> wave.kind, wave.frequency, wave.amplitude, round(wave.phase, 4)
    ('SINE', 1000.0, 4.0, 1.5708)
    """
    pairs = _pairs(_body(line, f"C{channel}:BSWV"), line)
    if not pairs.get("WVTP"):
        raise BadReply(f"Expected a wave with WVTP, got {line[:80]!r}. Ask again.")
    phase = number(pairs["PHSE"], _DEGREES) if "PHSE" in pairs else None
    return Wave(
        pairs["WVTP"].upper(),
        frequency(pairs["FRQ"]) if "FRQ" in pairs else None,
        voltage(pairs["AMP"]) if "AMP" in pairs else None,
        voltage(pairs["OFST"]) if "OFST" in pairs else None,
        None if phase is None else math.radians(phase),
    )


def parse_output(line: bytes, channel: int) -> Output:
    """Output of a reply to ``Cn:OUTP?``.

    Examples
    --------
    >>> parse_output(b"C1:OUTP ON,LOAD,HZ,PLRT,NOR", 1)
    Output(on=True, load=inf, inverted=False)
    """
    state, *fields = _body(line, f"C{channel}:OUTP")
    pairs = _pairs(fields, line)
    load, polarity = pairs.get("LOAD", ""), pairs.get("PLRT", "NOR").upper()
    if state.upper() not in ("ON", "OFF") or polarity not in ("NOR", "INVT") or not load:
        raise BadReply(f"Expected ON|OFF,LOAD,...,PLRT,..., got {line[:80]!r}. Ask again.")
    ohm = math.inf if load.upper() == "HZ" else number(load, {"": 1.0, "OHM": 1.0})
    return Output(state.upper() == "ON", ohm, polarity == "INVT")


def parse_reference(line: bytes) -> str:
    """``INT`` or ``EXT`` of a reply to ``ROSC?``, whatever follows it."""
    source = _body(line, "ROSC")[0].upper()
    if source not in ("INT", "EXT"):
        raise BadReply(f"Expected ROSC INT or EXT, got {line[:80]!r}. Ask again.")
    return source


def parse_mode(line: bytes) -> bool:
    """Whether the channels are phase-locked, of a reply to ``MODE?``.

    Firmware versions spell it with or without hyphen.
    """
    mode = _body(line, "MODE")[0].upper().replace("-", "")
    if mode not in ("PHASELOCKED", "INDEPENDENT"):
        raise BadReply(f"Expected PHASE-LOCKED or INDEPENDENT, got {line[:80]!r}. Ask again.")
    return mode == "PHASELOCKED"


def parse_number(line: bytes) -> float:
    """Number of a reply that is nothing else, as of ``MEAS:POW?``; `BadReply` otherwise."""
    return number(text_from_line(line))


def parse_sensor(line: bytes) -> Sensor:
    """Sensor head of a reply to ``SYST:SENS:IDN?``.

    Examples
    --------
    >>> parse_sensor(b'S140C,1234,"01-Jan-2024",1,18,289').flags
    <SensorFlags.POWER|WAVELENGTH|TEMPERATURE: 289>
    """
    parts = [part.strip().strip('"') for part in text_from_line(line).split(",")]
    if len(parts) != 6 or not all(re.fullmatch("[0-9]{1,9}", part) for part in parts[3:]):
        raise BadReply(
            f"Expected NAME,SERIAL,CALIBRATION,TYPE,SUBTYPE,FLAGS, got {line[:80]!r}. Ask again."
        )
    kind, subtype, flags = (int(part) for part in parts[3:])
    return Sensor(parts[0], parts[1], parts[2], kind, subtype, SensorFlags(flags))


def parse_error(line: bytes) -> tuple[int, str]:
    """Code and text of a reply to ``SYST:ERR?``; code 0 is no error.

    Examples
    --------
    >>> parse_error(b'-113,"Undefined header"')
    (-113, 'Undefined header')
    """
    code, comma, text = text_from_line(line).partition(",")
    if not comma or not re.fullmatch("[+-]?[0-9]{1,6}", code):
        raise BadReply(f'Expected CODE,"TEXT", got {line[:80]!r}. Ask again.')
    return int(code), text.strip().strip('"')
