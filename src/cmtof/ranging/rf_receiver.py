r"""RF demodulation after photo-conversion (Sec. 7.4): forward model, estimator and bound.

Light of mean power P whose fundamental has the depth m makes a current of amplitude R m H P; into
the load R_L it is a voltage whose complex envelope, at the amplifier's input, is

.. math:: V = R_L\,R\,m\,|H(f)|\,P\,e^{i\phi}, \qquad H = 1/(1 + i f/f_c)

The detector's lag is constant and left out. Amplifier, band-pass and mixer multiply it by a gain g,
add noise and offsets, and skew I against Q. Averaged over T each quadrature of the envelope has

.. math:: \sigma_V^2 = \frac{k_B T_0 F R_L + 2e\,(R P + I_d)\,R_L^2}{T}

(one-sided densities; mixing down doubles them, averaging leaves 1/2T of it). The electrical signal
goes with P squared. While thermal noise rules so does the signal-to-noise ratio; only beyond the
power at which shot noise takes over it goes with P.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import wrapped
from cmtof.instrument.electronics import ELEMENTARY_CHARGE, RANGES, slope
from cmtof.ranging.rf_settings import RfParts

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

BOLTZMANN = 1.380649e-23
"""J/K (exact, SI)."""


class Imbalance(NamedTuple):
    r"""Skew of an I/Q mixer: ``alpha z + beta conj(z)``.

    I = Re z and Q = g times Re of z turned by -90 degrees and the error e:
    :math:`\alpha = (1 + g e^{ie})/2,\ \beta = (1 - g e^{-ie})/2`.
    """

    alpha: Complex
    beta: Complex

    @classmethod
    def of(cls, gain: ArrayLike, error: ArrayLike) -> "Imbalance":
        """Skew of an amplitude ratio (...), 1 for none, and a phase error (...), rad."""
        ratio, angle = np.asarray(gain, complex), np.asarray(error, float)
        turned = np.asarray(ratio * np.exp(1j * angle), complex)
        pair = np.stack([1 + turned, 1 - np.conj(turned)]).astype(complex) / 2
        return cls(pair[0], pair[1])

    @property
    def rejection(self) -> Array:
        """Image rejection, a ratio of powers: ``|alpha / beta|^2``."""
        with np.errstate(divide="ignore"):
            return np.abs(self.alpha) ** 2 / np.abs(self.beta) ** 2

    def skew(self, phasor: ArrayLike) -> Complex:
        """Return what the mixer makes of true phasors."""
        z = np.asarray(phasor, complex)
        return self.alpha * z + self.beta * np.conj(z)

    def straighten(self, phasor: ArrayLike) -> Complex:
        """Return the true phasors: the inverse of `skew`."""
        z = np.asarray(phasor, complex)
        size = np.abs(self.alpha) ** 2 - np.abs(self.beta) ** 2
        return (np.conj(self.alpha) * z - self.beta * np.conj(z)) / size


STRAIGHT = Imbalance.of(1.0, 0.0)
"""No imbalance."""


class Reading(NamedTuple):
    """What an estimator makes of a phasor."""

    phase: NDArray[np.floating]
    """Wrapped phase in [0, 2 pi), rad."""
    amplitude: Array
    """Envelope at the converter, V."""


@dataclass(frozen=True)
class RfReceiver:
    """The circuit from the light on the photodiode to two averaged voltages.

    Powers are those *on the photodiode*. All arrays broadcast; ``modulation`` is the amplitude of
    the light's fundamental over its mean, ``frequency`` in Hz.

    Parameters
    ----------
    parts : RfParts

    Examples
    --------
    Electrical power goes with the square of the light:

    >>> receiver = RfReceiver()
    >>> weak, strong = receiver.snr([1e-9, 1e-8])
    >>> round(float(strong / weak))
    100
    """

    parts: RfParts = field(default_factory=RfParts)

    # --- gains ---------------------------------------------------------------------------------

    @property
    def gain(self) -> float:
        """Volts at the converter per volt of envelope at the amplifier's input."""
        amplifier, mixer = self.parts.amplifier, self.parts.mixer
        decibel = amplifier.gain - amplifier.filter_loss - mixer.conversion_loss
        return self.parts.baseband.gain * 10 ** (decibel / 20)

    @property
    def noise_factor(self) -> float:
        """Noise factor F of amplifier, filter and mixer (Friis 1944)."""
        amplifier, mixer = self.parts.amplifier, self.parts.mixer
        first, lossy = _ratio(amplifier.noise_figure), _ratio(amplifier.filter_loss)
        behind = lossy * _ratio(mixer.noise_figure) - 1
        return first + behind / _ratio(amplifier.gain)

    @property
    def imbalance(self) -> Imbalance:
        """The mixer's own skew."""
        mixer = self.parts.mixer
        return Imbalance.of(10 ** (mixer.amplitude_imbalance / 20), mixer.phase_imbalance)

    def offsets(self) -> tuple[float, float]:
        """Amplitudes of self-mixing and of pick-up, as envelopes at the amplifier's input, V."""
        amplifier, mixer, pickup = self.parts.amplifier, self.parts.mixer, self.parts.pickup
        mixed = mixer.lo_power - mixer.lo_isolation - amplifier.return_loss
        ahead = amplifier.gain - amplifier.filter_loss
        return self.volts(mixed - ahead), self.volts(pickup.drive_power - pickup.isolation)

    def volts(self, level: float) -> float:
        """Amplitude, V, of a level in the load, dBm."""
        return float(np.sqrt(2 * self.parts.photodiode.load * 1e-3 * 10 ** (level / 10)))

    def level(self, amplitude: ArrayLike) -> Array:
        """Level in the load, dBm, of an amplitude, V: the inverse of `volts`."""
        power = np.asarray(amplitude, float) ** 2 / (2 * self.parts.photodiode.load)
        with np.errstate(divide="ignore"):
            return 10 * np.log10(power / 1e-3)

    # --- forward -------------------------------------------------------------------------------

    def envelope(
        self,
        power: ArrayLike,
        modulation: ArrayLike = 1.0,
        phase: ArrayLike = 0.0,
        *,
        frequency: float = FREQUENCY_SINGLE,
    ) -> Complex:
        """Complex envelope at the amplifier's input, V, of light (...), W."""
        diode = self.parts.photodiode
        response = 1 / np.hypot(1, frequency / diode.bandwidth)
        size = diode.load * diode.responsivity * response
        turn = np.exp(1j * np.asarray(phase, float))
        return size * np.asarray(power, float) * np.asarray(modulation, float) * turn

    def noise(self, power: ArrayLike, *, time: float | None = None) -> Array:
        """Noise of one quadrature of the averaged envelope, V rms: thermal and shot noise."""
        diode, amplifier = self.parts.photodiode, self.parts.amplifier
        thermal = BOLTZMANN * amplifier.temperature * self.noise_factor * diode.load
        current = diode.responsivity * np.asarray(power, float) + diode.dark_current
        shot = 2 * ELEMENTARY_CHARGE * current * diode.load**2
        return np.sqrt((thermal + shot) / self._time(time))

    def converter_noise(self, volts: ArrayLike, *, time: float | None = None) -> Array:
        """Noise that amplifier and converter add to one averaged quadrature, V rms.

        ``volts`` (...) is what the converter would have to take at the full gain. The gain is
        turned down until a quarter more than that fits; all is referred to the full gain again.
        """
        base = self.parts.baseband
        full = np.maximum(base.least_range, 1.25 * np.asarray(volts, float))
        step = slope(RANGES[0]) / RANGES[0] * full
        white = (base.gain * base.noise_density) ** 2 / 2 + step**2 * (
            base.converter_noise**2 + 1 / 12
        ) / base.rate
        return np.sqrt(white / self._time(time))

    def phasor(
        self,
        power: ArrayLike,
        modulation: ArrayLike = 1.0,
        phase: ArrayLike = 0.0,
        *,
        frequency: float = FREQUENCY_SINGLE,
        offset: ArrayLike = 0.0,
        imbalance: Imbalance = STRAIGHT,
        time: float | None = None,
        rng: np.random.Generator | None = None,
    ) -> Complex:
        """Averaged I + iQ at the converter, V, at the full gain.

        Parameters
        ----------
        power : array_like, shape (...)
            Mean light on the photodiode, W.
        modulation, phase : array_like, shape (...)
            Amplitude of the fundamental over the mean, and its phase, rad.
        frequency : float
            Of the modulation, Hz.
        offset : array_like of complex, shape (...)
            Envelope at the amplifier's input that is no light, V.
        imbalance : Imbalance
            Skew of the mixer; none by default.
        time : float, optional
            Integration, s; by default that of the circuit.
        rng : Generator, optional
            Without one there is no noise.

        Returns
        -------
        ndarray of complex, shape (...)
        """
        signal = self.envelope(power, modulation, phase, frequency=frequency) + np.asarray(offset)
        if rng is None:
            return self.gain * imbalance.skew(signal)
        shape = np.broadcast_shapes(np.shape(signal), np.shape(imbalance.alpha))
        noisy = signal + self.noise(power, time=time) * _normals(rng, shape)
        # the mixer skews what comes before it, noise included; the converter's own comes after
        late = self.converter_noise(self.gain * np.abs(signal), time=time)
        return self.gain * imbalance.skew(noisy) + late * _normals(rng, shape)

    # --- inverse -------------------------------------------------------------------------------

    @staticmethod
    def estimate(
        reading: ArrayLike, *, offset: ArrayLike = 0.0, imbalance: Imbalance = STRAIGHT
    ) -> Reading:
        """Phase and amplitude of phasors (...), V, less a calibrated offset, V, and imbalance."""
        true = imbalance.straighten(np.asarray(reading, complex) - np.asarray(offset))
        return Reading(wrapped(np.angle(true)), np.abs(true))

    # --- bound ---------------------------------------------------------------------------------

    def snr(
        self,
        power: ArrayLike,
        modulation: ArrayLike = 1.0,
        *,
        frequency: float = FREQUENCY_SINGLE,
        offset: ArrayLike = 0.0,
        time: float | None = None,
    ) -> Array:
        """Signal over noise, a ratio of electrical powers, after averaging: ``|V|^2 / 2 sigma^2``.

        The offset does not count as signal; it only makes the converter take a wider range.
        """
        signal = np.abs(self.envelope(power, modulation, frequency=frequency))
        late = self.converter_noise(self.gain * (signal + np.abs(offset)), time=time) / self.gain
        return signal**2 / (2 * (self.noise(power, time=time) ** 2 + late**2))

    def phase_bound(
        self,
        power: ArrayLike,
        modulation: ArrayLike = 1.0,
        *,
        frequency: float = FREQUENCY_SINGLE,
        offset: ArrayLike = 0.0,
        time: float | None = None,
    ) -> Array:
        """Cramer-Rao bound on the phase, rad: ``sigma / |V| = 1 / sqrt(2 SNR)``."""
        ratio = self.snr(power, modulation, frequency=frequency, offset=offset, time=time)
        with np.errstate(divide="ignore"):
            return 1 / np.sqrt(2 * ratio)

    def shot_noise_power(self) -> float:
        """Light, W, whose shot noise equals the thermal noise: beyond it SNR goes with P."""
        diode, amplifier = self.parts.photodiode, self.parts.amplifier
        thermal = BOLTZMANN * amplifier.temperature * self.noise_factor
        current = thermal / (2 * ELEMENTARY_CHARGE * diode.load) - diode.dark_current
        return current / diode.responsivity

    def _time(self, time: float | None) -> float:
        chosen = self.parts.baseband.time if time is None else float(time)
        if not chosen > 0:
            raise ValueError(
                f"Expected an integration time above 0 s, got {chosen:g}. Give it in seconds."
            )
        return chosen


def _ratio(decibel: float) -> float:
    """Ratio of powers."""
    return float(10 ** (decibel / 10))


def _normals(rng: np.random.Generator, shape: tuple[int, ...]) -> Complex:
    """Two independent standard normals as a complex number."""
    return rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
