"""RGB-D frames: range along the ray, linear intensity, and the camera that saw them."""

import zipfile
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.files import check_input, written_whole
from cmtof.validation import check_claim, expect, numbers

EMBEDDED = Path(__file__).parent / "frames"  # the small frames that travel with the package
HELD_OUT = EMBEDDED / "test" / "rooms.npz"  # views of rooms that nothing was trained on
HELD_OUT_STEP = 5e-5  # step of its depth, m


@dataclass(frozen=True)
class Frame:
    """One view of a scene; a ValueError says what is no number or no possible scene."""

    depth: NDArray[np.floating]  # range along the ray (H, W), m, float32; NaN where invalid
    intensity: NDArray[np.floating]  # linear radiance (H, W) >= 0, clipped to 1 by the simulator
    camera: NDArray[np.floating] | None = None  # fx, fy, cx, cy, px (centres at +0.5), and skew
    name: str = ""  # source of the frame
    note: str = ""  # what a user should know of it

    def __post_init__(self) -> None:
        where, camera = self.name or "the frame", self.camera
        depth = numbers(self.depth, f"depth of {where}", np.float32)
        light = numbers(self.intensity, f"intensity of {where}", np.float32)
        alike = depth.ndim == 2 and depth.shape == light.shape and depth.size
        got = f"{depth.shape} and {light.shape} in {where}"
        expect(alike, "depth and intensity of one shape (H, W)", got, "Resample one of them.")
        depth[~(np.isfinite(depth) & (depth > 0))] = np.nan
        held, got = not np.isnan(depth).all(), f"none above 0 in {where}"
        expect(held, "depths in metres", got, "Check the depth scale.")
        bright, got = np.isfinite(light).all() and light.min() >= 0, f"others in {where}"
        expect(bright, "finite intensities >= 0", got, "Fill its holes with 0.")
        if camera is not None:
            camera = numbers(camera, f"camera of {where}")
            known = camera.shape in ((4,), (5,)) and np.isfinite(camera).all()
            what = f"camera fx fy cx cy (skew), px, with fx, fy > 0, in {where}"
            expect(known and (camera[:2] > 0).all(), what, camera.tolist(), "Correct it.")
        vars(self).update(depth=depth, intensity=light, camera=camera)

    def save(self, path: str | Path) -> None:
        """Write a compressed ``.npz`` (float32)."""
        arrays = {"depth": self.depth, "intensity": self.intensity, "camera": self.camera}
        arrays["note"] = np.array(self.note) if self.note else None
        with written_whole(path) as part:
            np.savez_compressed(part, **{k: v for k, v in arrays.items() if v is not None})

    def middle(self, height: int, width: int) -> "Frame":
        """Middle of the frame, at most that large; the camera moves with it."""
        top = max(0, (self.depth.shape[0] - height) // 2)
        left = max(0, (self.depth.shape[1] - width) // 2)
        part, camera = np.s_[top : top + height, left : left + width], self.camera
        if camera is not None:
            camera = camera - [0, 0, left, top, 0][: len(camera)]
        return Frame(self.depth[part], self.intensity[part], camera, self.name, self.note)


class Source(NamedTuple):
    """A frame that can be loaded; ``load`` raises ValueError or OSError where it is broken."""

    name: str
    load: Callable[[], Frame]


@dataclass
class Frames:
    """Frames of some sources; ``skipped`` holds name and reason of those that do not load."""

    sources: Iterable[Source]
    skipped: dict[str, str] = field(default_factory=dict)

    def __iter__(self) -> Iterator[Frame]:
        self.skipped.clear()
        for source in self.sources:
            try:
                yield source.load()
            except (ValueError, OSError) as error:
                self.skipped[source.name] = str(error)


def embedded_frames() -> dict[str, Path]:
    """Names and files of the frames that travel with the package."""
    return {path.stem: path for path in sorted(EMBEDDED.glob("*.npz"))}


def held_out_frames(path: Path = HELD_OUT) -> list[Frame]:
    """The test set of Tables 1 to 3: 32 views of 384 x 512 px, chosen by `cmtof_book.frames`."""
    arrays = read_npz(path)  # second differences of depth along rows, first ones of √I in bytes
    steps = arrays["depth"].cumsum(axis=2, dtype=np.int32).cumsum(axis=2, dtype=np.int32)
    levels = arrays["intensity"].cumsum(axis=2, dtype=np.uint8)
    light = (levels / np.float32(255)) ** 2
    views = zip(steps * HELD_OUT_STEP, light, arrays["camera"], arrays["name"], strict=True)
    return [Frame(depth, one, camera, str(name)) for depth, one, camera, name in views]


def broken(expected: str, path: Path, error: Exception) -> ValueError:
    """The one error, of one line, for whatever is wrong with a file."""
    reason = (str(error).splitlines() or [type(error).__name__])[0][:120]
    return ValueError(f"Expected {expected}, got {path} ({reason}). Fetch or write it again.")


def read_npz(path: Path) -> dict[str, NDArray]:
    """Every array of an ``.npz``, never a pickle; one ValueError for whatever is wrong."""
    try:
        with zipfile.ZipFile(check_input(path)) as archive:
            for member in archive.infolist():
                check_claim(member.file_size, member.compress_size)
        with np.load(path, allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}
    except Exception as error:  # zipfile, zlib and numpy raise half a dozen kinds
        raise broken("a whole .npz file", path, error) from error


def frame_from_npz(path: Path, camera: ArrayLike | None = None) -> Frame:
    """Frame of an ``.npz`` with ``depth``, ``intensity`` and, unless given, ``camera``."""
    arrays = read_npz(path)
    held = {"depth", "intensity"} <= arrays.keys()
    expect(held, f"arrays depth and intensity in {path}", sorted(arrays), "Add them.")
    stored, note = arrays.get("camera") if camera is None else camera, arrays.get("note", "")
    return Frame(arrays["depth"], arrays["intensity"], stored, path.stem, str(note))


def frame_from_pair(
    depth: Path,
    intensity: str | Path | None,
    *,
    depth_scale: float = 1000.0,
    planar: bool = False,
    camera: ArrayLike | None = None,
) -> Frame:
    """Frame of a 16-bit depth image and the colour or grey image (PNG or JPEG) of its size.

    ``depth_scale`` are levels per metre, level 0 is no depth. ``planar`` depth, along the optical
    axis, is turned into range by the ``camera``. The green channel is made linear.
    """
    if intensity is None or (planar and camera is None) or not 0 < depth_scale < np.inf:
        what = "an intensity image beside depth, a depth scale > 0, and for planar depth a camera"
        got = f"{intensity}, {depth_scale}, {camera} for {depth.name}"
        raise ValueError(f"Expected {what}, got {got}. Give what is missing.")
    levels, image = _read_image(depth), _read_image(Path(intensity))
    what = f"one channel of depth in {depth}"
    expect(levels.ndim == 2, what, levels.shape[-1], "Name depth first.")
    distance = levels / depth_scale
    if planar:
        distance = distance * ray_lengths(distance.shape, camera)
    green = image if image.ndim == 2 else image[..., 1 if image.shape[-1] > 2 else 0]
    encoded = green / np.iinfo(green.dtype).max  # sRGB, IEC 61966-2-1
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return Frame(distance, linear, camera, depth.stem)


def _read_image(path: Path) -> NDArray:
    """Pixels of a PNG of 8 or 16 bits or a JPEG as stored: (H, W) or (H, W, channels)."""
    from PIL import Image

    try:
        with Image.open(check_input(path)) as image:
            # palettes hold colour numbers, not levels
            pixels = np.asarray(image.convert("RGB") if image.mode in ("P", "1") else image)
    except Exception as error:  # Pillow raises OSError, SyntaxError and, for bombs, its own kind
        raise broken("a PNG image (or JPEG for colour)", path, error) from error
    # Pillow opens some 16-bit greys as 32-bit integers
    return pixels.astype(np.uint16) if pixels.dtype == np.int32 else pixels


def rays_from_camera(shape: tuple[int, ...], camera: ArrayLike) -> NDArray[np.float64]:
    """Rays (H, W, 3) through the pixel centres: x right, y down, z = 1.

    With the camera fx, fy, cx, cy, px, and a skew s: column u = fx x + s y + cx, row v = fy y + cy.
    """
    fx, fy, cx, cy, *skew = np.asarray(camera, float)
    v, u = np.indices(shape[:2]) + 0.5
    y = (v - cy) / fy
    x = (u - cx - sum(skew) * y) / fx
    return np.stack([x, y, np.ones(shape[:2])], axis=-1)


def ray_lengths(shape: tuple[int, ...], camera: ArrayLike) -> NDArray[np.float64]:
    """Range along the ray per planar depth, (H, W); parameters as in `rays_from_camera`."""
    return np.linalg.norm(rays_from_camera(shape, camera), axis=-1)


def brightness(color: ArrayLike) -> NDArray[np.floating]:
    """Linear brightness 0.3 R + 0.59 G + 0.11 B of colours (..., 3), as Hypersim defines it."""
    color = np.asarray(color)
    return color @ np.array([0.3, 0.59, 0.11], color.dtype)
