"""How much slower light is in air."""

import numpy as np

from cmtof.constants import LASER_WAVELENGTH

TEMPERATURE = 293.15
"""Room temperature, K."""

PRESSURE = 101325.0
"""Standard pressure, Pa."""


def group_index(
    *,
    wavelength: float = LASER_WAVELENGTH,
    temperature: float = TEMPERATURE,
    pressure: float = PRESSURE,
) -> float:
    """Group index of dry air, the speed of light in vacuum over that of its modulation.

    The updated Edlen equation (Birch and Downs, Metrologia 30 (1993) 155 and 31 (1994) 315) for the
    phase index n, and ``n_g = n + s dn/ds`` with the wavenumber s. A kelvin or 3.7 hPa change it
    by 1e-6; humidity, which is left out, by less.

    Parameters
    ----------
    wavelength : float
        Of the laser in vacuum, m.
    temperature, pressure : float
        K and Pa.

    Examples
    --------
    >>> round((group_index(temperature=288.15) - 1) * 1e6, 1)
    289.7
    """
    celsius = temperature - 273.15
    square = (1e-6 / wavelength) ** 2
    first, second = 130 - square, 38.9 - square
    refractivity = 8342.54 + 2406147 / first + 15998 / second
    slope = 2 * square * (2406147 / first**2 + 15998 / second**2)
    density = pressure * (1 + 1e-8 * (0.601 - 0.00972 * celsius) * pressure)
    density /= 96095.43 * (1 + 0.0036610 * celsius)
    return float(1 + 1e-8 * np.float64(refractivity + slope) * density)
