"""Frames that travel with the package: the test set, rendered again.

    python -m cmtof_book.frames [FILE]

The rule, the same for all: of the rooms of seed 3 those that `split_of` tests (no network was
trained or validated on them), in order, the first view across the room of each, 384 x 512, if the
released protocol scores between a fifth and nine tenths of its pixels; the first 32 of them.
"""

import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np

from cmtof.files import written_whole
from cmtof.frame import HELD_OUT, HELD_OUT_STEP, Frame, held_out_frames
from cmtof.simulation import simulate
from cmtof_rooms.rendering import Settings, frame_of, render_view, split_of
from cmtof_rooms.rooms import build_room

SETTINGS = Settings(seed=3, scenes=10_000, views=2, height=384, width=512)
COUNT, COVERAGE = 32, (0.2, 0.9)


def view_across(index: int, settings: Settings) -> Frame:
    """First view across the room of that number."""
    room = build_room(settings.seed, index)
    lens = settings.lens(index)
    pose = room.cameras(settings.views, lens)[0]
    return frame_of(render_view(room, pose, lens, 0), lens, f"{room.name}/cam_00")


def views_of_size(height: int, width: int) -> list[Frame]:
    """The test views, rendered at another size."""
    settings = replace(SETTINGS, height=height, width=width)
    rooms = [frame.name.partition("/")[0] for frame in held_out_frames()]
    return [view_across(int(room.rpartition("_")[2]), settings) for room in rooms]


def views(settings: Settings = SETTINGS, *, tested: bool = True) -> Iterator[Frame]:
    """Views that fit the rule; prints the share of pixels that the released protocol scores.

    Without ``tested`` they are of the rooms that networks train and validate on.
    """
    for index in range(settings.scenes):
        if (split_of(index) == "test") != tested:
            continue
        frame = view_across(index, settings)
        coverage = simulate(frame, noise_free=True).mask.mean()
        if COVERAGE[0] <= coverage <= COVERAGE[1]:
            print(f"{frame.name}: {coverage:.0%} scored", flush=True)
            yield frame


def store(path: Path, frames: list[Frame]) -> None:
    """Write what `cmtof.frame.held_out_frames` reads."""
    depth = np.nan_to_num(np.stack([frame.depth for frame in frames]).astype(float))
    steps = np.round(depth / HELD_OUT_STEP).astype(np.int32)
    light = np.clip([frame.intensity for frame in frames], 0, 1)
    levels = np.round(255 * np.sqrt(light)).astype(np.uint8)
    with written_whole(path) as part:
        np.savez_compressed(
            part,
            depth=_differences(_differences(steps)),
            intensity=_differences(levels),
            camera=np.stack(
                [frame.camera for frame in frames if frame.camera is not None]
            ),
            name=[frame.name for frame in frames],
        )


def _differences(images: np.ndarray) -> np.ndarray:
    """What each pixel adds to that on its left, of the same type; they pack better."""
    return np.diff(images, axis=2, prepend=images.dtype.type(0))


if __name__ == "__main__":
    store(Path(*sys.argv[1:2] or [HELD_OUT]), [*islice(views(), COUNT)])
