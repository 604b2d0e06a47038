"""What every driver shares: errors, one repeated question, read-back of settings, a safe end."""

from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")


class InstrumentError(OSError):
    """Something is wrong with an instrument or with the way to it."""


class InstrumentTimeout(InstrumentError):
    """Nothing, or not enough, came back in time."""


class ConnectionLost(InstrumentError):
    """The other end has gone."""


class BadReply(InstrumentError):
    """What came back is not what the protocol allows: cut, garbled, or for another request."""


class Refused(InstrumentError):
    """The device refused, or silently kept another setting."""


class Unsafe(InstrumentError):
    """The interlock is open, the lock is lost, or a watchdog has tripped."""


class Device:
    """An instrument with a name, a safe state and a connection to close."""

    def __init__(self, name: str) -> None:
        self.name = name

    def safe_state(self) -> None:
        """Bring the device to where it can hurt nobody; may be called at any time, and again."""

    def close(self) -> None:
        """Close the connection; may be called again."""

    def _resynchronise(self) -> None:
        """Make sure that the next answer is that to the next question."""

    def _read(self, ask: Callable[[], T]) -> T:
        """Ask, and once more after a lost or garbled answer: only where nothing moves by it."""
        try:
            return ask()
        except (InstrumentTimeout, BadReply):
            self._resynchronise()
        return ask()

    def _expect(self, what: str, wanted: float, found: float, tolerance: float = 0.0) -> None:
        """Raise `Refused` unless a device reads back what was set."""
        if not abs(found - wanted) <= tolerance:  # a comparison that NaN fails
            raise Refused(
                f"Expected {self.name} to set its {what} to {wanted:.9g}, got {found:.9g}. "
                "Give a value that the device takes."
            )


def insist(act: Callable[[], object], tries: int = 2) -> None:
    """Do what only ever makes things safer, again after a failure; the last failure is raised."""
    for left in reversed(range(tries)):
        try:
            act()
            return
        except OSError:
            if not left:
                raise


def insist_on_all(acts: list[Callable[[], object]]) -> None:
    """Do each of some safe acts, even if another fails; then raise `Refused` for those that did."""
    failed = []
    for act in acts:
        try:
            insist(act)
        except OSError as failure:
            failed.append(str(failure))
    if failed:
        raise Refused(" ".join(failed))


def number(text: str) -> float:
    """Finite number at the start of a reply, its unit behind it ignored.

    Examples
    --------
    >>> number("1.5E+7HZ"), number(" -0.25")
    (15000000.0, -0.25)
    """
    digits = text.strip().rstrip("ABCDFGHIJKLMNOPQRSTUVWXYZabcdfghijklmnopqrstuvwxyz")
    try:
        value = float(digits)
    except ValueError:
        value = float("nan")
    if not abs(value) < 9e36:  # 9.9E+37 stands for overload
        raise BadReply(f"Expected a number, got {text[:60]!r}. Ask again.")
    return value
