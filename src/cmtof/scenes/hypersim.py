"""Hypersim: the official tree as it lies on disk, or rooms rendered in the same layout."""

import csv
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.files import written_whole
from cmtof.scenes.frame import Frame, Frames, Source
from cmtof.scenes.half_precision import float16_step, smoothed_within_step

Matrix = NDArray[np.float64]

SKEW = 1e-6
"""Skew, relative to fx, below which a camera is written with four numbers."""

_DOWN_FORWARD = np.diag([1.0, -1.0, -1.0])


def uv_from_pixel(shape: tuple[int, ...]) -> Matrix:
    """The matrix N (3, 3) that takes (x, y, 1), px, to (u, v, 1)."""
    height, width = shape
    return np.array([[2 / width, 0, -1], [0, -2 / height, 1], [0, 0, 1]])


def rays_from_projection(projection: ArrayLike, shape: tuple[int, ...]) -> Matrix:
    """Unit rays (H, W, 3) through the pixels' centres in the camera's axes: right, up, backwards.

    Parameters
    ----------
    projection : array_like, shape (3, 3)
        M_cam_from_uv.
    shape : (int, int)
        H, W.
    """
    y, x = np.indices(shape) + 0.5
    pixels = np.stack([x, y, np.ones(shape)], axis=-1)
    rays = pixels @ (np.asarray(projection, float) @ uv_from_pixel(shape)).T
    return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def camera_from_projection(projection: ArrayLike, shape: tuple[int, ...]) -> tuple[Matrix, Matrix]:
    """Camera numbers and rotation of a projection.

    Parameters
    ----------
    projection : array_like, shape (3, 3)
        M_cam_from_uv.
    shape : (int, int)
        H, W.

    Returns
    -------
    camera : ndarray, shape (4,) or (5,)
        fx, fy, cx, cy, px, and the skew where it exceeds `SKEW` of fx.
    rotation : ndarray, shape (3, 3)
        Takes that camera's rays (x right, y down, z forward) to Hypersim's camera axes.

    Raises
    ------
    ValueError
        If the matrix shows nothing, or shows it mirrored.

    Examples
    --------
    >>> camera, rotation = camera_from_projection(np.diag([0.5, 0.375, -1.0]), (384, 512))
    >>> camera.tolist(), rotation.diagonal().tolist()
    ([512.0, 512.0, 256.0, 192.0], [1.0, -1.0, -1.0])
    """
    given = np.asarray(projection, float)
    whole = given.shape == (3, 3) and bool(np.isfinite(given).all())
    rays = _DOWN_FORWARD @ (given if whole else np.zeros((3, 3))) @ uv_from_pixel(shape)
    if not np.linalg.det(rays) > 0:
        raise ValueError(
            f"Expected a projection M_cam_from_uv that shows what lies ahead, got "
            f"{given.tolist()}. Check the table of camera parameters."
        )
    turned, inverse = np.linalg.qr(rays)
    signs = np.sign(np.diag(inverse))
    turned, inverse = turned * signs, inverse * signs[:, None]
    pinhole = np.linalg.inv(inverse)
    pinhole /= pinhole[2, 2]
    camera = pinhole[[0, 1, 0, 1, 0], [0, 1, 2, 2, 1]]
    skewed = abs(camera[4]) > SKEW * camera[0]
    return (camera if skewed else camera[:4]), _DOWN_FORWARD @ turned


def projection_from_focal(focal: float, shape: tuple[int, ...]) -> Matrix:
    """M_cam_from_uv (3, 3) of a plain pinhole with its centre in the middle of the image.

    Examples
    --------
    >>> projection_from_focal(886.81, (768, 1024)).diagonal().round(3).tolist()
    [0.577, 0.433, -1.0]
    """
    height, width = shape
    return np.diag([width / (2 * focal), height / (2 * focal), -1.0])


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


PARTITIONS = ("train", "val", "test")

Rule = Literal["scenes", "official", "authors"]
Split = dict[str, list[Listed]]

_OFFICIAL_NAME = re.compile(r"ai_\d{3}_\d{3}")


def is_authors_test(view: Listed) -> bool:
    """Whether a view is one of the paper's test frames: 0042 of camera 00 of an ai_VVV_001.

    Of the 49 such views 46 were published; 34 of them lie in the official training partition, 7 in
    its test and 5 in its validation partition.

    Examples
    --------
    >>> is_authors_test(Listed("ai_007_001", "cam_00", 42, "train"))
    True
    """
    first = re.fullmatch(r"ai_\d{3}_001", view.scene) is not None
    return first and view.camera == "cam_00" and view.frame == 42


def split_views(listed: Iterable[Listed], rule: Rule = "scenes") -> Split:
    """Part the published views into train, val and test.

    Parameters
    ----------
    listed : iterable of Listed
        Rows of the partition table.
    rule : {"scenes", "official", "authors"}
        ``scenes``, the default of this project: test are the paper's test frames
        (`is_authors_test`) or, in sets that were rendered here, the first view of each test scene.
        Train and val are the official partitions without any scene that holds a test frame, so
        that nothing is tested on a scene that was trained on.
        ``official``: the partitions as the table has them.
        ``authors``: the paper's test frames; everything else trains, neighbouring views of the
        tested scenes included. This rule and the official one exclude each other: 34 of the 46
        test frames lie in official training scenes.

    Returns
    -------
    dict
        Lists under train, val and test, sorted; no view stands in two of them.

    Raises
    ------
    ValueError
        If there is no such rule.

    Examples
    --------
    >>> views = [Listed("room_000_009", "cam_00", i, "test") for i in range(3)]
    >>> [view.frame for view in split_views(views)["test"]]
    [0]
    """
    rules: Mapping[str, Callable[[list[Listed]], Split]] = {
        "scenes": _by_scene,
        "official": _official,
        "authors": _by_authors,
    }
    if rule not in rules:
        raise ValueError(f"Expected a rule out of {', '.join(rules)}, got {rule}. Choose one.")
    return rules[rule](sorted(view for view in listed if view.partition in PARTITIONS))


def _official(views: list[Listed]) -> Split:
    return {name: [view for view in views if view.partition == name] for name in PARTITIONS}


def _by_authors(views: list[Listed]) -> Split:
    test = [view for view in views if is_authors_test(view)]
    return {"train": [v for v in views if not is_authors_test(v)], "val": [], "test": test}


def _by_scene(views: list[Listed]) -> Split:
    first: dict[str, Listed] = {}
    for view in views:
        if view.partition == "test" and not _OFFICIAL_NAME.fullmatch(view.scene):
            first.setdefault(view.scene, view)
    test = [view for view in views if is_authors_test(view) or first.get(view.scene) == view]
    tested = {view.scene for view in test}
    kept = _official([view for view in views if view.scene not in tested])
    return {"train": kept["train"], "val": kept["val"], "test": test}


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
            As in `cmtof.scenes.hypersim.split_views`.

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
