r"""The error budget of the all-optical instrument: a table of terms, and all of them together.

A day begins with a zero from known ranges over one wrap, and ten minutes later comes the sweep.
A small change :math:`a\,\epsilon_k` of the readings :math:`d + a\cos(\phi + \psi_k)` turns the
phase by :math:`-\frac2K\sum_k\epsilon_k\sin(\phi+\psi_k)`, and its rms over unknown phases is the
closed form of a cyclic error. Errors without one are simulated, each alone in `TwinSettings.ideal`.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.correlation import TAU, depth_from_phase
from cmtof_lab import optics as free_space
from cmtof_lab.optical_ranging import FREQUENCY, ORDER, OpticalRanger
from cmtof_lab.settings import TwinSettings
from cmtof_lab.sweep import POSITIONS, STAGE_ERROR
from cmtof_lab.targets import MIRROR, Hits, Plane
from cmtof_lab.world import DRIFT_OCTAVES

Array = NDArray[np.float64]


def budget_terms(
    target: Plane, mode: str = "single", *, days: int = 12, seed: int = 0
) -> dict[str, float]:
    r"""Rms error of each term, m, at the sizes that `TwinSettings` assumes.

    Noise: parts of the Cramer-Rao bound. Codes: :math:`ms/\sqrt{2K}` of K random ones. I/Q
    imbalance e: :math:`(e/2)\sin 2\phi`, nothing in the doubled mode. Back-reflection of the power
    ratio r: :math:`r\sin(\phi_b-\phi)`. RF leakage and laser drift: ``days`` of Monte Carlo before
    a mirror, which leaves little of the converter's rounding.
    """
    real, order = TwinSettings(), ORDER[mode]
    silent = replace(real, converter_noise=0.0)
    noises = [
        OpticalRanger(one, mode).bound(target, [0.0])[0]
        for one in (real, silent, replace(silent, noise_density=0.0))
    ]
    waits, zero = np.arange(POSITIONS.size) + OpticalRanger.age, np.arange(OpticalRanger.visits)
    phases = {
        "RF phase drift": order * real.phase_drift * drift_spread(waits, zero),
        "phase codes": order * real.phase_step_error / np.sqrt(2 * OpticalRanger.phases),
        "I/Q imbalance": real.iq_imbalance / np.sqrt(8) * (mode == "single"),
        "back-reflection": back_ratio(real, target) / np.sqrt(2),
    }
    warmer, denser = OpticalRanger.air_change
    weather = np.hypot(warmer / real.temperature, denser / real.pressure)
    excess = free_space.group_index(real) - 1
    mirror = replace(MIRROR, distance=target.distance)
    still = {"days": days, "seed": seed, "stage_error": 0.0, "air_change": (0, 0)}
    alone = {"RF leakage": only("leakage"), "laser drift": only("fibre_low", "fibre_high")}
    drawn = {name: simulated(one, mirror, mode, **still) for name, one in alone.items()}
    lengths = {
        "photon noise": noises[2],
        "amplifier": np.sqrt(noises[1] ** 2 - noises[2] ** 2),
        "converter": np.sqrt(noises[0] ** 2 - noises[1] ** 2),
        **{name: depth_from_phase(one, FREQUENCY[mode]) for name, one in phases.items()},
        **{name: np.sqrt(np.mean(errors**2)) for name, errors in drawn.items()},
        "air, changed since": excess * target.distance * weather,
        "stage": STAGE_ERROR,
    }
    return {name: float(length) for name, length in lengths.items()}


def drift_spread(times: ArrayLike, reference: ArrayLike) -> float:
    """Rms of the drift at ``times`` less its mean at ``reference``, s, in units of its own rms."""
    rate = TAU * DRIFT_OCTAVES
    now = np.exp(1j * np.multiply.outer(np.asarray(times, float), rate))
    then = np.exp(1j * np.multiply.outer(np.asarray(reference, float), rate)).mean(0)
    return float(np.sqrt(np.mean(np.abs(now - then) ** 2)))


def back_ratio(settings: TwinSettings, target: Plane) -> float:
    """Power of the coaxial back-reflection over that of the target."""
    hits = Hits(*map(np.array, (target.distance, 1.0, target.reflectance)), target.mirrored)
    return settings.back_fraction / float(sum(free_space.returned_fractions(settings, hits)))


def only(*names: str) -> TwinSettings:
    """Instrument without errors but for fields such as ``leakage``, which are real."""
    return TwinSettings.ideal(**{name: getattr(TwinSettings(), name) for name in names})


def simulated(
    settings: TwinSettings, target: Plane, mode: str, *, days: int, seed: int, **lab: Any
) -> Array:
    """Errors (days, P), m, of the sweep of Fig. 13; ``lab`` are fields of `OpticalRanger`."""
    about = POSITIONS - POSITIONS.mean()  # centred as the zero's wrap is
    ranger = OpticalRanger(settings, mode, **lab)
    return ranger.sweep(target, about, repeats=days, seed=seed) - target.distance - about
