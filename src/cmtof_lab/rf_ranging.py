r"""RF demodulation after photo-conversion (Sec. 7.4): circuit, bound, sweep, and image of a scan.

Light of mean power P whose fundamental has the depth m makes a voltage with the complex envelope V
in the load R_L; averaged over T each of its quadratures has the noise sigma,

.. math:: V = R_L\,R\,m\,|H(f)|\,P\,e^{i\phi}, \qquad
          \sigma^2 = \frac{k_B T_0 F R_L + 2e\,(R P + I_d)\,R_L^2 + e_n^2/2g^2}{T}, \qquad
          \mathrm{SNR} = \frac{|V|^2}{2\sigma^2} = \frac{1}{2\sigma_\phi^2}

with H = 1/(1 + i f/f_c) and the noise e_n of the amplifier behind the mixer, a gain g later.
"""

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator, default_rng
from numpy.typing import ArrayLike
from scipy.constants import Boltzmann, elementary_charge

from cmtof.correlation import centred, phase_from_depth, wrapped
from cmtof.hardware.ranging import correct_quadratures
from cmtof.hardware.rig import MODES, SAMPLE_RATE
from cmtof.types import Array, Complex
from cmtof_lab.instrument import DRIFT_RMS, drift
from cmtof_lab.optics import (
    emission_harmonics,
    inward,
    sent_power,
    speckle_cells,
    spot_radius,
    trace,
)
from cmtof_lab.sweep import (
    PhaseRanger,
    circular_normals,
    collected_power,
    zero_positions,
)
from cmtof_lab.targets import Plane, Target


@dataclass(frozen=True, kw_only=True)
class RfRanger(PhaseRanger):
    """RF demodulation with laser, emission and optics of the all-optical instrument.

    The paper names the photodiode only, the rest are catalogue parts (*known*, *assumed*: as in
    `cmtof_lab.settings`). The offset is read with the beam blocked, and the imbalance from a
    sweep of the phase, ``age`` before. These and each visit for the zero average ``points``.
    """

    # Offset and imbalance are taken away; the zero is set in any case
    calibrated: bool = True
    points: int = 100

    # s for a point, that of the all-optical instrument (Sec. 7.2)
    time: float = 320 / SAMPLE_RATE
    # A/W, photodiode ET-4000 at 532 nm (assumed: efficiency 0.47)
    responsivity: float = 0.2
    bandwidth: float = 12e9  # Hz, first order (Sec. 7.4)
    dark_current: float = 0.5e-9  # A (known)
    diameter: float = 60e-6  # m (known): the whole image of the spot does not fit on it
    reference_diameter: float = 1e-3  # m, APD440A, which sees the optics' field_of_view
    load: float = 50.0  # Ohm
    amplifier_gain: float = 26.0  # dB (known, the class of a Mini-Circuits ZVA-183+)
    noise_figure: float = 3.0  # dB (known)
    filter_loss: float = 1.5  # dB, band-pass (assumed)
    return_loss: float = 10.0  # dB, of both together as the mixer sees them (assumed)
    # dB, I/Q mixer HMC8193 (data sheet Rev. B), as the next four
    conversion_loss: float = 9.0
    mixer_noise_figure: float = 11.5  # dB
    amplitude_imbalance: float = 0.5  # dB, Q over I
    phase_imbalance: float = 0.08726646  # rad, 5 degrees
    lo_isolation: float = 48.0  # dB; what passes is thrown back and mixes with itself
    lo_power: float = 18.0  # dBm (known for this class)
    # V/sqrt(Hz), of the amplifier behind the mixer (assumed)
    noise_density: float = 5e-9
    baseband_gain: float = 1000.0  # of that amplifier (assumed)
    drive_power: float = 30.0  # dBm, of the crystal (assumed)
    # dB, from that drive into the photodiode's cable (assumed)
    isolation: float = 100.0
    # Of offsets and imbalances since the calibration, relative, rms (assumed)
    drift: float = 1e-3

    @property
    def noise_factor(self) -> float:
        """Noise factor F of amplifier, filter and mixer (Friis 1944)."""
        behind = 10 ** ((self.filter_loss + self.mixer_noise_figure) / 10) - 1
        return 10 ** (self.noise_figure / 10) + behind / 10 ** (
            self.amplifier_gain / 10
        )

    @property
    def gain_ahead(self) -> float:
        """Gain of power from the load to behind the mixer."""
        return 10 ** (
            (self.amplifier_gain - self.filter_loss - self.conversion_loss) / 10
        )

    @property
    def imbalance(self) -> Array:
        """Gain of Q over I, and error of the phase between them, rad."""
        return np.array([10 ** (self.amplitude_imbalance / 20), self.phase_imbalance])

    def output(self, envelopes: Complex) -> Complex:
        """Voltages I + iQ, V, behind mixer and amplifiers, for envelopes, V, at their input."""
        gain = np.sqrt(self.gain_ahead) * self.baseband_gain
        return gain * skew_quadratures(envelopes, *self.imbalance)

    @property
    def sent_light(self) -> float:
        """Mean power sent to the scene, W, times the transmission from aperture to detector."""
        return sent_power(self.settings, self.mode) * inward(self.settings)

    @property
    def offsets(self) -> Array:
        """Envelopes (2,), V, of self-mixing and of the drive's pick-up, without any light."""
        sent_back = self.lo_power - self.lo_isolation - self.return_loss
        leaked = sent_back - (self.amplifier_gain - self.filter_loss)
        level = np.array([leaked, self.drive_power - self.isolation])  # dBm
        return np.sqrt(2 * self.load * 1e-3 * 10 ** (level / 10))

    def envelope(self, power: ArrayLike) -> Array:
        """Size of the envelope, V, of light (...), W."""
        wave = emission_harmonics(self.settings, self.mode)
        depth = 2 * abs(wave[MODES[self.mode]]) / wave[0].real
        response = self.responsivity / np.hypot(1, self.frequency / self.bandwidth)
        return np.multiply(self.load * response * depth, power)

    def noise(self, power: ArrayLike) -> Array:
        """Noise of one quadrature averaged over ``time``, V rms: light (...), W, and circuit."""
        current = np.multiply(self.responsivity, power) + self.dark_current
        shot = 2 * elementary_charge * current * self.load**2
        thermal = Boltzmann * 290.0 * self.noise_factor * self.load
        behind = self.noise_density**2 / (2 * self.gain_ahead)
        return np.sqrt((shot + thermal + behind) / self.time)

    def snr(self, power: ArrayLike) -> Array:
        """Signal over noise of light (...), W, a ratio of electrical powers."""
        return self.envelope(power) ** 2 / (2 * self.noise(power) ** 2)

    def seen_share(self, ranges: ArrayLike) -> Array:
        """Share of a diffuse target's light on the small photodiode: a Gaussian image w/z wide."""
        half = self.settings.field_of_view / 2 * self.diameter / self.reference_diameter
        with np.errstate(divide="ignore"):
            edge = half * np.divide(ranges, spot_radius(self.settings, ranges))
        return 1 - np.exp(-2 * edge**2)

    def power(self, target: Plane, ranges: ArrayLike) -> Array:
        """Mean light on the photodiode, W; a mirror's beam is focused to a point (assumed)."""
        whole = collected_power(self.settings, target, ranges, self.mode)
        return whole * (1.0 if target.mirrored else self.seen_share(ranges))

    def phase(self, ranges: ArrayLike) -> Array:
        """Phase, rad, of ranges in air, m."""
        return phase_from_depth(
            np.multiply(self.settings.group_index, ranges), self.frequency
        )

    def phasor(self, light: Array, ranges: ArrayLike, turn: ArrayLike = 0.0) -> Complex:
        """Envelope, V, of light, W, from ranges, m, its phase turned by ``turn``, rad."""
        return self.envelope(light) * np.exp(1j * (self.phase(ranges) + turn))  # pyright: ignore[reportOperatorIssue, reportReturnType]

    def day(self, target: Plane, positions: Array, rng: Generator) -> Array:
        """Estimated ranges (P,), m, of one sweep."""
        count = self.visits
        ranges = target.distance + np.append(zero_positions(count), positions)
        turned = self.readings(target, ranges, rng) * np.exp(-1j * self.phase(ranges))
        off = centred(np.angle(turned[count:] / turned[:count].sum()))
        return ranges[count:] + off / self.phase(1.0)

    def bound(self, target: Plane, positions: ArrayLike) -> Array:
        """Cramer-Rao bound (P,), m: noise of one reading at the mean light, nothing else."""
        light = self.power(target, np.add(target.distance, positions))
        return self.noise(light) / self.envelope(light) / self.phase(1.0)

    def readings(self, target: Plane, ranges: Array, rng: Generator) -> Complex:
        """One day's envelopes (P,), V, at ranges (P,), m, the first ones those of the zero."""
        # the last reading is that of the blocked beam
        times = np.append(self.times(ranges.size - self.visits), 0.0)
        # the zero and the blocked beam are averaged over many points
        quieter = np.ones(times.size)
        quieter[: self.visits] = quieter[-1] = np.sqrt(self.points)
        key = int(rng.integers(2**62))
        # both parts of the offset, the phase, and the fibre
        slow = [drift(key, channel, times) / DRIFT_RMS for channel in range(4)]
        constant = self.offsets @ np.exp(2j * np.pi * rng.random(2))
        constant = constant * (1 + self.drift * (slow[0] + 1j * slow[1]))
        place = ranges + self.stage_error * rng.standard_normal(ranges.size)
        light = np.append(self._received_light(target, ranges, rng), 0.0)
        noise = self.settings.phase_noise[MODES[self.mode] - 1] / quieter
        turn = noise * rng.standard_normal(times.size)
        turn += self.settings.phase_drift * slow[2]
        seen = self.phasor(light, np.append(place, 0.0), turn)
        seen += self.phasor(
            self.sent_light * self.settings.back_fraction * (times > 0),
            self.settings.back_range,
            turn,
        )
        noise = self.noise(light) / quieter * circular_normals(rng, times.size)
        return self._read(constant + self._fibre(slow[3]) * seen + noise, rng)

    def _read(self, envelopes: Complex, rng: Generator) -> Complex:
        """Readings (P,) of envelopes (P + 1,), V, of which the last is the blocked beam's."""
        known = self.imbalance
        read = skew_quadratures(
            envelopes[:-1], *(known + self.drift * rng.standard_normal(2))
        )
        if not self.calibrated:
            return read
        # the blocked beam is read, and the imbalance known, before they drift
        return correct_quadratures(
            read - skew_quadratures(envelopes[-1], *known), *known
        )

    def _received_light(self, target: Plane, ranges: Array, rng: Generator) -> Array:
        """Light on the photodiode, W, with the speckle of a rough target."""
        light = self.power(target, ranges)
        if not self.settings.speckle or target.mirrored:
            return light
        cells = speckle_cells(self.settings, ranges)
        return light * rng.gamma(cells, 1 / cells)

    def _fibre(self, drifted: Array) -> Array:
        """Transmission of the fibre over its mean."""
        swing = self.settings.fibre_high - self.settings.fibre_low
        return 1 + swing / (2 * self.settings.fibre) * DRIFT_RMS * drifted


def skew_quadratures(phasor: Complex, gain: float, error: float) -> Complex:
    """Reading of an I/Q mixer whose Q is ``gain`` too large and ``error``, rad, off 90 degrees."""
    turned = phasor * np.exp(1j * error)
    return phasor.real + 1j * gain * turned.imag


def rf_image(ranger: RfRanger, target: Target, angles: Array, *, seed: int) -> Array:
    """Wrapped phase (...), rad, by RF demodulation at optical angles (..., 2), rad; noise alone."""
    paths = trace(target, angles.reshape(-1, 2), ranger.settings, seed)
    power = (
        ranger.sent_light
        * paths.fraction
        * ranger.seen_share(np.maximum(paths.range, 1e-3))
    )
    # each ray of the spot has a phase of its own: on a slope they partly cancel
    read = ranger.phasor(power, paths.range).sum(-1)
    rng = default_rng([seed, 16, ranger.mode == "doubled"])
    read += ranger.noise(power.sum(-1)) * circular_normals(rng, read.size)
    return wrapped(np.angle(read)).reshape(angles.shape[:-1])
