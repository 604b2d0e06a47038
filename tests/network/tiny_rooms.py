"""A tree of ten small scenes in Hypersim's layout: a minute of rendering done in a second."""

from pathlib import Path

import numpy as np

from cmtof.scenes.hypersim import write_metadata, write_scene, write_view

SIDE = 64
VIEWS = (("cam_00", 0), ("cam_00", 1))


def partition(scene: int) -> str:
    """Of ten scenes one validates and one tests."""
    return {8: "val", 9: "test"}.get(scene, "train")


def wall(seed: int, shape: tuple[int, int] = (SIDE, SIDE)) -> tuple[np.ndarray, np.ndarray]:
    """Depth, m, and intensity of a tilted wall with a box before it; some of it is unknown."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(0, 1, shape[1]), np.linspace(0, 1, shape[0]))
    a, b = rng.uniform(-0.4, 0.4, 2)
    depth = rng.uniform(1.5, 3) + a * x + b * y
    depth[shape[0] // 4 : shape[0] // 2, shape[1] // 4 : shape[1] // 2] -= 0.4
    depth[:2, :3] = np.nan
    return depth.astype(np.float32), (0.3 + 0.9 * rng.uniform(size=shape)).astype(np.float32)


def write_room(root: Path, scene: str, frame: int, seed: int, shape=(SIDE, SIDE)) -> None:
    """Write one view."""
    depth, intensity = wall(seed, shape)
    write_view(
        root, scene, "cam_00", frame,
        color=np.repeat(intensity[..., None], 3, 2), depth=depth,
        normal=np.zeros((*shape, 3)), instance=np.zeros(shape, int),
    )  # fmt: skip


def write_rooms(root: Path, shape: tuple[int, int] = (SIDE, SIDE), scenes: int = 10) -> Path:
    """Write the tree, two views a scene."""
    names = {f"room_000_{number:03d}": partition(number) for number in range(scenes)}
    poses = (np.zeros((2, 3)), np.tile(np.eye(3), (2, 1, 1)))
    for number, scene in enumerate(names):
        write_scene(root, scene, cameras={"cam_00": poses})
        for _, frame in VIEWS:
            write_room(root, scene, frame, 2 * number + frame, shape)
    write_metadata(root, names, shape=shape, focal=60.0, views=dict.fromkeys(names, VIEWS))
    return root
