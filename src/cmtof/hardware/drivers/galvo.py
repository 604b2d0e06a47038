"""Scan mirrors Thorlabs GVS012, steered by an LJTick-DAC on the read-out.

The driver boards take 0.5 V, 0.8 V or 1 V a degree of *mechanical* angle by a jumper (GVS012 User
Guide, position input scale factor); the beam turns by twice that. Angles here are optical, rad.
"""

import time
from collections.abc import Mapping
from math import hypot, pi
from typing import Protocol

from cmtof.hardware.device import insist

VOLTS_PER_RADIAN = 0.5 * 180 / pi / 2
"""Volts per radian of optical angle at 0.5 V a mechanical degree."""


class Registers(Protocol):
    """What writes registers: a `LabJackT7`."""

    def write_many(self, values: Mapping[str, float]) -> None:
        """Write registers in their order in one frame."""
        ...


class Galvo:
    """Two mirrors.

    Parameters
    ----------
    daq : Registers
        Read-out that carries the LJTick-DAC.
    channels : (str, str)
        Its registers for x and y.
    volts_per_radian : float
        Scale, V per rad of optical angle.
    offset : (float, float)
        Voltages at which the beam is straight, V.
    limit : float
        Largest voltage either way, V.
    settling : float
        Time that a small step takes, s (GVS012: 400 us for 0.2 degrees); longer steps wait longer
        by their length.
    name : str

    Examples
    --------
    >>> import numpy as np
    >>> class Recorder:
    ...     def write_many(self, values):
    ...         print(values)
    >>> Galvo(Recorder()).move_to(0.0, np.deg2rad(8.0))  # 2 V: half of 8 degrees is mechanical
    {'TDAC2': 0.0, 'TDAC3': 2.0}
    """

    def __init__(
        self,
        daq: Registers,
        channels: tuple[str, str] = ("TDAC2", "TDAC3"),
        *,
        volts_per_radian: float = VOLTS_PER_RADIAN,
        offset: tuple[float, float] = (0.0, 0.0),
        limit: float = 10.0,
        settling: float = 4e-4,
        name: str = "galvo",
    ) -> None:
        self.name = name
        self._daq = daq
        self._channels = channels
        self._scale, self._offset = volts_per_radian, offset
        self._limit, self._settling = limit, settling
        self._angles = (0.0, 0.0)

    def volts_from_angles(self, x: float, y: float) -> tuple[float, float]:
        """Voltages, V, of optical angles, rad.

        Raises
        ------
        ValueError
            If a voltage is beyond the limit, or no number.
        """
        volts = (self._offset[0] + self._scale * x, self._offset[1] + self._scale * y)
        for axis, value, angle in zip("xy", volts, (x, y), strict=True):
            if not abs(value) <= self._limit:  # a comparison that NaN fails
                raise ValueError(
                    f"Expected the mirror {axis} within {self._limit:g} V, got {value:.4g} V for "
                    f"{angle:.4g} rad. Reduce the field of view."
                )
        return volts

    def angles_from_volts(self, x: float, y: float) -> tuple[float, float]:
        """Optical angles, rad, of voltages, V."""
        return (x - self._offset[0]) / self._scale, (y - self._offset[1]) / self._scale

    def registers(self, x: float, y: float) -> dict[str, float]:
        """Register writes that turn the beam to optical angles, rad: for `LabJackT7.burst`."""
        # the LJTick-DAC has 14 bits over 20 V: microvolts say all
        volts = (float(round(value, 6)) for value in self.volts_from_angles(x, y))
        values = dict(zip(self._channels, volts, strict=True))
        self._angles = (x, y)
        return values

    def move_to(self, x: float, y: float) -> None:
        """Turn the beam to optical angles, rad, and wait until the mirrors have settled."""
        before = self._angles
        self._daq.write_many(self.registers(x, y))
        time.sleep(self.settling_time(hypot(x - before[0], y - before[1])))

    def settling_time(self, step: float) -> float:
        """Time that a step of optical angle, rad, takes, s.

        The stated settling holds to 0.2 mechanical degrees; beyond, 100 Hz full-scale square waves
        (GVS012 specifications) set the pace: 5 ms for 40 mechanical degrees. Between the two a
        straight line is assumed (not verified).
        """
        small, full = 2 * 0.2 * pi / 180, 2 * 40 * pi / 180
        share = min(max((step - small) / (full - small), 0.0), 1.0)
        return self._settling + share * max(5e-3 - self._settling, 0.0)

    def park(self) -> None:
        """Bring both mirrors to 0 V, where they also rest without power."""
        x, y = self.angles_from_volts(0.0, 0.0)
        self.move_to(x, y)

    def safe_state(self) -> None:
        """Park twice: the LJTick-DAC cannot be read back, so nobody sees a write that was lost."""
        insist(self.park)
        insist(self.park)
