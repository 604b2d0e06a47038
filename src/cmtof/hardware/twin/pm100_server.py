"""A simulated Thorlabs PM100D with an S140C integrating sphere: SCPI with an error queue.

Facts: PM100D manual, SCPI commands; the sensor's limits from the S140C data sheet (350-1100 nm,
1 uW-500 mW). Headers may be written long or short (SENSe:CORRection:WAVelength), in any case.
A reading takes ``averaging`` samples of about 3 ms on the virtual clock.
"""

import re
from collections import deque
from collections.abc import Callable
from typing import Any

from cmtof.hardware.twin.faults import Watch
from cmtof.hardware.twin.lines import Channel
from cmtof.hardware.twin.text import number_from_text, serve_lines
from cmtof.instrument.panel import Panel

WAVELENGTH = (350.0, 1100.0)
"""Wavelengths of the S140C, nm."""
AVERAGING = (1, 10_000)
"""Samples that a reading may average; the upper limit is not verified."""
SAMPLE_TIME = 3e-3
"""Time of one sample, s."""
RANGES = (500e-3, 50e-3, 5e-3, 500e-6, 50e-6)
"""Upper ends of the ranges, W; not verified."""
DARK_OFFSET = 3e-9
"""What the sensor reports in the dark until it is zeroed, W: a few of its steps of 1 nW."""
_QUEUE = 30
_NO_ERROR = (0, "No error")
_MNEMONICS = (
    "SYSTem SENSor SENSe CORRection WAVelength AVERage COUNt POWer RANGe AUTO UPPer UNIT COLLect "
    "ZERO INITiate ABORt STATe MAGNitude MEASure CONFigure READ FETCh ERRor NEXT IDN DC SCALar"
)
_SHORT = {
    form: short
    for word in _MNEMONICS.split()
    for short in ["".join(c for c in word if c.isupper())]
    for form in (short, word.upper())
}
_IGNORED = ("DC", "SCAL", "NEXT")  # mnemonics that a header may leave out


class _ScpiError(Exception):
    """An entry for the error queue: number and text."""


class PowerMeterServer:
    """One power meter.

    Parameters
    ----------
    panel : Panel
    world : World
        Asked for the power at the sensor.
    watch : Watch
        Faults of this device.
    """

    def __init__(self, panel: Panel, world: Any, watch: Watch) -> None:
        self._panel, self._world, self._watch = panel, world, watch
        self._errors: deque[tuple[int, str]] = deque(maxlen=_QUEUE)
        self._commands: dict[str, Callable[[str], str | None]] = {
            "*IDN?": lambda a: "THORLABS,PM100D,P0TWIN001,2.7.0",
            "*RST": self._reset,
            "*CLS": self._clear,
            "*OPC?": lambda a: "1",
            "SYST:ERR?": self._next_error,
            # flags: power 1, response settable 16, wavelength settable 32
            "SYST:SENS:IDN?": lambda a: "S140C,TWIN001,01-Jan-2024,1,7,49",
            "SENS:CORR:WAV": self._set_wavelength,
            "SENS:CORR:WAV?": lambda a: _limit(a, self._wavelength, *WAVELENGTH),
            "SENS:AVER": self._set_averaging,
            "SENS:AVER?": lambda a: str(self._averaging),
            "SENS:POW:RANG:AUTO": self._set_auto,
            "SENS:POW:RANG:AUTO?": lambda a: str(int(self._auto)),
            "SENS:POW:RANG": self._set_range,
            "SENS:POW:RANG?": lambda a: f"{self._range:.6E}",
            "SENS:POW:UNIT": self._set_unit,
            "SENS:POW:UNIT?": lambda a: "W",
            "SENS:CORR:COLL:ZERO": self._zero,
            "SENS:CORR:COLL:ZERO:ABOR": lambda a: None,
            "SENS:CORR:COLL:ZERO:STAT?": lambda a: "0",  # zeroing is over when it is asked
            "SENS:CORR:COLL:ZERO:MAGN?": lambda a: f"{self._magnitude:.6E}",
            "CONF:POW": lambda a: None,
            "INIT": lambda a: None,
            "MEAS:POW?": self._measure,
            "READ?": self._measure,
            "FETC?": self._measure,
        }
        # SENS may be left out (square brackets in the manual)
        for header, command in list(self._commands.items()):
            self._commands.setdefault(header.removeprefix("SENS:"), command)
        self._reset("")

    def _reset(self, argument: str) -> None:
        self._wavelength, self._averaging = 635.0, 1
        self._auto, self._range = True, RANGES[0]
        self._magnitude = 0.0

    def serve(self, channel: Channel) -> None:
        """Talk to one client until it has gone."""
        serve_lines(channel, self._answer)

    def _answer(self, line: str, channel: Channel) -> None:
        trouble = self._watch.next()
        reply = b""
        if not trouble.unheard:
            with self._panel.lock:
                replies = [self._obey(one) for one in line.split(";") if one.strip()]
            values = [one for one in replies if one is not None]
            reply = (";".join(values) + "\n").encode() if values else b""
        trouble.deliver(channel, reply)

    def _obey(self, text: str) -> str | None:
        head, _, argument = text.strip().partition(" ")
        try:
            command = self._commands.get(_header(head))
            if command is None:
                raise _ScpiError(-113, "Undefined header")
            return command(argument.strip().upper())
        except _ScpiError as error:
            self._errors.append((error.args[0], error.args[1]))
            return None

    def _next_error(self, argument: str) -> str:
        number, text = self._errors.popleft() if self._errors else _NO_ERROR
        return f'{number:+d},"{text}"'

    def _clear(self, argument: str) -> None:
        self._errors.clear()

    def _set_wavelength(self, argument: str) -> None:
        value = _named(argument, *WAVELENGTH)
        if not self._watch.takes("ignore"):
            self._wavelength = self._watch.pulled(value, *WAVELENGTH)

    def _set_averaging(self, argument: str) -> None:
        value = _named(argument, *AVERAGING)
        if not self._watch.takes("ignore"):
            self._averaging = round(self._watch.pulled(value, *AVERAGING))

    def _set_auto(self, argument: str) -> None:
        if argument not in ("ON", "OFF", "1", "0"):
            raise _ScpiError(-104, "Data type error")
        if not self._watch.takes("ignore"):
            self._auto = argument in ("ON", "1")

    def _set_range(self, argument: str) -> None:
        """The smallest range that holds the value; automatic ranging ends."""
        value = _named(argument, RANGES[-1], RANGES[0])
        if not self._watch.takes("ignore"):
            self._auto, self._range = False, min(one for one in RANGES if one >= value)

    def _set_unit(self, argument: str) -> None:
        if argument != "W":
            raise _ScpiError(-224, "Illegal parameter value")

    def _zero(self, argument: str) -> None:
        """Take what comes now for darkness, light or not."""
        if not self._watch.takes("ignore"):
            self._magnitude = self._world.laser_power(self._panel) + DARK_OFFSET

    def _measure(self, argument: str) -> str:
        power = self._world.laser_power(self._panel) + DARK_OFFSET
        self._panel.time += self._averaging * SAMPLE_TIME
        most = RANGES[0] if self._auto else self._range
        if power > 1.1 * most:
            return "9.900000E+37"  # SCPI's infinity stands for an overload
        return f"{power - self._magnitude:.6E}"


def _header(text: str) -> str:
    """Header in short mnemonics; text that is none comes back as it is.

    Examples
    --------
    >>> _header("sense:correction:wavelength?"), _header("SENS1:AVER:COUN"), _header("meas:power?")
    ('SENS:CORR:WAV?', 'SENS:AVER', 'MEAS:POW?')
    >>> _header(":SENS:CORR:COLL:ZERO:INIT"), _header("POWER?"), _header("wave?")
    ('SENS:CORR:COLL:ZERO', 'POW?', 'WAVE?')
    """
    text = text.upper()
    query = "?" if text.endswith("?") else ""
    words = text.removesuffix("?").removeprefix(":").split(":")
    short = [_SHORT.get(re.sub(r"(?<=[A-Z])1$", "", word), word) for word in words]
    short = [word for word in short if word not in _IGNORED]
    for ending in (["AVER", "COUN"], ["ZERO", "INIT"], ["RANG", "UPP"]):
        if short[-2:] == ending:
            short = short[:-1]
    return ":".join(short) + query


def _named(argument: str, low: float, high: float) -> float:
    """Number within the limits, or MIN or MAX."""
    if not argument:
        raise _ScpiError(-109, "Missing parameter")
    value = {"MIN": low, "MINIMUM": low, "MAX": high, "MAXIMUM": high}.get(argument)
    if value is None:
        value = number_from_text(argument)
    if value is None:
        raise _ScpiError(-104, "Data type error")
    if not low <= value <= high:
        raise _ScpiError(-222, "Data out of range")
    return value


def _limit(argument: str, value: float, low: float, high: float) -> str:
    """Value, or the limit that is asked for."""
    limits = {"": value, "MIN": low, "MINIMUM": low, "MAX": high, "MAXIMUM": high}
    if argument not in limits:
        raise _ScpiError(-104, "Data type error")
    return f"{limits[argument]:.6E}"
