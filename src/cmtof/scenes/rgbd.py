"""RGB-D frames: depth along the ray and linear intensity, and the one door to load them."""

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


def load_frame(
    source: str | Path,
    *,
    intensity: str | Path | None = None,
    depth_scale: float | None = None,
    planar: bool = False,
    camera: ArrayLike | None = None,
    smooth: bool = False,
) -> Frame:
    """Load a frame by file, by the name of an embedded one, or the first of a folder.

    Parameters
    ----------
    source : str or Path
        An ``.npz`` with ``depth`` (m), ``intensity`` and optionally ``camera``; a 16-bit depth
        ``.png``; a Hypersim depth file ``frame.IIII.depth_meters.hdf5`` in its tree; a name out of
        `embedded_frames`; or a folder that `cmtof.scenes.folders.frames_in` knows, whose first
        frame is taken (of a Hypersim tree the first test frame; ``name`` says which).
    intensity : str or Path, optional
        Image that belongs to a depth PNG; its green channel is made linear (sRGB).
    depth_scale : float, optional
        PNG levels per metre (1000 for NYU and ScanNet style, 5000 for TUM style). By default 1000,
        in folders that of the style.
    planar : bool
        True if the PNG holds depth along the optical axis, to be turned into range along the ray;
        needs ``camera``. Folders of a known style need not be told.
    camera : array_like, shape (4,) or (5,), optional
        fx, fy, cx, cy, px, and the skew where there is one.
    smooth : bool
        Smooth float16 depth within its own steps.

    Returns
    -------
    Frame
        Its ``note`` says what a user should know, such as float16 depth or a missing colour file.

    Raises
    ------
    FileNotFoundError, ValueError
        If a file is missing, cut short or of another kind.
    """
    known = embedded_frames()
    path = known.get(str(source), Path(source))
    if path.is_dir():
        from cmtof.scenes.folders import frames_in

        style = {"depth_scale": depth_scale, "planar": planar or None, "camera": camera}
        return frames_in(path, smooth=smooth, blank=True, **style)[0].load()
    if not path.is_file():
        raise FileNotFoundError(
            f"Expected a frame file or one of {', '.join(known)}, got {source}. Check the name."
        )
    if path.suffix == ".hdf5":
        from cmtof.scenes.hypersim import view_of_file

        return view_of_file(path).frame(smooth=smooth, blank=True)
    if path.suffix == ".png":
        from cmtof.scenes.png import frame_from_pair

        scale = 1000.0 if depth_scale is None else depth_scale
        return frame_from_pair(path, intensity, depth_scale=scale, planar=planar, camera=camera)
    if path.suffix != ".npz":
        raise ValueError(
            f"Expected a frame named *.npz, *.png or *.depth_meters.hdf5, got {path.name}. "
            "Convert it."
        )
    return _load_npz(path, camera)


def _load_npz(path: Path, camera: ArrayLike | None) -> Frame:
    arrays = read_npz(path)
    if not {"depth", "intensity"} <= arrays.keys():
        raise ValueError(
            f"Expected arrays depth and intensity in {path}, got {sorted(arrays)}. Add them."
        )
    stored = arrays.get("camera") if camera is None else np.asarray(camera, float)
    note = str(arrays.get("note", ""))
    return Frame(arrays["depth"], arrays["intensity"], stored, path.stem, note)


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
