"""Settings of the 100 MHz correlation camera, every number with its source.

SI units and radians; charge in electrons. *Known*: general knowledge of the part, not verified.
*Assumed*: nobody says; a number that such a part could have. Nothing was tuned to the paper's
results.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cmtof.instrument.parsing import check_fields, number

STEPS = 4
"""Phase steps of an image (the usual four)."""


@dataclass(frozen=True, kw_only=True)
class CameraSettings:
    """A camera like the LUCID Helios Flex with its Sony IMX556PLR (Sec. 8.2, Fig. 15).

    Examples
    --------
    >>> CameraSettings(f_number=0.0)
    Traceback (most recent call last):
        ...
    ValueError: Expected camera.f_number from 0.5 to 32, got 0. Keep to SI units.
    """

    # --- light
    power: float = number(8e-3, 0, 100)
    """Mean power of the four VCSELs together, W (Sec. 8.2), spread evenly over the field."""
    wavelength: float = number(850e-9, 4e-7, 1.1e-6)
    """m (Sec. 8.2)."""
    exposure: float = number(8e-3, 1e-7, 1)
    """Whole exposure, s (Sec. 8.2); taken as the sum of the four phase steps."""
    frequency: float = number(100e6, 1e5, 1e9)
    """Modulation frequency, Hz (Sec. 8.2): a wrap is c / 2f = 1.5 m."""
    emitter_bandwidth: float = number(400e6, 1e6)
    """-3 dB of driver and VCSELs, Hz; one pole rounds the square wave (assumed: 0.9 ns of rise)."""
    source_radius: float = number(0.01, 0, 0.1)
    """Radius of the emitting area beside the lens, m (assumed); widens a mirror's highlight."""

    # --- lens
    width: int = number(640, 1, 10000)
    """px (LUCID: IMX556, 640 x 480)."""
    height: int = number(480, 1, 10000)
    pixel: float = number(10e-6, 1e-7, 1e-3)
    """Side of a pixel, m (LUCID, Sony: 10 um)."""
    field_of_view: float = number(float(np.deg2rad(59)), 0.01, 3)
    """Full horizontal angle, rad (known: 59 x 45 degrees)."""
    f_number: float = number(1.4, 0.5, 32)
    """(assumed: a fast lens, as such cameras have)."""
    transmission: float = number(0.8, 0, 1)
    """Of lens and band-pass at the wavelength (assumed)."""
    filter_width: float = number(30e-9, 0, 1e-6)
    """Width of the band-pass, m (assumed)."""
    ambient_radiance: float = number(3e4, 0, 1e9)
    """Spectral radiance of a white surface in the room at the wavelength, W/(m^2 sr m): a tenth
    of the simulated instrument's 0.1 W/(m^2 sr) over 300 nm of visible light (assumed)."""

    # --- pixel
    efficiency: float = number(0.5, 0, 1)
    """Quantum efficiency at 850 nm, fill factor included (assumed; back-illuminated silicon)."""
    contrast: float = number(0.8, 0, 1)
    """How well charge goes to the tap that is open (known: Sony reported 80 % at 100 MHz at the
    VLSI Symposium 2017 for a 10 um back-illuminated CAPD pixel)."""
    gate_bandwidth: float = number(400e6, 1e6)
    """-3 dB of the gates' drive, Hz; one pole (assumed)."""
    full_well: float = number(100e3, 10)
    """Electrons that a tap holds (assumed)."""
    read_noise: float = number(15.0, 0)
    """Of the difference of both taps, electrons rms (assumed)."""
    bits: int = number(12, 4, 24)
    """Of the converter (known: 12)."""
    full_scale: float = number(20e3, 1)
    """Difference at the converter's end, electrons, at high gain (assumed)."""

    # --- errors of phase, each off at 0
    wiggling_left: float = number(0.05, 0, 1)
    """Share of the cyclic error that the maker's calibration leaves (assumed: its table was taken
    at another temperature); at 1 nothing was calibrated."""
    pattern: float = number(0.03, 0, 3)
    """Fixed phase offset of each pixel, rms, rad (assumed: 7 mm)."""
    pattern_left: float = number(0.1, 0, 1)
    """Share of it that calibration leaves (assumed)."""
    veil: float = number(0.02, 0, 1)
    """Share of the light that lens and sensor scatter evenly over the whole image (assumed)."""
    leak: float = number(1e-9, 0, 1)
    """Share of the emitted light that housing and window send to the sensor, evenly and at range
    0, beyond what calibration takes away (assumed)."""
    blur: float = number(0.6, 0, 20)
    """Standard deviation of the point spread of lens and pixel, cross-talk included, px
    (assumed)."""
    delay: float = number(1e-10, -1e-8, 1e-8)
    """By how much a tap at its full well answers later than an empty one, s; linear in the charge
    (assumed)."""
    nonlinearity: float = number(0.01, 0, 0.5)
    """Share of the charge that a full tap does not tell; grows with the square (assumed)."""

    # --- what its software does
    confidence: float = number(1.0, 0)
    """Least amplitude that is shown as depth, in units of its noise (assumed)."""

    def __post_init__(self) -> None:
        check_fields(type(self), vars(self), "camera")

    @classmethod
    def ideal(cls, **changes: Any) -> "CameraSettings":
        """Build settings with photon and read noise, harmonics and nothing else wrong."""
        errors = ("wiggling_left", "pattern", "pattern_left", "veil", "leak", "blur", "delay")
        quiet = dict.fromkeys((*errors, "nonlinearity", "ambient_radiance", "confidence"), 0.0)
        return replace(cls(**quiet), **changes)

    # --- what follows from them

    @property
    def focal_length(self) -> float:
        """Of the lens, m: half the sensor's width over the tangent of half the field."""
        return self.width * self.pixel / 2 / float(np.tan(self.field_of_view / 2))

    @property
    def pupil_area(self) -> float:
        """Area of the lens' opening, m^2."""
        return float(np.pi / 4 * (self.focal_length / self.f_number) ** 2)

    @property
    def pixels(self) -> int:
        """Number of pixels."""
        return self.width * self.height

    def intrinsics(self, height: int, width: int) -> tuple[float, float, float, float]:
        """Return fx, fy, cx, cy, px, of a window of that many pixels about the axis."""
        focal = self.focal_length / self.pixel
        return focal, focal, width / 2, height / 2
