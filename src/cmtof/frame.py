"""RGB-D frames: range along the ray, linear intensity, and the camera that saw them."""

import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.files import AnyPath, atomic_output, check_input, reading
from cmtof.types import Array, Texts
from cmtof.validation import check_claim, checked_camera, numbers

EMBEDDED = (
    Path(__file__).parent / "frames"
)  # the small frames that travel with the package
HELD_OUT = EMBEDDED / "test" / "rooms.npz"  # views of rooms that nothing was trained on
HELD_OUT_STEP = 5e-5  # step of its depth, m

_WHITE = 0.8  # share of white pixels beyond which the light looks wrong
_DARK = 0.02  # brightness of nearly all pixels below which it looks wrong, too


@dataclass(frozen=True, eq=False)
class Frame:
    """One view of a scene: depth and light; a ValueError says what is wrong with its arrays."""

    depth: Array  # range along the ray (H, W), m, float32; NaN where invalid
    intensity: Array  # linear radiance (H, W) >= 0, clipped to 1 by the simulator
    camera: Array | None = None  # fx, fy, cx, cy, px (centres at +0.5), and skew
    name: str = ""  # source of the frame
    note: str = ""  # what a user should know of it

    def __post_init__(self) -> None:
        where = self.name or "the frame"
        depth = numbers(self.depth, f"depth of {where}", np.float32)
        light = numbers(self.intensity, f"intensity of {where}", np.float32)
        if depth.ndim != 2 or depth.shape != light.shape or not depth.size:
            raise ValueError(
                "Expected depth and intensity of one shape (H, W), "
                f"got {depth.shape} and {light.shape} in {where}. Resample one of them."
            )
        depth[~(np.isfinite(depth) & (depth > 0))] = np.nan
        if np.isnan(depth).all():
            raise ValueError(
                f"Expected depths in metres, got none above 0 in {where}. "
                f"Check the depth scale. {self.note}".strip()
            )
        if not np.isfinite(light).all() or light.min() < 0:
            raise ValueError(
                f"Expected finite intensities >= 0, got others in {where}. Replace them with 0."
            )
        if np.asarray(self.intensity).dtype.kind in "iu" and light.max() > 1:
            white = next(top for top in (255, 65535, light.max()) if light.max() <= top)
            notes = [self.note, f"light in integers, {white} is 1"]
            vars(self)["note"] = "; ".join(filter(None, notes))
            light /= white
        camera = None if self.camera is None else checked_camera(self.camera, where)
        vars(self).update(depth=depth, intensity=light, camera=camera)

    def save(self, path: AnyPath) -> None:
        """Write the frame, but for its name, as a compressed ``.npz`` with float32 images."""
        arrays = {"depth": self.depth, "intensity": self.intensity}
        if self.camera is not None:
            arrays["camera"] = self.camera
        if self.note:
            arrays["note"] = np.array(self.note)
        with atomic_output(path, ".npz") as part:
            np.savez_compressed(part, **arrays)  # pyright: ignore[reportArgumentType]

    def middle(self, height: int, width: int) -> "Frame":
        """Central part of the frame, at most ``height`` x ``width`` px, with a shifted camera."""
        top = max(0, (self.depth.shape[0] - height) // 2)
        left = max(0, (self.depth.shape[1] - width) // 2)
        part = np.s_[top : top + height, left : left + width]
        camera = self.camera
        if camera is not None:
            camera = camera - [0, 0, left, top, 0][: len(camera)]
        return Frame(
            self.depth[part], self.intensity[part], camera, self.name, self.note
        )


class Source(NamedTuple):
    """Name of a frame and the function that loads it, or raises ValueError or OSError."""

    name: str
    load: Callable[[], Frame]


@dataclass
class Frames:
    """Frames loaded one by one from sources; ``skipped`` holds why others failed, by name."""

    sources: Sequence[Source]
    skipped: Texts = field(default_factory=dict)

    def __iter__(self) -> Iterator[Frame]:
        self.skipped.clear()
        for source in self.sources:
            try:
                yield source.load()
            except (ValueError, OSError) as error:
                self.skipped[source.name] = str(error)


def embedded_frames() -> dict[str, Path]:
    """Files of the frames that come with the package, by name."""
    return {path.stem: path for path in sorted(EMBEDDED.glob("*.npz"))}


def held_out_frames() -> list[Frame]:
    """The test set of Tables 1 to 3: 32 views of 384 x 512 px, chosen by `cmtof_rooms.held_out`."""
    # second differences of depth along rows, first ones of √I in bytes
    arrays = read_npz(HELD_OUT)
    slopes = arrays["depth"].cumsum(axis=2, dtype=np.int32)
    steps = slopes.cumsum(axis=2, dtype=np.int32)
    levels = arrays["intensity"].cumsum(axis=2, dtype=np.uint8)
    light = (levels / np.float32(255)) ** 2
    names = arrays["name"].tolist()
    return [*map(Frame, steps * HELD_OUT_STEP, light, arrays["camera"], names)]


def read_npz(path: Path) -> dict[str, NDArray]:
    """Arrays of an ``.npz`` by name, never a pickle; a ValueError for whatever is wrong."""
    with reading("a whole .npz file", path):
        with zipfile.ZipFile(check_input(path)) as archive:
            check_claim(sum(m.file_size for m in archive.infolist()), path)
        with np.load(path, allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}


def list_npz(path: Path) -> Iterator[str]:
    """Name, shape and type of every array of an ``.npz``; the arrays are not read."""
    with (
        reading("a whole .npz file", path),
        zipfile.ZipFile(check_input(path)) as archive,
    ):
        for member in archive.namelist():
            with archive.open(member) as file:
                np.lib.format.read_magic(file)
                shape, _, kind = np.lib.format.read_array_header_1_0(file)
            yield f"{member.removesuffix('.npy')} {shape} {kind}"


def frame_from_npz(path: Path, camera: ArrayLike | None) -> Frame:
    """Frame of an ``.npz`` with ``depth``, ``intensity`` and, unless given, ``camera``."""
    arrays = read_npz(path)
    if not arrays.keys() >= {"depth", "intensity"}:
        raise ValueError(
            f"Expected arrays depth and intensity in {path}, "
            f"got {', '.join(sorted(arrays)) or 'none'}. Add them."
        )
    stored = arrays.get("camera") if camera is None else camera
    frame = Frame(arrays["depth"], arrays["intensity"], stored, path.stem)  # pyright: ignore[reportArgumentType]
    notes = [str(arrays.get("note", "")), frame.note, light_note(frame.intensity)]
    # the stored one may hold what is noted again
    parts = dict.fromkeys("; ".join(notes).split("; "))
    vars(frame)["note"] = "; ".join(filter(None, parts))
    return frame


def light_note(light: Array) -> str:
    """Warning about linear brightness, where 1 is white, that looks wrong, or an empty text."""
    white = (light >= 1).mean()
    brightest = np.percentile(light, 99)
    if white > _WHITE:
        return f"{white:.0%} of the light is at 1 or above, and counts as white"
    if brightest < _DARK:
        return (
            f"dark: 99 % of the light is below {brightest:.2g} of white; "
            "is it linear (--linear)?"
        )
    return ""


def rays_from_camera(shape: tuple[int, ...], camera: ArrayLike) -> Array:
    """Rays (H, W, 3) through the pixel centres: x right, y down, z = 1.

    With the camera fx, fy, cx, cy, px, and a skew s: column u = fx x + s y + cx, row v = fy y + cy.
    """
    fx, fy, cx, cy, *skew = np.asarray(camera, float)
    v, u = np.indices(shape[:2]) + 0.5
    y = (v - cy) / fy
    x = (u - cx - sum(skew) * y) / fx
    return np.stack([x, y, np.ones(shape[:2])], axis=-1)


def ray_lengths(shape: tuple[int, ...], camera: ArrayLike) -> Array:
    """Range along the ray per planar depth, (H, W); parameters as in `rays_from_camera`."""
    return np.linalg.norm(rays_from_camera(shape, camera), axis=-1)


def brightness(color: ArrayLike) -> Array:
    """Linear brightness 0.3 R + 0.59 G + 0.11 B of colours (..., 3), as Hypersim defines it."""
    color = np.asarray(color)
    return color @ np.array([0.3, 0.59, 0.11], np.result_type(color, np.float32))
