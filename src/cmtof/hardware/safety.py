"""The emergency stop: however a program ends, every device reaches its safe state."""

import atexit
import signal
import sys
import threading
from collections.abc import Sequence
from typing import Any, Protocol, Self

from cmtof.hardware.device import Unsafe

SIGNALS = tuple(
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")
    if hasattr(signal, name)  # Windows lacks two of them
)
"""Signals that lead to the stop: Ctrl-C, kill, a closed terminal, Ctrl-backslash."""


class SafeDevice(Protocol):
    """What has a name and a safe state."""

    name: str

    def safe_state(self) -> None:
        """Bring the device to where it can hurt nobody."""
        ...


class EmergencyStop:
    """Safe states of devices on exit, exception, each of `SIGNALS` and the end of the program.

    A signal does no work itself: it raises in the main thread, so that no request is sent into the
    middle of another, and the stop runs while the context is left. Signals that come during the
    stop wait for its end. A killed process (SIGKILL) runs nothing: against that stand the RF
    drivers' dead man's timer and the read-out's watchdog.

    Parameters
    ----------
    devices : sequence of SafeDevice
        In the order in which they are stopped: what sends out light first.

    Examples
    --------
    >>> class Lamp:
    ...     name = "lamp"
    ...     def safe_state(self):
    ...         print("lamp off")
    >>> with EmergencyStop([Lamp()]):
    ...     print("working")
    working
    lamp off
    """

    def __init__(self, devices: Sequence[SafeDevice]) -> None:
        self._devices = list(devices)
        self._previous: dict[int, Any] = {}
        self._armed = self._stopping = False
        self._pending: int | None = None

    def stop(self) -> list[str]:
        """Bring every device to its safe state; return what failed, a line a device."""
        self._stopping, failed = True, []
        for device in self._devices:
            try:
                device.safe_state()
            except Exception as failure:  # one that fails must not keep the others running
                failed.append(f"{device.name}: {failure}")
        self._armed = self._stopping = False
        return failed

    def __enter__(self) -> Self:
        self._armed = True
        atexit.register(self._at_exit)
        if threading.current_thread() is threading.main_thread():
            self._previous = {one: signal.signal(one, self._on_signal) for one in SIGNALS}
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        failed = self.stop() if self._armed else []
        atexit.unregister(self._at_exit)
        for number, previous in self._previous.items():
            signal.signal(number, previous)
        self._previous, pending, self._pending = {}, self._pending, None
        if failed:
            message = (
                f"Expected every device in its safe state, got {len(failed)} that are not: "
                f"{' | '.join(failed)} Switch them off by hand."
            )
            if error is None:
                raise Unsafe(message)
            if isinstance(error, Exception):
                raise Unsafe(f"{error} Then: {message}") from error
            # Ctrl-C and exit codes go on as they are, but nobody may overlook this
            print(message, file=sys.stderr)
        if pending is not None and error is None:
            _raise(pending)

    def _on_signal(self, number: int, frame: object) -> None:
        if self._stopping:
            self._pending = number
        else:
            _raise(number)

    def _at_exit(self) -> None:
        if self._armed and (failed := self.stop()):
            print(f"Expected a safe end, got: {' | '.join(failed)}", file=sys.stderr)


def _raise(number: int) -> None:
    """Raise what a signal stands for: exit code 130 for Ctrl-C, else 128 and its number."""
    if number == signal.SIGINT:
        raise KeyboardInterrupt
    raise SystemExit(128 + number)
