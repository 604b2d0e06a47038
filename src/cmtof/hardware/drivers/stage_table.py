"""Table of the motorised stages: counts per metre or radian, speed unit, travel, tolerance."""

from dataclasses import dataclass, replace
from math import pi

_DEGREE = pi / 180
_MILLIMETRE = 1e-3


@dataclass(frozen=True)
class StageKind:
    """A stage with its controller.

    Attributes
    ----------
    name : str
    unit : str
        "m" or "rad".
    scale : float
        Counts per unit.
    velocity_scale : float
        Controller's velocity per unit/s.
    tolerance : float
        How far from its target a finished move may end, unit (chosen; a bench should check it).
    travel : tuple of float or None
        Ends of the travel, unit; None turns without end.
    stage_id : int
        Number in HW_GET_INFO (pylablib, kinesis.py); 0 where none is reported.
    models : tuple of str
        How the controller's model begins.
    """

    name: str
    unit: str
    scale: float
    velocity_scale: float
    tolerance: float
    travel: tuple[float, float] | None = None
    stage_id: int = 0
    models: tuple[str, ...] = ("KDC101", "TDC001", "KBD101")

    def counts(self, position: float) -> int:
        """Counts of a position, m or rad.

        Examples
        --------
        >>> STAGES["mts50-z8"].counts(0.010)
        345550
        """
        return round(position * self.scale)

    def rescaled(self, counts_per_unit: float) -> "StageKind":
        """Return the stage with another scale, counts per m or rad; its speed follows."""
        factor = counts_per_unit / self.scale
        if not 0.9 < factor < 1.1:
            raise ValueError(
                f"Expected about {self.scale:.6g} counts per {self.unit} for {self.name}, got "
                f"{counts_per_unit:.6g}. Give counts per m or rad."
            )
        return replace(self, scale=counts_per_unit, velocity_scale=self.velocity_scale * factor)


STAGES = {
    # APT Communications Protocol, 28 November 2022: 34554.96 counts/mm. Older drivers (pylablib,
    # kinesis.py) have 34304, 0.73 % less: command 10 mm and measure. Velocity is
    # counts * T * 65536 with T = 2048 / 6 MHz.
    "mts50-z8": StageKind(
        name="MTS50-Z8",
        unit="m",
        scale=34554.96 / _MILLIMETRE,
        velocity_scale=772981.37 / _MILLIMETRE,
        tolerance=5e-6,
        travel=(0.0, 50 * _MILLIMETRE),
        stage_id=8,
    ),
    # pylablib, kinesis.py: 1919.6418578623391 counts/degree
    "prm1-z8": StageKind(
        name="PRM1-Z8",
        unit="rad",
        scale=1919.6418578623391 / _DEGREE,
        velocity_scale=42941.66 / _DEGREE,
        tolerance=0.02 * _DEGREE,
        stage_id=6,
    ),
    # pylablib, kinesis.py: 409600 microsteps a turn, gear 120:1; velocity 53.68 a microstep/s
    "k10cr1": StageKind(
        name="K10CR1",
        unit="rad",
        scale=409600 * 120 / 360 / _DEGREE,
        velocity_scale=7329109 / _DEGREE,
        tolerance=0.02 * _DEGREE,
        models=("K10CR",),
    ),
}
"""Stages by the name in a RIG file."""
