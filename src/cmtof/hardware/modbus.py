"""Modbus TCP with LabJack's function 76 (feedback), over a socket."""

import socket
import struct

from cmtof.hardware.device import BadReply, ConnectionLost, Refused, one_error

PORT = 502
UNIT = 1
FEEDBACK = 76
HEAD = struct.Struct(">HHHBB")  # number, protocol, bytes that follow, unit, function


class Feedback:
    """Connection to a T7 that sends reads and writes of registers in one frame.

    After an error it is closed, and opened again for the next frame: a late answer would be taken
    for that to the next request.
    """

    def __init__(self, address: str, timeout: float) -> None:
        host, _, port = address.partition(":")
        self._timeout = timeout
        self._number = 0
        with one_error(f"a T7 at {address}", ConnectionLost):
            self.address = (host, int(port or PORT))
            self._socket: socket.socket | None = self._connect()

    def ask(self, frame: bytes) -> bytes:
        """Answer to a frame, without its header; `Refused` if the device reports an exception."""
        self._number = (self._number + 1) % 2**16
        self._socket = self._socket or self._connect()
        try:
            request = HEAD.pack(self._number, 0, len(frame) + 2, UNIT, FEEDBACK) + frame
            self._socket.sendall(request)
            head = receive(self._socket, HEAD.size)
            number, _, length, _, function = HEAD.unpack(head)
            if number != self._number or function & 0x7F != FEEDBACK:
                raise BadReply(
                    f"Expected answer {self._number}, got {number}. Ask again."
                )
            body = receive(self._socket, length - 2)
        except Exception:
            self.close()
            raise
        if function != FEEDBACK:
            raise Refused(
                f"Expected a request to be accepted, got exception {body[0]}. Look it up."
            )
        return body

    def close(self) -> None:
        """Close the connection; may be called again."""
        if self._socket is not None:
            self._socket.close()
        self._socket = None

    def _connect(self) -> socket.socket:
        return socket.create_connection(self.address, self._timeout)


def receive(line: socket.socket, size: int) -> bytes:
    """Exactly ``size`` bytes from a socket; ConnectionResetError if it ends before."""
    data = b""
    while len(data) < size:
        part = line.recv(size - len(data))
        if not part:
            raise ConnectionResetError("the connection was closed")
        data += part
    return data
