"""Devices of a bench for Bluesky's RunEngine: ``set -> Status``, ``read``, ``describe``, ``stop``.

With ``p = adapters(bench)``: ``RE(scan([p["power_meter"]], p["stage"], 0.02, 0.03, 11))``. A move
runs in a thread that feeds the bench's timers; until it ends nothing else may talk to it.
"""

import time
from collections.abc import Callable
from concurrent.futures import Future
from threading import Thread

from cmtof.hardware.bench import Bench
from cmtof.hardware.device import Unsafe

UNITS = {
    "power_meter": "W",
    "stage": "m",
    "plate_emission": "rad",
    "plate_detection": "rad",
}


class Motion(Future):
    """Status of a move, which runs in a thread of its own."""

    add_callback = Future.add_done_callback
    done = property(Future.done)  # type: ignore[assignment]
    success = property(lambda self: self.done and self.exception() is None)

    def __init__(self, act: Callable[[], object]) -> None:
        super().__init__()
        Thread(target=self._run, args=[act]).start()

    def _run(self, act: Callable[[], object]) -> None:
        """Act, and keep what came of it."""
        try:
            self.set_result(act())
        except Exception as error:
            self.set_exception(error)


class Adapter:
    """A device of a bench by its role."""

    parent = None
    _stopped = False

    def __init__(self, bench: Bench, role: str) -> None:
        self.name = role
        self._bench = bench
        self._device = bench.devices[role]
        self._motion = Motion(lambda: None)

    def read(self) -> dict[str, dict]:
        """Position or power, and the time, s since 1970."""
        value = getattr(
            self._device, "power" if self.name == "power_meter" else "position"
        )
        return {self.name: {"value": value, "timestamp": time.time()}}

    def describe(self) -> dict[str, dict]:
        """Kind of the value, and its unit."""
        kind = {"source": "cmtof", "dtype": "number", "shape": []}
        return {self.name: kind | {"units": UNITS[self.name]}}

    def set(self, position: float) -> Motion:
        """Move, m or rad."""
        self._stopped = False
        self._motion = Motion(
            lambda: self._device.move_to(position, waiting=self._wait)
        )
        return self._motion

    def stop(self, *, success: bool = False) -> None:
        """Bring the device into its safe state; a move ends in `Unsafe`."""
        self._stopped = True
        self._motion.exception()
        self._device.safe_state()

    def _wait(self) -> None:
        """Feed the timers of the bench, and end a move that is to stop."""
        if self._stopped:
            raise Unsafe(
                f"Expected {self.name} to move on, got a stop. Home it or go on."
            )
        self._bench.feed()


def adapters(bench: Bench) -> dict[str, Adapter]:
    """Motors and power meter of a bench that is set up, by role."""
    return {role: Adapter(bench, role) for role in UNITS}
