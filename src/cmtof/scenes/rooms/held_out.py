"""Frames to test on, from rooms that nothing was trained on.

Training takes the rooms of seed 1; seed 3 belongs to the tables. Of its scenes only those that
`cmtof.scenes.rooms.rendering.split_of` tests are built, every tenth, and of each only the first
view across the room: what the rule ``scenes`` of `cmtof.scenes.hypersim` keeps of a rendered set.
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context

from cmtof.scenes.frame import Frame
from cmtof.scenes.rooms.rendering import Settings, frame_of, render_view, split_of
from cmtof.scenes.rooms.scene import build

TEST_ROOMS = Settings(seed=3, scenes=460)
"""The rooms of the tables: 46 test frames of 512x512, as many as the paper has."""


def held_out(settings: Settings = TEST_ROOMS) -> list[int]:
    """Test scenes of a set, by their place in it.

    Examples
    --------
    >>> held_out(Settings(seed=3, scenes=40))
    [9, 19, 29, 39]
    """
    return [index for index in range(settings.scenes) if split_of(index) == "test"]


def held_out_frame(settings: Settings, index: int) -> Frame:
    """First view across the room of one scene, as in a set of two views or more."""
    scene, lens = build(settings.seed, index), settings.lens(index)
    pose = scene.cameras(2, lens)["cam_00"][0]
    return frame_of(render_view(scene, pose, lens, 0), lens, f"{scene.name}/cam_00")


def held_out_frames(
    settings: Settings = TEST_ROOMS, *, count: int | None = None, workers: int = 1
) -> Iterator[Frame]:
    """Render test frames one after the other, in the order of `held_out`.

    Parameters
    ----------
    settings : Settings
        What the set is made from; how many views each scene has does not matter.
    count : int, optional
        How many, from the first; by default all.
    workers : int
        Processes.
    """
    indices = held_out(settings)[:count]
    if workers > 1:
        yield from _rendered_together(settings, indices, workers)
    else:
        yield from (held_out_frame(settings, index) for index in indices)


def _rendered_together(settings: Settings, indices: Sequence[int], workers: int) -> Iterator[Frame]:
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        try:
            yield from pool.map(partial(held_out_frame, settings), indices)
        finally:
            pool.shutdown(cancel_futures=True)
