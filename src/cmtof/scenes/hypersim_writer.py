"""Write rendered scenes as a Hypersim tree, in float32: equal input gives equal bytes."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.scenes.hypersim_layout import remove_parts, view_file, write_array, write_table
from cmtof.scenes.hypersim_metadata import (
    CAMERAS,
    LISTED_COLUMNS,
    MATRIX_COLUMNS,
    ROW_COLUMNS,
    SCALE_COLUMN,
    SIZE_COLUMNS,
    SPLIT,
)
from cmtof.scenes.projection import projection_from_focal

MANTISSA = 10
"""Bits kept of colour and normals: as many as float16, the type of the official files, has."""


def write_view(
    root: str | Path,
    scene: str,
    camera: str,
    frame: int,
    *,
    color: ArrayLike,
    depth: ArrayLike,
    normal: ArrayLike,
    instance: ArrayLike,
) -> None:
    """Write the four files of a view, each whole or not at all; equal input gives equal bytes.

    Depth keeps every bit of float32. Colour and normals are float32 rounded to `MANTISSA` bits
    (at most 0.05 % off), so that their shuffled bytes pack well. Shuffle and LZF take 45 to 60 ms
    of one core for 512 x 512 pixels and leave a quarter to a third of 7.5 MB; gzip at its fastest
    would leave a quarter less of that for 20 ms more, and no packing takes 8 ms.

    Parameters
    ----------
    root : str or Path
        Folder of the scenes; folders below it are made.
    scene, camera, frame : str, str, int
        Such as ``"ai_001_001"``, ``"cam_00"``, 0.
    color : array_like, shape (H, W, 3)
        Linear radiance.
    depth : array_like, shape (H, W)
        Range along the ray, m; NaN where there is none.
    normal : array_like, shape (H, W, 3)
        Unit normals in the world.
    instance : array_like of int, shape (H, W)
        Number of the thing, -1 where there is none.

    Raises
    ------
    ValueError
        If the shapes do not fit together.
    """
    arrays = {
        "color": rounded(np.asarray(color, np.float32)),
        "depth": np.asarray(depth, np.float32),
        "normal": rounded(np.asarray(normal, np.float32)),
        "instance": _narrow(np.asarray(instance)),
    }
    shape = arrays["depth"].shape
    for kind, array in arrays.items():
        expected = (*shape, 3) if kind in ("color", "normal") else shape
        if len(shape) != 2 or array.shape != expected:
            raise ValueError(
                f"Expected {kind} of shape {expected}, got {array.shape} for {scene} {camera} "
                f"frame {frame}. Render them with one size."
            )
    for kind, array in arrays.items():
        write_array(view_file(root, scene, camera, frame, kind), array)


def write_scene(
    root: str | Path,
    scene: str,
    *,
    cameras: Mapping[str, tuple[ArrayLike, ArrayLike]],
    parameters: Mapping[str, object] | None = None,
) -> None:
    """Write a scene's ``_detail`` folder: its scale and the pose of every view.

    Parts that an interrupted run left in the scene's folder are removed.

    Parameters
    ----------
    root, scene : str or Path, str
        As in `write_view`.
    cameras : mapping
        For each camera, positions (K, 3), m, and orientations (K, 3, 3), world from camera, whose
        columns are the camera's axes: right, up, backwards. The world's z points up.
    parameters : mapping, optional
        What else is to be known of the scene, such as its seed.

    Raises
    ------
    ValueError
        If the shapes do not fit together.
    """
    detail = Path(root) / scene / "_detail"
    detail.mkdir(parents=True, exist_ok=True)
    remove_parts(detail.parent, "**/.*")
    rows = {"meters_per_asset_unit": 1.0, **(parameters or {})}
    write_table(
        detail / "metadata_scene.csv", ("parameter_name", "parameter_value"), list(rows.items())
    )
    write_table(detail / "metadata_cameras.csv", ("camera_name",), [(name,) for name in cameras])
    for name, (positions, orientations) in cameras.items():
        where, turned = np.asarray(positions, float), np.asarray(orientations, float)
        if where.ndim != 2 or where.shape[1] != 3 or turned.shape != (len(where), 3, 3):
            raise ValueError(
                f"Expected positions (K, 3) and orientations (K, 3, 3) of {name} in {scene}, got "
                f"{where.shape} and {turned.shape}. Stack one of each a view."
            )
        write_array(detail / name / "camera_keyframe_positions.hdf5", where)
        write_array(detail / name / "camera_keyframe_orientations.hdf5", turned)
        write_array(detail / name / "camera_keyframe_frame_indices.hdf5", np.arange(len(where)))


def write_metadata(
    root: str | Path,
    split: Mapping[str, str],
    *,
    shape: tuple[int, int],
    focal: float | Mapping[str, float],
    views: Mapping[str, Sequence[tuple[str, int]]],
) -> None:
    """Write both tables of a rendered set.

    Parameters
    ----------
    root : str or Path
        Folder of the scenes; made where it is missing. Parts of either table that an interrupted
        run left there are removed.
    split : mapping
        Partition of each scene: train, val or test.
    shape : (int, int)
        H, W of the views, px.
    focal : float or mapping
        Focal length, px, of all scenes or of each.
    views : mapping
        Camera and frame number of each view of each scene.

    Raises
    ------
    ValueError
        If a partition has another name.
    """
    root = Path(root)
    unknown = sorted(set(split.values()) - {"train", "val", "test"})
    if unknown:
        raise ValueError(
            f"Expected the partitions train, val and test, got {', '.join(unknown)}. Rename them."
        )
    root.mkdir(parents=True, exist_ok=True)
    remove_parts(root, ".metadata_*")
    lengths = focal if isinstance(focal, Mapping) else dict.fromkeys(split, focal)
    projections = [
        (scene, *map(float, shape), 1.0, *projection_from_focal(lengths[scene], shape).ravel())
        for scene in split
    ]
    write_table(
        root / CAMERAS, ("scene_name", *SIZE_COLUMNS, SCALE_COLUMN, *MATRIX_COLUMNS), projections
    )
    listed = [
        (scene, camera, frame, True, "", partition)
        for scene, partition in split.items()
        for camera, frame in views[scene]
    ]
    write_table(root / SPLIT, (*ROW_COLUMNS, *LISTED_COLUMNS), listed)


def rounded(array: NDArray[np.float32], bits: int = MANTISSA) -> NDArray[np.float32]:
    """Round to ``bits`` bits of mantissa: at most 2^-(bits + 1) off, relative.

    Examples
    --------
    >>> rounded(np.array([1.0, 1.25, np.pi], np.float32), bits=2).tolist()
    [1.0, 1.25, 3.0]
    """
    dropped = 23 - bits
    finite = np.isfinite(array)
    stored = np.ascontiguousarray(array).view(np.uint32)
    # half of the last place up, then cut: a carry into the exponent is what rounding means
    raised = (stored + np.uint32(1 << (dropped - 1))) & np.uint32(
        0xFFFFFFFF << dropped & 0xFFFFFFFF
    )
    return np.where(finite, raised.view(np.float32), array)


def _narrow(numbers: NDArray) -> NDArray[np.signedinteger]:
    """As int16, the official type, where the numbers fit, and as int32 otherwise."""
    fits = numbers.size == 0 or (numbers.min() >= -(2**15) and numbers.max() < 2**15)
    return numbers.astype(np.int16 if fits else np.int32)
