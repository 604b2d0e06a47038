"""A Hypersim tree written from the published description, by other code than the package's."""

import csv
import itertools

import h5py
import numpy as np
from vectors import unit

SHAPE = (24, 32)
PLAIN = np.diag([0.5773502886169104, 0.4330127164626828, -1.0])
TILTED = np.array(  # the official row of ai_037_002
    [
        [0.579607251426182, 0.0, -0.06955286861651404],
        [0.0, 0.4346865334657201, 0.09273312506660672],
        [0.0, 0.004054126980668954, -1.003909173803896],
    ]
)
PROJECTIONS = {"ai_001_001": PLAIN, "ai_001_002": TILTED, "ai_002_001": PLAIN}
PARTITIONS = {"ai_001_001": "train", "ai_001_002": "train", "ai_002_001": "test"}
VIEWS = [("cam_00", 0), ("cam_00", 42), ("cam_01", 3)]


def official_rays(projection):
    """Rays as the data set's authors describe them: uv from -1 to 1, v up, half a pixel inwards."""
    height, width = SHAPE
    u = np.linspace(-1 + 1 / width, 1 - 1 / width, width)
    v = np.linspace(-1 + 1 / height, 1 - 1 / height, height)[::-1]
    return unit(np.stack([*np.meshgrid(u, v), np.ones(SHAPE)], axis=-1) @ projection.T)


def wall(projection):
    """Range of a slanted plane, 2 m away."""
    normal = np.array([0.3, -0.2, 1.0])
    return -2.0 * np.linalg.norm(normal) / (official_rays(projection) @ normal)


def write_official(path, array):
    path.parent.mkdir(parents=True, exist_ok=True)
    with h5py.File(path, "w") as file:
        file.create_dataset(
            "dataset", data=array, compression="gzip", compression_opts=9
        )


def write_rows(path, rows):
    with path.open("w", newline="") as file:
        csv.writer(file).writerows(rows)


def write_views(root):
    """Depth and colour of three views of each scene."""
    color = np.broadcast_to(np.array([0.2, 0.5, 0.9], np.float16), (*SHAPE, 3)).copy()
    color[5, 5] = np.nan
    color[6, 6] = np.inf
    color[7, 7] = -1
    for (scene, projection), (camera, number) in itertools.product(
        PROJECTIONS.items(), VIEWS
    ):
        depth = wall(projection).astype(np.float16)
        depth[0, :3] = np.nan, np.inf, 0
        images = root / scene / "images"
        name = f"frame.{number:04d}"
        write_official(
            images / f"scene_{camera}_geometry_hdf5/{name}.depth_meters.hdf5", depth
        )
        write_official(images / f"scene_{camera}_final_hdf5/{name}.color.hdf5", color)


def write_tables(root):
    """Cameras of the scenes, and partitions of the views, one of them withdrawn."""
    matrix = [f"M_cam_from_uv_{i}{j}" for i in range(3) for j in range(3)]
    head = ["scene_name", "settings_output_img_height", "use_camera_physical", *matrix]
    rows = [[s, 24.0, False, *m.ravel()] for s, m in PROJECTIONS.items()]
    write_rows(root / "metadata_camera_parameters.csv", [head, *rows])
    head = ["scene_name", "camera_name", "frame_id", "included_in_public_release"]
    head += ["exclude_reason", "split_partition_name"]
    rows = [[s, c, f, True, "", p] for s, p in PARTITIONS.items() for c, f in VIEWS]
    hidden = ["ai_002_001", "cam_00", 7, False, "CONTENT FLAGGED FOR REMOVAL", ""]
    write_rows(root / "metadata_images_split_scene_v1.csv", [head, *rows, hidden])


def write_tree(root):
    """Three official scenes of three views each, and both tables."""
    write_views(root)
    write_tables(root)
    return root
