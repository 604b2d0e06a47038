"""The modulator's crystal: how its static retardance changes with the angle of the light."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.correlation import TAU
from cmtof.instrument.parsing import check_fields, number

Array = NDArray[np.floating]


@dataclass(frozen=True, kw_only=True)
class Crystal:
    """Electro-optic crystal with its optic axis along the field, across the light.

    The paper does not name it. `LITHIUM_NIOBATE` and `LITHIUM_TANTALATE` are what one could take.
    """

    ordinary: float = number(2.323, 1, 4)
    """n_o of congruent LiNbO3 at 532 nm (known)."""
    extraordinary: float = number(2.234, 1, 4)
    """n_e of congruent LiNbO3 at 532 nm (known)."""
    group_index: float = number(2.5, 1, 5)
    """Of either polarisation at 532 nm (known, from the dispersion: about 2.5)."""
    length: float = number(5e-3, 1e-5, 0.2)
    """Along the light, m (assumed: a third of a modulation wavelength inside)."""

    def __post_init__(self) -> None:
        check_fields(type(self), vars(self), "crystal")

    def retardance(self, across: ArrayLike, along: ArrayLike, wavelength: float) -> Array:
        r"""Static retardance of one pass, rad, by the sines of the angle outside.

        A plate's phase is L times the normal part of the wave vector: in units of ``2 pi/lambda``,
        :math:`\sqrt{n_o^2 - s^2}` for the ordinary wave and
        :math:`\sqrt{n_e^2 (1 - s_z^2/n_o^2) - s_x^2}` for the extraordinary one, s_z along the
        optic axis. To second order it is a saddle.

        Parameters
        ----------
        across, along : array_like
            Sines s_x and s_z.
        wavelength : float
            m.
        """
        x, z = np.square(across), np.square(along)
        fast = np.sqrt(self.ordinary**2 - x - z)
        slow = np.sqrt(self.extraordinary**2 * (1 - z / self.ordinary**2) - x)
        return TAU * self.length / wavelength * (slow - fast)

    def acceptance(self, tolerance: float, wavelength: float) -> float:
        """Sine up to which a square field stays within a change of retardance, rad.

        Second order: along x the change is ``Gamma s^2 / (2 n_o n_e)``, along z
        ``-Gamma s^2 / (2 n_o^2)``, and on the diagonals next to nothing.
        """
        # no angle beyond grazing, however weak the birefringence
        gamma = abs(float(self.retardance(0, 0, wavelength)))
        index = self.ordinary * min(self.ordinary, self.extraordinary)
        return min(float(np.sqrt(2 * index * tolerance / gamma)), 1.0) if gamma else 1.0

    def transit(self, frequency: float) -> float:
        """Share of the retardance that is left as the drive changes while light passes.

        ``sinc(f n_g L / c)`` for a field of one phase all along, as in a resonator; a travelling
        wave would put the difference of the indices in place of n_g.
        """
        return float(np.sinc(frequency * self.group_index * self.length / SPEED_OF_LIGHT))


LITHIUM_NIOBATE = Crystal()
"""LiNbO3: strong birefringence."""
LITHIUM_TANTALATE = Crystal(ordinary=2.183, extraordinary=2.188, group_index=2.4)
"""LiTaO3: a supplier's indices at 0.6 um (semi-el.com), taken at 532 nm; weak birefringence."""
