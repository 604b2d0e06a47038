"""Frames by file, by name and by folder."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from cmtof.scenes.frame import Frame, Source, embedded_frames, frame_from_pair, read_npz
from cmtof.scenes.hypersim import Hypersim, is_hypersim

Stamped = list[tuple[float, str]]


def read_stamps(path: Path) -> Stamped:
    """Read lines «time file» (``rgb.txt``, ``depth.txt``); comments begin with ``#``.

    Raises
    ------
    ValueError
        If a line holds something else.
    """
    return [(float(fields[0]), fields[1]) for fields in _lines(path, 2)]


def read_pairs(path: Path) -> list[tuple[str, str]]:
    """Read lines «time file time file» (``associations.txt``): depth and colour file of each pair.

    The order is told by the names: the file below ``depth`` is depth.

    Raises
    ------
    ValueError
        If a line holds something else.
    """
    pairs = []
    for _, one, _, other in _lines(path, 4):
        ordered = [name for name in (one, other) if "depth" in name.lower()]
        if len(ordered) != 1:
            raise ValueError(
                f"Expected one file of each pair in a folder depth, got {one} and {other} in "
                f"{path}. Write its lines as «time rgb/FILE time depth/FILE»."
            )
        pairs.append((ordered[0], other if ordered[0] == one else one))
    return pairs


def associate(
    first: Sequence[float], second: Sequence[float], within: float = 0.02
) -> list[tuple[int, int]]:
    """Pair time stamps, nearest ones first, each used once.

    Parameters
    ----------
    first, second : sequence of float
        Times, s, in any order.
    within : float
        Largest difference of a pair, s.

    Returns
    -------
    list of (int, int)
        Indices into both, in the order of ``first``.

    Examples
    --------
    >>> associate([0.00, 0.033, 0.067], [0.002, 0.034, 0.5])
    [(0, 0), (1, 1)]
    """
    order = np.argsort(second, kind="stable")
    times = np.asarray(second, float)[order]
    near = []
    for i, time in enumerate(first):
        start = np.searchsorted(times, time - 1.01 * within, side="left")
        stop = np.searchsorted(times, time + 1.01 * within, side="right")
        near += [(abs(time - times[k]), i, int(order[k])) for k in range(start, stop)]
    taken_first: set[int] = set()
    taken_second: set[int] = set()
    pairs = []
    for difference, i, j in sorted(near):
        if difference <= within and i not in taken_first and j not in taken_second:
            pairs.append((i, j))
            taken_first.add(i)
            taken_second.add(j)
    return sorted(pairs)


def _lines(path: Path, fields: int) -> list[list[str]]:
    """Fields of each line that is no comment; every other one is a time."""
    lines = []
    text = path.read_text(encoding="utf-8", errors="replace")
    for number, line in enumerate(text.splitlines(), start=1):
        parts = line.replace(",", " ").split()
        if not parts or parts[0].startswith("#"):
            continue
        if len(parts) < fields or not all(_is_time(part) for part in parts[:fields:2]):
            raise ValueError(
                f"Expected «{' '.join(['time file'] * (fields // 2))}» in line {number} of {path}, "
                f"got {line[:80]!r}. Write the list anew."
            )
        lines.append(parts[:fields])
    return lines


def _is_time(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False


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
        listed = read_pairs(folder / "associations.txt")
        return [(folder / depth, folder / colour) for depth, colour in listed]
    stamps = [_stamps(folder, kind) for kind in ("depth", "rgb")]
    depth, colour = ([time for time, _ in each] for each in stamps)
    paired = associate(depth, colour)
    return [(folder / stamps[0][i][1], folder / stamps[1][j][1]) for i, j in paired]


def _stamps(folder: Path, kind: str) -> Stamped:
    if (folder / f"{kind}.txt").is_file():
        return read_stamps(folder / f"{kind}.txt")
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
        from cmtof.scenes.frame import frame_from_pair

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


def frames_in(
    source: str | Path,
    *,
    style: str | None = None,
    depth_scale: float | None = None,
    planar: bool | None = None,
    camera: ArrayLike | None = None,
    partition: Literal["train", "val", "test", "all"] | None = None,
    smooth: bool = False,
    blank: bool = False,
) -> list[Source]:
    """List the frames of a file, an embedded name or a folder; nothing is loaded yet.

    Parameters
    ----------
    source : str or Path
        A file or name for `cmtof.scenes.frame.load_frame`, or a folder: a Hypersim tree or one
        scene of it; ``rgb`` and ``depth`` (TUM with its lists or time stamps as names, NYU with
        equal names); ``color`` and ``depth`` (ScanNet); ``NAME_depth.png`` beside
        ``NAME_colors.png`` (NYU); ``*.npz``; or a folder of such folders.
    style : {"tum", "nyu", "scannet"}, optional
        Style of the images; by default told by the folder.
    depth_scale, planar, camera : optional
        In place of what the style says: levels per metre, whether depth is along the optical axis,
        and fx, fy, cx, cy in px. ScanNet's camera is read from ``intrinsic_depth.txt``.
    partition : {"train", "val", "test", "all"}, optional
        Of a Hypersim tree, by the rule ``scenes`` of `cmtof.scenes.hypersim.split_views`. By default
        the test frames where there are any, and every view otherwise.
    smooth, blank : bool
        Of a Hypersim tree, as in `cmtof.scenes.hypersim.View.frame`.

    Raises
    ------
    FileNotFoundError, ValueError
        If there is no such source, or no frame in it.
    """
    path = Path(source)
    if str(source) in embedded_frames() or not path.is_dir():
        given = {"camera": camera, "smooth": smooth, "depth_scale": depth_scale}
        return [Source(str(source), partial(load_frame, source, planar=bool(planar), **given))]
    if style is not None and style not in STYLES:
        raise ValueError(f"Expected a style out of {', '.join(STYLES)}, got {style}. Choose one.")
    if style is None and is_hypersim(path):
        return _of_tree(Hypersim(path), partition, smooth, blank)
    given = {"depth_scale": depth_scale, "planar": planar, "camera": camera}
    found = _of_folder(path, style, given)
    if not found:
        inner = sorted(folder for folder in path.iterdir() if folder.is_dir())
        found = [one for folder in inner for one in _of_folder(folder, style, given)]
    if not found:
        raise ValueError(
            f"Expected frames in {path} (a Hypersim tree, rgb and depth, color and depth, "
            "NAME_depth.png or *.npz), got none. Name the folder that holds them."
        )
    return found


def _of_tree(tree: Hypersim, partition: str | None, smooth: bool, blank: bool) -> list[Source]:
    if partition == "all":
        views = tree.views
    elif partition is None:
        views = tree.test_views() or tree.views
    else:
        views = tree.split()[partition]
    if not views:
        raise ValueError(
            f"Expected views of the partition {partition} in {tree.root}, got none. Fetch them, or "
            "ask for all."
        )
    return tree.sources(views, smooth=smooth, blank=blank)


def _of_folder(folder: Path, style: str | None, given: dict) -> list[Source]:
    chosen = style or style_of(folder)
    if chosen is None:
        npz = sorted(folder.glob("*.npz"))
        return [Source(p.stem, partial(load_frame, p, camera=given["camera"])) for p in npz]
    load: Callable[..., Frame] = partial(_load, folder, chosen, given)
    return [
        Source(f"{folder.name}/{depth.stem}", partial(load, depth, colour))
        for depth, colour in pairs_in(folder, chosen)
    ]


def _load(folder: Path, style: str, given: dict, depth: Path, colour: Path) -> Frame:
    known = STYLES[style]
    scale = known.depth_scale if given["depth_scale"] is None else given["depth_scale"]
    planar = known.planar if given["planar"] is None else given["planar"]
    camera = given["camera"] if given["camera"] is not None else camera_of(folder, style, depth)
    shown = "unknown" if camera is None else " ".join(f"{x:g}" for x in np.ravel(camera))
    return frame_from_pair(
        depth,
        colour,
        depth_scale=scale,
        planar=planar,
        camera=camera,
        name=f"{folder.name}/{depth.stem}",
        note=f"{style} style: {scale:g} levels per metre, "
        f"{'along the axis' if planar else 'along the ray'}, camera {shown}",
    )
