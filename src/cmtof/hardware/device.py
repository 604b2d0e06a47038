"""What every driver does: read again where nothing moves, check what was set, end safely."""

from collections.abc import Callable
from types import TracebackType
from typing import Self, TypeVar

from cmtof.hardware.errors import (
    BadReply,
    ConnectionLost,
    InstrumentError,
    InstrumentTimeout,
    Refused,
)
from cmtof.hardware.transport import Transport

T = TypeVar("T")

QUERY_TIMEOUT = 1.0
"""How long a device may take to answer a question, s."""


class Device:
    """An instrument behind one or more transports, and a context manager.

    Leaving the context brings the device into its safe state and closes its transports, whatever
    happened inside.

    Parameters
    ----------
    name : str
        What messages call it.
    *transports : Transport
        Closed with the device.
    """

    def __init__(self, name: str, *transports: Transport) -> None:
        self.name = name
        self._transports = transports
        self._lost = False

    def safe_state(self) -> None:
        """Bring the device to where it can hurt nobody; may be called at any time, and again."""

    def close(self) -> None:
        """Close the transports; may be called again."""
        for transport in self._transports:
            transport.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        failed: list[str] = []
        for step in (self.safe_state, self.close):
            try:
                step()
            except Exception as failure:  # the second step must run whatever the first met
                failed.append(str(failure))
        if not failed:
            return
        message = (
            f"Expected {self.name} in its safe state, got: {'; '.join(failed)} "
            "Switch it off by hand."
        )
        if error is None:
            raise InstrumentError(message)
        error.add_note(message)

    def _read(self, read: Callable[[], T]) -> T:
        """Read, and read once more if the reply was late, cut, garbled or the connection lost.

        Only for reads that change nothing in the device: never for a move or an output.
        """
        try:
            return self._act(read)
        except ConnectionLost:
            pass
        except (InstrumentTimeout, BadReply):
            self._resynchronise()
        return self._act(read)

    def _act(self, act: Callable[[], T]) -> T:
        """Do what must not be done twice; open the connection anew first if it is known as lost."""
        if self._lost:
            for transport in self._transports:
                transport.reconnect()
            self._lost = False
            self._reconnected()
        try:
            return act()
        except ConnectionLost:
            self._lost = True
            raise

    def _insist(self, act: Callable[[], object], tries: int = 2) -> None:
        """Do what only ever makes things safer, again after a failure."""

        def anew() -> None:
            self._drop()
            act()

        insist(lambda: self._act(anew), tries)

    def _reconnected(self) -> None:
        """Do what the device wants after its connection was opened anew."""

    def _resynchronise(self) -> None:
        """Make sure that the next answer is that to the next question."""
        self._drop()

    def _drop(self) -> None:
        """Drop what has arrived: it may belong to a request that went wrong or was interrupted."""
        for transport in self._transports:
            transport.flush()


def insist(act: Callable[[], object], tries: int = 2) -> None:
    """Do what only ever makes things safer, again after a failure; the last failure is raised."""
    for left in reversed(range(tries)):
        try:
            act()
            return
        except OSError:
            if not left:
                raise


def check_set(
    device: str, quantity: str, wanted: float, found: float, *, tolerance: float, unit: str
) -> float:
    """Return what a device reads back, or raise if it silently kept or clamped the setting.

    Parameters
    ----------
    device, quantity, unit : str
        For the message.
    wanted, found : float
        What was set and what was read back.
    tolerance : float
        Largest difference, in the same unit.

    Raises
    ------
    Refused
        If they differ by more, or the reading is not a number.

    Examples
    --------
    >>> check_set("clock", "frequency", 10e6, 10e6, tolerance=1.0, unit="Hz")
    10000000.0
    """
    if not abs(found - wanted) <= tolerance:  # a comparison that NaN fails
        raise Refused(
            f"Expected {device} to set its {quantity} to {wanted:.9g} {unit}, got {found:.9g} "
            f"{unit}. Give a value that the device takes."
        )
    return found
