r"""A 100 MHz correlation camera like the LUCID Helios Flex (Sec. 8.2, Fig. 15), simulated.

Flood light, two taps a pixel, four phase steps. All light of a pixel is one phasor, in electrons,

.. math:: F = \sum_\mathrm{paths} N e^{-i\phi}, \qquad
          A, B = \tfrac12\,\bigl(S \pm m\,\mathrm{Re}\,F e^{-i\psi}\bigr),

with S the charge of both taps and m the modulation of square waves behind a pole each. What such
cameras calibrate to below a millimetre (cyclic error, fixed pattern, late taps) is left out.
"""

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from scipy.constants import c, h
from scipy.ndimage import gaussian_filter

from cmtof.bounds import linear_phase_noise
from cmtof.correlation import (
    TAU,
    centred,
    decode,
    depth_from_phase,
    phase_from_depth,
    wrap_length,
)
from cmtof.detector import quantise, skellam_gaussian
from cmtof.hardware.reduction import nominal_psi
from cmtof.types import Array, Arrays, Complex, Shape
from cmtof_lab.optics import SPECULAR_DIFFUSE, SPECULAR_LOBE, lobe_share
from cmtof_lab.targets import RayEnds

Light = tuple[Complex, Array]

STEPS = 4  # phase steps of an image; their exposures add up to the whole
PSI = nominal_psi(STEPS)


@dataclass(frozen=True, kw_only=True)
class MhzCamera:
    """Camera and its light, values *known* of the part or *assumed*, none fitted to the paper."""

    power: float = 8e-3  # W, mean of four VCSELs over the whole field (Sec. 8.2)
    wavelength: float = 850e-9  # m (Sec. 8.2)
    exposure: float = 8e-3  # s (Sec. 8.2)
    frequency: float = 100e6  # Hz: a wrap is 1.5 m (known)
    shape: Shape = (480, 640)  # height and width, px (known: Sony IMX556)
    pixel: float = 10e-6  # m (known)
    field_of_view: float = float(np.deg2rad(59))  # across, rad (known)
    f_number: float = 1.4  # assumed
    transmission: float = 0.8  # of lens and band-pass (assumed)
    efficiency: float = 0.5  # electrons per photon (assumed)
    # Of white in the room behind the band-pass, W/(m^2 sr), assumed
    ambient_radiance: float = 9e-4
    source_radius: float = 0.01  # of the emitters about the lens, m (assumed)
    # Of the taps at 100 MHz (known of a CAPD pixel, Sony, VLSI 2017)
    contrast: float = 0.8
    # Of the emitter and of the gates, Hz, one pole each (assumed)
    bandwidth: float = 400e6
    full_well: float = 100e3  # of a tap, electrons (assumed)
    read_noise: float = 15.0  # of a difference, electrons (assumed)
    bits: int = 12  # of the converter (known)
    full_scale: float = 20e3  # difference at its end, electrons (assumed)
    veil: float = 0.02  # share of all light scattered evenly over the image (assumed)
    blur: float = 0.6  # standard deviation of the point spread, px (assumed)

    @property
    def focal_length(self) -> float:
        """Focal length of the lens, px."""
        return self.shape[1] / 2 / np.tan(self.field_of_view / 2)

    @property
    def pupil_area(self) -> float:
        """Area of the lens's opening, m^2."""
        width = self.focal_length * self.pixel / self.f_number
        return np.pi / 4 * width**2

    @property
    def modulation(self) -> float:
        r"""Amplitude of A - B over the charge, :math:`m = (8/\pi^2)\,C / (1 + f^2/f_c^2)`."""
        ratio = self.frequency / self.bandwidth
        return 8 / np.pi**2 * self.contrast / (1 + ratio**2)

    @property
    def wrap(self) -> float:
        """Range after which answers repeat, m."""
        return wrap_length(self.frequency)  # pyright: ignore[reportReturnType]

    def signal(self, view: RayEnds) -> Array:
        """Charge (H, W), electrons, of one step in both taps by direct light (law in chapter 20).

        A polished surface keeps a small diffuse share, and mirrors where it faces lens and source.
        """
        z = view.range
        sent = self._electrons(self.power) / np.prod(self.shape)
        with np.errstate(all="ignore"):
            lobe = np.hypot(SPECULAR_LOBE, self.source_radius / z)
            # a Gaussian lobe of half angle w peaks at 2 / (pi w^2) per sr, white paper at 1 / pi
            mirror = 2 / lobe**2 * lobe_share(view.cosine, lobe)
            polished = SPECULAR_DIFFUSE * view.cosine + mirror
            shine = (1 - view.mirrored) * view.cosine + view.mirrored * polished
            seen = self.pupil_area / (np.pi * z**2)
        share = view.reflectance * shine * seen
        return sent * np.where(z > 0, share, 0.0)

    def room(self, view: RayEnds) -> Array:
        """Charge of one step from the room's light, electrons, (H, W)."""
        etendue = self.pupil_area / self.focal_length**2
        charge = self._electrons(self.ambient_radiance * etendue) * view.reflectance
        return np.where(view.range > 0, charge, 0.0)

    def _electrons(self, power: float) -> float:
        """Electrons of one step that a power, W, before the lens makes."""
        photons = power * self.exposure / STEPS * self.wavelength / (h * c)
        return photons * self.transmission * self.efficiency

    def light(self, view: RayEnds, field: RayEnds) -> Light:
        """Phasor F of the emitter's light, and charge S of all light (H, W), electrons a step.

        Direct, blurred, and scattered evenly from all of ``field``.
        """
        return tuple(
            (1 - self.veil) * gaussian_filter(own, self.blur, mode="nearest")
            + self.veil * every.mean()
            for own, every in zip(self._lights(view), self._lights(field), strict=True)
        )

    def _lights(self, view: RayEnds) -> Light:
        """Phasor of the direct light, and charge by all light, electrons of a step (H, W)."""
        own = self.signal(view)
        phasor = own * np.exp(-1j * (TAU / self.wrap) * np.nan_to_num(view.range))
        return phasor, own + self.room(view)

    def differences(self, light: Light) -> Array:
        """Mean of A - B in each step, electrons, (4, H, W)."""
        turned = np.multiply.outer(np.exp(-1j * PSI), light[0])
        return self.modulation * turned.real  # pyright: ignore[reportAttributeAccessIssue]

    def capture(self, light: Light, *, rng: Generator) -> Array:
        """Difference images (4, H, W), electrons: Skellam and read noise, rounded.

        NaN where a tap is full, which a camera sees by the sum of its taps.
        """
        swing = self.differences(light)
        a = (light[1] + swing) / 2
        b = (light[1] - swing) / 2
        noisy = skellam_gaussian(a, b, rng=rng, sigma=self.read_noise)
        end = self.full_scale
        images = quantise(noisy + end, bits=self.bits, full_scale=2 * end) - end
        return np.where(np.maximum(a, b) < self.full_well, images, np.nan)

    def depth(self, differences: Array) -> Arrays:
        """Range (H, W), m, and amplitude, electrons, of difference images (4, H, W).

        NaN where the amplitude lies within the noise of a dark pixel, or tap or converter are full.
        """
        found = decode(differences, PSI)
        depth = depth_from_phase(found.phase, self.frequency)
        lost = found.amplitude < np.sqrt(self.variance(0.0) * 2 / STEPS)
        end = self.full_scale * (1 - 2.0**-self.bits)
        lost |= ~(abs(differences).max(0) < end)
        return np.where(lost, np.nan, depth), found.amplitude

    def variance(self, charge: Array | float) -> Array | float:
        """Variance of A - B, electrons^2: Skellam, read noise, rounding."""
        step = 2 * self.full_scale / (2**self.bits - 1)
        return charge + self.read_noise**2 + step**2 / 12

    def bound(self, view: RayEnds) -> Array:
        """Standard deviation of a pixel's range, m, (H, W)."""
        own = self.signal(view)
        with np.errstate(divide="ignore"):
            spread = linear_phase_noise(
                self.modulation * own, self.variance(own + self.room(view)), STEPS
            )
        return depth_from_phase(spread, self.frequency)

    def error(self, found: Array, truth: Array) -> Array:
        """Range less truth, m, modulo the wrap."""
        off = phase_from_depth(found - truth, self.frequency)
        return depth_from_phase(centred(off), self.frequency)
