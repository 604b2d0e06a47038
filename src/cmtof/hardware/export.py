"""From a journal to a measurement: nothing but the journal is needed, whole or begun.

The file holds, beside what every `Measurement` has:

===================  ============================  ============================================
``raw_counts``       frequency, step, y, x         mean of the kept samples, counts
``dark``             frequency                     mean behind the closed shutter, counts
``laser_power``      frequency, y, x               behind the emission module, W
``angle``            y, x, axis                    optical angles x and y of the mirrors, rad
``time``             frequency, y, x               start of the burst on the plan's clock, s
===================  ============================  ============================================

``correlation`` is in V. The attributes ``settings`` and ``instruments`` are JSON; ``group_index``
divides ranges into distances (see `cmtof.hardware.reduction`); ``phase_drift`` says how far the
reference target's phase moved within each mode, rad. No clock of the computer enters.
"""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from cmtof.correlation import TAU
from cmtof.hardware.codecs.labjack import Gain
from cmtof.hardware.journal import Record, read_journal
from cmtof.hardware.plan import Line, Plan, plan_from_dict
from cmtof.hardware.reduction import (
    ADC_FULL_SCALE,
    Calibrated,
    Sampling,
    calibrate,
    nominal_psi,
)
from cmtof.measurement import Measurement, unambiguous_range

SLOT = 20e-3
"""Time from the start of one burst to that of the next on the plan's clock, s: 13.3 ms for the
paper's burst, and what the devices need between."""


def export(journal: str | Path, output: str | Path) -> Measurement:
    """Write the measurement that a journal holds, whole or not at all; return it.

    Pixels that are not measured yet, or where the converter clips, are masked. The same journal
    gives the same bytes.

    Parameters
    ----------
    journal : str or Path
        From a scan, finished or not, running or not.
    output : str or Path
        The file to write, ``*.nc``.

    Raises
    ------
    ValueError
        If the journal is damaged, or its reference target shows no modulation.
    """
    measurement = measurement_from_journal(*read_journal(journal))
    measurement.save(output)
    with Path(output).open("rb") as written:  # the journal may be removed after this
        os.fsync(written.fileno())
    return measurement


def measurement_from_journal(header: Mapping[str, Any], records: Sequence[Record]) -> Measurement:
    """Measurement of a header and the records that there are."""
    plan = plan_from_dict(header["plan"])
    sampling = Sampling(**header["sampling"])
    modes = [_Mode(header, plan, sampling, mode, records) for mode in plan.modes]
    modes.sort(key=lambda mode: mode.frequency)
    frequencies = np.array([mode.frequency for mode in modes])
    names = ("frequency", "step", "y", "x")
    image = ("frequency", "y", "x")
    dataset = xr.Dataset(
        {
            "correlation": (names, np.stack([mode.correlation for mode in modes]), VOLT),
            "raw_counts": (names, np.stack([mode.raw_counts for mode in modes])),
            "dark": ("frequency", np.array([mode.dark for mode in modes])),
            "mask": (("y", "x"), np.all([mode.valid for mode in modes], axis=0).astype(np.int8)),
            "angle": (("y", "x", "axis"), plan.angles, {"units": "rad"}),
        },
        {
            "frequency": frequencies,
            "psi": (("frequency", "step"), np.stack([mode.psi for mode in modes])),
            "time": (image, np.stack([mode.time for mode in modes])),
        },
    )
    if "power_meter" in header["settings"]["devices"]:
        power = np.stack([mode.power for mode in modes])
        dataset["laser_power"] = (image, power, {"units": "W"})
    if plan.camera is not None:
        dataset["camera"] = ("parameter", plan.camera)
    dataset.attrs = _attributes(header, modes, complete=len(records) == len(plan.lines))
    dataset.attrs |= {"range_min": 0.0, "range_max": unambiguous_range(frequencies)}
    return Measurement(dataset)


VOLT = {"units": "V"}


def _attributes(
    header: Mapping[str, Any], modes: "Sequence[_Mode]", *, complete: bool
) -> dict[str, Any]:
    def text(key: str) -> str:
        return json.dumps(header[key], sort_keys=True)

    given = {key: header[key] for key in ("seed", "scene") if header[key] is not None}
    return {
        "version": header["version"],
        "source": header["source"],
        "protocol": "scan",
        "settings": text("settings"),
        "instruments": text("instruments"),
        "calibration": text("gain"),
        "group_index": header["group_index"],
        "saturation": ADC_FULL_SCALE,
        "complete": int(complete),
        "phase_offset": [mode.calibrated.offset for mode in modes],
        "phase_drift": [mode.calibrated.drift for mode in modes],
        "reference_contrast": [mode.calibrated.contrast for mode in modes],
        **given,
    }


@dataclass
class _Mode:
    """One modulation mode as far as it was recorded."""

    header: Mapping[str, Any]
    plan: Plan
    sampling: Sampling
    mode: str
    records: Sequence[Record]

    def __post_init__(self) -> None:
        self.frequency = float(self.header["frequencies"][self.mode])
        self._gain = Gain(**self.header["gain"])
        done = [
            (line, self.records[line.index])
            for line in self.plan.lines[: len(self.records)]
            if line.mode == self.mode
        ]
        darks = [self._counts(record).mean() for line, record in done if line.kind == "dark"]
        self.dark = float(darks[0]) if darks else 0.0
        image = [(line, record) for line, record in done if line.kind == "scan"]
        self._power = image[0][1].power if image else 1.0
        self._fill(image)
        self.calibrated = self._calibrate(
            [record for line, record in done if line.kind == "reference"] if darks else []
        )
        psi = nominal_psi(self.sampling.phases) + self.calibrated.offset
        self.psi = np.mod(psi, TAU)

    def _counts(self, record: Record) -> NDArray[np.float64]:
        """Mean counts (N, K) of the kept samples."""
        return record.sums / self.sampling.kept

    def _volts(self, counts: NDArray[np.float64], power: float) -> NDArray[np.float64]:
        """Calibrated, above the dark, as at the power of the mode's first line."""
        volts = self._gain.volts_from_counts(counts) - self._gain.volts_from_counts(self.dark)
        return volts * (self._power / power)

    def _fill(self, image: Sequence[tuple[Line, Record]]) -> None:
        shape = self.plan.shape
        steps = (self.sampling.phases, *shape)
        self.correlation, self.raw_counts = np.zeros(steps, np.float32), np.zeros(steps, np.float32)
        self.power, self.time = np.zeros(shape), np.zeros(shape)
        self.valid = np.zeros(shape, bool)
        for line, record in image:
            at = line.row, line.columns
            counts = self._counts(record)
            self.raw_counts[:, *at] = counts.T
            self.correlation[:, *at] = self._volts(counts, record.power).T
            self.power[at], self.valid[at] = record.power, record.clipped == 0
        for line in self.plan.lines:
            if (line.mode, line.kind) == (self.mode, "scan"):
                self.time[line.row, line.columns] = SLOT * np.array(line.labels)

    def _calibrate(self, visits: Sequence[Record]) -> Calibrated:
        """Offset by the reference target; none while it has not been seen."""
        if not visits:
            self.valid[:] = False
            return Calibrated(0.0, 0.0, 0.0)
        reference = self.header["settings"]["reference"]
        bursts = len(visits[0].sums) // len(self.plan.sweep)
        ranges = reference["distance"] + np.repeat(self.plan.sweep, bursts)
        seen = [self._volts(self._counts(record), record.power) for record in visits]
        return calibrate(
            seen, ranges, frequency=self.frequency, group_index=self.header["group_index"]
        )
