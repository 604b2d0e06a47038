"""Folders of frames: depth and colour images in the styles of TUM, NYU and ScanNet, ``.npz``,
Hypersim trees.

Frames are listed at once and loaded one by one (`cmtof.scenes.sources`).
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from cmtof.scenes.hypersim import Hypersim, is_hypersim
from cmtof.scenes.png import frame_from_pair
from cmtof.scenes.rgbd import Frame, embedded_frames, load_frame
from cmtof.scenes.sources import Source
from cmtof.scenes.styles import STYLES, camera_of, pairs_in, style_of


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
        A file or name for `cmtof.scenes.rgbd.load_frame`, or a folder: a Hypersim tree or one
        scene of it; ``rgb`` and ``depth`` (TUM with its lists or time stamps as names, NYU with
        equal names); ``color`` and ``depth`` (ScanNet); ``NAME_depth.png`` beside
        ``NAME_colors.png`` (NYU); ``*.npz``; or a folder of such folders.
    style : {"tum", "nyu", "scannet"}, optional
        Style of the images; by default told by the folder.
    depth_scale, planar, camera : optional
        In place of what the style says: levels per metre, whether depth is along the optical axis,
        and fx, fy, cx, cy in px. ScanNet's camera is read from ``intrinsic_depth.txt``.
    partition : {"train", "val", "test", "all"}, optional
        Of a Hypersim tree, by the rule ``scenes`` of `cmtof.scenes.splits.split_views`. By default
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
