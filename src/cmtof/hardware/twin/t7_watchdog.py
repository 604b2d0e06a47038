"""The simulated T7's watchdog: when no host has spoken for long enough, lines take set levels.

Facts (ljm_constants.json; T-Series datasheet 12.0): enabled by WATCHDOG_ENABLE_DEFAULT, fed by any
request that is understood, WATCHDOG_TIMEOUT_S_DEFAULT seconds long; with
WATCHDOG_DIO_ENABLE_DEFAULT it writes direction and state of all lines that
WATCHDOG_DIO_INHIBIT_DEFAULT leaves free. Like the dead man's timers of the RF drivers it runs on
the wall clock, for a host that has been killed leaves no other.
"""

import time
from threading import Event, RLock, Thread

from cmtof.hardware.twin.t7_lines import T7Lines
from cmtof.hardware.twin.t7_registers import T7Registers


class T7Watchdog:
    """Bites once for each silence.

    Parameters
    ----------
    registers : T7Registers
    lines : T7Lines
    lock : RLock
        Held while the device does anything.
    """

    def __init__(self, registers: T7Registers, lines: T7Lines, lock: RLock) -> None:
        self._registers, self._lines, self._lock = registers, lines, lock
        self._fed = time.monotonic()
        self._bitten = False
        self._ended = Event()
        self._thread: Thread | None = None

    def feed(self) -> None:
        """A host has spoken; what the request enabled begins to count."""
        self._fed, self._bitten = time.monotonic(), False
        if self._thread is None and self._value("ENABLE"):
            self._thread = Thread(target=self._run, name="T7 watchdog", daemon=True)
            self._thread.start()

    def stop(self) -> None:
        """End the thread."""
        self._ended.set()
        if self._thread is not None:
            self._thread.join()

    def _value(self, name: str) -> int:
        return int(self._registers.value(f"WATCHDOG_{name}_DEFAULT"))

    def _left(self) -> float:
        """Seconds until it bites; a disabled or satisfied one looks again after its time."""
        length = max(1, self._value("TIMEOUT_S"))
        if self._bitten or not self._value("ENABLE"):
            return length
        return self._fed + length - time.monotonic()

    def _run(self) -> None:
        while not self._ended.wait(max(0.0, self._left())):
            with self._lock:
                if self._left() <= 0:  # nobody spoke meanwhile
                    self._bite()

    def _bite(self) -> None:
        self._bitten = True
        if self._value("DIO_ENABLE"):
            self._lines.force(
                self._value("DIO_DIRECTION"), self._value("DIO_STATE"), self._value("DIO_INHIBIT")
            )
