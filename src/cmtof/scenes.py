"""Frames of depth and light from files, folders, Hypersim and TUM data sets."""

from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from cmtof.files import AnyPath, check_input, reading
from cmtof.frame import Frame as Frame  # so that others may import it from here
from cmtof.frame import Frames as Frames
from cmtof.frame import Source, frame_from_npz
from cmtof.frame import embedded_frames as embedded_frames
from cmtof.hypersim import Hypersim, frame_of_file, is_hypersim
from cmtof.images import frame_from_pair
from cmtof.types import Fields

# Suffixes of images that may hold depth.
DEPTHS = (".png", ".pgm", ".pfm", ".npy", ".exr")

# Levels per metre in depth images of the TUM RGB-D benchmark.
TUM_LEVELS = 5000.0

# Largest time between depth and colour of one view of that benchmark, s.
TUM_GAP = 0.02


def load_frame(
    source: AnyPath, *, intensity: AnyPath | None = None, **given: Any
) -> Frame:
    """Frame of a file or of an embedded name, or the first one of a folder as `frames_in` lists it.

    An ``.npz`` holds ``depth`` (m), ``intensity`` and, unless given, ``camera``; an image of depth,
    ``.png``, ``.pgm``, ``.pfm`` or ``.npy``, takes an ``intensity`` image and the options of
    `cmtof.images.frame_from_pair`; an ``.hdf5`` lies in its tree.

    >>> load_frame("still_life").depth.shape
    (240, 320)
    """
    known = embedded_frames()
    path = known.get(str(source), Path(source))
    if path.is_dir():
        return frames_in(path, intensity=intensity, **given)[0].load()
    check_input(path, f"a frame file or one of {', '.join(known)}")
    suffix = path.suffix.lower()
    if suffix in DEPTHS:
        return frame_from_pair(path, intensity, **given)
    camera = given.pop("camera", None)
    _refuse_options(path, [intensity, *given.values()])
    if suffix == ".npz":
        return frame_from_npz(path, camera)
    if suffix == ".hdf5":
        return frame_of_file(path)
    raise ValueError(
        f"Expected a frame named *.npz, *.png or *.depth_meters.hdf5, got {path.name}. Convert it."
    )


def _refuse_options(path: Path, options: Iterable[Any]) -> None:
    """Raise a ValueError if an option is set that the file or folder settles by itself."""
    if any(map(np.any, options)):
        raise ValueError(
            f"Expected light, scale and kind of depth within {path.name}, got them as options. "
            "Leave these out."
        )


def frames_in(
    source: AnyPath, *, intensity: AnyPath | None = None, **given: Any
) -> list[Source]:
    """Sources of the frames of a file, an embedded name or a folder; none is loaded.

    A folder is a Hypersim tree or scene (its test frames, or every view without the table), a
    sequence of the TUM benchmark (``depth.txt`` and ``rgb.txt``), holds ``*.npz``, or pairs
    ``depth/NAME.png`` and ``rgb`` or ``color`` ``/NAME.png`` or ``.jpg``, as NYU and ScanNet are
    exported, with ScanNet's ``intrinsic/intrinsic_depth.txt``; options as in `load_frame`.
    """
    path = Path(source)
    if str(source) in embedded_frames() or not path.is_dir():
        return [
            Source(
                str(source), partial(load_frame, source, intensity=intensity, **given)
            )
        ]
    _refuse_options(path, [intensity])
    if is_hypersim(path):
        _refuse_options(path, given.values())
        return Hypersim(path).sources(blank=True)
    if (path / "depth.txt").is_file() and (path / "rgb.txt").is_file():
        return _tum_sequence(path, given)
    found = [
        Source(p.stem, partial(load_frame, p, **given))
        for p in sorted(path.glob("*.npz"))
    ]
    found += _pairs(path, given)
    if not found:
        raise ValueError(
            f"Expected frames in {path} (a Hypersim tree, depth beside rgb or color, TUM's lists, "
            "*.npz), got none. "
            "Name the folder that holds them."
        )
    return found


def _pairs(path: Path, options: Fields) -> list[Source]:
    """Sources of pairs ``depth/NAME`` and ``rgb/NAME`` or ``color/NAME``, by rising number."""
    if options.get("camera") is None:
        options = options | _scannet_camera(path)
    colours = {
        p.stem: p
        for folder in ("rgb", "color")
        for p in (path / folder).glob("*.*[gG]")
    }
    depths = [
        p
        for p in (path / "depth").glob("*")
        if p.suffix.lower() in DEPTHS and p.stem in colours
    ]
    return [
        Source(
            f"{path.name}/{p.stem}",
            partial(frame_from_pair, p, colours[p.stem], **options),
        )
        for p in sorted(depths, key=lambda p: (len(p.stem), p))
    ]


def _scannet_camera(path: Path) -> Fields:
    """Options of `frame_from_pair` by the camera that a folder of ScanNet has; none without it."""
    file = path / "intrinsic" / "intrinsic_depth.txt"
    if not file.is_file():
        return {}
    with reading("a matrix of the camera", file):
        matrix = np.loadtxt(file)
        focal = matrix[[0, 1], [0, 1]]
        centre = matrix[:2, 2] + 0.5  # they count pixels from their centres
    return {"planar": True, "camera": [*focal, *centre]}


def _tum_sequence(path: Path, options: Fields) -> list[Source]:
    """Sources of a sequence of the TUM benchmark: each depth with the colour nearest in time."""
    depths = _tum_list(path / "depth.txt")
    colours = _tum_list(path / "rgb.txt")
    reading = options | {
        "depth_scale": options.get("depth_scale") or TUM_LEVELS,
        # depth lies along the axis there
        "planar": options.get("planar") or options.get("camera") is not None,
    }
    times = np.array([*colours, np.inf])  # never near, where there is no colour
    found = []
    for time, name in depths.items():
        nearest = times[abs(times - time).argmin()]
        if abs(nearest - time) <= TUM_GAP:
            load = partial(
                frame_from_pair, path / name, path / colours[nearest], **reading
            )
            found.append(Source(f"{path.name}/{Path(name).stem}", load))
    if not found:
        raise ValueError(
            f"Expected depth and colour within {TUM_GAP} s of each other in {path}, got none. "
            "Check depth.txt and rgb.txt."
        )
    return found


def _tum_list(path: Path) -> dict[float, str]:
    """Image names by time, s, from a list such as ``depth.txt`` of the TUM benchmark."""
    lines = path.read_text("utf-8", errors="replace").splitlines()
    rows = [line.split() for line in lines if line.strip() and not line.startswith("#")]
    with reading("times and names of files below its folder", path):
        found = {float(row[0]): row[1] for row in rows}
        for name in map(Path, found.values()):
            if name.is_absolute() or ".." in name.parts:
                raise ValueError(f"{name} lies elsewhere")
    return found
