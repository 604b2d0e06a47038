"""A TCP connection to an instrument."""

import socket

from cmtof.hardware.errors import InstrumentTimeout
from cmtof.hardware.transport.buffered import Buffered

_CHUNK = 65536


class TcpTransport(Buffered):
    """Client of a TCP server.

    Parameters
    ----------
    host : str
        Name or address.
    port : int
        Port, 1 to 65535.
    timeout : float
        Longest wait for connecting and for sending, s.

    Raises
    ------
    ConnectionLost
        If nobody listens there.
    InstrumentTimeout
        If there is no answer at all.
    """

    def __init__(self, host: str, port: int, *, timeout: float = 2.0) -> None:
        super().__init__()
        self.name = f"tcp://{host}:{port}"
        self._address, self._timeout = (host, port), timeout
        self._socket: socket.socket | None = None
        self._open()

    def _open(self) -> None:
        try:
            self._socket = socket.create_connection(self._address, self._timeout)
        except TimeoutError:
            raise InstrumentTimeout(
                f"Expected a connection to {self.name} within {self._timeout:g} s, got none. "
                "Check address and cable."
            ) from None
        except OSError as error:
            raise self._lost(error.strerror or error) from error
        # requests are small and each waits for its answer
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def _shut(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def write(self, data: bytes) -> None:
        """Send all of the bytes."""
        if self._socket is None:
            raise self._lost("closed")
        try:
            self._socket.settimeout(self._timeout)
            self._socket.sendall(data)
        except TimeoutError:
            # an unknown part is on its way: what follows would be misread
            self._shut()
            raise InstrumentTimeout(
                f"Expected {self.name} to take {len(data)} bytes within {self._timeout:g} s, "
                "got no room. Reconnect."
            ) from None
        except OSError as error:
            raise self._lost(error.strerror or error) from error

    def _receive(self, timeout: float) -> bytes:
        if self._socket is None:
            raise self._lost("closed")
        try:
            self._socket.settimeout(timeout)
            data = self._socket.recv(_CHUNK)
        except (TimeoutError, BlockingIOError):
            return b""
        except OSError as error:
            raise self._lost(error.strerror or error) from error
        if not data:
            raise self._lost("closed by the device")
        return data
