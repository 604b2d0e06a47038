"""Styles of TUM, NYU and ScanNet: where depth and colour images lie, their scale and camera."""

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from cmtof.scenes import association

Camera = tuple[float, float, float, float]
Pair = tuple[Path, Path]

VGA = (640, 480)
"""Size of image, W x H, px, that the cameras of `STYLES` hold for."""

_COLOUR = (".png", ".jpg", ".jpeg")
_FLAT = ("_colors", "_color", "_colour", "_rgb", "_image")
_SCANNET_CAMERAS = ("intrinsic/intrinsic_depth.txt", "intrinsic_depth.txt", "intrinsics_depth.txt")


@dataclass(frozen=True)
class Style:
    """How a data set stores its images.

    Attributes
    ----------
    folder : str
        Of the colour images; those of depth lie in ``depth``.
    depth_scale : float
        Levels per metre.
    planar : bool
        True if depth is along the optical axis.
    camera : tuple, optional
        fx, fy, cx, cy, px, centres at +0.5, of images of size `VGA`.
    """

    folder: str
    depth_scale: float
    planar: bool
    camera: Camera | None


STYLES: dict[str, Style] = {
    # the benchmark's default, given for centres at whole numbers
    "tum": Style("rgb", 5000.0, True, (525.0, 525.0, 320.0, 240.0)),
    # colour camera of the toolbox, given for the first centre at 1; depth is registered to it
    "nyu": Style("rgb", 1000.0, True, (518.857901, 519.469611, 325.082449, 253.236166)),
    "scannet": Style("color", 1000.0, True, None),
}
"""TUM (Sturm et al. 2012), NYU Depth v2 (Silberman et al. 2012), ScanNet (Dai et al. 2017)."""


def style_of(folder: Path) -> str | None:
    """Style of a folder of images, or None."""
    if not (folder / "depth").is_dir():
        return "nyu" if next(folder.glob("*_depth.png"), None) else None
    if (folder / "color").is_dir():
        return "scannet"
    if not (folder / "rgb").is_dir():
        return None
    listed = any((folder / name).is_file() for name in ("depth.txt", "associations.txt"))
    stamped = next((folder / "depth").glob("*.*.png"), None) is not None
    return "tum" if listed or stamped else "nyu"


def pairs_in(folder: Path, style: str) -> list[Pair]:
    """Depth and colour image of every frame of a folder, in order."""
    if style == "tum":
        return _stamped_pairs(folder)
    depth, colour = folder / "depth", folder / STYLES[style].folder
    if depth.is_dir():
        colours = {p.stem: p for p in sorted(colour.glob("*")) if p.suffix.lower() in _COLOUR}
        there = [(p, colours[p.stem]) for p in depth.glob("*.png") if p.stem in colours]
    else:
        there = [(p, c) for p in folder.glob("*_depth.png") if (c := _beside(p)) is not None]
    return sorted(there, key=lambda pair: _numbered(pair[0]))


def _beside(depth: Path) -> Path | None:
    """Colour image of a ``NAME_depth.png``."""
    stem = depth.name.removesuffix("_depth.png")
    named = (depth.with_name(f"{stem}{end}{kind}") for end in _FLAT for kind in _COLOUR)
    return next((path for path in named if path.is_file()), None)


def _stamped_pairs(folder: Path) -> list[Pair]:
    """By the list of pairs, by the two lists, or by names that are times."""
    if (folder / "associations.txt").is_file():
        listed = association.read_pairs(folder / "associations.txt")
        return [(folder / depth, folder / colour) for depth, colour in listed]
    stamps = [_stamps(folder, kind) for kind in ("depth", "rgb")]
    depth, colour = ([time for time, _ in each] for each in stamps)
    paired = association.associate(depth, colour)
    return [(folder / stamps[0][i][1], folder / stamps[1][j][1]) for i, j in paired]


def _stamps(folder: Path, kind: str) -> association.Stamped:
    if (folder / f"{kind}.txt").is_file():
        return association.read_stamps(folder / f"{kind}.txt")
    try:
        return [(float(p.stem), f"{kind}/{p.name}") for p in sorted((folder / kind).glob("*.*"))]
    except ValueError as error:
        raise ValueError(
            f"Expected times as names in {folder / kind}, got another ({error}). Add the list "
            f"{kind}.txt."
        ) from error


def camera_of(folder: Path, style: str, depth: Path) -> ArrayLike | None:
    """Camera that a style knows for a depth image of a folder, or None."""
    if style == "scannet":
        table = next((folder / n for n in _SCANNET_CAMERAS if (folder / n).is_file()), None)
        return None if table is None else read_intrinsics(table)
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(depth) as image:  # reads the header only
            return STYLES[style].camera if image.size == VGA else None
    except (OSError, UnidentifiedImageError):
        return None  # the loader says what is wrong


def read_intrinsics(path: Path) -> Camera:
    """Camera out of a 3x3 or 4x4 matrix in a text file with centres at whole numbers (ScanNet).

    Raises
    ------
    ValueError
        If it is no such matrix.
    """
    try:
        with warnings.catch_warnings(action="ignore"):  # of no data: the error below says it
            matrix = np.loadtxt(path, ndmin=2)
    except ValueError as error:
        raise ValueError(
            f"Expected a 3x3 or 4x4 matrix in {path}, got {error}. Export it anew."
        ) from error
    if matrix.shape not in ((3, 3), (4, 4)):
        raise ValueError(
            f"Expected a 3x3 or 4x4 matrix in {path}, got {matrix.shape}. Export it anew."
        )
    fx, fy, cx, cy = (float(matrix[i]) for i in ((0, 0), (1, 1), (0, 2), (1, 2)))
    return fx, fy, cx + 0.5, cy + 0.5


def _numbered(path: Path) -> tuple[int, str]:
    """Order of frames that are counted without leading zeros."""
    digits = "".join(c for c in path.stem if c.isdigit())
    return (int(digits) if digits else 0, path.name)
