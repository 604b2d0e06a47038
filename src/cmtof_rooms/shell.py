"""Shell of a room: what stands before anything is put into it.

The room is a rectangle, 0 to width by 0 to depth, m, from which a block may be cut off in one
corner (an L).
"""

from dataclasses import dataclass, field

from cmtof_rooms.arrays import Triple
from cmtof_rooms.boxes import Box, Rectangle
from cmtof_rooms.things import Light, Part, Thing
from cmtof_rooms.walls import THICKNESS, Wall


@dataclass
class Shell:
    """An empty room; lengths in m.

    Attributes
    ----------
    width, depth, height : float
    walls : list of Wall
        Four outer ones and, of an L, the two faces of the block in its corner.
    floor : list of Rectangle
        Together the floor of the room.
    open : bool
        Without a ceiling.
    day : bool
    things : list of Thing
        The house itself.
    lights : list of Light
        Windows, sky, and lamps of a room beyond.
    keep : list of Rectangle
        Floor before doors, which stays free.
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
    floor: list[Rectangle]
    open: bool = False
    day: bool = True
    things: list[Thing] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    keep: list[Rectangle] = field(default_factory=list)
    beyond: list[Wall] = field(default_factory=list)
    eaves: list[Triple] = field(default_factory=list)
    lowest: float = 0.0

    def add(self, kind: str, *parts: Part) -> None:
        """Add a thing of the house itself."""
        self.things.append(Thing(kind, list(parts)))

    def build(self, kind: str, wall: Wall, *pieces: tuple) -> None:
        """Add a thing made of pieces of one material each, given in the frame of a wall."""
        self.add(kind, *[part for piece in pieces for part in wall.parts(*piece)])

    def headroom(self, area: Rectangle) -> float:
        """Free height above a rectangle of the floor, m."""
        lost = [0.0]
        for way, start, fall in self.eaves:
            edge = area.y1 if way > 0 else area.y0
            lost.append(fall * way * (edge - start))
        return self.height - self.lowest - max(lost)

    def reach(self, z0: float, z1: float) -> Box:
        """Box over the room and its walls between two heights, m."""
        t = THICKNESS
        return Box(-t, self.width + t, -t, self.depth + t, z0, z1)

    @property
    def sky(self) -> float:
        """Radiance of the sky."""
        return 1.0 if self.day else 0.01
