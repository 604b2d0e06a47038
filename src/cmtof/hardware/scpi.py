"""Drivers of SCPI instruments on PyVISA: clock Siglent SDG2042X, power meter Thorlabs PM100D.

Neither numbers its replies, and what the generator does not like it drops or clamps silently (SDG
Programming Guide; acceptance of an SDG2122X, firmware 2.01.01.39R7T2). So every setting is read
back, and after a lost answer ``*IDN?`` is asked until its reply comes.
"""

import re
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any, ClassVar

import pyvisa

from cmtof.hardware.device import (
    BadReply,
    ConnectionLost,
    Device,
    InstrumentTimeout,
    Refused,
    insist,
    number,
    one_error,
    question,
)
from cmtof.hardware.roles import Waiting
from cmtof.types import Texts


def open_visa(address: str, timeout: float = 1.0) -> Any:
    """Open a VISA resource, as ``TCPIP::192.168.1.20::5025::SOCKET``, or raise `ConnectionLost`."""
    with one_error(f"an instrument at {address}", ConnectionLost):
        resource: Any = pyvisa.ResourceManager("@py").open_resource(address)
        resource.read_termination = resource.write_termination = "\n"
        resource.timeout = 1e3 * timeout  # ms
        return resource


class ScpiInstrument(Device):
    """Instrument with text commands, on a resource of `open_visa` or alike (write, read, close)."""

    def _identity(self) -> Texts:
        return self._ask("*IDN?", identity_from_line)

    def _choose(self, command: str, value: str, *also: str) -> None:
        """Set a word and read it back; `Refused` unless it is the value or one of ``also``."""
        self._write(f"{command} {value}")
        found = self._ask(f"{command}?", str).strip()
        if found not in (value, *also):
            self._fail(Refused, f"set {command} to {value}", found, "Set it by hand.")

    def _write(self, command: str) -> None:
        with one_error(self.name):
            self._connection.write(command)

    def _set(self, command: str, value: float) -> None:
        """Set a number and read it back; `Refused` if it differs."""
        self._write(f"{command} {value:.9g}")
        self._expect(command, value, self._ask(f"{command}?"), 1e-3 * abs(value))

    @question
    def _ask(self, command: str, parse: Callable[[str], Any] = number) -> Any:
        """Answer to a command, parsed, by default as a number."""
        self._write(command)
        with one_error(self.name):
            return parse(self._connection.read())

    def _resynchronise(self) -> None:
        self._write("*IDN?")
        for _ in range(8):
            with suppress(BadReply), one_error(self.name):
                if self.MODELS[0] in self._connection.read():  # else it is an old reply
                    return
        self._fail(InstrumentTimeout, "identify itself", "other answers", "Restart it.")


def identity_from_line(line: str) -> Texts:
    """Maker, model, serial number and firmware of an answer to ``*IDN?``, by name."""
    fields = [field.strip() for field in line.removeprefix("*IDN ").split(",")]
    if len(fields) not in (4, 5):  # older Siglents add a header and a fifth field
        raise ValueError(line)
    return dict(
        zip(("maker", "model", "serial_number", "firmware"), fields, strict=False)
    )


class SignalGenerator(ScpiInstrument):
    """Siglent SDG2042X, to 40 MHz: the clock that both RF drivers multiply."""

    MODELS = ("SDG2",)
    LIMITS: ClassVar = {
        "channel": (1, 2),
        "frequency": (1e-6, 40e6),
        "amplitude": (2e-3, 10.0),
    }

    def reset(self) -> None:
        """Reset to the factory settings: no burst, sweep, modulation or coupling of channels."""
        self._write("*RST")
        usual = self._connection.timeout
        self._connection.timeout = 10_000  # ms, until it is done
        try:
            done = self._ask("*OPC?", lambda line: number(line.removeprefix("*OPC")))
        finally:
            self._connection.timeout = usual
        self._expect("reset", 1, done)
        self._write("ROSC INT")
        source = self._pairs("ROSC?").get("ROSC")
        self._expect("internal clock source", True, source == "INT")
        for channel in (1, 2):
            for kind in ("BTWV", "SWWV", "MDWV"):
                state = self._pairs(f"C{channel}:{kind}?").get("STATE")
                self._expect(f"{kind} of channel {channel}", False, state != "OFF")

    def sine(self, channel: int, *, frequency: float, amplitude: float) -> None:
        """Set a sine: frequency, Hz, and amplitude, V peak to peak into 50 Ohm; read it back."""
        self._within(channel=channel, frequency=frequency, amplitude=amplitude)
        self._write(f"C{channel}:OUTP LOAD,50")
        self._write(
            f"C{channel}:BSWV WVTP,SINE,FRQ,{frequency:.10g},AMP,{amplitude:.6g},OFST,0,PHSE,0"
        )
        found = self._pairs(f"C{channel}:OUTP?") | self._pairs(f"C{channel}:BSWV?")
        self._expect("sine", True, found.get("WVTP") == "SINE")
        settings = {
            "LOAD": 50.0,
            "FRQ": frequency,
            "AMP": amplitude,
            "OFST": 0.0,
            "PHSE": 0.0,
        }
        for key, wanted in settings.items():
            self._expect(key, wanted, number(found.get(key, "")), 1e-3 + 1e-9 * wanted)

    def output(self, channel: int, on: bool) -> None:
        """Switch a channel's output, and read it back."""
        self._write(f"C{channel}:OUTP {'ON' if on else 'OFF'}")
        self._expect(f"output {channel}", on, self.output_is_on(channel))

    def output_is_on(self, channel: int) -> bool:
        """Whether a channel puts out its sine."""
        return self._pairs(f"C{channel}:OUTP?").get(f"C{channel}:OUTP") == "ON"

    def lock_phases(self) -> None:
        """Lock and align both channels; firmware takes one of two spellings and drops the other."""
        self._write("MODE PHASE-LOCKED")
        self._write("MODE PHASELOCKED")
        self._expect("phase lock", True, "LOCKED" in self._ask("MODE?", str))
        self._write("EQPHASE")

    def safe_state(self) -> None:
        """Switch both outputs off; the second even if the first does not follow."""
        insist(*(partial(self.output, channel, False) for channel in (1, 2)))

    def _pairs(self, command: str) -> Texts:
        """Keys and values of an answer such as ``C1:OUTP ON,LOAD,50,PLRT,NOR``."""

        def parse(line: str) -> Texts:
            words = re.split("[ ,]", line.strip())
            if f"{words[0]}?" != command:
                raise ValueError(line)
            # the answer of OUTP begins with a value, that of BSWV does not
            first = len(words) % 2
            return dict(zip(words[first::2], words[first + 1 :: 2], strict=True))

        return self._ask(command, parse)


POWER_HEAD = 1  # flag of a head that measures power


class PowerMeter(ScpiInstrument):
    """Thorlabs PM100D with an integrating sphere S140C: laser power behind the emission module."""

    MODELS = ("PM100",)
    LIMITS: ClassVar = {"wavelength": (350e-9, 1100e-9), "readings": (1, 10000)}

    def _identity(self) -> Texts:
        self._choose("SENS:POW:UNIT", "W")  # it may have been left in dBm
        head = self._ask(
            "SYST:SENS:IDN?", lambda line: line.replace('"', "").split(",")
        )
        if not int(number(head[-1])) & POWER_HEAD:
            self._fail(Refused, "have a head for power", head[0], "Plug it in.")
        return super()._identity() | {"head": head[0], "head_serial_number": head[1]}

    @property
    def power(self) -> float:
        """Power, W; overload of the head raises `BadReply`."""
        return self._ask("MEAS:POW?")

    def set_up(
        self, *, wavelength: float, readings: int, waiting: Waiting = None
    ) -> None:
        """Correct for a wavelength, m, average readings of 3 ms each, and zero the dark head."""
        self._within(wavelength=wavelength, readings=readings)
        self._choose("SENS:POW:RANG:AUTO", "1", "ON")
        self._set("SENS:CORR:WAV", 1e9 * wavelength)
        self._set("SENS:AVER:COUN", readings)
        self._write("SENS:CORR:COLL:ZERO:INIT")  # the PM400's: not verified on a PM100D
        deadline = time.monotonic() + 30.0
        while self._ask("SENS:CORR:COLL:ZERO:STAT?"):
            if time.monotonic() >= deadline:
                self._fail(InstrumentTimeout, "be zeroed", "no end", "Cover the head.")
            if waiting:
                waiting()
            time.sleep(0.05)
