"""RF driver of one modulator, over lines of text on a serial port (pyserial).

Request ``>SEQ WORD arg...*CCCC``, reply ``<SEQ OK value...*CCCC`` or ``<SEQ ERR CODE text*CCCC``,
unasked ``!WORD arg...*CCCC``; every line ends in a newline. SEQ is 0 to 99; CCCC is the
CRC-16/CCITT-FALSE, in upper-case hexadecimal, of what stands before the asterisk. The words are
listed in the book's hardware guide. The driver's own safety stands in its firmware: a dead man's
timer turns RF off when the host falls silent, and loss of lock does the same.
"""

import time
from binascii import crc_hqx
from collections.abc import Callable, Sequence
from math import pi
from numbers import Integral
from typing import Any, TypeVar

from cmtof.hardware.device import (
    BadReply,
    ConnectionLost,
    Device,
    InstrumentTimeout,
    Refused,
    Unsafe,
    insist,
    number,
)
from cmtof.instrument.devices import Lock, Status

T = TypeVar("T")
CODES = 65536
"""Phase codes of one turn of the drive."""
TABLE_SIZE = 64
"""Entries of the phase table at most."""
_UNSAFE = ("TRIPPED", "LOCK", "UNLOCKED", "INTERLOCK")


def open_serial(address: str, *, rtscts: bool = False) -> Any:
    """Open a serial port of pyserial, a path or URL, at 115200 baud with 1 s to answer.

    Raises
    ------
    ConnectionLost
        If there is no such port.
    """
    import serial

    try:
        return serial.serial_for_url(
            address, baudrate=115200, timeout=1.0, write_timeout=1.0, rtscts=rtscts
        )
    except (OSError, ValueError) as error:
        raise ConnectionLost(
            f"Expected a serial port at {address}, got {error}. Check address and cable."
        ) from None


def port_errors(name: str, act: Callable[[], T]) -> T:
    """Do something with a serial port; errors of pyserial become ours."""
    import serial

    try:
        return act()
    except (BadReply, InstrumentTimeout):
        raise
    except serial.SerialTimeoutException:
        raise InstrumentTimeout(
            f"Expected {name} to take bytes, got none taken. Check it."
        ) from None
    except OSError as error:
        raise ConnectionLost(
            f"Expected {name} to be there, got {error}. Check the cable."
        ) from None


def framed(text: str) -> bytes:
    """Line with checksum and newline.

    Examples
    --------
    >>> framed(">7 PING")
    b'>7 PING*9555\\n'
    """
    body = text.encode("ascii")
    return b"%s*%04X\n" % (body, crc_hqx(body, 0xFFFF))


def code_from_phase(phase: float) -> int:
    """Phase code 0 to 65535 of a drive phase, rad; wraps."""
    return round(phase / (2 * pi) * CODES) % CODES


class RfDriver(Device):
    """An RF driver; ``trip`` is the reason that it last gave unasked for switching RF off."""

    MODEL = "CMTOF-RF"

    def __init__(self, port: Any, name: str) -> None:
        super().__init__(name)
        self._port = port
        self._sequence = -1
        self._guarded = False
        self.trip = ""

    def close(self) -> None:
        """Close the port."""
        self._port.close()

    def identify(self) -> dict[str, str]:
        """Model, serial number and firmware; `Refused` if it is another device."""
        parts = " ".join(self._question("ID?")).split(",")
        if len(parts) != 3 or parts[0] != self.MODEL:
            raise Refused(
                f"Expected a {self.MODEL} at {self.name}, got {','.join(parts)[:60]}. "
                "Check the address."
            )
        return dict(zip(("model", "serial_number", "firmware"), parts, strict=True))

    def set_frequency(self, hz: float) -> None:
        """Set the frequency of the drive, whole Hz."""
        self._set("FREQ", round(hz), 0.5)

    def set_power(self, dbm: float) -> None:
        """Set the power, dBm."""
        self._set("POWR", float(dbm), 0.051)

    def set_phase(self, rad: float) -> float:
        """Set the phase of the drive outside the table; return what was set, rad in [0, 2 pi)."""
        code = code_from_phase(rad)
        self._set("PHAS", code, 0.0)
        return 2 * pi * code / CODES

    def set_dead_man(self, seconds: float) -> None:
        """Have RF turned off when no request comes for so long, 0.1 to 60 s."""
        self._set("DEAD", float(seconds), 1e-3)
        self._guarded = True

    def output(self, on: bool, *, lock_timeout: float = 10.0) -> None:
        """Switch RF; when switching on, wait for the lock.

        Raises
        ------
        Unsafe
            If no dead man's time was set, or no lock is found: then RF is off again.
        """
        if on and not self._guarded:
            raise Unsafe(
                f"Expected a dead man's time in {self.name} before RF is switched on, got none. "
                "Call set_dead_man first."
            )
        self._switch("RF", on)
        if not on:
            return
        deadline = time.monotonic() + lock_timeout
        try:
            while not (lock := self.lock()).locked:
                if self.trip or time.monotonic() >= deadline:
                    raise Unsafe(
                        f"Expected {self.name} to lock within {lock_timeout:g} s, got "
                        f"{self.trip or 'no lock'} ({lock.detuning:g} Hz off). "
                        "Check frequency and cable."
                    )
                time.sleep(0.02)
        except OSError:
            self.safe_state()
            raise

    def lock(self) -> Lock:
        """State of the frequency lock."""
        locked, detuning, reflected = self._question("LOCK?", 3)
        return Lock(_truth(locked), number(detuning), number(reflected))

    def status(self) -> Status:
        """Output, lock, table and trip in one answer."""
        on, locked, index, edges, tripped = self._question("STAT?", 5)
        places = int(number(index)), int(number(edges))
        return Status(_truth(on), _truth(locked), *places, _truth(tripped))

    def clear_trip(self) -> None:
        """Allow RF again after a trip; it stays off until `output`."""
        self._ask("CLR")
        self.trip = ""

    def ping(self) -> None:
        """Feed the dead man's timer; `Unsafe` if the driver reported a trip since."""
        self._question("PING")
        if self.trip:
            raise Unsafe(
                f"Expected {self.name} to keep RF on, got a trip ({self.trip}). Find the cause."
            )

    def load_table(self, phases: Sequence[float]) -> None:
        """Load 1 to 64 phases of the drive, rad, that the trigger steps through; checked."""
        if not 1 <= len(phases) <= TABLE_SIZE:
            raise ValueError(f"Expected 1 to 64 phases, got {len(phases)}. Send fewer.")
        codes = [code_from_phase(phase) for phase in phases]
        self._ask("TABL", len(codes), *codes)
        count, check = self._question("TABL?", 2)
        wanted = crc_hqx(b"".join(code.to_bytes(2, "big") for code in codes), 0xFFFF)
        if (count, check.upper()) != (str(len(codes)), f"{wanted:04X}"):
            raise Refused(
                f"Expected {self.name} to hold the table of {len(codes)} phases, got another. "
                "Load it again."
            )

    def trigger(self, on: bool) -> None:
        """Let rising edges at the trigger input step the table, or not."""
        self._switch("TRIG", on)

    def arm(self) -> None:
        """Count no edges yet; the first edge plays entry 0."""
        self._ask("ARM")

    def safe_state(self) -> None:
        """Turn RF and trigger off, up to three times: the one request that is sent again."""
        insist(lambda: self._ask("SAFE"), 3)
        if self.status().on:
            raise Unsafe(f"Expected RF off at {self.name}, got on. Switch it off by hand.")

    # --- dialogue ------------------------------------------------------------------------------

    def _set(self, word: str, value: float, tolerance: float) -> None:
        (found,) = self._counted(self._ask(word, value), word, 1)
        self._expect(word, value, number(found), tolerance)

    def _switch(self, word: str, on: bool) -> None:
        (found,) = self._counted(self._ask(word, "ON" if on else "OFF"), word, 1)
        if _truth(found) != on:
            raise Refused(f"Expected {self.name} to switch {word}, got {found}. Check its status.")

    def _question(self, word: str, count: int | None = None) -> list[str]:
        """Values of an answer; asked once more after a lost or garbled one."""
        return self._read(lambda: self._counted(self._ask(word), word, count))

    def _counted(self, values: list[str], word: str, count: int | None) -> list[str]:
        if count is not None and len(values) != count:
            raise BadReply(
                f"Expected {count} values of {word} from {self.name}, got {len(values)}. "
                "Check its firmware."
            )
        return values

    def _ask(self, word: str, *arguments: float | str) -> list[str]:
        """Values of the answer to one request; answers to earlier ones are passed over."""
        self._sequence = (self._sequence + 1) % 100
        text = " ".join([f">{self._sequence}", word, *map(_text, arguments)])
        port_errors(self.name, lambda: self._port.write(framed(text)))
        for _ in range(100):
            head, *words = self._line()
            if head.startswith("!"):
                if head == "!TRIP":
                    self.trip = " ".join(words) or "unnamed"
            elif head == "<??" or words[:1] not in (["OK"], ["ERR"]):
                raise BadReply(f"Expected the request to arrive whole, got {head}. Ask again.")
            elif head == f"<{self._sequence}":
                return self._obeyed(words)
        raise BadReply(f"Expected an answer of {self.name}, got other lines. Ask again.")

    def _obeyed(self, words: list[str]) -> list[str]:
        if words[0] == "OK":
            return words[1:]
        kind = Unsafe if words[1:] and words[1] in _UNSAFE else Refused
        raise kind(
            f"Expected {self.name} to obey, got {' '.join(words)}. Check its state and limits."
        )

    def _line(self) -> list[str]:
        """Words of the next line whose checksum is right."""
        line = port_errors(self.name, lambda: self._port.read_until(b"\n", 1024))
        if not line.endswith(b"\n"):
            raise InstrumentTimeout(
                f"Expected a line of {self.name} in time, got {line[:40]!r}. Check power and cable."
            )
        body, _, check = line.strip().rpartition(b"*")
        if check != b"%04X" % crc_hqx(body, 0xFFFF) or not body.isascii():
            raise BadReply(f"Expected a line with its checksum, got {line[:40]!r}. Ask again.")
        return body.decode("ascii").split()

    def _resynchronise(self) -> None:
        port_errors(self.name, self._port.reset_input_buffer)


def _text(argument: float | str) -> str:
    """Argument that reads back the same; a float of NumPy would print its type."""
    if isinstance(argument, str):
        return argument
    return str(int(argument)) if isinstance(argument, Integral) else repr(float(argument))


def _truth(word: str) -> bool:
    """Truth of ON, OFF, 1 or 0."""
    if word not in ("ON", "OFF", "1", "0"):
        raise BadReply(f"Expected ON, OFF, 1 or 0, got {word!r}. Ask again.")
    return word in ("ON", "1")
