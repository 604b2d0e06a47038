"""Putting things where they belong: against walls, around tables, on surfaces, none in another."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cmtof.scenes.rooms.house import WallRun, facing
from cmtof.scenes.rooms.thing import Pose, Support, Thing, pose

Rectangle = tuple[float, float, float, float]
"""x0, x1, y0, y1, m."""


def footprint(thing: Thing, motion: Pose) -> Rectangle:
    """Rectangle that a thing covers as it stands, m, in the frame of ``motion``."""
    return _covered(thing.bounds, motion)


def _covered(bounds: NDArray[np.float64], motion: Pose) -> Rectangle:
    (x0, y0, _), (x1, y1, _) = bounds.tolist()
    (a, b, _, x), (c, d, _, y) = motion[:2].tolist()
    xs = [a * u + b * v + x for u in (x0, x1) for v in (y0, y1)]
    ys = [c * u + d * v + y for u in (x0, x1) for v in (y0, y1)]
    return min(xs), max(xs), min(ys), max(ys)


def overlap(a: Rectangle, b: Rectangle, gap: float = 0.0) -> bool:
    """Whether two rectangles come nearer than ``gap``, m.

    Examples
    --------
    >>> overlap((0, 1, 0, 1), (0.5, 2, 0.5, 2)), overlap((0, 1, 0, 1), (1.1, 2, 0, 1), gap=0.2)
    (True, True)
    """
    return a[0] < b[1] + gap and b[0] < a[1] + gap and a[2] < b[3] + gap and b[2] < a[3] + gap


def grown(area: Rectangle, by: NDArray[np.float64]) -> Rectangle:
    """A rectangle drawn out by a vector (x, y), m, on the side that it points to."""
    x, y = by.tolist()
    return area[0] + min(x, 0), area[1] + max(x, 0), area[2] + min(y, 0), area[3] + max(y, 0)


def _within(point: Sequence[float], area: Rectangle, slack: float = 0.02) -> bool:
    (x, y), (x0, x1, y0, y1) = point, area
    return x0 - slack <= x <= x1 + slack and y0 - slack <= y <= y1 + slack


@dataclass
class Floor:
    """A room that fills up: what may stand where without touching what stands there already."""

    rectangles: list[Rectangle]
    walls: list[WallRun]
    height: float
    rng: np.random.Generator
    placed: list[tuple[Thing, Pose]] = field(default_factory=list)
    taken: list[Rectangle] = field(default_factory=list)
    hung: list[tuple[int, float, float, float, float]] = field(default_factory=list)
    """(wall, from, to, bottom, top) of what stands against walls or hangs on them."""

    def free(self, area: Rectangle, gap: float = 0.03) -> bool:
        """Whether a rectangle lies on the floor and nobody has taken it."""
        x0, x1, y0, y1 = area
        points = [(x, y) for x in (x0, (x0 + x1) / 2, x1) for y in (y0, (y0 + y1) / 2, y1)]
        on_floor = all(any(_within(point, r) for r in self.rectangles) for point in points)
        return on_floor and not any(overlap(area, other, gap) for other in self.taken)

    def put(self, thing: Thing, motion: Pose, *, solid: bool = True) -> Pose:
        """Stand a thing there, whatever is in the way; ``solid`` things take their floor."""
        self.placed.append((thing, motion))
        if solid:
            self.taken.append(footprint(thing, motion))
        return motion

    def against_wall(
        self, thing: Thing, *, tries: int = 24, where: float | None = None, room_before: float = 0.0
    ) -> tuple[Pose, int] | None:
        """Stand a thing with its back to some free piece of wall; None if none is left.

        Parameters
        ----------
        where : float, optional
            0 to 1 along the wall; drawn by default.
        room_before : float
            Depth that must stay free in front, m.
        """
        bounds = low, high = thing.bounds
        width, depth, height = high - low
        lengths = np.array([max(wall.length - width, 0.0) for wall in self.walls])
        if not lengths.sum() > 0:
            return None
        for _ in range(tries):
            number = int(self.rng.choice(len(self.walls), p=lengths / lengths.sum()))
            wall = self.walls[number]
            share = self.rng.uniform() if where is None else where
            at = width / 2 + share * (wall.length - width)
            motion = wall.place(at, depth, gap=float(self.rng.uniform(0.005, 0.04)))
            span = (at - width / 2, at + width / 2)
            if height > wall.height - 0.05 or not self._free_on(number, *span, 0.0, height):
                continue
            area = _covered(bounds, motion)
            if not self.free(grown(area, room_before * wall.inward)):
                continue
            self.put(thing, motion)
            self.hung.append((number, *span, 0.0, float(height)))
            return motion, number
        return None

    def on_wall(self, thing: Thing, centre_height: float, *, tries: int = 16) -> bool:
        """Hang a thing on a free piece of wall, its centre at a height, m."""
        low, high = thing.bounds
        width = float(high[0] - low[0])
        bottom, top = centre_height + float(low[2]), centre_height + float(high[2])
        lengths = np.array([max(wall.length - width - 0.1, 0.0) for wall in self.walls])
        if not lengths.sum() > 0:
            return False
        for _ in range(tries):
            number = int(self.rng.choice(len(self.walls), p=lengths / lengths.sum()))
            wall = self.walls[number]
            at = float(self.rng.uniform(width / 2 + 0.05, wall.length - width / 2 - 0.05))
            if top > wall.height - 0.03:
                continue
            if self._free_on(number, at - width / 2, at + width / 2, bottom, top, gap=0.06):
                self.hang(thing, number, at, centre_height)
                return True
        return False

    def hang(self, thing: Thing, number: int, at: float, centre_height: float) -> None:
        """Hang a thing on a wall, ``at`` m along it, without asking."""
        low, high = thing.bounds
        wall = self.walls[number]
        x, y = np.asarray(wall.start) + at * wall.along + 0.002 * wall.inward
        self.placed.append((thing, pose(float(x), float(y), centre_height, facing(wall.inward))))
        self.hung.append(
            (number, at + float(low[0]), at + float(high[0]), centre_height + float(low[2]),
             centre_height + float(high[2]))
        )  # fmt: skip

    def wall_free(self, number: int, at: float, thing: Thing, centre_height: float) -> bool:
        """Whether a thing may hang there, its centre at a height, m."""
        low, high = thing.bounds
        a, b = at + float(low[0]), at + float(high[0])
        if a < 0 or b > self.walls[number].length:
            return False
        bottom, top = centre_height + float(low[2]), centre_height + float(high[2])
        return top < self.walls[number].height and self._free_on(number, a, b, bottom, top)

    def _free_on(
        self, number: int, a: float, b: float, bottom: float, top: float, gap: float = 0.02
    ) -> bool:
        for c, d, sill in self.walls[number].blocked:
            if a < d + gap and c < b + gap and top > sill:
                return False
        return not any(
            number == n and a < d + gap and c < b + gap and bottom < high + gap and low < top + gap
            for n, c, d, low, high in self.hung
        )

    def somewhere(self, thing: Thing, *, gap: float = 0.1, tries: int = 30) -> Pose | None:
        """Stand a thing anywhere on the free floor, turned at will; None if there is no room."""
        bounds = thing.bounds
        for _ in range(tries):
            x0, x1, y0, y1 = self._rectangle()
            turn = float(self.rng.choice([0, 0.5, 1, 1.5]) * np.pi + self.rng.normal(0, 0.1))
            motion = pose(self.rng.uniform(x0, x1), self.rng.uniform(y0, y1), 0.0, turn)
            if self.free(_covered(bounds, motion), gap):
                return self.put(thing, motion)
        return None

    def _rectangle(self) -> Rectangle:
        area = np.array([(b - a) * (d - c) for a, b, c, d in self.rectangles])
        return self.rectangles[int(self.rng.choice(len(area), p=area / area.sum()))]


def fill_support(
    support: Support,
    draw: Callable[[], Thing],
    rng: np.random.Generator,
    *,
    most: int,
    aligned: float = 0.5,
) -> list[tuple[Thing, Pose]]:
    """Rest up to ``most`` things on a support, none over its edge, none in another.

    Parameters
    ----------
    draw : callable
        Makes the next thing to try.
    aligned : float
        Chance that a thing stands square to the edge.

    Returns
    -------
    list of (Thing, Pose)
        In the frame of whatever carries the support.
    """
    resting: list[tuple[Thing, Pose]] = []
    taken: list[Rectangle] = []
    for _ in range(most):
        thing = draw()
        bounds = low, high = thing.bounds
        if high[2] > support.clearance:
            continue
        for _ in range(6):
            turn = float(rng.normal(0, 0.06) if rng.uniform() < aligned else rng.uniform(-3.1, 3.1))
            x0, x1, y0, y1 = _covered(bounds, pose(turn=turn))
            room_x, room_y = (
                support.x1 - support.x0 - (x1 - x0),
                support.y1 - support.y0 - (y1 - y0),
            )
            if room_x <= 0 or room_y <= 0:
                continue
            x = support.x0 - x0 + rng.uniform() * room_x
            y = support.y0 - y0 + rng.uniform() * room_y
            area = (x + x0, x + x1, y + y0, y + y1)
            if any(overlap(area, other, 0.005) for other in taken):
                continue
            taken.append(area)
            resting.append((thing, pose(x, y, support.z + 5e-4 - float(low[2]), turn)))
            break
    return resting
