r"""From the converter's counts to a calibrated measurement: pure functions, no instrument.

A burst holds K phases of S samples. The first samples of each phase, while the filters settle, are
dropped and the rest summed; sums, not means, so that nothing is rounded. Then

.. math:: C_k = \frac{P_1}{P} \left( U(\bar n_k) - U(\bar n_{dark}) \right)

with U the converter's calibration, V, and P the laser power of the line, P_1 of the first line of
the mode. The reference phase that the file states is the nominal one plus the offset that the
reference target showed, ``psi_k = 2 pi k / K + psi_0``.

Ranges are optical: light is slower in air, and a frequency in Hz and the speed of light in vacuum
make ``n_g z`` out of a phase. So the reference target is held against ``n_g`` times its distance,
and what comes out of a measurement divided by its attribute ``group_index`` is the distance in m.
"""

import json
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from cmtof.correlation import TAU, centred, decode, phase_from_depth
from cmtof.hardware.plan import Plan, Record
from cmtof.measurement import Measurement, unambiguous_range

Array = NDArray[np.float64]

FULL_SCALE = 65535
"""Highest count of a 16-bit stream sample; it and 0 mean that the converter clips."""
SLOT = 20e-3
"""Time from one burst to the next on the plan's clock, s: 13.3 ms for the paper's burst, and what
the devices need between."""
MIN_CONTRAST = 1e-3
"""Contrast of the reference target below which there is no phase to calibrate on."""
RANGES = (10.0, 1.0, 0.1, 0.01)
"""Input ranges of the T7, V, in the order of its gains."""


class Gain(NamedTuple):
    """Calibration of one input range: slopes, V per count, and the count of 0 V."""

    positive_slope: float
    negative_slope: float
    centre: float

    def volts_from_counts(self, counts: ArrayLike) -> Array:
        """Volts of 16-bit stream counts, same shape (LabJack's calibration.c).

        Examples
        --------
        >>> NOMINAL_GAIN.volts_from_counts([33523, 65187, 1859]).round(3).tolist()
        [0.0, 10.0, -10.0]
        """
        raw = np.asarray(counts, float)
        below = (self.centre - raw) * self.negative_slope
        return np.where(raw < self.centre, below, (raw - self.centre) * self.positive_slope)


NOMINAL_GAIN = Gain(0.000315805780, -0.000315805800, 33523.0)
"""Nominal values of the 10 V range (T-Series Datasheet, 20.0.1)."""


@dataclass(frozen=True, config=ConfigDict(extra="forbid", strict=True))
class Sampling:
    """Layout of a burst: K phases of S samples, and how many are dropped at the start of each.

    ``settle_first`` are dropped in the first phase, while the mirrors still move.
    """

    phases: int
    samples_per_phase: int
    settle_samples: int
    settle_first: int

    def __post_init__(self) -> None:
        for settle in (self.settle_samples, self.settle_first):
            if not 0 <= settle < self.samples_per_phase <= 1000 or not 3 <= self.phases <= 64:
                raise ValueError(
                    f"Expected fewer than {self.samples_per_phase} samples of a phase to be "
                    f"dropped, got {settle}. Raise `samples_per_phase` or lower `settling`."
                )

    @property
    def scans(self) -> int:
        """Samples of a burst."""
        return self.phases * self.samples_per_phase

    @property
    def kept(self) -> NDArray[np.int64]:
        """Samples of each phase (K,) that are summed."""
        kept = np.full(self.phases, self.samples_per_phase - self.settle_samples)
        kept[0] = self.samples_per_phase - max(self.settle_first, self.settle_samples)
        return kept

    def sums(self, counts: ArrayLike) -> tuple[NDArray[np.uint32], NDArray[np.uint16]]:
        """Sum of each phase (N, K) of bursts (N, K S), and how many summed samples clip (N,).

        Examples
        --------
        >>> sums, clipped = Sampling(3, 3, 1, 2).sums([[9, 9, 1, 9, 2, 65535, 9, 3, 3]])
        >>> sums.tolist(), clipped.tolist()
        ([[1, 65537, 6]], [1])
        """
        samples = np.asarray(counts, np.uint32)
        samples = samples.reshape(-1, self.phases, self.samples_per_phase)
        used = np.arange(self.samples_per_phase) >= (self.samples_per_phase - self.kept)[:, None]
        clips = ((samples == 0) | (samples == FULL_SCALE)) & used
        sums = np.where(used, samples, 0).sum(axis=2, dtype=np.uint32)
        return sums, clips.sum(axis=(1, 2)).astype(np.uint16)


def nominal_psi(phases: int) -> Array:
    """Reference phases of the correlation (K,), rad: a full turn, whatever the mode."""
    return TAU * np.arange(phases) / phases


def drive_phases(phases: int, mode: str) -> Array:
    """Phases of the detection module's drive (K,), rad, that step psi through a turn.

    With drives ``sin(w t - phi)`` on both modules the correlation is that of ``psi = phi_emission -
    phi_detection``, so the drive steps backwards; in the doubled mode psi is twice as fast, and the
    drive steps through half a turn (Sec. 6.2.2).
    """
    return np.mod(-nominal_psi(phases) / (2 if mode == "doubled" else 1), TAU)


class Calibrated(NamedTuple):
    """What the reference target shows of one mode.

    ``offset``: psi of the first step, rad, in [-pi, pi); ``contrast``: amplitude over mean;
    ``drift``: phase after the image minus phase before it, rad, 0 where it was seen once.
    """

    offset: float
    contrast: float
    drift: float


def calibrate(
    correlation: ArrayLike, ranges: ArrayLike, *, frequency: float, group_index: float
) -> Calibrated:
    """Offset of the reference phase from a target at known distances.

    The phasors are turned back by what their distance predicts and added up. Over a whole number of
    wraps a constant phasor, light that comes back from the optics, adds up to nothing.

    Parameters
    ----------
    correlation : array_like, shape (R, N, K)
        Correlations of R visits of the target, N bursts each, at the nominal psi.
    ranges : array_like, shape (N,)
        Distance along the ray of each burst, m.
    frequency, group_index : float
        Modulation frequency, Hz, and of the air.

    Raises
    ------
    ValueError
        If the target shows no modulation.

    Examples
    --------
    >>> z, psi = np.linspace(0.6, 0.61, 5), nominal_psi(8)
    >>> seen = 3 + np.cos(phase_from_depth(z, 7.15e9)[:, None] + psi + 0.25)
    >>> round(calibrate(seen[None], z, frequency=7.15e9, group_index=1.0).offset, 6)
    0.25
    """
    correlation = np.asarray(correlation, float)
    seen = decode(np.moveaxis(correlation, -1, 0), nominal_psi(correlation.shape[-1]))
    expected = phase_from_depth(group_index * np.asarray(ranges, float), frequency)
    visits = np.sum(seen.amplitude * np.exp(1j * (seen.phase - expected)), axis=1)
    total, mean = visits.sum(), float(seen.offset.mean())
    contrast = abs(total) / seen.offset.size / mean if mean > 0 else 0.0
    if not contrast > MIN_CONTRAST:
        raise ValueError(
            f"Expected a reference target with a contrast above {MIN_CONTRAST:g}, got "
            f"{contrast:.2g}. Check that both modulators run and that its light comes back."
        )
    drift = centred(np.angle(visits[-1]) - np.angle(visits[0]))
    return Calibrated(float(centred(np.angle(total))), float(contrast), float(drift))


def measurement_from_records(header: Mapping[str, Any], records: Sequence[Record]) -> Measurement:
    """Measurement of a journal's header and the records that there are.

    Beside what every `Measurement` has: ``raw_counts`` (mean of the kept samples), ``dark``,
    ``laser_power`` (W), ``angle`` (rad), ``time`` (s, on the plan's clock). Pixels that are not
    measured yet, or where the converter clips, are masked.

    Raises
    ------
    ValueError
        If the reference target shows no modulation, or saturates detector or converter.
    """
    plan = Plan.from_dict(header["plan"])
    modes = [_mode(header, plan, mode, records) for mode in plan.modes]
    modes.sort(key=lambda mode: mode["frequency"])

    def stacked(name: str) -> NDArray[Any]:
        return np.stack([mode[name] for mode in modes])

    frequencies = stacked("frequency")
    names, image = ("frequency", "step", "y", "x"), ("frequency", "y", "x")
    dataset = xr.Dataset(
        {
            "correlation": (names, stacked("correlation"), {"units": "V"}),
            "raw_counts": (names, stacked("raw_counts")),
            "dark": ("frequency", stacked("dark")),
            "mask": (("y", "x"), stacked("valid").all(axis=0).astype(np.int8)),
            "angle": (("y", "x", "axis"), plan.angles, {"units": "rad"}),
        },
        {
            "frequency": frequencies,
            "psi": (("frequency", "step"), stacked("psi")),
            "time": (image, stacked("time")),
        },
    )
    if "power_meter" in header["settings"]["devices"]:
        dataset["laser_power"] = (image, stacked("power"), {"units": "W"})
    dataset["camera"] = ("parameter", plan.camera)
    found = [mode["calibrated"] for mode in modes]
    texts = {"settings": "settings", "instruments": "instruments", "calibration": "gain"}
    dataset.attrs = {
        "version": header["version"],
        "source": header["source"],
        "protocol": "scan",
        **{name: json.dumps(header[key], sort_keys=True) for name, key in texts.items()},
        "group_index": header["group_index"],
        "saturation": FULL_SCALE,
        "complete": int(len(records) == len(plan.lines)),
        "phase_offset": [one.offset for one in found],
        "phase_drift": [one.drift for one in found],
        "reference_contrast": [one.contrast for one in found],
        **{key: header[key] for key in ("seed", "scene") if header[key] is not None},
        "range_min": 0.0,
        "range_max": unambiguous_range(frequencies),
    }
    return Measurement(dataset)


def _mode(
    header: Mapping[str, Any], plan: Plan, mode: str, records: Sequence[Record]
) -> dict[str, Any]:
    """Arrays and calibration of one modulation mode as far as it was recorded."""
    sampling, gain = Sampling(**header["sampling"]), Gain(**header["gain"])
    lines = [line for line in plan.lines if line.mode == mode]
    done = [(line, records[line.index]) for line in lines if line.index < len(records)]
    counts = {line.index: record.sums / sampling.kept for line, record in done}
    darks = [counts[line.index].mean() for line, _ in done if line.kind == "dark"]
    dark = float(darks[0]) if darks else 0.0
    image = [(line, record) for line, record in done if line.kind == "scan"]
    first = image[0][1].power if image else 1.0

    def volts(index: int, power: float) -> Array:
        """Calibrated, above the dark, as at the power of the mode's first line."""
        above = gain.volts_from_counts(counts[index]) - gain.volts_from_counts(dark)
        return above * (first / power)

    shape, steps = plan.shape, (sampling.phases, *plan.shape)
    correlation, raw = np.zeros(steps, np.float32), np.zeros(steps, np.float32)
    power, time, valid = np.zeros(shape), np.zeros(shape), np.zeros(shape, bool)
    for line, record in image:
        row = line.row
        raw[:, row] = counts[line.index].T
        correlation[:, row] = volts(line.index, record.power).T
        power[row], valid[row] = record.power, record.clipped == 0
    for line in lines:
        if line.kind == "scan":
            time[line.row] = SLOT * np.array(line.labels)
    frequency, visits = float(header["frequencies"][mode]), []
    if darks:
        visits = [(line, record) for line, record in done if line.kind == "reference"]
    calibrated = Calibrated(0.0, 0.0, 0.0)
    if visits:
        _check_level(visits, counts, gain, header["settings"]["detection"]["limit_volts"])
        bursts = len(visits[0][1].sums) // len(plan.sweep)
        ranges = header["settings"]["reference"]["distance"] + np.repeat(plan.sweep, bursts)
        seen = [volts(line.index, record.power) for line, record in visits]
        index = header["group_index"]
        calibrated = calibrate(seen, ranges, frequency=frequency, group_index=index)
    else:
        valid[:] = False
    return {
        "frequency": frequency,
        "correlation": correlation,
        "raw_counts": raw,
        "dark": dark,
        "power": power,
        "time": time,
        "valid": valid,
        "psi": np.mod(nominal_psi(sampling.phases) + calibrated.offset, TAU),
        "calibrated": calibrated,
    }


def _check_level(
    visits: Sequence[tuple[Any, Record]],
    counts: Mapping[int, Array],
    gain: Gain,
    limit: float,
) -> None:
    """Raise a ValueError where the reference target drives detector or converter to their end."""
    clipped = sum(int(record.clipped.sum()) for _, record in visits)
    highest = max(float(gain.volts_from_counts(counts[line.index]).max()) for line, _ in visits)
    if clipped or highest > limit:
        raise ValueError(
            f"Expected a reference target within the detector's range, got {highest:.2f} V and "
            f"{clipped} clipped samples: it saturates. Put a grey filter before it."
        )
