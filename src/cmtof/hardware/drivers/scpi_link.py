"""Text commands to an instrument that answers a line to a question, and nothing to a command."""

from collections.abc import Callable
from typing import TypeVar

from cmtof.hardware.codecs import scpi
from cmtof.hardware.device import QUERY_TIMEOUT, Device
from cmtof.hardware.errors import BadReply, InstrumentTimeout
from cmtof.hardware.transport import Transport

T = TypeVar("T")

_LIMIT = 4096  # longest reply, bytes
_LATE = 8  # lines of old replies that are passed over


class ScpiDevice(Device):
    """What both SCPI drivers share.

    Replies carry no number, so after a lost one nobody knows whose the next line is. Then
    ``*IDN?`` is asked, and all lines before its answer are dropped.
    """

    def __init__(self, transport: Transport, name: str, *, timeout: float = QUERY_TIMEOUT) -> None:
        super().__init__(name, transport)
        self._transport = transport
        self._timeout = timeout

    def _send(self, command: str) -> None:
        """Send a command, once; the device says nothing to it."""
        self._act(lambda: self._transport.write(scpi.line_from_text(command)))

    def _query(
        self, question: str, parse: Callable[[bytes], T], *, timeout: float | None = None
    ) -> T:
        """Parsed answer; asked once more after a lost or garbled one."""
        return self._read(lambda: parse(self._ask(question, timeout or self._timeout)))

    def _ask(self, question: str, timeout: float) -> bytes:
        self._transport.flush()  # an answer that nobody waits for any more
        self._transport.write(scpi.line_from_text(question))
        return self._transport.read_until(scpi.END, timeout, _LIMIT)

    def _identity(self) -> scpi.Identity:
        return self._query("*IDN?", scpi.parse_identity)

    def _resynchronise(self) -> None:
        self._transport.flush()
        line = self._ask("*IDN?", self._timeout)
        for _ in range(_LATE):
            try:
                scpi.parse_identity(line)
                return
            except BadReply:  # still an old reply
                line = self._transport.read_until(scpi.END, self._timeout, _LIMIT)
        raise InstrumentTimeout(
            f"Expected {self.name} to say who it is, got other lines. Restart it."
        )
