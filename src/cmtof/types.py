"""Kinds of arrays, for annotations."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]
Single = NDArray[np.float32]
Complex = NDArray[np.complexfloating]
Numbers = NDArray[np.integer]
Flags = NDArray[np.bool_]
Counts = NDArray[np.uint16]
