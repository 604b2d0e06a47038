"""Digital lines of the simulated T7, and what hangs on them in the default wiring.

Facts (ljm_constants.json): DIO# and FIO# make a line an input when read and an output when
written; _STATE and _DIRECTION take lines in bits 0-7 and inhibits in bits 8-15, and DIO_STATE,
DIO_DIRECTION obey DIO_INHIBIT. After power-on all are inputs. Wiring: what the lines control is
pulled down at its end, so that a line that nobody drives is off; every other input reads high by
the T7's own pull-up. High is: laser on, shutter open, flip mirror in, beam block OUT, interlock
closed. All lines low is the safe state.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from cmtof.hardware.twin.t7_registers import T7Registers
from cmtof.hardware.twin.trigger import pull, pulses_from_levels
from cmtof.instrument.panel import Panel

LINES = 23
"""DIO0 to DIO22: eight FIO, eight EIO, four CIO, three MIO."""
_ALL = (1 << LINES) - 1
_PORTS = (("FIO", 0, 8), ("EIO", 8, 8), ("CIO", 16, 4), ("MIO", 20, 3))
WIRING = {"laser": 0, "shutter": 1, "trigger": 4, "flip_mirror": 5, "beam_block": 6, "interlock": 7}
"""DIO numbers by their role."""


class T7Lines:
    """Levels and directions of the lines.

    Parameters
    ----------
    panel : Panel
    registers : T7Registers
    wiring : mapping of str to int
        DIO number of each role, as in `WIRING`.
    """

    def __init__(
        self, panel: Panel, registers: T7Registers, wiring: Mapping[str, int] = WIRING
    ) -> None:
        self._panel, self._wiring = panel, dict(wiring)
        self._driven = 0  # levels that outputs have, or would have
        self._outputs = 0
        self._inhibited = 0
        self._pulled_down = sum(
            1 << line for role, line in self._wiring.items() if role != "interlock"
        )
        self._hook(registers)
        self._show(before=False)

    def _hook(self, registers: T7Registers) -> None:
        for line in range(LINES):
            registers.on_read(f"DIO{line}", lambda line=line: self._read_line(line))
            registers.on_write(f"DIO{line}", lambda v, line=line: self._write_line(line, v))
        for port, first, count in _PORTS:
            mask = ((1 << count) - 1) << first
            registers.on_read(
                f"{port}_STATE", lambda m=mask, f=first: float((self.levels() & m) >> f)
            )
            registers.on_write(
                f"{port}_STATE", lambda v, f=first, c=count: self.set_port(f, c, int(v))
            )
            registers.on_read(
                f"{port}_DIRECTION", lambda m=mask, f=first: float((self._outputs & m) >> f)
            )
            registers.on_write(
                f"{port}_DIRECTION", lambda v, f=first, c=count: self._set_directions(f, c, int(v))
            )
        registers.on_read("DIO_STATE", lambda: float(self.levels()))
        registers.on_write("DIO_STATE", lambda v: self._drive(int(v), _ALL & ~self._inhibited))
        registers.on_read("DIO_DIRECTION", lambda: float(self._outputs))
        registers.on_write("DIO_DIRECTION", lambda v: self._direct(int(v), _ALL & ~self._inhibited))
        registers.on_write("DIO_INHIBIT", self._set_inhibit)

    def levels(self) -> int:
        """What the terminals show, one bit a line."""
        floating = _ALL & ~self._pulled_down
        if not self._panel.interlock_closed:
            floating &= ~(1 << self._wiring["interlock"])
        return self._driven & self._outputs | floating & ~self._outputs

    def factory(self) -> None:
        """All lines inputs again."""
        self._driven = self._inhibited = 0
        self._direct(0, _ALL)

    def force(self, directions: int, levels: int, inhibited: int) -> None:
        """Directions and levels of all lines that are not inhibited."""
        self._drive(levels, _ALL & ~inhibited)
        self._direct(directions, _ALL & ~inhibited)

    def set_port(self, first: int, count: int, value: int) -> None:
        """Write a _STATE register: levels, and in the upper byte what stays."""
        mask = (~(value >> 8) & ((1 << count) - 1)) << first
        self._drive((value & 0xFF) << first, mask)

    def play(self, values: NDArray[np.int64] | None, scans: int) -> NDArray[np.int64]:
        """Trigger edges of a burst whose stream-out writes FIO_STATE, one value a scan.

        Parameters
        ----------
        values : ndarray of int (scans,) or None
            Values with their inhibits; None where nothing is played.

        Returns
        -------
        ndarray of int (scans,)
            Number of the last edge, -1 before the first. `end_play` counts them and leaves the
            lines as the last value has them.
        """
        trigger = self._wiring["trigger"]
        bit = 1 << trigger
        if values is None or not self._outputs & bit:
            return np.full(scans, -1)
        free = (values >> 8) & bit == 0
        before = bool(self.levels() & bit)
        # a value that inhibits the line leaves it at the last one that does not
        last = np.maximum.accumulate(np.where(free, np.arange(scans), -1))
        levels = np.where(last < 0, before, (values[last] & bit) != 0)
        self._set_others(int(values[0]), bit)
        return pulses_from_levels(levels, before)

    def end_play(self, values: NDArray[np.int64] | None, pulses: NDArray[np.int64]) -> None:
        """Count the edges of a burst and leave the lines as its last value has them."""
        pull(self._panel, int(pulses[-1]) + 1)
        if values is not None:
            last = int(values[-1])
            bit = 1 << self._wiring["trigger"]
            if not (last >> 8) & bit:  # its edges are counted already
                self._driven = self._driven & ~bit | last & bit
            self._set_others(last, bit)

    def _set_others(self, value: int, trigger: int) -> None:
        self._drive(value & 0xFF, ~(value >> 8) & 0xFF & ~trigger)

    def _read_line(self, line: int) -> float:
        self._direct(0, 1 << line)
        return float(self.levels() >> line & 1)

    def _write_line(self, line: int, value: float) -> None:
        before = self._trigger_level()
        bit = 1 << line
        self._driven = self._driven | bit if value else self._driven & ~bit
        self._outputs |= bit
        self._show(before)

    def _set_directions(self, first: int, count: int, value: int) -> None:
        mask = (~(value >> 8) & ((1 << count) - 1)) << first
        self._direct((value & 0xFF) << first, mask)

    def _set_inhibit(self, value: float) -> None:
        self._inhibited = int(value)

    def _drive(self, value: int, mask: int) -> None:
        before = self._trigger_level()
        self._driven = self._driven & ~mask | value & mask
        self._show(before)

    def _direct(self, value: int, mask: int) -> None:
        before = self._trigger_level()
        self._outputs = self._outputs & ~mask | value & mask
        self._show(before)

    def _trigger_level(self) -> bool:
        return bool(self.levels() >> self._wiring["trigger"] & 1)

    def _show(self, before: bool) -> None:
        """Turn the knobs; a rising edge of the trigger line reaches the RF drivers."""
        levels, panel = self.levels(), self._panel
        high = {role: bool(levels >> line & 1) for role, line in self._wiring.items()}
        with panel.lock:
            panel.laser_on, panel.shutter_open = high["laser"], high["shutter"]
            panel.flip_mirror_in, panel.beam_block_in = high["flip_mirror"], not high["beam_block"]
            if high["trigger"] and not before:
                pull(panel, 1)
