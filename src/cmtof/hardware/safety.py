"""The emergency stop: however a program ends, every device reaches its safe state."""

import atexit
import signal
import sys
import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Self

from cmtof.hardware.device import Unsafe

_NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")  # Windows lacks the last two
_SIGNALS = tuple(getattr(signal, name) for name in _NAMES if hasattr(signal, name))


def _stopped(device: Any) -> str:
    """Why a device did not reach its safe state: one that fails must not keep the others."""
    try:
        device.safe_state()
    except Exception as failure:
        return f"{device.name}: {failure}"
    return ""


class EmergencyStop:
    """Safe states of devices on exit, exception, Ctrl-C, kill, and the end of the program.

    All devices are stopped at the same time, each in a thread of its own: one that does not answer
    delays no other. A signal raises in the main thread, so that no request is sent into the middle
    of another, and the stop runs while the context is left; signals that come then are ignored.
    Against SIGKILL stand the devices' timers.
    """

    def __init__(self, devices: Sequence[Any]) -> None:
        self._devices = list(devices)
        self._previous = {}

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
        self._ignore_signals()
        failed = self._make_safe()
        atexit.unregister(self.__exit__)
        for number, previous in self._previous.items():
            signal.signal(number, previous)
        self._previous = {}
        message = (
            f"Expected every device in its safe state, got {len(failed)} that are not: "
            f"{' | '.join(failed)} Switch them off by hand."
        )
        if failed and (error is None or isinstance(error, Exception)):
            raise Unsafe(f"{error} Then: {message}" if error else message) from error
        # Ctrl-C and exit codes go on as they are, but nobody may overlook this
        if failed:
            print(message, file=sys.stderr)

    def _make_safe(self) -> list[str]:
        """Bring all devices into their safe states at once; return what did not succeed."""
        try:
            with ThreadPoolExecutor(len(self._devices)) as pool:
                told = list(pool.map(_stopped, self._devices))
        except RuntimeError:  # the interpreter is ending and starts no more threads
            told = [_stopped(device) for device in self._devices]
        return [failure for failure in told if failure]

    def _ignore_signals(self) -> None:
        for number in self._previous:
            signal.signal(number, signal.SIG_IGN)

    def _on_signal(self, number: int, frame: object) -> None:
        """Raise what a signal stands for: exit code 130 for Ctrl-C, else 128 and its number."""
        self._ignore_signals()
        raise KeyboardInterrupt if number == signal.SIGINT else SystemExit(128 + number)
