"""The panel of the simulated instrument: every knob that servers turn and the world reads."""

from dataclasses import dataclass, field
from threading import RLock

import numpy as np
from numpy.typing import NDArray


@dataclass
class RfKnobs:
    """One RF driver."""

    on: bool = False
    frequency: float = 7.15e9
    """Frequency of the drive, Hz."""
    power: float = 0.0
    """Power, dBm."""
    phase: float = 0.0
    """Phase of the drive outside the table, rad."""
    table: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    """Phases of the table, rad."""
    index: int = 0
    """Entry of the table that plays next at an edge after arming, else the one that plays."""
    armed: bool = False
    """True between ARM and the first edge."""
    trigger: bool = False
    """Whether edges step the table."""
    edges: int = 0
    """Edges seen since arming."""


@dataclass
class Panel:
    """State of the whole instrument; hold `lock` while reading or turning more than one knob.

    Attributes
    ----------
    emission, detection : RfKnobs
    plate_angle : list of float
        Mount angles of the half-wave plates of emission and detection, rad.
    galvo_volts : list of float
        Voltages at the x and y input of the mirror driver, V.
    stage_position : float
        Target stage, m.
    laser_on, shutter_open, flip_mirror_in, beam_block_in, interlock_closed : bool
        Digital lines; the flip mirror sends the beam to the reference target.
    clock_on, clock_frequency : bool, float
        Output of the function generator that both RF drivers are locked to, Hz.
    label : int
        Number of the burst, from the read-out's user register; 0 for none.
    time : float
        Virtual time, s.
    bursts : int
        Bursts since the start.
    """

    emission: RfKnobs = field(default_factory=RfKnobs)
    detection: RfKnobs = field(default_factory=RfKnobs)
    plate_angle: list[float] = field(default_factory=lambda: [0.0, 0.0])
    galvo_volts: list[float] = field(default_factory=lambda: [0.0, 0.0])
    stage_position: float = 0.0
    laser_on: bool = False
    shutter_open: bool = False
    flip_mirror_in: bool = False
    beam_block_in: bool = True
    interlock_closed: bool = True
    clock_on: bool = False
    clock_frequency: float = 10e6
    label: int = 0
    time: float = 0.0
    bursts: int = 0
    lock: RLock = field(default_factory=RLock, repr=False, compare=False)
