"""The two tables beside a Hypersim tree: camera parameters of the scenes, partition of the views.

Both keep the official names, ``metadata_camera_parameters.csv`` and
``metadata_images_split_scene_v1.csv``, and the official columns. They are looked for in the folder
of the scenes, in its ``metadata`` and ``analysis``, then in the folder above and the same two
below that.
"""

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

CAMERAS = "metadata_camera_parameters.csv"
SPLIT = "metadata_images_split_scene_v1.csv"

SIZE_COLUMNS = ("settings_output_img_height", "settings_output_img_width")
SCALE_COLUMN = "settings_units_info_meters_scale"
MATRIX_COLUMNS = tuple(f"M_cam_from_uv_{i}{j}" for i in range(3) for j in range(3))
ROW_COLUMNS = ("scene_name", "camera_name", "frame_id")
LISTED_COLUMNS = ("included_in_public_release", "exclude_reason", "split_partition_name")


class Listed(NamedTuple):
    """One row of the partition table."""

    scene: str
    camera: str
    frame: int
    partition: str
    """train, val or test; empty where the view was not published."""


def find_table(root: str | Path, name: str) -> Path | None:
    """Where a table lies, or None."""
    root = Path(root).resolve()
    below = ("", "metadata", "analysis")
    places = [base / folder / name for base in (root, root.parent) for folder in below]
    return next((place for place in places if place.is_file()), None)


def read_projections(path: Path) -> dict[str, NDArray[np.float64]]:
    """M_cam_from_uv (3, 3) of each scene out of the table of camera parameters.

    Raises
    ------
    ValueError
        If a column is missing or a number is none.
    """
    projections = {}
    for line, row in _rows(path, ("scene_name", *MATRIX_COLUMNS)):
        try:
            matrix = np.array([float(row[name]) for name in MATRIX_COLUMNS]).reshape(3, 3)
        except ValueError as error:
            raise ValueError(
                f"Expected numbers in line {line} of {path}, got an error ({error}). "
                "Fetch the table anew."
            ) from error
        projections[row["scene_name"]] = matrix
    return projections


def read_split(path: Path) -> list[Listed]:
    """Views and their partitions out of the split table, in its order.

    Raises
    ------
    ValueError
        If a column is missing or a frame has no number.
    """
    listed = []
    for line, row in _rows(path, (*ROW_COLUMNS, "split_partition_name")):
        try:
            frame = int(row["frame_id"])
        except ValueError as error:
            raise ValueError(
                f"Expected a frame number in line {line} of {path}, got {row['frame_id']!r}. "
                "Fetch the table anew."
            ) from error
        partition = row["split_partition_name"]
        listed.append(Listed(row["scene_name"], row["camera_name"], frame, partition))
    return listed


def _rows(path: Path, columns: tuple[str, ...]) -> Iterator[tuple[int, dict[str, str]]]:
    """Line numbers and rows of a table that has these columns."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.DictReader(file)
            missing = [name for name in columns if name not in (reader.fieldnames or ())]
            if missing:
                raise ValueError(f"no column {missing[0]}")
            for row in reader:
                if any(row[name] is None for name in columns):
                    raise ValueError(f"line {reader.line_num} is short")
                yield reader.line_num, row
    except (csv.Error, UnicodeDecodeError, ValueError) as error:
        raise ValueError(
            f"Expected the columns {', '.join(columns[:3])}, ... in {path}, got {error}. "
            "Fetch the table anew."
        ) from error
