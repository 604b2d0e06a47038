"""A recorded dialogue in place of an instrument, for tests and for bug reports."""

from collections.abc import Iterable

from cmtof.hardware.errors import InstrumentError
from cmtof.hardware.transport.buffered import Buffered


class ReplayTransport(Buffered):
    """Plays a recorded dialogue, strictly: each write must be the next that was recorded.

    Parameters
    ----------
    dialogue : iterable of (bytes, bytes or InstrumentError)
        What the host writes and what the device answers; an error is raised at the next read. A
        step that writes b"" is unsolicited: its answer is there once the step before is done.

    Raises
    ------
    AssertionError
        From `write` when it does not follow the dialogue, from `finish` when something is left.

    Examples
    --------
    >>> line = ReplayTransport([(b"*IDN?\\n", b"THORLABS,PM100D,P0,2.6.0\\n")])
    >>> line.write(b"*IDN?\\n")
    >>> line.read_until(b"\\n", 1.0)
    b'THORLABS,PM100D,P0,2.6.0\\n'
    >>> line.finish()
    """

    name = "the recorded dialogue"

    def __init__(self, dialogue: Iterable[tuple[bytes, bytes | InstrumentError]]) -> None:
        super().__init__()
        self._steps = list(dialogue)
        self._waiting: list[bytes | InstrumentError] = []
        self.reconnects = 0
        self._unsolicited()

    def _unsolicited(self) -> None:
        while self._steps and not self._steps[0][0]:
            self._waiting.append(self._steps.pop(0)[1])

    def write(self, data: bytes) -> None:
        """Compare with the dialogue and queue the answer."""
        expected = self._steps[0][0] if self._steps else b""
        if data != expected:
            raise AssertionError(
                f"Expected {expected!r} to be written, got {data!r}. "
                "Compare the driver with the dialogue."
            )
        self._waiting.append(self._steps.pop(0)[1])
        self._unsolicited()

    def _receive(self, timeout: float) -> bytes:
        while self._waiting:
            answer = self._waiting.pop(0)
            if isinstance(answer, InstrumentError):
                raise answer
            if answer:
                return answer
        return b""  # at once: nothing more will come

    def reconnect(self) -> None:
        """Count; the dialogue goes on."""
        self._arrived.clear()
        self.reconnects += 1

    def finish(self) -> None:
        """Check that everything was written and read."""
        left = [answer for answer in self._waiting if answer]
        if self._steps or left or self._arrived:
            raise AssertionError(
                f"Expected the dialogue to be over, got {len(self._steps)} steps not written and "
                f"{bytes(self._arrived)!r}, {left!r} not read. Compare it with the driver."
            )
