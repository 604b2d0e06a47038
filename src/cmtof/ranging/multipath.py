r"""Light that takes detours: radiosity with delays in a corner, flood-lit or scanned by a spot.

The irradiance phasor b (W/m^2, modulation frequency f) of diffuse walls with albedo rho obeys

.. math:: b = e + \rho K b, \qquad
          K_{ij} = F_{ij}\, e^{-i 2\pi f d_{ij}/c}, \qquad
          F_{ij} = \frac{1}{A_i}\int\!\!\int \frac{\cos\theta_i \cos\theta_j}{\pi d^2}\,dA_j\,dA_i,

with e the light straight from the instrument: the radiosity equation (Goral et al. 1984), each link
with its delay. Flat walls meet along an edge and look the same along it, so K between two of them
is a convolution along that edge; a Fourier transform makes it a small matrix for each harmonic, and
millimetre cells fit in memory. Walls are Lambertian and scatter no polarisation, which is a model:
real corners shine a little.

A pixel sees one cell. The way from there to it is shared by direct and indirect light, so the error
of its range is ``-arg(b/e) c / (4 pi f)``: independent of where the camera stands.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.correlation import TAU, depth_from_phase
from cmtof.ranging.corner import Corner

Array = NDArray[np.floating]
Phasor = NDArray[np.complex128]

_NEAR = 4
"""Cells from the edge, and along it, between which the kernel is averaged over both cells."""
_NODES = 8
"""Gauss nodes a side for that average."""


# --- light from the instrument -----------------------------------------------------------------


def flood(corner: Corner, frequency: float) -> Phasor:
    """Direct irradiance phasor (walls, cells, along), 1/m^2 for 1 W/sr, all walls lit."""
    distance, cosine = corner.seen
    return cosine / distance**2 * _delay(distance, frequency)


def spots(corner: Corner, frequency: float, cells: ArrayLike) -> Phasor:
    """The same with one cell lit at a time: (S, walls, cells, along) for S indices (S, 3)."""
    index = np.asarray(cells, int)
    lit = np.zeros((len(index), *corner.shape), bool)
    lit[(np.arange(len(index)), *index.T)] = True
    return np.where(lit, flood(corner, frequency), 0)


def _delay(path: Array, frequency: float) -> Phasor:
    return np.exp((-1j * TAU * frequency / SPEED_OF_LIGHT) * path)


# --- from wall to wall -------------------------------------------------------------------------


def exchange(corner: Corner, frequency: float, *, moment: int = 0) -> Phasor:
    r"""Form factors with delays between cells of two walls, (cells, cells, along).

    For cells at u and v from the edge and Delta apart along it, whose centres lie d apart:
    ``d^2 = u^2 + v^2 - 2 u v cos(alpha) + Delta^2`` and
    ``F = A u v sin^2(alpha) / (pi d^4) exp(-i 2 pi f d / c)``, averaged over both cells where they
    are near.

    Parameters
    ----------
    corner : Corner
    frequency : float
        Hz.
    moment : int
        Power of d that weights it, for mean paths.
    """
    _, rows, columns = corner.shape
    h = corner.cell

    def value(u: Array, v: Array, apart: Array) -> Phasor:
        square = u**2 + v**2 - 2 * u * v * np.cos(corner.angle) + apart**2
        factor = h**2 * np.sin(corner.angle) ** 2 / np.pi * u * v / square**2
        d = np.sqrt(square)
        return factor * d**moment * _delay(d, frequency)

    u, apart = (np.arange(rows) + 0.5) * h, np.arange(columns) * h
    kernel = value(u[:, None, None], u[None, :, None], apart)
    near, close = min(_NEAR, rows), min(_NEAR, columns)
    # nodes crowd where two cells touch: the kernel has no limit there
    x, weight = np.polynomial.legendre.leggauss(_NODES)
    place, weight = ((x + 1) / 2) ** 3, 3 * ((x + 1) / 2) ** 2 * weight / 2
    gap = np.concatenate([-place, place])
    gap_weight = np.tile((1 - place) * weight, 2)  # of the differences of two points of a cell
    inner = (np.arange(near)[:, None] + place) * h
    fine = value(
        inner[:, :, None, None, None, None],
        inner[None, None, :, :, None, None],
        (apart[:close, None] + gap * h)[None, None, None, None],
    )
    kernel[:near, :near, :close] = np.einsum(
        "iajbkc,a,b,c->ijk", fine, weight, weight, gap_weight, optimize=True
    )
    return kernel


class Transport:
    """One bounce from wall to wall, for all cells at once.

    Parameters
    ----------
    corner : Corner
    frequency : float
        Hz.
    moment : int
        As in `exchange`.
    """

    def __init__(self, corner: Corner, frequency: float, *, moment: int = 0) -> None:
        self.corner = corner
        kernel = exchange(corner, frequency, moment=moment)
        # even along the edge: half of its spectrum over 2 m cells, enough not to wrap around
        padded = np.concatenate([kernel, np.zeros_like(kernel[..., :1])], axis=-1)
        self._spectrum = np.ascontiguousarray(
            np.moveaxis(np.asarray(fft.dct(padded, type=1)), -1, 0)
        )

    def bounce(self, light: ArrayLike) -> Phasor:
        """``K b``: irradiance (..., walls, cells, along) by that light once reflected, rho = 1."""
        given = np.asarray(light, complex)
        if given.shape[-3:] != self.corner.shape:
            raise ValueError(
                f"Expected light of shape (..., {', '.join(map(str, self.corner.shape))}), "
                f"got {given.shape}. Make it for this corner."
            )
        fields = given.reshape(-1, *self.corner.shape)
        found = np.zeros_like(fields)
        for into in range(self.corner.walls):
            for out in range(self.corner.walls):
                if into == out:
                    continue
                source = self._from_edge(fields[:, out], out, into)
                found[:, into] += self._from_edge(self._across(source), into, out)
        return found.reshape(given.shape)

    def _from_edge(self, field: Phasor, wall: int, other: int) -> Phasor:
        """Turn a wall's field so that its first axis leads away from the other; own inverse."""
        turned = self.corner.walls == 3 and (wall + 1) % 3 != other
        # the axis that leads away from wall j is the one that counts x_j
        return field.swapaxes(-1, -2) if turned else field

    def _across(self, field: Phasor) -> Phasor:
        """Convolve (N, cells, along) with the kernel along the edge."""
        m = field.shape[-1]
        bins = np.asarray(fft.fft(field, 2 * m, axis=-1)).transpose(2, 1, 0)  # (2 m, cells, N)
        out = np.empty_like(bins)
        out[: m + 1] = self._spectrum @ bins[: m + 1]
        out[m + 1 :] = self._spectrum[m - 1 : 0 : -1] @ bins[m + 1 :]
        return np.asarray(fft.ifft(out, axis=0))[:m].transpose(2, 1, 0)


def bounces(transport: Transport, light: ArrayLike, count: int) -> Phasor:
    """Terms ``K^n e`` of the Neumann series for n = 0 ... count, (count + 1, *shape of the light).

    They do not depend on the albedo: `total` adds them up for any.
    """
    terms = [np.asarray(light, complex)]
    for _ in range(count):
        terms.append(transport.bounce(terms[-1]))
    return np.stack(terms)


def total(terms: ArrayLike, albedo: float) -> Phasor:
    """Irradiance ``sum_n rho^n K^n e`` with all bounces in ``terms`` (B, ...)."""
    series = np.asarray(terms, complex)
    return np.einsum("b,b...->...", albedo ** np.arange(len(series)), series)


# --- what it does to the range -----------------------------------------------------------------


def range_error(ratio: ArrayLike, frequency: float) -> Array:
    """Error of the range, m, of a pixel whose light is ``ratio`` times the direct one, complex.

    Within half a wrap; positive where detours make the phase lag.
    """
    return depth_from_phase(-np.angle(np.asarray(ratio)), frequency)


def two_path_error(strength: ArrayLike, detour: ArrayLike, frequency: float) -> Array:
    r"""Error, m, that one detour of light makes, in closed form.

    .. math:: \delta z = \frac{c}{4\pi f}\,
              \mathrm{atan2}(a\sin k\Delta,\; 1 + a\cos k\Delta), \quad k = 2\pi f/c

    with a the light that took it over the direct light and Delta the length that it is longer, m.

    Examples
    --------
    At low frequencies half the mean detour: a = 1/4 of 1 m adds a fifth, halved.

    >>> round(float(two_path_error(0.25, 1.0, 1e3)), 4)
    0.1
    """
    lag = TAU * frequency / SPEED_OF_LIGHT * np.asarray(detour, float)
    return range_error(1 + np.asarray(strength) * np.exp(-1j * lag), frequency)


def mean_path_error(corner: Corner, albedo: float, *, count: int = 30) -> Array:
    """Error as f goes to 0, m: half the mean detour of all light, (walls, cells, along).

    The derivative of the transport equation at f = 0: with F the form factors and q the irradiance
    times its path, ``b = e + rho F b`` and ``q = e r + rho (F q + (F d) b)``.
    """
    plain, longer = Transport(corner, 0.0), Transport(corner, 0.0, moment=1)
    distance, _ = corner.seen
    light = total(bounces(plain, flood(corner, 0.0), count), albedo)
    source = flood(corner, 0.0) * distance + albedo * longer.bounce(light)
    path = total(bounces(plain, source, count), albedo)
    return np.real(path / light - distance) / 2


def spot_ratio(
    corner: Corner, terms: Phasor, albedo: float, frequency: float, cells: ArrayLike, field: float
) -> Phasor:
    """All light over the direct light, (S,), that a coaxial detector sees of S scanned spots.

    Indirect light counts only where it reaches a cell in the detector's field of view: between two
    flat walls that takes three reflections, unless the field of view reaches over the edge.

    Parameters
    ----------
    terms : ndarray, shape (B, S, walls, cells, along)
        `bounces` of `spots`.
    cells : array_like, shape (S, 3)
        The lit cells.
    field : float
        Full angle that the detector sees, rad.
    """
    distance, _ = corner.seen
    ray = (corner.points - corner.instrument) / distance[..., None]
    index = tuple(np.asarray(cells, int).T)
    apart = np.einsum("wijk,sk->swij", ray, ray[index])
    # light of a cell at the detector, as the instrument's light on the cell: reciprocity
    weight = np.where(apart >= np.cos(field / 2), flood(corner, frequency), 0)
    light = total(terms, albedo)
    direct = flood(corner, frequency)[index] ** 2
    return np.einsum("swij,swij->s", weight, light) / direct


def band_limit(frequencies: ArrayLike, strength: ArrayLike, *, level: float = 0.1) -> float:
    """Highest frequency, Hz, at which indirect light still has ``level`` of its strength at rest.

    The last crossing, interpolated in both logarithms (Gupta et al. 2015 call global light band
    limited: beyond it its phasors cancel).

    Parameters
    ----------
    frequencies : array_like, shape (F,)
        Rising, Hz; the first so low that the strength there is that at rest.
    strength : array_like, shape (F,)
        Indirect over direct light, magnitude.

    Raises
    ------
    ValueError
        If the last frequency is still above the level.
    """
    f, s = np.log(np.asarray(frequencies, float)), np.asarray(strength, float)
    over = np.log(s / (level * s[0]))
    if over[-1] > 0:
        raise ValueError(
            f"Expected the strength to fall below {level:g}, got {s[-1] / s[0]:.3g} at the end. "
            "Go on to higher frequencies."
        )
    last = int(np.flatnonzero(over > 0)[-1])
    share = over[last] / (over[last] - over[last + 1])
    return float(np.exp(f[last] + share * (f[last + 1] - f[last])))


def beat_wraps(
    ratio_low: ArrayLike, ratio_high: ArrayLike, *, frequencies: tuple[float, float]
) -> Array:
    """Wraps by which detours move the beat ``phi_2 - k phi_1`` against the phase of f_1.

    ``(f_1/Delta) (e_2 - k e_1)/2 pi - e_1/2 pi`` with the phase errors e and Delta = f_2 - k f_1:
    beyond half a wrap the pixel counts the wrong wrap, without any noise.

    Parameters
    ----------
    ratio_low, ratio_high : array_like
        All light over the direct light at both frequencies, complex.
    frequencies : (float, float)
        Hz.
    """
    low, high = frequencies
    multiple = round(high / low)
    first, second = (-np.angle(np.asarray(ratio)) for ratio in (ratio_low, ratio_high))
    beat = (second - multiple * first) * low / (high - multiple * low)
    return (beat - first) / TAU
