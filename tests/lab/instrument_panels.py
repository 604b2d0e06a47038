"""Panels as a scan leaves them."""

import numpy as np

from cmtof.hardware.reduction import drive_phases, nominal_psi
from cmtof_lab.electronics import volts_from_counts
from cmtof_lab.instrument import Panel, RfKnobs

ORDER = {"single": 1, "doubled": 2}
DRIVE = {"single": 7.15e9, "doubled": 7.16e9}
PLATE = {"single": np.deg2rad(11.25), "doubled": np.deg2rad(22.5)}
EDGES = np.arange(320) // 20
PSI = nominal_psi(16)


def ready(mode, **knobs):
    """Everything on; the table steps psi upwards, so the drive steps downwards."""
    rf = {"on": True, "frequency": DRIVE[mode], "power": 30.0}
    on = dict.fromkeys(["laser_on", "shutter_open", "clock_on"], True)
    detection = RfKnobs(**rf, table=drive_phases(16, mode))
    return Panel(RfKnobs(**rf), detection, PLATE[mode], PLATE[mode], **on | knobs)


def profile(instrument, panel, bursts=1, **options):
    """Mean volts (N, 16) of the phases of bursts behind the settling samples."""
    options.setdefault("labels", np.arange(bursts) + 1)
    angles = np.zeros((bursts, 2))
    counts = instrument.bursts(panel, angles, pulses=EDGES, **options)
    return volts_from_counts(counts.reshape(-1, 16, 20)[..., 8:].mean(-1))
