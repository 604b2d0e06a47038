"""Michelson interferometer with fringe counting, one of the instruments of Fig. 13 and Table 4.

The stage creeps from position to position; all the way the phase of the fringes is read, and each
reading is unwrapped against the one before. The wavelength turns fringes into metres.
"""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.bounds import linear_phase_noise
from cmtof.correlation import decode
from cmtof.instrument.settings import TwinSettings
from cmtof.ranging.disturbance import Speckle, drift, vibration, vibration_spread
from cmtof.ranging.fringes import fringe_phase, fringe_range, step_response
from cmtof.ranging.michelson import Fringes, Michelson, fringes, phase_index
from cmtof.ranging.target import StageTarget

Array = NDArray[np.float64]

AIR_PER_KELVIN = -0.93e-6
"""Change of the air's index per K at 20 C, 1/K (known)."""


class Path(NamedTuple):
    """Where the target is at each of N readings, and which of them belong to the P positions."""

    places: Array
    """(N,), m."""
    stations: NDArray[np.int64]
    """(P,)"""


class Record(NamedTuple):
    """One run: what the target did and what was read, for N readings."""

    truth: Array
    """Range less the first one, m, as the fringes see it: travel, vibration and drift."""
    wrapped: Array
    """Phase as read, in [-pi, pi], rad."""
    counted: Array
    """Range less the first one by sequential unwrapping, m."""
    amplitude: Array
    """Of the fringes, V."""
    stations: NDArray[np.int64]
    """(P,), readings that belong to the positions."""


@dataclass(frozen=True)
class Interferometer:
    """Interferometer of Sec. 8.2 on the simulated instrument.

    Each reading moves the reference mirror in K steps over half a wavelength, lengthened by the
    stage's nominal motion in that time, and takes the phase by least squares. Before the move the
    first position is read until noise and vibration no longer count.

    Parameters
    ----------
    settings : TwinSettings
        Laser, optics, air and detector.
    michelson : Michelson
        What the interferometer adds.

    Examples
    --------
    >>> ruler = Interferometer(TwinSettings())
    >>> found = ruler.sweep(StageTarget.mirror(), [0.0, 2e-6], repeats=1, seed=0)
    >>> bool(abs(found[0, 1] - found[0, 0] - 2e-6) < 0.4e-6)
    True
    """

    settings: TwinSettings
    michelson: Michelson = field(default_factory=Michelson)

    @property
    def wavelength(self) -> float:
        """Of the laser in air, m."""
        laser = self.settings.laser
        return laser.wavelength / phase_index(self.settings.air, laser.wavelength)

    @property
    def change_spread(self) -> float:
        """Standard deviation of what vibration adds between two readings, m."""
        m, time = self.michelson, self.michelson.reading_time
        table = vibration_spread(
            time, rms=m.table_rms, frequency=m.table_frequency, quality=m.quality
        )
        mount = vibration_spread(
            time, rms=m.mount_rms, frequency=m.mount_frequency, quality=m.quality
        )
        return float(np.hypot(table, mount))

    def path(self, positions: ArrayLike) -> Path:
        """Readings on the way through positions (P,), m: none further apart than a stride."""
        stops = _checked(positions)
        gaps = np.abs(np.diff(stops)) / self.michelson.stride
        counts = np.maximum(1, np.ceil(gaps - 1e-9)).astype(np.int64)
        stations = np.concatenate([[0], np.cumsum(counts)])
        return Path(np.interp(np.arange(stations[-1] + 1), stations, stops), stations)

    # --- forward and inverse ----------------------------------------------------------------------

    def sweep(self, target: StageTarget, positions: ArrayLike, *, repeats: int, seed: int) -> Array:
        """Ranges (repeats, P), m, found at stage positions (P,), m from ``target.distance``.

        A repeat is another day: wavelength, mirror's travel, speckle and drift are drawn anew. The
        first position is known; the stage misses the others by its error.

        Raises
        ------
        ValueError
            For positions that are not one finite row, or fewer than one repeat.
        """
        if repeats < 1:
            raise ValueError(f"Expected at least 1 repeat, got {repeats}. Ask for more.")
        scene = self._scene(target, positions)
        found = np.empty((repeats, scene.path.stations.size))
        for repeat in range(repeats):
            run = self._run(scene, np.random.default_rng([seed, repeat]), full=False)
            found[repeat] = run.counted[run.stations]
        found[:, 0] = 0.0  # the first position is where the instrument was set to the known range
        return target.distance + scene.path.places[0] + found

    def bound(self, target: StageTarget, positions: ArrayLike) -> Array:
        """Cramer-Rao least standard deviation (P,), m, of one range from noise alone.

        ``lambda / 4 pi sqrt(2 v / K) / a``; a diffuse plate at the mean of its speckle. At the
        first position it is the bound of the reading, though the range is known there.
        """
        light = self._light(target, _checked(positions))
        noise = linear_phase_noise(light.amplitude, light.variance, self.michelson.steps)
        return fringe_range(noise, self.wavelength)

    def record(
        self,
        target: StageTarget,
        positions: ArrayLike,
        *,
        seed: int,
        repeat: int = 0,
        full: bool = False,
    ) -> Record:
        """One run with all its readings: a repeat of `sweep`.

        Parameters
        ----------
        full : bool
            Simulate every step of the mirror with its own vibration and noise, and decode it. Else
            a reading is one phasor, for which vibration stands still. Other random numbers, the
            same law: tests hold the two together.
        """
        rng = np.random.default_rng([seed, repeat])
        return self._run(self._scene(target, positions), rng, full=full)

    def _light(self, target: StageTarget, places: Array) -> Fringes:
        return fringes(self.settings, self.michelson, target, target.distance + places)

    def _scene(self, target: StageTarget, positions: ArrayLike) -> "_Scene":
        path, m = self.path(positions), self.michelson
        rough = target.material == "diffuse" and self.settings.optics.speckle
        return _Scene(
            path,
            self._light(target, path.places),
            Speckle(path.places, m.speckle_length) if rough else None,
            target.distance * (m.expansion + AIR_PER_KELVIN) * m.temperature_drift,
        )

    def _run(self, scene: "_Scene", rng: np.random.Generator, *, full: bool) -> Record:
        m, path, count = self.michelson, scene.path, scene.path.places.size
        scale, travel = rng.standard_normal(2) * [m.wavelength_error, m.sweep_error]
        missed = m.stage_error * rng.standard_normal(path.stations.size)
        rough = np.ones(count) if scene.speckle is None else scene.speckle.draw(rng)
        field = scene.light.amplitude * rough
        way = path.places - path.places[0]
        way += np.interp(np.arange(count), path.stations, missed - missed[0])
        way += drift(rng, count, m.reading_time, rms=scene.drift, time=m.drift_time)
        steps = m.steps if full else 1
        shaken = self._vibration(rng, count * steps, m.reading_time / steps).reshape(count, steps)
        truth = way[:, None] + shaken
        read = _read_steps if full else _read_frozen
        phase = fringe_phase(truth, self.wavelength)
        wrapped = np.angle(read(m, scene.light, field, phase, travel, rng))
        # the plate's own phase and the mirror's cyclic error belong to the known range, too
        plus, minus = step_response(m.psi, travel)
        start = np.angle(plus * field[:1] + minus * np.conj(field[:1]))
        counted = np.unwrap(np.concatenate([start, wrapped]))[1:] - start
        metres = fringe_range(counted, self.wavelength * (1 + scale))
        return Record(truth.mean(-1), wrapped, metres, np.abs(field), path.stations)

    def _vibration(self, rng: np.random.Generator, count: int, interval: float) -> Array:
        m = self.michelson
        table = vibration(
            rng, count, interval, rms=m.table_rms, frequency=m.table_frequency, quality=m.quality
        )
        mount = vibration(
            rng, count, interval, rms=m.mount_rms, frequency=m.mount_frequency, quality=m.quality
        )
        return table + mount


class _Scene(NamedTuple):
    """What all repeats of a sweep share."""

    path: Path
    light: Fringes
    speckle: Speckle | None
    drift: float  # rms, m


def _read_frozen(
    m: Michelson,
    light: Fringes,
    field: NDArray[Any],
    phase: Array,
    travel: float,
    rng: np.random.Generator,
) -> NDArray[np.complex128]:
    """Phasors (N,) of readings, V, while phase (N, 1), rad, stands still."""
    turned = field * np.exp(1j * phase[:, 0])
    plus, minus = step_response(m.psi, travel)
    noise = rng.standard_normal((turned.size, 2)).view(complex)[:, 0]
    spread = np.sqrt(2 * light.variance / m.steps)
    return plus * turned + minus * np.conj(turned) + spread * noise


def _read_steps(
    m: Michelson,
    light: Fringes,
    field: NDArray[Any],
    phase: Array,
    travel: float,
    rng: np.random.Generator,
) -> NDArray[np.complex128]:
    """Phasors (N,) of readings, V, decoded from the intensity at each step; phase (N, K), rad."""
    angle = phase + (1 + travel) * m.psi
    volts = light.offset[:, None] + np.real(field[:, None] * np.exp(1j * angle))
    volts += np.sqrt(light.variance)[:, None] * rng.standard_normal(volts.shape)
    read = decode(volts.T, m.psi)
    return np.asarray(read.amplitude * np.exp(1j * read.phase), complex)


def _checked(positions: ArrayLike) -> Array:
    """Positions as one finite row."""
    stops = np.asarray(positions, float)
    if stops.ndim != 1 or stops.size == 0 or not np.isfinite(stops).all():
        raise ValueError(
            f"Expected finite positions of shape (P,), got shape {stops.shape}. "
            "Give one row of them in metres."
        )
    return stops
