"""Driver of motors with Thorlabs APT controllers: KDC101 (MTS50-Z8, PRM1-Z8) and K10CR1.

Messages are those of thorlabs-apt-protocol. A controller speaks unasked (MOVE_COMPLETED,
MOVE_HOMED): the end of a move is read from the status bits, and the position is read back.
"""

import time
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import thorlabs_apt_protocol as apt

from cmtof.files import read_document
from cmtof.hardware.device import (
    Device,
    InstrumentError,
    InstrumentTimeout,
    Refused,
    insist,
    one_error,
    question,
)
from cmtof.hardware.rf import open_serial
from cmtof.hardware.roles import Waiting
from cmtof.types import Texts

_HOST = 0x01
_UNIT = 0x50
_CHANNEL = 1
_POLL = 0.05  # s, between looks at the status bits
ANSWER = 2.0  # s that an answer may take, whatever else comes
# s that a move may take: the whole travel takes 21 s, a turn of a plate 36 s
LONGEST = 60.0
_MOVING = (
    "moving_forward",
    "moving_reverse",
    "jogging_forward",
    "jogging_reverse",
    "homing",
)


# Motors by the name in a RIG file.
MOTORS = {
    name: SimpleNamespace(**found)
    for name, found in read_document(Path(__file__).with_name("motors.yml")).items()
}


def open_controller(address: str, timeout: float = 1.0) -> Any:
    """Open a controller's serial port for this program alone, and discard buffered data.

    RTS is raised and lowered as the controllers' protocol asks; a pty or a URL has no such line.
    """
    port = open_serial(address, timeout, rtscts="://" not in address)
    for level in (True, False):
        with suppress(OSError):
            port.rts = level
        time.sleep(_POLL)
        port.reset_input_buffer()
        port.reset_output_buffer()
    return port


class Motor(Device):
    """A motor on a pyserial port; positions are in m or rad from home."""

    def __init__(
        self,
        port: Any,
        kind: SimpleNamespace,
        name: str,
        serial_number: str = "",
        scale: float = 0.0,
    ) -> None:
        super().__init__(port, name, serial_number)
        unit = kind.unit
        self.kind = kind
        self.scale = scale or kind.scale / unit  # counts per m or rad
        self.tolerance = unit * kind.tolerance
        self.MODELS = tuple(kind.models)  # type: ignore[misc]
        self.LIMITS = {"position": tuple(unit * end for end in kind.travel)}  # type: ignore[misc]
        self._unpacker = apt.Unpacker(port)
        self._speeds_set = False

    @property
    def position(self) -> float:
        """Position from home, m or rad."""
        return self._ask("mot_req_poscounter", _CHANNEL).position / self.scale

    @property
    def homed(self) -> bool:
        """Whether the home position is known."""
        return bool(self._status()[0].homed)

    def home(self, *, waiting: Waiting = None) -> None:
        """Move to the home position, and wait; ``waiting`` is called meanwhile."""
        self._move_and_wait("mot_move_home", 0.0, waiting=waiting)

    def move_to(self, position: float, *, waiting: Waiting = None) -> float:
        """Move to a position, m or rad, and return where the motor rests; an error stops it."""
        self._within(position=position)
        if not self.homed:
            self._fail(Refused, "be homed before a move", "it not homed", "Home it.")
        self._move_and_wait(
            "mot_move_absolute", position, round(position * self.scale), waiting=waiting
        )
        return self.position

    def safe_state(self) -> None:
        """Stop the motor at once, and wait until it rests."""
        insist(self._stop)

    def _stop(self) -> None:
        self._send("mot_move_stop", _CHANNEL, 1)
        for _ in range(20):
            if not self._status()[1]:
                return
            time.sleep(_POLL)
        self._fail(InstrumentTimeout, "stop", "it moving", "Switch it off.")

    def set_speeds(self) -> None:
        """Set and check velocity and acceleration: some controllers start with useless ones."""
        kind = self.kind
        home = self._ask("mot_req_homeparams", _CHANNEL)
        wanted = round(kind.home_velocity * kind.velocity_scale)
        self._send(
            "mot_set_homeparams",
            _CHANNEL,
            home.home_dir,
            home.limit_switch,
            wanted,
            home.offset_distance,
        )
        found = self._ask("mot_req_homeparams", _CHANNEL).home_velocity
        self._expect("home velocity", wanted, found, 1e-3 * wanted)
        acceleration = round(kind.acceleration * kind.acceleration_scale)
        velocity = round(kind.velocity * kind.velocity_scale)
        self._send("mot_set_velparams", _CHANNEL, 0, acceleration, velocity)
        moving = self._ask("mot_req_velparams", _CHANNEL)
        self._expect("velocity", velocity, moving.max_velocity, 1e-3 * velocity)
        self._expect(
            "acceleration", acceleration, moving.acceleration, 0.01 * acceleration
        )

    def _identity(self) -> Texts:
        self._send("hw_stop_updatemsgs")  # another program may have left it talking
        info = self._ask("hw_req_info")
        model = info.model_number.split(b"\0")[0].decode("ascii", "replace")
        return {"model": model, "serial_number": str(info.serial_number)}

    def _move_and_wait(
        self, message: str, position: float, *arguments: int, waiting: Waiting
    ) -> None:
        """Send a move, and wait until the motor rests at ``position``; after an error it stops."""
        if not self._speeds_set:
            self.set_speeds()
            self._speeds_set = True
        self._send("mod_set_chanenablestate", _CHANNEL, 1)
        self._send(message, _CHANNEL, *arguments)
        deadline = time.monotonic() + LONGEST
        try:
            while True:
                status, moving = self._status()
                arrived = abs(self.position - position) <= self.tolerance
                if arrived and status.homed and not moving:
                    return
                stuck = status.motion_error or status.motor_current_limit_reached
                if stuck or time.monotonic() >= deadline:
                    self._fail(
                        InstrumentError,
                        f"arrive at {position:.6g}",
                        f"it at {self.position:.6g}",
                        "Free it and home it.",
                    )
                if waiting:
                    waiting()
                time.sleep(_POLL)
        except InstrumentError:
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
        """Reply to a request; other messages are skipped, and `InstrumentTimeout` if it is late."""
        self._send(request, *arguments)
        reply = request.replace("_req_", "_get_")
        deadline = time.monotonic() + ANSWER
        with one_error(self.name):
            for message in self._unpacker:
                if message.msg == reply:
                    return message
                if time.monotonic() > deadline:
                    break
        return self._fail(
            InstrumentTimeout, f"answer {request}", "none", "Check power."
        )

    def _resynchronise(self) -> None:
        with one_error(self.name):
            self._connection.reset_input_buffer()
        self._unpacker.buf = b""
