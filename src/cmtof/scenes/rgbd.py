"""RGB-D frames: depth along the ray and linear intensity, from ``.npz`` or a pair of PNGs."""

from dataclasses import dataclass
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
    camera : ndarray, shape (4,), optional
        fx, fy, cx, cy, px, pixel centres at +0.5.
    name : str
        Where it came from.

    Raises
    ------
    ValueError
        If shapes differ, no pixel has a depth, or intensities are negative or not finite.
    """

    depth: NDArray[np.floating]
    intensity: NDArray[np.floating]
    camera: NDArray[np.floating] | None = None
    name: str = ""

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
        object.__setattr__(self, "depth", depth)
        object.__setattr__(self, "intensity", intensity)

    def save(self, path: str | Path) -> None:
        """Write a compressed ``.npz`` (float32)."""
        from cmtof.files import written_whole

        arrays: dict[str, Any] = {"depth": self.depth, "intensity": self.intensity}
        if self.camera is not None:
            arrays["camera"] = np.asarray(self.camera, float)
        with written_whole(path) as part:
            np.savez_compressed(part, **arrays)


def embedded_frames() -> dict[str, Path]:
    """Names and files of the frames that travel with the package."""
    return {path.stem: path for path in sorted(EMBEDDED.glob("*.npz"))}


def load_frame(
    source: str | Path,
    *,
    intensity: str | Path | None = None,
    depth_scale: float = 1000.0,
    planar: bool = False,
    camera: ArrayLike | None = None,
) -> Frame:
    """Load a frame by file or by the name of an embedded one.

    Parameters
    ----------
    source : str or Path
        An ``.npz`` with ``depth`` (m), ``intensity`` and optionally ``camera``; a 16-bit depth
        ``.png``; or a name out of `embedded_frames`.
    intensity : str or Path, optional
        PNG that belongs to a depth PNG; its green channel is made linear (sRGB).
    depth_scale : float
        PNG levels per metre (1000 for NYU and ScanNet style, 5000 for TUM style).
    planar : bool
        True if the PNG holds depth along the optical axis, to be turned into range along the ray;
        needs ``camera``.
    camera : array_like, shape (4,), optional
        fx, fy, cx, cy, px.

    Raises
    ------
    FileNotFoundError, ValueError
        If a file is missing, cut short or of another kind.
    """
    known = embedded_frames()
    path = known.get(str(source), Path(source))
    if not path.is_file():
        raise FileNotFoundError(
            f"Expected a frame file or one of {', '.join(known)}, got {source}. Check the name."
        )
    if path.suffix == ".png":
        return _load_png(path, intensity, depth_scale, planar, camera)
    if path.suffix != ".npz":
        raise ValueError(f"Expected a frame named *.npz or *.png, got {path.name}. Convert it.")
    arrays = read_npz(path)
    if not {"depth", "intensity"} <= arrays.keys():
        raise ValueError(
            f"Expected arrays depth and intensity in {path}, got {sorted(arrays)}. Add them."
        )
    stored = arrays.get("camera") if camera is None else np.asarray(camera, float)
    return Frame(arrays["depth"], arrays["intensity"], stored, path.stem)


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


def _load_png(
    path: Path,
    intensity: str | Path | None,
    depth_scale: float,
    planar: bool,
    camera: ArrayLike | None,
) -> Frame:
    if intensity is None:
        raise ValueError(
            f"Expected an intensity image beside the depth image {path.name}, got none. Name it."
        )
    if not depth_scale > 0:
        raise ValueError(
            f"Expected a depth scale > 0 levels per metre, got {depth_scale}. "
            "Common ones are 1000 and 5000."
        )
    depth = read_png(path).astype(np.float64) / depth_scale
    green = read_png(Path(intensity))
    green = green[..., 1] if green.ndim == 3 else green
    encoded = green / np.iinfo(green.dtype).max
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    if planar:
        if camera is None:
            raise ValueError(
                "Expected camera fx fy cx cy to turn planar depth into range, got none. Give it."
            )
        depth = depth * ray_lengths(depth.shape, camera)
    return Frame(depth, linear, None if camera is None else np.asarray(camera, float), path.stem)


def read_png(path: Path) -> NDArray:
    """Read a PNG of 8 or 16 bits as it is, (H, W) or (H, W, channels)."""
    from PIL import Image

    try:
        with Image.open(path) as image:
            pixels = np.asarray(image)
    except (OSError, SyntaxError) as error:
        raise ValueError(f"Expected a PNG image, got {path} ({error}). Check the file.") from error
    # Pillow opens some 16-bit greys as 32-bit integers
    return pixels.astype(np.uint16) if pixels.dtype == np.int32 else pixels


def rays_from_camera(shape: tuple[int, ...], camera: ArrayLike) -> NDArray[np.float64]:
    """Rays (H, W, 3) through the pixel centres, x right, y down, z = 1."""
    fx, fy, cx, cy = np.asarray(camera, float)
    v, u = np.indices(shape[:2]) + 0.5
    return np.stack([(u - cx) / fx, (v - cy) / fy, np.ones(shape[:2])], axis=-1)


def ray_lengths(shape: tuple[int, ...], camera: ArrayLike) -> NDArray[np.float64]:
    """Range along the ray per planar depth, (H, W): the length of each ray with z = 1."""
    return np.linalg.norm(rays_from_camera(shape, camera), axis=-1)
