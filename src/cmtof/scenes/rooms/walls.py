"""Rooms while they are being built: walls with openings, and what becomes of them as things."""

from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np

from cmtof.scenes.rooms.finishes import Finish
from cmtof.scenes.rooms.house import WallRun
from cmtof.scenes.rooms.materials import Material
from cmtof.scenes.rooms.panels import Opening, Points, Top, panel, reveals
from cmtof.scenes.rooms.plan import cross, offset, triangulated
from cmtof.scenes.rooms.solids import joined
from cmtof.scenes.rooms.thing import Mesh, Pose, Thing, pose, transformed

SINK = 0.03
"""Walls reach that far below the floor and above the ceiling, m."""
STANDING = 1.9
"""Under slopes that are lower nobody stands, m."""
LAP = 0.02
"""Floors and ceilings reach that far into the walls, m."""


@dataclass(eq=False)
class Wall:
    """One side of a room; its own frame has x from end to start, y outwards, the origin at end."""

    start: Points
    end: Points
    top: Top
    """Upper edge in the wall's frame."""
    thickness: float
    shared: bool = False
    """Another room begins where this wall ends."""
    openings: list[Opening] = field(default_factory=list)
    doors: set[int] = field(default_factory=set)
    """Which openings are doorways."""
    framed: set[int] = field(default_factory=set)
    """Which of them have a lining and architraves."""
    edges: tuple[float, float] = (0.0, 0.0)
    """No opening may come nearer to the ends at x = 0 and x = length than this, m."""
    blocked: list[tuple[float, float, float]] = field(default_factory=list)
    """Pieces (x0, x1, sill) in the wall's frame that furniture must leave free."""

    @cached_property
    def length(self) -> float:
        """m."""
        return float(np.linalg.norm(self.end - self.start))

    @cached_property
    def along(self) -> Points:
        """Unit vector from start to end."""
        return (self.end - self.start) / self.length

    @cached_property
    def inward(self) -> Points:
        """Unit vector into the room."""
        return np.array([-self.along[1], self.along[0]])

    @cached_property
    def frame(self) -> Pose:
        """Pose of the wall's frame in the room."""
        d = self.along
        return pose(self.end[0], self.end[1], 0.0, float(np.arctan2(-d[1], -d[0])))

    @property
    def height(self) -> float:
        """Lowest, m."""
        return min(z for _, z in self.top)

    def at(self, x: float, y: float = 0.0, z: float = 0.0, turn: float = 0.0) -> Pose:
        """Pose in the room of a place in the wall's frame."""
        return self.frame @ pose(x, y, z, turn)

    def headroom(self, x0: float, x1: float) -> float:
        """Lowest height of the wall between x0 and x1, m."""
        xs, zs = zip(*self.top, strict=True)
        inner = [z for x, z in self.top if x0 < x < x1]
        return float(min([np.interp(x0, xs, zs), np.interp(x1, xs, zs), *inner]))

    def cut(
        self, opening: Opening, *, door: bool = False, framed: bool = False, margin: float = 0.1
    ) -> None:
        """Make a hole and keep furniture away from it."""
        if door:
            self.doors.add(len(self.openings))
        if framed:
            self.framed.add(len(self.openings))
        self.openings.append(opening)
        self.block(opening.x0 - margin, opening.x1 + margin, 0.0 if door else opening.z0)

    def block(self, x0: float, x1: float, sill: float) -> None:
        """Let nothing higher than ``sill`` stand between x0 and x1."""
        x0, x1 = max(0.0, x0), min(self.length, x1)
        if x1 > x0:
            self.blocked.append((x0, x1, max(0.0, sill)))

    def gaps(self, margin: float = 0.15, *, low: float = np.inf) -> list[tuple[float, float]]:
        """Free pieces (x0, x1) between all that is blocked from below ``low``."""
        taken = sorted((a - margin, b + margin) for a, b, s in self.blocked if s < low)
        first, last = (max(margin, edge) for edge in self.edges)
        gaps, x = [], first
        for a, b in [*taken, (self.length - last, self.length)]:
            a = min(a, self.length - last)
            if a > x:
                gaps.append((x, a))
            x = max(x, b)
        return gaps

    def runs(self) -> list[WallRun]:
        """What the layout sees: the wall's level pieces, and of a slanting one its tall part."""
        found = []
        for (x0, z0), (x1, z1) in pairwise(self.top):
            if abs(z1 - z0) > 0.3:
                part = x0 + (x1 - x0) * float(np.clip((STANDING - z0) / (z1 - z0), 0.0, 1.0))
                x0, x1 = (part, x1) if z1 > z0 else (x0, part)
                z0, z1 = max(z0, STANDING), max(z1, STANDING)
            if x1 - x0 > 0.3:
                found.append(self._run(x0, x1, min(z0, z1)))
        return found

    def _run(self, x0: float, x1: float, height: float) -> WallRun:
        start, end = (self.end - x * self.along for x in (x1, x0))
        blocked = sorted(
            (round(x1 - min(b, x1), 6), round(x1 - max(a, x0), 6), s)
            for a, b, s in self.blocked
            if b > x0 and a < x1
        )
        ends = tuple(map(float, start)), tuple(map(float, end))
        length = float(np.hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]))
        blocked = [(max(0.0, a), min(b, length), s) for a, b, s in blocked]
        return WallRun(ends[0], ends[1], height, tuple(blocked))  # type: ignore[arg-type]


@dataclass(eq=False)
class Room:
    """A room while it is being built."""

    kind: str
    points: Points
    """Outline, counter-clockwise."""
    height: float
    finish: Finish
    walls: list[Wall]
    facade: Material
    slope: tuple[int, tuple[tuple[float, float], ...]] | None = None
    accent: int = -1
    """Which wall is finished otherwise."""

    def ceiling(self, x: float, y: float) -> float:
        """m, above (x, y)."""
        if self.slope is None:
            return self.height
        s, z = zip(*self.slope[1], strict=True)
        return float(np.interp((x, y)[self.slope[0]], s, z))


def room(
    kind: str,
    points: Points,
    height: float,
    finish: Finish,
    facade: Material,
    thickness: float,
    slope: tuple[int, tuple[tuple[float, float], ...]] | None = None,
) -> Room:
    """A room with plain walls around an outline."""
    built = Room(kind, points, height, finish, [], facade, slope)
    for start, end in zip(points, np.roll(points, -1, 0), strict=True):
        wall = Wall(start, end, [], thickness)
        stops = [0.0, wall.length]
        if slope is not None:
            axis, profile = slope
            rate = -wall.along[axis]
            if abs(rate) > 0.5:
                stops += [(s - end[axis]) / rate for s, _ in profile]
        stops = sorted({round(x, 9) for x in stops if -1e-9 <= x <= wall.length + 1e-9})
        stops[-1] = wall.length
        wall.top = [(x, built.ceiling(*(end - x * wall.along))) for x in stops]
        built.walls.append(wall)
    for k, wall in enumerate(built.walls):  # at corners that stand out into the room
        before, after = built.walls[k - 1], built.walls[(k + 1) % len(built.walls)]
        wall.edges = tuple(  # type: ignore[assignment]
            thickness + 0.03 if float(cross(a.along, b.along)) < 0 else 0.0
            for a, b in ((wall, after), (before, wall))
        )
    return built


def wall_things(built: Room) -> list[tuple[Thing, Pose]]:
    """Every wall of a room with its reveals and, where it is seen, its outer face."""
    outer = offset(built.points, [w.thickness for w in built.walls])
    return [(_wall_thing(built, k, outer), wall.frame) for k, wall in enumerate(built.walls)]


def _wall_thing(built: Room, k: int, outer: Points) -> Thing:
    wall, finish = built.walls[k], built.finish
    material, grain = finish.wall, finish.wall_grain
    if k == built.accent:
        material, grain = finish.accent_wall, finish.accent_grain
    raised = [(x, z + SINK) for x, z in wall.top]
    thing = Thing("wall").add(panel(wall.openings, raised, bottom=-SINK), material, grain)
    holes = [
        reveals(o, wall.thickness, open_below=j in wall.doors) for j, o in enumerate(wall.openings)
    ]
    if holes and wall.thickness > 0:
        thing.add(joined(holes), material, grain)
    d = wall.along
    x0, x1 = (float((p - wall.end) @ -d) for p in (outer[(k + 1) % len(outer)], outer[k]))
    if x1 > x0 + 0.05:
        far = [(x0, raised[0][1]), *raised[1:-1], (x1, raised[-1][1])]
        # where two rooms meet, each wall's back hides a hair's breadth behind the other's face
        y = wall.thickness - 0.01 * wall.shared if wall.thickness else 0.012
        thing.add(panel(wall.openings, far, bottom=-0.3, y=y, back=True), built.facade)
    return thing


def floor_thing(built: Room) -> Thing:
    """The floor, reaching under the walls."""
    ring = offset(built.points, LAP)
    points = np.column_stack([ring, np.zeros(len(ring))])
    mesh = Mesh(points.astype(np.float32), triangulated(ring))
    return Thing("floor").add(mesh, built.finish.floor, built.finish.floor_grain)


def flat_ceiling(built: Room, outline: Points | None = None) -> Thing:
    """A level ceiling, reaching over the walls; over another ``outline`` where it has a hole."""
    ring = offset(built.points if outline is None else outline, LAP)
    points = np.column_stack([ring, np.full(len(ring), built.height)])
    faces = triangulated(ring)[:, ::-1].copy()
    return Thing("ceiling").add(Mesh(points.astype(np.float32), faces), built.finish.ceiling)


@dataclass(eq=False)
class Slope:
    """One plane of an attic's ceiling, in its own frame: x level, z up the slope, y outwards."""

    frame: Pose
    length: float
    slant: float
    low: float
    """Height of its foot above the floor, m."""
    rise: float
    """Height that one metre up the slope gains, m."""
    before: float
    beyond: float
    openings: list[Opening] = field(default_factory=list)


def slopes(built: Room) -> list[Slope]:
    """The planes of a sloped ceiling."""
    assert built.slope is not None
    axis, profile = built.slope
    low, high = built.points.min(0) - LAP, built.points.max(0) + LAP
    other = 1 - axis
    found = []
    for k, ((s0, z0), (s1, z1)) in enumerate(pairwise(profile)):
        first, last = k == 0, k == len(profile) - 2
        if z1 < z0:  # up is always up
            (s0, z0), (s1, z1), first, last = (s1, z1), (s0, z0), last, first
        slant = float(np.hypot(s1 - s0, z1 - z0))
        up, across, origin = np.zeros(3), np.zeros(3), np.zeros(3)
        up[axis], up[2] = (s1 - s0) / slant, (z1 - z0) / slant
        across[other] = 1.0
        origin[axis], origin[2], origin[other] = s0, z0, low[other]
        if np.cross(up, across)[2] < 0:  # the back looks up
            across, origin[other] = -across, high[other]
        frame = np.eye(4)
        frame[:3] = np.column_stack([across, np.cross(up, across), up, origin])
        length, rise = float(high[other] - low[other]), (z1 - z0) / slant
        found.append(Slope(frame, length, slant, z0, rise, LAP * first, LAP * last))
    return found


def slope_thing(built: Room, slope: Slope, thickness: float) -> Thing:
    """A slope with its roof windows' reveals."""
    top = [(0.0, slope.slant + slope.beyond), (slope.length, slope.slant + slope.beyond)]
    material = built.finish.ceiling
    thing = Thing("ceiling").add(panel(slope.openings, top, bottom=-slope.before), material)
    if slope.openings:
        thing.add(joined([reveals(o, thickness) for o in slope.openings]), material)
    return thing


def place(wall: Wall, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A point of the wall's frame, in the room's."""
    a, b, c = transformed((x, y, z), wall.frame).tolist()
    return (a, b, c)
