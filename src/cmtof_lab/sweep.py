r"""The sweep of Fig. 13 and Table 4: the light that returns, and the parts of its errors.

The error of one repeat at stage position x is split by least squares,

.. math:: e(x) = \underbrace{o}_{offset} + s\,(x - \bar x) + r(x), \qquad
          \mathrm{RMSE}^2 = o^2 + s^2\,\mathrm{var}(x) + \frac{P-2}{P}\,\sigma_r^2 .
"""

from abc import ABC, abstractmethod
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.linalg import norm
from numpy.random import Generator, default_rng
from numpy.typing import ArrayLike

from cmtof.constants import FREQUENCY_DOUBLED, FREQUENCY_SINGLE
from cmtof.correlation import wrap_length
from cmtof.types import Array, Complex
from cmtof_lab.optics import inward, returned_fractions, sent_power, trace
from cmtof_lab.settings import TwinSettings
from cmtof_lab.targets import Plane, RayEnds

# Stage positions, m: 1 mm in steps of 50 um (Sec. 8.2)
POSITIONS = 5e-5 * np.arange(21)
ABOUT = POSITIONS - POSITIONS.mean()  # about their middle, as a zero's wrap is
STAGE_ERROR = 5e-8  # Error of a position of the stage, rms, m (Sec. 8.2)
WRAP = float(wrap_length(FREQUENCY_SINGLE))  # m
# Modulation frequency of each mode, Hz.
FREQUENCY = {"single": FREQUENCY_SINGLE, "doubled": FREQUENCY_DOUBLED}


def zero_positions(count: int) -> Array:
    """Stage positions (count,), m, that set a zero: over one wrap, where cyclic errors cancel."""
    return WRAP * ((np.arange(count) + 0.5) / count - 0.5)


def collected_power(
    settings: TwinSettings, target: Plane, ranges: ArrayLike, mode: str = "single"
) -> Array:
    """Mean light (...), W, behind the receiving optics, of a target at ranges (...), m."""
    hits = RayEnds(
        np.append(target.distance, ranges), 1.0, target.reflectance, target.mirrored
    )
    share = sum(returned_fractions(settings, hits))
    # a mirror turns the rim of the spot away: the same part of it at every range
    smooth = replace(settings, speckle=False)
    whole = trace(target, np.zeros((1, 2)), smooth, 0).fraction.sum()
    power = sent_power(settings, mode) * inward(settings) * whole
    return (power * share[1:] / share[0]).reshape(np.shape(ranges))  # pyright: ignore[reportIndexIssue]


@dataclass(frozen=True)
class Ranger(ABC):
    """A range finder before a target on a stage."""

    settings: TwinSettings = field(default_factory=TwinSettings)
    _: KW_ONLY
    stage_error: float = STAGE_ERROR

    def sweep(
        self,
        target: Plane,
        positions: ArrayLike,
        *,
        repeats: int,
        seed: int,
    ) -> Array:
        """Estimated ranges (repeats, P), m, at stage positions (P,), m from the target's distance.

        A repeat is another day: all that no setting states is drawn again.
        """
        stops = np.asarray(positions, float)
        return np.stack(
            [
                self.day(target, stops, default_rng([seed, repeat]))
                for repeat in range(repeats)
            ]
        )

    @abstractmethod
    def day(self, target: Plane, positions: Array, rng: Generator) -> Array:
        """Estimated ranges (P,), m, of one sweep."""


@dataclass(frozen=True)
class PhaseRanger(Ranger):
    """A range finder by the modulation's phase at 7.15 ("single") or 14.32 GHz ("doubled").

    ``visits`` readings at known ranges over one wrap set its zero.
    """

    mode: str = "single"
    visits: int = 8  # (assumed)
    age: float = 600.0  # s from the first visit to the sweep (assumed)
    # s from one reading to the next (assumed: 2.4 mm/s and a turn of 1 mm)
    step_time: float = 1.0

    @property
    def frequency(self) -> float:
        """Modulation frequency, Hz."""
        return FREQUENCY[self.mode]

    def times(self, count: int) -> Array:
        """Times, s, of the visits, and of readings at so many positions."""
        return np.append(
            self.step_time * np.arange(self.visits),
            self.age + self.step_time * np.arange(count),
        )


def circular_normals(rng: Generator, count: int) -> Complex:
    """Circular complex normals (count,) whose real and imaginary parts have unit variance."""
    return rng.standard_normal((count, 2)).view(complex)[:, 0]


class Parts(NamedTuple):
    """Parts (...) of the errors of each repeat, m; the slope has no unit."""

    offset: Array
    slope: Array
    scatter: Array
    rmse: Array
    mae: Array


def parts(errors: Array) -> Parts:
    """Offset, slope, scatter, RMSE and MAE of errors (..., P), m, at `POSITIONS`."""
    offset = errors.mean(-1)
    slope = errors @ ABOUT / (ABOUT @ ABOUT)
    left = errors - offset[..., None] - slope[..., None] * ABOUT
    scatter = norm(left, axis=-1) / np.sqrt(ABOUT.size - 2)
    rmse = norm(errors, axis=-1) / np.sqrt(ABOUT.size)
    return Parts(offset, slope, scatter, rmse, abs(errors).mean(-1))
