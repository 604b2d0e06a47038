"""Our own method: smooth surfaces in space, each unwrapped by the phases of all its pixels."""

from cmtof.surfaces.method import stages, surfaces
from cmtof.surfaces.mirrored import surfaces_mirrored

__all__ = ["stages", "surfaces", "surfaces_mirrored"]
