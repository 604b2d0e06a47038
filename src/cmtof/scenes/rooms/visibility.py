"""Which lamps can be seen from where, roughly: so that rays are not spent on lamps behind walls."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from cmtof.scenes.rooms.tracing import Tracer

CELL = 1.0
"""Side of the cells, m."""
_PROBES = 6  # points a cell
_LEAST = 0.03  # share that a lamp keeps where only the neighbours see it


class Visibility(NamedTuple):
    """Share of each cell's points that see each lamp."""

    low: NDArray[np.float32]
    """(3,) corner of the first cell, m."""
    seen: NDArray[np.float32]
    """(X, Y, Z, L), 0 to 1; 0 where no neighbouring cell sees it either."""


def visibility(tracer: Tracer, lights: NDArray[np.void], low: NDArray, high: NDArray) -> Visibility:
    """Probe a box from ``low`` to ``high``, (3,), m, against every lamp."""
    cells = np.maximum(np.ceil((np.asarray(high) - low) / CELL).astype(int), 1)
    index = np.stack(np.meshgrid(*(np.arange(n) for n in cells), indexing="ij"), -1)
    index = index.reshape(-1, 1, 3)
    # the same scattered points in every cell, and on every lamp
    k = np.arange(_PROBES)[:, None] + 0.5
    spread = (k * np.sqrt([2.0, 3.0, 5.0])) % 1
    points = (np.asarray(low) + CELL * (index + spread)).reshape(-1, 3).astype(np.float32)
    across = (2 * ((k * np.sqrt([7.0, 11.0])) % 1) - 1).astype(np.float32)
    across = np.tile(across, (len(index), 1))
    seen = np.empty((*cells, len(lights)), np.float32)
    for number, light in enumerate(lights):
        aim = light["centre"] + across[:, :1] * light["half_u"] + across[:, 1:] * light["half_v"]
        ray = aim - points
        reach = np.linalg.norm(ray, axis=1).astype(np.float32)
        ray = (ray / np.maximum(reach, 1e-6)[:, None]).astype(np.float32)
        free = ~tracer.blocked(points, ray, 0.999 * reach)
        seen[..., number] = free.reshape(*cells, _PROBES).mean(axis=-1)
    near = ndimage.maximum_filter(seen, size=(3, 3, 3, 1))
    seen = np.where(near > 0, np.maximum(seen, _LEAST), 0).astype(np.float32)
    return Visibility(np.asarray(low, np.float32), seen)
