"""The frame of an APT message."""

import struct
from dataclasses import dataclass

from cmtof.hardware.codecs.apt.ids import HEADER_SIZE, HOST, LONG, UNIT


@dataclass(frozen=True)
class Message:
    """One message; ``data`` is None in a short one, whose parameters are then the two bytes."""

    id: int
    parameters: tuple[int, int] = (0, 0)
    data: bytes | None = None
    destination: int = UNIT
    source: int = HOST

    def to_bytes(self) -> bytes:
        """Bytes on the wire."""
        if self.data is None:
            return struct.pack("<HBBBB", self.id, *self.parameters, self.destination, self.source)
        head = (self.id, len(self.data), self.destination | LONG, self.source)
        return struct.pack("<HHBB", *head) + self.data


def message_from_bytes(data: bytes) -> Message:
    """Message of exactly its bytes."""
    id_, first, second, destination, source = struct.unpack_from("<HBBBB", data)
    if destination & LONG:
        return Message(id_, (0, 0), data[HEADER_SIZE:], destination & ~LONG, source)
    return Message(id_, (first, second), None, destination, source)
