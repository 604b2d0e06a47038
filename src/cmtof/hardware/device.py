"""Base of all drivers: errors of one pattern, limits, repeated queries, read-back."""

import errno
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import wraps
from typing import Any, ClassVar, NoReturn

from cmtof.types import Pair, Texts


class InstrumentError(OSError):
    """Error of an instrument or of the connection to it."""


class InstrumentTimeout(InstrumentError):
    """Nothing, or not enough, came back in time."""


class ConnectionLost(InstrumentError):
    """The device cannot be reached, or no longer."""


class BadReply(InstrumentError):
    """What came back is not what the protocol allows: cut, garbled, or for another request."""


class Refused(InstrumentError):
    """The device refused, or silently kept another setting."""


class Unsafe(InstrumentError):
    """Not safe to go on: interlock, lock, watchdog, clock, laser power, or a stopped move."""


_LATE = {"SerialTimeoutException", "TimeoutError"}
_GONE = {"OSError", "VisaIOError", "InvalidSession"}
_PATTERNS = {
    InstrumentTimeout: "Expected an answer of {} in time, got none. Check power and cable.",
    ConnectionLost: "Expected {} to be there, got {}. Check address and cable.",
    BadReply: "Expected a whole answer of {}, got {}. Ask again.",
}


@contextmanager
def one_error(name: str, otherwise: type[InstrumentError] = BadReply) -> Iterator[None]:
    """Context that turns errors of pyserial, PyVISA, sockets and parsing into `InstrumentError`."""
    try:
        yield
    except InstrumentError:
        raise
    except Exception as error:
        # of their classes, without their libraries
        names = {kind.__name__ for kind in type(error).__mro__}
        late = names & _LATE or "VI_ERROR_TMO" in str(error)
        kind = (
            InstrumentTimeout
            if late
            else ConnectionLost
            if names & _GONE
            else otherwise
        )
        message = _PATTERNS[kind].format(name, " ".join(str(error).split())[:200])
        hints = [HINTS.get(getattr(error, "errno", 0), "")]
        hints += [hint for words, hint in PHRASES.items() if words in str(error)]
        raise kind(" ".join(filter(None, [message, *hints]))) from None


# Advice against errors of the operating system, by number, and of libraries, by their words.
HINTS = {
    errno.EACCES: (
        "Add yourself to the group dialout (`sudo usermod -aG dialout $USER`) and log in again; "
        "for USB add a udev rule."
    ),
    errno.ENOENT: "See which ports there are: ls -l /dev/serial/by-id.",
    errno.EAGAIN: "Another program has it: close that.",
    errno.EBUSY: "Another program has it: close that.",
    errno.ECONNREFUSED: "Something is there, but does not listen: check the port.",
    errno.EHOSTUNREACH: "Nothing is there: check network and address.",
}
PHRASES = {
    "install PyUSB": "Install it: pip install 'cmtof[hardware]'.",
    "VI_ERROR_RSRC_NFOUND": "List what VISA finds: pyvisa-shell -b py, then list.",
    "No backend available": "Install libusb (Debian: apt install libusb-1.0-0).",
}


class Device:
    """An instrument behind a connection; a given ``serial_number`` has to be its own."""

    # beginnings of the names that the driver takes
    MODELS: ClassVar[tuple[str, ...]] = ()
    LIMITS: ClassVar[Mapping[str, Pair]] = {}  # of settings, in SI units

    def __init__(self, connection: Any, name: str, serial_number: str = "") -> None:
        self._connection = connection
        self.name = name
        self._serial_number = serial_number

    def close(self) -> None:
        """Close the connection; may be called again."""
        self._connection.close()

    def safe_state(self) -> None:
        """Bring the device into its safe state; may be called at any time, and again."""

    def identify(self) -> Texts:
        """Model, serial number and more that the device reports; `Refused` if it is another one."""
        found = self._identity()  # type: ignore[attr-defined]
        model = found["model"]
        serial_number = found["serial_number"]
        if self._serial_number not in ("", serial_number) or not model.startswith(
            self.MODELS
        ):
            self._fail(
                Refused,
                f"be {' or '.join(self.MODELS)} {self._serial_number}",
                f"{model} {serial_number}",
                "Check the address.",
            )
        return found

    def _resynchronise(self) -> None:
        """Discard late answers, so that the next answer belongs to the next question."""

    def _within(self, **settings: float) -> None:
        """Raise a ValueError for a setting, by name, beyond its `LIMITS`."""
        for what, value in settings.items():
            low, high = self.LIMITS[what]
            if not low <= value <= high:
                raise ValueError(
                    f"Expected {what} of {self.name} from {low:g} to {high:g}, got {value:g}. "
                    "Stay within."
                )

    def _expect(
        self, what: str, wanted: float, found: float, tolerance: float = 0.0
    ) -> None:
        """Raise `Refused` unless ``found``, read back, is ``wanted`` within the tolerance."""
        if not abs(found - wanted) <= tolerance:  # a comparison that NaN fails
            self._fail(
                Refused,
                f"set its {what} to {wanted:.9g}",
                f"{found:.9g}",
                "Check value and wiring.",
            )

    def _fail(
        self, kind: type[InstrumentError], wish: str, got: str, remedy: str
    ) -> NoReturn:
        raise kind(f"Expected {self.name} to {wish}, got {got[:80]}. {remedy}")


def question(ask: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator for requests that change nothing: ask again if the answer is lost or garbled."""

    @wraps(ask)
    def asked(self: Device, *arguments: Any) -> Any:
        try:
            return ask(self, *arguments)
        except (InstrumentTimeout, BadReply):
            self._resynchronise()
        return ask(self, *arguments)

    return asked


def insist(*acts: Callable[[], object], tries: int = 2) -> None:
    """Run actions that only increase safety, each up to ``tries`` times; raise what failed.

    After an act that stays without an answer the rest is left out: each would wait as long. With
    one try the acts are those of several devices, and none is left out.
    """
    failures: list[OSError] = []
    for act in acts:
        for left in reversed(range(tries)):
            try:
                act()
                break
            except OSError as failure:
                if not left:
                    failures.append(failure)
        else:
            if tries > 1 and isinstance(failures[-1], InstrumentTimeout):
                break
    if failures:
        raise (
            failures[0] if len(failures) == 1 else Refused(" ".join(map(str, failures)))
        )


def number(text: str) -> float:
    """Finite number at the start of a reply such as ``1.5E+7HZ``; its unit is ignored."""
    found = re.match(r"\s*[-+]?\d+\.?\d*([eE][-+]?\d+)?", text)
    value = float(found[0]) if found else float("nan")
    if not abs(value) < 9e36:  # 9.9E+37 stands for overload
        raise BadReply(f"Expected a number, got {text[:60]!r}. Ask again.")
    return value
