"""Types of a few numbers."""

from collections.abc import Sequence

from cmtof.types import Array

Vector = Sequence[float] | Array  # such as a point or a size, m
Triple = tuple[float, float, float]
