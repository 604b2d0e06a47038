r"""The light of a 100 MHz camera: which phasors reach each pixel, and what pulls at them.

A pixel is held as the phasors of all paths that reach it, in electrons of one phase step, for the
harmonics h of its waveforms:

.. math:: F_h = \sum_\mathrm{paths} N e^{-ih\phi}.

Mixing of light is linear in them: a point spread is a convolution, scattered light a constant.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter

from cmtof.constants import SPEED_OF_LIGHT
from cmtof.correlation import phase_from_depth
from cmtof.instrument.electronics import PLANCK
from cmtof.instrument.optics import SPECULAR_DIFFUSE, SPECULAR_LOBE
from cmtof.ranging.mhz_settings import STEPS, CameraSettings

Array = NDArray[np.floating]
Complex = NDArray[np.complexfloating]

ORDERS = np.array([0, 1, 3, 5, 7, 9])
"""Harmonics that are carried: a gate of half a period has no even ones."""


class View(NamedTuple):
    """What the pixels of a window about the axis see, arrays (H, W).

    The fields are those of `cmtof.instrument.targets.Hits`. A finer raster of (s H, s W) rays
    serves where pixels see edges, see `light_of`.
    """

    range: Array
    """m; NaN where nothing is."""
    cosine: Array
    """Between ray and normal, 0 to 1."""
    reflectance: Array
    """0 to 1."""
    mirrored: Array | float = 0.0
    """Weight of the law of a polished surface against a diffuse one, 0 to 1."""


class Light(NamedTuple):
    """Charge of one phase step in both taps together, electrons."""

    phasors: Complex
    """(6, H, W): ``sum N exp(-i h phi)`` for the harmonics `ORDERS`; the first is all signal."""
    ambient: Array
    """(H, W): charge from the room's light."""


# --- the direct way ----------------------------------------------------------------------------


def emitted_charge(settings: CameraSettings) -> float:
    """Electrons that all light emitted in one step would make in a pixel."""
    photon = PLANCK * SPEED_OF_LIGHT / settings.wavelength
    return settings.power * settings.exposure / STEPS / photon * settings.efficiency


def signal(settings: CameraSettings, view: View) -> Array:
    r"""Charge of one step in both taps by the direct way, electrons, (H, W).

    .. math:: N = \frac{P T}{4\,h\nu}\,\frac{\eta\,t}{n}\,\frac{\varrho\cos\theta\,A}{\pi z^2}

    with n pixels in the field, the lens' opening A and transmission t. The focal length drops out:
    a pixel sees just the light that is sent towards what it sees. A polished surface keeps a small
    diffuse share, and where it faces lens and source it mirrors the light.
    """
    z, cosine, weight = view.range, view.cosine, np.asarray(view.mirrored)
    with np.errstate(invalid="ignore", divide="ignore"):
        lobe = np.hypot(SPECULAR_LOBE, settings.source_radius / z)
        turned = 2 * np.arccos(np.minimum(cosine, 1))
        # a Gaussian lobe of 1/e^2 half angle w peaks at 2 / (pi w^2) per sr, white paper at 1 / pi
        mirror = 2 / lobe**2 * np.exp(-2 * (turned / lobe) ** 2)
        shine = (1 - weight) * cosine + weight * (SPECULAR_DIFFUSE * cosine + mirror)
        share = view.reflectance * shine * settings.pupil_area / (np.pi * z**2)
    sent = emitted_charge(settings) / settings.pixels  # into the field of one pixel
    return sent * settings.transmission * np.where(z > 0, share, 0.0)


def ambient(settings: CameraSettings, view: View) -> Array:
    """Charge of one step in both taps from the room's light behind the band-pass, electrons."""
    radiance = settings.ambient_radiance * settings.filter_width * view.reflectance
    etendue = settings.pupil_area * (settings.pixel / settings.focal_length) ** 2
    photon = PLANCK * SPEED_OF_LIGHT / settings.wavelength
    photons = radiance * etendue * settings.transmission * settings.exposure / STEPS / photon
    return np.where(view.range > 0, photons * settings.efficiency, 0.0)


# --- all ways ----------------------------------------------------------------------------------


def light_of(
    settings: CameraSettings, view: View, *, rays: int = 1, field: View | None = None
) -> Light:
    """Charge that reaches each pixel of a window: direct, blurred, scattered, leaked.

    Parameters
    ----------
    settings : CameraSettings
    view : View
        Arrays (rays H, rays W).
    rays : int
        Rays across a pixel, whose phasors it adds up.
    field : View, optional
        The whole field on an even raster of any size: what is scattered over the sensor. Without
        it the field is dark outside the window.

    Raises
    ------
    ValueError
        If the arrays differ in shape or do not divide into pixels.
    """
    _check(view, rays)
    phasors = _binned(_phasors(settings, view), rays)
    room = _binned(ambient(settings, view), rays)
    if field is None:
        scattered = phasors.sum((1, 2)) / settings.pixels
        of_room = room.sum() / settings.pixels
    else:
        scattered = _phasors(settings, field).mean((1, 2))
        of_room = float(ambient(settings, field).mean())
    if settings.blur:
        phasors = _blurred(phasors.real, settings) + 1j * _blurred(phasors.imag, settings)
        room = _blurred(room, settings)
    kept = 1 - settings.veil
    leaked = emitted_charge(settings) * settings.leak / settings.pixels  # from range 0
    phasors = kept * phasors + settings.veil * scattered[:, None, None] + leaked
    return Light(phasors, kept * room + settings.veil * of_room)


def _phasors(settings: CameraSettings, view: View) -> Complex:
    phase = phase_from_depth(np.nan_to_num(view.range), settings.frequency)
    turns = np.exp(-1j * ORDERS[:, None, None] * phase)
    return np.asarray(signal(settings, view) * turns, complex)


def _binned(images: Any, rays: int) -> Any:
    """Mean (..., H, W) over blocks of ``rays`` by ``rays`` of (..., rays H, rays W)."""
    *first, height, width = images.shape
    blocks = images.reshape(*first, height // rays, rays, width // rays, rays)
    return blocks.mean((-3, -1))


def _blurred(images: Array, settings: CameraSettings) -> Array:
    """Convolve (..., H, W) with the point spread; beyond the border lies what lies on it."""
    return gaussian_filter(images, settings.blur, mode="nearest", axes=(-2, -1))


def _check(view: View, rays: int) -> None:
    shapes = {np.shape(part) for part in view[:3]}
    if len(shapes) > 1 or len(np.shape(view.range)) != 2:
        raise ValueError(
            f"Expected images (H, W) of one shape, got {sorted(shapes)}. Trace them together."
        )
    height, width = view.range.shape
    if rays < 1 or height % rays or width % rays:
        raise ValueError(
            f"Expected {rays} rays across each pixel to divide {height} x {width}, got a rest. "
            "Trace whole pixels."
        )


# --- closed forms of what pulls at a phase -----------------------------------------------------


def pulled_phase(ratio: ArrayLike, difference: ArrayLike) -> Array:
    """Phase error by a veil of ``ratio`` times the pixel's own amplitude, rad.

    ``arg(1 + s exp(i D))``, D the veil's phase less the pixel's, rad: at most ``asin(s)`` while
    s < 1, all of D when the pixel is black.

    Examples
    --------
    >>> round(float(pulled_phase(0.1, np.pi / 2)), 4)  # atan(0.1)
    0.0997
    """
    return np.angle(1 + np.asarray(ratio, float) * np.exp(1j * np.asarray(difference, float)))


def ratio_for_pull(error: float, difference: float) -> float:
    """Veil over own amplitude that pulls a phase by ``error``, rad: ``sin e / sin(D - e)``.

    Infinite where no veil of that phase pulls so far.

    Examples
    --------
    >>> round(ratio_for_pull(float(pulled_phase(0.3, 1.0)), 1.0), 6)
    0.3
    """
    if not 0 < error < difference < np.pi:
        return float("inf")
    return float(np.sin(error) / np.sin(difference - error))


def delay_error(delay: float, filling: ArrayLike) -> Array:
    """Range error, m, of taps that answer ``delay * filling`` s late: ``c delay fill / 2``."""
    return SPEED_OF_LIGHT * delay * np.asarray(filling, float) / 2
