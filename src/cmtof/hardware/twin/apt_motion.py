"""What a simulated motor does: moves that take their time, homing, limits, stalls, status bits."""

import time
from dataclasses import dataclass

from cmtof.hardware.twin.apt_motors import Motor
from cmtof.hardware.twin.faults import Watch
from cmtof.instrument.panel import Panel

_INT32 = 2**31 - 1

# Bits of the status word (APT protocol, MGMSG_MOT_GET_STATUSBITS). Sources disagree on which limit
# switch bit 0 is (yaq: forward, pylablib: backward); here it is the upper end of the travel.
UPPER_LIMIT, LOWER_LIMIT = 0x1, 0x2
FORWARD, REVERSE = 0x10, 0x20
CONNECTED, HOMING, HOMED = 0x100, 0x200, 0x400
SETTLED, MOTION_ERROR = 0x2000, 0x4000
CURRENT_LIMIT, ENABLED = 0x0100_0000, 0x8000_0000


@dataclass
class Move:
    """A move under way.

    Attributes
    ----------
    start, target : int
        Counts.
    duration : float
        Virtual time it takes, s.
    began, ends : float
        Moments on the monotonic wall clock, s.
    homing, stalls : bool
        Whether it looks for the zero; whether it will get stuck.
    """

    start: int
    target: int
    duration: float
    began: float
    ends: float
    homing: bool = False
    stalls: bool = False

    def done(self, now: float) -> float:
        """Fraction of the way."""
        if now >= self.ends:
            return 1.0
        return max(0.0, (now - self.began) / (self.ends - self.began))


class Motion:
    """Counter, status bits and moves of one motor.

    Parameters
    ----------
    panel : Panel
    motor : Motor
    place : str
        What it moves: "plate_emission", "plate_detection" or "stage".
    watch : Watch
        Faults of this device.
    pace : float
        Wall-clock seconds for one virtual second of a move.
    """

    def __init__(self, panel: Panel, motor: Motor, place: str, watch: Watch, pace: float) -> None:
        self._panel, self.motor, self._place = panel, motor, place
        self._watch, self._pace = watch, pace
        self.bits = CONNECTED | SETTLED | ENABLED
        self.velocity, self.acceleration = motor.velocity_counts, motor.acceleration_counts
        self.move: Move | None = None
        self._counts = 0
        self._zero = self._read_panel()
        """Where the counter reads 0, m or rad: where the motor was at power-on, until it homes."""

    def position(self) -> int:
        """Counter at this moment."""
        if self.move is None:
            return self._counts
        way = self.move.target - self.move.start
        return round(self.move.start + self.move.done(time.monotonic()) * way)

    def set_counter(self, counts: int) -> None:
        """Let the present position read so many counts; not while it moves."""
        if self.move is None:
            self._zero += (self._counts - counts) / self.motor.scale
            self._counts = counts

    def go(self, target: int) -> None:
        """Start a move to so many counts; the limits of the travel end it."""
        if not self._start():
            return
        target = self._limited(round(self._watch.pulled(target, *self._clamp_range(target))))
        self._depart(target, homing=False)

    def home(self) -> None:
        """Start to look for the zero."""
        if self._start():
            self.bits = (self.bits & ~HOMED) | HOMING
            self._depart(self.motor.counts(-self._zero), homing=True)

    def stop(self) -> None:
        """Stay where it is."""
        if self.move is not None:
            self._settle(self.move)

    def finish(self) -> Move | None:
        """The move that has come to its end by now, if one has; None also for one that stalls."""
        move = self.move
        if move is None or time.monotonic() < move.ends:
            return None
        self._settle(move)
        if move.stalls:
            self.bits |= MOTION_ERROR | CURRENT_LIMIT
            return None
        if move.homing:
            self._zero, self._counts = 0.0, 0
            self._write_panel()
            self.bits |= HOMED
        return move

    def _start(self) -> bool:
        """End a move under way; whether a new one may begin."""
        self.stop()
        if self._watch.takes("ignore") or not self.bits & ENABLED:
            return False
        self.bits &= ~(MOTION_ERROR | CURRENT_LIMIT | UPPER_LIMIT | LOWER_LIMIT | SETTLED)
        return True

    def _depart(self, target: int, *, homing: bool) -> None:
        stalls = self._watch.takes("stall")
        if stalls:
            target = (self._counts + target) // 2
        if target != self._counts:
            self.bits |= FORWARD if target > self._counts else REVERSE
        way = target - self._counts
        duration = self.motor.duration(way, self.velocity, self.acceleration)
        now = time.monotonic()
        ends = now + duration * self._pace
        self.move = Move(self._counts, target, duration, now, ends, homing, stalls)

    def _settle(self, move: Move) -> None:
        """End the move where it is; the time it took has passed on the virtual clock."""
        self._counts = self.position()
        self._panel.time += move.duration * move.done(time.monotonic())
        self.move = None
        self.bits = self.bits & ~(FORWARD | REVERSE | HOMING) | SETTLED
        self._write_panel()

    def _limited(self, target: int) -> int:
        """Target inside the travel, counts; sets the bit of the limit switch that is met."""
        if self.motor.travel is None:
            return max(-_INT32 - 1, min(_INT32, target))
        lowest, highest = self._limits(self.motor.travel)
        if target > highest:
            self.bits |= UPPER_LIMIT
        if target < lowest:
            self.bits |= LOWER_LIMIT
        return max(lowest, min(highest, target))

    def _limits(self, travel: tuple[float, float]) -> tuple[int, int]:
        low, high = (self.motor.counts(end - self._zero) for end in travel)
        return low, high

    def _clamp_range(self, target: int) -> tuple[int, int]:
        """Range of positions for the fault ``clamp``, counts: the travel, or one turn."""
        if self.motor.travel is not None:
            return self._limits(self.motor.travel)
        return target - self.motor.counts(self.motor.span), target

    def _read_panel(self) -> float:
        if self._place == "stage":
            return self._panel.stage_position
        return self._panel.plate_angle[int(self._place == "plate_detection")]

    def _write_panel(self) -> None:
        """Bring what is mounted to where the counter says, m or rad."""
        value = self._zero + self._counts / self.motor.scale
        if self._place == "stage":
            self._panel.stage_position = value
        else:
            self._panel.plate_angle[int(self._place == "plate_detection")] = value
