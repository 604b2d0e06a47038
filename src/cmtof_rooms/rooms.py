"""Furnished rooms from a seed, with their light and their cameras."""

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from cmtof_rooms.boxes import Rectangle, Rectangles
from cmtof_rooms.building import build_shell
from cmtof_rooms.cameras import Cameras, Lens, room_cameras
from cmtof_rooms.furnishing import Furnishing
from cmtof_rooms.interior import Interior
from cmtof_rooms.kit import Kit, household, weighted_choice
from cmtof_rooms.presets import presets
from cmtof_rooms.shell import Shell, Wall
from cmtof_rooms.things import Light, Thing, level_light

LIGHTS = 4  # lights that a room has at most: rays are sent to each

# streams of random numbers of one room, so that more views never change the room
ROOM, CAMERAS, _, LENS, EXPOSURE = range(5)


def stream(seed: int, index: int, use: int) -> Generator:
    """Random numbers of one room that no other and no other use of it share."""
    return np.random.default_rng([seed, index, use])


def room_name(seed: int, index: int) -> str:
    """Folder of a room, by seed and place in the set.

    >>> room_name(0, 7)
    'room_000_007'
    """
    return f"room_{seed:03d}_{index:03d}"


@dataclass(frozen=True)
class FurnishedRoom:
    """A furnished room with its light; cameras are drawn from it.

    Attributes
    ----------
    seed, index : int
        Of the set, and the room's place in it.
    interior : Interior
    floor : list of Rectangle
    height : float
        Of the ceiling, m.
    """

    seed: int
    index: int
    interior: Interior
    floor: Rectangles
    height: float

    @property
    def name(self) -> str:
        """Folder of the room, see `room_name`."""
        return room_name(self.seed, self.index)

    def cameras(self, views: int, lens: Lens) -> Cameras:
        """Poses, one in twenty a close one; the first stay the same when more are asked for."""
        return room_cameras(
            [(7 * self.index + number) % 20 == 19 for number in range(views)],
            self.interior,
            lens,
            floor=self.floor,
            height=self.height,
            rng=stream(self.seed, self.index, CAMERAS),
        )


def build_room(seed: int, index: int) -> FurnishedRoom:
    """Build, furnish and light one room; the same pair of numbers gives the same room."""
    rng = stream(seed, index, ROOM)
    rooms = presets()["rooms"]
    kind = weighted_choice(rng, {name: room["weight"] for name, room in rooms.items()})
    kit = household(rng)
    shell = build_shell(kit, rooms[kind])
    inside = Furnishing(shell, kit)
    tidy = kit.between(0.7, 1.5)
    inside.fill({name: tidy * mean for name, mean in rooms[kind]["things"].items()})
    for wall in shell.beyond:
        inside.things += _things_beyond(wall, kit)
    interior = Interior(
        shell.things + inside.things,
        _strongest(shell, inside.lights),
        [np.full(3, 0.1), np.subtract(shell.size, 0.1)],
        sky=shell.sky,
    )
    return FurnishedRoom(seed, index, interior, shell.floor, shell.height)


def _things_beyond(wall: Wall, kit: Kit) -> list[Thing]:
    """Furniture at the far wall of a room beyond a passage."""
    everywhere = Rectangle(-99.0, 99.0, -99.0, 99.0)
    far = Furnishing(Shell(0.0, 0.0, 2.0, [wall], [everywhere]), kit)
    far.fill(presets()["beyond"])
    return far.things


def _strongest(shell: Shell, lamps: list[Light]) -> list[Light]:
    """At most `LIGHTS` lights; the strongest lamps shine for those that were left out."""
    if not shell.lights and not lamps:  # a lamp that nobody sees
        width, depth, height = shell.size
        lamps = [level_light((width / 2, depth / 2, height - 0.05), 0.3, 0.3, 2.0)]
    dimmed = 0.15 if shell.day else 1.0
    lamps = [lamp._replace(power=lamp.power * dimmed) for lamp in lamps]
    every = sorted([*shell.lights, *lamps], key=lambda light: -light.power)
    kept = every[:LIGHTS]
    more = sum(light.power for light in every) / sum(light.power for light in kept)
    return [light._replace(power=light.power * more) for light in kept]
