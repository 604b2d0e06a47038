"""What it would take: the size at which one term alone makes a given error. Nothing is fitted."""

from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.special import jv

from cmtof.correlation import TAU, phase_from_depth
from cmtof.instrument import optics as free_space
from cmtof.instrument.settings import TwinSettings
from cmtof.instrument.world import PHASES
from cmtof.ranging import cyclic
from cmtof.ranging.budget_forms import back_ratio, foretold, residual_ratio
from cmtof.ranging.error_budget import VISITS, slope_scatter
from cmtof.ranging.optical import FREQUENCY
from cmtof.ranging.target import StageTarget

EXPANSION = 23e-6
"""Of an aluminium breadboard, 1/K (known)."""
CABLE_LENGTH = 1.0
"""Difference of the cables from the drivers to the crystals, m (assumed)."""
CABLE_DRIFT = 50e-6
"""Change of a PTFE cable's electrical length, 1/K, near room temperature (known, 20 to 100e-6)."""
CABLE_SPEED = 0.7
"""Of the wave in it over that of light (known)."""

_GRID = TAU * np.arange(720) / 720


class Need(NamedTuple):
    """One way to make the error."""

    label: str
    size: float
    """What is needed."""
    unit: str
    assumed: float
    """What the simulated instrument has, in the same unit; NaN where it has nothing of the kind."""
    factor: float
    """Error wanted over the error at the assumed size."""


def offset_needs(error: float, target: StageTarget, *, mode: str) -> list[Need]:
    """Ways to a constant error, m; a cyclic error is taken at its crest.

    Examples
    --------
    >>> ways = {need.label: need for need in offset_needs(33.5e-6, StageTarget(), mode="single")}
    >>> round(ways["RF phase since the zero"].size * 1e3, 1)
    10.0
    """
    _positive(error)
    drive = TwinSettings().drive
    phase = float(phase_from_depth(error, FREQUENCY[mode])) / cyclic.ORDER[mode]
    needs = [Need("RF phase since the zero", phase, "rad", drive.phase_drift,
                  phase / drive.phase_drift)]  # fmt: skip
    needs += _cyclic_needs(cyclic.ORDER[mode] * phase, target, mode)
    return needs + _length_needs(error, target)


def _cyclic_needs(phase: float, target: StageTarget, mode: str) -> list[Need]:
    drive, ratio = TwinSettings().drive, back_ratio(target)
    needs = [Need("back-reflection over target", float(np.sin(phase)), "dB power", ratio,
                  float(np.sin(phase)) / ratio)]  # fmt: skip
    one = cyclic.code_noise(1.0, steps=PHASES, mode=mode)[1]
    codes = phase / one
    needs.append(Need("phase codes", codes, "rad", drive.phase_step_error,
                      codes / drive.phase_step_error))  # fmt: skip
    if mode == "single":
        skew = 2 * phase
        needs.append(Need("I/Q imbalance", skew, "rad", drive.iq_imbalance,
                          skew / drive.iq_imbalance))  # fmt: skip
        four = float(np.abs(cyclic.aliasing(_GRID, drive.eta, steps=4)).max())
        eta = drive_of_aliasing(phase)
        return [*needs, Need("drive, with 4 steps", eta, "eta", drive.eta, phase / four)]
    lags = np.repeat(_GRID[::8, None], _GRID[::8].size, axis=1)
    bent = cyclic.leakage(lags.T, lags, 1.0, drive.eta, steps=PHASES, mode=mode)
    leak = phase / float(np.abs(bent - bent.mean(1, keepdims=True)).max())
    needs.append(Need("RF leakage", leak, "dB field", drive.leakage, leak / drive.leakage))
    left = cyclic.residual_fundamental(np.append(_GRID, _GRID + TAU), 1.0, steps=PHASES)
    ratio = phase / float(np.abs(left).max())
    tilt = plate_of_ratio(ratio)
    needs.append(
        Need("half-wave plates", tilt, "rad", float(np.deg2rad(0.14)), ratio / residual_ratio())
    )
    return needs


def _length_needs(error: float, target: StageTarget) -> list[Need]:
    """Lengths that nobody measures: air, bench, cable and the zero itself."""
    air, none = TwinSettings().air, float("nan")
    excess = free_space.group_index(air, TwinSettings().laser.wavelength) - 1
    whole = excess * target.distance
    cable = CABLE_DRIFT * CABLE_LENGTH / (2 * CABLE_SPEED)  # m of range a kelvin
    return [
        Need("air left out, path in it", error / excess, "m", target.distance, error / whole),
        Need("air since the zero", error / whole * air.temperature, "K", 0.5,
             error / whole * air.temperature / 0.5),
        Need("0.6 m of bench", error / (EXPANSION * 0.6), "K", none, none),
        Need("1 m of cable", error / cable, "K", none, none),
        Need("range of the reference", error, "m", none, none),
    ]  # fmt: skip


def scatter_needs(spread: float, target: StageTarget, *, mode: str) -> list[Need]:
    """Ways to a scatter about a straight line, m rms, from one position to the next."""
    _positive(spread)
    settings = TwinSettings()
    phase = float(phase_from_depth(spread, FREQUENCY[mode])) / cyclic.ORDER[mode]
    shot = _one_reading("photons", target, mode) / spread
    amplifier, converter = (_one_reading(n, target, mode) for n in ("amplifier", "converter"))
    dark = np.hypot(amplifier, converter) / spread
    # shot noise grows as the root of what is lost, the rest in proportion
    light = (shot**2 + np.sqrt(shot**4 + 4 * dark**2)) / 2
    laser = spread / _form("laser", target, mode)
    steep = spread / slope_scatter(settings, np.pi / 4, distance=target.distance)
    return [
        Need("light", float(light), "of assumed", 1.0, float(1 / np.hypot(shot, dark))),
        Need("laser drift", laser, "times", 1.0, laser),
        Need("RF phase, point to point", phase, "rad", settings.drive.phase_drift,
             phase / settings.drive.phase_drift),
        Need("stage", spread, "m", 5e-8, spread / 5e-8),
        Need("slope, fresh speckle", float(np.arctan(steep)), "rad", float("nan"), float("nan")),
    ]  # fmt: skip


def _form(name: str, target: StageTarget, mode: str) -> float:
    found = foretold(name, target, mode=mode)
    if found is None:
        raise ValueError(f"Expected a term with a closed form, got {name!r}. Choose another.")
    return found


def _one_reading(name: str, target: StageTarget, mode: str) -> float:
    """Noise of a single reading, m, the reference's share taken away."""
    return _form(name, target, mode) / float(np.sqrt(1 + 1 / VISITS))


def drive_of_aliasing(phase: float) -> float:
    """Drive eta, rad, at which four steps err by ``phase``, rad: ``(J_3/J_1)^2 = phase``.

    Raises
    ------
    ValueError
        Beyond the drive of the strongest fundamental.

    Examples
    --------
    >>> round(drive_of_aliasing(0.0149), 2)
    0.79
    """
    top = 0.92  # J_1 peaks at 2 eta = 1.84
    if not 0 < phase < _aliased(top):
        raise ValueError(
            f"Expected a phase error from 0 to {_aliased(top):.2g} rad, got {phase:g}. "
            "No useful drive makes more."
        )
    found: Any = brentq(lambda eta: _aliased(eta) - phase, 1e-3, top)
    return float(found)


def _aliased(eta: float) -> float:
    return float((jv(3, 2 * eta) / jv(1, 2 * eta)) ** 2)


def plate_of_ratio(ratio: float) -> float:
    """Error of both half-wave plates, rad, that leaves the drive itself with |W1/W2|^2 = ratio.

    With ``8 theta_h = pi + 8 delta`` the doubled mode keeps ``J_1 sin 8 delta`` of the drive
    beside ``J_2 cos 8 delta``.
    """
    eta = TwinSettings().drive.eta
    return float(np.arctan(np.sqrt(ratio) * jv(2, 2 * eta) / jv(1, 2 * eta)) / 8)


def _positive(error: float) -> None:
    if not error > 0:
        raise ValueError(f"Expected an error above 0 m, got {error:g}. Give its size.")
