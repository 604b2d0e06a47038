"""Panels as a scan leaves them, for the tests of the twin's physics."""

import numpy as np

from cmtof.instrument.panel import Panel, RfKnobs

ORDER = {"single": 1, "doubled": 2}
DRIVE = {"single": 7.15e9, "doubled": 7.16e9}
PLATE = {"single": np.deg2rad(11.25), "doubled": np.deg2rad(22.5)}
MODES = ("single", "doubled")


def psi(steps: int = 16) -> np.ndarray:
    """Reference phases that the panel's table makes, rad."""
    return 2 * np.pi * np.arange(steps) / steps


def ready(mode: str, *, steps: int = 16, power: float = 30.0, **knobs) -> Panel:
    """Everything on, the table armed: it steps psi upwards, so the drive steps downwards."""
    table = np.mod(-psi(steps) / ORDER[mode], 2 * np.pi)
    rf = {"on": True, "frequency": DRIVE[mode], "power": power}
    return Panel(
        emission=RfKnobs(**rf),
        detection=RfKnobs(**rf, table=table, armed=True, trigger=True),
        plate_angle=[PLATE[mode], PLATE[mode]],
        laser_on=True,
        shutter_open=True,
        clock_on=True,
        **knobs,
    )


def edges(steps: int = 16, samples: int = 20) -> np.ndarray:
    """Number of the last edge at each sample."""
    return np.arange(steps * samples) // samples


def ahead(count: int = 1) -> np.ndarray:
    """Directions straight ahead."""
    return np.zeros((count, 2))
