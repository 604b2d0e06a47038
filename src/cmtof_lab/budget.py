r"""The error budget of the all-optical instrument: a table of terms, and all of them together.

A day begins with a zero from known ranges over one wrap, and ten minutes later comes the sweep.
A small change :math:`a\,\epsilon_k` of the readings :math:`d + a\cos(\phi + \psi_k)` turns the
phase by :math:`-\frac2K\sum_k\epsilon_k\sin(\phi+\psi_k)`, and its rms over unknown phases is the
closed form of a cyclic error. Errors without one are simulated, each alone in `TwinSettings.ideal`.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cmtof.correlation import TAU, depth_from_phase
from cmtof.hardware.rig import MODES
from cmtof.types import Array, Values
from cmtof_lab.instrument import DRIFT_OCTAVES
from cmtof_lab.optical_ranging import OpticalRanger
from cmtof_lab.optics import returned_fractions
from cmtof_lab.settings import TwinSettings
from cmtof_lab.sweep import ABOUT, FREQUENCY, POSITIONS, STAGE_ERROR
from cmtof_lab.targets import MIRROR, Plane, RayEnds

REAL = TwinSettings()


def budget_terms(
    target: Plane, mode: str = "single", *, days: int = 12, seed: int = 0
) -> Values:
    r"""Rms error of each term, m, at the sizes that `TwinSettings` assumes.

    Noise: parts of the Cramer-Rao bound. Codes: :math:`ms/\sqrt{2K}` of K random ones. I/Q
    imbalance e: :math:`(e/2)\sin 2\phi`, nothing in the doubled mode. Back-reflection of the power
    ratio r: :math:`r\sin(\phi_b-\phi)`. RF leakage and laser drift: ``days`` of Monte Carlo before
    a mirror, which leaves little of the converter's rounding.
    """
    return {
        **noise_terms(target, mode),
        **phase_terms(target, mode),
        **drawn_terms(target, mode, days=days, seed=seed),
        "air, changed since": air_term(target),
        "stage": STAGE_ERROR,
    }


def noise_terms(target: Plane, mode: str) -> Values:
    """Noise of photons, amplifier and converter, m: differences of Cramer-Rao bounds."""
    silent = replace(REAL, converter_noise=0.0)
    every, analog, photons = (
        OpticalRanger(one, mode).bound(target, [0.0])[0]
        for one in (REAL, silent, replace(silent, noise_density=0.0))
    )
    return {
        "photon noise": photons,
        "amplifier": np.sqrt(analog**2 - photons**2),
        "converter": np.sqrt(every**2 - analog**2),
    }


def phase_terms(target: Plane, mode: str) -> Values:
    """Rms depth errors, m, by phase errors: RF drift, phase codes, I/Q imbalance, reflection."""
    drifted = drift_spread(
        np.arange(POSITIONS.size) + OpticalRanger.age, np.arange(OpticalRanger.visits)
    )
    phases = {
        "RF phase drift": MODES[mode] * REAL.phase_drift * drifted,
        "phase codes": MODES[mode]
        * REAL.phase_step_error
        / np.sqrt(2 * OpticalRanger.phases),
        "I/Q imbalance": REAL.iq_imbalance / np.sqrt(8) * (mode == "single"),
        "back-reflection": back_ratio(REAL, target) / np.sqrt(2),
    }
    return {  # pyright: ignore[reportReturnType]
        name: depth_from_phase(one, FREQUENCY[mode]) for name, one in phases.items()
    }


def drawn_terms(target: Plane, mode: str, *, days: int, seed: int) -> Values:
    """Errors without a closed form, m: RF leakage and laser drift, each alone before a mirror."""
    mirror = replace(MIRROR, distance=target.distance)
    still = {"days": days, "seed": seed, "stage_error": 0.0, "air_change": (0, 0)}
    alone = {"RF leakage": ["leakage"], "laser drift": ["fibre_low", "fibre_high"]}
    found = {}
    for name, flaws in alone.items():
        errors = simulated_errors(ideal_but_for(*flaws), mirror, mode, **still)
        found[name] = np.sqrt(np.mean(errors**2))
    return found


def air_term(target: Plane) -> float:
    """Rms range error, m, by air that has changed since the zero."""
    warmer, denser = OpticalRanger.air_change
    excess = (REAL.group_index - 1) * target.distance
    return excess * np.hypot(warmer / REAL.temperature, denser / REAL.pressure)


def drift_spread(times: ArrayLike, reference: ArrayLike) -> float:
    """Rms of the drift at ``times`` less its mean at ``reference``, s, in units of its own rms."""
    rate = TAU * DRIFT_OCTAVES
    now, then = (
        np.exp(1j * np.multiply.outer(when, rate)) for when in (times, reference)
    )
    return np.sqrt(np.mean(abs(now - then.mean(0)) ** 2))


def back_ratio(settings: TwinSettings, target: Plane) -> float:
    """Power of the coaxial back-reflection over that of the target."""
    hits = RayEnds(target.distance, 1.0, target.reflectance, target.mirrored)
    return settings.back_fraction / sum(returned_fractions(settings, hits))  # pyright: ignore[reportReturnType]


def ideal_but_for(*names: str) -> TwinSettings:
    """Settings of an ideal instrument but for fields such as ``leakage``, which keep defaults."""
    return TwinSettings.ideal(**{name: getattr(REAL, name) for name in names})


def simulated_errors(
    settings: TwinSettings,
    target: Plane,
    mode: str,
    *,
    days: int,
    seed: int,
    **lab: Any,
) -> Array:
    """Errors (days, P), m, of the sweep of Fig. 13; ``lab`` are fields of `OpticalRanger`."""
    ranger = OpticalRanger(settings, mode, **lab)
    found = ranger.sweep(target, ABOUT, repeats=days, seed=seed)
    return found - target.distance - ABOUT
