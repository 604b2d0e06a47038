"""What a line to an instrument can do, and what all lines share: a buffer and deadlines."""

import time
from abc import ABC, abstractmethod
from importlib import import_module
from typing import Any, Protocol

from cmtof.hardware.errors import BadReply, ConnectionLost, InstrumentError, InstrumentTimeout


class Transport(Protocol):
    """A two-way line of bytes. Times are in seconds.

    All methods raise `ConnectionLost` when the other end is gone, until `reconnect` succeeds.
    """

    def write(self, data: bytes) -> None:
        """Send all of the bytes."""
        ...

    def read_exact(self, size: int, timeout: float) -> bytes:
        """Exactly ``size`` bytes; `InstrumentTimeout` says how many came and keeps them."""
        ...

    def read_until(self, end: bytes, timeout: float, limit: int = 65536) -> bytes:
        """All up to and including ``end``; `BadReply` past ``limit`` bytes without it."""
        ...

    def flush(self) -> bytes:
        """Drop what has arrived, and return it."""
        ...

    def reconnect(self) -> None:
        """Close and open anew; what had arrived is dropped."""
        ...

    def close(self) -> None:
        """Close; again is harmless."""
        ...


class Buffered(ABC):
    """What all transports share: bytes that have arrived but were not asked for yet.

    A subclass gives ``name``, ``write`` and ``_receive``: what arrives within a time, b"" for
    nothing, `ConnectionLost` at the end of the line; ``_open`` and ``_shut`` where there is
    something to open.
    """

    name = ""

    def __init__(self) -> None:
        self._arrived = bytearray()

    def _open(self) -> None:  # noqa: B027 - a recorded dialogue has nothing to open
        ...

    def _shut(self) -> None:  # noqa: B027
        ...

    @abstractmethod
    def _receive(self, timeout: float) -> bytes: ...

    def read_exact(self, size: int, timeout: float) -> bytes:
        """Exactly ``size`` bytes; `InstrumentTimeout` says how many came and keeps them."""
        deadline = time.monotonic() + timeout
        while len(self._arrived) < size:
            self._more(deadline, f"{size} bytes", timeout)
        return self._take(size)

    def read_until(self, end: bytes, timeout: float, limit: int = 65536) -> bytes:
        """All up to and including ``end``; `BadReply` past ``limit`` bytes without it."""
        deadline = time.monotonic() + timeout
        searched = 0
        while (found := self._arrived.find(end, searched)) < 0:
            if len(self._arrived) >= limit:
                start = bytes(self._arrived[:40])
                raise BadReply(
                    f"Expected {end!r} within {limit} bytes from {self.name}, got {start!r}... "
                    "Flush and ask again."
                )
            searched = max(0, len(self._arrived) - len(end) + 1)
            self._more(deadline, f"a reply that ends in {end!r}", timeout)
        return self._take(found + len(end))

    def _more(self, deadline: float, wanted: str, timeout: float) -> None:
        """Wait for more bytes, once: at least what has already arrived is looked at."""
        data = self._receive(max(0.0, deadline - time.monotonic()))
        if not data:
            raise InstrumentTimeout(
                f"Expected {wanted} from {self.name} within {timeout:g} s, got "
                f"{len(self._arrived)} bytes. Check power and cable, then ask again."
            )
        self._arrived += data

    def _take(self, size: int) -> bytes:
        data = bytes(self._arrived[:size])
        del self._arrived[:size]
        return data

    def flush(self) -> bytes:
        """Drop what has arrived, and return it."""
        while data := self._receive(0.0):
            self._arrived += data
        return self._take(len(self._arrived))

    def reconnect(self) -> None:
        """Close and open anew; what had arrived is dropped."""
        self.close()
        self._open()

    def close(self) -> None:
        """Close; again is harmless."""
        self._shut()
        self._arrived.clear()

    def _lost(self, reason: object) -> ConnectionLost:
        self._shut()
        return ConnectionLost(
            f"Expected an open line to {self.name}, got «{reason}». "
            "Check that the device is on, then reconnect."
        )


def imported(module: str, package: str, extra: str | None) -> Any:
    """Import what only this kind of line needs."""
    try:
        return import_module(module)
    except ImportError:
        how = f"cmtof[{extra}]" if extra else package
        raise InstrumentError(
            f"Expected the package {package} for this address, got none. pip install {how}."
        ) from None
