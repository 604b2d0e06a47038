"""Who lives there: makes things in one style, and puts small things where people put them."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from cmtof.scenes.rooms.inventory import CATALOGUE
from cmtof.scenes.rooms.materials import Style
from cmtof.scenes.rooms.objects import groups
from cmtof.scenes.rooms.placing import Floor, fill_support
from cmtof.scenes.rooms.thing import Support, Thing

PLACES: Mapping[str, str] = {
    "dining_table": "dining table",
    "kitchen_island": "kitchen worktop",
    "kitchen_run": "kitchen worktop",
    "coffee_table": "coffee table",
    "side_table": "nightstand",
    "nightstand": "nightstand",
    "desk": "desk",
    "sewing_machine_table": "desk",
    "console_table": "mantel",
    "sideboard": "mantel",
    "chest_of_drawers": "mantel",
    "tv_stand": "mantel",
    "cupboard": "mantel",
    "upright_piano": "mantel",
    "fireplace": "mantel",
    "workbench": "workbench",
    "metal_rack": "workbench",
    "bookshelf": "shelf",
    "display_cabinet": "shelf",
    "wall_shelf": "shelf",
    "room_divider": "shelf",
    "bathroom_cabinet": "bathroom",
    "washbasin": "bathroom",
    "bathtub": "bathroom",
    "sofa": "sofa",
    "bed": "bed",
    "daybed": "bed",
}
"""Which group of small things (`cmtof.scenes.rooms.objects.groups`) belongs on a piece."""


class Household:
    """Makes things for one scene.

    Parameters
    ----------
    rng : Generator
    style : Style
        Of the big pieces.
    clutter : float
        0 tidy, 1 full.
    """

    def __init__(self, rng: np.random.Generator, style: Style, clutter: float) -> None:
        self.rng, self.style, self.clutter = rng, style, clutter

    def make(self, name: str, **options: Any) -> Thing:
        """Make one thing by its catalogue name."""
        return CATALOGUE[name](self.rng, self.style, **options).settle()

    def one_of(self, *names: str, **options: Any) -> Thing:
        """Make one of several, drawn."""
        return self.make(str(self.rng.choice(names)), **options)

    def dressed(self, *names: str, density: float = 1.0, **options: Any) -> Thing:
        """Make one of several, drawn, and put on it what people put on such a thing."""
        name = str(self.rng.choice(names))
        thing = self.make(name, **options)
        return self.dress(thing, PLACES[name], density) if name in PLACES else thing

    def chance(self, probability: float) -> bool:
        """True that often."""
        return bool(self.rng.uniform() < probability)

    def dress(self, thing: Thing, place: str, density: float = 1.0) -> Thing:
        """Put small things on every support of a thing; returns it.

        Parameters
        ----------
        place : str
            Key of the groups of small things.
        density : float
            Factor on how many.
        """
        for support in list(thing.supports):
            self._fill(thing, support, place, density)
        return thing.settle()

    def _fill(self, thing: Thing, support: Support, place: str, density: float) -> None:
        width, depth = support.x1 - support.x0, support.y1 - support.y0
        if min(width, depth) < 0.05:
            return
        if place == "shelf" and self.chance(0.55) and support.clearance > 0.16 and width > 0.2:
            width = self._books(thing, support)
            support = support._replace(x0=support.x1 - width)
            if width < 0.12:
                return
        area = width * depth
        mean = density * (0.3 + 1.7 * self.clutter) * (1.0 + 5.0 * area)
        names, weights = zip(*groups[place], strict=True)
        share = np.asarray(weights, float) / sum(weights)

        def draw() -> Thing:
            return self.make(str(self.rng.choice(names, p=share)))

        most = min(int(self.rng.poisson(mean)), 14)
        thing.children += fill_support(support, draw, self.rng, most=most)

    def _books(self, thing: Thing, support: Support) -> float:
        """Stand a row of books on a shelf, from its left end; returns the width that is left."""
        width, depth = support.x1 - support.x0, support.y1 - support.y0
        length = float(self.rng.uniform(0.35, 1.0)) * width
        height = min(support.clearance - 0.02, float(self.rng.uniform(0.2, 0.32)))
        row = self.make("book_row", length=length, height=height, depth=min(depth, 0.24))
        low, high = row.bounds
        if high[0] - low[0] > width or high[2] > support.clearance or high[1] - low[1] > depth:
            return width
        y = (support.y0 + support.y1) / 2 + min(0.0, (depth - (high[1] - low[1])) / 2 - 0.02)
        y = float(np.clip(y - (low[1] + high[1]) / 2, support.y0 - low[1], support.y1 - high[1]))
        thing.carry(row, support.x0 - float(low[0]), y, support.z + 5e-4)
        return width - float(high[0] - low[0]) - 0.02

    def scatter(self, floor: Floor, place: str, most: int) -> None:
        """Leave things of a group on the floor, near the walls."""
        names, weights = zip(*groups[place], strict=True)
        share = np.asarray(weights, float) / sum(weights)
        for _ in range(most):
            thing = self.make(str(self.rng.choice(names, p=share)))
            if self.chance(0.7) or thing.bounds[1, 2] > 0.8:  # what is tall would fall over
                floor.against_wall(thing, tries=6)
            else:
                floor.somewhere(thing, tries=6)
