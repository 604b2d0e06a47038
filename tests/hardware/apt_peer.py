"""A motor controller in memory that speaks APT, for faults and for the far end of a terminal."""

import struct

from cmtof.hardware.errors import ConnectionLost
from cmtof.hardware.transport.buffered import Buffered

HOMED, ENABLED, MOVING, HOMING = 1 << 10, 1 << 31, 1 << 4, 1 << 9
LIMIT, MOTION_ERROR, CURRENT_LIMIT = 1 << 0, 1 << 14, 1 << 24


def short(id_, first=0, second=0):
    return struct.pack("<HBBBB", id_, first, second, 0x01, 0x50)


def long(id_, form, *values):
    data = struct.pack(form, *values)
    return struct.pack("<HHBB", id_, len(data), 0x81, 0x50) + data


class Motor:
    """State of a controller with one channel.

    A move ends after `looks` questions for the status; faults are plain attributes.
    """

    def __init__(self, *, model=b"KDC101", serial=27000001, stage=8):
        self.model, self.serial, self.stage = model, serial, stage
        self.position = 0
        self.bits = HOMED
        self.looks = 1
        self.left = 0
        self.homing = False
        self.speaks = True
        """Whether ends of moves are announced."""
        self.clamp = None
        self.error = 0
        self.stalls = False
        self.velocity = 1_900_000  # of the order of 2.4 mm/s
        self.enables = True
        self.heard = []

    def feed(self, data):
        """Replies to whole messages."""
        out = b""
        while data:
            id_, length, destination, source = struct.unpack_from("<HHBB", data)
            size = 6 + (length if destination & 0x80 else 0)
            assert (destination & 0x7F, source) == (0x50, 0x01)
            message, data = data[:size], data[size:]
            self.heard.append(id_)
            handler = getattr(self, f"_do_{id_:04x}", None)
            assert handler is not None, f"{id_:#06x}"
            out += handler(message) or b""
        return out

    def _do_0018(self, message): ...
    def _do_0012(self, message): ...

    def _do_0210(self, message):
        if self.enables:
            self.bits |= ENABLED

    def _do_0211(self, message):
        return short(0x0212, 1, 1 if self.bits & ENABLED else 2)

    def _do_0005(self, message):
        return long(
            0x0006, "<I8sH4s48s10sHHHH", self.serial, self.model, 16, bytes([1, 0, 3, 0]),
            b"", b"", self.stage, 1, 0, 1,
        )  # fmt: skip

    def _do_0411(self, message):
        return long(0x0412, "<Hi", 1, self.position)

    def _do_0414(self, message):
        return long(0x0415, "<Hiii", 1, 0, 1000, self.velocity)

    def _do_0429(self, message):
        out = b""
        if self.left and not self.stalls:
            self.left -= 1
            if not self.left:
                out = self._finish()
        return long(0x042A, "<HI", 1, self.bits) + out

    def _do_0453(self, message):
        (self.target,) = struct.unpack_from("<i", message, 8)
        return self._start(MOVING)

    def _do_0443(self, message):
        self.target, self.homing = 0, True
        self.bits &= ~HOMED
        return self._start(HOMING)

    def _start(self, bit):
        if self.clamp is not None:
            self.target = min(self.target, self.clamp)
        self.bits |= bit
        self.left = self.looks
        return b"" if self.looks else self._finish()

    def _finish(self):
        self.bits &= ~(MOVING | HOMING)
        if self.error:
            self.bits |= self.error
            return b""
        self.position = self.target
        homed, self.homing = self.homing, False
        if homed:
            self.bits |= HOMED
            return short(0x0444, 1) if self.speaks else b""
        return self.status(0x0464) if self.speaks else b""

    def _do_0465(self, message):
        self.bits &= ~(MOVING | HOMING)
        self.left = 0
        return self.status(0x0466)

    def status(self, id_):
        return long(id_, "<HihHI", 1, self.position, 0, 0, self.bits)


class MotorLine(Buffered):
    """A line in memory to a `Motor`.

    Attributes
    ----------
    before : bytes
        Sent before the next reply.
    cut : int
        So many replies lose their second half.
    silences : int
        So many messages are not heard.
    """

    def __init__(self, motor):
        super().__init__()
        self.motor = motor
        self.waiting = []
        self.before = b""
        self.cut = self.silences = self.reconnects = 0
        self.lost = False

    def _receive(self, timeout):
        if self.lost:
            raise ConnectionLost("Expected an open line, got a closed one. Reconnect.")
        return self.waiting.pop(0) if self.waiting else b""

    def write(self, data):
        if self.lost:
            raise ConnectionLost("Expected an open line, got a closed one. Reconnect.")
        if self.silences:
            self.silences -= 1
            return
        reply = self.motor.feed(data)
        if reply and self.cut:
            self.cut -= 1
            reply = reply[: len(reply) // 2]
        before, self.before = self.before, b""
        if before + reply:
            self.waiting.append(before + reply)

    def reconnect(self):
        self._arrived.clear()
        self.waiting.clear()
        self.lost = False
        self.reconnects += 1
