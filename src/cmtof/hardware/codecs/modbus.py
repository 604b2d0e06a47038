"""Modbus TCP as the LabJack T7 speaks it: functions 3, 16 and 76, bytes to values and back.

A frame is the MBAP header (transaction u16, protocol 0 u16, length u16 of what follows, unit u8),
the function u8 and its data, all big-endian (Modbus Messaging on TCP/IP Implementation Guide
V1.0b, 3.1.3). Function 76, "Modbus Feedback", packs reads and writes of several addresses into one
frame (LabJack, Protocol Details [Direct Modbus TCP]; the frames are those that the public driver
async_labjack builds).
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass

from cmtof.hardware.errors import BadReply, Refused

HEADER_SIZE = 7
"""Bytes of the MBAP header, unit included."""
MAX_FRAME = 1040
"""Longest frame of a T7 over Ethernet: 512 stream samples and their 16 bytes of header."""
MAX_READ = 125
"""Registers that function 3 reads at most (Modbus Application Protocol V1.1b3, 6.3)."""
MAX_WRITE = 123
"""Registers that function 16 writes at most (6.12)."""
READ, WRITE, FEEDBACK = 3, 16, 76
_MAX_FEEDBACK = 255  # the count of a feedback frame is one byte

EXCEPTIONS = {
    1: "illegal function",
    2: "illegal data address",
    3: "illegal data value",
    4: "device failure",
    5: "acknowledged, not done yet",
    6: "device busy",
    8: "memory parity error",
    10: "gateway path unavailable",
    11: "gateway target did not respond",
}
"""Exception codes (Modbus Application Protocol V1.1b3, 7)."""

DETAILS = {
    2370: "AIN_RANGE_INVALID",
    2371: "AIN_SETTLING_INVALID",
    2373: "AIN_NEGATIVE_CHANNEL_INVALID",
    2460: "POWER_ANALOG_OFF",
    2500: "HW_DIO_NOT_AVAILABLE",
    2600: "STREAM_NEED_AT_LEAST_ONE_CHN",
    2603: "STREAM_IN_SPONTANEOUS_MODE",
    2605: "STREAM_IS_ACTIVE",
    2606: "STREAM_CONFIG_INVALID",
    2607: "STREAM_CHN_LIST_INVALID",
    2608: "STREAM_SCAN_RATE_INVALID",
    2609: "STREAM_OUT_BUFF_TOO_BIG",
    2610: "STREAM_OUT_NUM_INVALID",
    2611: "STREAM_DATA_TYPE_INVALID",
    2612: "STREAM_TARGET_CONFIG_INVALID",
    2613: "STREAM_OUT_BUFF_FULL",
    2614: "STREAM_OUT_TARGET_INVALID",
    2615: "STREAM_BUFF_SIZE_INVALID",
    2617: "STREAM_OUT_BUFF_DNE",
    2618: "STREAM_SAMPLES_PER_PKT_INVALID",
    2619: "STREAM_BUFFER_DNE",
    2620: "STREAM_NOT_RUNNING",
    2621: "STREAM_SETTLING_INVALID",
    2622: "STREAM_OUT_LOOP_TOO_BIG",
    2623: "STREAM_OUT_DATA_TRGT_MISSMATCH",
    2625: "STREAM_CHN_CAN_NOT_BE_STREAMED",
    2671: "SWDT_ENABLED",
    2760: "TDAC_SDA_SCL_INVALID",
    2761: "TDAC_SCL_INVALID",
    2762: "TDAC_INVALID_CHANNEL",
    2763: "TDAC_CAL_READ_FAILURE",
}
"""LabJack's codes in LAST_ERR_DETAIL that this rig can meet (ljm_constants.json, "errors")."""


class ModbusException(Refused):
    """The device answered a request with an exception.

    Attributes
    ----------
    function, code : int
        Function of the request and code of the exception.
    detail : int or None
        LabJack's own code, where LAST_ERR_DETAIL was read.
    """

    def __init__(self, function: int, code: int, detail: int | None = None) -> None:
        self.function, self.code, self.detail = function, code, detail
        reason = EXCEPTIONS.get(code, "unknown exception")
        more = "" if detail is None else f", LabJack {detail} {DETAILS.get(detail, 'unknown')}"
        super().__init__(
            f"Expected the device to accept Modbus function {function}, got exception {code} "
            f"({reason}{more}). Check address and value."
        )

    def with_detail(self, detail: int) -> "ModbusException":
        """Return the same exception with the code that LAST_ERR_DETAIL holds."""
        return ModbusException(self.function, self.code, detail)


@dataclass(frozen=True)
class Frame:
    """One frame, split: transaction number, unit, function and the data behind it."""

    transaction: int
    unit: int
    function: int
    data: bytes


@dataclass(frozen=True)
class Read:
    """Part of a feedback request: read ``count`` registers at ``address``."""

    address: int
    count: int


@dataclass(frozen=True)
class Write:
    """Part of a feedback request: write ``data``, two bytes a register, at ``address``."""

    address: int
    data: bytes


def _frame(transaction: int, unit: int, function: int, data: bytes) -> bytes:
    return struct.pack(">HHHBB", transaction & 0xFFFF, 0, len(data) + 2, unit, function) + data


def _check_span(address: int, count: int, limit: int) -> None:
    if not (address >= 0 and 1 <= count <= limit and address + count <= 0x10000):
        raise ValueError(
            f"Expected 1 to {limit} registers within 0-65535, got {count} at {address}. "
            "Split the request."
        )


def _registers(data: bytes) -> int:
    if len(data) % 2:
        raise ValueError(f"Expected two bytes a register, got {len(data)} bytes. Pad the value.")
    return len(data) // 2


def read_request(transaction: int, address: int, count: int, *, unit: int = 1) -> bytes:
    """Frame that reads ``count`` registers from ``address`` on (function 3).

    Examples
    --------
    >>> read_request(7, 0, 8).hex(" ", -2)  # AIN0 to AIN3
    '0007 0000 0006 0103 0000 0008'
    """
    _check_span(address, count, MAX_READ)
    return _frame(transaction, unit, READ, struct.pack(">HH", address, count))


def write_request(transaction: int, address: int, data: bytes, *, unit: int = 1) -> bytes:
    """Frame that writes the bytes, two a register, from ``address`` on (function 16).

    Examples
    --------
    >>> write_request(1, 30004, bytes.fromhex("40200000")).hex(" ", -2)  # TDAC2 = 2.5 V
    '0001 0000 000b 0110 7534 0002 0440 2000 00'
    """
    count = _registers(data)
    _check_span(address, count, MAX_WRITE)
    return _frame(transaction, unit, WRITE, struct.pack(">HHB", address, count, len(data)) + data)


def feedback_request(transaction: int, parts: Sequence[Read | Write], *, unit: int = 1) -> bytes:
    """Frame that does the reads and writes in their order (function 76).

    It is not atomic: after an error what stood before has been done.

    Raises
    ------
    ValueError
        If there are no parts, a part is too long, or request or answer exceed `MAX_FRAME`.
    """
    data = b"".join(_part(part) for part in parts)
    answer = 2 * sum(part.count for part in parts if isinstance(part, Read))
    size = HEADER_SIZE + 1 + max(len(data), answer)
    if not parts or size > MAX_FRAME:
        raise ValueError(
            f"Expected a feedback frame of 1 part to {MAX_FRAME} bytes, got {len(parts)} parts "
            f"and {size} bytes. Split the request."
        )
    return _frame(transaction, unit, FEEDBACK, data)


def _part(part: Read | Write) -> bytes:
    count = part.count if isinstance(part, Read) else _registers(part.data)
    _check_span(part.address, count, _MAX_FEEDBACK)
    head = struct.pack(">BHB", isinstance(part, Write), part.address, count)
    return head if isinstance(part, Read) else head + part.data


def bytes_to_come(header: bytes) -> int:
    """How many bytes follow the 7 of the MBAP header.

    Raises
    ------
    BadReply
        If this is no MBAP header of a frame that a T7 could send.
    """
    if len(header) != HEADER_SIZE:
        raise BadReply(
            f"Expected {HEADER_SIZE} bytes of header, got {len(header)}. Flush and ask again."
        )
    protocol, length = struct.unpack_from(">HH", header, 2)
    if protocol or not 2 <= length <= MAX_FRAME - 6:
        raise BadReply(
            f"Expected a Modbus TCP header (protocol 0, length 2 to {MAX_FRAME - 6}), got "
            f"protocol {protocol}, length {length}. Flush and ask again."
        )
    return length - 1


def parse_frame(frame: bytes) -> Frame:
    """Split a whole frame.

    Raises
    ------
    BadReply
        If header and length do not fit.
    """
    wanted = HEADER_SIZE + bytes_to_come(frame[:HEADER_SIZE])
    if len(frame) != wanted:
        raise BadReply(f"Expected a frame of {wanted} bytes, got {len(frame)}. Ask again.")
    (transaction,) = struct.unpack_from(">H", frame)
    return Frame(transaction, frame[6], frame[7], frame[8:])


def _reply(frame: bytes, transaction: int, function: int) -> bytes:
    reply = parse_frame(frame)
    if reply.transaction != transaction & 0xFFFF:
        raise BadReply(
            f"Expected the answer to request {transaction & 0xFFFF}, got one to "
            f"{reply.transaction}. Flush and ask again."
        )
    if reply.function == function | 0x80 and len(reply.data) == 1:
        raise ModbusException(function, reply.data[0])
    if reply.function != function:
        raise BadReply(
            f"Expected Modbus function {function}, got {reply.function}. Flush and ask again."
        )
    return reply.data


def parse_read(frame: bytes, transaction: int, count: int) -> bytes:
    """Bytes of the ``count`` registers that the answer to a read holds.

    Raises
    ------
    BadReply
        If it is no answer to that request, or its size is not the one asked for.
    ModbusException
        If the device refused.
    """
    data = _reply(frame, transaction, READ)
    if not data or data[0] != 2 * count or len(data) != 2 * count + 1:
        raise BadReply(f"Expected {2 * count} bytes of registers, got {data.hex()!r}. Ask again.")
    return data[1:]


def parse_write(frame: bytes, transaction: int, address: int, count: int) -> None:
    """Check the answer to a write; errors as in `parse_read`."""
    data = _reply(frame, transaction, WRITE)
    if data != struct.pack(">HH", address, count):
        raise BadReply(
            f"Expected {count} registers written at {address}, got {data.hex()}. Read them back."
        )


def parse_feedback(frame: bytes, transaction: int, parts: Sequence[Read | Write]) -> list[bytes]:
    """Bytes of each read of a feedback request, in their order; errors as in `parse_read`."""
    data = _reply(frame, transaction, FEEDBACK)
    sizes = [2 * part.count for part in parts if isinstance(part, Read)]
    if len(data) != sum(sizes):
        raise BadReply(f"Expected {sum(sizes)} bytes of reads, got {len(data)}. Ask again.")
    found, start = [], 0
    for size in sizes:
        found.append(data[start : start + size])
        start += size
    return found
