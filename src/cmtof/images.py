"""Frames of image files: an image of depth, in levels or metres, and one of light."""

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.files import AnyPath, check_input, reading
from cmtof.frame import Frame, light_note, ray_lengths
from cmtof.types import Array

# Suffixes that `read_image` reads; only PNG, PGM, PFM and NPY hold depth.
READ = (".png", ".pgm", ".jpg", ".jpeg", ".pfm", ".npy")

# Levels per metre of a depth image whose scale is not given.
LEVELS = 1000.0

_ROTATED = 8  # SUN RGB-D moves the lowest three bits of a level to its top
_CROWDED = 0.02  # share of pixels at the largest level from which on it seems to mean «unknown»
_ALIKE = 0.03  # by how much the shapes of two images of one view may differ


def frame_from_pair(
    depth: Path,
    intensity: AnyPath | None,
    *,
    depth_scale: float | None = None,
    planar: bool = False,
    camera: ArrayLike | None = None,
    linear: bool = False,
) -> Frame:
    """Frame of an image of depth and the colour or grey image of the same view.

    ``depth_scale`` is in levels per metre; without it, it is 1 for floats and `LEVELS` for
    integers. Level 0 is no depth, nor is the greatest one that 16 bits hold. ``planar`` depth,
    along the optical axis, is turned into range by the ``camera`` fx, fy, cx, cy, px. The green
    channel of integers is made linear, floats are linear already; with ``linear`` either is taken
    as it is, and its 99th percentile becomes 1.
    """
    wrong = depth_scale is not None and not 0 < depth_scale < np.inf
    if intensity is None or wrong or (planar and camera is None):
        raise ValueError(
            "Expected an intensity image beside depth, a depth scale > 0, and for planar depth a "
            f"camera, got {intensity}, {depth_scale}, {camera} for {depth.name}. "
            "Give what is missing."
        )
    levels = read_image(depth)
    image = read_image(Path(intensity))
    if levels.ndim != 2 or image.ndim not in (2, 3):
        raise ValueError(
            f"Expected one channel of depth in {depth} and an image of light, "
            f"got shapes {levels.shape} and {image.shape}. Name depth first."
        )
    distance, notes = depth_from_levels(levels, depth_scale)
    if not planar:
        notes.append("depth taken along the ray")
    else:
        distance = distance * ray_lengths(distance.shape, camera)  # type: ignore[arg-type]
    light, note = resample(image, distance.shape)
    light = brightness_of(light, linear)
    text = "; ".join(filter(None, [*notes, note, light_note(light)]))
    return Frame(distance, light, camera, depth.stem, text)  # pyright: ignore[reportArgumentType]


def read_image(path: Path) -> NDArray:
    """Pixels of an image as stored: (H, W) or (H, W, channels)."""
    from PIL import Image

    suffix = path.suffix.lower()
    if suffix == ".exr":
        raise ValueError(
            f"Expected an image out of {', '.join(READ)}, got {path.name}. "
            "Convert it: numpy.save('depth.npy', imageio.v3.imread(…)[..., 0])."
        )
    with reading("a PNG image (or JPEG for colour)", path):
        if suffix == ".npy":
            return np.array(
                np.load(check_input(path), mmap_mode="r", allow_pickle=False)
            )
        with Image.open(check_input(path)) as image:
            for codec, *_, how in image.tile:
                # of others Pillow would stretch the levels
                if codec.startswith("ppm") and how[-1] not in (255, 65535):  # pyright: ignore[reportOptionalSubscript]
                    raise ValueError("its largest level is neither 255 nor 65535")
            # palettes hold colour numbers, not levels
            pixels = np.asarray(
                image.convert("RGB") if image.mode in ("P", "1", "CMYK") else image
            )
    # Pillow opens some 16-bit greys as 32-bit integers
    return pixels.astype(np.uint16) if pixels.dtype == np.int32 else pixels


def depth_from_levels(levels: NDArray, scale: float | None) -> tuple[Array, list[str]]:
    """Depth (H, W), m, of pixel values, NaN where integers mean «unknown»; notes on doubts."""
    if levels.dtype.kind == "f":
        return levels / (scale or 1.0), []
    notes = (
        []
        if scale
        else [f"depth read at {LEVELS:g} levels a metre, for want of a scale"]
    )
    known = levels > 0
    if levels.dtype == np.uint16 and (full := levels == 65535).any():
        known &= ~full
        notes.append(
            f"{full.mean():.1%} of the depths are at level 65535, taken as unknown"
        )
    known_levels = levels[known]
    if known_levels.size and np.ptp(known_levels):
        share = (known_levels == known_levels.max()).mean()
        if share > _CROWDED:
            notes.append(
                f"{share:.1%} of the depths are at the largest level, {known_levels.max()}"
            )
        if (known_levels % _ROTATED == 0).mean() > 0.95 and np.unique(
            known_levels
        ).size > _ROTATED:
            notes.append(
                f"all levels are multiples of {_ROTATED}: if these are SUN RGB-D's rotated bits, "
                f"give the scale {_ROTATED * 1000}"
            )
    return np.where(known, levels / (scale or LEVELS), np.nan), notes


def resample(image: NDArray, shape: tuple[int, ...]) -> tuple[NDArray, str]:
    """The image resampled to ``shape`` (H, W), but as it is if proportions differ; a note on it."""
    height, width = image.shape[:2]
    if (height, width) == shape or abs(
        height * shape[1] / (width * shape[0]) - 1
    ) > _ALIKE:
        return image, ""  # a frame refuses images of different shapes
    pairs = zip(shape, (height, width), strict=True)
    place = [((np.arange(n) + 0.5) * m / n).astype(int) for n, m in pairs]
    note = f"light resampled from {height}x{width} to {shape[0]}x{shape[1]} px"
    return image[np.ix_(*place)], note


def brightness_of(image: NDArray, linear: bool) -> Array:
    """Linear brightness (H, W) of an image: its green channel, or its grey, without gamma."""
    green = image if image.ndim == 2 else image[..., 1 if image.shape[-1] > 2 else 0]
    if linear:
        return green / (np.percentile(green + 0.0, 99) or 1.0)
    if green.dtype.kind == "f":
        return green.astype(float)
    if green.dtype not in (np.uint8, np.uint16):
        raise ValueError(
            f"Expected light of 8 or 16 bits or floats, got {green.dtype}. Convert it, or read it "
            "as linear."
        )
    encoded = green / np.iinfo(green.dtype).max  # sRGB, IEC 61966-2-1
    return np.where(
        encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4
    )
