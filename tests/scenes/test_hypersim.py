"""Hypersim trees: the official layout as it is described, and what is broken in it."""

import h5py
import numpy as np
import pytest
from official_tree import (
    PLAIN,
    PROJECTIONS,
    SHAPE,
    VIEWS,
    final,
    geometry,
    official_rays,
    wall,
    write_official,
    write_rows,
)

from cmtof.pointcloud import points_from_depth
from cmtof.scenes import load_frame
from cmtof.scenes.half_precision import smoothed_within_step
from cmtof.scenes.hypersim import Hypersim, view_of_file


def first(tree):
    return Hypersim(tree).view("ai_001_001", "cam_00", 0)


# --- what a tree holds ---------------------------------------------------------------------


def test_views_are_found_in_order(tree):
    views = Hypersim(tree).views
    assert [(v.scene, v.camera, v.frame_number) for v in views] == [
        (scene, *view) for scene in PROJECTIONS for view in VIEWS
    ]
    assert views[1].name == "ai_001_001/cam_00/0042"


def test_nothing_is_read_before_it_is_asked_for(tree):
    for path in tree.rglob("*.hdf5"):
        path.write_bytes(b"")
    assert len(Hypersim(tree).views) == 9


def test_one_scene_of_a_tree_can_be_named(tree):
    alone = Hypersim(tree / "ai_001_002")
    assert {view.scene for view in alone.views} == {"ai_001_002"}
    assert len(alone.views[0].frame().camera) in (4, 5)


def test_official_float16_files_load(tree):
    frame = first(tree).frame()
    stored = wall(PLAIN).astype(np.float16).astype(np.float32)
    np.testing.assert_array_equal(frame.depth[1:], stored[1:])
    assert frame.intensity[3, 3] == 0.5  # green, linear, as stored
    assert frame.name == "ai_001_001/cam_00/0000"
    assert frame.note == "float16 depth in steps of up to 2.0 mm"


def test_depth_that_is_none_is_invalid(tree):
    depth = first(tree).frame().depth
    assert np.isnan(depth[0, :3]).all()
    assert np.isnan(depth).sum() == 3


def test_light_that_is_none_is_dark_and_overflown_light_is_bright(tree):
    intensity = first(tree).frame().intensity
    assert intensity[5, 5] == 0 and intensity[7, 7] == 0
    assert intensity[6, 6] == 65504


def test_normals_and_instances_are_read_as_stored(tree):
    view = first(tree)
    assert view.normal().shape == (*SHAPE, 3) and view.normal().dtype == np.float16
    assert view.instance().dtype == np.int16 and (view.instance() == -1).all()


def test_pose_is_in_metres(tree):
    position, orientation = Hypersim(tree).view("ai_001_001", "cam_00", 42).pose()
    np.testing.assert_allclose(position, 0.0254 * np.array([126, 127, 128]))
    np.testing.assert_array_equal(orientation, np.eye(3))


# --- range -----------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", PROJECTIONS)
def test_depth_is_range_already(tree, scene):
    """Along its rays a wall is flat as it stands; a second conversion would bend it."""
    view = Hypersim(tree).view(scene, "cam_00", 0)
    write_official(view.path("depth"), wall(PROJECTIONS[scene]).astype(np.float32))
    normal = np.array([0.3, -0.2, 1.0]) / np.linalg.norm([0.3, -0.2, 1.0])
    frame, rays = view.frame(), official_rays(PROJECTIONS[scene])
    np.testing.assert_allclose((rays * frame.depth[..., None]) @ normal, -2.0, atol=1e-6)
    twice = frame.depth / np.abs(rays[..., 2])
    assert np.ptp((rays * twice[..., None]) @ normal) > 0.05


@pytest.mark.parametrize("scene", PROJECTIONS)
def test_a_sphere_round_the_camera_has_one_depth(tree, scene):
    """And with the frame's own camera its points lie on that sphere again."""
    view = Hypersim(tree).view(scene, "cam_00", 0)
    write_official(view.path("depth"), np.full(SHAPE, 3.25, np.float32))
    frame = view.frame()
    assert np.unique(frame.depth).tolist() == [3.25]
    assert frame.camera is not None
    points = points_from_depth(frame.depth, frame.camera)
    np.testing.assert_allclose(np.linalg.norm(points, axis=-1), 3.25, rtol=1e-6)


def test_rays_follow_the_projection_of_each_scene(tree):
    for scene, projection in PROJECTIONS.items():
        view = Hypersim(tree).view(scene, "cam_01", 3)
        np.testing.assert_allclose(view.rays(), official_rays(projection), atol=1e-12)


def test_a_tilted_camera_keeps_a_wall_flat(tree):
    """Points by the frame's camera are the true ones, turned: still a plane, 2 m away."""
    view = Hypersim(tree).view("ai_001_002", "cam_00", 0)
    write_official(view.path("depth"), wall(PROJECTIONS["ai_001_002"]).astype(np.float32))
    frame = view.frame()
    assert frame.camera is not None
    points = points_from_depth(frame.depth, frame.camera).reshape(-1, 3)
    normal = np.linalg.lstsq(points, np.ones(len(points)), rcond=None)[0]
    assert 1 / np.linalg.norm(normal) == pytest.approx(2.0, abs=1e-5)
    np.testing.assert_allclose(points @ normal, 1.0, atol=1e-5)


def test_smoothing_is_an_option_and_marked(tree):
    view = first(tree)
    smooth = view.frame(smooth=True)
    assert smooth.note == "float16 depth smoothed within its steps of up to 2.0 mm"
    expected = smoothed_within_step(view.depth())[1:]
    np.testing.assert_array_equal(smooth.depth[1:], expected.astype(np.float32))


def test_float32_depth_is_never_smoothed(tree):
    view = first(tree)
    write_official(view.path("depth"), wall(PLAIN).astype(np.float32))
    frame = view.frame(smooth=True)
    np.testing.assert_array_equal(frame.depth, wall(PLAIN).astype(np.float32))
    assert frame.note == ""


# --- what is missing or broken ---------------------------------------------------------------


def truncated(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def without_key(path):
    with h5py.File(path, "w") as file:
        file.create_dataset("data", data=np.ones(SHAPE))


def damaged(name):
    def damage(path):
        write_official(path, {"flat": np.ones(5), "empty": np.ones((0, 0)),
                              "words": np.array([[b"a"]]), "deep": np.ones((*SHAPE, 2)),
                              "void": np.full(SHAPE, np.nan)}[name])  # fmt: skip

    return damage


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (truncated, "whole HDF5 file"),
        (without_key, "key dataset"),
        (lambda path: path.write_bytes(b"<html>not found</html>"), "whole HDF5 file"),
        (lambda path: path.write_bytes(b""), "whole HDF5 file"),
        (damaged("flat"), "numbers on 2 axes"),
        (damaged("empty"), "numbers on 2 axes"),
        (damaged("words"), "numbers on 2 axes"),
        (damaged("deep"), "numbers on 2 axes"),
        (damaged("void"), "none above 0"),
    ],
)
def test_a_broken_depth_file_is_named_with_its_remedy(tree, damage, message):
    view = first(tree)
    damage(view.path("depth"))
    with pytest.raises(ValueError, match=message) as error:
        view.frame()
    assert "ai_001_001" in str(error.value)
    assert str(error.value).rstrip(".").split(". ")[-1].split()[0] in ("Fetch", "Check")


def test_colour_of_another_shape_is_refused(tree):
    view = first(tree)
    write_official(view.path("color"), np.ones((4, 4, 3), np.float16))
    with pytest.raises(ValueError, match=r"one shape .* ai_001_001/cam_00/0000"):
        view.frame()
    write_official(view.path("color"), np.ones(SHAPE, np.float16))
    with pytest.raises(ValueError, match="numbers on 3 axes, the last of 3"):
        view.frame()


def test_missing_files_are_named(tree):
    view = first(tree)
    view.path("color").unlink()
    with pytest.raises(FileNotFoundError, match=r"frame\.0000\.color\.hdf5 .* Fetch"):
        view.frame()
    view.path("depth").unlink()
    with pytest.raises(FileNotFoundError, match=r"frame\.0000\.depth_meters\.hdf5"):
        view.frame(blank=True)


def test_a_tree_with_broken_frames_is_read_through(tree):
    truncated(geometry(tree, "ai_001_001") / "frame.0042.depth_meters.hdf5")
    (final(tree, "ai_001_002") / "frame.0000.color.hdf5").unlink()
    frames = Hypersim(tree).frames()
    names = [frame.name for frame in frames]
    assert len(names) == 7
    assert set(frames.skipped) == {"ai_001_001/cam_00/0042", "ai_001_002/cam_00/0000"}
    assert "whole HDF5 file" in frames.skipped["ai_001_001/cam_00/0042"]
    assert [frame.name for frame in frames] == names and len(frames.skipped) == 2


def test_views_without_colour_are_read_if_asked_for(tree):
    (final(tree, "ai_001_002") / "frame.0000.color.hdf5").unlink()
    frames = list(Hypersim(tree).frames(blank=True))
    assert len(frames) == 9
    notes = [frame.note for frame in frames if "intensity 1" in frame.note]
    assert len(notes) == 1


def test_without_its_table_a_frame_has_no_camera(tree):
    (tree / "metadata_camera_parameters.csv").unlink()
    assert first(tree).frame().camera is None
    with pytest.raises(ValueError, match=r"metadata_camera_parameters\.csv .* Fetch"):
        first(tree).rays()


def test_without_its_table_a_tree_has_no_split(tree):
    (tree / "metadata_images_split_scene_v1.csv").unlink()
    with pytest.raises(
        FileNotFoundError, match=r"metadata_images_split_scene_v1\.csv in or beside"
    ):
        Hypersim(tree).split()
    assert Hypersim(tree).test_views() == []


@pytest.mark.parametrize("place", ["..", "metadata", "analysis", "../metadata", "../analysis"])
def test_tables_are_found_beside_and_above_the_scenes(tree, place):
    folder = tree / place
    folder.mkdir(exist_ok=True)
    for table in tree.glob("*.csv"):
        table.rename(folder / table.name)
    assert first(tree).frame().camera is not None
    assert len(Hypersim(tree).split()["test"]) == 2


@pytest.mark.parametrize(
    ("name", "rows", "message"),
    [
        ("metadata_camera_parameters.csv", [["scene_name"], ["a"]], "no column M_cam_from_uv_00"),
        ("metadata_camera_parameters.csv", [], "no column scene_name"),
        ("metadata_images_split_scene_v1.csv", [["scene_name"]], "no column camera_name"),
        (
            "metadata_images_split_scene_v1.csv",
            [["scene_name", "camera_name", "frame_id", "split_partition_name"], list("abcd")],
            "frame number in line 2",
        ),
        (
            "metadata_images_split_scene_v1.csv",
            [["scene_name", "camera_name", "frame_id", "split_partition_name"], list("ab")],
            "line 2 is short",
        ),
    ],
)
def test_damaged_tables_are_named(tree, name, rows, message):
    write_rows(tree / name, rows)
    with pytest.raises(ValueError, match=message) as error:
        _ = Hypersim(tree).projections, Hypersim(tree).split()
    assert name in str(error.value) and "Fetch the table anew" in str(error.value)


def test_a_number_that_is_none_in_the_camera_table_is_named(tree):
    path = tree / "metadata_camera_parameters.csv"
    path.write_text(path.read_text().replace("-1.0", "minus one"))
    with pytest.raises(ValueError, match=r"numbers in line 2 of .*could not convert"):
        _ = Hypersim(tree).projections


def test_a_pose_that_is_missing_is_named(tree):
    detail = tree / "ai_001_001" / "_detail"
    (detail / "metadata_scene.csv").write_text("parameter_name,parameter_value\n")
    with pytest.raises(ValueError, match="meters_per_asset_unit"):
        first(tree).pose()
    write_official(detail / "cam_00" / "camera_keyframe_frame_indices.hdf5", np.arange(3) + 7)
    with pytest.raises(ValueError, match="one pose of frame 0"):
        first(tree).pose()


def test_folders_that_are_no_tree_are_refused(tmp_path):
    with pytest.raises(ValueError, match="Expected scenes such as"):
        Hypersim(tmp_path)
    with pytest.raises(FileNotFoundError, match="folder of scenes"):
        Hypersim(tmp_path / "nowhere")


# --- splits of what is on disk -----------------------------------------------------------------


def test_default_split_of_the_tree(tree):
    """Both ai_VVV_001 are tested at frame 42, so neither of them trains; frame 7 was never out."""
    split = Hypersim(tree).split()
    assert [v.name for v in split["test"]] == ["ai_001_001/cam_00/0042", "ai_002_001/cam_00/0042"]
    assert {view.scene for view in split["train"]} == {"ai_001_002"}
    assert split["val"] == []


def test_split_lists_only_what_is_on_disk(tree):
    (geometry(tree, "ai_001_001") / "frame.0042.depth_meters.hdf5").unlink()
    split = Hypersim(tree).split()
    assert [view.scene for view in split["test"]] == ["ai_002_001"]
    assert {view.scene for view in split["train"]} == {"ai_001_002"}


def test_official_split_of_the_tree(tree):
    split = Hypersim(tree).split("official")
    assert [len(split[name]) for name in ("train", "val", "test")] == [6, 0, 3]


# --- the one door --------------------------------------------------------------------------------


def test_load_frame_takes_a_depth_file_of_a_tree(tree):
    path = geometry(tree, "ai_001_002") / "frame.0042.depth_meters.hdf5"
    frame = load_frame(path)
    assert frame.name == "ai_001_002/cam_00/0042"
    np.testing.assert_array_equal(frame.depth, view_of_file(path).frame().depth)
    assert load_frame(path, smooth=True).note.startswith("float16 depth smoothed")


def test_load_frame_takes_the_first_test_frame_of_a_tree(tree):
    assert load_frame(tree).name == "ai_001_001/cam_00/0042"
    (tree / "metadata_images_split_scene_v1.csv").unlink()
    assert load_frame(tree).name == "ai_001_001/cam_00/0000"


def test_a_depth_file_without_colour_loads_with_intensity_1(tree):
    path = geometry(tree, "ai_001_001") / "frame.0000.depth_meters.hdf5"
    first(tree).path("color").unlink()
    frame = load_frame(path)
    assert (frame.intensity == 1).all()
    assert frame.note.endswith("no colour file: intensity 1 everywhere")


@pytest.mark.parametrize("name", ["frame.0000.semantic_instance.hdf5", "depth.hdf5"])
def test_other_files_of_a_tree_are_no_depth(tree, name):
    path = geometry(tree, "ai_001_001") / name
    write_official(path, np.ones(SHAPE))
    with pytest.raises(ValueError, match="Keep the layout"):
        load_frame(path)


def test_a_depth_file_outside_a_tree_is_refused(tmp_path):
    write_official(tmp_path / "frame.0000.depth_meters.hdf5", np.ones(SHAPE))
    with pytest.raises(ValueError, match="Expected a depth file SCENE/images"):
        load_frame(tmp_path / "frame.0000.depth_meters.hdf5")


def test_the_public_depth_file_loads(official_tables):
    """The one frame that stands in the repository: float16, tilt-shift, no colour beside it."""
    path = next(official_tables.rglob("frame.0000.depth_meters.hdf5"))
    frame = load_frame(path)
    assert frame.depth.shape == (768, 1024) and np.isfinite(frame.depth).all()
    assert frame.depth.min() == pytest.approx(2.96, abs=0.01)
    assert frame.note == (
        "float16 depth in steps of up to 7.8 mm; no colour file: intensity 1 everywhere"
    )
    assert frame.camera is not None and len(frame.camera) == 4
    rays, (_, _, cx, cy) = view_of_file(path).rays(), frame.camera
    assert abs(cx - 512) > 50 and abs(cy - 384) > 50  # shifted
    assert np.allclose(np.linalg.norm(rays, axis=-1), 1)
    frames = Hypersim(official_tables).frames()
    assert list(frames) == [] and list(frames.skipped) == ["ai_037_002/cam_00/0000"]
