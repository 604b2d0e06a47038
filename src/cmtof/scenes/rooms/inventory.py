"""Everything that can be made, by name."""

from collections.abc import Callable

from cmtof.scenes.rooms import decor, fittings, furniture, objects
from cmtof.scenes.rooms.thing import Thing

CATALOGUE: dict[str, Callable[..., Thing]] = {
    **fittings.CATALOGUE,
    **decor.CATALOGUE,
    **objects.CATALOGUE,
    **furniture.CATALOGUE,
}
"""Makers ``(rng, style, **options) -> Thing``."""
