"""Types that several modules share."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]
"""Real numbers."""

Flags = NDArray[np.bool_]
"""True or false."""

Numbers = NDArray[np.integer]
"""Numbers of parts, things, triangles, vertices."""

Vector = Sequence[float] | Array
"""A few numbers, such as a point or a size, m."""

Pair = tuple[float, float]
Triple = tuple[float, float, float]

Shape = tuple[int, int]
"""Height and width of an image, px."""
