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
from types import SimpleNamespace

from peers import T7, Controller, Firmware, Wire
from scpi_peers import Generator, Meter

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
    device = replace(rig.devices[role], **changes)
    return replace(rig, devices=rig.devices | {role: device})


def whole_line(data):
    """Length of the first line of text, 0 if it is not whole."""
    return data.find(b"\n") + 1


def whole_message(data):
    """Length of the first APT message."""
    return (
        6 + struct.unpack_from("<H", data, 2)[0] * (data[4] >> 7)
        if len(data) > 5
        else 0
    )


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
        threading.Thread(
            target=self._server.serve_forever, args=(0.01,), daemon=True
        ).start()

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

    def __init__(self, whole, model):
        self._model = model
        for port in range(20_000 + os.getpid() % 10_000, 60_000):
            with suppress(OSError):
                self._stream = Stream(whole_line, model, port + 200)
                super().__init__(whole, self._answer, port)
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


PEERS = {
    "labjack-t7": (T7, Network, whole_frame),
    "rf-driver": (Firmware, Terminal, whole_line),
    "sdg2042x": (Generator, Visa, whole_line),
    "pm100d": (Meter, Visa, whole_line),
}
"""Model, far end of the wire and form of a request of each driver but the motors."""


class World:
    """Devices of a rig before a scene, each behind a wire of its own; ``rig`` leads there."""

    def __init__(self, rig, scene=None, *, seed=0):
        self.passed = 0.0
        bench = simulated_bench(rig, scene, seed=seed)
        self.panel = bench.daq.panel
        self.devices = bench.devices
        self.models = {}
        self.ends = {}
        named = dict(rig.devices)
        for role, device in bench.devices.items():
            driver = named[role].driver
            kind, end, whole = PEERS.get(driver, (Controller, Terminal, whole_message))
            timed = self.now if kind in (T7, Firmware) else driver
            self.models[role] = kind(device, timed)
            self.ends[role] = end(whole, self.models[role])
            named[role] = replace(named[role], address=self.ends[role].address)
        self.rig = replace(rig, devices=named)

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
        for role in ("daq", "rf_emission", "rf_detection"):
            self.models[role].look()

    @property
    def lit(self):
        """Whether light may go out."""
        return (
            self.panel.laser_on or self.panel.shutter_open or self.panel.beam_block_out
        )

    @property
    def dark(self):
        """Whether neither light nor RF goes out."""
        return not (self.lit or self.panel.emission.on or self.panel.detection.on)

    def write(self, path, **changes):
        """Write the rig that leads here into a file."""
        devices = {role: asdict(one) for role, one in self.rig.devices.items()}
        path.write_text(json.dumps(self.rig.as_dict() | {"devices": devices} | changes))

    def close(self):
        for end in self.ends.values():
            end.close()
