"""Shell of a room: walls with openings, floor, slopes; what stands before anything is put in.

The room is a rectangle, 0 to width by 0 to depth, m, from which a block may be cut off in one
corner (an L). A wall's own frame has x along it and y outwards.
"""

from dataclasses import dataclass, field

import numpy as np
from trimesh import Trimesh

from cmtof_rooms.boxes import Box, Boxes, Triple
from cmtof_rooms.solids import move, plate
from cmtof_rooms.things import Light, Place, Thing

THICKNESS = 0.15  # of walls, m


@dataclass
class Wall:
    """One side of a room."""

    place: Place  # its left end, seen from inside
    length: float  # m
    taken: Boxes = field(default_factory=list)  # where nothing else is placed
    holes: Boxes = field(default_factory=list)  # what is cut out of it

    def in_room(self, box: Box) -> Box:
        """A box of the wall's own frame in that of the room; walls along x or y only."""
        corners = np.sort(self.place.carry([box.low, box.high]), axis=0)
        return Box(*corners.T.flat)

    def take(self, box: Box, side: float = 0.05, above: float = 0.05) -> None:
        """Let nothing be in or before the wall at a box and in margins, m, beside and above it."""
        around = box.inset(x=-side, z0=-0.03, z1=-above)
        self.taken.append(around.cut(y0=-99.0, y1=99.0))

    def cut(self, hole: Box, **margins: float) -> None:
        """Cut a hole, and let nothing be placed in it or in margins about it, see `take`."""
        self.holes.append(hole)
        self.take(hole, **margins)

    def solid(self, height: float) -> Trimesh:
        """The wall itself, to a height, m, a little longer than the room at both ends."""
        holes = [
            (hole.x0 + THICKNESS, hole.x1 + THICKNESS, hole.z0, hole.z1)
            for hole in self.holes
        ]
        return move(
            plate(self.length + 2 * THICKNESS, height, THICKNESS, holes),
            (-THICKNESS, 0, 0),
        )


@dataclass
class Shell:
    """An empty room; lengths in m.

    Attributes
    ----------
    width, depth, height : float
    walls : list of Wall
        Four outer ones and, of an L, the two faces of the block in its corner.
    floor : list of Box
        Together the space of the room.
    open : bool
        Without a ceiling.
    day : bool
    things : list of Thing
        The house itself.
    lights : list of Light
        Windows, sky, and lamps of a room beyond.
    keep : list of Box
        Space before doors, which stays free.
    beyond : list of Wall
        Far wall of a room beyond a passage.
    eaves : list of tuple
        Slopes: direction along y (1 or -1), where the slope starts, height lost a metre.
    lowest : float
        How far beams reach down.
    """

    width: float
    depth: float
    height: float
    walls: list[Wall]
    floor: Boxes
    open: bool = False
    day: bool = True
    things: list[Thing] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    keep: Boxes = field(default_factory=list)
    beyond: list[Wall] = field(default_factory=list)
    eaves: list[Triple] = field(default_factory=list)
    lowest: float = 0.0

    def build(self, kind: str, place: Place, *pieces: tuple) -> None:
        """Add a thing; each piece is a material and solids in the frame ``place``."""
        parts = [part for piece in pieces for part in place.parts(*piece)]
        self.things.append(Thing(kind, parts))

    def headroom(self, area: Box) -> float:
        """Height that is free where a box stands, m."""
        lost = [
            fall * way * (y - start)
            for way, start, fall in self.eaves
            for y in area[2:4]
        ]
        return self.height - self.lowest - max([0.0, *lost])

    def reach(self, z0: float, z1: float) -> Box:
        """Box over the room and its walls between two heights, m."""
        t = THICKNESS
        return Box(-t, self.width + t, -t, self.depth + t, z0, z1)

    @property
    def sky(self) -> float:
        """Radiance of the sky."""
        return 1.0 if self.day else 0.01
