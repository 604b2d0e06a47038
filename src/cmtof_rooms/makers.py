"""Every maker of furniture by the name that `presets.yml` uses."""

from collections.abc import Callable

from cmtof_rooms import decoration, furniture
from cmtof_rooms.kit import Piece

# A maker fills a box with a piece of furniture; see `cmtof_rooms.kit`.
MAKERS: dict[str, Callable[..., Piece]] = {
    "bed": furniture.bed,
    "cabinet": furniture.cabinet,
    "chair": furniture.chair,
    "shelf": furniture.shelf,
    "sofa": furniture.sofa,
    "table": furniture.table,
    "blob": decoration.blob,
    "cloth": decoration.cloth,
    "lamp": decoration.lamp,
    "picture": decoration.picture,
    "pipe": decoration.pipe,
    "plant": decoration.plant,
    "radiator": decoration.radiator,
    "rug": decoration.rug,
    "stack": decoration.stack,
    "stairs": decoration.stairs,
    "vessel": decoration.vessel,
}
