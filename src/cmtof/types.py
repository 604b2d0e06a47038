"""Names of array and value types, for annotations."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]
Single = NDArray[np.float32]
Complex = NDArray[np.complexfloating]
Numbers = NDArray[np.integer]
Flags = NDArray[np.bool_]
Counts = NDArray[np.uint16]
Shape = tuple[int, int]  # height and width
Pair = tuple[float, float]
Texts = dict[str, str]  # by name, as `Fields` and `Named`
Fields = dict[str, Any]
Named = Mapping[str, Any]
Values = dict[str, float]
Arrays = tuple[Array, Array]
