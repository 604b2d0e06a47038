r"""From the converter's counts to a calibrated measurement: pure functions, no instrument.

The last samples of each phase, when the filters have settled, are summed; sums, so that nothing is
rounded. With their means n, the converter's calibration U, V, and the laser power P of the line,
P_1 of the mode's first line,

.. math:: C_k = \frac{P_1}{P} \left( U(\bar n_k) - U(\bar n_{dark}) \right).

The reference phase that the file states is the nominal one plus the offset that the reference
target showed, ``psi_k = 2 pi k / K + psi_0``.

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

from cmtof.correlation import TAU, centred, decode, phase_from_depth
from cmtof.hardware.plan import MODES, REFERENCE_BURSTS, SLOT, Plan, Record
from cmtof.measurement import Measurement, unambiguous_range

Array = NDArray[np.float64]

FULL_SCALE = 65535  # of a 16-bit stream sample; it and 0 mean that the converter clips
MIN_CONTRAST = 1e-3  # of the reference target; below there is no phase to calibrate on
RANGES = (10.0, 1.0, 0.1, 0.01)  # of the T7's inputs, V, in the order of its gains


class Gain(NamedTuple):
    """Calibration of one input range: slopes, V per count, and the count of 0 V."""

    positive_slope: float
    negative_slope: float
    centre: float

    def volts_from_counts(self, counts: ArrayLike) -> Array:
        """Volts of 16-bit stream counts, same shape (LabJack's calibration.c)."""
        above = np.asarray(counts, float) - self.centre
        return above * np.where(above < 0, -self.negative_slope, self.positive_slope)


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


def sums_from_counts(
    counts: ArrayLike, kept: ArrayLike
) -> tuple[NDArray[np.uint32], NDArray[np.uint16]]:
    """Sums (N, K) of the last samples of each phase, and how many of them clip (N,).

    Counts (N, K S) of bursts; of each phase's S samples the last ``kept`` (K,) are summed.

    Examples
    --------
    >>> sums, clipped = sums_from_counts([[9, 9, 1, 9, 2, 65535, 9, 3, 3]], [1, 2, 2])
    >>> sums.tolist(), clipped.tolist()
    ([[1, 65537, 6]], [1])
    """
    samples, kept = np.asarray(counts, np.uint32), np.asarray(kept)
    samples = samples.reshape(len(samples), kept.size, -1)
    used = np.arange(samples.shape[2]) >= (samples.shape[2] - kept)[:, None]
    clips = ((samples == 0) | (samples == FULL_SCALE)) & used
    sums = np.where(used, samples, 0).sum(axis=2, dtype=np.uint32)
    return sums, clips.sum(axis=(1, 2)).astype(np.uint16)


class Calibrated(NamedTuple):
    """What the reference target shows of one mode."""

    offset: float  # psi of the first step, rad, in [-pi, pi)
    contrast: float  # amplitude over mean
    drift: float  # phase after the image minus phase before it, rad; 0 where it was seen once


def calibrate(correlation: Array, ranges: ArrayLike, frequency: float) -> Calibrated:
    """Offset of the reference phase from R visits of a target at N optical ranges, m.

    Phasors of the correlations (R, N, K) at the nominal psi are turned back by what their range
    predicts and added up. Over a whole number of wraps a constant phasor, light that comes back
    from the optics, adds up to nothing. Raises ValueError if the target shows no modulation.
    """
    seen = decode(np.moveaxis(correlation, -1, 0), nominal_psi(correlation.shape[-1]))
    turned = np.exp(1j * (seen.phase - phase_from_depth(ranges, frequency)))
    visits = np.sum(seen.amplitude * turned, axis=1)
    total, mean = visits.sum(), float(seen.offset.mean())
    contrast = float(abs(total) / seen.offset.size / mean) if mean > 0 else 0.0
    if not contrast > MIN_CONTRAST:
        raise ValueError(
            f"Expected a reference target with a contrast above {MIN_CONTRAST:g}, got "
            f"{contrast:.2g}. Check that both modulators run and that its light comes back."
        )
    drift = centred(np.angle(visits[-1]) - np.angle(visits[0]))
    return Calibrated(float(centred(np.angle(total))), contrast, float(drift))


class Lines(NamedTuple):
    """Recorded lines of a kind in a mode."""

    counts: Array  # means of the kept samples (L, N, K)
    power: Array  # W (L, 1, 1)
    clipped: NDArray[np.uint16]  # samples (L, N)
    labels: NDArray[np.int64]  # (L, N)


def lines_of(plan: Plan, records: Sequence[Record], mode: str, kind: str) -> Lines:
    """Lines of a kind among records."""
    found = [one for one in records if plan.lines[one.line][1:3] == (mode, kind)]
    return Lines(
        np.array([one.sums for one in found]) / plan.kept,
        np.array([one.power for one in found])[:, None, None],
        np.array([one.clipped for one in found]),
        np.array([plan.lines[one.line].labels for one in found]),
    )


def calibrated(
    plan: Plan, header: Mapping[str, Any], mode: str, records: Sequence[Record]
) -> Calibrated:
    """Calibration of a mode by the whole visits of the reference target that are recorded.

    Of the header of `cmtof.hardware.scan` the converter's ``calibration`` and ``group_index``
    count. Raises a ValueError if the target saturates, or shows no modulation.
    """
    gain, seen = Gain(*header["calibration"]), lines_of(plan, records, mode, "reference")
    volts, clipped = gain.volts_from_counts(seen.counts), int(seen.clipped.sum())
    if clipped or volts.max() > plan.rig.limit_volts:
        raise ValueError(
            f"Expected a reference target within the detector's range, got {volts.max():.2f} V and "
            f"{clipped} clipped samples: it saturates. Put a grey filter before it."
        )
    dark = gain.volts_from_counts(lines_of(plan, records, mode, "dark").counts.mean())
    ranges = plan.rig.reference_distance + np.repeat(plan.sweep, REFERENCE_BURSTS)
    visits = ((volts - dark) / seen.power).reshape(-1, ranges.size, plan.rig.phases)
    return calibrate(visits, header["group_index"] * ranges, _frequency(plan, mode))


def measurement_from_records(
    plan: Plan, header: Mapping[str, Any], records: Sequence[Record]
) -> Measurement:
    """Measurement of the records of every line of a plan; raises as `calibrated` does.

    Beside what every `Measurement` has: ``raw_counts`` (mean of the kept samples), ``dark``,
    ``laser_power`` (W), ``angle`` (rad), ``time`` (s, on the plan's clock), and of each frequency
    what the reference target showed. Pixels where the converter clips are masked.
    """
    modes = [_images(plan, header, mode, records) for mode in MODES]
    dims = {1: (), 2: ("step",), 3: ("y", "x"), 4: ("step", "y", "x")}
    arrays = {name: np.stack([mode[name] for mode in modes]) for name in modes[0]}
    clipped = arrays.pop("clipped").any(axis=0)
    data = xr.Dataset({n: (("frequency", *dims[a.ndim]), a) for n, a in arrays.items()})
    data = data.set_coords(["psi", "time"])
    data["mask"] = (("y", "x"), (~clipped).astype(np.int8))
    data["angle"] = (("y", "x", "axis"), plan.angles, {"units": "rad"})
    data["camera"] = ("parameter", plan.camera)
    data["correlation"].attrs["units"], data["laser_power"].attrs["units"] = "V", "W"
    about = {name: value for name, value in header.items() if value is not None}
    data.attrs = {
        name: value if isinstance(value, str | int | float) else json.dumps(value, sort_keys=True)
        for name, value in about.items()
    } | {
        "protocol": "scan",
        "saturation": FULL_SCALE,
        "range_min": 0.0,
        "range_max": unambiguous_range(arrays["frequency"]),
    }
    return Measurement(data)


def _images(
    plan: Plan, header: Mapping[str, Any], mode: str, records: Sequence[Record]
) -> dict[str, Any]:
    """Arrays and calibration of a mode, by their names in the file."""
    found, gain = calibrated(plan, header, mode, records), Gain(*header["calibration"])
    image = lines_of(plan, records, mode, "scan")
    dark = lines_of(plan, records, mode, "dark").counts.mean()
    volts = gain.volts_from_counts(image.counts) - gain.volts_from_counts(dark)
    volts = volts * (image.power[0] / image.power)
    return {
        "frequency": _frequency(plan, mode),
        "psi": np.mod(nominal_psi(plan.rig.phases) + found.offset, TAU),
        "correlation": np.moveaxis(volts, -1, 0).astype(np.float32),
        "raw_counts": np.moveaxis(image.counts, -1, 0).astype(np.float32),
        "dark": dark,
        "laser_power": np.broadcast_to(image.power[..., 0], image.labels.shape),
        "time": SLOT * image.labels,
        "phase_offset": found.offset,
        "phase_drift": found.drift,
        "reference_contrast": found.contrast,
        "clipped": image.clipped > 0,
    }


def _frequency(plan: Plan, mode: str) -> float:
    """Modulation frequency of a mode, Hz."""
    return plan.rig.drive_frequency(mode) * (2 if mode == "doubled" else 1)
