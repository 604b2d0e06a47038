"""Table of the motors: scales between counts and metres or radians, travel and speed."""

import math
from dataclasses import dataclass

_DEGREE = math.pi / 180
_MILLIMETRE = 1e-3


@dataclass(frozen=True)
class Motor:
    """A stage with its controller.

    Attributes
    ----------
    controller : str
        Model that HW_GET_INFO reports.
    serial : int
        Its first two digits tell the controller: 27 KDC101, 55 K10CR1 (pylablib, kinesis.py).
    stage : int
        Number of the stage in HW_GET_INFO, 0 where none is reported.
    scale : float
        Counts per m or rad.
    velocity_scale, acceleration_scale : float
        Counts of the velocity per m/s or rad/s, of the acceleration per m/s^2 or rad/s^2.
    velocity, acceleration : float
        The largest, m/s or rad/s, m/s^2 or rad/s^2.
    travel : tuple of float or None
        Ends of the travel, m; None turns without end.
    """

    controller: str
    serial: int
    stage: int
    scale: float
    velocity_scale: float
    acceleration_scale: float
    velocity: float
    acceleration: float
    travel: tuple[float, float] | None = None

    @property
    def span(self) -> float:
        """Length of the travel, m, or one turn, rad."""
        return 2 * math.pi if self.travel is None else self.travel[1] - self.travel[0]

    @property
    def velocity_counts(self) -> int:
        """Largest velocity in the controller's unit."""
        return round(self.velocity * self.velocity_scale)

    @property
    def acceleration_counts(self) -> int:
        """Largest acceleration in the controller's unit."""
        return round(self.acceleration * self.acceleration_scale)

    def counts(self, distance: float) -> int:
        """Counts of a distance, m or rad.

        Examples
        --------
        >>> MOTORS["mts50-z8"].counts(0.010)
        345550
        """
        return round(distance * self.scale)

    def duration(self, counts: int, velocity: int, acceleration: int) -> float:
        """Time of a move with ramps up and down, s; velocity, acceleration in controller's units.

        Examples
        --------
        >>> motor = MOTORS["mts50-z8"]
        >>> full = motor.velocity_counts, motor.acceleration_counts
        >>> round(motor.duration(motor.counts(0.010), *full), 3)  # 10 / 2.4 + 2.4 / 4.5
        4.7
        """
        distance = abs(counts) / self.scale
        speed = velocity / self.velocity_scale
        rate = acceleration / self.acceleration_scale
        if distance < speed**2 / rate:  # never reaches full speed
            return 2 * math.sqrt(distance / rate)
        return distance / speed + speed / rate


MOTORS = {
    # Counts: APT protocol, issue 28 Nov 2022, 34554.96 per mm; older drivers have 34304 (the two
    # differ by 0.7 %). Velocity and acceleration: counts * T * 65536 and counts * T^2 * 65536 with
    # T = 2048 / 6 MHz. Travel 50 mm, 2.4 mm/s, 4.5 mm/s^2: Thorlabs, MTS50-Z8 (not verified).
    "mts50-z8": Motor(
        controller="KDC101",
        serial=27000001,
        stage=8,
        scale=34554.96 / _MILLIMETRE,
        velocity_scale=772981.37 / _MILLIMETRE,
        acceleration_scale=263.844 / _MILLIMETRE,
        velocity=2.4 * _MILLIMETRE,
        acceleration=4.5 * _MILLIMETRE,
        travel=(0.0, 50 * _MILLIMETRE),
    ),
    # Counts as in pylablib (kinesis.py), 25 degrees/s: Thorlabs, PRM1-Z8 (not verified).
    "prm1-z8": Motor(
        controller="KDC101",
        serial=27000002,
        stage=6,
        scale=1919.6418578623391 / _DEGREE,
        velocity_scale=42941.66 / _DEGREE,
        acceleration_scale=14.6574 / _DEGREE,
        velocity=25 * _DEGREE,
        acceleration=25 * _DEGREE,
    ),
    # 409600 microsteps a turn, gear 120:1 (pylablib, kinesis.py); 10 degrees/s: Thorlabs, K10CR1
    # (not verified).
    "k10cr1": Motor(
        controller="K10CR1",
        serial=55000001,
        stage=0,
        scale=409600 * 120 / 360 / _DEGREE,
        velocity_scale=7329109 / _DEGREE,
        acceleration_scale=1502 / _DEGREE,
        velocity=10 * _DEGREE,
        acceleration=10 * _DEGREE,
    ),
}
"""Motors by the name of the stage in a RIG file."""
