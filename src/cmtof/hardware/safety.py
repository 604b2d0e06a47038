"""The emergency stop: however a program ends, every device reaches its safe state."""

import atexit
import signal
import sys
import threading
from types import FrameType, TracebackType
from typing import Any, Protocol, Self

from cmtof.hardware.errors import Unsafe

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class SafeDevice(Protocol):
    """What has a name and a safe state."""

    name: str

    def safe_state(self) -> None:
        """Bring the device to where it can hurt nobody."""
        ...


class EmergencyStop:
    """Bring devices to their safe states on exit, exception, Ctrl-C, SIGTERM and end of program.

    A signal does no work itself: it raises in the main thread, so that no request is sent into the
    middle of another, and the stop runs while the context is left. Signals that come during the
    stop wait for its end. A killed process (SIGKILL) runs nothing: against that stand the RF
    drivers' dead man's timer and the read-out's watchdog.

    Parameters
    ----------
    *devices
        In the order in which they are stopped: what sends out light first.

    Examples
    --------
    >>> class Lamp:
    ...     name = "lamp"
    ...     def safe_state(self):
    ...         print("lamp off")
    >>> with EmergencyStop(Lamp()):
    ...     print("working")
    working
    lamp off
    """

    def __init__(self, *devices: SafeDevice) -> None:
        self.devices = list(devices)
        self._previous: dict[int, Any] = {}
        self._armed = False
        self._stopping = False
        self._pending: int | None = None

    def add(self, device: SafeDevice) -> None:
        """Stop this one too, after the others."""
        self.devices.append(device)

    def stop(self) -> list[str]:
        """Bring every device to its safe state; return what failed, a line a device."""
        failed = []
        for device in self.devices:
            try:
                device.safe_state()
            except Exception as failure:  # one that fails must not keep the others running
                failed.append(f"{device.name}: {failure}")
        return failed

    def __enter__(self) -> Self:
        self._armed = True
        atexit.register(self._at_exit)
        if threading.current_thread() is threading.main_thread():
            for number in _SIGNALS:
                self._previous[number] = signal.signal(number, self._on_signal)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        failed = self._stop_once()
        pending = self._restore()
        if failed:
            self._report(failed, error)
        if pending is not None and error is None:
            _raise(pending)

    def _stop_once(self) -> list[str]:
        if not self._armed:
            return []
        self._stopping = True
        try:
            return self.stop()
        finally:
            self._armed = self._stopping = False

    def _restore(self) -> int | None:
        """Give the signals back; return the one that came during the stop."""
        atexit.unregister(self._at_exit)
        for number, previous in self._previous.items():
            signal.signal(number, previous)
        self._previous.clear()
        pending, self._pending = self._pending, None
        return pending

    def _report(self, failed: list[str], error: BaseException | None) -> None:
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

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        if self._stopping:
            self._pending = number
            return
        _raise(number)

    def _at_exit(self) -> None:
        failed = self._stop_once()
        if failed:
            print(f"Expected a safe end, got: {' | '.join(failed)}", file=sys.stderr)


def _raise(number: int) -> None:
    if number == signal.SIGINT:
        raise KeyboardInterrupt
    raise SystemExit(128 + number)
