"""One furnished interior from two numbers: its seed and its place in the set."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cmtof.scenes.rooms.architecture import shell
from cmtof.scenes.rooms.assembly import Geometry, Outdoors, assemble, counted
from cmtof.scenes.rooms.cameras import Camera, Lens, close_cameras, room_cameras
from cmtof.scenes.rooms.furnish import furnish, hang_lamps
from cmtof.scenes.rooms.house import Shell
from cmtof.scenes.rooms.household import Household
from cmtof.scenes.rooms.illumination import Illumination
from cmtof.scenes.rooms.materials import style
from cmtof.scenes.rooms.placing import Floor, Rectangle
from cmtof.scenes.rooms.tracing import Tracer

KINDS = {
    "living": 0.24,
    "dining": 0.12,
    "bedroom": 0.14,
    "kitchen": 0.12,
    "office": 0.1,
    "hallway": 0.04,
    "bathroom": 0.05,
    "attic": 0.07,
    "workshop": 0.06,
    "nursery": 0.06,
}
"""Kinds of rooms and how often each is drawn."""

CLOSE_SHARE = 0.1
"""Share of a set's views that are taken from 0.5 to 1.2 m."""

# streams of random numbers of one scene, so that more views never change the room
_ROOM, _PATTERNS, _VIEWS, _CLOSE = range(4)


@dataclass(frozen=True)
class Scene:
    """A room with its light; cameras are drawn from it."""

    seed: int
    index: int
    kind: str
    geometry: Geometry
    light: Illumination
    floor: list[Rectangle]
    """Where a person may stand, m."""
    height: float
    """Of the ceiling, m."""
    furniture: NDArray[np.int32]
    """Numbers of the things that do not belong to the house itself."""

    @property
    def name(self) -> str:
        """Folder of the scene, as in ``room_000_007``: seed and place in the set."""
        return scene_name(self.seed, self.index)

    def cameras(self, views: int, lens: Lens) -> dict[str, list[Camera]]:
        """Poses of ``cam_00`` (across the room) and ``cam_01`` (close to things).

        Together ``views``; the first ones stay the same when more are asked for.
        """
        close = close_views(self.index, views)
        where: dict[str, Any] = {
            "floor": self.floor,
            "height": self.height,
            "tracer": self.light.tracer,
            "geometry": self.geometry,
            "lens": lens,
        }
        across, near = (stream(self.seed, self.index, use) for use in (_VIEWS, _CLOSE))
        return {
            "cam_00": room_cameras(views - close, rng=across, **where),
            "cam_01": close_cameras(close, things=self.furniture, rng=near, **where),
        }


def stream(seed: int, index: int, *number: int) -> np.random.Generator:
    """Random numbers of one scene that no other and no other use of it share."""
    return np.random.default_rng([seed, index, *number])


def scene_name(seed: int, index: int) -> str:
    """Folder of a scene.

    Examples
    --------
    >>> scene_name(0, 7)
    'room_000_007'
    """
    return f"room_{seed:03d}_{index:03d}"


def close_views(index: int, views: int) -> int:
    """How many of a scene's views are close ones; over many scenes a share of `CLOSE_SHARE`.

    Examples
    --------
    >>> [close_views(i, 5) for i in range(4)], close_views(7, 10)
    ([0, 1, 0, 1], 1)
    """
    share = round(views * CLOSE_SHARE, 9)
    return int((index + 1) * share) - int(index * share)


def build(seed: int, index: int, *, kind: str | None = None) -> Scene:
    """Build, furnish and light one room.

    Parameters
    ----------
    seed, index : int
        The same pair gives the same room, bit for bit.
    kind : str, optional
        Key of `KINDS`; drawn by default.
    """
    rng = stream(seed, index, _ROOM)
    kinds, odds = zip(*KINDS.items(), strict=True)
    drawn = str(rng.choice(kinds, p=np.array(odds) / sum(odds)))
    kind = kind or drawn
    manner = style(rng)
    empty = shell(rng, manner, kind=kind, **_size(rng, kind))
    house = Household(rng, manner, clutter=float(rng.beta(2, 2)))
    floor = _floor(empty, rng)
    hang_lamps(floor, house, empty.ceiling_spots)
    furnish(floor, house, kind)
    for thing, _ in empty.things:
        if thing.supports and house.chance(0.6):  # sills, mantels, low walls
            house.dress(thing, "mantel" if thing.kind == "fireplace" else "window sill")
    for beside in empty.annexes:
        more = Floor([beside.floor], list(beside.walls), beside.height, rng)
        more.taken += _thresholds(empty)
        x0, x1, y0, y1 = beside.floor
        hang_lamps(more, house, [((x0 + x1) / 2, (y0 + y1) / 2, beside.height)])
        furnish(more, house, beside.kind, sparse=True)
        floor.placed += more.placed
    geometry = assemble(
        empty.things + floor.placed,
        rng=stream(seed, index, _PATTERNS),
        lights=empty.lights,
        outdoors=_outdoors(empty),
    )
    light = Illumination(geometry, Tracer(geometry.vertices, geometry.faces))
    first = 1 + sum(counted(thing) for thing, _ in empty.things)
    furniture = np.arange(first, len(geometry.kinds) + 1, dtype=np.int32)
    return Scene(seed, index, kind, geometry, light, empty.floor, empty.height, furniture)


def _size(rng: np.random.Generator, kind: str) -> dict[str, float]:
    """Width and depth, m; two rooms of three are large, for the far views that Hypersim has."""
    if kind in ("bathroom", "hallway") or rng.uniform() < 0.35:
        return {}
    return {"width": float(rng.uniform(6.5, 10.0)), "depth": float(rng.uniform(5.0, 8.0))}


def _floor(empty: Shell, rng: np.random.Generator) -> Floor:
    floor = Floor(list(empty.floor), list(empty.walls), empty.height, rng)
    floor.taken += _thresholds(empty)
    return floor


def _thresholds(empty: Shell) -> list[Rectangle]:
    """Squares before and behind each doorway that must stay free to walk through."""
    return [(x - 0.5, x + 0.5, y - 0.5, y + 0.5) for (x, y), _ in empty.doorways]


def _outdoors(empty: Shell) -> Outdoors:
    corners = [(0.0, empty.width, 0.0, empty.depth)] + [a.floor for a in empty.annexes]
    x0, x1, y0, y1 = zip(*corners, strict=True)
    house = (min(x0) - 0.05, max(x1) + 0.05, min(y0) - 0.05, max(y1) + 0.05)
    towards, strength = empty.sun or ((0.0, 0.0, 1.0), 0.0)
    return Outdoors(house, 12.0, towards, strength)
