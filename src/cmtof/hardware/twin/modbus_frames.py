"""Modbus TCP as a LabJack T7 serves it: functions 3, 4, 6, 16 and 76, and exceptions.

Sources: Modbus Application Protocol V1.1b3 and Messaging on TCP/IP V1.0b; LabJack, «Protocol
Details [Direct Modbus TCP]»: packets up to 1040 bytes over Ethernet, function 76 («Modbus
Feedback») with frames ``type (0 read, 1 write), address u16, registers u8, data``.
"""

import struct
from typing import Protocol

HEADER_SIZE = 7
"""Transaction, protocol, length, unit: the MBAP header."""
_PACKET = 1040
_FEW = 127  # registers whose bytes one byte can count

ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE, DEVICE_FAILURE = 1, 2, 3, 4


class ModbusError(Exception):
    """An exception reply: Modbus' code and LabJack's own for LAST_ERR_DETAIL."""

    def __init__(self, code: int, detail: int = 0) -> None:
        super().__init__(code, detail)
        self.code, self.detail = code, detail


class Map(Protocol):
    """What the functions act on: 16-bit registers."""

    def read(self, address: int, count: int) -> bytes:
        """Bytes of ``count`` registers."""
        ...

    def write(self, address: int, data: bytes) -> None:
        """Set as many registers as there are pairs of bytes."""
        ...


def split_frames(buffer: bytes) -> tuple[list[bytes], bytes]:
    """Whole frames at the head of a buffer, and the rest; what cannot be a frame is thrown away.

    Examples
    --------
    >>> split_frames(bytes.fromhex("0007 0000 0006 01 03 0000 0008 00"))
    ([b'\\x00\\x07\\x00\\x00\\x00\\x06\\x01\\x03\\x00\\x00\\x00\\x08'], b'\\x00')
    >>> split_frames(b"GET / HTTP/1.0")  # not protocol 0
    ([], b'')
    """
    frames = []
    while len(buffer) >= HEADER_SIZE:
        protocol, length = struct.unpack_from(">HH", buffer, 2)
        if protocol != 0 or not 2 <= length <= _PACKET - 6:
            return frames, b""
        if len(buffer) < 6 + length:
            break
        frames.append(buffer[: 6 + length])
        buffer = buffer[6 + length :]
    return frames, buffer


def reply_to(frame: bytes, registers: Map) -> tuple[bytes, ModbusError | None]:
    """Carry out a frame: its reply, and the exception where there was one."""
    function, body = frame[HEADER_SIZE], frame[HEADER_SIZE + 1 :]
    error = None
    try:
        data = bytes([function]) + _carry_out(function, body, registers)
    except ModbusError as raised:
        error, data = raised, bytes([function | 0x80, raised.code])
    return frame[:4] + struct.pack(">HB", len(data) + 1, frame[6]) + data, error


def _carry_out(function: int, body: bytes, registers: Map) -> bytes:
    if function in (3, 4):
        return _read(body, registers)
    if function == 6:
        if len(body) != 4:
            raise ModbusError(ILLEGAL_VALUE)
        registers.write(struct.unpack_from(">H", body)[0], body[2:])
        return body
    if function == 16:
        return _write(body, registers)
    if function == 76:
        return _feedback(body, registers)
    raise ModbusError(ILLEGAL_FUNCTION)


def _read(body: bytes, registers: Map) -> bytes:
    if len(body) != 4:
        raise ModbusError(ILLEGAL_VALUE)
    address, count = struct.unpack(">HH", body)
    if not 1 <= count <= _FEW:
        raise ModbusError(ILLEGAL_VALUE)
    return bytes([2 * count]) + registers.read(address, count)


def _write(body: bytes, registers: Map) -> bytes:
    if len(body) < 5:
        raise ModbusError(ILLEGAL_VALUE)
    address, count, size = struct.unpack_from(">HHB", body)
    if not 1 <= count <= 123 or size != 2 * count or len(body) != 5 + size:
        raise ModbusError(ILLEGAL_VALUE)
    registers.write(address, body[5:])
    return body[:4]


def _feedback(body: bytes, registers: Map) -> bytes:
    """Frames in their order; those before one that fails have been carried out."""
    read, place = b"", 0
    while place < len(body):
        if len(body) < place + 4:
            raise ModbusError(ILLEGAL_VALUE)
        kind, address, count = struct.unpack_from(">BHB", body, place)
        place += 4
        if kind not in (0, 1) or not count:
            raise ModbusError(ILLEGAL_VALUE)
        if kind == 0:
            read += registers.read(address, count)
            if len(read) > _PACKET - HEADER_SIZE - 1:
                raise ModbusError(ILLEGAL_VALUE)
            continue
        data = body[place : place + 2 * count]
        place += 2 * count
        if len(data) != 2 * count:
            raise ModbusError(ILLEGAL_VALUE)
        registers.write(address, data)
    return read
