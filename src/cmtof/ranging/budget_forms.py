"""What closed forms say of each term of the error budget: rms over days of unknown phases, m."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.correlation import TAU, correlation_contrast, depth_from_phase
from cmtof.instrument import optics as free_space
from cmtof.instrument.drift import Drift
from cmtof.instrument.settings import TwinSettings
from cmtof.instrument.targets import Hits
from cmtof.instrument.world import PHASES, SAMPLE_RATE, SAMPLES, World
from cmtof.ranging import cyclic
from cmtof.ranging.budget_terms import MEASURED_AIR, TERMS
from cmtof.ranging.error_budget import AGE, VISITS, ranger_of
from cmtof.ranging.optical import FREQUENCY, OpticalRanger
from cmtof.ranging.target import StageTarget

Array = NDArray[np.float64]

LOWEST = 1e-3
"""Slowest octave of the twin's drift, Hz."""
_GRID = TAU * np.arange(96) / 96


def foretold(name: str, target: StageTarget, *, mode: str, count: int = 21) -> float | None:
    """Rms error of a term, m, the zero taken from a reference over a wrap; None without a form.

    Parameters
    ----------
    name : str
        Key of `TERMS`.
    target : StageTarget
    mode : {"single", "doubled"}
    count : int
        Positions of the sweep, one a second.

    Raises
    ------
    ValueError
        For no term.

    Examples
    --------
    >>> round(foretold("imbalance", StageTarget(), mode="single") * 1e6, 2)
    1.18
    """
    if name not in TERMS:
        raise ValueError(f"Expected a term out of {', '.join(TERMS)}, got {name!r}. Name one.")
    if name in _NOISES:
        return _noise(name, target, mode)
    drive, steps = TwinSettings().drive, 4 if name == "four" else PHASES
    phases: dict[str, Callable[[], float]] = {
        "drift": lambda: drift_spread(np.arange(count) + AGE, np.arange(VISITS) + 1.0)
        * drive.phase_drift * cyclic.ORDER[mode],
        "laser": lambda: _rms(ramp_error(_GRID, mode)),
        "codes": lambda: cyclic.code_noise(drive.phase_step_error, steps=steps, mode=mode)[1],
        "imbalance": lambda: _rms(cyclic.imbalance(_GRID, drive.iq_imbalance, mode=mode)),
        "leakage": lambda: _leakage(mode),
        "back": lambda: back_ratio(target) / np.sqrt(2),
        "four": lambda: _rms(cyclic.aliasing(_GRID, drive.eta, steps=steps, mode=mode)),
        "sixteen": lambda: _rms(cyclic.aliasing(_GRID, drive.eta, steps=steps, mode=mode)),
        "modulators": lambda: _modulators(mode),
    }  # fmt: skip
    if name in phases:
        return float(depth_from_phase(phases[name](), FREQUENCY[mode]))
    lengths = {"weather": air_spread(target.distance), "stage": 5e-8}
    return lengths.get(name)


_NOISES = ("photons", "amplifier", "converter", "reference")


def _noise(name: str, target: StageTarget, mode: str) -> float:
    """Noise of one reading and of the reference's mean; the first is the Cramer-Rao bound."""
    term = TERMS[name]
    loud = TERMS["photons"].change if name == "reference" else term.change
    ranger = ranger_of(loud(TwinSettings.ideal()), mode, {})
    one = float(ranger.bound(target, [0.0])[0]) / term.scale
    readings = (0 if name == "reference" else 1) + 1 / VISITS
    return one * float(np.sqrt(readings))


def back_ratio(target: StageTarget) -> float:
    """Power of the back-reflection over that of the target."""
    optics = TwinSettings().optics
    hits = Hits(*(np.array(x) for x in (target.distance, 1.0, target.reflectance)))
    return optics.back_fraction / float(free_space.returned_fraction(optics, target.material, hits))


def air_spread(distance: float) -> float:
    """Change of the optical range, rms, m, with errors of temperature and pressure."""
    air, wavelength = TwinSettings().air, TwinSettings().laser.wavelength
    relative = np.hypot(
        MEASURED_AIR["temperature_error"] / air.temperature,
        MEASURED_AIR["pressure_error"] / air.pressure,
    )
    return float((free_space.group_index(air, wavelength) - 1) * distance * relative)


def drift_spread(times: ArrayLike, reference: ArrayLike) -> float:
    """Rms of the drift at ``times`` less its mean at ``reference``, in units of its own rms.

    An octave of the angular frequency w leaves ``|exp(i w t) - mean exp(i w t_r)|``; old
    references tend to sqrt(2) for one visit and to 1 for many.

    Examples
    --------
    >>> round(drift_spread([0.0], [0.0]), 9)
    0.0
    """
    rate = TAU * _octaves()
    now = np.exp(1j * np.multiply.outer(np.asarray(times, float), rate))
    then = np.exp(1j * np.multiply.outer(np.asarray(reference, float), rate)).mean(0)
    return float(np.sqrt(np.mean(np.abs(now - then) ** 2)))


def power_slope() -> float:
    """Relative change of the laser's power in the time of a point, rms."""
    laser = TwinSettings().laser
    swing = (laser.fibre_high - laser.fibre_low) / (laser.fibre_high + laser.fibre_low)
    rate = swing / Drift.COUNT * np.sqrt(np.sum((TAU * _octaves()) ** 2) / 2)
    return float(rate * PHASES * SAMPLES / SAMPLE_RATE)


def ramp_error(phase: ArrayLike, mode: str) -> Array:
    """Error, rad, of a ramp of one rms of the laser's drift."""
    wave = _emission(mode, TwinSettings.ideal())[:: cyclic.ORDER[mode]]
    contrast, ramp = correlation_contrast(wave, wave), np.full(np.shape(phase), power_slope())
    return cyclic.power_ramp(phase, ramp, contrast, steps=PHASES)


def residual_ratio() -> float:
    """r of `cyclic.residual_fundamental` with the plates and splitters of the budget."""
    wave = np.abs(_emission("doubled", TERMS["modulators"].change(TwinSettings.ideal())))
    return float((wave[1] / wave[2]) ** 2)


def _modulators(mode: str) -> float:
    """The zero comes from one wrap, the error repeats after two."""
    if mode == "single":
        return 0.0
    both = cyclic.residual_fundamental(
        np.concatenate([_GRID, _GRID + TAU]), residual_ratio(), steps=PHASES
    )
    # a reference over the wrap around the target: its window moves along with the phase
    window = np.ones(_GRID.size) / _GRID.size
    zero = np.fft.irfft(np.fft.rfft(both) * np.conj(np.fft.rfft(window, both.size)), both.size)
    return _rms(both - np.roll(zero, _GRID.size // 2))


def _leakage(mode: str) -> float:
    drive = TwinSettings().drive
    phase, lag = np.meshgrid(_GRID, _GRID, indexing="ij")
    error = cyclic.leakage(phase, lag, drive.leakage, drive.eta, steps=PHASES, mode=mode)
    # the leak's own phase enters as its cosine
    return _rms(error - error.mean(0)) / np.sqrt(2)


def _emission(mode: str, settings: TwinSettings) -> NDArray[np.complex128]:
    ranger = OpticalRanger(settings, mode)
    return World(settings).light.emission(ranger.panel())


def _octaves() -> Array:
    return np.asarray(LOWEST * 2.0 ** np.arange(Drift.COUNT), float)


def _rms(values: ArrayLike) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
