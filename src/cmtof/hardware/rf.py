"""RF driver of one modulator, over lines of text on a serial port (pyserial).

Request ``>SEQ WORD arg...*CCCC``, reply ``<SEQ OK value...*CCCC`` or ``<SEQ ERR CODE text*CCCC``,
unasked ``!WORD arg...*CCCC``; SEQ is 0 to 99, CCCC the CRC-16/CCITT-FALSE of what stands before the
asterisk. The words are listed in the book's hardware guide. The driver's own safety stands in its
firmware: a dead man's timer turns RF off when the host falls silent, and loss of lock does so too.
"""

import time
from binascii import crc_hqx
from math import pi
from typing import Any, ClassVar

from cmtof.hardware.device import (
    BadReply,
    ConnectionLost,
    Device,
    InstrumentTimeout,
    Refused,
    Unsafe,
    insist,
    number,
    one_error,
    question,
)
from cmtof.hardware.roles import RfLock, RfStatus
from cmtof.types import Array, Texts

CODES = 65536  # of one turn of the drive


def open_serial(address: str, timeout: float = 1.0, *, rtscts: bool = False) -> Any:
    """Open a serial port, a path or URL, at 115200 baud, for this program alone.

    Raises `ConnectionLost` if it is not there, or in use.
    """
    import serial

    with one_error(f"a serial port at {address}", ConnectionLost):
        return serial.serial_for_url(
            address,
            baudrate=115200,
            timeout=timeout,
            write_timeout=timeout,
            rtscts=rtscts,
            exclusive=True,
        )


def line_with_checksum(text: str) -> bytes:
    """Bytes of a line of text, with its checksum and a newline."""
    body = text.encode("latin-1")
    return b"%s*%04X\n" % (body, crc_hqx(body, 0xFFFF))


def code_from_phase(phase: float) -> int:
    """Phase code, 0 to 65535, of a drive phase, rad, modulo a turn."""
    return round(phase / (2 * pi) * CODES) % CODES


class RfDriver(Device):
    """Driver of the RF drive of one modulator, on a serial port."""

    MODELS = ("CMTOF-RF",)
    LIMITS: ClassVar = {
        "FREQ": (7.14e9, 7.17e9),
        "POWR": (-30.0, 35.0),
        "PHAS": (0, CODES - 1),
        "DEAD": (0.1, 60.0),
        "TABL": (1, 64),
    }
    _sequence = -1

    def set_frequency(self, hz: float) -> None:
        """Set the frequency of the drive, whole Hz."""
        self._set("FREQ", round(hz), 0.5)

    def set_power(self, dbm: float) -> None:
        """Set the power, dBm."""
        self._set("POWR", dbm, 0.051)

    def set_phase(self, rad: float) -> None:
        """Set the phase of the drive, rad, for when no trigger steps through the phase table."""
        self._set("PHAS", code_from_phase(rad))

    def set_dead_man(self, seconds: float) -> None:
        """Set the watchdog: RF turns off when no request comes for so many seconds."""
        self._set("DEAD", seconds, 1e-3)

    def output(self, on: bool, *, lock_timeout: float = 10.0) -> None:
        """Switch RF; if on, wait for the lock; `Unsafe` and RF off if it does not come in time."""
        self._switch("RF", on)
        deadline = time.monotonic() + lock_timeout
        try:
            while on and not (status := self.status()).locked:
                if status.tripped or time.monotonic() >= deadline:
                    self._fail(
                        Unsafe,
                        f"lock within {lock_timeout:g} s",
                        str(status),
                        "Check frequency and cable.",
                    )
                time.sleep(0.02)
        except OSError:
            self.safe_state()
            raise

    def status(self) -> RfStatus:
        """State of output, lock, phase table and trip, in one answer."""
        with one_error(self.name):
            return RfStatus(*map(int, self._question("STAT?")))  # type: ignore[arg-type]

    def lock(self) -> RfLock:
        """Lock to the resonance, detuning, Hz, and reflected power, dBm, in one answer."""
        with one_error(self.name):
            return RfLock(*map(float, self._question("LOCK?")))  # type: ignore[arg-type]

    def clear_trip(self) -> None:
        """Allow RF again after a trip; it stays off until `output`."""
        self._ask("CLR")

    def ping(self) -> None:
        """Reset the watchdog; `Unsafe` if the driver has switched RF off by itself."""
        if self.status().tripped:
            self._fail(Unsafe, "keep RF on", "a trip", "Find the cause.")

    def load_table(self, phases: Array) -> None:
        """Load phases of the drive, rad, that the trigger steps through."""
        codes = [str(code_from_phase(phase)) for phase in phases]
        self._set("TABL", len(codes), 0.0, *codes)

    def trigger(self, on: bool) -> None:
        """Let rising edges at the trigger input step through the phase table, or not."""
        self._switch("TRIG", on)

    def arm(self) -> None:
        """Rewind the phase table to entry 0, and count trigger edges from 0."""
        self._ask("ARM")

    def safe_state(self) -> None:
        """Turn RF and trigger off, in up to three tries; `Unsafe` if RF stays on."""
        insist(lambda: self._ask("SAFE"), tries=3)
        if self.status().on:
            self._fail(Unsafe, "turn RF off", "it on", "Switch it off by hand.")

    def _identity(self) -> Texts:
        words = "".join(self._question("ID?")).split(",")
        with one_error(self.name):
            return dict(zip(("model", "serial_number", "firmware"), words, strict=True))

    def _set(self, word: str, value: float, tolerance: float = 0.0, *more: str) -> None:
        """Set a number within its limits, with more arguments; `Refused` if it is not confirmed."""
        self._within(**{word: value})
        found = number(" ".join(self._ask(word, f"{value:.12g}", *more)))
        self._expect(word, value, found, tolerance)

    def _switch(self, word: str, on: bool) -> None:
        """Switch what a word of the protocol names; `Refused` if the device does not confirm it."""
        self._expect(word, on, self._ask(word, "ON" if on else "OFF") == ["ON"])

    @question
    def _question(self, word: str) -> list[str]:
        """Words of the answer to a request that changes nothing."""
        return self._ask(word)

    def _ask(self, word: str, *arguments: str) -> list[str]:
        """Words of the answer to a request; late answers and unasked lines are skipped."""
        self._sequence = (self._sequence + 1) % 100
        with one_error(self.name):
            self._connection.write(
                line_with_checksum(" ".join([f">{self._sequence}", word, *arguments]))
            )
        for _ in range(1000):  # no flood of unasked lines holds up a safe state
            if (words := self._read_line())[:1] == [f"<{self._sequence}"]:
                break
        else:
            self._fail(BadReply, "answer", "unasked lines", "Restart it.")
        if words[1:2] != ["OK"]:
            self._fail(
                Refused, f"obey {word}", " ".join(words[1:]), "Check state and limits."
            )
        return words[2:]

    def _read_line(self) -> list[str]:
        """Words of the next line received, without its checksum."""
        with one_error(self.name):
            line = self._connection.read_until(b"\n", 1024)
        body = line.decode("latin-1").rpartition("*")[0]
        if line != line_with_checksum(body):
            self._fail(
                BadReply if line.endswith(b"\n") else InstrumentTimeout,
                "send a whole line in time",
                repr(line),
                "Check power and cable.",
            )
        return body.split()

    def _resynchronise(self) -> None:
        with one_error(self.name):
            self._connection.reset_input_buffer()
