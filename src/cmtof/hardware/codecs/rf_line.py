"""The RF drivers' line protocol: ASCII lines with sequence number and checksum.

Request ``>SEQ WORD arg...*CCCC``, reply ``<SEQ OK value...*CCCC`` or ``<SEQ ERR CODE text*CCCC``,
unsolicited ``!WORD arg...*CCCC``; every line ends in a newline. SEQ is 0 to 99; CCCC is the
CRC-16/CCITT-FALSE, in upper-case hexadecimal, of what stands before the asterisk. A request whose
checksum is wrong is answered ``<?? ERR CHECKSUM ...``. The words are listed in the book's hardware
guide.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Integral

from cmtof.hardware.codecs.crc import crc16
from cmtof.hardware.errors import BadReply, Refused

END = b"\n"
LIMIT = 1024
"""Longest line, bytes: the table of 64 phases needs about 400."""
SEQUENCES = 100
STEPS = 65536
"""Phase codes of one turn of the drive."""
TABLE_SIZE = 64
"""Entries of the phase table at most."""
_WORD = re.compile(r"[!-)+-~]+")  # printable, no space, no asterisk
_INTEGER = re.compile(r"[+-]?[0-9]{1,18}")
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")


@dataclass(frozen=True)
class Reply:
    """Answer to a request.

    Attributes
    ----------
    sequence : int or None
        Number of the request; None where the device could not read it.
    values : tuple of str
        What follows OK, or the words of the error's text.
    code : str
        Code of the error, "" for OK.
    """

    sequence: int | None
    values: tuple[str, ...]
    code: str = ""


@dataclass(frozen=True)
class Notice:
    """Line that the device sent unasked, as ``!TRIP DEADMAN`` or ``!LOCK 0``."""

    word: str
    arguments: tuple[str, ...]


def line_from_text(text: str) -> bytes:
    """Line with checksum and newline.

    Examples
    --------
    >>> line_from_text(">7 PING")
    b'>7 PING*9555\\n'
    """
    body = text.encode("ascii")
    return b"%s*%04X\n" % (body, crc16(body))


def request(sequence: int, word: str, *arguments: float | str) -> bytes:
    """Line of a request; floats are written so that they read back the same.

    Raises
    ------
    ValueError
        If a word is empty or holds a space, an asterisk or what is not printable ASCII.
    """
    if not 0 <= sequence < SEQUENCES:
        raise ValueError(f"Expected a sequence number 0 to 99, got {sequence}. Wrap it.")
    words = [word, *map(_text, arguments)]
    for one in words:
        if not _WORD.fullmatch(one):
            raise ValueError(f"Expected a printable word without * or space, got {one!r}. Fix it.")
    line = line_from_text(f">{sequence} {' '.join(words)}")
    if len(line) > LIMIT:
        raise ValueError(f"Expected a line to {LIMIT} bytes, got {len(line)}. Send less.")
    return line


def _text(argument: float | str) -> str:
    if isinstance(argument, str):
        return argument
    # a float of NumPy would print its type
    return str(int(argument)) if isinstance(argument, Integral) else repr(float(argument))


def parse_line(line: bytes) -> Reply | Notice:
    """Reply or notice of a line, newline included or not.

    Raises
    ------
    BadReply
        If checksum or form are wrong.
    """
    body, star, check = line.rstrip(b"\r\n").rpartition(b"*")
    if not star or len(line) > LIMIT + 2 or check != b"%04X" % crc16(body):
        raise BadReply(f"Expected a line with a true checksum, got {line[:80]!r}. Ask again.")
    try:
        words = body.decode("ascii").split(" ")
    except UnicodeDecodeError:
        raise BadReply(f"Expected ASCII, got {line[:80]!r}. Ask again.") from None
    if all(_WORD.fullmatch(word) for word in words):
        if words[0][0] == "!" and len(words[0]) > 1:
            return Notice(words[0][1:], tuple(words[1:]))
        if words[0][0] == "<":
            return _reply(words, line)
    raise BadReply(f"Expected a reply or a notice, got {line[:80]!r}. Ask again.")


def _reply(words: list[str], line: bytes) -> Reply:
    number = words[0][1:]
    known = re.fullmatch("[0-9]{1,2}", number)
    sequence = int(number) if known else None
    if known or number == "??":
        if words[1:2] == ["OK"] and known:
            return Reply(sequence, tuple(words[2:]))
        if words[1:2] == ["ERR"] and len(words) > 2:
            return Reply(sequence, tuple(words[3:]), words[2])
    raise BadReply(f"Expected OK or ERR, got {line[:80]!r}. Ask again.")


def values_from_reply(reply: Reply, sequence: int) -> tuple[str, ...]:
    """Values of the reply to a request.

    Raises
    ------
    BadReply
        If the reply is to another request, or the device received the request garbled.
    Refused
        If the device says no.
    """
    if reply.code == "CHECKSUM":
        raise BadReply("Expected the request to arrive whole, got ERR CHECKSUM. Send it again.")
    if reply.sequence != sequence:
        raise BadReply(f"Expected the reply to {sequence}, got one to {reply.sequence}. Ask again.")
    if reply.code:
        text = " ".join((reply.code, *reply.values))
        raise Refused(
            f"Expected the RF driver to obey, got ERR {text}. Check its state and limits."
        )
    return reply.values


def integers(values: Sequence[str], count: int) -> tuple[int, ...]:
    """Exactly ``count`` whole numbers of a reply's values; `BadReply` otherwise."""
    return tuple(int(value) for value in _matching(values, count, _INTEGER, "whole numbers"))


def numbers(values: Sequence[str], count: int) -> tuple[float, ...]:
    """Exactly ``count`` finite numbers of a reply's values; `BadReply` otherwise."""
    found = tuple(float(value) for value in _matching(values, count, _NUMBER, "numbers"))
    if not all(map(math.isfinite, found)):
        raise BadReply(f"Expected {count} finite numbers, got {' '.join(values)!r}. Ask again.")
    return found


def _matching(
    values: Sequence[str], count: int, pattern: re.Pattern[str], what: str
) -> Sequence[str]:
    if len(values) != count or not all(pattern.fullmatch(value) for value in values):
        raise BadReply(f"Expected {count} {what}, got {' '.join(values)!r}. Ask again.")
    return values


def switch(value: str) -> bool:
    """Truth of ON, OFF, 1 or 0; `BadReply` otherwise."""
    if value not in ("ON", "OFF", "1", "0"):
        raise BadReply(f"Expected ON, OFF, 1 or 0, got {value!r}. Ask again.")
    return value in ("ON", "1")


def code_from_phase(phase: float) -> int:
    """Phase code 0 to 65535 of a drive phase, rad; wraps.

    Examples
    --------
    >>> code_from_phase(math.pi), code_from_phase(-math.pi / 2), code_from_phase(2 * math.pi)
    (32768, 49152, 0)
    """
    if not math.isfinite(phase):
        raise ValueError(f"Expected a finite phase, got {phase}. Give it in rad.")
    return round(phase / (2 * math.pi) * STEPS) % STEPS


def phase_from_code(code: int) -> float:
    """Drive phase in [0, 2 pi), rad, of a phase code."""
    return 2 * math.pi * code / STEPS


def table_crc(codes: Sequence[int]) -> int:
    """Checksum that ``TABL?`` reports: of the codes as big-endian 16-bit words, in order."""
    return crc16(b"".join(code.to_bytes(2, "big") for code in codes))
