"""Motors behind Thorlabs APT controllers: KDC101 with MTS50-Z8 or PRM1-Z8, and K10CR1.

Messages are those of thorlabs-apt-protocol. A controller speaks unasked (MOVE_COMPLETED,
MOVE_HOMED), so what is not the awaited reply is passed over: the end of a move is read from the
status bits, and the position is read back. Moves are sent once.
"""

import struct
import time
from math import pi
from typing import Any, NamedTuple

from cmtof.hardware.device import (
    BadReply,
    Device,
    InstrumentError,
    InstrumentTimeout,
    Refused,
    insist,
)
from cmtof.hardware.rf import port_errors

HOME_TIMEOUT = 60.0
"""How long homing may take, s."""
_HOST, _UNIT, _CHANNEL = 0x01, 0x50, 1
_POLL = 0.05  # s, between looks at the status bits
_MOVING = ("moving_forward", "moving_reverse", "jogging_forward", "jogging_reverse", "homing")
_ERRORS = {
    "motion_error": "a motion error (position error too large)",
    "motor_current_limit_reached": "the motor's current limit",
}


class MotorKind(NamedTuple):
    """A motor: counts per m or rad, speed unit, tolerance, travel, and its status message."""

    unit: str
    scale: float
    velocity_scale: float
    tolerance: float
    travel: tuple[float, float]
    models: tuple[str, ...]
    status: str = "dcstatusupdate"


MOTORS = {
    # APT Communications Protocol, 28 November 2022: 34554.96 counts/mm. Older drivers (pylablib,
    # kinesis.py) have 34304, 0.73 % less: command 10 mm and measure. Velocity is
    # counts * T * 65536 with T = 2048 / 6 MHz.
    "mts50-z8": MotorKind("m", 34554960.0, 772981370.0, 5e-6, (0.0, 0.05), ("KDC101", "TDC001")),
    # pylablib, kinesis.py: 1919.6418578623391 counts/degree
    "prm1-z8": MotorKind(
        "rad",
        1919.6418578623391 * 180 / pi,
        42941.66 * 180 / pi,
        0.02 * pi / 180,
        (-1e3, 1e3),
        ("KDC101", "TDC001"),
    ),
    # pylablib, kinesis.py: 409600 microsteps a turn, gear 120:1; velocity 53.68 a microstep/s
    "k10cr1": MotorKind(
        "rad",
        409600 * 120 / (2 * pi),
        7329109 * 180 / pi,
        0.02 * pi / 180,
        (-1e3, 1e3),
        ("K10CR",),
        "statusupdate",
    ),
}
"""Motors by the name in a RIG file."""


class Motor(Device):
    """A motor; positions in m or rad, from home.

    Parameters
    ----------
    port
        pyserial port, with RTS/CTS on a real controller.
    kind : MotorKind
    name : str
    serial_number : str
        Refuse another controller than this one; empty takes any.
    """

    def __init__(self, port: Any, kind: MotorKind, name: str, serial_number: str = "") -> None:
        from thorlabs_apt_protocol import Unpacker

        super().__init__(name)
        self.kind, self._port, self._serial_number = kind, port, serial_number
        self._unpacker = Unpacker(port)
        self._ready = False

    def close(self) -> None:
        """Close the port."""
        self._port.close()

    def identify(self) -> dict[str, str]:
        """Model and serial number; `Refused` if it is another controller."""
        self._prepare()
        info = self._ask("hw_req_info", "hw_get_info")
        model = info.model_number.split(b"\0")[0].decode("ascii", "replace")
        if not model.startswith(self.kind.models) or self._serial_number not in (
            "",
            str(info.serial_number),
        ):
            raise Refused(
                f"Expected {' or '.join(self.kind.models)} {self._serial_number} at {self.name}, "
                f"got {model} {info.serial_number}. Check the address."
            )
        return {"model": model, "serial_number": str(info.serial_number)}

    @property
    def position(self) -> float:
        """Position, m or rad."""
        found = self._ask("mot_req_poscounter", "mot_get_poscounter", _CHANNEL)
        return found.position / self.kind.scale

    @property
    def homed(self) -> bool:
        """Whether the home position is known."""
        return bool(self._status().homed)

    def home(self, timeout: float = HOME_TIMEOUT) -> None:
        """Find the home position; the shaft or carriage travels."""
        self._prepare()
        self._send("mot_move_home", _CHANNEL)
        self._wait(timeout, lambda: self.homed and abs(self.position) <= self.kind.tolerance)

    def move_to(self, position: float) -> float:
        """Move to a position, m or rad, and wait; return where it ended.

        Raises
        ------
        ValueError
            If the position is beyond the travel.
        Refused
            If the motor is not homed, or ended elsewhere.
        InstrumentTimeout
            If it takes longer than distance over speed and 2 s; the motor is stopped.
        """
        low, high = self.kind.travel
        if not low <= position <= high:
            raise ValueError(
                f"Expected {low:g} to {high:g} {self.kind.unit} for {self.name}, got "
                f"{position:g}. Stay within the travel."
            )
        if not self.homed:
            raise Refused(f"Expected {self.name} homed before a move, got it not. Home it.")
        speed = self._ask("mot_req_velparams", "mot_get_velparams", _CHANNEL).max_velocity
        seconds = abs(position - self.position) * self.kind.velocity_scale / max(speed, 1)
        self._prepare()
        self._send("mot_move_absolute", _CHANNEL, round(position * self.kind.scale))
        arrived = lambda: abs(self.position - position) <= self.kind.tolerance  # noqa: E731
        self._wait(seconds + 2.0, arrived)
        return self.position

    def stop(self) -> None:
        """Stop at once, and wait for it."""
        self._send("mot_move_stop", _CHANNEL, 1)
        deadline = time.monotonic() + 1.0
        while self._moving(self._status()):
            if time.monotonic() >= deadline:
                raise InstrumentTimeout(
                    f"Expected {self.name} to stop within 1 s, got it moving. Switch it off."
                )
            time.sleep(_POLL)

    def safe_state(self) -> None:
        """Stop."""
        insist(self.stop)

    # --- dialogue ------------------------------------------------------------------------------

    def _prepare(self) -> None:
        """Enable the channel and silence the updates; once a connection."""
        if self._ready:
            return
        self._send("hw_no_flash_programming")
        self._send("hw_stop_updatemsgs")
        self._send("mod_set_chanenablestate", _CHANNEL, 1)
        found = self._ask("mod_req_chanenablestate", "mod_get_chanenablestate", _CHANNEL)
        if not found.enabled:
            raise Refused(f"Expected {self.name} enabled, got it disabled. Enable it by hand.")
        self._ready = True

    def _wait(self, seconds: float, arrived: Any) -> None:
        """Wait until the motor rests where it should; it is stopped before an error is raised."""
        deadline, looks = time.monotonic() + seconds, 0
        while looks < 3:  # at rest three times in a row elsewhere: it did not hear, or was stopped
            status = self._status()
            if errors := [text for name, text in _ERRORS.items() if getattr(status, name)]:
                self.stop()
                raise InstrumentError(
                    f"Expected {self.name} to move freely, got {' and '.join(errors)}. "
                    "Free the stage and home it."
                )
            if not self._moving(status):
                if arrived():
                    return
                looks += 1
            elif time.monotonic() >= deadline:
                self.stop()
                raise InstrumentTimeout(
                    f"Expected {self.name} to arrive within {seconds:.1f} s, got it moving. "
                    "Free the stage."
                )
            time.sleep(_POLL)
        raise Refused(
            f"Expected {self.name} to arrive, got it at rest at {self.position:.6g} "
            f"{self.kind.unit}. Home it and try again."
        )

    def _status(self) -> Any:
        kind = self.kind.status
        return self._ask(f"mot_req_{kind}", f"mot_get_{kind}", _CHANNEL)

    @staticmethod
    def _moving(status: Any) -> bool:
        return any(getattr(status, name) for name in _MOVING)

    def _send(self, message: str, *arguments: int) -> None:
        import thorlabs_apt_protocol as apt

        request = getattr(apt, message)(_UNIT, _HOST, *arguments)
        port_errors(self.name, lambda: self._port.write(request))

    def _ask(self, request: str, reply: str, *arguments: int) -> Any:
        """Reply to a request, asked once more; what comes unasked is passed over."""

        def ask() -> Any:
            self._send(request, *arguments)
            for _ in range(256):
                message = port_errors(self.name, self._next)
                if message.msg == reply:
                    return message
                if message.msg in ("hw_response", "hw_richresponse"):
                    raise Refused(
                        f"Expected {self.name} to obey {request}, got a fault. "
                        "Look at the controller."
                    )
            raise BadReply(f"Expected {reply} of {self.name}, got other messages. Restart it.")

        return self._read(ask)

    def _next(self) -> Any:
        """Next whole message."""
        try:
            for message in self._unpacker:
                return message
            while self._port.in_waiting:  # garbage was dropped; a message may follow it
                for message in self._unpacker:
                    return message
        except (struct.error, AssertionError, KeyError, ValueError):
            raise BadReply(f"Expected a whole message of {self.name}, got garbage.") from None
        raise InstrumentTimeout(
            f"Expected a message of {self.name} in time, got none. Check power and cable."
        )

    def _resynchronise(self) -> None:
        port_errors(self.name, self._port.reset_input_buffer)
        self._unpacker.buf = b""
