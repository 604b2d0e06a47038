"""Hypersim: the official tree as it lies on disk, or rooms rendered in the same layout.

One reader serves both. Depth is the range along the ray already and is taken as it is; intensity
is linear green. The official files are float16: `View.frame` can undo the steps of their depth
(`cmtof.scenes.half_precision`), and says in the frame's note what it did.

Source: Roberts et al., ICCV 2021; https://github.com/apple/ml-hypersim.
"""

import csv
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cmtof.scenes.half_precision import float16_step, smoothed_within_step
from cmtof.scenes.hypersim_layout import read_array, view_exists, view_file
from cmtof.scenes.hypersim_metadata import (
    CAMERAS,
    SPLIT,
    find_table,
    read_projections,
    read_split,
)
from cmtof.scenes.hypersim_writer import write_metadata, write_scene, write_view
from cmtof.scenes.projection import camera_from_projection, rays_from_projection
from cmtof.scenes.rgbd import Frame
from cmtof.scenes.sources import Frames, Source
from cmtof.scenes.splits import PARTITIONS, Rule, split_views

__all__ = ["Hypersim", "View", "view_exists", "write_metadata", "write_scene", "write_view"]

_DEPTH_NAME = re.compile(r"frame\.(\d+)\.depth_meters\.hdf5")
_BRIGHTEST = 65504.0  # largest float16; radiance beyond it is stored as infinite


@dataclass(frozen=True, order=True)
class View:
    """One view of a tree; nothing is read before it is asked for."""

    scene: str
    camera: str
    frame_number: int
    tree: "Hypersim" = field(repr=False, compare=False)

    @property
    def name(self) -> str:
        """Such as ``ai_001_001/cam_00/0042``."""
        return f"{self.scene}/{self.camera}/{self.frame_number:04d}"

    def path(self, kind: str) -> Path:
        """File of its color, depth, normal or instance."""
        return view_file(self.tree.root, self.scene, self.camera, self.frame_number, kind)

    def color(self) -> NDArray[np.floating]:
        """Linear radiance (H, W, 3) as stored."""
        return read_array(self.path("color"), 3)

    def depth(self) -> NDArray[np.floating]:
        """Range along the ray (H, W), m, as stored."""
        return read_array(self.path("depth"), 2)

    def normal(self) -> NDArray[np.floating]:
        """Unit normals (H, W, 3) in the world, as stored."""
        return read_array(self.path("normal"), 3)

    def instance(self) -> NDArray[np.integer]:
        """Number of the thing in each pixel (H, W); -1 where there is none."""
        return read_array(self.path("instance"), 2)

    def projection(self) -> NDArray[np.float64]:
        """M_cam_from_uv (3, 3) of its scene.

        Raises
        ------
        ValueError
            If no table of camera parameters tells it.
        """
        known = self.tree.projections.get(self.scene)
        if known is None:
            raise ValueError(
                f"Expected {self.scene} in {CAMERAS} beside {self.tree.root}, got no such row. "
                "Fetch the table from the data set's repository."
            )
        return known

    def rays(self) -> NDArray[np.float64]:
        """Unit rays (H, W, 3) in the camera's axes: right, up, backwards."""
        return rays_from_projection(self.projection(), self.depth().shape)

    def pose(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Position (3,), m, and orientation (3, 3), world from camera (right, up, backwards)."""
        folder = self.tree.root / self.scene / "_detail" / self.camera
        frames, positions, orientations = (
            read_array(folder / f"camera_keyframe_{kind}.hdf5", axes)
            for kind, axes in (("frame_indices", 1), ("positions", 2), ("orientations", 3))
        )
        at = np.flatnonzero(frames == self.frame_number)
        if len(at) != 1 or not at[0] < min(len(positions), len(orientations)):
            raise ValueError(
                f"Expected one pose of frame {self.frame_number} in {folder}, got {len(at)}. "
                "Fetch the scene's _detail folder anew."
            )
        scale = self.tree.meters_per_asset_unit(self.scene)
        return positions[at[0]].astype(float) * scale, orientations[at[0]].astype(float)

    def frame(self, *, smooth: bool = False, blank: bool = False) -> Frame:
        """The view as the simulator takes it.

        Parameters
        ----------
        smooth : bool
            Smooth float16 depth within its own steps. Depth of other types stays.
        blank : bool
            Where the colour file is missing, take intensity 1 everywhere.

        Returns
        -------
        Frame
            With linear green as intensity (NaN and negative light as 0), range as depth, and the
            camera if the tables tell it. Its ``note`` names steps, smoothing and blank intensity.

        Raises
        ------
        FileNotFoundError
            If a file is missing.
        ValueError
            If a file is broken, or the sizes differ.
        """
        depth, notes = self.depth(), []
        if depth.dtype == np.float16:
            notes.append(_step_note(depth, smooth))
            depth = smoothed_within_step(depth) if smooth else depth
        if blank and not self.path("color").is_file():
            intensity = np.ones(depth.shape, np.float32)
            notes.append("no colour file: intensity 1 everywhere")
        else:
            green = self.color()[..., 1].astype(np.float32)
            intensity = np.nan_to_num(green, nan=0.0, posinf=_BRIGHTEST, neginf=0.0).clip(0)
        camera = None
        if self.scene in self.tree.projections:
            camera, _ = camera_from_projection(self.projection(), depth.shape)
        return Frame(depth, intensity, camera, self.name, "; ".join(notes))


class Hypersim:
    """A tree of scenes.

    Parameters
    ----------
    root : str or Path
        Folder that holds the scenes, or one scene. The two tables are looked for in it, beside
        it, and in the folders ``metadata`` and ``analysis`` of either.

    Raises
    ------
    FileNotFoundError
        If there is no such folder.
    ValueError
        If it holds no scene.
    """

    def __init__(self, root: str | Path):
        path = Path(root)
        if not path.is_dir():
            raise FileNotFoundError(f"Expected a folder of scenes, got {path}. Check the path.")
        alone = (path / "images").is_dir()
        self.root = path.resolve().parent if alone else path
        self._scenes = path.resolve().name if alone else "*"
        if not is_hypersim(path):
            raise ValueError(
                f"Expected scenes such as ai_001_001/images in {path}, got none. Name the folder "
                "that holds them."
            )

    @cached_property
    def views(self) -> list[View]:
        """Every view whose depth is on disk, sorted."""
        pattern = f"{self._scenes}/images/scene_*_geometry_hdf5/frame.*.depth_meters.hdf5"
        return sorted(view for path in self.root.glob(pattern) if (view := self._view(path)))

    def view(self, scene: str, camera: str, frame: int) -> View:
        """One view by name."""
        return View(scene, camera, frame, self)

    @cached_property
    def projections(self) -> dict[str, NDArray[np.float64]]:
        """M_cam_from_uv (3, 3) of each scene; empty without the table."""
        table = find_table(self.root, CAMERAS)
        return {} if table is None else read_projections(table)

    def meters_per_asset_unit(self, scene: str) -> float:
        """Scale of a scene's positions.

        Raises
        ------
        ValueError
            If the scene does not tell it.
        """
        path = self.root / scene / "_detail" / "metadata_scene.csv"
        try:
            with path.open(encoding="utf-8", newline="") as file:
                return float(dict(row[:2] for row in csv.reader(file))["meters_per_asset_unit"])
        except (OSError, ValueError, KeyError) as error:
            raise ValueError(
                f"Expected meters_per_asset_unit in {path}, got none. Fetch the scene's _detail "
                "folder."
            ) from error

    def split(self, rule: Rule = "scenes") -> dict[str, list[View]]:
        """Views on disk that train, validate and test.

        Parameters
        ----------
        rule : {"scenes", "official", "authors"}
            As in `cmtof.scenes.splits.split_views`.

        Raises
        ------
        FileNotFoundError
            If the partition table is not there.
        """
        table = find_table(self.root, SPLIT)
        if table is None:
            raise FileNotFoundError(
                f"Expected {SPLIT} in or beside {self.root}, got none. Fetch it from the data "
                "set's repository, or write it with write_metadata."
            )
        parts = split_views(read_split(table), rule)
        there = {_key(view): view for view in self.views}
        return {
            name: [there[row[:3]] for row in parts[name] if row[:3] in there] for name in PARTITIONS
        }

    def sources(
        self, views: Iterable[View] | None = None, *, smooth: bool = False, blank: bool = False
    ) -> list[Source]:
        """Views as frames to be loaded; options as in `View.frame`."""
        chosen = self.views if views is None else views
        return [Source(v.name, partial(v.frame, smooth=smooth, blank=blank)) for v in chosen]

    def frames(
        self, views: Iterable[View] | None = None, *, smooth: bool = False, blank: bool = False
    ) -> Frames:
        """Iterate over frames; broken and incomplete ones are left out and told in ``skipped``."""
        return Frames(self.sources(views, smooth=smooth, blank=blank))

    def test_views(self) -> list[View]:
        """Test frames by the default rule; none without the partition table."""
        return self.split()["test"] if find_table(self.root, SPLIT) else []

    def _view(self, path: Path) -> View | None:
        named = _DEPTH_NAME.fullmatch(path.name)
        camera = path.parent.name.removeprefix("scene_").removesuffix("_geometry_hdf5")
        return self.view(path.parts[-4], camera, int(named[1])) if named else None


def is_hypersim(folder: Path) -> bool:
    """Whether a folder is a tree of scenes or one scene."""
    below = "images/scene_*_geometry_hdf5/frame.*.depth_meters.hdf5"
    return any(next(folder.glob(pattern), None) for pattern in (below, f"*/{below}"))


def view_of_file(path: Path) -> View:
    """The view that a depth file belongs to, wherever its tree lies.

    Raises
    ------
    ValueError
        If the file is not named and placed as in a tree.
    """
    path = path.resolve()
    view = None
    if len(path.parts) > 4 and path.parts[-3] == "images":
        view = Hypersim(path.parents[3])._view(path)
    if view is None:
        raise ValueError(
            "Expected a depth file SCENE/images/scene_cam_XX_geometry_hdf5/"
            f"frame.IIII.depth_meters.hdf5, got {path}. Keep the layout of the data set."
        )
    return view


def _key(view: View) -> tuple[str, str, int]:
    return (view.scene, view.camera, view.frame_number)


def _step_note(depth: NDArray[np.float16], smooth: bool) -> str:
    valid = depth[np.isfinite(depth) & (depth > 0)]
    widest = 1000 * float16_step(valid.max()) if valid.size else 0.0
    what = "smoothed within its" if smooth else "in"
    return f"float16 depth {what} steps of up to {widest:.1f} mm"
