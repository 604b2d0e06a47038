"""What a camera makes of a laser spot (simulated): electrons, speckle, shot and read noise, counts.

Numbers of the sensor are those published for pixels of its kind; each says where it comes from.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr

from cmtof.constants import LASER_WAVELENGTH, SPEED_OF_LIGHT
from cmtof.stereo.rig import FOCAL_LENGTH, PIXEL_PITCH

Array = NDArray[np.floating]

PLANCK = 6.62607015e-34
"""J s (exact, SI)."""

LASER_POWER = 3e-3
"""Of the beam that leaves the scanner, W (Sec. 7.1)."""


@dataclass(frozen=True)
class Sensor:
    """Noise and colour of a camera's pixels, and the lens before them.

    Attributes
    ----------
    full_well : float
        Electrons. 40.3 dB of signal to noise, table of the IMX255 in Matrix Vision's mvBlueFOX3
        manual, Sec. 20.7: that sensor has the IMX252's pixel; its own number is not verified.
    read_noise : float
        Electrons, from the 71.3 dB dynamic range of the same table.
    bits : int
        Of the converter; FLIR's table for the BFS-U3-32S4 (see `cmtof.stereo.rig.PIXEL_PITCH`).
    efficiency : float
        Electrons per photon at 532 nm in a green pixel, lens included. Not verified.
    mosaic : tuple
        Response of red, green / green, blue pixels at 532 nm over that of green: the C in
        GS3-U3-32S4C is a colour sensor. A reading of typical curves, not verified.
    f_number : float
        Of the lens; the paper does not tell.
    pitch, focal_length : float
        m.
    """

    full_well: float = 10_700.0
    read_noise: float = 2.9
    bits: int = 12
    efficiency: float = 0.5
    mosaic: tuple[tuple[float, float], tuple[float, float]] = ((0.1, 1.0), (1.0, 0.2))
    f_number: float = 4.0
    pitch: float = PIXEL_PITCH
    focal_length: float = FOCAL_LENGTH

    @property
    def gain(self) -> float:
        """Electrons per count: the full well fills the converter."""
        return self.full_well / (2**self.bits - 1)

    @property
    def variance(self) -> float:
        """Of a dark pixel, electrons^2: read noise and rounding to whole counts."""
        return self.read_noise**2 + self.gain**2 / 12

    @property
    def top(self) -> int:
        """Largest count."""
        return 2**self.bits - 1

    def response(self, corners: ArrayLike, side: int) -> Array:
        """Relative response (..., side, side) of windows at corners (..., 2), column and row."""
        corner = np.asarray(corners, int)
        columns = (corner[..., :1] + np.arange(side)) % 2
        rows = (corner[..., 1:] + np.arange(side)) % 2
        return np.asarray(self.mosaic)[rows[..., :, None], columns[..., None, :]]

    def counts(self, electrons: ArrayLike, rng: np.random.Generator) -> Array:
        """Counts of mean electrons: Poisson, read noise, rounded, clipped at the top.

        Like a real one the camera adds an offset, here 32 counts, so that noise is not cut off.
        """
        drawn = rng.poisson(np.asarray(electrons, float)).astype(float)
        drawn += self.read_noise * rng.standard_normal(drawn.shape)
        return np.clip(np.rint(drawn / self.gain) + OFFSET, 0, self.top)

    def flux(
        self, reflectance: ArrayLike, distance: ArrayLike, cosine: ArrayLike, power: float
    ) -> Array:
        r"""Electrons a second in green pixels from a spot on a Lambertian surface.

        .. math:: \dot N = \frac{\lambda}{hc}\,P\,\rho\,q\,\frac{\cos\theta\,D^2}{4 R^2},
                  \quad D = f/N

        Parameters
        ----------
        reflectance, distance, cosine : array_like
            rho; from spot to lens, m; of the angle between the surface's normal and the lens.
        power : float
            W.
        """
        photons = power * LASER_WAVELENGTH / (PLANCK * SPEED_OF_LIGHT)
        aperture = self.focal_length / self.f_number
        share = np.asarray(cosine) * aperture**2 / (4 * np.asarray(distance) ** 2)
        return photons * self.efficiency * np.asarray(reflectance) * share

    def speckle(self, contrast: float) -> float:
        r"""Standard deviation of a spot's centroid by speckle, px, whatever its size and distance.

        .. math:: \sigma = \frac{C \lambda N}{\sqrt 2\,\pi p}

        A spot of Gaussian profile E, covered with speckle of contrast C and area
        :math:`A = 4 (\lambda N)^2 / \pi` (round aperture), has a centroid of variance
        :math:`C^2 A \int x^2 E^2 / (\int E)^2 = C^2 A / 8\pi`: a larger spot holds more speckles,
        and its centroid is as unsure as before. `speckled_centroids` draws it from the wave itself.
        That this limits laser triangulation was found by R. G. Dorsch, G. Haeusler and
        J. M. Herrmann, Applied Optics 33, 1306 (1994); their factor depends on the shape of the
        aperture and was not verified.

        Parameters
        ----------
        contrast : float
            C: 1 in polarised light, 1 / sqrt 2 where the surface depolarises it.
        """
        return contrast * LASER_WAVELENGTH * self.f_number / (np.sqrt(2) * np.pi * self.pitch)


OFFSET = 32
"""Counts that the simulated cameras add in the dark."""


def gaussian_spot(
    side: int, centre: ArrayLike, width: ArrayLike
) -> tuple[Array, Array, Array, Array]:
    """Share of a Gaussian spot in each pixel of a window, with derivatives.

    Parameters
    ----------
    side : int
        Of the window, px.
    centre : array_like, shape (..., 2)
        x, y in the window, px; pixel centres at +0.5.
    width : array_like, shape (...)
        Standard deviation, px.

    Returns
    -------
    share, by_x, by_y, by_width : ndarray, shape (..., side, side)
    """
    centre, width = np.asarray(centre, float), np.asarray(width, float)[..., None]
    edges = np.arange(side + 1)
    profile, by_place, by_width = [], [], []
    for axis in (0, 1):
        z = (edges - centre[..., axis : axis + 1]) / width
        density = np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi)
        profile.append(np.diff(ndtr(z)))
        by_place.append(-np.diff(density) / width)
        by_width.append(-np.diff(z * density) / width)
    (x, y), (dx, dy), (wx, wy) = profile, by_place, by_width

    def outer(rows: Array, columns: Array) -> Array:
        return rows[..., :, None] * columns[..., None, :]

    return outer(y, x), outer(y, dx), outer(dy, x), outer(wy, x) + outer(y, wx)


def speckled_centroids(
    sensor: Sensor,
    *,
    width: float,
    draws: int,
    rng: np.random.Generator,
    polarisations: int = 1,
    side: int = 192,
    finer: int = 4,
) -> Array:
    """Centroids (draws, 2), px, of spots with fully developed speckle, from the wave itself.

    A Gaussian spot of random phase is imaged through the round aperture of the lens; independent
    polarisations add in intensity. Noise-free: what is left is speckle alone.

    Parameters
    ----------
    sensor : Sensor
    width : float
        Standard deviation of the spot's intensity in the image, px.
    draws : int
    rng : Generator
    polarisations : int
        1, or 2 for a contrast of 1 / sqrt 2.
    side, finer : int
        Of the simulated patch, samples; samples a pixel. A sample must resolve half a speckle.

    Raises
    ------
    ValueError
        If the patch is too small for the spot, or its samples too coarse for the aperture.
    """
    cutoff = sensor.pitch / finer / (2 * LASER_WAVELENGTH * sensor.f_number)  # cycles a sample
    if cutoff > 0.25 or side < 8 * width * finer:
        raise ValueError(
            f"Expected samples that resolve the speckle and a patch of 8 widths, got a cutoff of "
            f"{cutoff:.2f} cycles a sample and {side} samples. Sample finer."
        )
    place = (np.arange(side) - (side - 1) / 2) / finer
    envelope = np.exp(-(place[:, None] ** 2 + place**2) / (4 * width**2))
    frequency = np.fft.fftfreq(side)
    passed = np.hypot(frequency[:, None], frequency) <= cutoff
    found = np.empty((draws, 2))
    for i in range(draws):
        noise = rng.standard_normal((2, polarisations, side, side))
        wave = np.fft.ifft2(np.fft.fft2(envelope * (noise[0] + 1j * noise[1])) * passed)
        light = (np.abs(wave) ** 2).sum(axis=0)
        found[i] = (light.sum(0) @ place, light.sum(1) @ place) / light.sum()
    return found
