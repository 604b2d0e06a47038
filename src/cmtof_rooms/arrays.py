"""Types that several modules share."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]
"""Real numbers."""

Flags = NDArray[np.bool_]
"""True or false."""

Numbers = NDArray[np.integer]
"""Numbers of parts, things, triangles, vertices."""

Pair = tuple[float, float]
Triple = tuple[float, float, float]

Shape = tuple[int, int]
"""Height and width of an image, px."""
