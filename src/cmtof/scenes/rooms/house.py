"""What the empty room tells the layout: free floor, runs of wall, doorways, lights."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.scenes.rooms.plan import Rect
from cmtof.scenes.rooms.thing import Light, Pose, Thing, pose

Point = tuple[float, float]


@dataclass(frozen=True)
class WallRun:
    """A straight piece of wall; going from start to end, the room's inside is on the left.

    Attributes
    ----------
    start, end : (x, y)
        m, on the face of the wall.
    height : float
        m, lowest along the run.
    blocked : tuple of (a, b, sill)
        Pieces from a to b along the run, m, in front of which nothing higher than ``sill`` may
        stand: 0 for a door, the sill's height for a window.
    """

    start: Point
    end: Point
    height: float
    blocked: tuple[tuple[float, float, float], ...] = ()

    @property
    def length(self) -> float:
        """m."""
        return float(np.hypot(self.end[0] - self.start[0], self.end[1] - self.start[1]))

    @property
    def along(self) -> NDArray[np.float64]:
        """Unit vector (2,) from start to end."""
        return (np.asarray(self.end, float) - self.start) / self.length

    @property
    def inward(self) -> NDArray[np.float64]:
        """Unit vector (2,) into the room."""
        return np.array([-self.along[1], self.along[0]])

    def place(self, at: float, depth: float, gap: float = 0.01) -> Pose:
        """Pose of something ``depth`` deep with its back to the wall, ``at`` m along it."""
        x, y = np.asarray(self.start) + at * self.along + (depth / 2 + gap) * self.inward
        return pose(float(x), float(y), 0.0, facing(self.inward))


def facing(direction: ArrayLike) -> float:
    """Turn, rad, that points a thing's front (its -y) along a direction (x, y)."""
    x, y = np.asarray(direction, float)
    return float(np.arctan2(x, -y))


@dataclass(frozen=True)
class Annex:
    """A room or corridor seen through a doorway of the main room."""

    kind: str
    floor: Rect
    height: float
    walls: tuple[WallRun, ...]


@dataclass(frozen=True)
class Shell:
    """An empty room with all that belongs to the house.

    Attributes
    ----------
    things : list of (Thing, Pose)
        Floor, ceiling, each wall, door, window, curtain, radiator, each its own instance.
    width, depth : float
        Bounding rectangle of the main room, m: x in [0, width], y in [0, depth].
    height : float
        Lowest ceiling of the main room, m; `headroom` tells it for each place.
    floor : list of (x0, x1, y0, y1)
        Largest free rectangles of the main room; they overlap, their union is the free floor.
    walls : list of WallRun
        Against which furniture may stand.
    lights : list of Light
        One portal a window, its normal inwards, and lamps of the annexes.
    sun : ((x, y, z), strength) or None
        Direction towards the sun, and irradiance on a white wall that faces it.
    ceiling_spots : list of (x, y, z)
        Where lamps may hang, m.
    doorways : list of ((x, y), (dx, dy))
        Middle of each open doorway and its direction into the main room.
    annexes : list of Annex
        Rooms beyond.
    kind : str
        Use of the room.
    features : list of str
        What this plan has, as in ``"bay"`` or ``"chimney breast"``.
    slope : (axis, ((s, z), ...)) or None
        Sloped ceiling: its height z along axis 0 (x) or 1 (y), m.
    """

    things: list[tuple[Thing, Pose]]
    width: float
    depth: float
    height: float
    floor: list[Rect]
    walls: list[WallRun]
    lights: list[Light] = field(default_factory=list)
    sun: tuple[tuple[float, float, float], float] | None = None
    ceiling_spots: list[tuple[float, float, float]] = field(default_factory=list)
    doorways: list[tuple[Point, Point]] = field(default_factory=list)
    annexes: list[Annex] = field(default_factory=list)
    kind: str = "living"
    features: list[str] = field(default_factory=list)
    slope: tuple[int, tuple[tuple[float, float], ...]] | None = None

    def headroom(self, x: float, y: float) -> float:
        """Height of the ceiling above (x, y), m."""
        if self.slope is None:
            return self.height
        axis, profile = self.slope
        s, z = zip(*profile, strict=True)
        return float(np.interp((x, y)[axis], s, z))
