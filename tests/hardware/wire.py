"""The other ends of a rig's wires: sockets and pseudo-terminals before a simulated instrument.

All devices have one clock, which stands still until a test or the host's sleep puts it forward: so
nobody waits for a watchdog, a dead man or a slow part.
"""

import json
import os
import socketserver
import struct
import threading
import tty
from contextlib import suppress
from dataclasses import asdict, replace
from functools import partial
from io import BufferedReader
from pathlib import Path
from types import SimpleNamespace

from peers import T7, Controller, Firmware, Wire
from scpi_peers import Generator, Meter

from cmtof.hardware.apt import MOTORS
from cmtof.hardware.connect import DARK_FIRST
from cmtof.hardware.rig import Rig
from cmtof_lab.rehearsal import simulated_bench
from cmtof_lab.targets import Plane

TODAY = 1.8e9  # s since 1970
WALL = Plane(0.9, tilt_x=0.3, reflectance=0.8)
DEFAULT = Rig.default()
PATIENT = {role: replace(one, timeout=10.0) for role, one in DEFAULT.devices.items()}
RIG = replace(DEFAULT, phases=4, samples_per_phase=14, devices=PATIENT)


def with_device(rig, role, **changes):
    """The rig with other settings of a device."""
    changed = {role: replace(rig.devices[role], **changes)}
    return replace(rig, devices=rig.devices | changed)


def message(requests):
    """The next APT message."""
    head = requests.read(6)
    long = head[4:5] > b"\x7f"
    return head + requests.read(long * int.from_bytes(head[2:4], "little"))


def frame(requests):
    """The next Modbus frame."""
    head = requests.read(6)
    return head + requests.read(int.from_bytes(head[4:], "big"))


def serve(requests, read, answer, send):
    """Answer requests until the host goes, or a fault hangs up."""
    with suppress(OSError), requests:
        while request := read(requests):
            send(answer(request))


def in_background(act, *arguments):
    """Have something done by a thread that ends with the program."""
    threading.Thread(target=act, args=arguments, daemon=True).start()


class Terminal:
    """A pseudo-terminal whose far end answers."""

    def __init__(self, model, read=BufferedReader.readline):
        self.wire = Wire(model)
        near, far = os.openpty()
        tty.setraw(far)
        # its own number would lead to the terminal of another test once it is closed
        self._link = Path(f"port{far}").absolute()
        self._link.symlink_to(os.ttyname(far))
        self.address = str(self._link)
        self._far = os.fdopen(far, "rb")
        in_background(
            serve, os.fdopen(near, "rb"), read, self.wire, partial(os.write, near)
        )

    def close(self):
        """Leave the port: when the host leaves it, too, nobody is there."""
        self._far.close()
        self._link.unlink(missing_ok=True)


class Server:
    """A TCP server whose connections are answered."""

    form = "{}:{}"

    def __init__(self, model, read=BufferedReader.readline, port=0):
        self.wire = Wire(model)
        self._read = read
        self._server = socketserver.ThreadingTCPServer(
            ("127.0.0.1", port), lambda client, *_: self.handle(client)
        )
        self._server.daemon_threads = True
        self.address = self.form.format(*self._server.server_address)
        in_background(self._server.serve_forever, 0.01)

    def handle(self, client):
        """Serve a connection."""
        serve(client.makefile("rb"), self._read, self.wire, client.sendall)

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
                self.stream = Stream(model, port=port + 200)
                super().__init__(self._answer, frame, port)
                return

    def _answer(self, request):
        number, _, _, unit, function = struct.unpack_from(">HHHBB", request)
        try:
            body = self._model(request[8:])
        except LookupError as refusal:  # with LabJack's own code of its cause
            self._model.set(55000, "H", *refusal.args)
            body = b"\6"
            function |= 0x80
        return struct.pack(">HHHBB", number, 0, len(body) + 2, unit, function) + body

    def close(self):
        self.stream.close()
        super().close()


class Stream(Server):
    """The port of a T7's packets."""

    def handle(self, client):
        self.wire.answer.stream = SimpleNamespace(write=client.sendall)
        client.recv(1)  # until the other end closes


# Model and far end of the wire of each driver.
PEERS = {
    "labjack-t7": (T7, Network),
    "rf-driver": (Firmware, Terminal),
    "sdg2042x": (Generator, Visa),
    "pm100d": (Meter, Visa),
}
for driver in MOTORS:
    controller = partial(Controller, driver=driver)
    PEERS[driver] = (controller, partial(Terminal, read=message))


class World:
    """Devices of a rig before a scene, each behind a wire of its own; ``rig`` leads there."""

    def __init__(self, rig, scene=None, *, seed=0):
        self.passed = 0.0
        bench = simulated_bench(rig, scene, seed=seed)
        self.panel = bench.daq.panel
        self.models = {}
        self.ends = {}
        self.rig = rig
        for role, device in bench.devices.items():
            kind, end = PEERS[rig.devices[role].driver]
            self.models[role] = kind(device, clock=self.now)
            self.ends[role] = end(self.models[role])
            self.rig = with_device(self.rig, role, address=self.ends[role].address)
        self.ends["stream"] = self.ends["daq"].stream

    def now(self):
        """Time, s."""
        return self.passed

    def date(self):
        """Time, s since 1970."""
        return TODAY + self.passed

    def sleep(self, seconds):
        """Let time pass."""
        self.passed += seconds

    def silence(self, seconds):
        """Let time pass without any request."""
        self.sleep(seconds)
        for role in DARK_FIRST:
            self.models[role].look()

    @property
    def lit(self):
        """Whether light may go out."""
        panel = self.panel
        return panel.laser_on or panel.shutter_open or panel.beam_block_out

    @property
    def dark(self):
        """Whether neither light nor RF goes out."""
        return not (self.lit or self.panel.emission.on or self.panel.detection.on)

    def write(self, **changes):
        """Write the rig that leads here into the working folder."""
        devices = {role: asdict(one) for role, one in self.rig.devices.items()}
        held = self.rig.as_dict() | {"devices": devices} | changes
        Path("rig.yml").write_text(json.dumps(held))

    def close(self):
        for end in self.ends.values():
            end.close()
