"""The other ends of a rig's wires: sockets and pseudo-terminals before a simulated instrument.

Each model speaks its device's protocol and turns the knobs of one panel. All have one clock, which
can be put forward, so that nobody waits for a watchdog, a dead man or a slow part.
"""

import json
import os
import socketserver
import struct
import threading
import time
import tty
from contextlib import suppress
from dataclasses import asdict, replace
from types import SimpleNamespace

import numpy as np
from peers import HOMED, T7, Controller, Firmware, Wire

from cmtof.correlation import TAU
from cmtof.hardware.apt import MOTORS
from cmtof.hardware.rf import CODES
from cmtof.hardware.rig import LINES
from cmtof_lab.rehearsal import simulated_bench

# --- wires ---------------------------------------------------------------------------------------


def whole_line(data):
    """Length of the first line of text, 0 if it is not whole."""
    return data.find(b"\n") + 1


def whole_message(data):
    """Length of the first APT message."""
    return 6 + struct.unpack_from("<H", data, 2)[0] * (data[4] >> 7) if len(data) > 5 else 0


def whole_frame(data):
    """Length of the first Modbus frame."""
    return 6 + struct.unpack_from(">H", data, 4)[0] if len(data) > 5 else 0


def served(read, write, whole, wire):
    """Answer requests until the host goes, or a fault hangs up."""
    data = b""
    with suppress(OSError):
        while part := read(4096):
            data += part
            while 0 < (size := whole(data)) <= len(data):
                write(wire(data[:size]))
                data = data[size:]


class Terminal:
    """A pseudo-terminal whose far end answers."""

    def __init__(self, whole, model):
        self.wire = Wire(model)
        primary, secondary = os.openpty()
        tty.setraw(secondary)
        self.address = os.ttyname(secondary)
        self._near = os.fdopen(primary, "r+b", buffering=0)
        self._far = os.fdopen(secondary, "r+b", buffering=0)
        threading.Thread(target=self._serve, args=(whole,), daemon=True).start()

    def _serve(self, whole):
        served(self._near.read, self._near.write, whole, self.wire)
        self.close()
        self._near.close()

    def close(self):
        """Leave the port: when the host leaves it, too, nobody is there."""
        self._far.close()


class Server:
    """A TCP server whose connections are answered."""

    form = "{}:{}"

    def __init__(self, whole, model, port=0):
        self.wire = Wire(model)
        self._whole = whole
        handle = lambda client, *_: self.handle(client)  # noqa: E731
        self._server = socketserver.ThreadingTCPServer(("127.0.0.1", port), handle)
        self._server.daemon_threads = True
        self.address = self.form.format(*self._server.server_address)
        threading.Thread(target=self._server.serve_forever, args=(0.01,), daemon=True).start()

    def handle(self, client):
        """Serve a connection."""
        served(client.recv, client.sendall, self._whole, self.wire)

    def close(self):
        self._server.shutdown()
        self._server.server_close()


class Visa(Server):
    """A server whose address is that of a VISA resource."""

    form = "TCPIP::{}::{}::SOCKET"


class Network(Server):
    """A T7: function 76 on one port, packets of the stream on that 200 above."""

    def __init__(self, model):
        self._model = model
        for port in range(20_000 + os.getpid() % 10_000, 60_000):
            with suppress(OSError):
                self._stream = Stream(whole_line, model, port + 200)
                super().__init__(whole_frame, self._answer, port)
                return

    def _answer(self, frame):
        number, _, _, unit, function = struct.unpack_from(">HHHBB", frame)
        try:
            body = self._model(frame[8:])
        except LookupError as refusal:  # with LabJack's own code of its cause
            self._model.set(55000, "H", *refusal.args)
            body = b"\6"
            function |= 0x80
        return struct.pack(">HHHBB", number, 0, len(body) + 2, unit, function) + body

    def close(self):
        self._stream.close()
        super().close()


class Stream(Server):
    """The port of a T7's packets."""

    def handle(self, client):
        self.wire.answer.stream = SimpleNamespace(write=client.sendall)
        client.recv(1)  # until the other end closes


# --- models --------------------------------------------------------------------------------------


class Clock:
    """Time of all devices, s, which can be put forward."""

    passed = 0.0

    def __call__(self):
        return time.monotonic() + self.passed

    def pass_by(self, seconds):
        self.passed += seconds


class RfPeer(Firmware):
    """An RF driver with its dead man's timer."""

    def __init__(self, device, clock):
        super().__init__()
        self.device = device
        self.clock = clock
        self.heard = clock()
        self.tripped = False

    def look(self):
        """Trip when the host has been silent for too long."""
        if self.device.knobs.on and self.clock() - self.heard > float(self.values.get("DEAD", 5)):
            self.device.output(False)
            self.tripped = True

    def obey(self, word, arguments):
        self.look()
        self.heard = self.clock()
        if word == "RF" and arguments == ["ON"] and self.tripped:
            return "ERR TRIPPED CLR first"
        self.tripped &= word != "CLR"
        if word in WORDS:
            WORDS[word](self.device, *arguments)
        return super().obey(word, arguments)

    def status(self):
        return self.device.status()._replace(tripped=self.tripped)


def turned(*codes):
    """Phases, rad, of codes."""
    return np.array(codes, int) * TAU / CODES


WORDS = {
    "FREQ": lambda rf, hz: rf.set_frequency(float(hz)),
    "POWR": lambda rf, dbm: rf.set_power(float(dbm)),
    "PHAS": lambda rf, code: rf.set_phase(turned(code)[0]),
    "RF": lambda rf, word: rf.output(word == "ON"),
    "TRIG": lambda rf, word: rf.trigger(word == "ON"),
    "TABL": lambda rf, number, *codes: rf.load_table(turned(*codes)),
    "ARM": lambda rf: rf.arm(),
    "SAFE": lambda rf: rf.safe_state(),
}


class MotorPeer(Controller):
    """A motor that is not homed; ``slow`` moves take so many looks at its status."""

    slow = iter(())

    def __init__(self, device, kind):
        super().__init__()
        self.device = device
        self.scale = kind.scale
        self.model = f"{kind.models[0]}1".encode()
        self.status &= ~HOMED

    def go(self, goal):
        super().go(goal)
        self.looks = next(self.slow, 1)
        self.device.move_to(goal / self.scale)


class ReadOut(T7):
    """A T7 with its watchdog, and with a flip mirror that takes its time."""

    def __init__(self, device, clock):
        super().__init__()
        self.device = device
        self.clock = clock
        self.heard = clock()
        self.slowness = 0.0  # of the flip mirror, s
        self.turning = []
        self.set(61812, "fff", *device.gain(10.0))  # INTERNAL_FLASH_READ

    def look(self):
        """Let the watchdog act, and the flip mirror arrive."""
        if self.get(61600) and self.clock() - self.heard > self.get(61604):
            for line in range(8):
                if not self.get(61636) >> line & 1:  # not inhibited
                    self.write(2000 + line, b"\0\0")
        while self.turning and self.turning[0][0] <= self.clock():
            self.device.set_line(*self.turning.pop(0)[1:])

    def __call__(self, frame):
        self.look()
        self.heard = self.clock()
        self.set(2007, "H", self.device.line(LINES["interlock"]))
        return super().__call__(frame)

    def write(self, address, data):
        super().write(address, data)
        line = f"FIO{address - 2000}"
        if line == LINES["flip_mirror"]:
            self.turning.append((self.clock() + self.slowness, line, any(data)))
        elif 2000 <= address < 2008:
            self.device.set_line(line, any(data))
        elif address in (30004, 30006):
            self.device.write_many({f"TDAC{(address - 30000) // 2}": self.get(address, "f")})

    def cycle_power(self):
        super().cycle_power()
        for line in range(8):
            self.device.set_line(f"FIO{line}", bool(self.levels >> line & 1))

    def counts(self):
        settings = {"rate": self.get(4002, "f"), "scans": self.get(4020), "pulse": self.get(4060)}
        self.device.configure_burst(channel="AIN0", range=10.0, pulse_line="FIO4", **settings)
        return next(self.device.bursts([{"USER_RAM0_U32": self.get(46100)}]))


class Scpi:
    """A device of text commands: what is set is kept, and told when it is asked for."""

    model = ""
    settings = ()

    def __init__(self, device):
        self.device = device
        self.kept = dict(self.settings)

    def __call__(self, line):
        head, _, value = line.decode().strip().partition(" ")
        if value:
            self.obey(head, value)
        answer = self.answer(head[:-1]) if head.endswith("?") else ""
        return f"{answer}\n".encode() if answer else b""

    def answer(self, head):
        return f"MAKER,{self.model},1,2" if head == "*IDN" else self.kept.get(head, "")

    def obey(self, head, value):
        self.kept[head] = value


class Generator(Scpi):
    """An SDG2042X."""

    model = "SDG2042X"
    settings = (("*OPC", "1"), ("MODE", "PHASE-LOCKED"))

    def answer(self, head):
        if head.endswith("OUTP"):
            state = "ON" if self.device.output_is_on(int(head[1])) else "OFF"
            return f"{head} {state},LOAD,50,PLRT,NOR"
        if ":" in head:
            return f"{head} {self.kept.get(head, 'STATE,OFF')}"
        return super().answer(head)

    def obey(self, head, value):
        if value in ("ON", "OFF"):
            self.device.output(int(head[1]), value == "ON")
        super().obey(head, value)


class Meter(Scpi):
    """A PM100D that was left in dBm."""

    model = "PM100D"
    settings = (
        ("SENS:POW:UNIT", "DBM"),
        ("SENS:CORR:COLL:ZERO:STAT", "0"),
        ("SYST:SENS:IDN", '"S140C","1","01-JAN-2026",1,1,33'),
    )

    def answer(self, head):
        return repr(self.device.power) if head == "MEAS:POW" else super().answer(head)


# --- world ---------------------------------------------------------------------------------------


class World:
    """Devices of a rig before a scene, each behind a wire of its own; ``rig`` leads there."""

    def __init__(self, rig, scene=None, *, seed=0):
        bench = simulated_bench(rig, scene, seed=seed)
        self.panel = bench.daq.panel
        self.clock = Clock()
        self.models = {}
        self.ends = {}
        for role, device in bench.devices.items():
            driver = rig.devices[role].driver
            self.models[role] = self._model(driver, device)
            self.ends[role] = end_of(driver, self.models[role])
        named = {
            role: replace(rig.devices[role], address=end.address) for role, end in self.ends.items()
        }
        self.rig = replace(rig, devices=named)

    def _model(self, driver, device):
        if driver in MOTORS:
            return MotorPeer(device, MOTORS[driver])
        if driver in ("sdg2042x", "pm100d"):
            return {"sdg2042x": Generator, "pm100d": Meter}[driver](device)
        return {"rf-driver": RfPeer, "labjack-t7": ReadOut}[driver](device, self.clock)

    def pass_by(self, seconds):
        """Let time pass without any request."""
        self.clock.passed += seconds
        for role in ("daq", "rf_emission", "rf_detection"):
            self.models[role].look()

    @property
    def dark(self):
        """Whether no light and no RF goes out."""
        panel = self.panel
        lit = panel.laser_on or panel.shutter_open or panel.beam_block_out
        return not (lit or panel.emission.on or panel.detection.on)

    def write(self, path, **changes):
        """Write the rig that leads here into a file."""
        devices = {role: asdict(one) for role, one in self.rig.devices.items()}
        path.write_text(json.dumps(self.rig.as_dict() | {"devices": devices} | changes))

    def close(self):
        for end in self.ends.values():
            end.close()


def end_of(driver, model):
    """Far end of a device's wire."""
    match driver:
        case "labjack-t7":
            return Network(model)
        case "rf-driver":
            return Terminal(whole_line, model)
        case "sdg2042x" | "pm100d":
            return Visa(whole_line, model)
    return Terminal(whole_message, model)
