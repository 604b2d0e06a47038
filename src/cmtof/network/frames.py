"""Frames packed for training: one array a partition, read by crops through the page cache.

A Hypersim tree is one compressed file an image; unpacking them for every crop would cost more than
a step on a GPU. Packed, a crop is a copy of its rows, whatever the set's size.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cmtof.files import written_whole
from cmtof.scenes.frame import Frames
from cmtof.scenes.hypersim import Hypersim

PARTS = ("depth", "intensity")


@dataclass(frozen=True)
class Pack:
    """Frames of one partition.

    Attributes
    ----------
    depth : ndarray, shape (V, H, W)
        Range, m, float32; NaN where unknown.
    intensity : ndarray, shape (V, H, W)
        Linear, clipped to [0, 1], float16.
    far : ndarray, shape (V,)
        99.9th percentile of each frame's depth, m: what protocol ``released`` shrinks by.
    names : list of str
    """

    depth: NDArray[np.float32]
    intensity: NDArray[np.float16]
    far: NDArray[np.float64]
    names: list[str]

    def __len__(self) -> int:
        return len(self.names)


def pack_frames(
    tree: Path,
    folder: Path,
    partition: str,
    progress: Callable[[str], None] = lambda name: None,
) -> Pack:
    """Pack a partition of a Hypersim tree, or open what was packed before.

    Parameters
    ----------
    tree : Path
        Hypersim's published layout, or what ``cmtof render`` wrote.
    folder : Path
        Where to put the arrays.
    partition : {"train", "val", "test"}
        By the rule ``scenes`` of `cmtof.scenes.hypersim.split_views`.
    progress : callable
        Told of each frame as it is read.

    Raises
    ------
    ValueError
        If the partition is empty, or its frames differ in size.
    """
    listing = folder / f"{partition}.json"
    source = Hypersim(tree)
    views = source.split()[partition]
    wanted = [view.name for view in views]
    if listing.is_file():
        held = json.loads(listing.read_text(encoding="utf-8"))
        if held["views"] == wanted:
            return _opened(folder, partition, held)
    if not views:
        raise ValueError(
            f"Expected views of the partition {partition} in {tree}, got none. Render 10 scenes or "
            "more: of ten, one validates and one tests."
        )
    folder.mkdir(parents=True, exist_ok=True)
    return _pack(Frames(source.sources(views)), wanted, folder, partition, progress)


def _pack(
    frames: Frames,
    wanted: Sequence[str],
    folder: Path,
    partition: str,
    progress: Callable[[str], None],
) -> Pack:
    names, far, arrays = [], [], None
    paths = {part: folder / f"{partition}_{part}.npy" for part in PARTS}
    kinds = {"depth": np.float32, "intensity": np.float16}
    for path in paths.values():
        path.unlink(missing_ok=True)  # another process may still read the old one
    for frame in frames:
        if arrays is None:
            arrays = {p: _new(paths[p], kinds[p], (len(wanted), *frame.depth.shape)) for p in PARTS}
        if frame.depth.shape != arrays["depth"].shape[1:]:
            raise ValueError(
                f"Expected frames of {arrays['depth'].shape[1:]}, got {frame.depth.shape} in "
                f"{frame.name}. Train on one size."
            )
        arrays["depth"][len(names)] = frame.depth
        arrays["intensity"][len(names)] = np.clip(frame.intensity, 0, 1)
        far.append(float(np.nanpercentile(frame.depth, 99.9)))
        names.append(frame.name)
        progress(frame.name)
    if arrays is None:
        raise ValueError(f"Expected frames to train on, got {frames.skipped}. Render them anew.")
    for array in arrays.values():
        array.flush()
    held = {"views": list(wanted), "names": names, "far": far, "skipped": frames.skipped}
    with written_whole(folder / f"{partition}.json") as part:
        part.write_text(json.dumps(held, indent=1) + "\n", encoding="utf-8")
    return _opened(folder, partition, held)


def _new(path: Path, kind: type, shape: tuple[int, ...]) -> np.memmap:
    return np.lib.format.open_memmap(path, mode="w+", dtype=kind, shape=shape)


def _opened(folder: Path, partition: str, held: dict) -> Pack:
    depth, intensity = (np.load(folder / f"{partition}_{p}.npy", mmap_mode="r") for p in PARTS)
    count = len(held["names"])
    return Pack(depth[:count], intensity[:count], np.asarray(held["far"]), held["names"])
