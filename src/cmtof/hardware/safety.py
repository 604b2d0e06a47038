"""The emergency stop: however a program ends, every device reaches its safe state."""

import atexit
import signal
import sys
import threading
from collections.abc import Collection
from concurrent.futures import ThreadPoolExecutor
from time import monotonic
from typing import Any, Self

from cmtof.hardware.device import Unsafe

_NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")  # Windows lacks the last two
_SIGNALS = [one for one in signal.Signals if one.name in _NAMES]
PAUSE = 2.0  # s after a signal in which the next is taken for impatience


def _stop_device(device: Any) -> str:
    """Bring a device into its safe state; return an empty text, or why it failed."""
    try:
        device.safe_state()
    except Exception as failure:
        return f"{device.name}: {failure}"
    return ""


class EmergencyStop:
    """Context that brings devices into their safe states however it ends, also by a signal.

    The devices are those that the collection holds at the end.

    All devices are stopped at the same time, each in a thread of its own: one that does not answer
    delays no other. A signal raises in the main thread, so that no request is sent into the middle
    of another, and the stop runs while the context is left; signals that come then are ignored. If
    something swallows what a signal raised, a later one raises again.
    Against SIGKILL the devices have watchdogs of their own.
    """

    def __init__(self, devices: Collection[Any]) -> None:
        self._devices = devices
        self._previous = {}
        self._signalled = -PAUSE

    def __enter__(self) -> Self:
        atexit.register(self.__exit__, None, None, None)
        if threading.current_thread() is threading.main_thread():
            self._previous = {
                one: signal.signal(one, self._on_signal) for one in _SIGNALS
            }
        return self

    def __exit__(
        self, kind: object, error: BaseException | None, trace: object
    ) -> None:
        try:
            for number in self._previous:
                signal.signal(number, signal.SIG_IGN)
        finally:  # also if a signal comes here
            self._stop(error)

    def _stop(self, error: BaseException | None) -> None:
        """Make all devices safe; raise `Unsafe`, after ``error``, if some are not."""
        failures = self._make_safe()
        atexit.unregister(self.__exit__)
        for number, previous in self._previous.items():
            signal.signal(number, previous)
        self._previous = {}
        message = (
            f"Expected every device in its safe state, got {len(failures)} that are not: "
            f"{' | '.join(failures)} Switch them off by hand."
        )
        if failures and (error is None or isinstance(error, Exception)):
            raise Unsafe(f"{error} Then: {message}" if error else message) from error
        # Ctrl-C and exit codes go on as they are, but nobody may overlook this
        if failures:
            print(message, file=sys.stderr)

    def _make_safe(self) -> list[str]:
        """Bring all devices into their safe states at once; return the messages of failures."""
        try:
            with ThreadPoolExecutor(max(len(self._devices), 1)) as pool:
                messages = list(pool.map(_stop_device, self._devices))
        except RuntimeError:  # the interpreter is ending and starts no more threads
            messages = [_stop_device(device) for device in self._devices]
        return [failure for failure in messages if failure]

    def _on_signal(self, number: int, frame: object) -> None:
        """Raise KeyboardInterrupt for Ctrl-C, else SystemExit with 128 plus the signal's number."""
        if monotonic() - self._signalled < PAUSE:
            return
        self._signalled = monotonic()
        raise KeyboardInterrupt if number == signal.SIGINT else SystemExit(128 + number)
