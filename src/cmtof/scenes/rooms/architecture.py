"""The empty room: plan, walls, windows, doors, what lies beyond and outside."""

import numpy as np

from cmtof.scenes.rooms import equipment, insets, outdoors, trimmings
from cmtof.scenes.rooms.beyond import Passage, annex, side_of
from cmtof.scenes.rooms.daylight import (
    Glazing,
    cut_windows,
    far_window,
    portal,
    roof_windows,
    side_facing,
    sun_through,
)
from cmtof.scenes.rooms.draft import Draft, Sun, told
from cmtof.scenes.rooms.finishes import facade, finish
from cmtof.scenes.rooms.house import Point, Shell
from cmtof.scenes.rooms.layouts import Plan, draw_plan
from cmtof.scenes.rooms.materials import Style
from cmtof.scenes.rooms.openings import window
from cmtof.scenes.rooms.passages import blind_door, fill_passage
from cmtof.scenes.rooms.placing import footprint
from cmtof.scenes.rooms.plan import chamfered, outline
from cmtof.scenes.rooms.thing import Light, Pose, Thing, pose
from cmtof.scenes.rooms.walls import (
    Room,
    flat_ceiling,
    floor_thing,
    room,
    slope_thing,
    slopes,
    wall_things,
)

Placed = list[tuple[Thing, Pose]]
ROOF = 0.25
"""Thickness of a roof, m."""


def shell(
    rng: np.random.Generator,
    style: Style,
    *,
    width: float | None = None,
    depth: float | None = None,
    height: float | None = None,
    kind: str = "living",
) -> Shell:
    """Build an empty room with all that belongs to the house.

    Parameters
    ----------
    rng : numpy.random.Generator
    style : Style
        What the household bought; frames, doors and curtains take their materials from it.
    width, depth, height : float, optional
        Of the main room's bounding rectangle, m; drawn by default, as its kind asks.
    kind : str
        Key of `cmtof.scenes.rooms.layouts.SIZES`.

    Examples
    --------
    >>> from cmtof.scenes.rooms.materials import style
    >>> rng = np.random.default_rng(3)
    >>> room = shell(rng, style(rng), width=5.0, depth=4.0, kind="bedroom")
    >>> room.kind, room.width, room.depth
    ('bedroom', 5.0, 4.0)
    """
    plan = draw_plan(rng, kind, width, depth, height)
    slope = _profile(rng, plan) if kind == "attic" else None
    thickness = float(rng.uniform(0.15, 0.4))
    made, outer = finish(rng, style, kind), facade(rng)
    main = room(kind, plan.points, plan.height, made, outer, thickness, slope)
    draft = Draft(rng, style, plan, main, (0.0, plan.width, 0.0, plan.depth), low=plan.height)
    main.accent = int(rng.integers(len(main.walls))) if made.accent_wall is not made.wall else -1
    if kind not in ("bathroom", "kitchen", "workshop"):
        draft.things += equipment.hearth(rng, style, main, plan)
    _stairs(draft)
    _beyond(draft)
    _insets(draft)
    windows = _windows(draft)
    indoors = [w for beside in draft.annexes for w in far_window(rng, beside)]
    _overhead(draft)
    for built in (main, *draft.annexes):
        _carcass(draft, built)
    doorways = [d for p in draft.passages for d in _fill(draft, p)]
    sun, sunny = _sun(draft, windows)
    _equip(draft, windows, indoors, sunny)
    lights = _glaze(draft, windows + indoors)
    if windows or indoors:
        _outdoors(draft, windows, sun)
    return told(draft, lights, sun, doorways)


def _profile(rng: np.random.Generator, plan: Plan) -> tuple[int, tuple[Point, ...]]:
    """An attic's ceiling across its shorter side: one or two slopes, knee walls, a flat top."""
    axis = 1 if plan.width >= plan.depth else 0
    span = plan.depth if axis else plan.width
    knee = float(rng.uniform(1.0, 1.5))
    steep = float(np.tan(np.radians(rng.uniform(35, 55))))
    run = min((plan.height - knee) / steep, 0.42 * span)
    if rng.uniform() < 0.3:
        return axis, ((0.0, plan.height), (span - run, plan.height), (span, knee))
    return axis, ((0.0, knee), (run, plan.height), (span - run, plan.height), (span, knee))


def _beyond(draft: Draft) -> None:
    """Up to two rooms behind walls of different sides, sometimes a third behind a corridor."""
    rng, plan, main, rect = draft.rng, draft.plan, draft.main, draft.rect
    count = int(rng.choice([0, 1, 2], p=[0.15, 0.5, 0.35]))
    used = {-1, plan.bay, plan.hearth[0] if plan.hearth else -1}
    for k in rng.permutation(len(main.walls)).tolist():
        wall = main.walls[k]
        side = side_of(wall, rect)
        if side in used or len(used) - len({-1, plan.bay}) > 2 or len(draft.annexes) >= count:
            continue
        corridor, limits = draft.chance(0.45), (0.0, plan.length(side))
        found = annex(rng, draft.style, main, wall, rect, limits, corridor=corridor)
        if found is None:
            continue
        used.add(side)
        draft.annexes.append(found[0])
        draft.passages.append(found[1])
        if corridor and draft.chance(0.5):
            _next_room(draft, found[0], side, limits)
    for built in (main, *draft.annexes):
        share = 0.6 if built is main and not draft.passages else 0.35
        if draft.chance(share):
            walls = built.walls
            if built is main:  # nobody puts a door into a bay
                walls = [w for w in walls if side_facing(w) != plan.bay]
            draft.things += blind_door(rng, draft.style, built, walls)


def _next_room(draft: Draft, corridor: Room, side: int, limits: tuple[float, float]) -> None:
    """A room at the far end of a corridor."""
    low, high = corridor.points.min(0), corridor.points.max(0)
    rect = (float(low[0]), float(high[0]), float(low[1]), float(high[1]))
    far = corridor.walls[side]
    found = annex(draft.rng, draft.style, corridor, far, rect, limits, corridor=False)
    if found is not None:
        draft.annexes.append(found[0])
        draft.passages.append(found[1])


def _stairs(draft: Draft) -> None:
    """Stairs through the ceiling; what follows keeps clear of them."""
    plan, main = draft.plan, draft.main
    if main.slope is not None or plan.chamfers:
        return
    if draft.chance(0.6 if main.kind in ("hallway", "living", "workshop") else 0.2):
        things, draft.hole = insets.stairwell(draft.rng, draft.style, main, plan)
        draft.things += things
        plan.features += ["stairs"] if things else []


def _insets(draft: Draft) -> None:
    """Columns, half walls, a raised floor."""
    rng, plan, main, style = draft.rng, draft.plan, draft.main, draft.style
    if main.slope is not None:
        return
    area = plan.width * plan.depth
    if area > 26 and draft.chance(0.25):
        things = insets.columns(rng, main, plan)
        draft.things += things
        plan.features += ["columns"] if things else []
    if area > 20 and draft.chance(0.22):
        things, runs = insets.half_wall(rng, style, main, plan)
        draft.things += things
        draft.runs += runs
        plan.features += ["half wall"] if things else []
    if area > 18 and draft.chance(0.35):
        things = insets.podium(rng, style, main, plan)
        draft.things += things
        plan.features += ["step"] if things else []


def _windows(draft: Draft) -> list[Glazing]:
    """Windows of the main room, in its walls and in its roof."""
    main, rect = draft.main, draft.rect
    closed = {side_of(p.near, rect) for p in draft.passages if p.near in main.walls}
    windows = cut_windows(draft.rng, main, draft.plan, closed)
    if main.slope is not None:
        draft.planes = slopes(main)
        windows += roof_windows(draft.rng, draft.planes, ROOF)
    return windows


def _overhead(draft: Draft) -> None:
    """Beams, coffers, rafters or a lowered strip."""
    rng, plan, main = draft.rng, draft.plan, draft.main
    timber = draft.style.wood if draft.chance(0.6) else main.finish.ceiling
    if main.slope is not None:
        if draft.chance(0.6):
            thing, draft.bays = trimmings.rafters(rng, main, timber)
            draft.things.append((thing, pose()))
            plan.features.append("rafters")
        return
    roll = float(rng.uniform())
    if draft.hole is not None or plan.height < 2.45 or roll > 0.4:
        return
    if roll < 0.28:
        coffered = roll > 0.2
        thing, deep, draft.bays = trimmings.beams(rng, plan, timber, coffered=coffered)
        draft.things.append((thing, pose()))
        draft.low = plan.height - deep
        plan.features.append("coffers" if coffered else "beams")
        return
    found = trimmings.lowered(rng, plan, main.finish.ceiling)
    if found is not None:
        draft.things.append((found[0], pose()))
        draft.strip = found[1]
        draft.low = float(found[0].bounds[0, 2])
        plan.features.append("lowered ceiling")


def _carcass(draft: Draft, built: Room) -> None:
    """Floor, walls, ceiling, and what runs along them."""
    things, rng = draft.things, draft.rng
    things.append((floor_thing(built), pose()))
    things += wall_things(built)
    trim = built.finish.trim if draft.chance(0.7) else built.finish.wall
    if draft.chance(0.92):
        things.append((trimmings.skirting(rng, built, trim), pose()))
    things += trimmings.wainscot(rng, built, draft.style)
    if built.slope is not None:
        things += [(slope_thing(built, plane, ROOF), plane.frame) for plane in draft.planes]
        return
    ring = None
    if built is draft.main and draft.hole is not None:
        ring = outline(draft.plan.width, draft.plan.depth, [*draft.plan.cuts, draft.hole])
        if draft.plan.chamfers:
            ring = chamfered(ring, draft.plan.chamfers, draft.plan.chamfer)
    things.append((flat_ceiling(built, ring), pose()))
    if ring is None and built.height - 0.15 > 2.1 and draft.chance(0.3):
        things.append((trimmings.cornice(rng, built, built.finish.ceiling), pose()))


def _fill(draft: Draft, passage: Passage) -> list[tuple[Point, Point]]:
    """The door in a passage; its leaf takes floor in the main room."""
    things, doorways, swing = fill_passage(draft.rng, draft.style, passage, draft.main)
    draft.things += things
    if swing is not None and passage.near in draft.main.walls:
        insets.claim(draft.main, draft.plan, swing)
    return doorways


def _sun(draft: Draft, windows: list[Glazing]) -> tuple[Sun | None, Glazing | None]:
    """The sun in half of the rooms with windows, and the window that it comes through."""
    if not windows or not draft.chance(0.62):
        return None, None
    outer = [w for w in windows if w.wall is None or side_of(w.wall, draft.rect) >= 0]
    for k in draft.rng.permutation(len(outer)).tolist():
        sun = sun_through(draft.rng, outer[k])
        if sun is not None:
            return sun, outer[k]
    return None, None


def _equip(
    draft: Draft, windows: list[Glazing], indoors: list[Glazing], sunny: Glazing | None
) -> None:
    """Radiators, curtains, switches and sockets."""
    rng, style = draft.rng, draft.style
    for some in (windows, indoors):
        draft.things += equipment.heating(rng, style, some)
    draft.things += equipment.cover_windows(rng, style, windows, sunny)
    if indoors and draft.chance(0.5):
        draft.things += equipment.cover_windows(rng, style, indoors[:1], None)
    for built in (draft.main, *draft.annexes):
        things = equipment.utilities(rng, style, built)
        draft.things += things
        if built is draft.main:
            draft.plan.obstacles += [footprint(t, at) for t, at in things if t.kind == "boiler"]
        draft.things += equipment.small_fittings(rng, style, built)


def _glaze(draft: Draft, windows: list[Glazing]) -> list[Light]:
    """A frame and a portal of daylight for each opening."""
    seed, brightness = int(draft.rng.integers(2**32)), float(draft.rng.uniform(3, 6))
    for glazing in windows:
        own = np.random.default_rng(seed)  # the windows of a house are alike
        hole = glazing.hole
        roof = glazing.wall is None
        made = window(
            own,
            draft.style,
            opening=hole,
            depth=glazing.depth,
            design="roof" if roof else None,
            sill=not roof and hole.z0 > 0.2 and hole.shape != "round",
        )
        draft.things.append((made, glazing.frame @ pose(hole.centre[0], 0.0, hole.z0)))
    return [portal(glazing, brightness) for glazing in windows]


def _outdoors(
    draft: Draft,
    windows: list[Glazing],
    sun: Sun | None,
) -> None:
    """Ground, and a house or a hedge before some of the sides with windows."""
    rng, plan = draft.rng, draft.plan
    level = (
        outdoors.GROUND
        if draft.chance(0.65) and plan.features != ["slope"]
        else -float(rng.uniform(2.9, 6.5))
    )
    corners = np.concatenate([built.points for built in (draft.main, *draft.annexes)])
    low, high = corners.min(0), corners.max(0)
    whole = (float(low[0]), float(high[0]), float(low[1]), float(high[1]))
    draft.things.append((outdoors.ground(rng, whole, level), pose()))
    closed = {side_of(p.near, draft.rect) for p in draft.passages if p.near in draft.main.walls}
    open_sides = sorted({side_facing(w.wall) for w in windows if w.wall is not None} - closed)
    for side in open_sides:
        out = np.array([(0, -1), (1, 0), (0, 1), (-1, 0)][side])
        sunlit = sun is not None and float(np.dot(out, sun[0][:2])) > 0.1
        roll, away, width = float(rng.uniform()), float(rng.uniform(3, 8)), 13.0
        if roll > 0.6 or sunlit:
            continue
        at = outdoors.beyond_side(draft.rect, side, away, width)
        if roll < 0.4:
            draft.things.append((outdoors.opposite_house(rng, width, level), at))
        elif level > -1:
            draft.things.append((outdoors.hedge(rng, width, level), at))
    for glazing in windows:
        wall, hole = glazing.wall, glazing.hole
        if wall is not None and hole.z0 < 0.1 and (level < -1 or draft.chance(0.3)):
            made = outdoors.balcony(rng, draft.style, hole.x1 - hole.x0 + 0.5)
            draft.things.append((made, wall.at(hole.centre[0], wall.thickness + 0.004)))
