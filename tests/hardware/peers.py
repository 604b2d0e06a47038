"""Other ends for the drivers: small models of the devices, behind wires that can fail."""

import io
import struct
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import serial
from pyvisa import VisaIOError
from pyvisa.constants import StatusCode

from cmtof.hardware.rf import framed
from cmtof.hardware.roles import RfStatus


class Wire:
    """Requests to a model; those that hold ``marker`` meet a fault, so many times."""

    def __init__(self, answer):
        self.answer = answer
        self.sent = []
        self.fail(b"", b"", times=0)

    def fail(self, marker, fault, times=10**9):
        self.marker = marker
        self.fault = fault
        self.times = times

    def __call__(self, request):
        self.sent.append(request)
        if not self.times or self.marker not in request:
            return self.answer(request)
        self.times -= 1
        if isinstance(self.fault, Exception):
            raise self.fault
        return self.fault


class Port:
    """A serial port on pyserial's ``loop://``: what is written is answered by a function at once.

    So nothing waits for it, whatever ``timeout`` a driver sets.
    """

    def __init__(self, answer=lambda data: data):
        self._loop = serial.serial_for_url("loop://", timeout=0)
        self._answer = answer

    def write(self, data):
        self._loop.write(self._answer(data))

    def read_until(self, end, size):
        line = b""
        while not line.endswith(end) and len(line) < size and (byte := self._loop.read(1)):
            line += byte
        return line

    def __getattr__(self, name):
        return getattr(self._loop, name)


class Visa:
    """A VISA resource: what is written is answered by a function of bytes."""

    timeout = 0.0

    def __init__(self, answer):
        self._answer = answer
        self.lines = []

    def write(self, text):
        self.lines += self._answer(text.encode()).decode().splitlines()

    def read(self):
        if not self.lines:
            raise VisaIOError(StatusCode.error_timeout)
        return self.lines.pop(0)

    def close(self):
        self.lines = []


def modbus(answer):
    """A connection to a T7 in process: function 76 is answered by a function."""
    return SimpleNamespace(ask=answer, close=lambda: None)


@contextmanager
def dialogue(kind, *pairs):
    """Port or resource that holds one dialogue of (sent, reply), and no other."""
    heard = []
    replies = [reply for _, reply in pairs]

    def answer(request):
        heard.append(request)
        return replies.pop(0) if replies else b""

    yield kind(answer)
    assert heard == [sent for sent, _ in pairs]


class Firmware:
    """An RF driver's firmware: numbers and switches by word, lock, table."""

    model = "CMTOF-RF"
    locked = True

    def __init__(self):
        self.values = {"RF": "OFF"}

    def __call__(self, line):
        head, word, *arguments = line.decode().rpartition("*")[0].split()
        return framed(f"<{head[1:]} {self.obey(word, arguments)}".strip())

    def obey(self, word, arguments):
        """Answer to a request."""
        if word == "SAFE":
            self.values["RF"] = "OFF"
        if arguments:
            self.codes = [int(code) for code in arguments[1:]]
            self.values[word] = arguments[0]
        status = " ".join(str(int(value)) for value in self.status())
        replies = self.values | {"ID?": f"{self.model},R0001,1.2", "STAT?": status}
        return f"OK {replies.get(word, '')}"

    def status(self):
        """State as `RfStatus` has it."""
        on = self.values["RF"] == "ON"
        return RfStatus(on, self.locked and on, 0, 16, tripped=False)


HOMED = 1 << 10
MOVING = 1 << 4
ERROR = 1 << 14


class Controller:
    """A KDC101: position, status bits, and messages that come unasked."""

    model = b"KDC101"
    serial = 27000001

    def __init__(self):
        self.position = 0
        self.status = HOMED | 1 << 31
        self.looks = 0
        self.deaf = False
        self.moves = []
        # direction, limit switch, velocity, offset; least velocity, acceleration, largest velocity
        self.home_parameters = (2, 1, 5, 0)
        self.velocities = (0, 1, 5)

    def __call__(self, data):
        (number,) = struct.unpack_from("<H", data)
        info = (self.serial, self.model, 16, 1, 1, 1, 1, b"", 1, 1, 1)
        moving = MOVING if self.looks else 0
        self.looks -= bool(self.looks and number in (0x0480, 0x0490))
        answers = {
            0x0005: (0x0006, "<l8sH4B60sHHH", *info),
            0x0411: (0x0412, "<Hl", 1, self.position),
            0x0441: (0x0442, "<3Hll", 1, *self.home_parameters),
            0x0414: (0x0415, "<H3l", 1, *self.velocities),
            0x0490: (0x0491, "<HlhHL", 1, self.position, 0, 0, self.status | moving),
            0x0480: (0x0481, "<HllL", 1, self.position, 0, self.status | moving),
        }
        if number in (0x0443, 0x0453):
            self.status |= HOMED * (number == 0x0443)
            self.go(struct.unpack_from("<Hl", data, 6)[1] if number == 0x0453 else 0)
            return struct.pack("<HBBBB", 0x0464, 1, 0, 0x01, 0x50)  # comes unasked
        if number == 0x0440:
            self.home_parameters = struct.unpack_from("<HHll", data, 8)
        if number == 0x0413:
            self.velocities = struct.unpack_from("<3l", data, 8)
        if number == 0x0465:
            self.looks = 0
        if number not in answers:
            return b""
        reply, layout, *values = answers[number]
        body = struct.pack(layout, *values)
        return struct.pack("<HHBB", reply, len(body), 0x81, 0x50) + body

    def go(self, goal):
        """Move to a position, counts."""
        self.moves.append(goal)
        if not self.deaf:
            self.position = goal
            self.looks = max(self.looks, 1)


class T7:
    """Registers of a T7, function 76, and a burst's packets on ``stream``; a burst may fail."""

    def __init__(self):
        self.memory = bytearray(2 * 65536)
        self.written = []
        self.fault = ""
        self.outputs = set()
        self.power_up = {}
        self.stream = Port()
        self.set(2007, "H", 1)
        self.set(60000, "f", 7.0)  # PRODUCT_ID
        self.set(60004, "f", 1.0292)  # FIRMWARE_VERSION
        self.set(60028, "I", 470010001)  # SERIAL_NUMBER
        self.set(61812, "fff", 3.16e-4, -3.16e-4, 33520.0)  # INTERNAL_FLASH_READ

    def set(self, address, kind, *values):
        """Set registers from an address on."""
        struct.pack_into(f">{kind}", self.memory, 2 * address, *values)

    def get(self, address, kind="I"):
        """Value of a register."""
        return struct.unpack_from(f">{kind}", self.memory, 2 * address)[0]

    @property
    def levels(self):
        """Bits of the digital lines."""
        return self.get(2500, "H")

    def cycle_power(self):
        """Switch off and on: lines are inputs, pulled high, unless others are saved."""
        self.outputs = set(self.power_up)
        self.set(2500, "H", sum(self.power_up.get(line, 1) << line for line in range(8)))

    def __call__(self, frame):
        if self.fault == "refuse" and frame[1:3] != b"\xd6\xd8":
            raise LookupError(2603)
        reply = b""
        rest = io.BytesIO(frame)
        while head := rest.read(4):
            writes, address, count = struct.unpack(">BHB", head)
            if writes:
                self.write(address, rest.read(2 * count))
            else:
                reply += self.memory[2 * address : 2 * (address + count)]
        return reply

    def write(self, address, data):
        self.memory[2 * address : 2 * address + len(data)] = data
        self.written.append((address, data))
        if 2000 <= address < 2008:
            line = address - 2000
            self.outputs.add(line)
            others = self.levels & ~(1 << line)
            self.set(2500, "H", others | self.get(address, "H") << line)
        elif address == 49002:
            self.power_up = {line: self.get(2000 + line, "H") for line in self.outputs}
        elif address == 4990 and any(data):
            self.set(4494, "I", self.get(4002))
            self._send_burst()

    def counts(self):
        """A ramp that starts at the label of the burst."""
        return np.arange(self.get(4020)) + self.get(46100)

    def _send_burst(self):
        """Packets of a burst."""
        scans = self.get(4020)
        size = self.get(4006)
        counts = self.counts().astype(">u2")
        fault = self.fault
        self.fault = ""
        for n, start in enumerate(range(0, scans, size)):
            part = counts[start : start + size].tobytes()
            status = 2944 if start + size >= scans else 0
            number = n
            if n and fault == "short":
                return
            if n and fault == "skipped":
                status = 2941
            if n and fault == "lost":
                number += 1
            head = struct.pack(">HHHBBBBHHH", number, 0, 10 + len(part), 1, 76, 16, 0, 0, status, 0)
            self.stream.write(head + part)
