"""Where windows go, the daylight that they let in, and the sun through one of them."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cmtof.scenes.rooms.layouts import Plan
from cmtof.scenes.rooms.panels import Opening
from cmtof.scenes.rooms.thing import Light, Pose, transformed
from cmtof.scenes.rooms.walls import Room, Slope, Wall

Triple = tuple[float, float, float]


@dataclass(eq=False)
class Glazing:
    """A window opening in a wall or in a slope."""

    frame: Pose
    """Of the wall or slope: x along it, y outwards."""
    hole: Opening
    depth: float
    """Of the reveal, m."""
    wall: Wall | None = None
    """None for a roof window."""


class Size(NamedTuple):
    """Windows of one room, m."""

    width: float
    sill: float
    head: float
    shape: str = "rectangle"


def side_facing(wall: Wall) -> int:
    """Side of a rectangle that a wall faces away to, counter-clockwise from y = 0."""
    out = -wall.inward
    return int(np.argmax([-out[1], out[0], out[1], -out[0]]))


def cut_windows(
    rng: np.random.Generator, main: Room, plan: Plan, closed: set[int]
) -> list[Glazing]:
    """Cut windows of one size into the walls that look outdoors; ``closed`` sides have none."""
    if plan.bay < 0 and rng.uniform() < 0.05:
        return []
    hearth = plan.hearth[0] if plan.hearth else -1
    sides = [s for s in range(4) if s not in closed and s != hearth]
    chosen = {s for s in sides if rng.uniform() < 0.55} or set(sides[:1])
    chosen |= {plan.bay} - {-1}
    size = _size(rng, max(z for w in main.walls for _, z in w.top))
    found: list[Glazing] = []
    for k, wall in enumerate(main.walls):
        if side_facing(wall) in chosen and wall.length > 0.7 and k != main.accent:
            found += _along(rng, wall, size)
    return found


def _size(rng: np.random.Generator, height: float) -> Size:
    """Plain windows mostly; glazed doors, ribbons, tall, arched or round ones."""
    design = str(
        rng.choice(["plain", "plain", "plain", "french", "strip", "tall", "arch", "round"])
    )
    top = height - 0.15
    head = min(float(rng.uniform(2.05, 2.5)), top)
    width, sill = float(rng.uniform(0.9, 1.8)), float(rng.uniform(0.75, 1.0))
    if design == "french":
        return Size(float(rng.uniform(1.4, 3.4)), 0.02, head)
    if design == "strip":
        return Size(float(rng.uniform(2.4, 5.0)), float(rng.uniform(1.0, 1.5)), head)
    if design == "tall":
        return Size(float(rng.uniform(0.8, 1.2)), 0.35, min(top, 3.2))
    if design == "arch":
        return Size(float(rng.uniform(0.8, 1.3)), 0.7, min(top, 2.8), "arch")
    if design == "round":
        return Size(float(rng.uniform(0.7, 1.1)), 1.0, head, "round")
    return Size(width, sill, head)


def _along(rng: np.random.Generator, wall: Wall, size: Size) -> list[Glazing]:
    """Windows in the free pieces of a wall, evenly spaced, at most three a piece."""
    found: list[Glazing] = []
    for a, b in wall.gaps(margin=0.12):
        room = b - a
        if room < 0.55:
            continue
        each = min(size.width, room - 0.1)
        count = int(min(3, max(1, (room + 0.5) // (each + 0.6))))
        if size.shape == "round":
            count = min(count, 2)
        free = (room - count * each) / (count + 1)
        for k in range(count):
            x = a + free * (k + 1) + each * k
            sill, head = size.sill, min(size.head, wall.headroom(x, x + each) - 0.12)
            if size.shape == "round":
                each = min(each, head - sill)
                sill, head = 1.55 - each / 2, 1.55 + each / 2
            if head > wall.headroom(x, x + each) - 0.05 or head - sill < 0.4 or each < 0.5:
                continue
            hole = Opening(x, x + each, sill, head, size.shape)
            wall.cut(hole, margin=0.0)
            found.append(Glazing(wall.frame, hole, wall.thickness, wall))
    return found


def far_window(rng: np.random.Generator, beside: Room) -> list[Glazing]:
    """A window in the far wall or in one of the long walls of a room beyond."""
    near = next(k for k, w in enumerate(beside.walls) if w.thickness == 0)
    wall = beside.walls[(near + int(rng.choice([1, 2, 2, 3]))) % 4]
    free = [(a, b) for a, b in wall.gaps(margin=0.12) if b - a > 0.6]
    if not free:
        return []
    a, b = free[int(rng.integers(len(free)))]
    width = min(float(rng.uniform(0.8, 1.8)), b - a - 0.05)
    x = float(rng.uniform(a, b - width))
    hole = Opening(x, x + width, float(rng.uniform(0.8, 1.1)), min(2.2, wall.height - 0.1))
    wall.cut(hole, margin=0.0)
    return [Glazing(wall.frame, hole, wall.thickness, wall)]


def roof_windows(rng: np.random.Generator, planes: list[Slope], depth: float) -> list[Glazing]:
    """One to three windows in each slope, at a height from which one can look out."""
    found: list[Glazing] = []
    for plane in planes:
        if plane.rise < 0.3 or rng.uniform() < 0.2:
            continue
        width, tall = float(rng.uniform(0.6, 1.0)), float(rng.uniform(0.9, 1.3))
        foot = max(0.1, (float(rng.uniform(0.95, 1.25)) - plane.low) / plane.rise)
        if foot + tall > plane.slant - 0.08:
            tall = plane.slant - 0.08 - foot
        if tall < 0.5:
            continue
        count = int(rng.integers(1, 4))
        free = (plane.length - count * width) / (count + 1)
        for k in range(count if free > 0.2 else 1):
            x = free * (k + 1) + width * k
            hole = Opening(x, x + width, foot, foot + tall)
            plane.openings.append(hole)
            found.append(Glazing(plane.frame, hole, depth))
    return found


def portal(glazing: Glazing, brightness: float) -> Light:
    """The sky in a window: fills the opening at its outer edge and shines inwards."""
    hole = glazing.hole
    x, z = hole.centre
    fill = 1.0 if hole.shape == "rectangle" else 0.7  # inside the curve
    a, b = fill * (hole.x1 - hole.x0) / 2, fill * (hole.z1 - hole.z0) / 2
    axes = glazing.frame[:3, :3]
    return Light(
        _triple(transformed((x, glazing.depth, z), glazing.frame)),
        _triple(axes[:, 0] * a),
        _triple(axes[:, 2] * b),
        power=4 * a * b * brightness,
        normal=_triple(-axes[:, 1]),
        colour=(0.95, 1.0, 1.06),
    )


def _triple(v: ArrayLike) -> Triple:
    a, b, c = np.asarray(v, float).tolist()
    return (a, b, c)


def sun_through(rng: np.random.Generator, glazing: Glazing) -> tuple[Triple, float] | None:
    """Direction to a sun whose beam passes the reveal of this window, 15 to 60 degrees high.

    None when the reveal is too deep for it. A share of the opening's half width and height is left
    to the beam, so that a bar in its middle does not stop it all.
    """
    hole, frame = glazing.hole, glazing.frame
    share = 0.45 if hole.shape == "rectangle" else 0.25
    reach = glazing.depth + 0.1
    sideways = share * (hole.x1 - hole.x0) / reach
    upwards = share * (hole.z1 - hole.z0) / reach
    wide, high = np.arctan(sideways), np.arctan(upwards)
    for _ in range(8):
        azimuth = float(rng.uniform(-min(wide, 0.9), min(wide, 0.9)))
        lift = float(rng.uniform(-high if frame[2, 1] > 0.1 else 0.0, high))
        d = np.cos(lift) * (np.sin(azimuth) * frame[:3, 0] + np.cos(azimuth) * frame[:3, 1])
        d += np.sin(lift) * frame[:3, 2]
        strength = float(rng.uniform(4, 14))
        if np.sin(np.radians(15)) < d[2] < np.sin(np.radians(60)):
            return _triple(d / np.linalg.norm(d)), strength
    return None
