r"""Michelson interferometer with fringe counting on the simulated instrument (Sec. 8.2).

The reference mirror steps over half a wavelength, K steps a reading; the interferogram is

.. math:: P(\psi) = P_r + P_s + 2|\gamma|\sqrt{m P_r P_s}\cos(\phi + \psi), \quad
          \phi = 4\pi z/\lambda, \quad \sigma_z = \frac{\lambda}{4\pi}\frac{\sqrt{2v/K}}{a},

with the coherence gamma, the share m of the light in the reference beam's mode, amplitude a and
noise v of a step. The stage creeps, and each reading is unwrapped against the one before.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray
from scipy.signal import lfilter
from scipy.special import ndtr

from cmtof.bounds import linear_phase_noise
from cmtof.constants import SPEED_OF_LIGHT
from cmtof.correlation import TAU
from cmtof.hardware.rig import SAMPLE_RATE
from cmtof.types import Array, Numbers
from cmtof_lab.electronics import SLOPE, Chain, density, root_of, volts_per_watt
from cmtof_lab.optics import aperture_area, spot_radius
from cmtof_lab.sweep import Ranger, circular_normals, collected_power
from cmtof_lab.targets import Plane

AIR_PER_KELVIN = -0.93e-6  # 1/K, change of the air's index at 20 C (known)


class Fringes(NamedTuple):
    """Interferogram at ranges (...), V; a rough plate's amplitude is the rms over its speckle."""

    amplitude: Array
    offset: Array
    variance: Array  # noise of one step, V^2


@dataclass(frozen=True, kw_only=True)
class Interferometer(Ranger):
    """Interferometer of Table 4: both drives off, beam block out, APD440A behind grey filters."""

    # Hz, full width at half maximum, several modes (gem 532, known)
    linewidth: float = 30e9
    # Relative, rms over days (assumed: it may run at 532.1 nm)
    wavelength_error: float = 2e-4
    # Of the laser from step to step, relative, rms (assumed)
    intensity_noise: float = 1e-3
    # W of either arm on the detector at most, below its end (assumed)
    arm_power: float = 1.4e-9
    # m, 1/e^2 radius of the reference beam (Sec. 7.1)
    reference_radius: float = 0.25e-3
    imbalance: float = 1e-3  # m, reference arm less the target's distance (assumed)
    steps: int = 8  # K, over half a wavelength (assumed)
    samples: int = 5  # at 24 kS/s in a step (assumed)
    speed: float = 3e-5  # m/s of the stage between positions (assumed: 50 nm a reading)

    # m of travel (assumed: the plate turns by 20 urad per mm)
    speckle_length: float = 0.016
    # m rms, along the beam: a resonance of the breadboard (assumed)
    shaking: float = 20e-9
    resonance: float = 30.0  # Hz (assumed)
    quality: float = 20.0  # quality factor of the resonance (assumed)
    temperature_drift: float = 0.05  # K rms (assumed)
    drift_time: float = 600.0  # s, after which it has forgotten where it was (assumed)
    # 1/K, of the breadboard under the scene arm (steel, known)
    expansion: float = 11e-6

    @property
    def wavelength(self) -> float:
        """Laser wavelength in air, m, by the group index, 1e-5 above the phase index."""
        return self.settings.wavelength / self.settings.group_index

    @property
    def reading_time(self) -> float:
        """Time of a phase reading, and from one to the next, s."""
        return self.steps * self.samples / SAMPLE_RATE

    @property
    def stride(self) -> float:
        """Travel of the stage from one reading to the next, m."""
        return self.speed * self.reading_time

    @property
    def decay(self) -> complex:
        """Exponent of a resonance under white forcing, from one reading to the next."""
        ringing = 1j - 1 / (2 * self.quality)
        return TAU * self.resonance * self.reading_time * ringing

    def matched_share(self, target: Plane) -> float:
        """Share m of the collected light in the reference beam's mode, Gaussian of radius w_r.

        Rough plate: speckle of the coherence ``exp(-(pi w d / lambda z)^2 / 2)`` in the aperture A,
        of which it takes ``2 pi / (A ((pi w / lambda z)^2 + 1 / w_r^2))`` on average, w the spot's
        radius. Mirror: overlap with the wide and curved beam that comes back.
        """
        settings = self.settings
        z = target.distance
        vacuum = settings.wavelength
        if not target.mirrored:
            inverse = (np.pi * spot_radius(settings, z) / (vacuum * z)) ** 2
            area = aperture_area(settings)
            return min(1.0, TAU / (area * (inverse + self.reference_radius**-2)))  # pyright: ignore[reportReturnType]
        width = spot_radius(settings, 2 * z)
        real = self.reference_radius**-2 + width**-2
        # Curvature of the wavefront
        turned = np.pi * settings.divergence / (width * vacuum)
        return 4 / (self.reference_radius * width) ** 2 / (real**2 + turned**2)  # pyright: ignore[reportReturnType]

    def fringes(self, target: Plane, ranges: ArrayLike) -> Fringes:
        """Interferogram at ranges (...), m."""
        settings = self.settings
        scene = np.minimum(collected_power(settings, target, ranges), self.arm_power)
        delay = (
            2 * np.subtract(ranges, target.distance + self.imbalance) / SPEED_OF_LIGHT
        )
        fallen = (np.pi * self.linewidth * delay) ** 2
        coherence = np.exp(-fallen / (4 * np.log(2)))
        mixed = np.sqrt(self.arm_power * self.matched_share(target) * scene)
        amplitude = volts_per_watt(settings) * 2 * coherence * mixed
        offset = volts_per_watt(settings) * (self.arm_power + scene)
        # a mean over a step averages white noise over 1 / (2 T), unless the filters pass less
        passed = Chain(settings, 1 / SAMPLE_RATE).memory(1)[0]
        bandwidth = min(SAMPLE_RATE / (2 * self.samples), passed)
        variance = (
            density(settings, offset) * bandwidth
            + (settings.converter_noise * SLOPE) ** 2 / self.samples
            + (self.intensity_noise * offset) ** 2
        )
        return Fringes(amplitude, offset, variance * settings.noise)

    def day(self, target: Plane, positions: Array, rng: Generator) -> Array:
        """Ranges (P,), m, at stage positions (P,), m, by fringes counted from the first."""
        counts = np.ceil(abs(np.diff(positions)) / self.stride - 1e-9).clip(1)
        # readings at the stops, of all that the stage passes on its way
        stations = np.append(0, counts.cumsum()).astype(int)
        seen = self.fringes(target, target.distance + _along(stations, positions))
        speckle = _along(stations, self._speckle(target, positions, rng))
        shown = seen._replace(amplitude=seen.amplitude * speckle)
        believed = self.wavelength * (1 + self.wavelength_error * rng.standard_normal())
        way = self._way(target, positions, stations, rng)
        counted = self._count_phase(way, shown, rng)
        moved = np.append(0.0, counted[stations[1:]] * believed / (2 * TAU))
        return target.distance + positions[0] + moved

    def _speckle(self, target: Plane, stops: Array, rng: Generator) -> NDArray:
        """Complex speckle factor (P,) of the field at stops (P,), m; 1 without speckle."""
        if not self.settings.speckle or target.mirrored:
            return np.ones(stops.size)
        # circular, of mean square 1, with the correlation exp(-d^2)
        apart = (stops[:, None] - stops) / self.speckle_length
        return root_of(np.exp(-(apart**2)) / 2) @ circular_normals(rng, stops.size)

    def _way(
        self, target: Plane, stops: Array, stations: Numbers, rng: Generator
    ) -> Array:
        """True travel, m, at each reading: stage, shaking, and the drift of temperature."""
        reached = stops + self.stage_error * rng.standard_normal(stops.size)
        way = _along(stations, reached - reached[0])
        shaken = _first_order_process(circular_normals(rng, way.size), self.decay).real  # pyright: ignore[reportAttributeAccessIssue]
        slow = _first_order_process(
            rng.standard_normal(way.size), -self.reading_time / self.drift_time
        )
        warmth = (self.expansion + AIR_PER_KELVIN) * self.temperature_drift
        drifted = target.distance * warmth * (slow - slow[0])
        return way + self.shaking * shaken + drifted

    def _count_phase(self, way: Array, shown: Fringes, rng: Generator) -> Array:
        """Unwrapped phase, rad, of each reading, from the first stop's known speckle phase."""
        noise = np.sqrt(2 * shown.variance / self.steps)
        read = shown.amplitude * np.exp(2j * TAU / self.wavelength * way)
        read += noise * circular_normals(rng, way.size)
        start = np.angle(shown.amplitude[0])
        return np.unwrap(np.append(start, np.angle(read)))[1:] - start

    def bound(self, target: Plane, positions: ArrayLike) -> Array:
        """Cramer-Rao least standard deviation (P,), m, by noise alone, speckle at its mean."""
        seen = self.fringes(target, np.add(target.distance, positions))
        noise = linear_phase_noise(seen.amplitude, seen.variance, self.steps)
        return self.wavelength / (2 * TAU) * noise

    def lost_fringes(self) -> float:
        """Mean number of fringes that one reading loses along the move (law in chapter 17)."""
        spread = self.shaking * np.sqrt(2 - 2 * np.exp(self.decay).real)
        spread = max(spread, 1e-15)
        highest = 4 * (self.stride + 9 * spread) / self.wavelength
        edge = self.wavelength / 4 * np.arange(1, highest + 2, 2)
        forward, backward = (
            ndtr((way - edge) / spread).sum() for way in (self.stride, -self.stride)
        )
        return forward - backward


def _along(stations: Numbers, values: NDArray) -> NDArray:
    """Values at every reading, interpolated linearly from those at the readings ``stations``."""
    return np.interp(np.arange(stations[-1] + 1), stations, values)


def _first_order_process(normals: NDArray, exponent: complex) -> NDArray:
    """Stationary first-order process of unit variance, ``x_k = exp(exponent) x_(k-1) + rest``."""
    keep = np.exp(exponent)
    fresh = np.sqrt(1 - abs(keep) ** 2) * normals
    fresh[:1] = normals[:1]
    return lfilter([1.0], [1.0, -keep], fresh)  # pyright: ignore[reportReturnType]
