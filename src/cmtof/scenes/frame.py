"""RGB-D frames: depth along the ray and linear intensity."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

EMBEDDED = Path(__file__).parents[1] / "frames"
"""Folder of the small frames that travel with the package."""


@dataclass(frozen=True)
class Frame:
    """One view of a scene.

    Attributes
    ----------
    depth : ndarray of float32, shape (H, W)
        Range along the ray, m; NaN where invalid.
    intensity : ndarray of float32, shape (H, W)
        Linear radiance >= 0; the simulator clips it to 1.
    camera : ndarray, shape (4,) or (5,), optional
        fx, fy, cx, cy, px, pixel centres at +0.5, and the skew where there is one.
    name : str
        Where it came from.
    note : str
        What was done to it, or is missing, that a user should know; empty if nothing.

    Raises
    ------
    ValueError
        If shapes differ, no pixel has a depth, intensities are negative or not finite, or the
        camera is none.
    """

    depth: NDArray[np.floating]
    intensity: NDArray[np.floating]
    camera: NDArray[np.floating] | None = None
    name: str = ""
    note: str = ""

    def __post_init__(self) -> None:
        depth = np.array(self.depth, np.float32)
        intensity = np.array(self.intensity, np.float32)
        if depth.ndim != 2 or depth.shape != intensity.shape or depth.size == 0:
            raise ValueError(
                f"Expected depth and intensity of one shape (H, W), got {depth.shape} and "
                f"{intensity.shape} in {self.name or 'the frame'}. Resample one of them."
            )
        depth[~(np.isfinite(depth) & (depth > 0))] = np.nan
        if np.isnan(depth).all():
            raise ValueError(
                f"Expected depths in metres, got none above 0 in {self.name or 'the frame'}. "
                "Check the depth scale."
            )
        if not (np.isfinite(intensity).all() and intensity.min() >= 0):
            raise ValueError(
                f"Expected finite intensities >= 0, got some that are not in "
                f"{self.name or 'the frame'}. Use linear radiance and fill its holes with 0."
            )
        if self.camera is not None:
            object.__setattr__(self, "camera", _checked_camera(self.camera, self.name))
        object.__setattr__(self, "depth", depth)
        object.__setattr__(self, "intensity", intensity)

    def save(self, path: str | Path) -> None:
        """Write a compressed ``.npz`` (float32)."""
        from cmtof.files import written_whole

        arrays: dict[str, Any] = {"depth": self.depth, "intensity": self.intensity}
        if self.camera is not None:
            arrays["camera"] = np.asarray(self.camera, float)
        if self.note:
            arrays["note"] = np.array(self.note)
        with written_whole(path) as part:
            np.savez_compressed(part, **arrays)


def _checked_camera(camera: ArrayLike, name: str) -> NDArray[np.float64]:
    numbers = np.asarray(camera, float)
    known = numbers.shape in ((4,), (5,)) and bool(np.isfinite(numbers).all())
    if not known or not (numbers[:2] > 0).all():
        raise ValueError(
            f"Expected camera fx fy cx cy, px, with fx, fy > 0 (and a skew where there is one), "
            f"got {numbers.tolist()} in {name or 'the frame'}. Correct it."
        )
    return numbers


def embedded_frames() -> dict[str, Path]:
    """Names and files of the frames that travel with the package."""
    return {path.stem: path for path in sorted(EMBEDDED.glob("*.npz"))}


def read_npz(path: Path) -> dict[str, NDArray]:
    """Read every array of an ``.npz``, never a pickle; one ValueError for whatever is wrong."""
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}
    except Exception as error:  # zipfile, zlib and numpy raise half a dozen kinds
        reason = (str(error).splitlines() or [type(error).__name__])[0][:120]
        raise ValueError(
            f"Expected a whole .npz file, got {path} ({reason}). Write it anew."
        ) from error


def rays_from_camera(shape: tuple[int, ...], camera: ArrayLike) -> NDArray[np.float64]:
    """Rays (H, W, 3) through the pixel centres, x right, y down, z = 1.

    Parameters
    ----------
    shape : (int, int)
        H, W.
    camera : array_like, shape (4,) or (5,)
        fx, fy, cx, cy, px, and the skew s: column u = fx x + s y + cx, row v = fy y + cy.
    """
    fx, fy, cx, cy, *skew = np.asarray(camera, float)
    v, u = np.indices(shape[:2]) + 0.5
    y = (v - cy) / fy
    x = (u - cx - sum(skew) * y) / fx
    return np.stack([x, y, np.ones(shape[:2])], axis=-1)


def ray_lengths(shape: tuple[int, ...], camera: ArrayLike) -> NDArray[np.float64]:
    """Range along the ray per planar depth, (H, W): the length of each ray with z = 1.

    Parameters as in `rays_from_camera`.
    """
    return np.linalg.norm(rays_from_camera(shape, camera), axis=-1)


@dataclass(frozen=True)
class Source:
    """A frame that can be loaded.

    Attributes
    ----------
    name : str
        Which frame it is.
    load : callable
        Loads it; raises ValueError or OSError where it is broken or missing.
    """

    name: str
    load: Callable[[], Frame]


@dataclass
class Frames:
    """Frames of some sources in their order, those left out that cannot be loaded.

    Attributes
    ----------
    sources : iterable of Source
    skipped : dict
        Name and reason of each frame that was left out since the latest start.

    Examples
    --------
    >>> def broken() -> Frame:
    ...     raise ValueError("Expected a whole file, got a part. Fetch it anew.")
    >>> good = Source("good", lambda: Frame([[1.0]], [[0.5]], name="good"))
    >>> frames = Frames([good, Source("bad", broken)])
    >>> [frame.name for frame in frames], frames.skipped
    (['good'], {'bad': 'Expected a whole file, got a part. Fetch it anew.'})
    """

    sources: Iterable[Source]
    skipped: dict[str, str] = field(default_factory=dict)

    def __iter__(self) -> Iterator[Frame]:
        self.skipped.clear()
        for source in self.sources:
            try:
                frame = source.load()
            except (ValueError, OSError) as error:
                self.skipped[source.name] = str(error)
                continue
            yield frame


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
