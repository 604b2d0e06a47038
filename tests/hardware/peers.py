"""Other ends for the drivers: strict dialogues, and a T7 on pymodbus' own server."""

import asyncio
import gc
import socket
import struct
import threading
import warnings

import numpy as np
import serial
from pymodbus.constants import ExcCodes
from pymodbus.pdu import ExceptionResponse
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice
from pyvisa import VisaIOError
from pyvisa.constants import StatusCode

from cmtof.hardware.t7 import REGISTERS, feedback_class


class Dialogue:
    """A VISA resource that expects one dialogue, (sent, replies) pairs in their order.

    A reply is text, or an exception that is raised in its place; `finish` fails on leftovers.
    """

    timeout = 1000

    def __init__(self, *pairs):
        self.pairs, self.replies, self.closed = list(pairs), [], False

    def write(self, text):
        assert not self.replies, f"{text} sent while {self.replies} was not read"
        assert self.pairs, f"{text} sent behind the end of the dialogue"
        wanted, reply = self.pairs.pop(0)
        assert text == wanted
        if isinstance(reply, Exception):
            raise reply
        self.replies = [] if reply is None else [reply]

    def read(self):
        if not self.replies:
            raise VisaIOError(StatusCode.error_timeout)
        reply = self.replies.pop(0)
        if isinstance(reply, Exception):
            raise reply
        return reply

    def close(self):
        self.closed = True

    def finish(self):
        assert not self.pairs
        assert not self.replies


class Port:
    """A serial port on pyserial's ``loop://``: what is written is answered by a function."""

    def __init__(self, answer):
        self._loop = serial.serial_for_url("loop://", timeout=0.02)
        self._answer, self.sent = answer, []

    def write(self, data):
        self.sent.append(data)
        reply = self._answer(data)
        if isinstance(reply, Exception):
            raise reply
        self._loop.write(reply)

    def __getattr__(self, name):
        return getattr(self._loop, name)


def script(*pairs):
    """Port that expects one dialogue; `finish` fails on leftovers."""
    left = list(pairs)

    def answer(data):
        assert left, f"{data!r} sent behind the end of the dialogue"
        wanted, reply = left.pop(0)
        assert data == wanted
        return reply

    port = Port(answer)
    port.finish = lambda: not left or (_ for _ in ()).throw(AssertionError(left))
    return port


def timeout():
    """What pyvisa raises when nothing comes."""
    return VisaIOError(StatusCode.error_timeout)


def lost():
    """What pyvisa raises when the other end has gone."""
    return VisaIOError(StatusCode.error_connection_lost)


class T7Peer:
    """A T7: its map on pymodbus' server, function 76, and stream packets on a second port.

    ``fault`` may be "drop" (answer nothing), "garbage", "refuse" or "hang up" for the next
    requests, or "lost packet", "skipped", "short" for the next burst.
    """

    def __init__(self):
        self.registers, self.written, self.fault, self.pulses = {}, [], "", 0
        self.set("PRODUCT_ID", 7.0)
        self.set("TEST", 0x00112233)
        self.set("SERIAL_NUMBER", 470010001)
        self.set("FIRMWARE_VERSION", 1.0292)
        self.flash = {0x3C4000: struct.pack(">4f", 3.16e-4, -3.16e-4, 33520.0, -10.6)}
        self.registers[2000 + 7] = 1  # the interlock is closed
        self._stream = socket.create_server(("127.0.0.1", 0))
        self.stream = f"127.0.0.1:{self._stream.getsockname()[1]}"
        self._clients = []
        self._loop = asyncio.new_event_loop()
        self._ready, self._connected = threading.Event(), threading.Event()
        self._threads = [
            threading.Thread(target=one, daemon=True) for one in (self._serve, self._accept)
        ]
        for thread in self._threads:
            thread.start()
        assert self._ready.wait(10)

    def set(self, name, value):
        """Set a register by name."""
        address, kind = REGISTERS[name]
        words = struct.unpack(f">{struct.calcsize(kind) // 2}H", struct.pack(f">{kind}", value))
        self.registers.update({address + n: word for n, word in enumerate(words)})

    def get(self, name):
        """Value of a register by name."""
        address, kind = REGISTERS[name]
        words = [self.registers.get(address + n, 0) for n in range(struct.calcsize(kind) // 2)]
        return struct.unpack(f">{kind}", struct.pack(f">{len(words)}H", *words))[0]

    def _serve(self):
        asyncio.set_event_loop(self._loop)
        peer = self

        class Feedback(feedback_class()):
            async def datastore_update(self, context, device_id):
                return peer.feedback(self)

        async def values(function, start, address, count, registers, written):
            if written is None:
                return [self.registers.get(address + n, 0) for n in range(count)]
            return None

        async def start():
            device = SimDevice(
                1,
                simdata=SimData(0, values=0, count=65535, datatype=DataType.REGISTERS),
                action=values,
            )
            self._server = ModbusTcpServer(
                device,
                address=("127.0.0.1", 0),
                custom_pdu=[Feedback],
                trace_packet=self._trace,
            )
            await self._server.serve_forever(background=True)
            port = self._server.transport.sockets[0].getsockname()[1]
            self.address = f"127.0.0.1:{port}"
            self._ready.set()

        self._loop.create_task(start())
        self._loop.run_forever()

    def _trace(self, sending, data):
        """Drop or garble what is sent."""
        if sending and self.fault in ("drop", "garbage"):
            fault, self.fault = self.fault, ""
            return b"" if fault == "drop" else b"\xff" * len(data)
        return data

    def feedback(self, request):
        """Do reads and writes in their order."""
        if self.fault == "refuse":
            self.fault = ""
            self.set("LAST_ERR_DETAIL", 2605)
            return ExceptionResponse(76, ExcCodes.DEVICE_BUSY)
        data, reply, at = request.data, b"", 0
        while at < len(data):
            writes, address, count = struct.unpack_from(">BHB", data, at)
            at += 4
            if writes:
                words = struct.unpack_from(f">{count}H", data, at)
                at += 2 * count
                self._write(address, words)
            elif address == REGISTERS["INTERNAL_FLASH_READ"][0]:
                block = self.flash.get(self.get("INTERNAL_FLASH_READ_POINTER"), b"\xff" * 16)
                reply += block[: 2 * count]
        return feedback_class()(reply)

    def _write(self, address, words):
        self.registers.update({address + n: word for n, word in enumerate(words)})
        self.written.append((address, words))
        if 2000 <= address < 2008:
            bit = 1 << (address - 2000)
            state = self.registers.get(2500, 0) & ~bit | bit * words[0]
            self.registers[2500] = state
        if address == REGISTERS["STREAM_ENABLE"][0] and words[-1]:
            self._send_burst()

    def _accept(self):
        while True:
            try:
                self._clients.append(self._stream.accept()[0])
                self._connected.set()
            except OSError:
                return

    def _send_burst(self):
        """Packets of a ramp that starts at the label of the burst."""
        scans, size = self.get("STREAM_NUM_SCANS"), self.get("STREAM_SAMPLES_PER_PACKET")
        counts = (np.arange(scans) + self.get("USER_RAM0_U32")).astype(">u2")
        self.pulses += scans // max(self.get("STREAM_OUT0_LOOP_NUM_VALUES"), 1)
        fault, packets = self.fault, []
        for n, start in enumerate(range(0, scans, size)):
            part = counts[start : start + size].tobytes()
            status = 2944 if start + size >= scans else 0
            if fault == "skipped" and n == 1:
                status = 2941
            number = n + (fault == "lost packet" and n > 0)
            head = struct.pack(">HHHBBBBHHH", number, 0, 10 + len(part), 1, 76, 16, 0, 0, status, 0)
            packets.append(head + part)
        if fault in ("skipped", "lost packet", "short"):
            self.fault = ""
        assert self._connected.wait(5)
        for client in self._clients:
            client.sendall(b"".join(packets[: 1 if fault == "short" else None]))

    def close(self):
        """Stop serving; may be called again."""
        if self._loop.is_closed():
            return

        async def shutdown():
            for connection in list(self._server.active_connections.values()):
                if connection.transport:
                    connection.transport.abort()
            await self._server.shutdown()
            await asyncio.sleep(0.02)  # transports close on the next turns of the loop

        asyncio.run_coroutine_threadsafe(shutdown(), self._loop).result(5)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._stream.shutdown(socket.SHUT_RDWR)
        for thread in self._threads:
            thread.join(5)
        self._loop.close()
        for one in (self._stream, *self._clients):
            one.close()
        with warnings.catch_warnings():  # pymodbus leaves the transports of its server open
            warnings.simplefilter("ignore", ResourceWarning)
            del self._server
            gc.collect()
