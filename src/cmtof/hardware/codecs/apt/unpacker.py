"""From a stream of bytes to APT messages, across garbage."""

import struct

from cmtof.hardware.codecs.apt.ids import HEADER_SIZE, HOST, LONG, SOURCES
from cmtof.hardware.codecs.apt.message import Message, message_from_bytes
from cmtof.hardware.codecs.apt.replies import SIZES


class Unpacker:
    """Cuts a stream of bytes into messages and finds its feet again after garbage.

    A message must have a known identifier, a size that this identifier can have, the host (or
    nobody, 0) as destination and a unit as source; else one byte is dropped and the next tried.

    Attributes
    ----------
    skipped : int
        Bytes dropped so far.

    Examples
    --------
    >>> unpacker = Unpacker()
    >>> unpacker.feed(bytes.fromhex("ff 44 04 01"))
    []
    >>> [m.parameters for m in unpacker.feed(bytes.fromhex("00 01 50"))], unpacker.skipped
    ([(1, 0)], 1)
    """

    def __init__(self) -> None:
        self._buffer = bytearray()
        self.skipped = 0

    def feed(self, data: bytes) -> list[Message]:
        """Messages that are complete with these bytes."""
        self._buffer += data
        found, start = [], 0
        while len(self._buffer) - start >= HEADER_SIZE:
            size = self._size(start)
            if size is None:
                start += 1
                self.skipped += 1
            elif len(self._buffer) - start < size:
                break
            else:
                found.append(message_from_bytes(bytes(self._buffer[start : start + size])))
                start += size
        del self._buffer[:start]
        return found

    def _size(self, start: int) -> int | None:
        """Bytes of the message that begins here, None if none does."""
        id_, length, destination, source = struct.unpack_from("<HHBB", self._buffer, start)
        sizes = SIZES.get(id_, ())
        if destination & ~LONG not in (0, HOST) or source not in SOURCES:
            return None
        if destination & LONG:
            return HEADER_SIZE + length if length in sizes else None
        return HEADER_SIZE if None in sizes else None

    def reset(self) -> bytes:
        """Drop an unfinished message, and return its bytes."""
        dropped = bytes(self._buffer)
        self._buffer.clear()
        return dropped
