"""Group index of air: how much slower modulated light travels in it than in vacuum."""

from cmtof.constants import LASER_WAVELENGTH

STANDARD_TEMPERATURE = 288.15  # K, of the air that the refractivity below is stated for
STANDARD_PRESSURE = 101325.0  # Pa, likewise


def group_index(
    *,
    wavelength: float = LASER_WAVELENGTH,
    temperature: float = 293.15,
    pressure: float = STANDARD_PRESSURE,
) -> float:
    """Group index of dry air, ``n_g = n - lambda dn/dlambda``, from m, K and Pa; 1 at 0 Pa.

    Standard air of P. E. Ciddor, Appl. Opt. 35, 1566 (1996), eq. 1, scaled as an ideal gas.
    Vapour is left out: up to 60 % humidity at 293 K it lowers the index by less than 5e-7.

    >>> f"{group_index(temperature=288.15) - 1:.4e}"
    '2.8975e-04'
    """
    square = (1e-6 / wavelength) ** 2  # wave number squared, 1/um^2
    refractivity = 0.0
    for strength, pole in ((0.05792105, 238.0185), (0.00167917, 57.362)):
        # n + sigma dn/dsigma of strength / (pole - sigma^2)
        refractivity += strength * (pole + square) / (pole - square) ** 2
    refractivity *= pressure / STANDARD_PRESSURE
    return 1 + refractivity * (STANDARD_TEMPERATURE / temperature)
