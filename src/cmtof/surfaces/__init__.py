"""Our own method: surfaces in true geometry, grown, pooled and tied to each other."""

from cmtof.surfaces.method import stages, surfaces

__all__ = ["stages", "surfaces"]
