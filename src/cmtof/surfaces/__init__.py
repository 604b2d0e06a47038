"""Our own method: surfaces in true geometry, grown, pooled and tied to each other."""

from cmtof.surfaces.method import stages, surfaces
from cmtof.surfaces.mirrored import surfaces_mirrored

__all__ = ["stages", "surfaces", "surfaces_mirrored"]
