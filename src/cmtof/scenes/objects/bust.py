"""A diffuse bust of plaster on a socle."""

import numpy as np

from cmtof.instrument.targets import MeshTarget
from cmtof.scenes.objects.staging import Piece, lathe, refined, staged
from cmtof.scenes.rooms.joinery import boards
from cmtof.scenes.rooms.portraits import Face, portrait
from cmtof.scenes.rooms.solids import sheet
from cmtof.scenes.rooms.thing import Mesh

PLASTER = 0.8
"""Reflectance of plaster at 532 nm (known: 0.8 to 0.9 when clean)."""
FIELD = 0.36
"""Full angle that frames it, rad."""

_ROWS, _COLUMNS, _FINER = 96, 96, 3
_HEAD, _FOOT = 0.125, 0.055  # m: chin to crown; height of the socle
_FACE = Face(nose=0.13, jaw=0.03, brow=0.035, hair=0.06, curl=0.6, beard=0.0, turn=0.3, nod=0.04,
    broad=0.8, cut="square")  # fmt: skip


def bust() -> MeshTarget:
    """Build the bust before its wall."""
    coarse = portrait(np.random.default_rng(7), _FACE, _HEAD, _ROWS, _COLUMNS)
    # the first row is the middle of the cut below: a fan, not a part of the smooth surface
    grid = coarse.vertices.reshape(_ROWS + 1, _COLUMNS, 3)[1:]
    fine = refined(grid, _FINER)
    fine[..., 2] += _FOOT - 0.006
    low = np.broadcast_to(fine[0].mean(0), fine[:1].shape)
    body = sheet(np.concatenate([low, fine]), closed=True)
    turned = lathe(np.array([(0, 0.15), (0.044, 0.15), (0.046, 0.28), (0.03, 0.42), (0.024, 0.6),
        (0.03, 0.82), (0.042, 0.92), (0.042, 1.0), (0, 1.0)]) * [1, _FOOT])  # fmt: skip
    base = boards([(-0.05, 0.05, -0.05, 0.05, 0, 0.2 * _FOOT)], 0.002)
    whole: list[Mesh] = [body, turned, base]
    return staged([Piece(mesh, PLASTER) for mesh in whole], middle=0.145, pitch=0.1)
