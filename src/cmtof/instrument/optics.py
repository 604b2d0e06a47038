"""Free space: air, the spot, how much light comes back, speckle, losses, the light that is sent."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammaincinv

from cmtof.constants import LASER_WAVELENGTH
from cmtof.instrument.drift import uniform_from_places
from cmtof.instrument.settings import Air, Optics, TwinSettings
from cmtof.instrument.targets import Hits, Target
from cmtof.modulator import doubled_mode_harmonics, single_mode_harmonics

Array = NDArray[np.float64]

PLACE = 1e-6
"""Directions, rad, that share their speckle: finer than a step of the galvo's 14 bits."""
SPECULAR_LOBE = 3e-3
"""1/e^2 half angle into which a polished surface reflects a ray, rad (assumed)."""
SPECULAR_DIFFUSE = 0.02
"""Share of a polished surface's reflectance that is diffuse (assumed)."""

_HEXAGON = np.arange(6) * np.pi / 3
# Points of the spot in units of its 1/e^2 radius, and their weights: exact for a Gaussian up to
# degree 5 (Stroud, Approximate Calculation of Multiple Integrals, 1971, E_2^{r^2}: 5-1)
_SPOT = np.concatenate([[[0.0, 0.0]], np.stack([np.cos(_HEXAGON), np.sin(_HEXAGON)], -1)])
_WEIGHTS = np.array([1 / 2] + 6 * [1 / 12])


class Paths(NamedTuple):
    """Ways of the light to the detector and back, M for each of N directions."""

    range: Array
    """(N, M), m; negative before the galvo."""
    fraction: Array
    """(N, M), share of the emitted light that enters the aperture and the splitter's axis."""


def group_index(air: Air = Air(), wavelength: float = LASER_WAVELENGTH) -> float:  # noqa: B008
    """Group index of dry air, ``n_g = n - lambda dn/dlambda``.

    Dispersion of standard air (15 C, 101325 Pa, 450 ppm CO2) by P. E. Ciddor, Appl. Opt. 35, 1566
    (1996), eq. 1, scaled with the density of an ideal gas; water vapour, below 5e-7 in a room, is
    left out.

    Examples
    --------
    >>> f"{group_index(Air(temperature=288.15)) - 1:.4e}"
    '2.8975e-04'
    """
    square = (1e-6 / wavelength) ** 2  # wave number squared, 1/um^2
    refractivity = 0.0
    for strength, pole in ((0.05792105, 238.0185), (0.00167917, 57.362)):
        # n + sigma dn/dsigma of strength / (pole - sigma^2)
        refractivity += strength * (pole + square) / (pole - square) ** 2
    return 1 + refractivity * (air.pressure / 101325.0) * (288.15 / air.temperature)


def directions_from_angles(angles: ArrayLike) -> Array:
    """Unit vectors (..., 3) of optical angles (..., 2), rad: along (tan x, tan y, 1)."""
    return _unit(np.tan(np.asarray(angles, float)))


def _unit(tangent: Array) -> Array:
    """Unit vectors (..., 3) along (tangent, 1)."""
    ray = np.concatenate([tangent, np.ones((*tangent.shape[:-1], 1))], axis=-1)
    return ray / np.sqrt((ray * ray).sum(-1, keepdims=True))


def spot_radius(optics: Optics, distance: ArrayLike) -> Array:
    """1/e^2 radius of the spot, m, at a range, m: exit radius and defocus add up."""
    return optics.exit_radius + optics.divergence * np.abs(np.asarray(distance, float))


def speckle_cells(optics: Optics, wavelength: float, distance: ArrayLike) -> Array:
    """Speckle cells in the aperture, ``1 + A pi w^2 / (lambda z)^2``; their contrast is 1/sqrt.

    The coherence area of a Gaussian spot of radius w is ``(lambda z)^2 / (pi w^2)`` (Goodman,
    Speckle Phenomena in Optics, 2007, ch. 4): defocus makes the spot larger and speckle weaker.
    """
    z = np.asarray(distance, float)
    area = np.pi * optics.aperture**2 / 4
    return 1 + area * np.pi * spot_radius(optics, z) ** 2 / (wavelength * z) ** 2


def returned_fraction(optics: Optics, material: str, hits: Hits) -> Array:
    """Share of the light on a surface that enters the aperture, polarisation included; 0 for NaN.

    Diffuse: ``rho cos A / (pi z^2)``, half of it in the polarisation that the splitter passes.
    Specular: a Gaussian lobe that spreads over the range, cut by the aperture and turned away by
    twice the tilt; the polarisation is kept. Mixed: both laws, weighted with ``hits.mirrored``.
    """
    rough, polished = _returned(optics, material, hits)
    return rough + polished


def _returned(optics: Optics, material: str, hits: Hits) -> tuple[Array, Array]:
    """Both parts of `returned_fraction`: what speckles, and what a polished surface returns."""
    z = hits.range
    radius = optics.aperture / 2
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        # half of the hemisphere's light at the very most, for ranges within the aperture
        share = np.minimum(0.5 * hits.cosine * (radius / z) ** 2, 0.5)
        rough, polished = share, np.zeros_like(share)
        if material != "diffuse":
            lobe = np.hypot(SPECULAR_LOBE, 2 * optics.divergence)
            caught = 1 - np.exp(-2 * (radius / (z * lobe)) ** 2)
            turned = 2 * np.arccos(np.minimum(hits.cosine, 1))
            polished = caught * np.exp(-2 * (turned / lobe) ** 2) + SPECULAR_DIFFUSE * share
            weight = hits.mirrored if material == "mixed" else 1.0
            rough, polished = (1 - weight) * share, weight * polished
    rough, polished = (np.where(z > 0, hits.reflectance * part, 0.0) for part in (rough, polished))
    return rough, polished


def trace(target: Target, angles: Array, settings: TwinSettings, seed: int) -> Paths:
    """Paths (N, 7) of the spot's sub-rays for optical angles (N, 2), rad.

    Speckle multiplies what a rough surface returns into each sub-ray by an independent gamma law of
    its share of the cells, so the whole spot follows that of all cells; it depends on the direction
    only, the same in both modes.
    """
    optics = settings.optics
    tangent = np.tan(angles)[:, None, :]
    # the spot's angle at 1 m serves at every range, or each ray would have to be traced twice
    angle = float(spot_radius(optics, 1.0))
    weights = _WEIGHTS if angle else np.ones(1)
    hits = target.look(_unit(tangent + angle * _SPOT if angle else tangent))
    distance = np.where(hits.range > 0, hits.range, 0.0)
    rough, polished = (weights * part for part in _returned(optics, target.material, hits))
    if optics.speckle and target.material != "specular":
        far = np.maximum(distance, 1e-3)
        cells = speckle_cells(optics, settings.laser.wavelength, far) * weights
        chance = uniform_from_places(seed, np.rint(angles / PLACE), weights.size)
        rough = rough * gammaincinv(cells, chance) / cells
    return Paths(distance, rough + polished)


def with_stray(paths: Paths, optics: Optics) -> Paths:
    """Paths and the coaxial back-reflection."""
    stray = (optics.back_range, optics.back_fraction)
    more = (np.full((len(paths.range), 1), value) for value in stray)
    return Paths(*(np.concatenate(pair, axis=1) for pair in zip(paths, more, strict=True)))


def outward(optics: Optics) -> float:
    """Transmission from the fibre to the scene, modulator apart (Sec. 7.1).

    Two lenses, a mirror, two splitters, the mirror to the galvo and its two mirrors.
    """
    return optics.lens**2 * optics.mirror**4 * optics.splitter**2


def to_power_meter(optics: Optics) -> float:
    """Transmission from the fibre to the integrating sphere, modulator apart (Sec. 7.1)."""
    return optics.lens**2 * optics.mirror * optics.splitter


def inward(optics: Optics) -> float:
    """Transmission from the aperture to the detector, modulator apart (Sec. 7.2).

    Two galvo mirrors and the mirror behind them, the splitter's second passage, the expander's two
    lenses, a mirror, and the lens before the detector.
    """
    return optics.mirror**4 * optics.splitter * optics.lens**3


def ambient(optics: Optics) -> float:
    """Room light, W, behind `inward`: radiance times aperture times solid angle, half polarised."""
    solid = np.pi * optics.field_of_view**2 / 4
    area = np.pi * optics.aperture**2 / 4
    return float(0.5 * optics.ambient_radiance * area * solid * inward(optics))


def emission_mean(settings: TwinSettings, mode: str) -> float:
    """Mean transmission of an ideal emission module at the stated eta, mirror included."""
    law = doubled_mode_harmonics if mode == "doubled" else single_mode_harmonics
    return float(law(settings.drive.eta, 2)[0].real) * settings.emission.mirror_reflectance


def sent_power(settings: TwinSettings, mode: str = "single") -> float:
    """Mean power sent to the scene, W, the fibre at the middle of its drift (Sec. 7.1: 3 mW).

    Examples
    --------
    >>> round(1e3 * sent_power(TwinSettings()), 2)
    3.2
    """
    fibre = (settings.laser.fibre_low + settings.laser.fibre_high) / 2
    through = fibre * emission_mean(settings, mode) * outward(settings.optics)
    return settings.laser.power * through
