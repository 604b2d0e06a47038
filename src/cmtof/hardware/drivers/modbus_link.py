"""Modbus TCP requests to a LabJack and their answers, one at a time."""

from collections.abc import Callable, Sequence
from typing import TypeVar

from cmtof.hardware.codecs import modbus
from cmtof.hardware.codecs.registers import register
from cmtof.hardware.errors import BadReply
from cmtof.hardware.transport import Transport

T = TypeVar("T")

_STALE = 8
"""Late answers to earlier requests that are passed over before giving up."""


class ModbusLink:
    """Numbers requests, waits for the answer of the same number, drops answers that come late.

    Parameters
    ----------
    transport : Transport
        To port 502.
    timeout : float
        For each answer, s.
    """

    def __init__(self, transport: Transport, *, timeout: float) -> None:
        self._transport = transport
        self._timeout = timeout
        self._number = 0

    def read(self, address: int, count: int) -> bytes:
        """Bytes of ``count`` registers from ``address`` on (function 3).

        Raises
        ------
        ModbusException
            If the device refuses; with LabJack's own code.
        BadReply, InstrumentTimeout, ConnectionLost
            If no whole answer comes.
        """
        number = self._next()
        frame = self._exchange(number, modbus.read_request(number, address, count))
        return self._explained(lambda: modbus.parse_read(frame, number, count))

    def write(self, address: int, data: bytes) -> None:
        """Write two bytes a register from ``address`` on (function 16); raises as `read`."""
        number = self._next()
        frame = self._exchange(number, modbus.write_request(number, address, data))
        self._explained(lambda: modbus.parse_write(frame, number, address, len(data) // 2))

    def feedback(self, parts: Sequence[modbus.Read | modbus.Write]) -> list[bytes]:
        """Do reads and writes in their order in one frame (function 76); bytes of each read."""
        number = self._next()
        frame = self._exchange(number, modbus.feedback_request(number, parts))
        return self._explained(lambda: modbus.parse_feedback(frame, number, parts))

    def _next(self) -> int:
        self._number = (self._number + 1) & 0xFFFF
        return self._number

    def _exchange(self, number: int, request: bytes) -> bytes:
        # a request that was interrupted may have left half an answer
        self._transport.flush()
        self._transport.write(request)
        for _ in range(_STALE):
            frame = self._frame()
            found = modbus.parse_frame(frame).transaction
            if found == number:
                return frame
            if (number - found) & 0xFFFF > 0x7FFF:  # not an earlier request of ours
                break
        raise BadReply(f"Expected the answer to request {number}, got others. Flush and ask again.")

    def _frame(self) -> bytes:
        header = self._transport.read_exact(modbus.HEADER_SIZE, self._timeout)
        return header + self._transport.read_exact(modbus.bytes_to_come(header), self._timeout)

    def _explained(self, parse: Callable[[], T]) -> T:
        """Parse; an exception of the device is raised with the code in LAST_ERR_DETAIL."""
        try:
            return parse()
        except modbus.ModbusException as refusal:
            detail = self._detail()
            raise (refusal if detail is None else refusal.with_detail(detail)) from None

    def _detail(self) -> int | None:
        number = self._next()
        entry = register("LAST_ERR_DETAIL")
        try:
            frame = self._exchange(number, modbus.read_request(number, entry.address, 1))
            return int.from_bytes(modbus.parse_read(frame, number, 1), "big")
        except OSError:  # the refusal itself is what matters
            return None
