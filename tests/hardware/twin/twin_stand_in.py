"""For the tests of the twin's servers: a world without physics, and clients that speak bytes."""

import os
import select
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from cmtof.hardware.twin.lines import PtyLine, TcpLine

CENTRE = 33523


@dataclass
class Lock:
    locked: bool = True
    detuning: float = 5e6
    reflected: float = -12.5


@dataclass
class StandInWorld:
    """Counts say which edge came last; everything asked is written down."""

    asked: list[dict[str, Any]] = field(default_factory=list)
    locks: dict[str, Lock] = field(
        default_factory=lambda: {"emission": Lock(), "detection": Lock()}
    )
    power: float = 1e-3
    volts: tuple[float, ...] = (1.25, -2.5, 0.0, 10.0)

    def burst(self, panel, *, scans, rate, pulses, volts_range):
        with panel.lock:
            self.asked.append(
                {
                    "label": panel.label,
                    "scans": scans,
                    "rate": rate,
                    "pulses": np.array(pulses),
                    "range": volts_range,
                    "index": panel.detection.index,
                    "armed": panel.detection.armed,
                    "laser": panel.laser_on,
                }
            )
            panel.time = (panel.label * 0.02 if panel.label else panel.time) + scans / rate
            panel.bursts += 1
        return (CENTRE + np.asarray(pulses)).astype(np.uint16)

    def analog_input(self, panel, channel):
        return self.volts[channel] if channel < len(self.volts) else 0.0

    def laser_power(self, panel):
        return self.power if panel.laser_on and panel.shutter_open else 0.0

    def lock(self, panel, which):
        return self.locks[which]


class SocketClient:
    def __init__(self, port: int) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=5)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def send(self, data: bytes) -> None:
        self.socket.sendall(data)

    def read(self, timeout: float = 5.0, size: int = 65536) -> bytes:
        if not select.select([self.socket], [], [], timeout)[0]:
            return b""
        try:
            return self.socket.recv(size)
        except ConnectionResetError:  # hung up on before it had read what was sent
            return b""

    def close(self) -> None:
        self.socket.close()


class PtyClient:
    def __init__(self, link: Path) -> None:
        self.descriptor = os.open(link, os.O_RDWR | os.O_NOCTTY)

    def send(self, data: bytes) -> None:
        os.write(self.descriptor, data)

    def read(self, timeout: float = 5.0, size: int = 65536) -> bytes:
        if not select.select([self.descriptor], [], [], timeout)[0]:
            return b""
        return os.read(self.descriptor, size)

    def close(self) -> None:
        os.close(self.descriptor)


Client = SocketClient | PtyClient


def read_size(client: Client, size: int, timeout: float = 5.0) -> bytes:
    data = b""
    while len(data) < size:
        part = client.read(timeout, size - len(data))
        assert part, f"{len(data)} of {size} bytes: {data!r}"
        data += part
    return data


def read_line(client: Client, timeout: float = 5.0) -> bytes:
    data = b""
    while not data.endswith(b"\n"):
        part = client.read(timeout)
        assert part, f"no whole line: {data!r}"
        data += part
    return data


def ask(client: Client, text: str) -> str:
    client.send(text.encode() + b"\n")
    return read_line(client).decode().rstrip("\n")


def wait_until(true: Callable[[], bool], timeout: float = 5.0) -> None:
    end = time.monotonic() + timeout
    while not true():
        assert time.monotonic() < end, "it never came true"
        time.sleep(0.002)


@contextmanager
def on_port(serve) -> Iterator[tuple[TcpLine, SocketClient]]:
    line = TcpLine("127.0.0.1", 0, serve, "test")
    client = SocketClient(line.port)
    try:
        yield line, client
    finally:
        client.close()
        line.stop()


@contextmanager
def on_terminal(serve, folder: Path) -> Iterator[tuple[PtyLine, PtyClient]]:
    line = PtyLine(folder / "port", serve, "test")
    client = PtyClient(line.link)
    try:
        yield line, client
    finally:
        client.close()
        line.stop()


def left_behind() -> tuple[set[threading.Thread], int]:
    """Threads, and how many descriptors are open."""
    return set(threading.enumerate()), len(list(Path("/proc/self/fd").iterdir()))


def listening() -> list[str]:
    """Addresses on which this process listens, as the kernel lists them (hexadecimal)."""
    mine = set()
    for entry in Path("/proc/self/fd").iterdir():
        try:
            mine.add(str(entry.readlink()))
        except OSError:
            continue
    found = []
    for table in ("tcp", "tcp6", "udp", "udp6"):
        for row in Path(f"/proc/self/net/{table}").read_text().splitlines()[1:]:
            local, state, inode = row.split()[1], row.split()[3], row.split()[9]
            open_to_all = state == ("0A" if table.startswith("tcp") else "07")
            if open_to_all and f"socket:[{inode}]" in mine:
                found.append(local)
    return found
