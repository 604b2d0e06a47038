"""Motors behind Thorlabs APT controllers: KDC101 with MTS50-Z8 or PRM1-Z8, and K10CR1.

Messages are those of thorlabs-apt-protocol. A controller speaks unasked (MOVE_COMPLETED,
MOVE_HOMED), so what is not the awaited reply is passed over: the end of a move is read from the
status bits, and the position is read back. Moves are sent once.
"""

import time
from math import pi
from typing import Any, NamedTuple

import thorlabs_apt_protocol as apt

from cmtof.hardware import device
from cmtof.hardware.device import one_error

_HOST, _UNIT, _CHANNEL = 0x01, 0x50, 1
_POLL = 0.05  # s, between looks at the status bits
_MOVING = ("moving_forward", "moving_reverse", "jogging_forward", "jogging_reverse", "homing")


class MotorKind(NamedTuple):
    """A motor: counts per m or rad, unit of speed (counts/s), tolerance, travel, controllers."""

    scale: float
    speed: float
    tolerance: float
    travel: tuple[float, float]
    models: tuple[str, ...] = ("KDC101", "TDC001")
    status: str = "dcstatusupdate"


_SERVO = 2048 / 6e6 * 65536  # APT Communications Protocol: a cycle of 2048 / 6 MHz
_TURNS = (-1e3, 1e3)  # rad
MOTORS = {
    # APT Communications Protocol, 28 November 2022: 34554.96 counts/mm. Older drivers (pylablib,
    # kinesis.py) have 34304, 0.73 % less: command 10 mm and measure.
    "mts50-z8": MotorKind(34554960.0, 1 / _SERVO, 5e-6, (0.0, 0.05)),
    # pylablib, kinesis.py: 1919.6418578623391 counts/degree
    "prm1-z8": MotorKind(1919.6418578623391 * 180 / pi, 1 / _SERVO, 3.5e-4, _TURNS),
    # pylablib, kinesis.py: 409600 microsteps a turn, gear 120:1; velocity 53.68 a microstep/s
    "k10cr1": MotorKind(
        409600 * 120 / (2 * pi), 1 / 53.68, 3.5e-4, _TURNS, ("K10CR",), "statusupdate"
    ),
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

    def home(self, timeout: float = 60.0) -> None:
        """Find the home position; the shaft or carriage travels."""
        self._go("mot_move_home", 0.0, timeout)

    def move_to(self, position: float) -> float:
        """Move to a position, m or rad, and wait, 2 s longer than it takes; return the position.

        `Refused` if the motor is not homed or ends elsewhere; after an error it is stopped.
        """
        self._within(position=position)
        if not self.homed:
            self._fail(device.Refused, "be homed before a move", "it not", "Home it.")
        speed = self._ask("mot_req_velparams", _CHANNEL).max_velocity * self.kind.speed
        seconds = abs(position - self.position) * self.kind.scale / max(speed, 1.0)
        counts = round(position * self.kind.scale)
        self._go("mot_move_absolute", position, seconds + 2.0, counts)
        return self.position

    def stop(self) -> None:
        """Stop at once, and wait for it."""
        self._send("mot_move_stop", _CHANNEL, 1)
        for _ in range(20):
            if not self._status()[1]:
                return
            time.sleep(_POLL)
        self._fail(device.InstrumentTimeout, "stop", "it moving", "Switch it off.")

    def safe_state(self) -> None:
        """Stop."""
        device.insist(self.stop)

    def _identity(self) -> dict[str, str]:
        info = self._ask("hw_req_info")
        model = info.model_number.split(b"\0")[0].decode("ascii", "replace")
        return {"model": model, "serial_number": str(info.serial_number)}

    def _go(self, message: str, position: float, seconds: float, *arguments: int) -> None:
        """Send a move, and wait until the motor rests where it should; after an error it stops."""
        self._send("mod_set_chanenablestate", _CHANNEL, 1)
        self._send(message, _CHANNEL, *arguments)
        deadline, looks, wish = time.monotonic() + seconds, 0, f"arrive at {position:.6g}"
        try:
            while looks < 3:  # thrice at rest elsewhere: it did not hear, or was stopped
                status, moving = self._status()
                if status.motion_error or status.motor_current_limit_reached:
                    got = "a motion error or its current limit"
                    self._fail(device.InstrumentError, wish, got, "Free it and home it.")
                if moving and time.monotonic() >= deadline:
                    self._fail(device.InstrumentTimeout, wish, "it moving", "Free the stage.")
                if not moving:
                    if status.homed and abs(self.position - position) <= self.kind.tolerance:
                        return
                    looks += 1
                time.sleep(_POLL)
        except device.InstrumentError:
            self.stop()
            raise
        self._fail(device.Refused, wish, f"it at rest at {self.position:.6g}", "Home it.")

    def _status(self) -> tuple[Any, bool]:
        """Status bits by name, and whether the motor moves."""
        status = self._ask(f"mot_req_{self.kind.status}", _CHANNEL)
        return status, any(getattr(status, name) for name in _MOVING)

    def _send(self, message: str, *arguments: int) -> None:
        with one_error(self.name):
            self._connection.write(getattr(apt, message)(_UNIT, _HOST, *arguments))

    def _ask(self, request: str, *arguments: int) -> Any:
        """Reply to a request, asked once more; what comes unasked is passed over."""
        reply = request.replace("_req_", "_get_")

        def ask() -> Any:
            self._send(request, *arguments)
            for _ in range(256):
                with one_error(self.name):
                    message = next(self._unpacker, None)
                    more = self._connection.in_waiting
                if message is not None and message.msg == reply:
                    return message
                if message is None and not more:
                    break
            raise device.InstrumentTimeout(
                f"Expected {self.name} to answer {request}, got nothing. Check power and cable."
            )

        return self._read(ask)

    def _resynchronise(self) -> None:
        with one_error(self.name):
            self._connection.reset_input_buffer()
        self._unpacker.buf = b""
