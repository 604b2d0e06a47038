"""A serial line, or the pseudo-terminal of a simulated instrument."""

import time
from typing import Any

from cmtof.hardware.errors import InstrumentTimeout
from cmtof.hardware.transport.buffered import Buffered, imported


class SerialTransport(Buffered):
    """Serial port or pseudo-terminal, 8 data bits, no parity, 1 stop bit; needs pyserial.

    Parameters
    ----------
    path : str
        Device, as ``/dev/ttyUSB0`` or ``COM3``.
    baud : int
        Bits per second.
    rtscts : bool
        Whether RTS and CTS control the flow (Thorlabs APT wants it).
    timeout : float
        Longest wait for sending, s.

    Raises
    ------
    ConnectionLost
        If the port is missing, in use or cannot be opened.
    """

    def __init__(
        self, path: str, *, baud: int = 115200, rtscts: bool = False, timeout: float = 2.0
    ) -> None:
        super().__init__()
        self.name = f"serial:{path}"
        self._settings: dict[str, Any] = {
            "port": path,
            "baudrate": baud,
            "rtscts": rtscts,
            "timeout": 0.0,
            "write_timeout": timeout,
            "exclusive": True,  # two hosts on one line would read each other's replies
        }
        self._port: Any = None
        self._open()

    def _open(self) -> None:
        serial = imported("serial", "pyserial", "hardware")
        try:
            self._port = serial.Serial(**self._settings)
        except (OSError, ValueError) as error:
            raise self._lost(error) from error
        if self._settings["rtscts"]:
            self._reset_flow()

    def _reset_flow(self) -> None:
        """Toggle RTS as APT controllers want it (pylablib kinesis.py, yaq's README)."""
        try:
            self._port.rts = True
            time.sleep(0.05)
            self._port.reset_input_buffer()
            self._port.reset_output_buffer()
            self._port.rts = False
        except OSError:
            return  # a pseudo-terminal has no such line

    def _shut(self) -> None:
        if self._port is not None:
            self._port.close()
            self._port = None

    def write(self, data: bytes) -> None:
        """Send all of the bytes."""
        if self._port is None:
            raise self._lost("closed")
        serial = imported("serial", "pyserial", "hardware")
        try:
            self._port.write(data)
        except serial.SerialTimeoutException:
            self._shut()
            raise InstrumentTimeout(
                f"Expected {self.name} to take {len(data)} bytes, got no room. "
                "Check the cable, then reconnect."
            ) from None
        except OSError as error:
            raise self._lost(error) from error

    def _receive(self, timeout: float) -> bytes:
        if self._port is None:
            raise self._lost("closed")
        try:
            self._port.timeout = timeout
            first = self._port.read(1)
            return first + self._port.read(self._port.in_waiting) if first else b""
        except OSError as error:
            raise self._lost(error) from error
