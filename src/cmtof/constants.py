"""Constants of nature, of the prototype and of its simulation, with units and sections (Sec.)."""

SPEED_OF_LIGHT = 299_792_458.0  # in vacuum, m/s (exact, SI)
FREQUENCY_SINGLE = 7.15e9  # modulation in the single mode, Hz (Sec. 6.2)
# in the doubled mode, twice a drive at 7.16 GHz, Hz (Sec. 6.2.2)
FREQUENCY_DOUBLED = 14.32e9
FREQUENCIES = (
    FREQUENCY_SINGLE,
    FREQUENCY_DOUBLED,
)  # those that the paper unwraps with, Hz
LASER_WAVELENGTH = 532e-9  # m (Sec. 7.1)
HALF_WAVE_PLATE_SINGLE = 11.25  # its angle in the single mode, degrees (Sec. 6.2.1)
HALF_WAVE_PLATE_DOUBLED = 22.5  # and in the doubled mode, degrees (Sec. 6.2.2)
ADC_BITS = 14  # resolution of the analog-to-digital converter (Sec. 6.3)

# of the simulation (Sec. 8.1)
GAIN = 20.0  # sensor gain G
INTEGRATION_TIME = 1000.0  # T in ms, the unit in which the paper puts it into Eq. 8
FULL_SIGNAL = GAIN * INTEGRATION_TIME  # G T of a white surface, counts
NOISE_SIGMA = 1200.0  # standard deviation of the Gaussian noise, counts
