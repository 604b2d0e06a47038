r"""A 100 MHz multi-bucket camera: flood light, two taps a pixel, four phase steps (Fig. 15).

With the phasors F of the light in a pixel (`cmtof.ranging.mhz_light`), its taps of a step psi hold

.. math:: A, B = \tfrac12 (S \pm D_\psi),\qquad
          D_\psi = 2\,\mathrm{Re}\sum_h P_h R_h^*\, F_h\, e^{-ih\psi},

with the emitter's harmonics P (mean 1), those R of gate A less gate B, and all charge S of both.
The camera reads A - B; its noise is Skellam's (Poisson of both) and the amplifier's.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.bounds import linear_phase_noise
from cmtof.correlation import (
    TAU,
    centred,
    correlation_contrast,
    cyclic_error,
    decode,
    depth_from_phase,
    phase_from_depth,
    wrap_length,
    wrapped,
)
from cmtof.detector import quantise, skellam_gaussian
from cmtof.ranging.mhz_light import ORDERS, Light, View, ambient, light_of, signal
from cmtof.ranging.mhz_settings import STEPS, CameraSettings
from cmtof.waveform import Harmonics, gate, low_pass_harmonics

Array = NDArray[np.floating]
Complex = NDArray[np.complexfloating]

PSI = TAU * np.arange(STEPS) / STEPS
"""Reference phases of the four steps, rad."""

_TABLE = 1024  # phases of the wiggling table


class Depth(NamedTuple):
    """What the camera tells of each pixel, arrays (..., H, W)."""

    range: Array
    """m within one wrap; NaN where the signal is too weak or a tap is full."""
    phase: Array
    """Corrected phase in [0, 2 pi), rad; of every pixel."""
    amplitude: Array
    """Coefficient of the cosine, electrons."""


class MhzCamera:
    """One camera: its fixed pattern depends on the seed, its noise on each capture's generator.

    Parameters
    ----------
    settings : CameraSettings
    seed : int
        Of the fixed pattern of phase offsets.

    Examples
    --------
    >>> camera = MhzCamera()
    >>> wall = View(*(np.full((2, 2), x) for x in (1.0, 1.0, 0.5)))
    >>> print(f"{camera.bound(wall)[0, 0] * 1e3:.0f} mm")
    31 mm
    """

    def __init__(self, settings: CameraSettings | None = None, *, seed: int = 0) -> None:
        self.settings = CameraSettings() if settings is None else settings
        self.seed = int(seed)

    # --- waveforms

    @property
    def emitted(self) -> Harmonics:
        """Harmonics of the light, mean 1: a square wave behind one pole."""
        square = gate(int(ORDERS[-1])) / 0.5
        s = self.settings
        return low_pass_harmonics(square, frequency=s.frequency, cutoff=s.emitter_bandwidth)

    @property
    def gates(self) -> Harmonics:
        """Harmonics of gate A less gate B, between -1 and 1: no mean, no even orders."""
        s = self.settings
        difference = 2 * s.contrast * gate(int(ORDERS[-1]))
        difference[::2] = 0
        return low_pass_harmonics(difference, frequency=s.frequency, cutoff=s.gate_bandwidth)

    @property
    def modulation(self) -> float:
        """Amplitude of A - B over the signal's charge in both: ``2 |P_1 R_1|``."""
        both = self.gates
        both[0] = 1  # A + B is always open
        return correlation_contrast(self.emitted, both)

    @property
    def lag(self) -> float:
        """Constant phase that the poles add, rad; calibration takes it away."""
        return float(-np.angle(self.emitted[1] * np.conj(self.gates[1])))

    def wiggling(self, phase: ArrayLike) -> Array:
        """Cyclic error of four steps at true phases, rad: the third and fifth harmonic."""
        return cyclic_error(self.emitted, self.gates, phase=phase, samples=STEPS)

    # --- forward: view -> charge -> difference images

    def light(self, view: View, *, rays: int = 1, field: View | None = None) -> Light:
        """Charge that reaches each pixel by all ways; see `cmtof.ranging.mhz_light.light_of`."""
        return light_of(self.settings, view, rays=rays, field=field)

    def differences(self, light: Light) -> Array:
        """Mean of A - B in each step, electrons, (4, H, W); what full taps lose included."""
        a, b = self._taps(light)
        return a - b

    def capture(self, light: Light, *, rng: np.random.Generator, repeats: int = 1) -> Array:
        """Difference images (repeats, 4, H, W), electrons, with noise and the converter's steps."""
        a, b = self._taps(light)
        s, shape = self.settings, (repeats, *a.shape)
        noisy = skellam_gaussian(
            np.broadcast_to(a, shape), np.broadcast_to(b, shape), rng=rng, sigma=s.read_noise
        )
        end = s.full_scale
        return quantise(noisy + end, bits=s.bits, full_scale=2 * end) - end

    # --- inverse: difference images -> range

    def estimate(self, differences: ArrayLike, full: NDArray[np.bool_] | bool = False) -> Depth:
        """Range of difference images (..., 4, H, W), electrons.

        Decoded as every correlation here; then lag, most of the cyclic error and most of the fixed
        pattern come off, as far as the maker calibrated them.

        Parameters
        ----------
        differences : array_like, shape (..., 4, H, W)
        full : ndarray of bool, shape (H, W)
            Pixels that `saturated`: the camera knows them by the sum of its taps.
        """
        s = self.settings
        images = np.moveaxis(np.asarray(differences, float), -3, 0)
        found = decode(images.reshape(STEPS, -1), PSI)
        shape = images.shape[1:]
        phase = centred(found.phase.reshape(shape) - self.lag)
        # in the reverse order in which they came: a pixel's offset moves it along the wiggling
        phase = phase - (1 - s.wiggling_left) * self._wiggling_table(phase)
        phase = wrapped(phase - (1 - s.pattern_left) * self._pattern(shape[-2:]))
        amplitude = found.amplitude.reshape(shape)
        good = (amplitude > self.least_amplitude) & ~np.asarray(full)
        return Depth(np.where(good, depth_from_phase(phase, s.frequency), np.nan), phase, amplitude)

    def saturated(self, light: Light) -> NDArray[np.bool_]:
        """Pixels (H, W) where a tap is full or the converter at its end in any step."""
        half = light.phasors[0].real + light.ambient
        swing = self._swing(light.phasors)
        full = (half + np.abs(swing)).max(0) / 2 >= self.settings.full_well
        return full | (np.abs(swing).max(0) >= self.settings.full_scale)

    def bound(self, view: View) -> Array:
        r"""Least standard deviation of a pixel's range from noise alone, m, (H, W).

        A difference has the variance ``v = S + sigma^2`` in every step: Skellam, amplifier and
        rounding. Four of them hold one phasor ``N g(phi)``, whose angle m(phi) = phi + wiggling
        runs unevenly, so the Cramer-Rao bound of phase and amplitude is

        .. math:: \sigma_\phi = \sqrt{v/2}\,/\,(N |g|\,m'),\qquad m' = \mathrm{Im}(g'/g),

        for the pixel's own light. (That v, too, tells about N adds less than 1 %.)
        """
        own = signal(self.settings, view)
        noise = self._noise(own + ambient(self.settings, view))
        phase = phase_from_depth(np.nan_to_num(view.range), self.settings.frequency)
        g, slope = self._response(phase)
        with np.errstate(divide="ignore"):
            spread = linear_phase_noise(np.abs(g) * own, noise**2, STEPS) / (slope / g).imag
        return depth_from_phase(spread, self.settings.frequency)

    def error(self, depth: Depth, truth: ArrayLike) -> Array:
        """Range less truth, m, modulo the wrap: what the camera gets wrong, wraps apart."""
        frequency = self.settings.frequency
        off = centred(phase_from_depth(depth.range - np.asarray(truth), frequency))
        return np.where(np.isfinite(depth.range), depth_from_phase(off, frequency), np.nan)

    @property
    def least_amplitude(self) -> float:
        """Amplitude, electrons, below which no range is shown: `confidence` times dark noise."""
        return self.settings.confidence * float(self._noise(0.0)) * float(np.sqrt(2 / STEPS))

    @property
    def wrap(self) -> float:
        """Range after which its answers repeat themselves, m."""
        return float(wrap_length(self.settings.frequency))

    # --- parts

    def _response(self, phase: Array) -> tuple[Complex, Complex]:
        """Decoded phasor ``g`` of one electron at true phases, and its derivative, 1/rad.

        ``D = Re sum q_h exp(-i h (phi + psi))``: in four steps order 3 looks like -1, 5 like 1.
        """
        g, slope = np.zeros((2, *phase.shape), complex)
        product = 2 * self.emitted * np.conj(self.gates)
        for order in ORDERS[1:]:
            sign = 1 if order % STEPS == 1 else -1
            weight = np.conj(product[order]) if sign == 1 else product[order]
            term = weight * np.exp(1j * sign * order * phase)
            g, slope = g + term, slope + 1j * sign * order * term
        return g, slope

    def _swing(self, phasors: Complex) -> Array:
        """A - B of a linear pixel in each step, (4, H, W), electrons."""
        product = (2 * self.emitted * np.conj(self.gates))[ORDERS]
        turned = product[:, None] * np.exp(-1j * np.multiply.outer(ORDERS, PSI))
        return np.einsum("hk,h...->k...", turned, phasors).real

    def _taps(self, light: Light) -> tuple[Array, Array]:
        """Mean charge of both taps (4, H, W), electrons, as a real pixel tells it."""
        s = self.settings
        total = light.phasors[0].real + light.ambient
        late = TAU * s.frequency * s.delay * np.minimum(total / 2 / s.full_well, 1)
        late = late + self._pattern(total.shape)
        swing = self._swing(light.phasors * np.exp(-1j * ORDERS[:, None, None] * late))
        a, b = (np.minimum((total + sign * swing) / 2, s.full_well) for sign in (1, -1))
        return (
            a - s.nonlinearity * a**2 / s.full_well,
            b - s.nonlinearity * b**2 / s.full_well,
        )

    def _pattern(self, shape: tuple[int, ...]) -> Array:
        """Fixed phase offset of each pixel, rad."""
        rng = np.random.default_rng([self.seed, 556])
        return self.settings.pattern * rng.standard_normal(shape)

    def _wiggling_table(self, phase: Array) -> Array:
        """Cyclic error at measured phases, rad: the table measured against true, turned about."""
        true = TAU * np.arange(-8, _TABLE + 8) / _TABLE
        error = self.wiggling(true)
        return np.interp(wrapped(phase), true + error, error)

    def _noise(self, charge: ArrayLike) -> Array:
        """Standard deviation of A - B, electrons: Skellam, amplifier, rounding."""
        s = self.settings
        step = 2 * s.full_scale / (2**s.bits - 1)
        return np.sqrt(np.asarray(charge) + s.read_noise**2 + step**2 / 12)
