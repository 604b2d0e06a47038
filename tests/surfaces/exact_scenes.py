"""Scenes in closed form: a furnished corner and single planes, with their exact depth."""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from cmtof.constants import FREQUENCIES
from cmtof.correlation import phase_from_depth, wrap_length
from cmtof.frame import Frame, rays_from_camera
from cmtof.measurement import Measurement
from cmtof.surfaces.field import CELL, field_from_measurement
from cmtof.surfaces.placing import Offsets
from cmtof.surfaces.shapes import BENT, moved

SHAPE = (128, 160)
CAMERA = (140.0, 138.0, 81.0, 62.5)
WRAP = wrap_length(FREQUENCIES[0])

# Normals and distances, m, of two walls and the floor about a camera at the origin; nearest and
# furthest corner, m, of a box on the floor, turned about the vertical; the camera looks down.
_ROOM = (((0.6, 0.0, 0.8), 2.1), ((-0.8, 0.0, 0.6), 2.0), ((0.0, 1.0, 0.0), 2.1))
_BOX = ((0.95, 1.5, 0.75), (1.55, 2.1, 1.45))
_TURN, _PITCH = np.deg2rad(40), np.deg2rad(42)


class Scene(NamedTuple):
    """A frame, and which surface each of its pixels shows."""

    frame: Frame
    part: np.ndarray  # 0 and 1 the walls, 2 the floor, 3 to 5 the box's faces


def unit_rays(shape, camera=CAMERA):
    rays = rays_from_camera(shape, camera)
    return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def corner_scene(shape=SHAPE, camera=CAMERA):
    """Two walls, a floor and a box before them, hit by formula."""
    turned = Rotation.from_euler("x", -_PITCH).apply(
        unit_rays(shape, camera).reshape(-1, 3)
    )
    room = [h / np.maximum(turned @ np.array(n), 1e-9) for n, h in _ROOM]
    room = np.reshape(room, (-1, *shape))
    turned = Rotation.from_euler("y", _TURN).apply(turned).T.reshape(3, 1, *shape)
    sides = np.sort(np.array(_BOX).T[..., None, None] / turned, axis=1)
    enter, leave = sides[:, 0], sides[:, 1]
    hit = (enter.max(axis=0) < leave.min(axis=0)) & (enter.max(axis=0) > 0)
    hit &= enter.max(axis=0) < room.min(axis=0)
    depth = np.where(hit, enter.max(axis=0), room.min(axis=0))
    part = np.where(hit, 3 + enter.argmax(axis=0), room.argmin(axis=0))
    paint = np.array([0.85, 0.65, 0.95, 0.8, 1.0, 0.6])[part]
    rows, columns = np.indices(shape)
    paint *= 0.8 + 0.2 * np.sin(0.31 * columns + 0.17 * rows) * np.cos(0.23 * rows)
    return Scene(Frame(depth, np.clip(paint, 0.3, 1), np.array(camera), "corner"), part)


def plane_depth(normal, z, shape=SHAPE, camera=CAMERA):
    """Range (H, W), m, of the plane through (0, 0, z) with a normal; and its q (6,)."""
    q = np.zeros(6)
    q[:3] = np.asarray(normal, float) / (normal[2] * z)
    return 1 / (unit_rays(shape, camera) @ q[:3]), q


def plane_frame(normal, z, intensity=1.0):
    depth, _ = plane_depth(normal, z)
    return Frame(depth, np.broadcast_to(intensity, SHAPE), np.array(CAMERA), "plane")


def exact_field(depth, *, information=100.0, noise_of=None, camera=CAMERA):
    """Field of known depths in which every pixel and frequency is worth the same information.

    ``noise_of`` is a generator to draw the phasors' own noise from.
    """
    depth = np.asarray(depth, float)
    phase = np.stack([phase_from_depth(depth, f) for f in FREQUENCIES])
    field = field_from_measurement(
        Measurement.from_phase(phase, FREQUENCIES, camera=camera)
    )
    height, width = depth.shape
    k = np.zeros_like(field.information)
    k[:, :height, :width] = information
    p = np.zeros(k.shape, complex)
    p[:, :height, :width] = np.exp(1j * phase)
    p *= np.sqrt(k)  # a / s, where the noise is 1 in each component
    if noise_of is not None:
        drawn = noise_of.normal(size=(2, *k.shape))
        p += drawn[0] + 1j * drawn[1]
    p *= np.sqrt(k)
    return field._replace(
        real=p.real.astype(np.float32),
        imaginary=p.imag.astype(np.float32),
        information=k,
    )


def whole_boxes(shape):
    """Every cell of an image as a rectangle (N, 4)."""
    y, x = (CELL * i.ravel() for i in np.indices((shape[0] // CELL, shape[1] // CELL)))
    return np.stack([y, y + CELL, x, x + CELL], axis=1)


def known(mean, spread):
    """Offsets of surfaces and their deviations, wraps."""
    return Offsets(np.array(mean, float), np.array(spread, float))


def meeting_planes():
    """Field of two planes that meet at the optical axis, and both, one moved by three wraps."""
    left, q = plane_depth((0.3, 0, 1), 2.5)
    right, p = plane_depth((-0.3, 0, 1), 2.5)
    field = exact_field(np.maximum(left, right))
    return field, np.stack([q, moved(field, p, whole_boxes(SHAPE), BENT, 3 * WRAP)[0]])
