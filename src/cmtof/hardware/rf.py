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
from typing import Any, ClassVar

import serial

from cmtof.hardware import device
from cmtof.hardware.device import number, one_error
from cmtof.instrument.devices import Status

CODES = 65536
"""Phase codes of one turn of the drive."""
_UNSAFE = {"TRIPPED", "LOCK", "UNLOCKED", "INTERLOCK"}
_truth = {"ON": True, "1": True, "OFF": False, "0": False}.__getitem__


def open_serial(address: str, *, rtscts: bool = False) -> Any:
    """Open a serial port, a path or URL, at 115200 baud, or raise `ConnectionLost`."""
    with one_error(f"a serial port at {address}", device.ConnectionLost):
        return serial.serial_for_url(
            address, baudrate=115200, timeout=1.0, write_timeout=1.0, rtscts=rtscts
        )


def framed(text: str) -> bytes:
    """Line with checksum and newline."""
    body = text.encode("ascii")
    return b"%s*%04X\n" % (body, crc_hqx(body, 0xFFFF))


def code_from_phase(phase: float) -> int:
    """Phase code 0 to 65535 of a drive phase, rad; wraps."""
    return round(phase / (2 * pi) * CODES) % CODES


class RfDriver(device.Device):
    """An RF driver; it sends unasked why it switched RF off by itself, a trip."""

    MODELS = ("CMTOF-RF",)
    LIMITS: ClassVar = {
        "FREQ": (7.14e9, 7.17e9),
        "POWR": (-30.0, 35.0),
        "PHAS": (0, CODES - 1),
        "DEAD": (0.1, 60.0),
        "TABL": (1, 64),
    }
    _trip, _sequence, _guarded = "", -1, False

    def set_frequency(self, hz: float) -> None:
        """Set the frequency of the drive, whole Hz."""
        self._set("FREQ", round(hz), 0.5)

    def set_power(self, dbm: float) -> None:
        """Set the power, dBm."""
        self._set("POWR", dbm, 0.051)

    def set_phase(self, rad: float) -> float:
        """Set the phase of the drive outside the table; return what was set, rad in [0, 2 pi)."""
        code = code_from_phase(rad)
        self._set("PHAS", code)
        return 2 * pi * code / CODES

    def set_dead_man(self, seconds: float) -> None:
        """Have RF turned off when no request comes for so long."""
        self._set("DEAD", seconds, 1e-3)
        self._guarded = True

    def output(self, on: bool, *, lock_timeout: float = 10.0) -> None:
        """Switch RF; on needs a dead man's time, and a lock in time, or RF is off again."""
        if on and not self._guarded:
            self._fail(device.Unsafe, "have a dead man's time", "none", "Call set_dead_man first.")
        self._set("RF", on)
        deadline = time.monotonic() + lock_timeout
        try:
            while on:
                locked, detuning, _ = self._question("LOCK?", _truth, number, number)
                if locked:
                    return
                if self._trip or time.monotonic() >= deadline:
                    got = f"{self._trip or 'no lock'} ({detuning:g} Hz off)"
                    wish = f"lock within {lock_timeout:g} s"
                    self._fail(device.Unsafe, wish, got, "Check frequency and cable.")
                time.sleep(0.02)
        except OSError:
            self.safe_state()
            raise

    def status(self) -> Status:
        """Output, lock, table and trip in one answer."""
        return Status(*self._question("STAT?", _truth, _truth, int, int, _truth))

    def clear_trip(self) -> None:
        """Allow RF again after a trip; it stays off until `output`."""
        self._ask("CLR")
        self._trip = ""

    def ping(self) -> None:
        """Feed the dead man's timer; `Unsafe` if the driver reported a trip since."""
        self._question("PING")
        if self._trip:
            self._fail(device.Unsafe, "keep RF on", f"a trip ({self._trip})", "Find the cause.")

    def load_table(self, phases: Sequence[float]) -> None:
        """Load phases of the drive, rad, that the trigger steps through; checked."""
        codes = [code_from_phase(phase) for phase in phases]
        self._within(TABL=len(codes))
        check = crc_hqx(b"".join(code.to_bytes(2, "big") for code in codes), 0xFFFF)
        found = self._ask("TABL", *map(str, [len(codes), *codes]), parsers=[int, str])
        if found != [len(codes), f"{check:04X}"]:
            self._fail(device.Refused, "take the table's checksum", str(found), "Load it again.")

    def trigger(self, on: bool) -> None:
        """Let rising edges at the trigger input step the table, or not."""
        self._set("TRIG", on)

    def arm(self) -> None:
        """Count no edges yet; the first edge plays entry 0."""
        self._ask("ARM")

    def safe_state(self) -> None:
        """Turn RF and trigger off, up to three times: the one request that is sent again."""
        device.insist(lambda: self._ask("SAFE"), tries=3)
        if self.status().on:
            self._fail(device.Unsafe, "turn RF off", "it on", "Switch it off by hand.")

    def _identity(self) -> dict[str, str]:
        words = ("model", "serial_number", "firmware")
        parse = lambda word: dict(zip(words, word.split(","), strict=True))  # noqa: E731
        return self._question("ID?", parse)[0]

    def _set(self, word: str, value: float, tolerance: float = 0.0) -> None:
        """Set a number within its limits, or a switch, and compare what was really set."""
        if isinstance(value, bool):
            (found,) = self._ask(word, "ON" if value else "OFF", parsers=[_truth])
        else:
            self._within(**{word: value})
            (found,) = self._ask(word, f"{value:.12g}", parsers=[number])
        self._expect(word, value, found, tolerance)

    def _question(self, word: str, *parsers: Callable[[str], Any]) -> list[Any]:
        """Values of an answer; asked once more after a lost or garbled one."""
        return self._read(lambda: self._ask(word, parsers=parsers))

    def _ask(
        self, word: str, *arguments: str, parsers: Sequence[Callable[[str], Any]] = ()
    ) -> list[Any]:
        """Values of the answer to one request; answers to earlier ones are passed over."""
        self._sequence = (self._sequence + 1) % 100
        with one_error(self.name):
            self._connection.write(framed(" ".join([f">{self._sequence}", word, *arguments])))
        for _ in range(100):
            head, *words = self._line()
            if head == "!TRIP":
                self._trip = " ".join(words) or "unnamed"
            elif head == "<??":
                break
            elif head == f"<{self._sequence}":
                if words[:1] != ["OK"]:
                    kind = device.Unsafe if _UNSAFE & set(words[1:2]) else device.Refused
                    self._fail(kind, f"obey {word}", " ".join(words), "Check state and limits.")
                with one_error(self.name):
                    return [parse(one) for parse, one in zip(parsers, words[1:], strict=True)]
        raise device.BadReply(f"Expected {self.name} to answer, got other lines. Ask again.")

    def _line(self) -> list[str]:
        """Words of the next line whose checksum is right."""
        with one_error(self.name):
            line = self._connection.read_until(b"\n", 1024)
        if not line.endswith(b"\n"):
            self._fail(device.InstrumentTimeout, "send a line in time", repr(line), "Check power.")
        body, _, _ = line.rpartition(b"*")
        if not body or not body.isascii() or line != framed(body.decode("ascii")):
            self._fail(device.BadReply, "send a line with its checksum", repr(line), "Ask again.")
        return body.decode("ascii").split() or [""]

    def _resynchronise(self) -> None:
        with one_error(self.name):
            self._connection.reset_input_buffer()
