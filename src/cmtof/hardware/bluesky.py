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
from cmtof.types import Fields

UNITS = {
    "power_meter": "W",
    "stage": "m",
    "plate_emission": "rad",
    "plate_detection": "rad",
}


class Motion(Future):
    """Status of a move, for Bluesky; the move runs in a thread of its own."""

    add_callback = Future.add_done_callback
    done = property(Future.done)  # type: ignore[assignment]
    success = property(lambda self: self.done and self.exception() is None)

    def __init__(self, act: Callable[[], object]) -> None:
        super().__init__()
        Thread(target=self._run, args=[act]).start()

    def _run(self, act: Callable[[], object]) -> None:
        """Run the move, and store its result or its error."""
        try:
            self.set_result(act())
        except Exception as error:
            self.set_exception(error)


class Adapter:
    """Device of a bench for Bluesky, by its role in `UNITS`."""

    parent = None
    _stopped = False

    def __init__(self, bench: Bench, role: str) -> None:
        self.name = role
        self._bench = bench
        self._device = bench.devices[role]
        self._motion = Motion(lambda: None)

    def read(self) -> Fields:
        """Position, m or rad, or power, W, with the time, s since 1970, as Bluesky expects."""
        value = getattr(
            self._device, "power" if self.name == "power_meter" else "position"
        )
        return {self.name: {"value": value, "timestamp": time.time()}}

    def describe(self) -> Fields:
        """Type and unit of the value, as Bluesky expects."""
        kind = {"source": "cmtof", "dtype": "number", "shape": []}
        return {self.name: kind | {"units": UNITS[self.name]}}

    def set(self, position: float) -> Motion:
        """Start a move to a position, m or rad; return its status."""
        self._stopped = False
        self._motion = Motion(
            lambda: self._device.move_to(position, waiting=self._feed_or_stop)
        )
        return self._motion

    def stop(self, *, success: bool = False) -> None:
        """Bring the device into its safe state; a running move fails with `Unsafe`."""
        self._stopped = True
        self._motion.exception()
        self._device.safe_state()

    def _feed_or_stop(self) -> None:
        """Reset the bench's watchdogs during a move; `Unsafe` after `stop`."""
        if self._stopped:
            raise Unsafe(
                f"Expected {self.name} to end its move, got a stop. Home it or move it again."
            )
        self._bench.feed()


def adapters(bench: Bench) -> dict[str, Adapter]:
    """Adapters of the motors and the power meter of a bench that is set up, by role."""
    return {role: Adapter(bench, role) for role in UNITS}
