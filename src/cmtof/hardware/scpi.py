"""SCPI instruments on pyvisa: the clock Siglent SDG2042X and the power meter Thorlabs PM100D.

Neither numbers its replies nor has an error queue that helps: what the generator does not like it
drops or clamps silently (SDG Programming Guide; acceptance of an SDG2122X, firmware
2.01.01.39R7T2). So every setting is read back, and after a lost answer ``*IDN?`` is asked until its
reply comes.
"""

import math
import time
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

from cmtof.hardware.device import (
    BadReply,
    ConnectionLost,
    Device,
    InstrumentTimeout,
    Refused,
    insist_on_all,
    number,
)

T = TypeVar("T")


def open_visa(address: str, library: str = "@py") -> Any:
    """Open a VISA resource, as ``TCPIP::192.168.1.20::5025::SOCKET``, with lines and 1 s to answer.

    Raises
    ------
    ConnectionLost
        If nothing answers there.
    """
    import pyvisa

    try:
        resource: Any = pyvisa.ResourceManager(library).open_resource(address)
        resource.read_termination = resource.write_termination = "\n"
        resource.timeout = 1000
    except (pyvisa.Error, OSError, ValueError) as error:
        raise ConnectionLost(
            f"Expected an instrument at {address}, got {error}. Check address and cable."
        ) from None
    return resource


class ScpiInstrument(Device):
    """Text commands to a VISA resource.

    Parameters
    ----------
    resource
        From `open_visa`, or anything with its ``write``, ``read``, ``close`` and ``timeout``.
    name : str
    """

    MAKER, MODEL = "", ""

    def __init__(self, resource: Any, name: str) -> None:
        super().__init__(name)
        self._resource = resource

    def close(self) -> None:
        """Close the resource."""
        self._resource.close()

    def identify(self) -> dict[str, str]:
        """Maker, model, serial number and firmware; `Refused` if it is another device."""
        words = ("maker", "model", "serial_number", "firmware")
        found = self._ask("*IDN?", lambda line: dict(zip(words, line.split(","), strict=True)))
        same = self.MAKER in found["maker"].lower() and found["model"].startswith(self.MODEL)
        if not same:
            raise Refused(
                f"Expected a {self.MAKER} {self.MODEL} at {self.name}, got {found['maker']} "
                f"{found['model']}. Check the address."
            )
        return found

    def _write(self, command: str) -> None:
        self._talk(lambda: self._resource.write(command))

    def _ask(self, question: str, parse: Callable[[str], T]) -> T:
        """Parsed answer; asked once more after a lost or garbled one."""

        def ask() -> T:
            self._write(question)
            line = self._talk(self._resource.read)
            try:
                return parse(line)
            except (ValueError, KeyError):
                raise BadReply(
                    f"Expected an answer to {question} of {self.name}, got {line[:60]!r}. "
                    "Ask again."
                ) from None

        return self._read(ask)

    def _talk(self, act: Callable[[], T]) -> T:
        """Do something with the resource; errors of pyvisa become ours."""
        from pyvisa import VisaIOError
        from pyvisa.constants import StatusCode

        try:
            return act()
        except VisaIOError as error:
            if error.error_code == StatusCode.error_timeout:
                raise InstrumentTimeout(
                    f"Expected an answer of {self.name} in time, got none. Check it, try again."
                ) from None
            raise ConnectionLost(
                f"Expected {self.name} to be there, got {error.abbreviation}. Check the cable."
            ) from None
        except UnicodeDecodeError:
            raise BadReply(f"Expected ASCII of {self.name}, got other bytes. Ask again.") from None
        except OSError as error:
            if isinstance(error, (BadReply, InstrumentTimeout)):
                raise
            raise ConnectionLost(
                f"Expected {self.name} to be there, got {error}. Check the cable."
            ) from None

    def _resynchronise(self) -> None:
        self._write("*IDN?")
        for _ in range(8):
            try:
                if self.MAKER in self._talk(self._resource.read).lower():
                    return
            except BadReply:  # still an old reply
                continue
        raise InstrumentTimeout(f"Expected {self.name} to identify itself, got none. Restart it.")


class SignalGenerator(ScpiInstrument):
    """Siglent SDG2042X, to 40 MHz: the clock that both RF drivers multiply."""

    MAKER, MODEL = "siglent", "SDG2"
    CHANNELS = (1, 2)

    def sine(self, channel: int, *, frequency: float, amplitude: float, load: float = 50.0) -> None:
        """Set a sine, Hz and V peak to peak into a load, Ohm, which the amplitude depends on."""
        if channel not in self.CHANNELS:
            raise ValueError(f"Expected channel 1 or 2, got {channel}. Choose one.")
        self._write(f"C{channel}:OUTP LOAD,{load:.10g}")
        self._expect("load", load, number(self._pairs(channel, "OUTP")["LOAD"]), 0.5)
        wave = f"FRQ,{frequency:.10g},AMP,{amplitude:.6g},OFST,0,PHSE,0"
        self._write(f"C{channel}:BSWV WVTP,SINE,{wave}")
        found = self._pairs(channel, "BSWV")
        if found.get("WVTP") != "SINE":
            raise Refused(f"Expected {self.name} to make a sine, got another wave. Set it by hand.")
        for what, key, wanted, tolerance in (
            ("frequency", "FRQ", frequency, 1e-6 + 1e-9 * frequency),
            ("amplitude", "AMP", amplitude, 1e-3 + 1e-3 * amplitude),
            ("offset", "OFST", 0.0, 1e-3),
            ("phase", "PHSE", 0.0, 0.06),
        ):
            self._expect(what, wanted, number(found.get(key, "none")), tolerance)

    def output(self, channel: int, on: bool) -> None:
        """Switch a channel's output, and check it."""
        wanted = "ON" if on else "OFF"
        self._write(f"C{channel}:OUTP {wanted}")
        if wanted not in self._pairs(channel, "OUTP"):
            raise Refused(
                f"Expected output {channel} of {self.name} {wanted}, got the contrary. "
                "Look for an overload."
            )

    def lock_phases(self) -> None:
        """Lock and align both channels; firmware knows one of two spellings, so both are tried."""
        for spelling in ("PHASE-LOCKED", "PHASELOCKED"):
            self._write(f"MODE {spelling}")
            mode = self._ask("MODE?", lambda line: line.split()[1])
            if mode.replace("-", "") == "PHASELOCKED":
                self._write("EQPHASE")
                return
        raise Refused(
            f"Expected {self.name} to lock its channels, got INDEPENDENT with both spellings. "
            "Set it at the front panel."
        )

    def safe_state(self) -> None:
        """Switch both outputs off; the second even if the first does not follow."""
        insist_on_all([partial(self.output, channel, False) for channel in self.CHANNELS])

    def _pairs(self, channel: int, what: str) -> dict[str, str]:
        """Keys and values of a reply such as ``C1:OUTP ON,LOAD,50,PLRT,NOR``; a flag has none."""

        def parse(line: str) -> dict[str, str]:
            head, _, rest = line.strip().partition(" ")
            if head != f"C{channel}:{what}":
                raise ValueError
            words = rest.split(",")
            flag = {words.pop(0): ""} if len(words) % 2 else {}
            return flag | dict(zip(words[::2], words[1::2], strict=True))

        return self._ask(f"C{channel}:{what}?", parse)


class PowerMeter(ScpiInstrument):
    """Thorlabs PM100D with an integrating sphere S140C: laser power behind the emission module.

    The zeroing commands stand in the PM400's manual only; on a PM100D they are not verified.
    """

    MAKER, MODEL = "thorlabs", "PM100"

    def identify(self) -> dict[str, str]:
        """Identity and head; `Refused` for another device, or a head without power."""
        found = super().identify()
        sensor = self._ask("SYST:SENS:IDN?", lambda line: line.split(","))
        if len(sensor) < 6 or not int(number(sensor[-1])) & 1:
            raise Refused(
                f"Expected a head that measures power at {self.name}, got {sensor[0]}. "
                "Plug in the S140C."
            )
        return found | {"sensor": sensor[0].strip('"'), "sensor_serial_number": sensor[1]}

    @property
    def wavelength(self) -> float:
        """Wavelength that the head is corrected for, m."""
        return 1e-9 * self._ask("SENS:CORR:WAV?", number)

    @wavelength.setter
    def wavelength(self, metres: float) -> None:
        low, high = (self._ask(f"SENS:CORR:WAV? {end}", number) for end in ("MIN", "MAX"))
        if not low <= 1e9 * metres <= high:
            raise ValueError(
                f"Expected {low:g} to {high:g} nm for the head of {self.name}, got "
                f"{1e9 * metres:g}. Choose another wavelength or head."
            )
        self._write(f"SENS:CORR:WAV {1e9 * metres:.6g}")
        self._expect("wavelength", metres, self.wavelength, 0.5e-9)

    @property
    def averaging(self) -> int:
        """Readings of 3 ms each that a value is the mean of."""
        return int(self._ask("SENS:AVER:COUN?", number))

    @averaging.setter
    def averaging(self, count: int) -> None:
        self._write(f"SENS:AVER:COUN {count}")
        self._expect("averaging", count, self.averaging)

    @property
    def power(self) -> float:
        """Power, W; overload of the head raises `BadReply`."""
        return self._ask("MEAS:POW?", number)

    def zero(self, timeout: float = 30.0) -> None:
        """Take what the covered head sees now as dark."""
        self._write("SENS:CORR:COLL:ZERO:INIT")
        deadline = time.monotonic() + timeout
        while self._ask("SENS:CORR:COLL:ZERO:STAT?", number):
            if time.monotonic() >= deadline:
                raise InstrumentTimeout(
                    f"Expected {self.name} to be zeroed within {timeout:g} s, got no end. "
                    "Cover the head and try again."
                )
            time.sleep(0.05)
        if not math.isfinite(self._ask("SENS:CORR:COLL:ZERO:MAGN?", number)):
            raise BadReply(f"Expected a zero of {self.name}, got none. Zero it again.")
