r"""An image sensor behind one modulator: how many pixels a crystal can serve, and how well.

Sec. 9 of the paper would expand the modulated light with a telescope and put an array behind it.
Lenses keep the étendue, area times solid angle: what enters a scene through a small crystal may
come from a wide field only through a small pupil. The emitted light is one mode of a fibre and can
be spread at will; the returned light must pass the *detection's* crystal at all angles of the
field. Two passes of a birefringent crystal bound these angles, and so

.. math:: N = \frac{a^2\,(2 s)^2}{\lambda^2}, \qquad
          s^2 \approx \frac{n^2 \lambda\,\Gamma_\mathrm{tol}}{\pi L\,|n_e - n_o|},
          \qquad a\,s = D \sin\theta_F

for an aperture of side a, sines of angles up to s, a pupil of side D and a field of +- theta_F.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import jv

from cmtof import bounds
from cmtof.constants import FREQUENCY_DOUBLED, FREQUENCY_SINGLE, SPEED_OF_LIGHT
from cmtof.correlation import (
    TAU,
    centred,
    correlation_from_phase,
    decode,
    depth_from_phase,
    phase_from_depth,
    wrapped,
)
from cmtof.detector import poisson_gaussian
from cmtof.instrument import optics as free_space
from cmtof.instrument.budget import sent_power
from cmtof.instrument.electronics import PLANCK
from cmtof.instrument.parsing import check_fields, choice, number
from cmtof.instrument.settings import TwinSettings
from cmtof.modulator import doubled_mode_harmonics, single_mode_harmonics
from cmtof.ranging.crystal import LITHIUM_NIOBATE, Crystal

Array = NDArray[np.floating]
Phasor = NDArray[np.complex128]

ACTIVE_SIDE = 2.5e-3
"""Side of the modulator's active area, m (Sec. 9)."""


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """Global-shutter CMOS sensor of the kind of Sony's IMX252, in the paper's stereo cameras."""

    efficiency: float = number(0.65, 0, 1)
    """Quantum efficiency at 532 nm (known, about)."""
    read_noise: float = number(2.3, 0, 1e4)
    """Electrons, rms (known, about)."""
    full_well: float = number(1.05e4, 1)
    """Electrons (known, about)."""
    bits: int = number(12, 4, 16)  # type: ignore[assignment]
    """Bits of its converter, over the full well (known)."""
    dark_current: float = number(2.0, 0)
    """Electrons/s (assumed, at room temperature)."""

    def __post_init__(self) -> None:
        check_fields(type(self), vars(self), "sensor")

    @property
    def noise(self) -> float:
        """Of one reading, electrons, rms: read noise and rounding."""
        return float(np.hypot(self.read_noise, self.full_well / 2**self.bits / np.sqrt(12)))


class Electrons(NamedTuple):
    """What a pixel collects in a second, electrons/s: ``mean + amplitude cos(phi + psi)``."""

    mean: Array
    """With room light and dark current."""
    amplitude: Array


class Frame(NamedTuple):
    """What frames of an array came to, (repeats, H, W) each."""

    phase: Array
    """Wrapped, rad, its change over the field calibrated away."""
    error: Array
    """Range less true range, m, within half a wrap."""
    bound: Array
    """Least standard deviation of the range by noise alone, m."""
    electrons: Array
    """Mean number a phase."""


@dataclass(frozen=True, kw_only=True)
class ArrayImager:
    """Flood light, one detection modulator with a telescope on either side, an image sensor.

    The crystal stands in a pupil: a pixel is an angle. The whole field is lit evenly, its N pixels
    share the emitted light.
    """

    twin: TwinSettings = field(default_factory=TwinSettings)
    """Laser, emission, drive, optics and room light: those of the scanning instrument."""
    crystal: Crystal = LITHIUM_NIOBATE
    sensor: Sensor = field(default_factory=Sensor)
    mode: str = choice("single", ("single", "doubled"))
    pixels: int = number(64, 1, 100_000)  # type: ignore[assignment]
    """Across the square image."""
    half_field: float = number(0.2, 1e-4, 1.5)
    """Half the width of the field of view in the scene, rad."""
    side: float = number(ACTIVE_SIDE, 1e-5, 1)
    """Side of the active area, m."""
    tolerance: float = number(0.2, 1e-6, 10)
    """Change of a pass's static retardance at the field's rim, rad (chosen: costs 8 % of the
    amplitude there)."""
    brightness: float = number(1.0, 0, 1e9)
    """Emitted power over that of the scanning instrument."""
    diffuser: float = number(0.9, 0, 1)
    """Share of the emitted light that a beam shaper puts into the field (assumed)."""
    room_light: float = number(0.01, 0, 1)
    """Share of the room's light that a filter of 3 nm passes (assumed; the paper has none)."""
    phases: int = number(16, 3, 1000)  # type: ignore[assignment]
    """Reference phases, an exposure each."""

    def __post_init__(self) -> None:
        check_fields(type(self), vars(self), "array")

    # --- angles ---------------------------------------------------------------------------------

    @property
    def frequency(self) -> float:
        """Of the modulation, Hz."""
        return FREQUENCY_SINGLE if self.mode == "single" else FREQUENCY_DOUBLED

    @property
    def way(self) -> float:
        """From the crystal's front to the mirror and back to the front, m, in air's angles."""
        inside = self.crystal.length / self.crystal.ordinary
        return 2 * (inside + self.twin.detection.mirror_distance)

    @property
    def acceptance(self) -> float:
        """Sine of the largest angle in the crystal's air: retardance, or the aperture's end."""
        by_retardance = self.crystal.acceptance(self.tolerance, self.twin.laser.wavelength)
        return min(by_retardance, self.side / self.way)

    @property
    def etendue(self) -> float:
        """``a^2 (2 s)^2``, m^2 sr."""
        return (2 * self.side * self.acceptance) ** 2

    @property
    def resolvable(self) -> float:
        """Points N that diffraction lets the crystal tell apart, étendue over wavelength^2."""
        return self.etendue / self.twin.laser.wavelength**2

    @property
    def pupil(self) -> float:
        """Side of the pupil towards the scene, m: ``D sin(theta_F) = a s``."""
        return self.side * self.acceptance / float(np.sin(self.half_field))

    def unvignetted(self, across: ArrayLike, along: ArrayLike) -> Array:
        """Share of the aperture that light at an angle (sines) finds open on both passes.

        Coming back from the mirror it has moved sideways by angle times `way`.
        """
        left = [1 - self.way / self.side * np.abs(np.asarray(s, float)) for s in (across, along)]
        return np.maximum(left[0], 0) * np.maximum(left[1], 0)

    def grid(self) -> tuple[Array, Array]:
        """Sines of the angle in the crystal's air, across and along the optic axis, (H, W) each."""
        s = (2 * (np.arange(self.pixels) + 0.5) / self.pixels - 1) * self.acceptance
        return tuple(np.meshgrid(s, s))  # type: ignore[return-value]

    def rays(self) -> Array:
        """Unit rays (H, W, 3) of the pixels: x right, y down, z ahead, evenly spaced tangents."""
        step = (2 * (np.arange(self.pixels) + 0.5) / self.pixels - 1) * np.tan(self.half_field)
        x, y = np.meshgrid(step, step)
        ray = np.stack([x, y, np.ones_like(x)], axis=-1)
        return ray / np.linalg.norm(ray, axis=-1, keepdims=True)

    # --- the gate over the field ----------------------------------------------------------------

    def gate(self, across: ArrayLike, along: ArrayLike) -> tuple[Array, Phasor]:
        r"""Mean W_0 and coefficient W_m of the detection module at an angle (sines).

        With a change Gamma of a pass's retardance and the drive phase delta between passes,
        ``V_1 + V_2 = 2 eta cos(delta/2) sin(theta + delta/2)`` and the closed forms of
        `cmtof.modulator` become

        .. math:: W_0 = \tfrac12(1 - J_0 \sin 2\Gamma),\;
                  W_1 = \tfrac{i}{2} J_1 \cos 2\Gamma\, e^{i\delta/2} \quad\text{(single)},
        .. math:: W_0 = \tfrac12(1 - J_0 \cos 2\Gamma),\;
                  W_2 = -\tfrac12 J_2 \cos 2\Gamma\, e^{i\delta} \quad\text{(doubled)}.

        The bias is set for light along the axis.
        """
        wavelength = self.twin.laser.wavelength
        change = self.crystal.retardance(across, along, wavelength) - float(
            self.crystal.retardance(0, 0, wavelength)
        )
        delta = self.pass_delay(across, along)
        swing = 2 * self.twin.drive.eta * np.cos(delta / 2)
        if self.mode == "single":
            mean = (1 - jv(0, swing) * np.sin(2 * change)) / 2
            return mean, 0.5j * jv(1, swing) * np.cos(2 * change) * np.exp(0.5j * delta)
        mean = (1 - jv(0, swing) * np.cos(2 * change)) / 2
        return mean, -0.5 * jv(2, swing) * np.cos(2 * change) * np.exp(1j * delta)

    def pass_delay(self, across: ArrayLike, along: ArrayLike) -> Array:
        """Drive phase by which the second pass comes late at an angle (sines), rad; 0 on axis.

        The way to the mirror and back, and that within the crystal, grow as ``1/cos``.
        """
        square = np.square(across) + np.square(along)
        outside = 1 / np.sqrt(1 - square) - 1
        inside = 1 / np.sqrt(1 - square / self.crystal.ordinary**2) - 1
        path = 2 * self.twin.detection.mirror_distance * outside
        path = path + self.crystal.length * self.crystal.group_index * inside
        drive = self.frequency if self.mode == "single" else self.frequency / 2
        return TAU * drive / SPEED_OF_LIGHT * path

    def field_error(self, across: ArrayLike, along: ArrayLike) -> Array:
        """Range, m, that the gate's phase adds at an angle unless it is calibrated."""
        on_axis = self.gate(0.0, 0.0)[1]
        # C = 2 Re p r* exp(-i(phi + psi)): a gate that is further on makes the light look late
        return depth_from_phase(np.angle(self.gate(across, along)[1] / on_axis), self.frequency)

    # --- light ----------------------------------------------------------------------------------

    @property
    def speckle_cells(self) -> float:
        """Modes of light in one pixel, ``1 + N_resolvable / N``: speckle contrast 1/sqrt."""
        return 1 + self.resolvable / self.pixels**2

    def electrons(
        self,
        ranges: ArrayLike,
        *,
        cosine: ArrayLike = 1.0,
        reflectance: ArrayLike = 0.5,
        across: ArrayLike = 0.0,
        along: ArrayLike = 0.0,
        ratio: ArrayLike = 1.0,
    ) -> Electrons:
        """Rates of a pixel that sees a diffuse surface.

        Parameters
        ----------
        ranges, cosine, reflectance : array_like, shape (...)
            m; cosine of incidence; 0 to 1.
        across, along : array_like, shape (...)
            Sines of the angle in the crystal's air.
        ratio : array_like, shape (...)
            All light over the direct light at the modulation's frequency, complex
            (`cmtof.ranging.multipath`). Its mean light is left at the direct one.
        """
        law, order = (
            (single_mode_harmonics, 1) if self.mode == "single" else (doubled_mode_harmonics, 2)
        )
        emitted = law(self.twin.drive.eta, 2)
        depth = 2 * abs(emitted[order]) / emitted[0].real
        mean, gate = self.gate(across, along)
        per_second = self._per_watt * self.unvignetted(across, along)
        light = per_second * self._collected(ranges, cosine, reflectance)
        room = per_second * self._room
        kept = mean * self.twin.detection.mirror_reflectance
        swing = np.abs(gate) * self.twin.detection.mirror_reflectance
        return Electrons(
            (light + room) * kept + self.sensor.dark_current,
            light * depth * swing * np.abs(np.asarray(ratio)),
        )

    @property
    def _per_watt(self) -> float:
        """Electrons/s for 1 W at the pupil, gate open."""
        photon = PLANCK * SPEED_OF_LIGHT / self.twin.laser.wavelength
        return self.sensor.efficiency / photon * free_space.inward(self.twin.optics)

    def _collected(self, ranges: ArrayLike, cosine: ArrayLike, reflectance: ArrayLike) -> Array:
        seen = (np.asarray(x, float) for x in (ranges, cosine, reflectance))
        hits = free_space.Hits(*np.broadcast_arrays(*seen))
        # rho cos A / (pi z^2), half of it in the right polarisation, for the square pupil's area
        share = free_space.returned_fraction(self.twin.optics, "diffuse", hits)
        area = self.pupil**2 / (np.pi * self.twin.optics.aperture**2 / 4)
        sent = sent_power(self.twin, self.mode) * self.brightness
        lit = sent * self.diffuser / self.pixels**2
        return lit * share * area

    @property
    def _room(self) -> float:
        """Room light of a pixel at the pupil, W, half of it in the right polarisation."""
        radiance = self.twin.optics.ambient_radiance * self.room_light
        return 0.5 * radiance * self.etendue / self.pixels**2

    # --- precision ------------------------------------------------------------------------------

    @property
    def psi(self) -> Array:
        """Reference phases (K,), rad."""
        return TAU * np.arange(self.phases) / self.phases

    def readings(self, rates: Electrons, time: float) -> int:
        """Readings of an exposure that keep the brightest pixel below the full well."""
        crest = float(np.max(rates.mean + rates.amplitude)) * time / self.phases
        return max(1, int(np.ceil(crest / self.sensor.full_well)))

    def bound(self, rates: Electrons, time: float, *, phase: ArrayLike = 0.0) -> Array:
        """Cramer-Rao bound of the range, m, of a frame that takes ``time``, s, all phases."""
        share = time / self.phases
        sigma = self.sensor.noise * np.sqrt(self.readings(rates, time))
        return bounds.depth_bound(
            rates.amplitude * share, rates.mean * share, self.psi, sigma=float(sigma),
            phase=phase, frequency=self.frequency,
        )  # fmt: skip

    def time_for(self, rates: Electrons, noise: ArrayLike) -> Array:
        r"""Time of a frame, s, whose phase noise is ``noise``, rad, one reading a phase.

        ``noise^2 = (2/K) (m t + r^2) / (a t)^2`` solved for the exposure t of one of K phases.
        """
        square = self.phases * np.square(np.asarray(noise) * rates.amplitude)
        root = np.sqrt(rates.mean**2 + 2 * square * self.sensor.noise**2)
        return self.phases * (rates.mean + root) / square

    def frames(
        self,
        ranges: ArrayLike,
        *,
        cosine: ArrayLike = 1.0,
        reflectance: ArrayLike = 0.5,
        ratio: ArrayLike = 1.0,
        time: float = 1.0,
        repeats: int = 1,
        seed: int = 0,
        speckle: bool = True,
    ) -> Frame:
        """Expose and decode frames of a diffuse scene, (H, W) pixels as `rays` has them.

        The phase over the field is calibrated by the foretold one; the wrap is taken as known.

        Parameters
        ----------
        ranges, cosine, reflectance, ratio
            As of `electrons`, shape (H, W).
        time : float
            Of a frame, s.
        repeats, seed : int
            Each repeat has its own speckle and noise.
        speckle : bool
        """
        z = np.asarray(ranges, float)
        if z.shape != (self.pixels, self.pixels):
            raise ValueError(
                f"Expected ranges of {self.pixels} x {self.pixels} pixels, got {z.shape}. "
                "Trace the rays of this array."
            )
        rng = np.random.default_rng(seed)
        across, along = self.grid()
        cells = self.speckle_cells
        grain = rng.gamma(cells, 1 / cells, (repeats, *z.shape)) if speckle else np.ones((1, 1, 1))
        rates = self.electrons(
            z, cosine=cosine, reflectance=np.asarray(reflectance) * grain,
            across=across, along=along, ratio=ratio,
        )  # fmt: skip
        rates = Electrons(*(np.broadcast_to(r, (repeats, *z.shape)) for r in rates))
        true = phase_from_depth(z, self.frequency)
        offset = phase_from_depth(self.field_error(across, along), self.frequency)
        seen = true - np.angle(np.asarray(ratio)) + offset
        share = time / self.phases
        mean = correlation_from_phase(
            np.broadcast_to(seen, rates.mean.shape), self.psi,
            amplitude=share * rates.amplitude, offset=share * rates.mean,
        )  # fmt: skip
        sigma = self.sensor.noise * np.sqrt(self.readings(rates, time))
        counts = poisson_gaussian(mean, rng=rng, sigma=float(sigma))
        # flat, because four axes would be read as frequency, step, y, x
        found = decode(counts.reshape(self.phases, -1), self.psi).phase.reshape(rates.mean.shape)
        phase = wrapped(found - offset)
        error = depth_from_phase(centred(phase - true), self.frequency)
        bound = self.bound(rates, time, phase=seen)
        return Frame(phase, error, bound, share * rates.mean)
