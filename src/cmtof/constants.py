"""Constants of nature and of the prototype, each with its section in the paper. SI units."""

SPEED_OF_LIGHT = 299_792_458.0
"""Speed of light in vacuum, m/s (exact, SI)."""

FREQUENCY_SINGLE = 7.15e9
"""Modulation frequency of the single mode, Hz (Sec. 6.2)."""

FREQUENCY_DOUBLED = 14.32e9
"""Modulation frequency of the doubled mode, twice a drive at 7.16 GHz, Hz (Sec. 6.2.2)."""

FREQUENCIES = (FREQUENCY_SINGLE, FREQUENCY_DOUBLED)
"""The two frequencies that the paper unwraps with, lowest first, Hz."""

LASER_WAVELENGTH = 532e-9
"""Wavelength of the laser, m (Sec. 7.1)."""

GAIN = 20.0
"""Sensor gain G of the simulation (Sec. 8.1, training details)."""

INTEGRATION_TIME = 1000.0
"""Integration time T of the simulation in ms, the unit in which the paper puts it into Eq. 8."""

NOISE_SIGMA = 1200.0
"""Standard deviation of the Gaussian noise of the simulation, counts (Sec. 8.1)."""

ADC_BITS = 14
"""Resolution of the analog-to-digital converter (Sec. 6.3)."""

HALF_WAVE_PLATE_SINGLE = 11.25
"""Half-wave plate angle of the single mode, degrees (Sec. 6.2.1)."""

HALF_WAVE_PLATE_DOUBLED = 22.5
"""Half-wave plate angle of the doubled mode, degrees (Sec. 6.2.2)."""
