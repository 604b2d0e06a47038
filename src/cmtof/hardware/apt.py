"""Motors behind Thorlabs APT controllers: KDC101 with MTS50-Z8 or PRM1-Z8, and K10CR1.

Messages are those of thorlabs-apt-protocol. A controller speaks unasked (MOVE_COMPLETED,
MOVE_HOMED): the end of a move is read from the status bits, and the position is read back.
"""

import time
from math import pi
from typing import Any, NamedTuple

import thorlabs_apt_protocol as apt

from cmtof.hardware import device
from cmtof.hardware.device import one_error, question
from cmtof.hardware.roles import Waiting

_HOST, _UNIT, _CHANNEL = 0x01, 0x50, 1
_POLL = 0.05  # s, between looks at the status bits
LONGEST = 60.0  # s that a move may take: the whole travel takes 21 s, a turn of a plate 36 s
_MOVING = ("moving_forward", "moving_reverse", "jogging_forward", "jogging_reverse", "homing")


class MotorKind(NamedTuple):
    """A motor: counts per m or rad, tolerance, travel, controllers, message of the status."""

    scale: float
    tolerance: float
    travel: tuple[float, float]
    models: tuple[str, ...] = ("KDC101", "TDC001")
    status: str = "dcstatusupdate"


_TURNS = (-1e3, 1e3)  # rad
MOTORS = {
    # APT Communications Protocol, 28 November 2022: 34554.96 counts/mm. Older drivers (pylablib,
    # kinesis.py) have 34304, 0.73 % less: command 10 mm and measure.
    "mts50-z8": MotorKind(34554960.0, 5e-6, (0.0, 0.05)),
    # pylablib, kinesis.py: 1919.6418578623391 counts/degree
    "prm1-z8": MotorKind(1919.6418578623391 * 180 / pi, 3.5e-4, _TURNS),
    # pylablib, kinesis.py: 409600 microsteps a turn, gear 120:1
    "k10cr1": MotorKind(409600 * 120 / (2 * pi), 3.5e-4, _TURNS, ("K10CR",), "statusupdate"),
}
"""Motors by the name in a RIG file."""


class Motor(device.Device):
    """A motor on a pyserial port, with RTS/CTS on a real controller; m or rad from home."""

    def __init__(self, port: Any, kind: MotorKind, name: str, serial_number: str = "") -> None:
        super().__init__(port, name, serial_number)
        self.kind, self.MODELS = kind, kind.models  # type: ignore[misc]
        self.LIMITS = {"position": kind.travel}  # type: ignore[misc]
        self._unpacker = apt.Unpacker(port)

    @property
    def position(self) -> float:
        """Position, m or rad."""
        return self._ask("mot_req_poscounter", _CHANNEL).position / self.kind.scale

    @property
    def homed(self) -> bool:
        """Whether the home position is known."""
        return bool(self._status()[0].homed)

    def home(self, *, waiting: Waiting = None) -> None:
        """Find the home position; the shaft or carriage travels."""
        self._go("mot_move_home", 0.0, waiting=waiting)

    def move_to(self, position: float, *, waiting: Waiting = None) -> float:
        """Move to a position, m or rad, and wait; return it. After an error it is stopped."""
        self._within(position=position)
        if not self.homed:
            self._fail(device.Refused, "be homed before a move", "it not", "Home it.")
        counts = round(position * self.kind.scale)
        self._go("mot_move_absolute", position, counts, waiting=waiting)
        return self.position

    def safe_state(self) -> None:
        """Stop at once, and wait for it."""
        device.insist(self._stop)

    def _stop(self) -> None:
        self._send("mot_move_stop", _CHANNEL, 1)
        for _ in range(20):
            if not self._status()[1]:
                return
            time.sleep(_POLL)
        self._fail(device.InstrumentTimeout, "stop", "it moving", "Switch it off.")

    def _identity(self) -> dict[str, str]:
        info = self._ask("hw_req_info")
        model = info.model_number.split(b"\0")[0].decode("ascii", "replace")
        return {"model": model, "serial_number": str(info.serial_number)}

    def _go(self, message: str, position: float, *arguments: int, waiting: Waiting) -> None:
        """Send a move, and wait until the motor rests where it should; after an error it stops."""
        self._send("mod_set_chanenablestate", _CHANNEL, 1)
        self._send(message, _CHANNEL, *arguments)
        deadline = time.monotonic() + LONGEST
        try:
            while True:
                status, moving = self._status()
                arrived = abs(self.position - position) <= self.kind.tolerance
                if arrived and status.homed and not moving:
                    return
                stuck = status.motion_error or status.motor_current_limit_reached
                if stuck or time.monotonic() >= deadline:
                    wish, got = f"arrive at {position:.6g}", f"it at {self.position:.6g}"
                    self._fail(device.InstrumentError, wish, got, "Free it and home it.")
                if waiting:
                    waiting()
                time.sleep(_POLL)
        except device.InstrumentError:
            self.safe_state()
            raise

    def _status(self) -> tuple[Any, bool]:
        """Status bits by name, and whether the motor moves."""
        status = self._ask(f"mot_req_{self.kind.status}", _CHANNEL)
        return status, any(getattr(status, name) for name in _MOVING)

    def _send(self, message: str, *arguments: int) -> None:
        with one_error(self.name):
            self._connection.write(getattr(apt, message)(_UNIT, _HOST, *arguments))

    @question
    def _ask(self, request: str, *arguments: int) -> Any:
        """Reply to a request; what comes unasked is passed over."""
        self._send(request, *arguments)
        reply = request.replace("_req_", "_get_")
        with one_error(self.name):
            message = next((one for one in self._unpacker if one.msg == reply), None)
        if message is None:
            self._fail(device.InstrumentTimeout, f"answer {request}", "nothing", "Check power.")
        return message

    def _resynchronise(self) -> None:
        with one_error(self.name):
            self._connection.reset_input_buffer()
        self._unpacker.buf = b""
