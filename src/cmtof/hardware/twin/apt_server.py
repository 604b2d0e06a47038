"""Simulated Thorlabs motors: KDC101 with MTS50-Z8 or PRM1-Z8, and K10CR1, over the APT protocol.

Written from «Thorlabs Motion Controllers Host-Controller Communications Protocol» as public
drivers quote it (pylablib, InstrumentKit, yaq); what no source stated is marked «not verified».
Everything is little-endian. Short messages are ``<HBBBB`` id, parameter 1, parameter 2,
destination, source; long ones ``<HHBB`` id, length, destination | 0x80, source, then the data.

A move takes its time on the virtual clock (`Panel.time`) and a small part of it on the wall clock,
so that a motor can be asked and stopped while it moves.
"""

import struct
import time
from collections.abc import Callable, Iterable

from cmtof.hardware.twin.apt_motion import ENABLED, REVERSE, Motion
from cmtof.hardware.twin.apt_motors import MOTORS
from cmtof.hardware.twin.faults import Watch
from cmtof.hardware.twin.lines import Channel
from cmtof.instrument.panel import Panel

_HOST, _UNIT, _LONG = 0x01, 0x50, 0x80
_ADDRESSES = (0x11, 0x21, 0x50)  # motherboard, bay 1, generic USB unit
_CHANNEL = 1
_PARTIAL_TIMEOUT = 0.05  # a message that stays incomplete so long is given up, s; not verified
_UPDATE_PERIOD = 0.1  # of the status messages that START_UPDATEMSGS asks for, s
_UNACKNOWLEDGED = 50  # status messages that are sent without an acknowledgement; not verified

Replies = Iterable[bytes]


class AptServer:
    """One motor with its controller.

    Parameters
    ----------
    panel : Panel
    motor : str
        One of `apt_motors.MOTORS`.
    place : str
        What it moves: "plate_emission", "plate_detection" or "stage".
    watch : Watch
        Faults of this device.
    pace : float
        Wall-clock seconds for one virtual second of a move.

    Raises
    ------
    ValueError
        If the motor is not known.
    """

    def __init__(
        self, panel: Panel, motor: str, place: str, watch: Watch, *, pace: float = 0.01
    ) -> None:
        if motor not in MOTORS:
            raise ValueError(f"Expected a motor in {', '.join(MOTORS)}, got {motor!r}. Choose one.")
        self._panel, self._watch = panel, watch
        self._motion = Motion(panel, MOTORS[motor], place, watch, pace)
        self._least_velocity = 0
        self._homing = (2, 1, self._motion.velocity // 2, 0)  # direction, switch, speed, offset
        self._relative = self._absolute = 0
        self._reports = True
        self._next_update: float | None = None
        self._unacknowledged = 0
        self._handlers = self._table()

    def serve(self, channel: Channel) -> None:
        """Talk to one client until it has gone."""
        rest, arrived = b"", 0.0
        while (data := channel.receive(self._patience(arrived if rest else None))) != b"":
            now = time.monotonic()
            if data:
                rest, arrived = rest + data, now
            elif rest and now >= arrived + _PARTIAL_TIMEOUT:
                rest = rest[1:]  # the head of a message that never came: look behind it
            for message in list(self._due(now)):
                channel.send(message)
            rest = self._read(rest, channel)

    def _patience(self, arrived: float | None) -> float | None:
        """Time until something happens by itself, s."""
        moments = [] if arrived is None else [arrived + _PARTIAL_TIMEOUT]
        if self._motion.move is not None:
            moments.append(self._motion.move.ends)
        if self._next_update is not None:
            moments.append(self._next_update)
        return max(0.0, min(moments) - time.monotonic()) if moments else None

    def _due(self, now: float) -> Replies:
        """Messages that nobody asked for."""
        with self._panel.lock:
            finished = self._motion.finish()
            if finished is not None and self._reports:
                yield _short(0x0444, _CHANNEL) if finished.homing else self._status(0x0464)
            if self._next_update is not None and now >= self._next_update:
                self._next_update = now + _UPDATE_PERIOD
                self._unacknowledged += 1
                if self._unacknowledged <= _UNACKNOWLEDGED:
                    yield self._status(0x0491)

    def _read(self, buffer: bytes, channel: Channel) -> bytes:
        """Answer every whole message; what may be the beginning of one is left."""
        while len(buffer) >= 6:
            size = self._size(buffer)
            if size == 0:
                buffer = buffer[1:]  # not the head of a message: out of step
            elif len(buffer) < size:
                return buffer
            else:
                self._answer(buffer[:size], channel)
                buffer = buffer[size:]
        return buffer

    def _size(self, buffer: bytes) -> int:
        """Length of the message that begins here, 0 if none does."""
        ident, length, destination, source = struct.unpack_from("<HHBB", buffer)
        known = ident in self._handlers and source == _HOST
        if not known or destination & ~_LONG not in _ADDRESSES:
            return 0
        length = length or -1 if destination & _LONG else 0
        return 6 + length if length in self._handlers[ident][0] else 0

    def _answer(self, message: bytes, channel: Channel) -> None:
        trouble = self._watch.next()
        if trouble.unheard:
            trouble.deliver(channel, b"")
            return
        arguments = message[6:] if message[4] & _LONG else message[2:4]
        _, of_channel, handler = self._handlers[struct.unpack_from("<H", message)[0]]
        if of_channel and arguments[0] != _CHANNEL:
            return  # there is one channel only
        with self._panel.lock:
            replies = list(handler(arguments))
        for reply in replies:
            trouble.deliver(channel, reply)

    def _table(self) -> dict[int, tuple[tuple[int, ...], bool, Callable[[bytes], Replies]]]:
        """Per message: lengths of its data (0: short), whether it names the channel, handler."""
        short, motion = (0,), self._motion
        return {
            0x0002: (short, False, _nothing),  # HW_DISCONNECT
            0x0005: (short, False, self._info),
            0x0011: (short, False, self._start_updates),
            0x0012: (short, False, self._stop_updates),
            0x0017: (short, False, _nothing),  # HW_YES_FLASH_PROGRAMMING
            0x0018: (short, False, _nothing),  # HW_NO_FLASH_PROGRAMMING
            0x0210: (short, True, self._enable),
            0x0211: (short, True, self._enabled),
            0x0223: (short, False, _nothing),  # MOD_IDENTIFY: a light blinks
            0x040A: (short, True, lambda a: [_counts(0x040B, motion.position())]),
            0x0410: ((6,), True, self._set_counter),
            0x0411: (short, True, lambda a: [_counts(0x0412, motion.position())]),
            0x0413: ((14,), True, self._set_velocity),
            0x0414: (short, True, self._velocity),
            0x0429: (short, True, lambda a: [_long(0x042A, "<HI", _CHANNEL, motion.bits)]),
            0x0440: ((14,), True, self._set_homing),
            0x0441: (short, True, lambda a: [_long(0x0442, "<HHHii", _CHANNEL, *self._homing)]),
            0x0443: (short, True, self._home),
            0x0445: ((6,), True, self._set_relative),
            0x0446: (short, True, lambda a: [_counts(0x0447, self._relative)]),
            0x0448: ((0, 6), True, self._move_relative),
            0x0450: ((6,), True, self._set_absolute),
            0x0451: (short, True, lambda a: [_counts(0x0452, self._absolute)]),
            0x0453: ((0, 6), True, self._move_absolute),
            0x0465: (short, True, self._stop),
            0x046B: (short, False, self._suspend_reports),
            0x046C: (short, False, self._resume_reports),
            0x0480: (short, True, self._stepper_status),
            0x0490: (short, True, lambda a: [self._status(0x0491)]),
            0x0492: (short, False, self._acknowledge),
        }

    def _info(self, arguments: bytes) -> Replies:
        """HW_GET_INFO: 84 bytes; the stage's number stands at [76:78] (pylablib, kinesis.py)."""
        motor = self._motion.motor
        head = (motor.serial, motor.controller.encode(), 16)  # hardware type: not verified
        firmware = bytes([1, 0, 3, 0])  # 3.0.1: not verified
        tail = (motor.stage, 1, 0, 1)  # hardware version, modification, channels
        yield _long(0x0006, "<I8sH4s48s10sHHHH", *head, firmware, b"simulated", b"", *tail)

    def _start_updates(self, arguments: bytes) -> Replies:
        self._next_update, self._unacknowledged = time.monotonic() + _UPDATE_PERIOD, 0
        return ()

    def _stop_updates(self, arguments: bytes) -> Replies:
        self._next_update = None
        return ()

    def _acknowledge(self, arguments: bytes) -> Replies:
        self._unacknowledged = 0
        return ()

    def _suspend_reports(self, arguments: bytes) -> Replies:
        self._reports = False
        return ()

    def _resume_reports(self, arguments: bytes) -> Replies:
        self._reports = True
        return ()

    def _enable(self, arguments: bytes) -> Replies:
        if arguments[1] in (1, 2) and not self._watch.takes("ignore"):
            bits = self._motion.bits & ~ENABLED
            self._motion.bits = bits | ENABLED if arguments[1] == 1 else bits
        return ()

    def _enabled(self, arguments: bytes) -> Replies:
        yield _short(0x0212, _CHANNEL, 1 if self._motion.bits & ENABLED else 2)

    def _set_counter(self, arguments: bytes) -> Replies:
        if not self._watch.takes("ignore"):
            self._motion.set_counter(_int(arguments))
        return ()

    def _set_velocity(self, arguments: bytes) -> Replies:
        """SET_VELPARAMS; what the motor cannot do is clamped without a word, 0 is not taken."""
        least, acceleration, most = struct.unpack("<Hiii", arguments)[1:]
        motor = self._motion.motor
        if acceleration > 0 and most > 0 and not self._watch.takes("ignore"):
            limit = motor.velocity_counts
            most = round(self._watch.pulled(min(most, limit), 0, limit))
            self._motion.velocity = max(1, most)
            self._motion.acceleration = min(acceleration, motor.acceleration_counts)
            self._least_velocity = least
        return ()

    def _velocity(self, arguments: bytes) -> Replies:
        motion = self._motion
        values = (self._least_velocity, motion.acceleration, motion.velocity)
        yield _long(0x0415, "<Hiii", _CHANNEL, *values)

    def _set_homing(self, arguments: bytes) -> Replies:
        if not self._watch.takes("ignore"):
            self._homing = struct.unpack("<HHHii", arguments)[1:]
        return ()

    def _home(self, arguments: bytes) -> Replies:
        self._motion.home()
        return ()

    def _set_relative(self, arguments: bytes) -> Replies:
        self._relative = _int(arguments)
        return ()

    def _set_absolute(self, arguments: bytes) -> Replies:
        self._absolute = _int(arguments)
        return ()

    def _move_relative(self, arguments: bytes) -> Replies:
        if len(arguments) == 6:
            self._relative = _int(arguments)
        self._motion.go(self._motion.position() + self._relative)
        return ()

    def _move_absolute(self, arguments: bytes) -> Replies:
        if len(arguments) == 6:
            self._absolute = _int(arguments)
        self._motion.go(self._absolute)
        return ()

    def _stop(self, arguments: bytes) -> Replies:
        """MOVE_STOP, at once (1) or on a ramp (2): the way of the ramp is not simulated."""
        self._motion.stop()
        yield self._status(0x0466)

    def _stepper_status(self, arguments: bytes) -> Replies:
        position = self._motion.position()
        yield _long(0x0481, "<HiiI", _CHANNEL, position, position, self._motion.bits)

    def _status(self, ident: int) -> bytes:
        """DC status: channel, position, velocity (0 at rest), reserved, status bits."""
        motion = self._motion
        speed = 0 if motion.move is None else min(0x7FFF, motion.velocity >> 16)
        velocity = -speed if motion.bits & REVERSE else speed
        return _long(ident, "<HihHI", _CHANNEL, motion.position(), velocity, 0, motion.bits)


def _nothing(arguments: bytes) -> Replies:
    return ()


def _int(arguments: bytes) -> int:
    """The number behind the channel."""
    return struct.unpack("<Hi", arguments)[1]


def _short(ident: int, first: int = 0, second: int = 0) -> bytes:
    return struct.pack("<HBBBB", ident, first, second, _HOST, _UNIT)


def _counts(ident: int, counts: int) -> bytes:
    return _long(ident, "<Hi", _CHANNEL, counts)


def _long(ident: int, form: str, *values: object) -> bytes:
    data = struct.pack(form, *values)
    return struct.pack("<HHBB", ident, len(data), _HOST | _LONG, _UNIT) + data
