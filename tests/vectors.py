"""Directions of vectors."""

import numpy as np


def unit(vectors):
    """Vectors (..., 3) of the same directions and of length one."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
