"""Models of the devices, each on a simulated one, and connections in process that can fail."""

import io
import math
import struct
import time
from types import SimpleNamespace

import numpy as np
import serial
from pyvisa import VisaIOError
from pyvisa.constants import StatusCode
from registers import ACCESS

from cmtof.correlation import TAU
from cmtof.hardware.apt import MOTORS
from cmtof.hardware.rf import CODES, line_with_checksum
from cmtof.hardware.rig import LINES, Rig
from cmtof_lab.rehearsal import simulated_bench

HOMED = 1 << 10
MOVING = 1 << 4
ERROR = 1 << 14
OUTPUTS = {30004: "TDAC2", 30006: "TDAC3", 1000: "DAC0"}


def simulated(role):
    """A device of an instrument that is switched off."""
    return simulated_bench(Rig.default()).devices[role]


# --- connections ---------------------------------------------------------------------------------


class Wire:
    """Requests to a model; those that hold ``marker`` meet a fault, so many times.

    Unless it is told how many, it meets every request from the first of these on.
    """

    def __init__(self, answer):
        self.answer = answer
        self.sent = []
        self.fail(b"", b"", times=0)

    def fail(self, marker, fault, times=math.inf):
        self.marker = marker
        self.fault = fault
        self.times = times

    def __call__(self, request):
        self.sent.append(request)
        if not self.times or self.marker not in request:
            return self.answer(request)
        self.times -= 1
        if self.times == math.inf:
            self.marker = b""
        if isinstance(self.fault, Exception):
            raise self.fault
        return self.fault


class Port:
    """A serial port on pyserial's ``loop://``: what is written is answered by a function at once.

    So nothing waits long for it, whatever ``timeout`` a driver sets.
    """

    def __init__(self, answer=lambda data: data, timeout=0.1):
        self._loop = serial.serial_for_url("loop://", timeout=timeout)
        self._answer = answer

    def write(self, data):
        self._loop.write(self._answer(data))

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


# --- models --------------------------------------------------------------------------------------


class Firmware:
    """An RF driver as the guide describes it, with its dead man's timer."""

    model = "CMTOF-RF"

    def __init__(self, device, clock=time.monotonic):
        self.device = device
        self.clock = clock
        self.heard = clock()
        self.dead_man = 5.0
        self.tripped = False

    def look(self):
        """Trip when the host has been silent for too long."""
        if self.device.knobs.on and self.clock() - self.heard > self.dead_man:
            self.device.output(False)
            self.tripped = True

    def __call__(self, line):
        self.look()
        self.heard = self.clock()
        head, word, *arguments = line.decode().rpartition("*")[0].split()
        return line_with_checksum(f"<{head[1:]} {self.obey(word, *arguments)}".strip())

    def obey(self, word, *arguments):
        """Answer to a request."""
        rf = self.device
        match word:
            case "ID?":
                return f"OK {self.model},R0001,1.2"
            case "STAT?":
                status = rf.status()._replace(tripped=self.tripped)
                return "OK " + " ".join(str(int(value)) for value in status)
            case "LOCK?":
                return "OK {:d} {} {}".format(*rf.lock())
            case "RF" if self.tripped and arguments == ("ON",):
                return "ERR TRIPPED CLR first"
            case "RF" | "TRIG":
                {"RF": rf.output, "TRIG": rf.trigger}[word](arguments == ("ON",))
            case "FREQ" | "POWR":
                {"FREQ": rf.set_frequency, "POWR": rf.set_power}[word](
                    float(*arguments)
                )
            case "PHAS":
                rf.set_phase(*turned(arguments))
            case "TABL":
                rf.load_table(turned(arguments[1:]))
            case "ARM" | "SAFE":
                {"ARM": rf.arm, "SAFE": rf.safe_state}[word]()
            case "DEAD":
                self.dead_man = float(*arguments)
            case "CLR":
                self.tripped = False
        return " ".join(["OK", *arguments[:1]])


def turned(codes):
    """Phases, rad, of codes."""
    return np.array(codes, int) * TAU / CODES


class Controller:
    """An APT controller; ``slow`` moves take so many looks at its status."""

    serial = 27000001

    def __init__(self, device, driver="mts50-z8", homed=False, clock=None):
        kind = MOTORS[driver]
        self.device = device
        self.scale = kind.scale / kind.unit
        self.model = f"{kind.models[0]}1".encode()
        self.status = HOMED * homed | 1 << 31
        self.looks = 0
        self.slow = iter(())
        self.deaf = False
        self.moves = []
        # direction, limit switch, velocity, offset; least velocity, acceleration, largest velocity
        self.home_parameters = (2, 1, 5, 0)
        self.velocities = (0, 1, 5)

    def __call__(self, data):
        (number,) = struct.unpack_from("<H", data)
        info = (self.serial, self.model, 16, 1, 1, 1, 1, b"", 1, 1, 1)
        position = round(self.device.position * self.scale)
        status = self.status | MOVING * bool(self.looks)
        self.looks -= bool(self.looks and number in (0x0480, 0x0490))
        answers = {
            0x0005: (0x0006, "<l8sH4B60sHHH", *info),
            0x0411: (0x0412, "<Hl", 1, position),
            0x0441: (0x0442, "<3Hll", 1, *self.home_parameters),
            0x0414: (0x0415, "<H3l", 1, *self.velocities),
            0x0480: (0x0481, "<HllL", 1, position, 0, status),
            0x0490: (0x0491, "<HlhHL", 1, position, 0, 0, status),
        }
        match number:
            case 0x0443:
                self.status |= HOMED
                return self.go(0)
            case 0x0453:
                return self.go(struct.unpack_from("<l", data, 8)[0])
            case 0x0440:
                self.home_parameters = struct.unpack_from("<HHll", data, 8)
            case 0x0413:
                self.velocities = struct.unpack_from("<3l", data, 8)
            case 0x0465:
                self.looks = 0
        if number not in answers:
            return b""
        reply, layout, *values = answers[number]
        body = struct.pack(layout, *values)
        return struct.pack("<HHBB", reply, len(body), 0x81, 0x50) + body

    def go(self, goal):
        """Move to a position, counts; that it has been reached comes unasked."""
        self.moves.append(goal)
        if not self.deaf:
            self.device.move_to(goal / self.scale)
            self.looks = max(self.looks, next(self.slow, 1))
        return struct.pack("<HBBBB", 0x0464, 1, 0, 0x01, 0x50)


class T7:
    """Registers of a T7, function 76, its watchdog, and a burst's packets on ``stream``."""

    def __init__(self, device, clock=time.monotonic):
        self.device = device
        self.clock = clock
        self.heard = clock()
        self.memory = bytearray(2 * 65536)
        self.written = []
        self.fault = ""  # of the next burst
        self.outputs = set()
        self.power_up = {}
        self.turning = []  # flip mirror: when, line and level
        self.flip_time = 0.0
        self.stream = Port(timeout=0)
        self.set(60000, "f", 7.0)  # PRODUCT_ID
        self.set(60004, "f", 1.0292)  # FIRMWARE_VERSION
        self.set(60028, "I", 470010001)  # SERIAL_NUMBER
        self.set(61812, "fff", *device.gain())  # INTERNAL_FLASH_READ

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

    def look(self):
        """Let the watchdog act, and the flip mirror arrive."""
        if self.get(61600) and self.clock() - self.heard > self.get(61604):
            for line in range(8):
                if not self.get(61636) >> line & 1:  # not inhibited
                    self.write(2000 + line, b"\0\0")
        while self.turning and self.turning[0][0] <= self.clock():
            self.device.set_line(*self.turning.pop(0)[1:])

    def cycle_power(self):
        """Switch off and on: lines are inputs, pulled high, unless others are saved."""
        self.outputs = set(self.power_up)
        self.set(
            2500, "H", sum(self.power_up.get(line, 1) << line for line in range(8))
        )
        for line in range(8):
            self.device.set_line(f"FIO{line}", bool(self.levels >> line & 1))

    def __call__(self, frame):
        self.look()
        self.heard = self.clock()
        self.set(2007, "H", self.device.line(LINES["interlock"]))
        reply = b""
        rest = io.BytesIO(frame)
        while head := rest.read(4):
            writes, address, count = struct.unpack(">BHB", head)
            if "RW"[writes] not in ACCESS.get(address, ""):
                raise LookupError(2501)  # a code of the maker
            if writes:
                self.write(address, rest.read(2 * count))
            else:
                reply += self.memory[2 * address : 2 * (address + count)]
        return reply

    def write(self, address, data):
        self.memory[2 * address : 2 * address + len(data)] = data
        self.written.append((address, data))
        if 2000 <= address < 2008:
            self.drive(address - 2000, any(data))
        elif address in OUTPUTS:
            self.device.write_many({OUTPUTS[address]: self.get(address, "f")})
        elif address == 49002:
            self.power_up = {line: self.get(2000 + line, "H") for line in self.outputs}
        elif address == 4002:
            self.set(4494, "f", self.get(4002, "f"))
        elif address == 4990 and any(data):
            self.send_burst()

    def drive(self, number, high):
        """Make a line an output at a level; the flip mirror takes its time."""
        line = f"FIO{number}"
        self.outputs.add(number)
        self.set(2500, "H", self.levels & ~(1 << number) | high << number)
        if line == LINES["flip_mirror"]:
            self.turning.append((self.clock() + self.flip_time, line, high))
        else:
            self.device.set_line(line, high)

    def send_burst(self):
        """Send the packets of a burst."""
        size = self.get(4006)
        places = range(4102, 4100 + 2 * self.get(4004), 2)
        self.device.configure_burst(
            channels=[f"AIN{self.get(place) // 2}" for place in places],
            rate=self.get(4002, "f"),
            scans=self.get(4020),
            pulse_line="FIO4",
            pulse=self.get(4060),
        )
        (counts,) = self.device.bursts([{"USER_RAM0_U32": self.get(46100)}])
        parts = np.split(counts.astype(">u2"), range(size, counts.size, size))
        fault = ""
        for n, part in enumerate(parts):
            if fault == "short":
                break
            status = 2944 if part is parts[-1] else 0
            if fault == "skipped":
                status = 2941
            number = n + (fault == "lost")
            head = struct.pack(
                ">HHHBBBBHHH", number, 0, 10 + part.nbytes, 1, 76, 16, 0, 0, status, 0
            )
            self.stream.write(head + part.tobytes())
            fault = self.fault  # from the second packet on
        self.fault = ""
