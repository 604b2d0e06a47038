"""Free space: the spot, how much light comes back, speckle, losses, the light that is sent."""

from typing import NamedTuple

import numpy as np
from numpy.linalg import norm
from numpy.typing import ArrayLike
from pandas.util import hash_array
from scipy.special import gammaincinv

from cmtof.modulator import doubled_mode_harmonics, single_mode_harmonics
from cmtof.types import Array, Complex
from cmtof_lab.settings import TwinSettings
from cmtof_lab.targets import RayEnds, Target

PLACE = 1e-6  # Directions, rad, that share their speckle: finer than a step of the galvo's 14 bits
# Largest number of 64 bits
WORD = 2**64 - 1
# 1/e^2 half angle into which a polished surface reflects a ray, rad (assumed)
SPECULAR_LOBE = 3e-3
# Share of a polished surface's reflectance that is diffuse (assumed)
SPECULAR_DIFFUSE = 0.02

# Points of the spot in units of its 1/e^2 radius, and their weights: exact for a Gaussian up to
# degree 5 (Stroud, Approximate Calculation of Multiple Integrals, 1971, E_2^{r^2}: 5-1)
_HEXAGON = np.arange(6) * np.pi / 3
_SPOT = np.vstack([[0.0, 0.0], np.transpose([np.cos(_HEXAGON), np.sin(_HEXAGON)])])
_WEIGHTS = np.array([1 / 2] + 6 * [1 / 12])


class Paths(NamedTuple):
    """Paths of the light to the scene and back, M for each of N directions."""

    range: Array  # (N, M), m; negative before the galvo
    fraction: Array  # (N, M), share of the emitted light that enters aperture and splitter's axis


def directions_from_angles(angles: ArrayLike, aside: ArrayLike = 0.0) -> Array:
    """Unit vectors (..., 3) along (tan x, tan y, 1) + aside for optical angles (..., 2), rad."""
    ray = np.insert(np.tan(angles) + aside, 2, 1.0, axis=-1)
    return ray / norm(ray, axis=-1, keepdims=True)


def spot_radius(settings: TwinSettings, distance: ArrayLike) -> Array:
    """1/e^2 radius of the spot, m, at a range, m: exit radius and defocus add up."""
    return settings.exit_radius + settings.divergence * np.abs(distance)


def aperture_area(settings: TwinSettings) -> float:
    """Area of the aperture, m^2."""
    return np.pi * settings.aperture**2 / 4


def speckle_cells(settings: TwinSettings, distance: ArrayLike) -> Array:
    """Speckle cells M in the aperture, ``1 + A pi w^2 / (lambda z)^2``: contrast 1 / sqrt(M)."""
    # (lambda z)^2 / (pi w^2): coherence area of a Gaussian spot (Goodman, Speckle, 2007, ch. 4)
    product = aperture_area(settings) * np.pi * spot_radius(settings, distance) ** 2
    return 1 + product / np.multiply(settings.wavelength, distance) ** 2


def lobe_share(cosine: Array, half_angle: ArrayLike) -> Array:
    """Brightness of a Gaussian lobe about the mirrored ray, 1 there: it turns by twice the tilt."""
    turned = 2 * np.arccos(np.minimum(cosine, 1))
    return np.exp(-2 * (turned / half_angle) ** 2)


def returned_fractions(settings: TwinSettings, hits: RayEnds) -> list[Array]:
    """Shares of the light on a surface that enter the aperture, diffuse and specular; 0 for NaN."""
    z = hits.range
    radius = settings.aperture / 2
    lobe = np.hypot(SPECULAR_LOBE, 2 * settings.divergence)
    with np.errstate(all="ignore"):
        # rho cos A / (pi z^2), half of it in the splitter's polarisation; half at the very most
        rough = np.minimum(0.5 * hits.cosine * (radius / z) ** 2, 0.5)
        # a Gaussian lobe, cut by the aperture, keeps its polarisation
        cut = radius / (z * lobe)
        mirrored = (1 - np.exp(-2 * cut**2)) * lobe_share(hits.cosine, lobe)
        parts = [
            (1 - hits.mirrored) * rough,
            hits.mirrored * (mirrored + SPECULAR_DIFFUSE * rough),
        ]
    return [np.where(z > 0, hits.reflectance * part, 0.0) for part in parts]


def trace(
    target: Target,
    angles: Array,
    settings: TwinSettings,
    seed: int,
) -> Paths:
    """Paths (N, 7) of the spot's sub-rays for optical angles (N, 2), rad."""
    # the spot's angle at 1 m serves at every range, or each ray would have to be traced twice
    spot = spot_radius(settings, 1.0) * _SPOT
    rays = directions_from_angles(angles[:, None], spot)
    hits = target.look(rays)
    distance = np.fmax(hits.range, 0.0)
    rough, polished = (_WEIGHTS * one for one in returned_fractions(settings, hits))
    if settings.speckle and rough.any():
        # a gamma law of each sub-ray's cells, so that the whole spot follows that of all cells
        cells = _WEIGHTS * speckle_cells(settings, np.maximum(distance, 1e-3))
        chance = uniform_from_places(
            seed,
            np.rint(angles / PLACE),
            _WEIGHTS.size,
        )
        rough = rough * gammaincinv(cells, chance) / cells
    return Paths(distance, rough + polished)


def uniform_from_places(seed: int, places: ArrayLike, count: int) -> Array:
    """Uniform numbers (N, count) in (0, 1) that depend on the seed and on places (N, 2) only."""
    # places, whole numbers of 32 bits, are mixed as in SplitMix64 (Steele et al., OOPSLA 2014)
    pair = np.asarray(places, np.int64).view(np.uint64)
    start = hash_array(np.array([seed & WORD, 7], np.uint64))  # pyright: ignore[reportCallIssue]
    # arrays of unsigned integers wrap round without a warning
    word = (pair[:, :1] << 32) ^ (pair[:, 1:] & 0xFFFFFFFF)
    column = np.arange(1, count + 1, dtype=np.uint64) * 0x9E3779B97F4A7C15
    row = hash_array(word ^ start[:1])  # pyright: ignore[reportCallIssue]
    mixed = hash_array(row + start[1:] + column) >> 11  # pyright: ignore[reportCallIssue]
    return (mixed + 0.5) / 2.0**53


def outward(settings: TwinSettings) -> float:
    """Transmission from fibre to scene, modulator apart (Sec. 7.1): lenses, mirrors, splitters."""
    return settings.lens**2 * settings.mirror**4 * settings.splitter**2


def inward(settings: TwinSettings) -> float:
    """Transmission from aperture to detector, modulator apart (Sec. 7.2)."""
    return settings.mirror**4 * settings.splitter * settings.lens**3


def ambient(settings: TwinSettings) -> float:
    """Room light, W, through `inward`: half of radiance times aperture times solid angle."""
    etendue = aperture_area(settings) * (np.pi * settings.field_of_view**2 / 4)
    return 0.5 * settings.ambient_radiance * etendue * inward(settings)


def emission_harmonics(settings: TwinSettings, mode: str) -> Complex:
    """Mean and first two harmonics (3,) of an ideal emission module at the stated eta."""
    law = doubled_mode_harmonics if mode == "doubled" else single_mode_harmonics
    return law(settings.eta, 2)


def emission_mean(settings: TwinSettings, mode: str) -> float:
    """Mean transmission of an ideal emission module, its mirror's reflectance included."""
    return emission_harmonics(settings, mode)[0].real * settings.mirror_reflectance


def sent_power(settings: TwinSettings, mode: str = "single") -> float:
    """Mean power sent to the scene, W, the fibre at the middle of its drift (Sec. 7.1: 3 mW)."""
    emitted = settings.laser_power * settings.fibre * emission_mean(settings, mode)
    return emitted * outward(settings)
