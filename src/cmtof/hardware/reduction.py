r"""From the converter's counts to a calibrated measurement: pure functions, no instrument.

The last samples of each phase, when the filters have settled, are summed; sums, so that nothing is
rounded. With their means n, the converter's calibration U, V, and the laser power P of the line,
P_1 of the mode's first line,

.. math:: C_k = \frac{P_1}{P} \left( U(\bar n_k) - U(\bar n_{dark}) \right).

The reference phase that the file states is the nominal one plus the offset that the reference
target showed, ``psi_k = 2 pi k / K + psi_0``.

Ranges are optical: light is slower in air, and a frequency in Hz and the speed of light in vacuum
make ``n_g z`` out of a phase. The reference target is compared with ``n_g`` times its distance,
and what comes out of a measurement divided by its attribute ``group_index`` is the distance in m.
"""

import json
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from xarray import Dataset, concat

from cmtof.correlation import TAU, centred, decode, phase_from_depth
from cmtof.hardware.plan import REFERENCE_BURSTS, LineRecord, Plan
from cmtof.hardware.rig import MODES
from cmtof.measurement import Measurement
from cmtof.types import Array, Counts, Fields, Named, Numbers, Pair

Records = Sequence[LineRecord]  # of lines of a plan, in any order

FULL_SCALE = 65535  # of a 16-bit stream sample; it and 0 mean that the converter clips
MIN_CONTRAST = 1e-3  # of the reference target; below there is no phase to calibrate on


class Gain(NamedTuple):
    """Calibration of the read-out's inputs: slopes, V per count, and the count at 0 V."""

    positive_slope: float
    negative_slope: float
    centre: float

    def volts_from_counts(self, counts: ArrayLike) -> Array:
        """Volts of 16-bit stream counts, same shape (LabJack's calibration.c)."""
        above = np.subtract(counts, self.centre)
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
    return np.mod(-nominal_psi(phases) / MODES[mode], TAU)


def sums_from_counts(counts: ArrayLike, kept: ArrayLike) -> tuple[Numbers, Counts]:
    """Sums (N, K) of each phase's last ``kept`` (K,) samples, and number of clipped ones (N,)."""
    samples = np.asarray(counts, np.uint32)
    samples = samples.reshape(len(samples), np.size(kept), -1)
    size = samples.shape[2]
    used = np.arange(size) >= np.subtract(size, kept)[:, None]
    clips = np.isin(samples, (0, FULL_SCALE)) & used
    sums = np.where(used, samples, 0).sum(axis=2, dtype=np.uint32)
    return sums, clips.sum(axis=(1, 2)).astype(np.uint16)


def calibrate(correlation: Array, ranges: ArrayLike, frequency: float) -> Pair:
    """Offset and drift of psi, rad, from R visits of a target at N optical ranges, m.

    Phasors of the correlations (R, N, K) at the nominal psi are turned back by what their range
    predicts and added up. Over a whole number of wraps a constant phasor, light that comes back
    from the optics, adds up to nothing. The drift is from the first visit to the last. Raises
    ValueError if the target shows no modulation.
    """
    seen = decode(np.moveaxis(correlation, -1, 0), nominal_psi(correlation.shape[-1]))
    turned = np.exp(1j * (seen.phase - phase_from_depth(ranges, frequency)))
    visits = np.sum(seen.amplitude * turned, axis=1)
    total = visits.sum()
    mean = seen.offset.mean()
    contrast = abs(total) / seen.offset.size / mean if mean > 0 else 0.0
    if not contrast > MIN_CONTRAST:
        raise ValueError(
            f"Expected a reference target with a contrast above {MIN_CONTRAST:g}, "
            f"got {contrast:.2g}. Check that both modulators run and that its light comes back."
        )
    drift = centred(np.angle(visits[-1]) - np.angle(visits[0]))
    return float(centred(np.angle(total))), float(drift)


def lines_of(plan: Plan, records: Records, mode: str, kind: str) -> tuple[Any, Array]:
    """Records of a mode and kind, stacked into one, and the bursts' mean counts (lines, N, K)."""
    found = [one for one in records if plan.lines[one.line][1:3] == (mode, kind)]
    record: Any = LineRecord._make(map(np.array, zip(*found, strict=True)))
    return record, record.sums / plan.kept


def check_brightness(volts: Array, limit: float) -> None:
    """Raise a ValueError if light drives the detector beyond a limit, V; inf means clipped."""
    if not volts.max() <= limit:
        raise ValueError(
            f"Expected light up to limit_volts, {limit:g} V, got {volts.max():.2f} V: it "
            "saturates. Put a grey filter before it."
        )


def psi_correction(plan: Plan, header: Named, mode: str, records: Records) -> Pair:
    """Offset and drift of psi, rad, by the target; ValueError if it saturates or lacks contrast."""
    gain = Gain(*header["calibration"])
    seen, counts = lines_of(plan, records, mode, "reference")
    volts = gain.volts_from_counts(counts)
    check_brightness(
        np.where(seen.clipped[..., None], np.inf, volts), plan.rig.limit_volts
    )
    dark = gain.volts_from_counts(lines_of(plan, records, mode, "dark")[1].mean())
    ranges = plan.rig.reference_distance + np.repeat(plan.sweep, REFERENCE_BURSTS)
    visits = (volts - dark) / seen.power[:, None, None]
    return calibrate(
        visits.reshape(-1, ranges.size, counts.shape[2]),
        header["group_index"] * ranges,
        MODES[mode] * plan.rig.drive_frequency(mode),
    )


def attributes(values: Named) -> Fields:
    """Attributes of a measurement, in which lists and dicts are JSON."""
    return {
        name: json.dumps(value) if isinstance(value, list | dict) else value
        for name, value in values.items()
    }


def measurement_from_records(
    plan: Plan, header: Named, records: Records
) -> Measurement:
    """Measurement from the records of all lines of a plan; raises as `psi_correction` does.

    Beside what every `Measurement` has: ``raw_counts`` (mean of the kept samples), ``dark``,
    ``laser_power`` (W), ``detuning`` (Hz) and ``reflected_power`` (dBm) of both drives at each
    line's end, ``angle`` (rad), ``time`` (s since 1970 at which a burst was read; simulated, on a
    clock of the bursts' numbers), the attribute ``sample_rate`` (Hz), and of each
    frequency what the reference target showed. Pixels where the converter clips are masked.
    """
    modes = [_images_of_mode(plan, header, mode, records) for mode in MODES]
    data = concat(modes, "frequency").set_coords("time")
    data["mask"] = ~data["clipped"].any("frequency")
    data["camera"] = "parameter", plan.camera
    data["angle"] = ("y", "x", "axis"), plan.angles, {"units": "rad"}
    data.attrs = {
        "protocol": "scan",
        "saturation": FULL_SCALE,
        "sample_rate": float(np.mean([record.rate for record in records])),
        **attributes(header),
    }
    return Measurement(data.drop_vars("clipped"))


def _images_of_mode(plan: Plan, header: Named, mode: str, records: Records) -> Dataset:
    """Part of a measurement that belongs to one mode, from its records."""
    gain = Gain(*header["calibration"])
    offset, drift = psi_correction(plan, header, mode, records)
    image, counts = lines_of(plan, records, mode, "scan")
    dark = lines_of(plan, records, mode, "dark")[1].mean()
    power = image.power[:, None]
    volts = gain.volts_from_counts(counts) - gain.volts_from_counts(dark)
    volts *= (power[0] / power)[..., None]
    watts = np.broadcast_to(power, image.times.shape)
    line = ("y", "x")
    drives = ("y", "module")
    return Dataset(
        {
            "correlation": ((*line, "step"), volts.astype(np.float32), {"units": "V"}),
            "psi": ("step", np.mod(nominal_psi(plan.rig.phases) + offset, TAU)),
            "raw_counts": ((*line, "step"), counts.astype(np.float32)),
            "clipped": (line, image.clipped > 0),
            "dark": dark,
            "laser_power": (line, watts, {"units": "W"}),
            "time": (line, image.times),
            "detuning": (drives, image.locks[..., 0], {"units": "Hz"}),
            "reflected_power": (drives, image.locks[..., 1], {"units": "dBm"}),
            "phase_offset": offset,
            "phase_drift": drift,
        },
        {"frequency": MODES[mode] * plan.rig.drive_frequency(mode)},
    ).transpose("step", ...)
