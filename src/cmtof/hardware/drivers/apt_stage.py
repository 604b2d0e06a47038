"""Motorised stage behind a Thorlabs APT controller: KDC101 with MTS50-Z8 or PRM1-Z8, K10CR1.

A controller speaks unasked (MOVE_COMPLETED, MOVE_HOMED, status), so what is not the awaited reply
is queued. Moves are sent once. The end of a move is its message or, should that be lost, the status
bits; either way the position is read back.
"""

import time
from collections import deque
from collections.abc import Callable
from typing import TypeVar

from cmtof.hardware.codecs import apt
from cmtof.hardware.device import QUERY_TIMEOUT, Device
from cmtof.hardware.drivers.stage_table import StageKind
from cmtof.hardware.errors import InstrumentError, InstrumentTimeout, Refused
from cmtof.hardware.transport import Transport

P = TypeVar("P")

HOME_TIMEOUT = 60.0
"""How long homing may take, s."""

_POLL = 0.1  # s, between looks at the status bits while nothing is said
_AT_REST = 3  # looks in a row that must find the motor at rest when no message came
_ERRORS = {
    apt.Status.MOTION_ERROR: "a motion error (position error too large)",
    apt.Status.CURRENT_LIMIT: "the motor's current limit",
}


class Stage(Device):
    """A stage; positions in m or rad, from the home position.

    Parameters
    ----------
    transport : Transport
        Serial line, ``rtscts=1`` on a real controller.
    kind : StageKind
        Out of `STAGES`, or one with its own scale.
    name : str
    serial_number : str
        Refuse another controller than this one; empty takes any.
    timeout, margin : float
        For an answer, and for a move beyond the time that it should take, s.
    """

    def __init__(
        self,
        transport: Transport,
        kind: StageKind,
        name: str = "stage",
        *,
        serial_number: str = "",
        timeout: float = QUERY_TIMEOUT,
        margin: float = 2.0,
    ) -> None:
        super().__init__(name, transport)
        self.kind = kind
        self._transport = transport
        self._serial_number = serial_number
        self._timeout, self._margin = timeout, margin
        self._unpacker = apt.Unpacker()
        self._inbox: deque[apt.Payload] = deque()
        self._queue: deque[apt.Payload] = deque(maxlen=256)
        self._ready = False

    # --- what the stage is and where -----------------------------------------------------------

    def identify(self) -> apt.HardwareInfo:
        """Check that the right controller and stage answer, and make them ready to move.

        Raises
        ------
        Refused
            If it is another controller or stage.
        """
        self._prepare()
        info = self._question(apt.request_info(), apt.HardwareInfo)
        if not info.model.startswith(self.kind.models):
            raise Refused(
                f"Expected a {' or '.join(self.kind.models)} at {self.name}, got {info.model}. "
                "Check the address."
            )
        if info.stage_id and self.kind.stage_id and info.stage_id != self.kind.stage_id:
            raise Refused(
                f"Expected an {self.kind.name} (stage {self.kind.stage_id}) at {self.name}, got "
                f"stage {info.stage_id}. Check the cable, or `stage` in the RIG file."
            )
        if self._serial_number not in ("", str(info.serial)):
            raise Refused(
                f"Expected serial number {self._serial_number} at {self.name}, got {info.serial}. "
                "Check the address."
            )
        return info

    def position(self) -> float:
        """Position, m or rad."""
        return self.counts() / self.kind.scale

    def counts(self) -> int:
        """Position as the controller counts."""
        return self._question(apt.request_position(), apt.Position).counts

    def status(self) -> apt.Status:
        """Status bits, as ``HOMED`` and ``moving``."""
        return self._question(apt.request_status_bits(), apt.StatusBits).status

    # --- moves ---------------------------------------------------------------------------------

    def home(self, timeout: float = HOME_TIMEOUT) -> None:
        """Find the home position; the shaft or carriage travels.

        Raises
        ------
        InstrumentTimeout
            If it is not found in time; the stage is stopped.
        InstrumentError
            If the controller reports an error, or ends without being homed.
        """
        told = self._move(apt.move_home(), apt.Homed, timeout)
        # a stage that was homed before says so still, though it may not have heard the command
        found = told or abs(self.position()) <= self.kind.tolerance
        if not (found and self.status() & apt.Status.HOMED):
            raise InstrumentError(
                f"Expected {self.name} to be homed, got no home position. "
                "Free the stage and home it again."
            )

    def move_to(self, position: float) -> float:
        """Move to a position, m or rad, and wait; return where it ended.

        Raises
        ------
        ValueError
            If the position is beyond the travel.
        Refused
            If the stage is not homed, or ended elsewhere.
        InstrumentTimeout
            If it takes longer than distance over speed and the margin; the stage is stopped.
        InstrumentError
            If the controller reports an error.
        """
        self._check_travel(position)
        self._prepare()
        if not self.status() & apt.Status.HOMED:
            raise Refused(
                f"Expected {self.name} to be homed before it moves, got no home position. "
                "Call home first."
            )
        target = self.kind.counts(position)
        seconds = self._duration(abs(target - self.counts())) + self._margin
        self._move(apt.move_absolute(target), _completed, seconds)
        return self._arrived(position)

    def stop(self) -> None:
        """Stop at once.

        Raises
        ------
        InstrumentTimeout
            If the motor goes on.
        """
        self._act(lambda: self._transport.write(apt.stop()))
        deadline = time.monotonic() + self._timeout
        while self.status().moving:
            if time.monotonic() >= deadline:
                raise InstrumentTimeout(
                    f"Expected {self.name} to stop within {self._timeout:g} s, got it moving. "
                    "Switch it off."
                )
            self._next(_POLL)
        self._queue.clear()

    def safe_state(self) -> None:
        """Stop."""
        self._insist(self.stop)

    def _check_travel(self, position: float) -> None:
        low, high = self.kind.travel or (-1e3, 1e3)
        if not low <= position <= high:
            raise ValueError(
                f"Expected {low:g} to {high:g} {self.kind.unit} for {self.name}, got "
                f"{position:g}. Stay within the travel."
            )

    def _duration(self, counts: int) -> float:
        """Time of a move without ramps, s, at the controller's own speed."""
        velocity = self._question(apt.request_velocity(), apt.Velocity).maximum
        if velocity <= 0:
            raise Refused(
                f"Expected a speed above 0 in {self.name}, got {velocity}. Set its parameters."
            )
        return counts / self.kind.scale / (velocity / self.kind.velocity_scale)

    def _move(
        self, request: bytes, ends: Callable[[apt.Payload], bool] | type, seconds: float
    ) -> bool:
        """Send a move and wait for its end; False if it came to rest without telling that."""
        self._prepare()
        self._act(self._drop)  # an older MOVE_COMPLETED must not end this move
        self._act(lambda: self._transport.write(request))
        deadline = time.monotonic() + seconds
        at_rest = 0
        while at_rest < _AT_REST:
            payload = self._next(min(_POLL, seconds))
            if payload is not None and _matches(payload, ends):
                self._sound_status()
                return True
            if payload is None:
                status = self._sound_status()
                at_rest = 0 if status.moving else at_rest + 1
            if time.monotonic() >= deadline:
                self.stop()
                raise InstrumentTimeout(
                    f"Expected {self.name} to arrive within {seconds:.1f} s, got it "
                    f"{self.position():.6g} {self.kind.unit} from home. Free the stage."
                )
        self._sound_status()
        return False

    def _sound_status(self) -> apt.Status:
        """Status bits; the motor is stopped before an error is raised."""
        status = self.status()
        if errors := [text for bit, text in _ERRORS.items() if status & bit]:
            self.stop()
            raise InstrumentError(
                f"Expected {self.name} to move freely, got {' and '.join(errors)}. "
                "Free the stage and home it."
            )
        return status

    def _arrived(self, position: float) -> float:
        found = self.position()
        if abs(found - position) > self.kind.tolerance:
            at_limit = self.status() & (apt.Status.LIMIT_CW | apt.Status.LIMIT_CCW)
            raise Refused(
                f"Expected {self.name} at {position:.6g} {self.kind.unit}, got {found:.6g}"
                f"{' at a limit switch' if at_limit else ''}. Home it and try again."
            )
        return found

    # --- dialogue ------------------------------------------------------------------------------

    def _prepare(self) -> None:
        """Have a channel that is on and speaks only of moves; once a connection."""
        if self._ready:
            return
        start = apt.no_flash_programming() + apt.stop_updates() + apt.enable(True)
        self._act(lambda: self._transport.write(start))
        if not self._question(apt.request_enabled(), apt.ChannelEnabled).enabled:
            raise Refused(
                f"Expected {self.name} to enable its motor, got it disabled. "
                "Enable it at the controller's panel."
            )
        self._ready = True

    def _question(self, request: bytes, kind: type[P]) -> P:
        return self._read(lambda: self._ask(request, kind))

    def _ask(self, request: bytes, kind: type[P]) -> P:
        self._set_aside()  # what was there before cannot be the reply
        self._transport.write(request)
        deadline = time.monotonic() + self._timeout
        while True:
            payload = self._receive(max(deadline - time.monotonic(), 0.0))
            if isinstance(payload, kind):
                return payload
            self._queue.append(payload)

    def _next(self, timeout: float) -> apt.Payload | None:
        """Take what the controller said unasked; None when it says nothing."""
        try:
            return self._queue.popleft() if self._queue else self._receive(timeout)
        except InstrumentTimeout:
            return None

    def _set_aside(self) -> None:
        self._queue.extend(self._inbox)
        self._inbox.clear()

    def _receive(self, timeout: float) -> apt.Payload:
        """Next message that has arrived or arrives."""
        deadline = time.monotonic() + timeout
        while not self._inbox:
            messages = self._more(max(deadline - time.monotonic(), 0.0))
            self._inbox.extend(apt.parse_message(message) for message in messages)
        payload = self._inbox.popleft()
        if isinstance(payload, apt.Fault):
            raise Refused(
                f"Expected {self.name} to obey, got fault {payload.code} about message "
                f"{payload.about:#06x} {payload.text}. Look at the controller."
            )
        return payload

    def _more(self, timeout: float) -> list[apt.Message]:
        first = self._transport.read_exact(1, timeout)
        return self._unpacker.feed(first + self._transport.flush())

    def _drop(self) -> None:
        super()._drop()
        self._forget()

    def _reconnected(self) -> None:
        self._forget()
        self._ready = False

    def _forget(self) -> None:
        self._unpacker.reset()
        self._inbox.clear()
        self._queue.clear()


def _completed(payload: apt.Payload) -> bool:
    return isinstance(payload, apt.Motion) and payload.event is apt.MessageId.MOT_MOVE_COMPLETED


def _matches(payload: apt.Payload, ends: Callable[[apt.Payload], bool] | type) -> bool:
    return isinstance(payload, ends) if isinstance(ends, type) else ends(payload)
