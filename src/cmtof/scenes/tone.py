"""Light for eyes and back: brightness, Hypersim's tone map, and linear light of sRGB images."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

GAMMA = 2.2


def brightness(color: ArrayLike) -> NDArray[np.floating]:
    """Linear brightness 0.3 R + 0.59 G + 0.11 B (...) of colours (..., 3)."""
    color = np.asarray(color)
    return color @ np.array([0.3, 0.59, 0.11], color.dtype)


def tone_mapped(color: ArrayLike, valid: ArrayLike | None = None) -> NDArray[np.floating]:
    """Hypersim's tone map, ``(0.8^2.2 / P90 * color)^(1/2.2)`` clipped to 0...1, for showing.

    P90 is the 90th percentile of brightness over the valid pixels; it is shown at 0.8. An image
    darker than 1e-4 is shown black.

    Parameters
    ----------
    color : array_like, shape (H, W, 3)
        Linear radiance.
    valid : array_like of bool, shape (H, W), optional
        Pixels that show a surface; all by default.

    Examples
    --------
    >>> tone_mapped(np.full((2, 2, 3), 7.0))[0, 0].round(3).tolist()
    [0.8, 0.8, 0.8]
    """
    color = np.asarray(color)
    light = brightness(color)[... if valid is None else np.asarray(valid, bool)]
    reference = float(np.percentile(light, 90)) if light.size else 1.0
    scale = 0.8**GAMMA / reference if reference >= 1e-4 else 0.0
    return np.clip(scale * np.maximum(color, 0), 0, 1) ** (1 / GAMMA)


def linear_from_srgb(pixels: ArrayLike) -> NDArray[np.float64]:
    """Linear light, 0...1, of sRGB levels (8 or 16 bits; IEC 61966-2-1).

    Examples
    --------
    >>> linear_from_srgb(np.array([0, 188, 255], np.uint8)).round(3).tolist()
    [0.0, 0.503, 1.0]
    """
    levels = np.asarray(pixels)
    encoded = levels / np.iinfo(levels.dtype).max
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
