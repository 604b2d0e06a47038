"""Lines of text out of a stream of bytes, and numbers out of text, as careful firmware does it."""

import re
from collections.abc import Callable

from cmtof.hardware.twin.lines import Channel

_NUMBER = re.compile(r"[+-]?(\d{1,20}\.?\d{0,20}|\.\d{1,20})([eE][+-]?\d{1,3})?", re.ASCII)


class LineBuffer:
    """Cuts what arrives at newlines; a line without an end is given up at ``limit`` bytes.

    Examples
    --------
    >>> buffer = LineBuffer(limit=8)
    >>> buffer.feed(b"*IDN?\\r\\nC1:BS"), buffer.feed(b"WV?\\n")
    ([b'*IDN?'], [b'C1:BSWV?'])
    >>> buffer.feed(b"x" * 100), buffer.feed(b"yz\\nMODE?\\n")
    ([], [b'xxxxxxxx', b'MODE?'])
    """

    def __init__(self, limit: int = 4096) -> None:
        self._limit = limit
        self._rest = b""

    def feed(self, data: bytes) -> list[bytes]:
        """Complete lines so far, without their ends; one that is too long is cut."""
        *lines, rest = (self._rest + data).split(b"\n")
        self._rest = rest[: self._limit]
        return [line.rstrip(b"\r")[: self._limit] for line in lines]


def serve_lines(channel: Channel, answer: Callable[[str, Channel], None]) -> None:
    """Hand every line that is not blank to ``answer``, until the client has gone."""
    lines = LineBuffer()
    while data := channel.receive():
        for line in lines.feed(data):
            if line.strip():
                answer(line.decode("ascii", "replace"), channel)


def number_from_text(text: str) -> float | None:
    """Finite number that the whole text is, or None.

    Examples
    --------
    >>> number_from_text("7.15e9"), number_from_text("nan"), number_from_text("1_0")
    (7150000000.0, None, None)
    """
    text = text.strip()
    if not _NUMBER.fullmatch(text):
        return None
    value = float(text)
    return value if abs(value) < 1e300 else None
