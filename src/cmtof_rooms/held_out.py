"""The test set that the package contains: how its views were chosen, and how to render them again.

The rule, the same for all: of the rooms of seed 3 those that `split_of` tests (no network was
trained or validated on them), in order, the first view across the room of each, 384 x 512, if the
released protocol scores between a fifth and nine tenths of its pixels; the first 32 of them.
"""

from collections.abc import Iterator
from dataclasses import replace

from cmtof.frame import Frame, held_out_frames
from cmtof.simulation import simulate
from cmtof_rooms.rendering import Settings, list_views, split_of, views_of_room

SETTINGS = Settings(seed=3, scenes=10_000, views=2, height=384, width=512)


def view_across(index: int, settings: Settings) -> Frame:
    """First view across the room with number ``index``."""
    return next(views_of_room(settings, index, list_views(settings, index))).frame


def views_of_size(height: int, width: int) -> list[Frame]:
    """The 32 views of the test set, rendered at another size, px."""
    settings = replace(SETTINGS, height=height, width=width)
    rooms = [frame.name.partition("/")[0] for frame in held_out_frames()]
    return [view_across(int(room.rpartition("_")[2]), settings) for room in rooms]


def views(seed: int = SETTINGS.seed, *, tested: bool = True) -> Iterator[Frame]:
    """Views with 20 to 90 % of pixels scored, of test rooms or, not ``tested``, of all others."""
    settings = replace(SETTINGS, seed=seed)
    for index in range(settings.scenes):
        if (split_of(index) == "test") == tested:
            frame = view_across(index, settings)
            scored = simulate(frame, noise_free=True).mask.mean()
            if 0.2 <= scored <= 0.9:
                yield frame
