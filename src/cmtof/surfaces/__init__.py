"""Unwrapping at the limit of the data: surfaces in true geometry, pooled and tied."""
