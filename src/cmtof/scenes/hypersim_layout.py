"""Files of a Hypersim tree: where each lies, how one is written and read.

One view of a scene is four files, each with a single array under the key ``dataset``::

    SCENE/images/scene_cam_XX_final_hdf5/frame.IIII.color.hdf5                 (H, W, 3)
    SCENE/images/scene_cam_XX_geometry_hdf5/frame.IIII.depth_meters.hdf5       (H, W)
    SCENE/images/scene_cam_XX_geometry_hdf5/frame.IIII.normal_world.hdf5       (H, W, 3)
    SCENE/images/scene_cam_XX_geometry_hdf5/frame.IIII.semantic_instance.hdf5  (H, W)

Source: Roberts et al., ICCV 2021, and the description published with the data set.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cmtof.files import written_whole

FILES = {
    "color": ("final", "color"),
    "depth": ("geometry", "depth_meters"),
    "normal": ("geometry", "normal_world"),
    "instance": ("geometry", "semantic_instance"),
}
"""Folder and file name of each array of a view."""

_ROWS = 64  # of a chunk


def view_file(root: str | Path, scene: str, camera: str, frame: int, kind: str) -> Path:
    """Where an array of a view lies; ``kind`` is a key of `FILES`.

    Examples
    --------
    >>> view_file("tree", "ai_001_001", "cam_00", 42, "depth").as_posix()
    'tree/ai_001_001/images/scene_cam_00_geometry_hdf5/frame.0042.depth_meters.hdf5'
    """
    folder, name = FILES[kind]
    images = Path(root) / scene / "images" / f"scene_{camera}_{folder}_hdf5"
    return images / f"frame.{frame:04d}.{name}.hdf5"


def view_exists(root: str | Path, scene: str, camera: str, frame: int) -> bool:
    """Whether all four files of a view are there, and therefore whole."""
    return all(view_file(root, scene, camera, frame, kind).is_file() for kind in FILES)


def write_array(path: Path, array: NDArray) -> None:
    """Write one HDF5 file with the key ``dataset``; no times in it, so equal arrays equal bytes."""
    import h5py

    packed: dict[str, Any] = {}
    if array.nbytes > 2**16:  # a chunk table would outweigh what packing saves
        rows = min(_ROWS, len(array))
        packed = {"chunks": (rows, *array.shape[1:]), "compression": "lzf", "shuffle": True}
    path.parent.mkdir(parents=True, exist_ok=True)
    with written_whole(path) as part, h5py.File(part, "w") as file:
        file.create_dataset("dataset", data=array, track_times=False, **packed)


def read_array(path: Path, dimensions: int) -> NDArray:
    """Read the key ``dataset``.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If it is no whole HDF5 file, has no such key, or not that many dimensions; the last of
        three is 3.
    """
    import h5py

    if not path.is_file():
        raise FileNotFoundError(
            f"Expected the file {path.name} in {path.parent}, got none. Fetch or render it."
        )
    try:
        with h5py.File(path, "r") as file:
            array = np.asarray(file["dataset"][()])  # type: ignore[index]
    except Exception as error:  # h5py raises OSError, KeyError and RuntimeError by kind of damage
        reason = (str(error).splitlines() or [type(error).__name__])[0][:120]
        raise ValueError(
            f"Expected a whole HDF5 file with the key dataset, got {path} ({reason}). "
            "Fetch or render it anew."
        ) from error
    fits = array.ndim == dimensions and (dimensions < 3 or array.shape[-1] == 3)
    if not fits or array.dtype.kind not in "iuf" or array.size == 0:
        raise ValueError(
            f"Expected numbers on {dimensions} axes{', the last of 3' * (dimensions == 3)}, got "
            f"{array.dtype} {array.shape} in {path}. Fetch or render it anew."
        )
    return array


def write_table(path: Path, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a CSV table, whole or not at all."""
    import csv

    with written_whole(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(rows)


def remove_parts(folder: Path, pattern: str) -> None:
    """Remove what `written_whole` had begun when a run was killed."""
    for part in folder.glob(f"{pattern}.part-*"):
        part.unlink(missing_ok=True)
