"""The emergency stop: however a program ends, every device reaches its safe state."""

import atexit
import signal
import sys
import threading
from collections.abc import Sequence
from typing import Any, Self

from cmtof.hardware.device import Unsafe

SIGNALS = tuple(
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")
    if hasattr(signal, name)  # Windows lacks two of them
)
"""Signals that lead to the stop: Ctrl-C, kill, a closed terminal, Ctrl-backslash."""


class EmergencyStop:
    """Safe states of devices on exit, exception, each of `SIGNALS` and the end of the program.

    ``devices`` have a ``name`` and a ``safe_state()`` and are stopped in their order: what sends
    out light first. A signal does no work itself: it raises in the main thread, so that no request
    is sent into the middle of another, and the stop runs while the context is left; signals that
    come then wait for its end. Against SIGKILL stand the devices' own timers.
    """

    def __init__(self, devices: Sequence[Any]) -> None:
        self._devices = list(devices)
        self._previous: dict[int, Any] = {}

    def __enter__(self) -> Self:
        self._stopping, self._pending = False, 0
        atexit.register(self.__exit__, None, None, None)
        if threading.current_thread() is threading.main_thread():
            self._previous = {one: signal.signal(one, self._on_signal) for one in SIGNALS}
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        self._stopping, failed = True, []
        for device in self._devices:
            try:
                device.safe_state()
            except Exception as failure:  # one that fails must not keep the others running
                failed.append(f"{device.name}: {failure}")
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
        if failed:  # Ctrl-C and exit codes go on as they are, but nobody may overlook this
            print(message, file=sys.stderr)
        if self._pending and error is None:
            _raise(self._pending)

    def _on_signal(self, number: int, frame: object) -> None:
        if self._stopping:
            self._pending = number
        else:
            _raise(number)


def _raise(number: int) -> None:
    """Raise what a signal stands for: exit code 130 for Ctrl-C, else 128 and its number."""
    raise KeyboardInterrupt if number == signal.SIGINT else SystemExit(128 + number)
