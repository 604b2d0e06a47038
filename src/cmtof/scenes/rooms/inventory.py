"""Everything that can be made, by name."""

from collections.abc import Callable

from cmtof.scenes.rooms import (
    decor,
    electronics,
    figurines,
    fittings,
    food,
    furniture,
    playthings,
    reading,
    sundries,
    ware,
)
from cmtof.scenes.rooms.thing import Thing

CATALOGUE: dict[str, Callable[..., Thing]] = {
    **fittings.CATALOGUE,
    **decor.CATALOGUE,
    **ware.CATALOGUE,
    **figurines.CATALOGUE,
    **food.CATALOGUE,
    **reading.CATALOGUE,
    **electronics.CATALOGUE,
    **sundries.CATALOGUE,
    **playthings.CATALOGUE,
    **furniture.CATALOGUE,
}
"""Makers ``(rng, style, **options) -> Thing``."""
