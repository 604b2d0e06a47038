"""Everything that makes a room lived in but is no furniture: lamps, plants, cloth, pictures."""

from cmtof.scenes.rooms import (
    cables,
    hanging_lamps,
    hangings,
    lamps,
    padding,
    plants,
    table_plants,
    textiles,
    wall_art,
    wall_lamps,
    wall_things,
)
from cmtof.scenes.rooms.shades import Maker

CATALOGUE: dict[str, Maker] = {
    **lamps.CATALOGUE,
    **hanging_lamps.CATALOGUE,
    **wall_lamps.CATALOGUE,
    **plants.CATALOGUE,
    **table_plants.CATALOGUE,
    **textiles.CATALOGUE,
    **hangings.CATALOGUE,
    **padding.CATALOGUE,
    **wall_art.CATALOGUE,
    **wall_things.CATALOGUE,
    **cables.CATALOGUE,
}
"""Makers by name."""
