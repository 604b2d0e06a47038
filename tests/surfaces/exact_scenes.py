"""Scenes in closed form: a furnished corner and single planes, with their exact depth."""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation
from walls import WRAP

from cmtof.constants import FREQUENCIES
from cmtof.correlation import phase_from_depth
from cmtof.frame import Frame
from cmtof.measurement import Measurement
from cmtof.pointcloud import points_from_depth
from cmtof.surfaces.field import CELL, field_from_measurement
from cmtof.surfaces.fitting import move_surface
from cmtof.surfaces.placing import Offsets
from cmtof.surfaces.shapes import BENT

SHAPE = (128, 160)
COLUMNS = np.arange(SHAPE[1])
CELLS = (SHAPE[0] // CELL, SHAPE[1] // CELL)
CAMERA = (140.0, 138.0, 81.0, 62.5)
TILTED = (0.3, -0.2, 1)  # normal of a plane

# Normals and distances, m, of two walls and the floor about a camera at the origin; nearest and
# furthest corner, m, of a box on the floor, turned about the vertical; the camera looks down.
_ROOM = (((0.6, 0.0, 0.8), 2.1), ((-0.8, 0.0, 0.6), 2.0), ((0.0, 1.0, 0.0), 2.1))
_BOX = ((0.95, 1.5, 0.75), (1.55, 2.1, 1.45))
_TURN = np.deg2rad(40)
_PITCH = np.deg2rad(42)
_PAINT = (0.85, 0.65, 0.95, 0.8, 1.0, 0.6)  # of each part


class Scene(NamedTuple):
    """A frame, and which surface each of its pixels shows."""

    frame: Frame
    part: np.ndarray  # 0 and 1 the walls, 2 the floor, 3 to 5 the box's faces


def unit_rays(shape, camera=CAMERA):
    return points_from_depth(np.ones(shape), camera)


def room_hits(rays):
    """Depth, m, of the nearest wall or floor along rays (N, 3), and which it is."""
    depth = [distance / np.maximum(rays @ normal, 1e-9) for normal, distance in _ROOM]
    return np.min(depth, axis=0), np.argmin(depth, axis=0)


def box_hits(rays):
    """Depth, m, of the box, infinite where a ray misses it, and the axis of its face."""
    turned = Rotation.from_euler("y", _TURN).apply(rays)
    near, far = np.sort(np.array(_BOX)[:, None] / turned, axis=0)
    enter = near.max(1)
    hit = (enter > 0) & (enter < far.min(1))
    return np.where(hit, enter, np.inf), near.argmax(1)


def corner_scene(shape=SHAPE, camera=CAMERA):
    """Two walls, a floor and a box before them, hit by formula."""
    rays = unit_rays(shape, camera).reshape(-1, 3)
    level = Rotation.from_euler("x", -_PITCH).apply(rays)
    behind, side = room_hits(level)
    before, face = box_hits(level)
    depth = np.minimum(before, behind).reshape(shape)
    part = np.where(before < behind, 3 + face, side).reshape(shape)
    return Scene(Frame(depth, painted(part), camera), part)


def painted(part):
    """Brightness (H, W) of the parts that pixels show: each its own, with a pattern."""
    rows, columns = np.indices(part.shape)
    pattern = np.sin(0.31 * columns + 0.17 * rows)
    pattern *= np.cos(0.23 * rows)
    return (np.array(_PAINT)[part] * (0.8 + 0.2 * pattern)).clip(0.3, 1)


def plane_depth(normal=TILTED, z=2.5, shape=SHAPE, camera=CAMERA):
    """Range (H, W), m, of the plane through (0, 0, z) with a normal; and its q (6,)."""
    q = np.zeros(6)
    q[:3] = np.asarray(normal, float) / (normal[2] * z)
    return 1 / (unit_rays(shape, camera) @ q[:3]), q


def plane_frame(normal, intensity=1.0):
    depth, _ = plane_depth(normal)
    return Frame(depth, np.broadcast_to(intensity, SHAPE), CAMERA)


def exact_field(depth, *, information=100.0, noise_of=None, camera=CAMERA):
    """Field of known depths in which every pixel and frequency is worth the same information.

    ``noise_of`` is a generator to draw the phasors' own noise from.
    """
    phase = np.stack([phase_from_depth(depth, f) for f in FREQUENCIES])
    measurement = Measurement.from_phase(phase, FREQUENCIES, camera=camera)
    field = field_from_measurement(measurement)
    told = np.full_like(field.information, information)
    size = np.sqrt(told)  # a / s, where the noise is 1 in each component
    phasor = size * np.exp(1j * phase)
    if noise_of is not None:
        real, imaginary = noise_of.normal(size=(2, *told.shape))
        phasor += real + 1j * imaginary
    phasor *= size
    return field._replace(phasor=phasor.astype(np.complex64), information=told)


def whole_boxes(shape=SHAPE):
    """Every cell of an image as a rectangle (N, 4)."""
    top, left = np.mgrid[: shape[0] : CELL, : shape[1] : CELL].reshape(2, -1)
    return np.stack([top, top + CELL, left, left + CELL], axis=1)


def known(mean, spread):
    """Offsets of surfaces and their deviations, wraps."""
    return Offsets(*np.array([mean, spread], float))


def meeting_planes():
    """Field of two planes that meet at the optical axis, and both, one moved by three wraps."""
    left, q = plane_depth((0.3, 0, 1))
    right, p = plane_depth((-0.3, 0, 1))
    field = exact_field(np.maximum(left, right))
    aside, _ = move_surface(field, p, whole_boxes(), BENT, 3 * WRAP)
    return field, np.stack([q, aside])


# which of the two planes each pixel shows
SIDES = (COLUMNS >= 81) * np.ones(SHAPE, np.int32)
