"""Objects a metre before the instrument, as Figs. 14 to 16 show them; all of them our own.

Each is a target of the simulated instrument, of fine meshes with materials at 532 nm:

>>> from cmtof.instrument.world import World
>>> from cmtof.instrument.settings import TwinSettings
>>> world = World(TwinSettings(), object_scene("owl"))
>>> bool(0.9 < world.ranges([[0.0, 0.0]])[0] < 1.0)
True
"""

from functools import lru_cache
from importlib import import_module
from types import ModuleType

from cmtof.instrument.targets import MeshTarget
from cmtof.scenes.objects.flat import gage_blocks, slanted_plane

OBJECTS = ("bust", "helmet", "owl", "table")
"""Names of the objects: diffuse plaster, specular metal, textured plumage, a cluttered table."""

__all__ = ["OBJECTS", "field_of_view", "gage_blocks", "object_scene", "slanted_plane"]


def _module(name: str) -> ModuleType:
    if name not in OBJECTS:
        raise ValueError(
            f"Expected an object out of {', '.join(OBJECTS)}, got {name!r}. Choose one."
        )
    return import_module(f"{__name__}.{name}")


@lru_cache(maxsize=len(OBJECTS))
def object_scene(name: str) -> MeshTarget:
    """Return an object about 1 m before the instrument, with a wall behind it.

    Parameters
    ----------
    name : str
        One of `OBJECTS`.

    Raises
    ------
    ValueError
        For another name.
    """
    return getattr(_module(name), name)()


def field_of_view(name: str) -> float:
    """Return the full optical angle that frames an object across and down, rad."""
    return _module(name).FIELD
