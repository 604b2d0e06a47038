"""Laser, shutter, flip mirror and beam block on the read-out's digital lines, and the interlock.

All four outputs are wired so that a low line, a cut cable or a read-out without power is safe:
laser off, shutter shut, beam block in. The interlock's loop of door contacts brings the T7's supply
to its line, and a resistor of 10 kOhm pulls that line down, against the T7's own pull-up of 100
kOhm (T-Series Datasheet, 13.0 Digital I/O): an open door or a cut cable reads low.
"""

import functools
from typing import Protocol

from cmtof.hardware.device import insist
from cmtof.hardware.errors import Refused, Unsafe

LASER_ON = SHUTTER_OPEN = MIRROR_IN = BLOCK_OUT = True
"""Levels of the lines."""

LOOP_CLOSED = True
"""Level of the interlock's line when nothing is open."""


class DigitalLines(Protocol):
    """What has digital lines: a `LabJackT7`."""

    def set_line(self, dio: str, high: bool) -> None:
        """Make a line an output at that level."""
        ...

    def line(self, dio: str) -> bool:
        """Level of an input."""
        ...


class LineNames(Protocol):
    """Which line does what; `cmtof.hardware.rig_settings.LineSettings` is one."""

    @property
    def laser(self) -> str: ...  # noqa: D102
    @property
    def shutter(self) -> str: ...  # noqa: D102
    @property
    def flip_mirror(self) -> str: ...  # noqa: D102
    @property
    def beam_block(self) -> str: ...  # noqa: D102
    @property
    def interlock(self) -> str: ...  # noqa: D102


class Interlock:
    """What lets light out.

    Parameters
    ----------
    daq : DigitalLines
    lines : LineNames
    name : str
    """

    def __init__(self, daq: DigitalLines, lines: LineNames, name: str = "interlock") -> None:
        self.name = name
        self._daq = daq
        self._lines = lines

    def check(self) -> None:
        """Raise `Unsafe` when the interlock is open."""
        if self._daq.line(self._lines.interlock) != LOOP_CLOSED:
            raise Unsafe(
                f"Expected the interlock at {self._lines.interlock} closed, got it open. "
                "Close doors and covers."
            )

    def laser(self, on: bool) -> None:
        """Switch the laser; on only with the interlock closed."""
        if on:
            self.check()
        self._daq.set_line(self._lines.laser, LASER_ON if on else not LASER_ON)

    def shutter(self, open: bool) -> None:
        """Open the shutter, only with the interlock closed, or shut it."""
        if open:
            self.check()
        self._daq.set_line(self._lines.shutter, SHUTTER_OPEN if open else not SHUTTER_OPEN)

    def flip_mirror(self, inserted: bool) -> None:
        """Send the beam to the reference target, or to the scene."""
        self._daq.set_line(self._lines.flip_mirror, MIRROR_IN if inserted else not MIRROR_IN)

    def beam_block(self, inserted: bool) -> None:
        """Block the arm that the splitter discards, or let it into the interferometer."""
        self._daq.set_line(self._lines.beam_block, not BLOCK_OUT if inserted else BLOCK_OUT)

    def safe_state(self) -> None:
        """Shut the shutter, switch the laser off, put the block in; each even if another fails.

        Raises
        ------
        Refused
            If a line did not follow; the message names all of them.
        """
        failed = []
        for act, safe in ((self.shutter, False), (self.laser, False), (self.beam_block, True)):
            try:
                insist(functools.partial(act, safe))
            except OSError as failure:
                failed.append(str(failure))
        if failed:
            raise Refused(" ".join(failed))
