"""What steers and releases the beam, on the read-out's outputs: galvo and interlock."""

import time
from functools import partial
from math import pi
from typing import Any

from cmtof.hardware.device import Unsafe, insist


class Galvo:
    """Scan mirrors Thorlabs GVS012, steered by an LJTick-DAC on the read-out.

    The driver boards take 0.5 V a degree of *mechanical* angle (GVS012 User Guide); the beam turns
    by twice that. Angles here are optical, rad.

    Parameters
    ----------
    daq
        Read-out with ``write_many``.
    settings
        ``x``, ``y`` (registers), ``volts_per_radian``, ``offset_x_volts``, ``offset_y_volts``,
        ``limit_volts`` and ``settling`` (s, of a step of 0.2 mechanical degrees).
    """

    name = "galvo"

    def __init__(self, daq: Any, settings: Any) -> None:
        self._daq, self._settings = daq, settings

    def registers(self, x: float, y: float) -> dict[str, float]:
        """Register writes that turn the beam to optical angles, rad.

        Raises
        ------
        ValueError
            If a voltage is beyond the limit, or no number.
        """
        known = self._settings
        volts = {
            known.x: round(known.offset_x_volts + known.volts_per_radian * x, 6),
            known.y: round(known.offset_y_volts + known.volts_per_radian * y, 6),
        }
        for value in volts.values():
            if not abs(value) <= known.limit_volts:  # a comparison that NaN fails
                raise ValueError(
                    f"Expected the mirrors within {known.limit_volts:g} V, got {value:.4g} V. "
                    "Reduce the field of view."
                )
        return volts

    def move_to(self, x: float, y: float) -> None:
        """Turn the beam to optical angles, rad, and wait as long as the longest step takes."""
        self._daq.write_many(self.registers(x, y))
        time.sleep(settling_time(pi, self._settings.settling))

    def park(self) -> None:
        """Bring both mirrors to 0 V, where they also rest without power."""
        self._daq.write_many({self._settings.x: 0.0, self._settings.y: 0.0})

    def safe_state(self) -> None:
        """Park twice: the LJTick-DAC cannot be read back, so nobody sees a write that was lost."""
        insist(self.park)
        insist(self.park)


def settling_time(step: float, small: float) -> float:
    """Time, s, that a step of optical angle, rad, takes.

    ``small``, s, holds to 0.2 mechanical degrees; beyond, 100 Hz full-scale square waves (GVS012
    specifications) set the pace: 5 ms for 40 degrees. Between, a straight line (not verified).
    """
    if not small:  # simulated mirrors
        return 0.0
    near, far = 2 * 0.2 * pi / 180, 2 * 40 * pi / 180
    share = min(max((step - near) / (far - near), 0.0), 1.0)
    return small + share * max(5e-3 - small, 0.0)


SAFE_LEVELS = {"laser": False, "shutter": False, "beam_block": False}
"""Levels that the read-out's own watchdog gives the outputs."""


class Interlock:
    """Laser, shutter, flip mirror and beam block on the read-out's lines, and the interlock.

    All four outputs are wired so that a low line, a cut cable or a read-out without power is safe:
    laser off, shutter shut, beam block in. The interlock's loop of door contacts brings the T7's
    supply to its line, and a resistor of 10 kOhm pulls that line down against the T7's own pull-up
    of 100 kOhm (T-Series Datasheet, 13.0): an open door or a cut cable reads low.
    """

    name = "interlock"

    def __init__(self, daq: Any, lines: Any) -> None:
        self._daq, self._lines = daq, lines

    def check(self) -> None:
        """Raise `Unsafe` when the interlock is open."""
        if not self._daq.line(self._lines.interlock):
            raise Unsafe(
                f"Expected the interlock at {self._lines.interlock} closed, got it open. "
                "Close doors and covers."
            )

    def laser(self, on: bool) -> None:
        """Switch the laser; on only with the interlock closed."""
        if on:
            self.check()
        self._daq.set_line(self._lines.laser, on)

    def shutter(self, open: bool) -> None:
        """Open the shutter, only with the interlock closed, or shut it."""
        if open:
            self.check()
        self._daq.set_line(self._lines.shutter, open)

    def flip_mirror(self, inserted: bool) -> None:
        """Send the beam to the reference target, or to the scene."""
        self._daq.set_line(self._lines.flip_mirror, inserted)

    def beam_block(self, inserted: bool) -> None:
        """Block the arm that the splitter discards, or let it into the interferometer."""
        self._daq.set_line(self._lines.beam_block, not inserted)

    def safe_state(self) -> None:
        """Shut the shutter, switch the laser off, put the block in; each even if another fails."""
        acts = ((self.shutter, False), (self.laser, False), (self.beam_block, True))
        insist(*(partial(act, safe) for act, safe in acts))
