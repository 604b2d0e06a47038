"""RF driver of one modulator, over its line protocol (`cmtof.hardware.codecs.rf_line`).

The driver's own safety stands in its firmware: a dead man's timer turns RF off when the host falls
silent, and loss of lock does the same. This class refuses to switch on before the timer is set.
"""

import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from cmtof.hardware.codecs import rf_line
from cmtof.hardware.device import QUERY_TIMEOUT, Device, check_set
from cmtof.hardware.errors import BadReply, Refused, Unsafe
from cmtof.hardware.transport import Transport

MODEL = "CMTOF-RF"
_POLL = 0.02  # s, between questions for the lock
_SAFE_TRIES = 3
_UNSAFE = ("TRIPPED", "LOCK", "UNLOCKED", "INTERLOCK")


@dataclass(frozen=True)
class RfIdentity:
    """Which driver answers."""

    model: str
    serial_number: str
    firmware: str


@dataclass(frozen=True)
class RfLock:
    """State of the frequency lock: detuning from the resonance, Hz; reflected power, dBm."""

    locked: bool
    detuning: float
    reflected: float


@dataclass(frozen=True)
class RfStatus:
    """Whether RF is on and locked, entry that plays, edges since arming, whether RF tripped."""

    on: bool
    locked: bool
    index: int
    edges: int
    tripped: bool


class RfDriver(Device):
    """An RF driver.

    Parameters
    ----------
    transport : Transport
    name : str
    timeout : float
        For an answer, s.

    Attributes
    ----------
    notices : deque of Notice
        The last hundred lines that came unasked, as ``!TRIP DEADMAN``.
    """

    def __init__(
        self, transport: Transport, name: str = "rf driver", *, timeout: float = QUERY_TIMEOUT
    ) -> None:
        super().__init__(name, transport)
        self._transport = transport
        self._timeout = timeout
        self._sequence = -1
        self._dead_man: float | None = None
        self._trip = ""
        self.notices: deque[rf_line.Notice] = deque(maxlen=100)

    # --- settings ------------------------------------------------------------------------------

    def identify(self) -> RfIdentity:
        """Check that an RF driver answers.

        Raises
        ------
        Refused
            If it is another device.
        """
        parts = " ".join(self._question("ID?")).split(",")
        if len(parts) != 3 or parts[0] != MODEL:
            raise Refused(
                f"Expected a {MODEL} at {self.name}, got {','.join(parts)}. Check the address."
            )
        return RfIdentity(*parts)

    def set_frequency(self, hz: float) -> float:
        """Set the frequency of the drive to whole Hz; return what was set."""
        wanted = round(hz)
        (found,) = rf_line.integers(self._command("FREQ", wanted), 1)
        return check_set(self.name, "frequency", wanted, found, tolerance=0.5, unit="Hz")

    def set_phase(self, rad: float) -> float:
        """Set the phase outside the table, rad of the drive; return what was set, in [0, 2 pi)."""
        wanted = rf_line.code_from_phase(rad)
        (found,) = rf_line.integers(self._command("PHAS", wanted), 1)
        check_set(self.name, "phase", wanted, found, tolerance=0.0, unit="codes")
        return rf_line.phase_from_code(found)

    def set_power(self, dbm: float) -> float:
        """Set the power, dBm; return what was set."""
        (found,) = rf_line.numbers(self._command("POWR", float(dbm)), 1)
        return check_set(self.name, "power", dbm, found, tolerance=0.051, unit="dBm")

    def set_dead_man(self, seconds: float) -> float:
        """Have RF turned off when no request comes for so long, 0.1 to 60 s."""
        if not 0.1 <= seconds <= 60:
            raise ValueError(f"Expected 0.1 to 60 s, got {seconds}. Choose another time.")
        (found,) = rf_line.numbers(self._command("DEAD", float(seconds)), 1)
        check_set(self.name, "dead man's time", seconds, found, tolerance=1e-3, unit="s")
        self._dead_man = found
        return found

    # --- output and lock -----------------------------------------------------------------------

    def output(self, on: bool, *, lock_timeout: float = 10.0) -> None:
        """Switch RF; when switching on, wait for the lock.

        Raises
        ------
        Unsafe
            If no dead man's time was set, the driver has tripped, or no lock is found: then RF is
            off again.
        """
        if not on:
            self._switch("RF", False)
            return
        if self._dead_man is None:
            raise Unsafe(
                f"Expected a dead man's time in {self.name} before RF is switched on, got none. "
                "Call set_dead_man first."
            )
        self._switch("RF", True)
        try:
            self.wait_for_lock(lock_timeout)
        except OSError:
            self.safe_state()
            raise

    def lock(self) -> RfLock:
        """State of the frequency lock."""
        locked, *values = self._values("LOCK?", 3)
        detuning, reflected = rf_line.numbers(values, 2)
        return RfLock(rf_line.switch(locked), detuning, reflected)

    def wait_for_lock(self, timeout: float = 10.0) -> RfLock:
        """Return as soon as the frequency is locked.

        Raises
        ------
        Unsafe
            If it is not after ``timeout`` seconds, or the driver has tripped.
        """
        deadline = time.monotonic() + timeout
        while not (lock := self.lock()).locked:
            if self._trip or time.monotonic() >= deadline:
                reason = f"a trip ({self._trip})" if self._trip else "none"
                raise Unsafe(
                    f"Expected {self.name} to lock within {timeout:g} s, got {reason} "
                    f"({lock.detuning:g} Hz off, {lock.reflected:g} dBm reflected). "
                    "Check frequency and cable, then clear_trip."
                )
            time.sleep(_POLL)
        return lock

    def status(self) -> RfStatus:
        """Output, lock, table and trip in one answer."""
        on, locked, index, edges, tripped = self._values("STAT?", 5)
        number, count = rf_line.integers((index, edges), 2)
        return RfStatus(
            rf_line.switch(on), rf_line.switch(locked), number, count, tripped not in ("0", "OFF")
        )

    def clear_trip(self) -> None:
        """Allow RF again after a trip; it stays off until `output`."""
        self._command("CLR")
        self._trip = ""

    def ping(self) -> None:
        """Feed the dead man's timer.

        Raises
        ------
        Unsafe
            If the driver has said since that it tripped.
        """
        self._question("PING")
        if self._trip:
            raise Unsafe(
                f"Expected {self.name} to keep RF on, got a trip ({self._trip}). "
                "Find the cause, then clear_trip."
            )

    # --- phase table ---------------------------------------------------------------------------

    def load_table(self, phases: Sequence[float]) -> None:
        """Load 1 to 64 phases of the drive, rad, that the trigger steps through; checked.

        Raises
        ------
        Refused
            If the driver holds another table than was sent.
        """
        if not 1 <= len(phases) <= rf_line.TABLE_SIZE:
            raise ValueError(
                f"Expected 1 to {rf_line.TABLE_SIZE} phases, got {len(phases)}. Send fewer."
            )
        codes = [rf_line.code_from_phase(phase) for phase in phases]
        self._command("TABL", len(codes), *codes)
        count, check = self._values("TABL?", 2)
        if (count, check.upper()) != (str(len(codes)), f"{rf_line.table_crc(codes):04X}"):
            raise Refused(
                f"Expected {self.name} to hold the table of {len(codes)} phases, got another "
                f"({count}, checksum {check}). Load it again."
            )

    def trigger(self, on: bool) -> None:
        """Let rising edges at the trigger input step the table, or not."""
        self._switch("TRIG", on)

    def arm(self) -> None:
        """Play entry 0, count no edges yet; the first edge plays entry 0 anew."""
        self._command("ARM")

    def index(self) -> tuple[int, int]:
        """Entry that plays, and edges since arming."""
        index, edges = rf_line.integers(self._question("INDX?"), 2)
        return index, edges

    # --- safety --------------------------------------------------------------------------------

    def safe_state(self) -> None:
        """Turn RF and trigger off. The one command that is sent again: it only ever switches off.

        Raises
        ------
        Unsafe
            If RF is still on.
        """
        self._insist(lambda: self._ask("SAFE"), _SAFE_TRIES)
        if self.status().on:
            raise Unsafe(f"Expected RF off at {self.name}, got on. Switch it off by hand.")

    # --- dialogue ------------------------------------------------------------------------------

    def _switch(self, word: str, on: bool) -> None:
        wanted = "ON" if on else "OFF"
        values = self._command(word, wanted)
        if len(values) != 1 or rf_line.switch(values[0]) != on:
            raise Refused(
                f"Expected {self.name} to answer {word} {wanted}, got {' '.join(values)}. "
                "Look at its status."
            )

    def _values(self, word: str, count: int) -> tuple[str, ...]:
        values = self._question(word)
        if len(values) != count:
            raise BadReply(
                f"Expected {count} values of {word} from {self.name}, got {len(values)}. "
                "Check its firmware."
            )
        return values

    def _question(self, word: str) -> tuple[str, ...]:
        return self._read(lambda: self._ask(word))

    def _command(self, word: str, *arguments: float | str) -> tuple[str, ...]:
        return self._act(lambda: self._ask(word, *arguments))

    def _ask(self, word: str, *arguments: float | str) -> tuple[str, ...]:
        self._sequence = (self._sequence + 1) % rf_line.SEQUENCES
        self._transport.write(rf_line.request(self._sequence, word, *arguments))
        deadline = time.monotonic() + self._timeout
        while True:
            line = self._transport.read_until(
                rf_line.END, max(round(deadline - time.monotonic(), 3), 0.0), rf_line.LIMIT
            )
            reply = rf_line.parse_line(line)
            if isinstance(reply, rf_line.Notice):
                self._take_note(reply)
            elif reply.sequence in (None, self._sequence):
                return self._checked(reply)
            # else a late answer to an earlier request

    def _checked(self, reply: rf_line.Reply) -> tuple[str, ...]:
        if reply.code in _UNSAFE:
            text = " ".join((reply.code, *reply.values))
            raise Unsafe(
                f"Expected {self.name} to obey, got ERR {text}. Find the cause, then clear_trip."
            )
        return rf_line.values_from_reply(reply, self._sequence)

    def _take_note(self, notice: rf_line.Notice) -> None:
        self.notices.append(notice)
        if notice.word == "TRIP":
            self._trip = " ".join(notice.arguments) or "unnamed"
