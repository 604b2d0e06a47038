"""What the instruments of Fig. 13 look at: a flat target across the beam, on the stage."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.instrument import optics as free_space
from cmtof.instrument.optics import sent_power
from cmtof.instrument.parsing import check_fields, choice, number
from cmtof.instrument.settings import TwinSettings
from cmtof.instrument.targets import Plane

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class StageTarget:
    """A mirror or a diffuse plate that faces the instrument (Sec. 8.2: at 60 cm).

    Examples
    --------
    >>> StageTarget.mirror().material
    'specular'
    """

    material: str = choice("diffuse", ("diffuse", "specular"))
    reflectance: float = number(0.5, 0, 1)
    """0 to 1 (diffuse plate: assumed)."""
    distance: float = number(0.60, 0.01, 100)
    """Range of the middle of its travel, m."""

    def __post_init__(self) -> None:
        check_fields(type(self), vars(self), "stage target")

    @classmethod
    def mirror(cls, **changes: float) -> "StageTarget":
        """Build a silvered mirror, PF10-03-P01 (known: 97 % at 532 nm)."""
        return replace(cls(material="specular", reflectance=0.97), **changes)

    def plane(self, distance: float) -> Plane:
        """Return it as a target of the simulated instrument, at a range, m."""
        return Plane(distance, reflectance=self.reflectance, material=self.material)


def collected_power(
    settings: TwinSettings, target: StageTarget, ranges: ArrayLike, *, mode: str = "single"
) -> Array:
    """Mean light behind the receiving optics, W: before any detector or second modulator.

    Speckle, which multiplies it for a diffuse target, is left out.

    Parameters
    ----------
    settings : TwinSettings
    target : StageTarget
    ranges : array_like, shape (...)
        m.
    mode : {"single", "doubled"}
        Of the emission module.

    Returns
    -------
    ndarray, shape (...)

    Examples
    --------
    >>> power = collected_power(TwinSettings(), StageTarget(), 0.6)
    >>> f"{power * 1e9:.1f} nW"
    '2.2 nW'
    """
    distance = np.asarray(ranges, float)
    hits = free_space.Hits(
        distance, np.ones(distance.shape), np.full(distance.shape, target.reflectance)
    )
    share = free_space.returned_fraction(settings.optics, target.material, hits)
    return sent_power(settings, mode) * share * free_space.inward(settings.optics)
