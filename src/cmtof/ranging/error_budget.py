"""The error budget of the all-optical instrument: each term alone, and all together.

A term starts from an instrument without errors, `TwinSettings.ideal`, and switches one on. What no
setting states, the phases of paths and cables inside, is drawn anew for each day. Errors are
estimated minus true range, m. The converter's rounding stays in every run.
"""

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.correlation import TAU, centred, depth_from_phase, phase_from_depth, wrap_length
from cmtof.instrument import optics as free_space
from cmtof.instrument.settings import TwinSettings
from cmtof.instrument.targets import Plane
from cmtof.instrument.world import LABEL_TIME, World
from cmtof.ranging.budget_terms import STILL_AIR, Change, Term
from cmtof.ranging.cyclic import ORDER
from cmtof.ranging.optical import FREQUENCY, OpticalRanger
from cmtof.ranging.target import StageTarget

Array = NDArray[np.float64]

AGE = 600.0
"""Time from the reference to the sweep, s (assumed)."""
VISITS = 8
"""Positions of the reference, over one wrap (assumed)."""


class Errors(NamedTuple):
    """Errors (D, P), m, of D days at P positions, by how the zero was found."""

    raw: Array
    """The instrument's constants known exactly."""
    zeroed: Array
    """By the same target at known ranges over a whole wrap before, as a scan does it."""
    first: Array
    """By the first reading of the sweep itself."""


class Day(NamedTuple):
    """Phases that no setting states, each anywhere in a turn, 0 to 1."""

    path: float
    back: float
    cable: float
    leak: float

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> "Day":
        """Draw a day."""
        return cls(*rng.uniform(0, 1, 4))

    def settings(self, settings: TwinSettings) -> TwinSettings:
        """Return the instrument on that day: inner path, back-reflection, cable and leak moved."""
        wrap = float(wrap_length(FREQUENCY["single"]))
        optics, drive = settings.optics, settings.drive
        return replace(
            settings,
            optics=replace(
                optics,
                internal_path=optics.internal_path + wrap * self.path,
                back_range=optics.back_range - wrap * self.back,
            ),
            drive=replace(drive, phase_offset=TAU * self.cable, leakage_phase=TAU * self.leak),
        )


def ranger_of(settings: TwinSettings, mode: str, ranging: Mapping[str, Any]) -> OpticalRanger:
    """Build a ranger whose laboratory is perfect but for what ``ranging`` says.

    Raises
    ------
    ValueError
        For what is no field of `OpticalRanger`.
    """
    known = {entry.name for entry in fields(OpticalRanger)}
    wrong = [name for name in ranging if name not in known]
    if wrong:
        raise ValueError(
            f"Expected fields of OpticalRanger, got {', '.join(wrong)}. Correct the term."
        )
    chosen: dict[str, Any] = {"stage_error": 0.0, "calibration": "perfect", **STILL_AIR, **ranging}
    return OpticalRanger(settings, mode, **chosen)


def errors(
    term: Term,
    target: StageTarget,
    positions: ArrayLike,
    *,
    mode: str = "single",
    days: int,
    seed: int,
    visits: int = VISITS,
) -> Errors:
    """Measure one term of the budget on several days.

    Parameters
    ----------
    term : Term
    target : StageTarget
    positions : array_like, shape (P,)
        Of the stage relative to the target's distance, m.
    mode : {"single", "doubled"}
    days : int
        D; at least 1.
    seed : int
    visits : int
        Positions of the reference, over one wrap.

    Raises
    ------
    ValueError
        For no day, or fewer than three visits.
    """
    if days < 1 or visits < 3:
        raise ValueError(
            f"Expected at least 1 day and 3 visits, got {days} and {visits}. Ask for more."
        )
    offsets = np.asarray(positions, float)
    wrap = float(wrap_length(FREQUENCY[mode]))
    known = wrap * ((np.arange(visits) + 0.5) / visits - 0.5)
    now, then = _benches(term, target, mode)
    found = []
    for number in range(days):
        rng = np.random.default_rng((seed, number))
        day, key = Day.drawn(rng), int(rng.integers(2**31))
        air = rng.standard_normal(2)
        earlier = World(day.settings(then.settings), seed=key)
        same = now.settings == then.settings
        today = earlier if same else World(day.settings(now.settings), seed=key)
        at = _readings(then.ranger, earlier, target, known, 0.0, air, rng)
        off = _readings(now.ranger, today, target, offsets, AGE, air, rng)
        turns = np.exp(1j * phase_from_depth(at, FREQUENCY[mode]))
        zero = depth_from_phase(np.angle(turns.sum()), FREQUENCY[mode])
        found.append((off, off - zero, off - off[0]))
    return Errors(*(np.stack(part) / term.scale for part in zip(*found, strict=True)))


class _Bench(NamedTuple):
    ranger: OpticalRanger
    settings: TwinSettings
    """With the target on the stage and its grey filter, which no day changes."""


def _benches(term: Term, target: StageTarget, mode: str) -> tuple[_Bench, _Bench]:
    """Bench of the sweep, and of the reference before it."""
    ideal = TwinSettings.ideal()

    def bench(change: Change, ranging: Mapping[str, Any]) -> _Bench:
        ranger = ranger_of(change(ideal), mode, ranging)
        return _Bench(ranger, ranger.before(target))

    now = bench(term.change, term.ranging)
    if term.reference is None and term.reference_ranging is None:
        return now, now
    return now, bench(term.before, term.lab_before)


def _readings(
    ranger: OpticalRanger,
    world: World,
    target: StageTarget,
    positions: Array,
    start: float,
    air: Array,
    rng: np.random.Generator,
) -> Array:
    """Errors (P,), m, of readings one step after the other, the constants known exactly."""
    labels = 1 + np.rint((start + np.arange(positions.size) * ranger.step_time) / LABEL_TIME)
    at = positions + ranger.stage_error * rng.standard_normal(positions.size)
    phase = ranger.phase(ranger.counts(world, ranger.panel(), at, labels.astype(int)))
    index = ranger.stated_index(*air)
    ranges = index * (target.distance + positions)
    off = phase - _phase_of(ranges, world.settings, ranger.mode)
    return np.asarray(depth_from_phase(centred(off), ranger.frequency) / index, float)


def _phase_of(optical: ArrayLike, settings: TwinSettings, mode: str) -> Array:
    """Phase, rad, not wrapped, of an optical range: inner path and cable included."""
    way = np.asarray(optical, float) + settings.optics.internal_path
    lag = ORDER[mode] * settings.drive.phase_offset
    return np.asarray(phase_from_depth(way, FREQUENCY[mode]) - lag, float)


def rms(values: ArrayLike) -> float:
    """Root of the mean square over the days."""
    return float(np.sqrt(np.mean(np.square(values))))


# --- over a wrap, and on a slope ------------------------------------------------------------------


class Turn(NamedTuple):
    """One day's errors (P,) over a whole wrap, with the phases that closed forms need, rad."""

    positions: Array
    """m."""
    error: Array
    """m, mean removed."""
    phase: Array
    """Of the correlation, whatever shifts it included."""
    stray: float
    """The same of the back-reflection."""
    lag: float
    """Of the detection's drive behind the emission's at psi = 0."""
    leak: float
    """cos of the leak's own phase, which both drives share."""


def over_a_wrap(
    term: Term, target: StageTarget, *, mode: str = "single", count: int = 64, seed: int
) -> Turn:
    """Measure a term once at ``count`` positions over one wrap."""
    rng = np.random.default_rng((seed, 0))
    day, key = Day.drawn(rng), int(rng.integers(2**31))
    bench, _ = _benches(term, target, mode)
    settings = day.settings(bench.settings)
    positions = float(wrap_length(FREQUENCY[mode])) * (np.arange(count) / count - 0.5)
    world, air = World(settings, seed=key), np.zeros(2)
    off = _readings(bench.ranger, world, target, positions, AGE, air, rng) / term.scale
    index = free_space.group_index(settings.air, settings.laser.wavelength)
    return Turn(
        positions,
        off - off.mean(),
        _phase_of(index * (target.distance + positions), settings, mode),
        float(_phase_of(index * settings.optics.back_range, settings, mode)),
        settings.drive.phase_offset,
        float(np.cos(settings.drive.leakage_phase)),
    )


def slope_errors(
    settings: TwinSettings, tilt: float, *, distance: float, count: int, seed: int
) -> Array:
    """Errors (count,), m, that speckle causes on a plane tilted by ``tilt``, rad.

    The phase is that of the spot's mean range, weighted by the light that comes back; each error
    belongs to another piece of the surface.
    """
    surface = Plane(distance, tilt_x=tilt)
    places = free_space.PLACE * np.arange(count, dtype=float)
    angles: Array = np.stack([np.zeros(count), places], axis=-1)
    paths = free_space.trace(surface, angles, settings, seed)
    mean = (paths.fraction * paths.range).sum(1) / paths.fraction.sum(1)
    return mean - surface.look(free_space.directions_from_angles(angles)).range


def slope_scatter(settings: TwinSettings, tilt: float, *, distance: float) -> float:
    """Closed form of `slope_errors`: ``tan(tilt) (w/2) / sqrt(N)``, m.

    A Gaussian spot of the 1/e^2 radius w has the standard deviation w/2 along the slope, and N
    speckle cells weigh it at random. On a slope the range grows by ``z / cos`` more.
    """
    # the twin's spot is the cone that it is at 1 m
    radius = float(free_space.spot_radius(settings.optics, 1.0)) * distance
    cells = free_space.speckle_cells(settings.optics, settings.laser.wavelength, distance)
    return float(np.tan(tilt) * radius / 2 / np.sqrt(cells))
