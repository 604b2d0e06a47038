"""Everything that can be made, by name."""

from collections.abc import Callable

from cmtof.scenes.rooms import (
    decor,
    electronics,
    fittings,
    food,
    furniture,
    playthings,
    reading,
    sculpture,
    sundries,
    tableware,
    vessels,
)
from cmtof.scenes.rooms.thing import Thing

CATALOGUE: dict[str, Callable[..., Thing]] = {
    **fittings.CATALOGUE,
    **decor.CATALOGUE,
    **vessels.CATALOGUE,
    **tableware.CATALOGUE,
    **sculpture.CATALOGUE,
    **food.CATALOGUE,
    **reading.CATALOGUE,
    **electronics.CATALOGUE,
    **sundries.CATALOGUE,
    **playthings.CATALOGUE,
    **furniture.CATALOGUE,
}
"""Makers ``(rng, style, **options) -> Thing``."""
