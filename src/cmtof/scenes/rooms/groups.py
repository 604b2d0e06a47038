"""Things that belong together: sofa and low table, table and chairs, desk and lamp."""

import numpy as np

from cmtof.scenes.rooms.house import facing
from cmtof.scenes.rooms.household import Household
from cmtof.scenes.rooms.placing import Floor, footprint
from cmtof.scenes.rooms.thing import Pose, Thing, pose


def _before(motion: Pose, thing: Thing, gap: float, other: Thing) -> Pose:
    """Pose of ``other`` in front of a thing, face to face, ``gap`` m between them."""
    away = gap - thing.bounds[0, 1] + (other.bounds[1, 1] - other.bounds[0, 1]) / 2
    return motion @ pose(0.0, -float(away), 0.0, np.pi)


def seating(floor: Floor, house: Household) -> None:
    """A sofa, a table before it, a rug below, seats and lamps about, a television opposite."""
    rng = house.rng
    sofa = house.make("sofa")
    at = floor.against_wall(sofa, room_before=1.0, tries=40)
    if at is None:
        sofa = house.make("sofa", seats=2)
        at = floor.against_wall(sofa, room_before=0.7, tries=40)
    if at is None:  # no wall is long enough: it stands in the open, as in many large rooms
        where = floor.somewhere(sofa, gap=0.6)
        if where is None:
            return
        at = where, -1
    motion, number = at
    if house.chance(0.5):
        _throw(house, sofa)
    table = house.dressed("coffee_table")
    where = _before(motion, sofa, float(rng.uniform(0.3, 0.5)), table)
    if floor.free(footprint(table, where)):
        floor.put(table, where)
        if house.chance(0.75):
            floor.put(house.make("rug"), where @ pose(turn=float(rng.normal(0, 0.03))), solid=False)
        for side in (-1, 1):
            if house.chance(0.55):
                seat = house.one_of("armchair", "armchair", "ottoman", "rocking_chair", "pouf")
                x = side * (table.bounds[1, 0] + 0.5 - seat.bounds[0, 1])
                turn = facing((-side, 0.0)) + float(rng.normal(0, 0.25))
                chair = where @ pose(float(x), float(rng.normal(0, 0.2)), 0.0, turn)
                if floor.free(footprint(seat, chair)):
                    floor.put(seat, chair)
    _beside(floor, house, motion, sofa, ("floor_lamp", "side_table", "side_table"))
    if house.chance(0.65):
        stand = house.make("tv_stand")
        if house.chance(0.8):
            _carry_on_top(stand, house.make("television"))
        house.dress(stand, "mantel", density=0.5)
        opposite = _opposite(floor, number) if number >= 0 else None
        if opposite is None or not _stand_at(floor, stand, opposite):
            floor.against_wall(stand, room_before=0.6)


def _opposite(floor: Floor, number: int) -> int | None:
    """Number of the wall that looks most straight at another."""
    turned = [float(wall.inward @ floor.walls[number].inward) for wall in floor.walls]
    best = int(np.argmin(turned))
    return best if turned[best] < -0.9 else None


def _stand_at(floor: Floor, thing: Thing, number: int) -> bool:
    """Stand a thing against one given wall."""
    walls = floor.walls
    only = Floor([*floor.rectangles], [walls[number]], floor.height, floor.rng)
    only.placed, only.taken = floor.placed, floor.taken
    only.hung = [(0, *rest) for n, *rest in floor.hung if n == number]  # type: ignore[misc]
    before = len(only.hung)
    if only.against_wall(thing) is None:
        return False
    floor.hung += [(number, *rest) for _, *rest in only.hung[before:]]  # type: ignore[misc]
    return True


def _throw(house: Household, sofa: Thing) -> None:
    """A pillow or two more on the seat."""
    for support in sofa.supports[:1]:
        for _ in range(int(house.rng.integers(1, 3))):
            pillow = house.make("cushion_pillow")
            x = float(house.rng.uniform(support.x0 + 0.2, max(support.x1 - 0.2, support.x0 + 0.21)))
            y = float((support.y0 + support.y1) / 2)
            sofa.carry(pillow, x, y, support.z, float(house.rng.uniform(-0.5, 0.5)))


def _carry_on_top(stand: Thing, thing: Thing) -> None:
    """Put a thing in the middle of the highest support, and keep clutter off it."""
    if not stand.supports:
        return
    top = max(stand.supports, key=lambda support: support.z)
    low, high = thing.bounds
    if high[0] - low[0] > top.x1 - top.x0 + 0.3 or high[1] - low[1] > top.y1 - top.y0 + 0.05:
        return
    y = float(
        np.clip((top.y0 + top.y1) / 2, top.y0 - low[1], max(top.y1 - high[1], top.y0 - low[1]))
    )
    stand.carry(thing, (top.x0 + top.x1) / 2, y, top.z + 5e-4)
    stand.supports.remove(top)


def _beside(
    floor: Floor, house: Household, motion: Pose, thing: Thing, names: tuple[str, ...]
) -> None:
    """Left and right of a thing that stands at a wall: one of ``names`` each, dressed."""
    for side in (-1, 1):
        if not house.chance(0.7):
            continue
        name = str(house.rng.choice(names))
        other = house.make(name)
        if name in ("side_table", "nightstand"):
            if house.chance(0.6):
                _carry_on_top(other, house.make("table_lamp"))
            house.dress(other, "nightstand", density=0.7)
        edge = thing.bounds[1 if side > 0 else 0, 0]
        half = (other.bounds[1] - other.bounds[0])[:2] / 2
        y = thing.bounds[1, 1] - half[1]
        where = motion @ pose(float(edge + side * (half[0] + 0.06)), float(y))
        if floor.free(footprint(other, where), gap=0.0):
            floor.put(other, where)


def dining(floor: Floor, house: Household) -> None:
    """A laid table in the open with its chairs, some pulled out, and a lamp above."""
    rng = house.rng
    table = house.make("dining_table")
    if house.chance(0.3) and table.supports:
        top = table.supports[0]
        size = {"length": top.x1 - top.x0, "width": top.y1 - top.y0}
        cloth = house.make("tablecloth", **size)
        table.carry(cloth, (top.x0 + top.x1) / 2, (top.y0 + top.y1) / 2, top.z + 1e-3)
        table.supports[0] = top._replace(z=top.z + 0.004)
    house.dress(table, "dining table", density=1.2)
    where = floor.somewhere(table, gap=0.75)
    if where is None:
        where = floor.somewhere(table, gap=0.3)
    if where is None:
        return
    design = int(rng.integers(2**31))
    low, high = table.bounds
    along = max(1, int((high[0] - low[0]) / 0.65))
    for side in (-1, 1):
        for k in range(along):
            x = low[0] + (high[0] - low[0]) * (k + 0.5) / along
            _pull_up(floor, house, where, design, float(x), side * float(high[1]), side)
    for side in (-1, 1):
        if house.chance(0.6):
            _pull_up(floor, house, where, design, side * float(high[0]), 0.0, side, end=True)
    if house.chance(0.6) and house.chance(0.7):
        rug = house.make("rug")
        floor.put(rug, where, solid=False)
    if floor.height < 4.5:
        lamp = house.make("pendant", drop=floor.height - float(rng.uniform(1.5, 1.7)))
        floor.put(lamp, where @ pose(0, 0, floor.height), solid=False)


def _pull_up(
    floor: Floor, house: Household, where: Pose, design: int, x: float, y: float, side: int,
    end: bool = False,
) -> None:  # fmt: skip
    """A chair at a table's edge, pushed in or pulled out, of the set's design."""
    rng = house.rng
    if not house.chance(0.9):
        return
    seat = Household.make
    own, house.rng = house.rng, np.random.default_rng(design)  # the chairs of a set are alike
    chair = seat(house, "dining_chair")
    house.rng = own
    half = float(chair.bounds[1, 1] - chair.bounds[0, 1]) / 2
    out = half + float(rng.choice([-0.22, -0.15, 0.05, 0.25])) + float(rng.normal(0, 0.03))
    turn = float(rng.normal(0, 0.08 if out < half else 0.3))
    if end:
        motion = where @ pose(x + side * out, 0.0, 0.0, facing((-side, 0.0)) + turn)
    else:
        motion = where @ pose(x, y + side * out, 0.0, facing((0.0, -side)) + turn)
    x0, x1, y0, y1 = footprint(chair, motion)
    inner = (x0 + 0.1, x1 - 0.1, y0 + 0.1, y1 - 0.1)
    others = floor.taken[:]
    floor.taken = [t for t in others if not _is_table(t, where)]
    fits = floor.free(inner, gap=0.0)
    floor.taken = others
    if fits:
        floor.put(chair, motion)


def _is_table(area: tuple[float, float, float, float], where: Pose) -> bool:
    """Whether the rectangle is centred on the table's place: chairs may slide under it."""
    x, y = (area[0] + area[1]) / 2, (area[2] + area[3]) / 2
    return float(np.hypot(x - where[0, 3], y - where[1, 3])) < 0.15


def sleeping(floor: Floor, house: Household) -> None:
    """A bed with its head to the wall, something on either side, a rug, a chest at its foot."""
    bed = house.make(str(house.rng.choice(["bed", "bed", "bed", "daybed"])))
    at = floor.against_wall(bed, tries=40, room_before=0.5)
    if at is None:
        bed = house.make("bed", width=0.9)
        at = floor.against_wall(bed, tries=40)
    if at is None:
        return
    motion, _ = at
    house.dress(bed, "bed", density=0.3)
    _beside(floor, house, motion, bed, ("nightstand", "nightstand", "nightstand", "side_table"))
    if house.chance(0.6):
        floor.put(house.make("rug"), motion @ pose(0.3, -0.6, 0.0, np.pi / 2), solid=False)
    storage(floor, house, ("wardrobe", "chest_of_drawers", "wardrobe", "clothes_rail"), 2)


def working(floor: Floor, house: Household) -> None:
    """A desk with what one works at, a chair before it, a board above."""
    rng = house.rng
    desk = house.make("desk")
    back = (
        max(desk.supports, key=lambda s: (s.x1 - s.x0) * (s.y1 - s.y0)) if desk.supports else None
    )
    if back is not None:
        screen = house.one_of("monitor", "monitor", "laptop")
        x, y = float(rng.uniform(-0.15, 0.15)), back.y1 - 0.16
        desk.carry(screen, x, float(y), back.z + 5e-4, float(rng.normal(0, 0.1)))
        reach = float(screen.bounds[0, 1])
        if screen.kind == "monitor":
            desk.carry(house.make("keyboard"), x, float(y + reach - 0.16), back.z + 5e-4)
        rest = back._replace(x0=x + float(screen.bounds[1, 0]) + 0.05)
        left = back._replace(x1=x + float(screen.bounds[0, 0]) - 0.05)
        desk.supports = [s for s in desk.supports if s is not back]
        desk.supports += [s for s in (rest, left) if s.x1 - s.x0 > 0.12]
        if house.chance(0.7) and left.x1 - left.x0 > 0.25:
            desk.carry(house.make("desk_lamp"), left.x0 + 0.12, float(y - 0.05), back.z + 5e-4)
            desk.supports[-1] = left._replace(x0=left.x0 + 0.24)
    house.dress(desk, "desk", density=1.3)
    at = floor.against_wall(desk, room_before=0.6)
    if at is None:
        return
    motion, number = at
    chair = house.one_of("office_chair", "office_chair", "dining_chair")
    gap = float(rng.uniform(-0.25, 0.25))
    turn = np.pi + float(rng.normal(0, 0.5))
    y = desk.bounds[0, 1] - gap - (chair.bounds[1, 1] - chair.bounds[0, 1]) / 2
    floor.put(chair, motion @ pose(float(rng.normal(0, 0.1)), float(y), 0.0, turn))
    if house.chance(0.5):
        board = house.dressed("pinboard", "wall_shelf", "whiteboard", "calendar")
        wall = floor.walls[number]
        at_wall = float((motion[:2, 3] - np.asarray(wall.start)) @ wall.along)
        if wall.height > 2.2 and floor.wall_free(number, at_wall, board, 1.65):
            floor.hang(board, number, at_wall, 1.65)


def cooking(floor: Floor, house: Household) -> None:
    """Units along the longest free wall, cupboards and a hood above, a fridge, an island."""
    rng = house.rng
    longest = max(wall.length for wall in floor.walls)
    for length in (min(longest - 0.9, 4.2), 3.0, 2.2, 1.6):
        if length < 1.5:
            continue
        run = house.make("kitchen_run", length=float(length))
        at = floor.against_wall(run, tries=40, room_before=0.9)
        if at is None:
            continue
        house.dress(run, "kitchen worktop", density=1.2)
        motion, number = at
        wall = floor.walls[number]
        centre = float((motion[:2, 3] - np.asarray(wall.start)) @ wall.along)
        above = house.chance(0.75)
        units = (
            house.make("wall_units", length=float(length * rng.uniform(0.4, 0.95)))
            if above
            else house.make("range_hood")
        )
        if wall.height > 2.3 and floor.wall_free(number, centre, units, 1.8):
            floor.hang(units, number, centre, 1.8)
        break
    floor.against_wall(house.make("fridge"), room_before=0.5)
    if house.chance(0.4):
        island = house.dressed("kitchen_island")
        where = floor.somewhere(island, gap=0.7)
        if where is not None:
            for k in range(int(rng.integers(0, 4))):
                stool = house.make("bar_stool")
                y = island.bounds[0, 1] - 0.3
                spot = where @ pose(-0.6 + 0.6 * k, float(y), 0.0, float(rng.uniform(0, 6.28)))
                if floor.free(footprint(stool, spot), gap=0.0):
                    floor.put(stool, spot)


def bathing(floor: Floor, house: Household) -> None:
    """Tub or shower, basin with a cabinet above it, toilet, towels, small stuff."""
    tub = house.dressed("bathtub", "bathtub", "shower_cabin", density=0.6)
    floor.against_wall(tub, where=float(house.rng.choice([0.0, 1.0])))
    at = floor.against_wall(house.dressed("washbasin"), room_before=0.5)
    if at is not None:
        motion, number = at
        wall = floor.walls[number]
        centre = float((motion[:2, 3] - np.asarray(wall.start)) @ wall.along)
        glass = house.one_of("bathroom_cabinet", "mirror")
        if floor.wall_free(number, centre, glass, 1.6):
            floor.hang(glass, number, centre, 1.6)
    floor.against_wall(house.make("toilet"), room_before=0.5)
    floor.on_wall(house.make("towel_rail"), 1.3)
    floor.on_wall(house.make("hanging_towel"), 1.4)
    floor.against_wall(house.make("laundry_basket"))
    if house.chance(0.6):
        floor.somewhere(house.make("doormat"))


def storage(floor: Floor, house: Household, names: tuple[str, ...], most: int) -> None:
    """Stand up to ``most`` of some pieces against the walls, with what lies on them."""
    for _ in range(most):
        floor.against_wall(house.dressed(*names))


def shelves(floor: Floor, house: Household) -> None:
    """Books and good china."""
    storage(floor, house, ("bookshelf", "bookshelf", "display_cabinet", "sideboard"), 2)


def arriving(floor: Floor, house: Household) -> None:
    """Coats, shoes, a mirror, and what does not fit elsewhere."""
    names = ("coat_stand", "shoe_rack", "console_table", "bench", "chest_of_drawers", "wardrobe")
    storage(floor, house, names, 4)
    floor.on_wall(house.make("coat_hooks"), 1.6)
    floor.on_wall(house.make("mirror"), 1.5)
    if house.chance(0.5):
        floor.against_wall(house.one_of("umbrella_stand", "bicycle", "pram"))
    floor.somewhere(house.make("rug"))


def repairing(floor: Floor, house: Household) -> None:
    """Benches and racks with tools, boxes and things under repair."""
    for _ in range(int(house.rng.integers(1, 3))):
        floor.against_wall(house.dressed("workbench", density=1.5), room_before=0.4)
    storage(floor, house, ("metal_rack", "metal_rack", "filing_cabinet", "cupboard"), 3)
    floor.against_wall(house.one_of("bicycle", "stepladder", "exercise_bike", "ironing_board"))
    if house.chance(0.5):
        floor.somewhere(house.one_of("bicycle", "stepladder", "easel"))
    house.scatter(floor, "floor corner", 5)


def playing(floor: Floor, house: Household) -> None:
    """A child's bed, a chest of toys, and the toys."""
    floor.against_wall(house.one_of("crib", "bunk_bed", "daybed"))
    storage(floor, house, ("toy_chest", "chest_of_drawers", "bookshelf"), 2)
    floor.somewhere(house.one_of("rug", "beanbag"))
    if house.chance(0.5):
        floor.somewhere(house.one_of("rocking_horse", "high_chair", "rocking_chair"))
    house.scatter(floor, "toy corner", int(house.rng.integers(4, 10)))


def music(floor: Floor, house: Household) -> None:
    """Now and then a piano or a guitar."""
    if house.chance(0.3):
        floor.against_wall(house.dressed("upright_piano", "grand_piano"), room_before=0.6)
        floor.somewhere(house.make("music_stand"))
    if house.chance(0.2):
        floor.against_wall(house.make("guitar"))


def hang_on_walls(floor: Floor, house: Household, most: int) -> None:
    """Pictures, clocks and shelves where the walls are free."""
    names = ("painting", "painting", "picture_group", "mirror", "wall_clock", "poster",
             "plates_on_wall", "wall_shelf", "wall_sconce", "map", "tapestry", "wall_planter",
             "mask", "wall_hanging", "dartboard", "flag", "thermometer", "key_board", "letters",
             "neon", "light_strip", "string_lights")  # fmt: skip
    for _ in range(most):
        thing = house.dressed(*names)
        floor.on_wall(thing, float(house.rng.uniform(1.4, 1.75)))


def fill_corners(floor: Floor, house: Household, most: int) -> None:
    """Plants and floor lamps in what corners are left."""
    names = ("floor_lamp", "monstera", "ficus", "palm", "snake_plant", "fern", "dried_branches")
    for _ in range(most):
        corner = float(house.rng.choice([0.0, 1.0]))
        floor.against_wall(house.one_of(*names), where=corner, tries=12)


def leave_cable(floor: Floor, house: Household) -> None:
    """A cable where one may stumble over it."""
    x0, x1, y0, y1 = max(floor.rectangles, key=lambda r: (r[1] - r[0]) * (r[3] - r[2]))
    u, v = house.rng.uniform(0.15, 0.85, 2)
    x, y = x0 + u * (x1 - x0), y0 + v * (y1 - y0)
    cable = house.one_of("cable_on_floor", "power_strip", "extension_reel")
    motion = pose(float(x), float(y), 0.0, float(house.rng.uniform(0, 6.28)))
    if floor.free(footprint(cable, motion), gap=0.0):
        floor.put(cable, motion, solid=False)
