"""What Fig. 14 looks at: two gauge blocks side by side, and a slanted plane."""

import numpy as np

from cmtof.instrument.targets import MeshTarget, Plane, assembled

STEEL = 0.58
"""Reflectance of lapped steel at 532 nm (known: 0.55 to 0.6)."""
MIRRORED = 0.7
"""Weight of its specular law (assumed): lapping leaves a matt sheen beside the mirror image."""
WIDTH, HEIGHT = 9e-3, 30e-3
"""Face of a gauge block, m (known: 9 mm by 30 mm up to 10 mm of length)."""
GRADE_2 = 0.45e-6
"""Greatest deviation of a block's length from nominal, m, up to 10 mm (DIN 861, grade 2; tables of
two makers and dealers agree, the standard itself was not seen)."""


def gage_blocks(
    step: float = 0.5e-3,
    distance: float = 1.0,
    *,
    tilt: float = 0.02,
    mirrored: float = MIRRORED,
    errors: tuple[float, float] = (0.0, 0.0),
) -> MeshTarget:
    """Two gauge blocks, wrung on a flat mount side by side, their measuring faces ahead.

    The left face meets the axis at ``distance``; beside the faces nothing returns.

    Parameters
    ----------
    step : float
        Difference of their nominal lengths, m; the right one stands nearer by it.
    distance : float
        From the instrument to the left block's face, m.
    tilt : float
        By which both faces are turned about the upright axis, rad, so that the mirror image of the
        beam misses the instrument (assumed).
    mirrored : float
        Weight of the law of a specular surface, 0 to 1.
    errors : tuple of float
        Deviations of both lengths from nominal, m.
    """
    parts = []
    for side, length in ((-1, errors[0]), (1, step + errors[1])):
        x = np.array([0.0, side * WIDTH, side * WIDTH, 0.0])
        y = np.array([-1.0, -1.0, 1.0, 1.0]) * HEIGHT / 2
        # the step is the distance of the two parallel faces, along their normal
        z = distance + np.tan(tilt) * x - length / np.cos(tilt)
        corners = np.stack([x, y, z], -1)
        parts.append(
            MeshTarget(corners, np.array([[0, 1, 2], [0, 2, 3]]), STEEL, "mixed", mirrored)
        )
    return assembled(parts)


def slanted_plane(distance: float = 1.0, tilt: float = 0.5, reflectance: float = 0.5) -> Plane:
    """Return a large diffuse plane, turned about the upright axis by ``tilt``, rad."""
    return Plane(distance, tilt_x=tilt, reflectance=reflectance)
