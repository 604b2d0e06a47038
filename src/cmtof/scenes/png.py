"""Frames from a depth image and the colour image that belongs to it."""

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.scenes.rgbd import Frame, ray_lengths
from cmtof.scenes.tone import linear_from_srgb

_SIDES = 0.02  # relative difference of aspect ratios that a crop of sensors explains


def frame_from_pair(
    depth: Path,
    intensity: str | Path | None,
    *,
    depth_scale: float = 1000.0,
    planar: bool = False,
    camera: ArrayLike | None = None,
    name: str | None = None,
    note: str = "",
) -> Frame:
    """Load a 16-bit depth image and its colour or grey image.

    Parameters
    ----------
    depth : Path
        Levels of depth; 0 where there is none.
    intensity : str or Path
        PNG or JPEG; its green channel is made linear (sRGB). If its size differs from the depth
        image's it is averaged onto that grid; the two must show the same field of view.
    depth_scale : float
        Levels per metre.
    planar : bool
        True if depth is along the optical axis, to be turned into range along the ray.
    camera : array_like, shape (4,) or (5,), optional
        fx, fy, cx, cy, px, and a skew; needed if ``planar``.
    name, note : str, optional
        Of the frame.

    Raises
    ------
    ValueError
        If something is missing, no image, or of another field of view.
    """
    if intensity is None:
        raise ValueError(
            f"Expected an intensity image beside the depth image {depth.name}, got none. Name it."
        )
    if not depth_scale > 0:
        raise ValueError(
            f"Expected a depth scale > 0 levels per metre, got {depth_scale}. "
            "Common ones are 1000 and 5000."
        )
    levels = read_image(depth)
    if levels.ndim != 2:
        raise ValueError(
            f"Expected one channel of depth in {depth}, got {levels.shape[-1]}. Name the depth "
            "image first."
        )
    distance = levels.astype(np.float64) / depth_scale
    green = read_image(Path(intensity))
    green = green[..., 1] if green.ndim == 3 and green.shape[-1] > 2 else green
    linear = on_grid(linear_from_srgb(green[..., 0] if green.ndim == 3 else green), levels.shape)
    if planar:
        if camera is None:
            raise ValueError(
                f"Expected camera fx fy cx cy to turn planar depth of {depth.name} into range, "
                "got none. Give it."
            )
        distance = distance * ray_lengths(distance.shape, camera)
    return Frame(distance, linear, _numbers(camera), depth.stem if name is None else name, note)


def read_image(path: Path) -> NDArray:
    """Read a PNG of 8 or 16 bits, or a JPEG, as it is: (H, W) or (H, W, channels)."""
    from PIL import Image

    try:
        with Image.open(path) as image:
            # palettes hold colour numbers, not levels
            pixels = np.asarray(image.convert("RGB") if image.mode == "P" else image)
    except (OSError, SyntaxError) as error:
        raise ValueError(
            f"Expected a PNG image (or JPEG for colour), got {path} ({error}). Check the file."
        ) from error
    # Pillow opens some 16-bit greys as 32-bit integers
    return pixels.astype(np.uint16) if pixels.dtype == np.int32 else pixels


def on_grid(image: NDArray[np.floating], shape: tuple[int, ...]) -> NDArray[np.floating]:
    """Average a linear image (H', W') onto a grid (H, W) of the same field of view.

    Examples
    --------
    >>> on_grid(np.array([[0.0, 1.0], [1.0, 1.0]]), (1, 1)).tolist()
    [[0.75]]
    """
    from PIL import Image

    if image.shape == shape:
        return image
    stretch = (image.shape[0] * shape[1]) / (image.shape[1] * shape[0])
    if abs(stretch - 1) > _SIDES:
        raise ValueError(
            f"Expected an intensity image with the sides of the depth image {shape}, got "
            f"{image.shape}. Crop or register it to the depth image."
        )
    scaled = Image.fromarray(image.astype(np.float32)).resize(
        (shape[1], shape[0]), Image.Resampling.BOX
    )
    return np.asarray(scaled).clip(0, 1)


def _numbers(camera: ArrayLike | None) -> NDArray[np.float64] | None:
    return None if camera is None else np.asarray(camera, float)
