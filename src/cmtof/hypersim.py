"""Frames of the Hypersim data set, official or of rooms rendered in the same layout.

A view is four files SCENE/images/scene_cam_XX_FOLDER_hdf5/frame.IIII.NAME.hdf5, as `FILES` lists
them, each with one array (H, W) or (H, W, 3) under the key ``dataset``. Two tables lie beside the
scenes: `CAMERAS`, the projection of each, and `SPLIT`, the partition of each view. Depth is the
range along the ray already, official files hold float16: between 4 and 8 m its steps are 4 mm.
Source: Roberts et al., ICCV 2021; https://github.com/apple/ml-hypersim.
"""

import csv
import os
import re
from collections.abc import Callable, Iterable
from functools import cached_property, partial
from glob import escape
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.files import AnyPath, atomic_output, check_input, check_links, reading
from cmtof.frame import Frame, Source
from cmtof.types import Array, Named, Shape, Texts
from cmtof.validation import check_claim

FILES = {  # folder, file name and, in rendered sets, type of each array of a view
    "color": ("final", "color", np.float16),
    "depth": ("geometry", "depth_meters", np.float32),
    "normal": ("geometry", "normal_world", np.float16),
    "instance": ("geometry", "semantic_instance", np.int16),
}
CAMERAS = "metadata_camera_parameters.csv"
SPLIT = "metadata_images_split_scene_v1.csv"
PARTITIONS = ("train", "val", "test")

_MATRIX = tuple(f"M_cam_from_uv_{i}{j}" for i in range(3) for j in range(3))
_LISTED = ("scene_name", "camera_name", "frame_id", "split_partition_name")
_DEPTH_FILES = "images/scene_*_geometry_hdf5/frame.*.depth_meters.hdf5"
_BRIGHTEST = 65504.0  # largest float16; radiance beyond it is stored as infinite


class View(NamedTuple):
    """Scene, camera and number of a view; ``partition`` is empty where none is stated."""

    scene: str
    camera: str
    number: int
    partition: str = ""

    @property
    def name(self) -> str:
        """Name such as ``ai_001_001/cam_00/0042``."""
        return f"{self.scene}/{self.camera}/{self.number:04d}"

    def file(self, root: AnyPath, kind: str) -> Path:
        """File of an array below the root of a tree; ``kind`` is a key of `FILES`."""
        folder, name, _ = FILES[kind]
        images = (
            Path(root) / self.scene / "images" / f"scene_{self.camera}_{folder}_hdf5"
        )
        return images / f"frame.{self.number:04d}.{name}.hdf5"


class Hypersim:
    """Hypersim folder, or one of its scenes; tables lie in it, beside it, or in ``metadata``."""

    def __init__(self, root: AnyPath):
        path = Path(os.path.abspath(root))  # noqa: PTH100 - a link keeps its name and place
        if not is_hypersim(path):
            raise ValueError(
                f"Expected scenes such as ai_001_001/images in {path}, got none. Name their folder."
            )
        one_scene = (path / "images").is_dir()
        self.root = path.parent if one_scene else path
        self._scenes = escape(path.name) if one_scene else "*"

    @cached_property
    def views(self) -> list[View]:
        """Every view whose depth is on disk, sorted."""
        files = self.root.glob(f"{self._scenes}/{_DEPTH_FILES}")
        return sorted(view for file in files if (view := _view_from_path(file)))

    @cached_property
    def projections(self) -> dict[str, Array]:
        """Projection M_cam_from_uv (3, 3) of each scene, by name; empty without the table."""
        return dict(
            self._table(
                CAMERAS,
                lambda r: (
                    r["scene_name"],
                    np.reshape([float(r[m]) for m in _MATRIX], (3, 3)),
                ),
            )
        )

    def frame(self, view: View, *, blank: bool = False) -> Frame:
        """Frame of a view, its intensity linear green, or 1 if ``blank`` and no colour is there."""
        depth = read_array(view.file(self.root, "depth"), 2)
        notes = []
        if depth.dtype == np.float16:
            step = np.spacing(depth[np.isfinite(depth)].max(initial=0))
            notes.append(f"float16 depth in steps of up to {1e3 * step:.1f} mm")
        color = view.file(self.root, "color")
        intensity = np.ones(depth.shape)
        if blank and not color.is_file():
            notes.append("no colour file: intensity 1 everywhere")
        else:
            green = read_array(color, 3)[..., 1].astype(np.float32)
            intensity = np.nan_to_num(green, posinf=_BRIGHTEST).clip(0)
        projection = self.projections.get(view.scene)
        camera = (
            None
            if projection is None
            else camera_from_projection(projection, depth.shape)
        )
        return Frame(depth, intensity, camera, view.name, "; ".join(notes))

    def sources(
        self, views: Iterable[View] | None = None, *, blank: bool = False
    ) -> list[Source]:
        """Sources of the frames of views; by default of test frames, or of all without a split."""
        if views is None:
            views = (self.split()["test"] if self._listed_views else []) or self.views
        return [
            Source(view.name, partial(self.frame, view, blank=blank)) for view in views
        ]

    def split(self) -> dict[str, list[View]]:
        """Views on disk by partition (train, val, test), as `split_views` chooses them."""
        if not self._listed_views:
            raise FileNotFoundError(
                f"Expected {SPLIT} in or beside {self.root}, got none. Copy it from the data set."
            )
        parts = split_views(self._listed_views)
        there = {view[:3] for view in self.views}
        return {
            name: [v for v in part if v[:3] in there] for name, part in parts.items()
        }

    @cached_property
    def _listed_views(self) -> list[View]:
        """Every view that the table of the split lists; empty without the table."""
        scene, camera, number, part = _LISTED
        return self._table(
            SPLIT, lambda r: View(r[scene], r[camera], int(r[number]), r[part])
        )

    def _table(self, name: str, parse: Callable[[Texts], Any]) -> list[Any]:
        """Rows of a published table, each parsed by a function; empty without the table."""
        places = (
            base / folder / name
            for base in (self.root, self.root.parent)
            for folder in ("", "metadata", "analysis")
        )
        path = next((place for place in places if place.is_file()), None)
        if path is None:
            return []
        with (
            reading("the data set's columns and numbers", path),
            path.open(encoding="utf-8-sig", newline="") as file,
        ):
            return [parse(row) for row in csv.DictReader(file)]


def is_hypersim(folder: Path) -> bool:
    """Whether a folder is in Hypersim's layout: scenes, or one scene."""
    return any(next(folder.glob(p), None) for p in (_DEPTH_FILES, f"*/{_DEPTH_FILES}"))


def frame_of_file(path: Path) -> Frame:
    """Frame of a depth file of Hypersim; a ValueError if it lies outside the data set's layout."""
    path = Path(os.path.abspath(path))  # noqa: PTH100 - as above
    if (view := _view_from_path(path)) is None:
        raise ValueError(
            "Expected a depth file "
            f"SCENE/images/scene_cam_XX_geometry_hdf5/frame.IIII.depth_meters.hdf5, got {path}. "
            "Keep the layout of the data set."
        )
    return Hypersim(path.parents[3]).frame(view, blank=True)


def _view_from_path(path: Path) -> View | None:
    layout = r"/([^/]+)/images/scene_([^/]+)_geometry_hdf5/frame\.(\d{1,9})\.depth_meters\.hdf5$"
    found = re.search(layout, path.as_posix())
    return View(found[1], found[2], int(found[3])) if found else None


def camera_from_projection(projection: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Camera fx, fy, cx, cy (and a skew above 1e-6 fx), px, of a projection M_cam_from_uv.

    A pixel at (x, y), centres at +0.5, has u = 2x/W - 1 and v = 1 - 2y/H; its ray in the camera's
    axes (right, up, backwards) is M (u, v, 1). Any M is a pinhole K turned by a rotation R, by the
    QR decomposition of its rays per pixel, R K^-1. ValueError if it is singular or mirrored.
    """
    given = np.asarray(projection, float)
    rays = np.diag([1.0, -1.0, -1.0]) @ given
    rays = rays @ [[2 / shape[1], 0, -1], [0, -2 / shape[0], 1], [0, 0, 1]]
    if not np.isfinite(rays).all() or np.linalg.det(rays) <= 0:
        raise ValueError(
            "Expected a projection M_cam_from_uv, invertible and not mirrored, "
            f"got {given.tolist()}. Check the table of camera parameters."
        )
    inverse = np.linalg.qr(rays, mode="r")
    pinhole = np.linalg.inv(inverse * np.sign(np.diag(inverse))[:, None])
    camera = (pinhole / pinhole[2, 2])[[0, 1, 0, 1, 0], [0, 1, 2, 2, 1]]
    return camera if abs(camera[4]) > 1e-6 * camera[0] else camera[:4]


def split_views(listed: Iterable[View]) -> dict[str, list[View]]:
    """Listed views divided into train, val and test; each list is sorted.

    Test are the paper's test frames or, in sets rendered here, the first view of each test scene;
    train and val are the official partitions without the scenes of any test frame.
    """
    views = sorted(view for view in listed if view.partition in PARTITIONS)
    first_rendered = {
        view.scene: view
        for view in reversed(views)
        if view.partition == "test" and not re.match(r"ai_\d{3}_", view.scene)
    }
    test = sorted(
        [
            *(v for v in views if re.fullmatch(r"ai_\d{3}_001/cam_00/0042", v.name)),
            *first_rendered.values(),
        ]
    )
    tested = {view.scene for view in test}
    parts = {
        name: [v for v in views if v.partition == name and v.scene not in tested]
        for name in ("train", "val")
    }
    return {**parts, "test": test}


def read_array(path: Path, dimensions: int) -> NDArray:
    """Numbers of one file, (H, W) for two dimensions, (H, W, 3) for three."""
    import h5py

    check_input(path, "a file of the data set")
    with reading("a whole HDF5 file with the key dataset", path):
        with h5py.File(path, "r") as file:
            check_links(file)
            stored: Any = file["dataset"]
            check_claim(stored.nbytes, path)
            array = np.asarray(stored[()])
        if array.dtype.kind not in "iuf" or array.shape[2:] != (3,) * (dimensions - 2):
            raise ValueError(
                f"{array.dtype} {array.shape}, no numbers on {dimensions} axes"
            )
    return array


def write_metadata(root: Path, shape: Shape, scenes: Named) -> None:
    """Write the tables `CAMERAS` and `SPLIT` of a rendered set whose views all have ``shape`` H, W.

    A scene has a partition, a focal length in px, and views by camera and frame number.
    """
    cameras: list[tuple] = [("scene_name", *_MATRIX)]
    listed: list[tuple] = [_LISTED]
    for scene, (partition, focal, views) in scenes.items():
        half = np.array(shape) / (2 * focal)
        cameras.append((scene, *np.diag([half[1], half[0], -1.0]).ravel().tolist()))
        listed += [(scene, *view, partition) for view in views]
    for name, rows in ((CAMERAS, cameras), (SPLIT, listed)):
        with (
            atomic_output(root / name) as part,
            part.open("w", newline="") as file,
        ):
            csv.writer(file, lineterminator="\n").writerows(rows)
