"""A LabJack T7's two connections in memory: registers, function 3, 16 and 76, scripted packets."""

import struct

import numpy as np

from cmtof.hardware.errors import ConnectionLost
from cmtof.hardware.transport.buffered import Buffered

FLASH = {
    0x3C4000: struct.pack(
        ">41f",
        *[
            v
            for g in (1, 0.1, 0.01, 0.001) * 2
            for v in (3.16e-4 * g, -3.157e-4 * g, 33500.0, -10.57 * g)
        ],
        *[13200.0, 0.0, 13200.0, 0.0, -92.6, 467.6, 1e-5, 2e-4, 1.5e-8],
    )
}


class Memory(Buffered):
    """A line in memory; `answers` counts requests, `silent` ones get none."""

    def __init__(self):
        super().__init__()
        self.waiting = []
        self.lost = False
        self.reconnects = 0

    def _receive(self, timeout):
        if self.lost:
            raise ConnectionLost("Expected an open line, got a closed one. Reconnect.")
        return self.waiting.pop(0) if self.waiting else b""

    def write(self, data):
        if self.lost:
            raise ConnectionLost("Expected an open line, got a closed one. Reconnect.")

    def reconnect(self):
        self._arrived.clear()
        self.lost = False
        self.reconnects += 1


class Command(Memory):
    """Port 502."""

    def __init__(self, peer):
        super().__init__()
        self.peer = peer
        self.silences = 0
        self.refusals = {}
        """Exception code and LabJack's own, by the address that must not be written."""

    def write(self, data):
        super().write(data)
        number, protocol, length, unit, function = struct.unpack_from(">HHHBB", data)
        assert (protocol, length, unit) == (0, len(data) - 6, 1)
        if self.silences:
            self.silences -= 1
            return
        try:
            answer = bytes([function]) + getattr(self, f"_do_{function}")(data[8:])
        except PermissionError as refusal:
            code, detail = refusal.args
            self.peer.memory[55000] = detail
            answer = bytes([function | 0x80, code])
        self.waiting.append(struct.pack(">HHHB", number, 0, len(answer) + 1, 1) + answer)

    def _do_3(self, data):
        address, count = struct.unpack(">HH", data)
        words = self.peer.read(address, count)
        return bytes([2 * count]) + words

    def _do_16(self, data):
        address, count, size = struct.unpack_from(">HHB", data)
        assert size == 2 * count == len(data) - 5
        self._write(address, data[5:])
        return data[:4]

    def _do_76(self, data):
        reads = b""
        while data:
            kind, address, count = struct.unpack_from(">BHB", data)
            data = data[4:]
            if kind == 0:
                reads += self.peer.read(address, count)
            else:
                self._write(address, data[: 2 * count])
                data = data[2 * count :]
        return reads

    def _write(self, address, data):
        if address in self.refusals:
            raise PermissionError(*self.refusals[address])
        self.peer.write(address, data)


class T7Peer:
    """The device behind both connections.

    `packets` is called at every start of a stream and returns what port 702 sends then.
    """

    def __init__(self, packets=None):
        self.memory = {}
        self.log = []
        """Writes in their order: (address, bytes)."""
        self.packets = packets or (lambda peer: whole_burst(320))
        self.kept = {}
        """Registers that keep their value, whatever is written."""
        self.flash = dict(FLASH)
        self.command, self.stream = Command(self), Memory()
        self.put_float(60000, 7.0)
        self.put(55100, bytes.fromhex("00112233"))
        self.put_float(60004, 1.0301)
        self.put_float(60002, 1.35)
        self.put(60028, (470012345).to_bytes(4, "big"))
        self.put(60010, bytes(4))
        self.memory[2500] = 0

    def put(self, address, data):
        for n in range(0, len(data), 2):
            self.memory[address + n // 2] = int.from_bytes(data[n : n + 2], "big")

    def put_float(self, address, value):
        self.put(address, struct.pack(">f", value))

    def read(self, address, count):
        if address == 61812:
            (pointer,) = struct.unpack(">I", self.read(61810, 2))
            start = pointer - 0x3C4000
            return self.flash[0x3C4000][start : start + 2 * count]
        return b"".join(self.memory.get(address + n, 0).to_bytes(2, "big") for n in range(count))

    def write(self, address, data):
        self.log.append((address, data))
        self.put(address, self.kept.get(address, data))
        if 2000 <= address < 2008:
            bit = 1 << (address - 2000)
            state = self.memory[2500]
            self.memory[2500] = state | bit if data[-1] else state & ~bit
        if (address, data[-1]) == (4990, 1):
            self.stream.waiting.extend(self.packets(self))

    def written(self, address):
        return [data for found, data in self.log if found == address]


def packet(number, counts, *, status=0, extra=0):
    data = np.asarray(counts, ">u2").tobytes()
    head = struct.pack(">BBBBHHH", 1, 76, 16, 0, 2 * len(counts), status, extra)
    return struct.pack(">HHH", number & 0xFFFF, 0, len(head) + len(data)) + head + data


def whole_burst(scans, *, size=160, first=0, value=lambda s: 40000 + s):
    counts = [value(s) for s in range(scans)]
    parts = [counts[n : n + size] for n in range(0, scans, size)]
    last = len(parts) - 1
    return [
        packet(first + n, part, status=2944 if n == last else 0, extra=0)
        for n, part in enumerate(parts)
    ]
