"""Sources of RGB-D: files, folders, Hypersim, rooms from a seed, real captures."""

from functools import partial
from pathlib import Path
from typing import Any

from cmtof.files import check_input
from cmtof.frame import (
    Frame,
    Frames,
    Source,
    embedded_frames,
    frame_from_npz,
    frame_from_pair,
)
from cmtof.hypersim import Hypersim, frame_of_file, is_hypersim
from cmtof.validation import expect

__all__ = ["Frame", "Frames", "embedded_frames", "frames_in", "load_frame"]


def load_frame(source: str | Path, *, intensity: str | Path | None = None, **given: Any) -> Frame:
    """Frame of a file or of an embedded name, or the first one of a folder as `frames_in` lists it.

    An ``.npz`` holds ``depth`` (m), ``intensity`` and, unless given, ``camera``; depth as ``.png``
    takes an ``intensity`` image and options of `frame_from_pair`; an ``.hdf5`` lies in its tree.

    >>> load_frame("still_life").depth.shape
    (240, 320)
    """
    known = embedded_frames()
    path = known.get(str(source), Path(source))
    if path.is_dir():
        return frames_in(path, **given)[0].load()
    check_input(path, f"a frame file or one of {', '.join(known)}")
    what = "a frame named *.npz, *.png or *.depth_meters.hdf5"
    expect(path.suffix in (".npz", ".png", ".hdf5"), what, path.name, "Convert it.")
    if path.suffix == ".npz":
        return frame_from_npz(path, given.get("camera"))
    if path.suffix == ".png":
        return frame_from_pair(path, intensity, **given)
    return frame_of_file(path)


def frames_in(source: str | Path, **given: Any) -> list[Source]:
    """Frames of a file, an embedded name or a folder, listed without loading any.

    A folder is a Hypersim tree or scene (its test frames, or every view without the table), holds
    ``*.npz``, or pairs ``depth/NAME.png`` and ``rgb`` or ``color`` ``/NAME.png`` or ``.jpg``, as
    NYU and ScanNet are exported; options as in `load_frame`.
    """
    path = Path(source)
    if str(source) in embedded_frames() or not path.is_dir():
        return [Source(str(source), partial(load_frame, source, **given))]
    if is_hypersim(path):
        return Hypersim(path).sources(blank=True)
    camera = given.get("camera")
    found = [Source(p.stem, partial(frame_from_npz, p, camera)) for p in sorted(path.glob("*.npz"))]
    colours = {p.stem: p for folder in ("rgb", "color") for p in (path / folder).glob("*.*g")}
    found += [
        Source(f"{path.name}/{p.stem}", partial(frame_from_pair, p, colours[p.stem], **given))
        for p in sorted((path / "depth").glob("*.png"), key=lambda p: (len(p.stem), p))
        if p.stem in colours
    ]
    what = f"frames in {path} (a Hypersim tree, depth beside rgb or color, or *.npz)"
    expect(found, what, "none", "Name the folder that holds them.")
    return found
