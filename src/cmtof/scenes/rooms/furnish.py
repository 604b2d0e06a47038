"""What stands in each kind of room, and what goes with what."""

from collections.abc import Callable

from cmtof.scenes.rooms import groups
from cmtof.scenes.rooms.household import Household
from cmtof.scenes.rooms.placing import Floor
from cmtof.scenes.rooms.thing import pose


def furnish(floor: Floor, house: Household, kind: str, *, sparse: bool = False) -> None:
    """Fill a room as its kind asks; ``sparse`` for rooms that are only passed through."""
    if sparse:
        groups.storage(floor, house, ("chest_of_drawers", "bookshelf", "console_table", "bench"), 2)
        groups.hang_on_walls(floor, house, 2)
        groups.fill_corners(floor, house, 1)
        return
    for group in ROOMS[kind]:
        group(floor, house)
    _more(floor, house, kind)
    groups.hang_on_walls(floor, house, int(house.rng.integers(5, 12)))
    groups.fill_corners(floor, house, int(house.rng.integers(2, 5)))
    place = "toy corner" if kind == "nursery" else "floor corner"
    house.scatter(floor, place, int(house.rng.poisson(3 + 6 * house.clutter)))
    if house.chance(0.5):
        groups.leave_cable(floor, house)


def _more(floor: Floor, house: Household, kind: str) -> None:
    """Fill what walls and floor are left: rooms that are lived in are seldom empty."""
    at_walls, in_the_open = EXTRAS[kind]
    length = sum(wall.length for wall in floor.walls)
    for _ in range(int(house.rng.uniform(0.6, 1.1) * length / 1.3)):
        floor.against_wall(house.dressed(*at_walls), tries=12)
    area = max((b - a) * (d - c) for a, b, c, d in floor.rectangles)
    for _ in range(int(house.rng.poisson(area / 3.5))):
        floor.somewhere(house.dressed(*in_the_open), gap=0.2, tries=12)


def hang_lamps(floor: Floor, house: Household, spots: list[tuple[float, float, float]]) -> None:
    """Hang lamps where the ceiling has places for them, at most four."""
    for x, y, z in spots[:4]:
        lamp = house.one_of("pendant", "ceiling_lamp", "ceiling_lamp", "chandelier", "track_spots")
        if z + lamp.bounds[0, 2] < 1.9:
            lamp = house.make("ceiling_lamp")
        floor.put(lamp, pose(x, y, z, float(house.rng.uniform(0, 6.28))), solid=False)


Group = Callable[[Floor, Household], None]

ROOMS: dict[str, tuple[Group, ...]] = {
    "living": (groups.seating, groups.shelves, groups.music),
    "dining": (groups.dining, groups.shelves),
    "bedroom": (groups.sleeping, groups.working),
    "kitchen": (groups.cooking, groups.dining),
    "office": (groups.working, groups.working, groups.shelves),
    "hallway": (groups.arriving,),
    "bathroom": (groups.bathing,),
    "attic": (groups.sleeping, groups.seating, groups.shelves),
    "workshop": (groups.repairing,),
    "nursery": (groups.playing,),
}
"""Groups of things in each kind of room, the most important first."""

_LIVING = ("bookshelf", "bookshelf", "sideboard", "cupboard", "display_cabinet", "console_table",
           "armchair", "bench", "upright_piano", "wine_rack", "fish_tank", "side_table", "guitar",
           "basket", "bicycle")  # fmt: skip
_SEATS = ("armchair", "ottoman", "pouf", "side_table", "stool", "rocking_chair", "dining_chair")
_CHILD = ("toy_chest", "bookshelf", "chest_of_drawers", "wardrobe", "desk", "basket")

EXTRAS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "living": (_LIVING, (*_SEATS, "side_table", "beanbag")),
    "dining": (_LIVING, (*_SEATS, "high_chair")),
    "bedroom": (
        ("wardrobe", "chest_of_drawers", "clothes_rail", "bookshelf", "armchair", "bench",
         "sewing_machine_table", "laundry_basket", "toy_chest", "room_divider"),
        (*_SEATS, "laundry_basket", "suitcase", "exercise_bike"),
    ),
    "kitchen": (
        ("cupboard", "bookshelf", "bench", "console_table", "wine_rack", "metal_rack", "stool"),
        ("stool", "bar_stool", "high_chair", "stepladder", "dining_chair"),
    ),
    "office": (
        ("bookshelf", "filing_cabinet", "metal_rack", "cupboard", "desk", "sideboard", "printer"),
        ("office_chair", "armchair", "stool", "cardboard_box", "side_table", "camera_on_tripod"),
    ),
    "hallway": (
        ("chest_of_drawers", "bench", "wardrobe", "coat_stand", "shoe_rack", "cupboard"),
        ("stepladder", "pram", "suitcase", "stool"),
    ),
    "bathroom": (
        ("cupboard", "clothes_rail", "laundry_basket", "stool", "metal_rack"),
        ("stool", "laundry_basket", "ironing_board"),
    ),
    "attic": (
        ("chest_of_drawers", "toy_chest", "cardboard_box", "bench", "suitcase", "bookshelf"),
        ("rocking_chair", "cardboard_box", "rocking_horse", "suitcase", "easel", "bicycle"),
    ),
    "workshop": (
        ("metal_rack", "workbench", "cupboard", "filing_cabinet", "bicycle", "stepladder"),
        ("stool", "bicycle", "stepladder", "bucket", "cardboard_box", "workbench"),
    ),
    "nursery": (_CHILD, ("rocking_horse", "toy_train", "building_blocks", "stool", "ball_toy")),
}  # fmt: skip
"""What else may stand at the walls, and in the open, of each kind of room."""
