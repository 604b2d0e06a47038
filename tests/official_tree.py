"""A Hypersim tree written from the published description, by other code than the package's."""

import csv
import itertools

import h5py
import numpy as np
from vectors import unit

SHAPE = (24, 32)
# Cameras of the scenes; that of the second is the official row of ai_037_002.
CAMERAS = """\
scene_name,settings_output_img_height,use_camera_physical,\
M_cam_from_uv_00,M_cam_from_uv_01,M_cam_from_uv_02,\
M_cam_from_uv_10,M_cam_from_uv_11,M_cam_from_uv_12,\
M_cam_from_uv_20,M_cam_from_uv_21,M_cam_from_uv_22
ai_001_001,24.0,False,0.5773502886169104,0.0,0.0,0.0,0.4330127164626828,0.0,0.0,0.0,-1.0
ai_001_002,24.0,False,0.579607251426182,0.0,-0.06955286861651404,\
0.0,0.4346865334657201,0.09273312506660672,0.0,0.004054126980668954,-1.003909173803896
ai_002_001,24.0,False,0.5773502886169104,0.0,0.0,0.0,0.4330127164626828,0.0,0.0,0.0,-1.0
"""
# Partitions of the views, of which the last was withdrawn.
SPLIT = """\
scene_name,camera_name,frame_id,included_in_public_release,exclude_reason,split_partition_name
ai_001_001,cam_00,0,True,,train
ai_001_001,cam_00,42,True,,train
ai_001_001,cam_01,3,True,,train
ai_001_002,cam_00,0,True,,train
ai_001_002,cam_00,42,True,,train
ai_001_002,cam_01,3,True,,train
ai_002_001,cam_00,0,True,,test
ai_002_001,cam_00,42,True,,test
ai_002_001,cam_01,3,True,,test
ai_002_001,cam_00,7,False,CONTENT FLAGGED FOR REMOVAL,
"""
PROJECTIONS = {
    scene: np.reshape(matrix, (3, 3)).astype(float)
    for scene, _, _, *matrix in csv.reader(CAMERAS.splitlines()[1:])
}
PLAIN = PROJECTIONS["ai_001_001"]
VIEWS = [("cam_00", 0), ("cam_00", 42), ("cam_01", 3)]


def wall(projection):
    """Range of a slanted plane, 2 m away.

    Rays are as the data set's authors describe them: uv from -1 to 1, v up, half a pixel inwards.
    """
    y, x = (np.indices(SHAPE) + 0.5) / np.reshape(SHAPE, (2, 1, 1))
    uv = np.stack([2 * x - 1, 1 - 2 * y, np.ones(SHAPE)], axis=-1)
    normal = [0.3, -0.2, 1.0]
    return -2.0 * np.linalg.norm(normal) / (unit(uv @ projection.T) @ normal)


def write_official(path, array):
    path.parent.mkdir(parents=True, exist_ok=True)
    with h5py.File(path, "w") as file:
        file.create_dataset(
            "dataset", data=array, compression="gzip", compression_opts=9
        )


def write_tree(root):
    """Three official scenes of three views each, and both tables."""
    color = np.full((*SHAPE, 3), [0.2, 0.5, 0.9], np.float16)
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
    (root / "metadata_camera_parameters.csv").write_text(CAMERAS)
    (root / "metadata_images_split_scene_v1.csv").write_text(SPLIT)
    return root
