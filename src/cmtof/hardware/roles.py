"""Interfaces of a scan's devices: a Protocol for each role, in SI units and dBm.

A driver does it over a wire, a simulated device (`cmtof_lab.devices`) in process. Neither knows the
other. What a method does on the wire is documented at the driver.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple, Protocol

from numpy.typing import ArrayLike

from cmtof.hardware.reduction import Gain
from cmtof.types import Array, Counts, Texts

# Called again and again while a device moves, to reset the watchdogs of the others.
Waiting = Callable[[], object] | None
Registers = Mapping[str, ArrayLike]  # of a read-out, and their values
Requests = Iterable[Mapping[str, float]]


class DeviceRole(Protocol):
    """Interface of every device."""

    name: str

    def identify(self) -> Texts:
        """Model and serial number as the device reports them."""
        ...

    def safe_state(self) -> None:
        """Become safe; may be called at any time, and again."""

    def close(self) -> None:
        """Close the connection; may be called again."""


class RfStatus(NamedTuple):
    """State of an RF drive: on, locked, table entry, trigger edges since `arm`, tripped."""

    on: bool
    locked: bool
    entry: int
    edges: int
    tripped: bool


class RfLock(NamedTuple):
    """Whether a drive is locked to its resonance; its detuning, Hz; reflected power, dBm."""

    locked: bool
    detuning: float
    reflected: float


class RfRole(DeviceRole, Protocol):
    """Drive of one modulator, with a table of phases that a trigger steps through."""

    def set_frequency(self, hz: float) -> None:
        """Set the frequency, Hz."""

    def set_power(self, dbm: float) -> None:
        """Set the power, dBm."""

    def set_phase(self, rad: float) -> None:
        """Set the phase of the drive, rad, for when no trigger steps through the table."""

    def set_dead_man(self, seconds: float) -> None:
        """Set the watchdog: RF turns off when no request comes for so many seconds."""

    def output(self, on: bool, *, lock_timeout: float = 10.0) -> None:
        """Switch RF on or off; if on, wait up to ``lock_timeout``, s, for the lock."""

    def status(self) -> RfStatus:
        """State of output, lock, phase table and trip."""
        ...

    def lock(self) -> RfLock:
        """Lock, detuning and reflected power."""
        ...

    def clear_trip(self) -> None:
        """Allow RF again after a trip."""

    def ping(self) -> None:
        """Reset the watchdog that `set_dead_man` sets."""

    def load_table(self, phases: Array) -> None:
        """Load the table of drive phases, rad."""

    def trigger(self, on: bool) -> None:
        """Choose whether edges at the trigger input step through the table."""

    def arm(self) -> None:
        """Rewind the table to its first entry, and count trigger edges from 0."""


class ClockRole(DeviceRole, Protocol):
    """Clock of both RF drivers, on channels 1 and 2."""

    def reset(self) -> None:
        """Reset to the factory settings."""

    def sine(self, channel: int, *, frequency: float, amplitude: float) -> None:
        """Set a sine, Hz and V peak to peak."""

    def lock_phases(self) -> None:
        """Lock both channels to one phase."""

    def output(self, channel: int, on: bool) -> None:
        """Switch the output of a channel."""

    def output_is_on(self, channel: int) -> bool:
        """Whether a channel puts out its sine."""
        ...


class MotorRole(DeviceRole, Protocol):
    """Rotation mount, rad, or linear stage, m."""

    @property
    def position(self) -> float:
        """Position from home, rad or m."""
        ...

    @property
    def homed(self) -> bool:
        """Whether the home position is known."""
        ...

    def home(self, *, waiting: Waiting = None) -> None:
        """Move to the home position, and wait; ``waiting`` is called meanwhile."""

    def move_to(self, position: float, *, waiting: Waiting = None) -> float:
        """Move to a position, rad or m, and wait; return the position read back."""
        ...


class PowerMeterRole(DeviceRole, Protocol):
    """Meter of the laser's power behind the emission module."""

    @property
    def power(self) -> float:
        """Power, W."""
        ...

    def set_up(
        self, *, wavelength: float, readings: int, waiting: Waiting = None
    ) -> None:
        """Correct for a wavelength, m, average so many readings, and zero the dark head."""


class ReadOutRole(DeviceRole, Protocol):
    """Digital lines, scan mirrors, and bursts of detector samples.

    Its safe state: no light leaves, and the mirrors are parked. ``rate`` is that of the last burst.
    """

    rate: float

    def gain(self) -> Gain:
        """Calibration of the inputs."""
        ...

    def line(self, dio: str) -> bool:
        """Level of a digital input line: True is high."""
        ...

    def set_line(self, dio: str, high: bool) -> None:
        """Make a digital line an output, high or low."""

    def write_many(self, values: Registers) -> None:
        """Write registers by name, in their order."""

    def watchdog(self, seconds: int) -> None:
        """Set the watchdog: safe lines go low when no request comes for so many seconds."""

    def configure_burst(
        self,
        *,
        channels: Sequence[str],
        rate: float,
        scans: int,
        pulse_line: str,
        pulse: int,
    ) -> None:
        """Set up bursts of inputs; a line is high in the first half of each ``pulse`` samples."""

    def bursts(self, requests: Requests) -> Iterator[Counts]:
        """Counts of one burst per request, whose registers are written as it starts."""
        ...
