"""Furnished rooms from a seed, with their light and their cameras."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.random import Generator

from cmtof_rooms.boxes import Box, Boxes
from cmtof_rooms.building import build_shell
from cmtof_rooms.cameras import (
    Cameras,
    Lens,
    camera_across,
    camera_close,
    choose_cameras,
    middles_of,
    range_across,
    range_close,
)
from cmtof_rooms.furnishing import Furnishing
from cmtof_rooms.interior import Interior
from cmtof_rooms.kit import household, weighted_choice
from cmtof_rooms.presets import presets
from cmtof_rooms.shell import Shell
from cmtof_rooms.things import Light, Thing, level_light

CLOSE_SHARE = 0.05  # share of a set's views that are taken from 0.5 to 1.2 m

LIGHTS = 4  # lights that a room has at most: rays are sent to each

# streams of random numbers of one room, so that more views never change the room
ROOM, ACROSS, CLOSE, LENS, EXPOSURE = range(5)


def stream(seed: int, index: int, use: int) -> Generator:
    """Random generator for one ``use`` in one room, independent of other uses and rooms."""
    return np.random.default_rng([seed, index, use])


def room_name(seed: int, index: int) -> str:
    """Folder of a room, by seed and place in the set.

    >>> room_name(0, 7)
    'room_000_007'
    """
    return f"room_{seed:03d}_{index:03d}"


def count_views(index: int, views: int) -> dict[str, int]:
    """How many of a room's views each camera has; over many rooms `CLOSE_SHARE` are close ones.

    >>> [count_views(i, 5)["cam_01"] for i in range(8)]
    [0, 0, 0, 1, 0, 0, 0, 1]
    """
    share = round(views * CLOSE_SHARE, 9)
    close = int((index + 1) * share) - int(index * share)
    return {"cam_00": views - close, "cam_01": close}


@dataclass(frozen=True)
class FurnishedRoom:
    """A furnished room with its light; cameras are drawn from it.

    Attributes
    ----------
    seed, index : int
        Of the set, and the room's place in it.
    interior : Interior
    floor : list of Box
        Pieces of its space, as high as the ceiling.
    furniture : list of Thing
        What does not belong to the house itself; of an empty room, everything.
    """

    seed: int
    index: int
    interior: Interior
    floor: Boxes
    furniture: list[Thing]

    def cameras(self, views: int, lens: Lens) -> dict[str, Cameras]:
        """Poses of ``cam_00`` (across the room) and ``cam_01`` (close to things).

        Together ``views``; those of ``cam_00`` stay the same when more are asked for, and mostly
        those of ``cam_01``.
        """
        counts = count_views(self.index, views)
        choose = partial(choose_cameras, self.interior, lens)
        return {
            "cam_00": choose(
                counts["cam_00"],
                stream(self.seed, self.index, ACROSS),
                range_across,
                partial(camera_across, self.floor),
            ),
            "cam_01": choose(
                counts["cam_01"],
                stream(self.seed, self.index, CLOSE),
                range_close,
                partial(camera_close, middles_of(self.furniture)),
            ),
        }


def build_room(seed: int, index: int) -> FurnishedRoom:
    """Build, furnish and light one room; the same pair of numbers gives the same room."""
    rng = stream(seed, index, ROOM)
    rooms = list(presets()["rooms"].values())
    room = weighted_choice(rng, rooms, [room["weight"] for room in rooms])
    kit = household(rng)
    shell = build_shell(kit, room)
    inside = Furnishing(shell, kit, clear=list(shell.keep))
    tidy = kit.between(0.7, 1.5)
    inside.fill({name: tidy * mean for name, mean in room["things"].items()})
    everywhere = Box(-99.0, 99.0, -99.0, 99.0, 0.0, 99.0)
    for wall in shell.beyond:  # furniture at the far wall of a room beyond a passage
        far = Furnishing(Shell(0.0, 0.0, 2.0, [wall], [everywhere]), kit)
        far.fill(presets()["beyond"])
        inside.things += far.things
    interior = Interior(
        shell.things + inside.things,
        _strongest(shell, inside.lights),
        [np.full(3, 0.1), np.array([shell.width, shell.depth, shell.height]) - 0.1],
        sky=shell.sky,
    )
    return FurnishedRoom(
        seed,
        index,
        interior,
        shell.floor,
        inside.things or shell.things,
    )


def _strongest(shell: Shell, lamps: list[Light]) -> list[Light]:
    """The `LIGHTS` strongest lights at most, brightened by the power of those left out."""
    if not shell.lights and not lamps:  # a lamp that nobody sees
        middle = (shell.width / 2, shell.depth / 2, shell.height - 0.05)
        lamps = [level_light(middle, 0.3, 2.0)]
    dimmed = 0.15 if shell.day else 1.0
    lamps = [lamp._replace(power=lamp.power * dimmed) for lamp in lamps]
    every = sorted([*shell.lights, *lamps], key=lambda light: -light.power)
    kept = every[:LIGHTS]
    more = sum(light.power for light in every) / sum(light.power for light in kept)
    return [light._replace(power=light.power * more) for light in kept]
