"""Every maker of furniture by its name, which `presets.yml` uses."""

from collections.abc import Callable

from cmtof_rooms.decoration import (
    blob,
    cloth,
    lamp,
    picture,
    pipe,
    plant,
    radiator,
    rug,
    stack,
    stairs,
    vessel,
)
from cmtof_rooms.furniture import bed, cabinet, chair, shelf, sofa, table
from cmtof_rooms.kit import Piece

# A maker fills a box with a piece of furniture; see `cmtof_rooms.kit`.
MAKERS: dict[str, Callable[..., Piece]] = {
    maker.__name__: maker
    for maker in (
        bed,
        cabinet,
        chair,
        shelf,
        sofa,
        table,
        blob,
        cloth,
        lamp,
        picture,
        pipe,
        plant,
        radiator,
        rug,
        stack,
        stairs,
        vessel,
    )
}
