r"""From the converter's counts to calibrated correlations: pure functions, no instrument.

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

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.correlation import TAU, centred, decode, phase_from_depth

ADC_FULL_SCALE = 65535
"""Highest count of a 16-bit stream sample; it and 0 mean that the converter clips."""


@dataclass(frozen=True)
class Sampling:
    """How the samples of a burst are laid out.

    Attributes
    ----------
    phases, samples_per_phase : int
        K and S.
    settle_samples : int
        Samples dropped at the start of each phase.
    settle_first : int
        Samples dropped at the start of the first phase, while the mirrors still move.
    """

    phases: int
    samples_per_phase: int
    settle_samples: int
    settle_first: int

    def __post_init__(self) -> None:
        for settle in (self.settle_samples, self.settle_first):
            if not 0 <= settle < self.samples_per_phase:
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

    def sums(self, counts: ArrayLike) -> tuple[NDArray[np.uint32], int]:
        """Sum of each phase (K,), and how many of the summed samples clip.

        Examples
        --------
        >>> sums, clipped = Sampling(2, 3, 1, 2).sums([9, 9, 1, 9, 2, 65535])
        >>> sums.tolist(), clipped
        ([1, 65537], 1)
        """
        samples = np.asarray(counts, np.uint32).reshape(self.phases, self.samples_per_phase)
        place = np.arange(self.samples_per_phase)
        used = place >= (self.samples_per_phase - self.kept)[:, None]
        clips = ((samples == 0) | (samples == ADC_FULL_SCALE)) & used
        return np.where(used, samples, 0).sum(axis=1, dtype=np.uint32), int(clips.sum())


def nominal_psi(phases: int) -> NDArray[np.float64]:
    """Reference phases of the correlation (K,), rad: a full turn, whatever the mode."""
    return TAU * np.arange(phases) / phases


def drive_phases(phases: int, mode: str) -> NDArray[np.float64]:
    """Phases of the detection module's drive (K,), rad, that step psi through a turn.

    With drives ``sin(w t - phi)`` on both modules the correlation is that of ``psi = phi_emission -
    phi_detection``, so the drive steps backwards; in the doubled mode psi is twice as fast, and the
    drive steps through half a turn (Sec. 6.2.2).
    """
    return np.mod(-nominal_psi(phases) / (2 if mode == "doubled" else 1), TAU)


@dataclass(frozen=True)
class Calibrated:
    """What the reference target tells of one mode.

    Attributes
    ----------
    offset : float
        psi of the first step, rad, in [-pi, pi).
    contrast : float
        Amplitude over mean of its correlation.
    drift : float
        Phase after the image minus phase before it, rad; 0 where it was seen once.
    """

    offset: float
    contrast: float
    drift: float


def calibrate(
    correlation: ArrayLike, ranges: ArrayLike, *, frequency: float, group_index: float
) -> Calibrated:
    """Offset of the reference phase from a target at known distances.

    The phasors are turned back by what their distance says and added up. Over a whole number of
    wraps a constant phasor, light that comes back from the optics, adds up to nothing.

    Parameters
    ----------
    correlation : array_like, shape (R, N, K)
        Correlations of R visits of the target, N bursts each, at the nominal psi.
    ranges : array_like, shape (N,)
        Distance along the ray of each burst, m.
    frequency : float
        Modulation frequency, Hz.
    group_index : float
        Of the air.

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


MIN_CONTRAST = 1e-3
"""Contrast of the reference target below which there is no phase to calibrate on."""
