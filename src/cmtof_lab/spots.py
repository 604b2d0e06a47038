"""The laser's spot in a camera: its light, its noise, and where its centre is found."""

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from scipy.special import ndtr

from cmtof.constants import LASER_WAVELENGTH
from cmtof.types import Array, Arrays, Shape

WINDOW = 11  # side of the window in which a spot is placed, px
WEIGHT = 1.3  # standard deviation of the weight of its centroid, px


@dataclass(frozen=True)
class Sensor:
    """Camera, lens and laser spot, the pixel of Sony's IMX252 (assumed)."""

    shape: Shape = (1536, 2048)  # height and width, px
    pitch: float = 3.45e-6  # m
    focal_length: float = 8e-3  # m (Sec. 6.4)
    f_number: float = 4.0  # assumed
    full_well: float = 10_700.0  # electrons
    read_noise: float = 2.9  # electrons
    ambient: float = 5.0  # electrons of other light in a pixel (assumed)
    beam: float = 0.6e-3  # standard deviation of the spot on a surface, m (assumed)
    blur: float = 0.8  # standard deviation of the lens's blur, px (assumed)
    contrast: float = 0.7071  # of speckle on a surface that depolarises (assumed)

    @property
    def speckle(self) -> float:
        r"""Deviation, px, of a centroid by speckle of contrast C: C lambda N / (sqrt(2) pi pitch).

        (Dorsch, Haeusler and Herrmann, Applied Optics 33, 1306, 1994, found this limit.)
        """
        grain = LASER_WAVELENGTH * self.f_number / self.pitch
        return self.contrast * grain / (np.sqrt(2) * np.pi)


SENSOR = Sensor()


def photographed_spots(
    true: Array,
    rate: Array,
    width: Array,
    rng: Generator,
    sensor: Sensor,
) -> Array:
    """Windows (N, S, S) of spots at ``true``, px, in electrons less the room's light."""
    away = np.arange(WINDOW + 1) - true[..., None]
    shares = np.diff(ndtr(away / width[:, None, None]), axis=-1)
    across, down = np.moveaxis(shares, 1, 0)
    mean = rate[:, None, None] * down[..., None] * across[:, None]
    mean += sensor.ambient
    drawn = rng.poisson(mean) + sensor.read_noise * rng.standard_normal(mean.shape)
    return np.minimum(drawn, sensor.full_well) - sensor.ambient


def place_spots(light: Array, sensor: Sensor) -> Arrays:
    r"""Centres (N, 2) and their standard deviations (N,), px, of spots in windows (N, S, S).

    The centroid under a Gaussian weight w of width s that moves with it (XWIN of SExtractor):

    .. math:: x \leftarrow x + 2\frac{\sum w I (u - x)}{\sum w I}, \qquad
              \sigma_x = \frac{\sqrt{\sum w^2 (u - x)^2 v}}{\sum w I\,(1 - (u - x)^2/s^2)}.

    Electrons of variance v; speckle adds to sigma. NaN: saturated, below six deviations, 2 px off.
    """
    middle = light.shape[-1] / 2
    centre = np.full((2, len(light)), middle)
    for _ in range(12):
        off = np.arange(light.shape[-1]) + 0.5 - centre[..., None]
        near = np.exp(-(off**2) / 2 / WEIGHT**2)
        weight = near[1, ..., None] * near[0, :, None]
        lit = weight * light
        total = lit.sum((1, 2)).clip(1e-9)
        pull = np.vecdot([lit.sum(1), lit.sum(2)], off)
        centre += (2 * pull / total).clip(-1, 1)
    noise = light.clip(0) + sensor.ambient + sensor.read_noise**2
    noise *= weight**2  # pyright: ignore[reportPossiblyUnboundVariable]
    off = off[0] ** 2  # pyright: ignore[reportPossiblyUnboundVariable]
    sigma = np.sqrt(np.vecdot(noise.sum(1), off))
    sigma /= np.vecdot(lit.sum(1), 1 - off / WEIGHT**2).clip(1e-9)  # pyright: ignore[reportPossiblyUnboundVariable]
    lost = total < 6 * np.sqrt(noise.sum((1, 2)))  # pyright: ignore[reportPossiblyUnboundVariable]
    lost |= (abs(centre - middle) > 2).any(0)
    lost |= light.max((1, 2)) >= sensor.full_well - sensor.ambient
    sigma = np.where(lost, np.nan, np.hypot(sigma, sensor.speckle))
    return np.where(lost, np.nan, centre).T, sigma
