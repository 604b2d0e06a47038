"""Objects a metre before the instrument, as Figs. 1 and 14 to 16 show them; all of them our own.

Meshes lie in the instrument's axes (m; x right, y down, z forward); vertices carry ``reflectance``
at 532 nm and ``mirrored``, the weight of a specular law against a diffuse one, both 0 to 1.
Triangles of side L lie up to ``L^2 / (8 R)``, 2 um, off a body of radius R.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator
from trimesh import Trimesh
from trimesh.creation import box, cylinder, icosphere, torus
from trimesh.util import concatenate

from cmtof.validation import expect

Array = NDArray[np.float64]
Law = Callable[[Array, Array, Array], Any] | None  # of the place x, y, z

STEEL = 0.58  # reflectance of polished or lapped steel (known: 0.55 to 0.6)
DISTANCE = 1.0  # from the instrument to the middle of an object, m
WIDTH, HEIGHT = 9e-3, 30e-3  # face of a gauge block up to 10 mm long, m (known)
GRADE_2 = 0.45e-6  # greatest error of such a length, m (DIN 861, grade 2, by makers' tables)
MIRRORED = 0.7  # specular weight of a block (assumed): lapping leaves a matt sheen
FIELD_OF_VIEW = {"bust": 0.36, "helmet": 0.34, "owl": 0.34, "table": 0.44}  # full angle, rad


@lru_cache(maxsize=4)
def object_mesh(name: str) -> Trimesh:
    """Mesh of one of `OBJECTS` about 1 m before the instrument, on a table before a wall."""
    expect(name in OBJECTS, f"an object out of {', '.join(OBJECTS)}", repr(name), "Choose one.")
    pieces, middle, pitch = OBJECTS[name]
    board = _piece(_box((1.2, 0.9, 0.01)), 0.4, at=(0, -0.15, -0.01))
    wall = _piece(_box((1.2, 0.01, 1.3)), 0.55, at=(0, 0.305, -0.1))
    mesh: Any = concatenate([*pieces(), board, wall])
    cos, sin = np.cos(pitch), np.sin(pitch)
    axes = np.array([(1, 0, 0), (0, -sin, -cos), (0, cos, -sin)])  # right, down, forward
    mesh.vertices = (mesh.vertices - [0, 0, middle]) @ axes.T + [0, 0, DISTANCE]
    return mesh


def gage_blocks(step: float, distance: float, *, tilt: float, errors: Sequence[float]) -> Trimesh:
    """Measuring faces of two gauge blocks, wrung on a mount side by side (Fig. 14).

    The left face meets the axis at ``distance``, m; the right one stands nearer by ``step``. Both
    lengths are off by ``errors``, and ``tilt``, rad, keeps the mirror image off the instrument.
    """
    corners = []
    for side, length in ((-1, errors[0]), (1, step + errors[1])):
        x = np.array([0.0, side, side, 0.0]) * WIDTH
        y = np.array([-1.0, -1.0, 1.0, 1.0]) * HEIGHT / 2
        # the step is the distance of the two parallel faces, along their normal
        corners.append(np.stack([x, y, distance + np.tan(tilt) * x - length / np.cos(tilt)], -1))
    faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]
    return _piece(Trimesh(np.concatenate(corners), faces, process=False), STEEL, MIRRORED)


def _piece(
    shape: Trimesh, bright: Any, mirrored: float = 0, at: ArrayLike = (0, 0, 0), turn: float = 0
) -> Trimesh:
    """A shape on z = 0, front towards -y, of a material (number or law), turned and moved."""
    points = np.asarray(shape.vertices)
    cos, sin = np.cos(turn), np.sin(turn)
    moved = points @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]]) + np.asarray(at, float)
    seen = np.full(len(points), bright(*points.T) if callable(bright) else bright, float)
    held = {"reflectance": seen, "mirrored": np.full(len(points), mirrored, float)}
    return Trimesh(moved, shape.faces, process=False, vertex_attributes=held)


def _body(
    sections: ArrayLike, relief: Law = None, holes: Law = None, grid: tuple[int, int] = (240, 400)
) -> Trimesh:
    """A smooth upright body by sections: height, half breadth and, unless round, front and back."""
    path = np.asarray(sections, float)
    path = path[:, [0, 1, 2, 3] if path.shape[1] == 4 else [0, 1, 1, 1]]
    along = np.concatenate([[0], np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1).cumsum()])
    rows = PchipInterpolator(along, path)(np.linspace(0, along[-1], grid[0]))
    turn = np.linspace(-np.pi, np.pi, grid[1], endpoint=False)  # 0 is the front
    z, side, front, back = np.repeat(rows.T[..., None], grid[1], axis=2)
    x, y = side * np.sin(turn), np.where(np.cos(turn) > 0, -front, -back) * np.cos(turn)
    if relief is not None:
        grow = 1 + relief(x, y, z) / np.maximum(np.hypot(x, y), 0.01)
        x, y = x * grow, y * grow
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    ring = np.pad(np.arange(x.size).reshape(x.shape), ((0, 0), (0, 1)), "wrap")  # closed behind
    a, b, c, d = (q.ravel() for q in (ring[:-1, :-1], ring[:-1, 1:], ring[1:, 1:], ring[1:, :-1]))
    kept = ... if holes is None else ~holes(*points[np.stack([a, b, c, d])].mean(0).T)
    faces = np.concatenate([np.stack(t, -1)[kept] for t in ((a, b, c), (a, c, d))])
    return Trimesh(points, faces, process=False)


def _ellipsoid(size: ArrayLike, relief: Law = None) -> Trimesh:
    """An ellipsoid about the origin with half axes x, y, z, m."""
    a, (x, y, z) = np.linspace(-np.pi / 2, np.pi / 2, 81), np.asarray(size, float)
    return _body(np.stack([z * np.sin(a), *(np.cos(a) * half for half in (x, y, y))], -1), relief)


def _box(size: ArrayLike) -> Trimesh:
    return box(size).apply_translation([0, 0, np.asarray(size, float)[2] / 2])


def _bump(*offsets: tuple[Array, float]) -> Array:
    """A Gaussian bump: exp of minus the sum of (offset / width)^2."""
    return np.exp(-sum((off / width) ** 2 for off, width in offsets))


def _mix(dark: Array | float, pale: float, share: ArrayLike) -> Array:
    return dark + (pale - dark) * np.clip(share, 0, 1)


def _bust() -> list[Trimesh]:
    """Plaster (0.8 to 0.9 when clean): a head on its shoulders, on a turned socle."""
    sections = [
        (0.0, 0.048, 0.048, 0.048), (0.012, 0.048, 0.048, 0.048), (0.018, 0.036, 0.036, 0.036),
        (0.038, 0.026, 0.026, 0.026), (0.052, 0.036, 0.036, 0.036), (0.058, 0.04, 0.036, 0.036),
        (0.066, 0.07, 0.045, 0.04), (0.085, 0.1, 0.058, 0.05), (0.108, 0.102, 0.054, 0.05),
        (0.128, 0.075, 0.042, 0.044), (0.14, 0.043, 0.034, 0.042), (0.155, 0.035, 0.03, 0.042),
        (0.168, 0.036, 0.036, 0.044), (0.174, 0.04, 0.05, 0.048), (0.188, 0.046, 0.057, 0.056),
        (0.21, 0.051, 0.06, 0.066), (0.235, 0.054, 0.062, 0.073), (0.26, 0.053, 0.058, 0.072),
        (0.278, 0.043, 0.045, 0.06), (0.289, 0.026, 0.027, 0.038), (0.293, 0.0, 0.0, 0.0),
    ]  # fmt: skip

    def relief(x: Array, y: Array, z: Array) -> Array:
        apart, face = np.abs(x), y < 0
        nose = np.clip((0.234 - z) / 0.03, 0, 1) / (1 + np.exp((0.2 - z) / 0.0015))
        out = 0.019 * nose * _bump((x, 0.0075))
        out += 0.004 * _bump((apart - 0.01, 0.005), (z - 0.203, 0.004))  # nostrils
        out -= 0.008 * _bump((apart - 0.021, 0.01), (z - 0.225, 0.007))  # sockets, eyes, brows
        out += 0.0055 * _bump((apart - 0.021, 0.008), (z - 0.2235, 0.0042))
        out += 0.004 * _bump((apart - 0.02, 0.016), (z - 0.2365, 0.004))
        for height, depth in ((0.1905, 0.003), (0.187, -0.003), (0.1835, 0.003)):
            out += depth * _bump((x, 0.015), (z - height, 0.0022))
        out += 0.006 * _bump((x, 0.014), (z - 0.172, 0.006))
        ears = 0.014 * _bump((y - 0.008, 0.011), (z - 0.213, 0.017)) * (apart > 0.03)
        locks = np.sin(9 * np.arctan2(x, -y) + 250 * z) + np.sin(5 * np.arctan2(x, -y) - 420 * z)
        line = z - 0.25 + 0.9 * np.clip(y + 0.02, 0, 0.06)
        hair = np.clip(line / 0.006, 0, 1) * np.clip((z - 0.18) / 0.02, 0, 1)
        return out * face + ears + hair * (0.004 + 0.0014 * locks) * (z > 0.15)

    return [_piece(_body(sections, relief, grid=(800, 600)), 0.8, turn=0.35)]


def _helmet() -> list[Trimesh]:
    """Polished steel, open behind, with slits and holes that show the wall."""
    height = 0.28
    sections = [
        (0.0, 0.104, 0.128, 0.112), (0.014, 0.097, 0.118, 0.105), (0.042, 0.092, 0.113, 0.1),
        (0.084, 0.096, 0.118, 0.106), (0.14, 0.101, 0.122, 0.112), (0.174, 0.102, 0.12, 0.113),
        (0.21, 0.094, 0.108, 0.104), (0.244, 0.071, 0.08, 0.08), (0.266, 0.043, 0.05, 0.05),
        (0.277, 0.019, 0.022, 0.022), (0.28, 0.0, 0.0, 0.0),
    ]  # fmt: skip

    def relief(x: Array, y: Array, z: Array) -> Array:
        face = np.clip(-30 * y, 0, 1)
        comb = 0.007 * _bump((x, 0.006)) * np.clip((z / height - 0.66) / 0.08, 0, 1)
        brow = 0.004 * _bump((z - 0.193 + 0.9 * x**2, 0.006)) * face
        keel = 0.012 * np.exp(-np.abs(x) / 0.012) * face * np.sqrt(np.clip(1 - z / 0.185, 0, 1))
        return comb + brow + keel + 0.003 * _bump((z - 0.006, 0.004))

    def holes(x: Array, y: Array, z: Array) -> NDArray[np.bool_]:
        u, slits = np.abs(x) - 0.02, np.zeros(x.shape, bool)
        for k in range(4):
            slits |= ((u - 0.015 * k) / 0.0042) ** 2 + ((z - 0.095) / (0.03 - 0.003 * k)) ** 4 < 1
        eyes = ((u - 0.022) / 0.028) ** 4 + ((z - 0.171 - 0.12 * (u - 0.022)) / 0.0085) ** 2 < 1
        breaths = (np.hypot(u - 0.01, z - 0.04) < 0.0055) | (np.hypot(u - 0.03, z - 0.042) < 0.0055)
        return ((eyes | slits | breaths) & (y < -0.01)) | ((y > 0.02) & (z < 0.78 * height))

    shell = _piece(_body(sections, relief, holes, grid=(440, 720)), STEEL, 0.97, at=(0, 0, 0.02))
    return [shell, _piece(_box((0.26, 0.3, 0.02)), 0.18, 0.03)]


def _owl() -> list[Trimesh]:
    """Plumage from nearly black (0.03) to white (0.8), relief and all; eyes, a beak, a branch."""
    dark, pale = 0.03, 0.8

    def feathers(x: Array, y: Array, z: Array) -> tuple[Array, Array]:
        """How near a point is to the tip of a feather, 0 to 1, and a fixed number of each."""
        level = np.floor(z / 0.0135)
        across = np.arctan2(x, -y) * 24 / (2 * np.pi) + 0.5 * (level % 2)
        column = np.floor(across)
        s, t = across - column - 0.5, z / 0.0135 - level  # t is 0 at the tip
        inside = np.clip(1 - (2 * s) ** 2, 0, 1)
        tip = inside * np.cos(np.pi / 2 * t) ** 1.5 * np.clip(6 * t, 0, 1)
        return tip, np.mod(np.sin(12.9898 * level + 78.233 * column) * 43758.5453, 1.0)

    def relief(x: Array, y: Array, z: Array) -> Array:
        return 7e-4 * feathers(x, y, z)[0]

    def breast(x: Array, y: Array, z: Array) -> Array:
        tip, which = feathers(x, y, z)
        base = _mix(0.12, pale, np.clip(0.5 - y / 0.04, 0, 1) * (0.8 + 0.4 * tip))
        return _mix(base, dark, 6 * (tip - 0.5) * (which < 0.6))

    def wing(x: Array, y: Array, z: Array) -> Array:
        tip, which = feathers(x, y, z)
        return _mix(_mix(0.04, 0.16, which), pale, 6 * (tip - 0.5) * (which < 0.6))

    def face(x: Array, y: Array, z: Array) -> Array:
        """Two pale discs with rings and a dark rim under a brown crown."""
        far = np.hypot(np.abs(x) - 0.03, z)
        disc = _mix(0.45, pale, 0.5 + 0.5 * np.cos(2 * np.pi * far / 0.0075))
        seen = np.where((far < 0.036) & (y < 0), disc, wing(x, y, z))
        return seen + (dark - seen) * _bump((far - 0.036, 0.0035)) * (y < 0)

    def iris(x: Array, y: Array, z: Array) -> Array:
        far = np.hypot(x, z)
        return np.select([far < 0.0072, far < 0.0145], [dark, 0.5], 0.05)

    pieces = [
        _piece(_ellipsoid((0.08, 0.068, 0.105), relief), breast, at=(0, 0, 0.125)),
        _piece(_ellipsoid((0.073, 0.059, 0.058), relief), face, at=(0, -0.004, 0.232)),
        _piece(_ellipsoid((0.008, 0.015, 0.017)), 0.06, 0.05, at=(0, -0.064, 0.214)),
    ]
    for side in (-1, 1):
        pieces += [
            _piece(_ellipsoid((0.023, 0.057, 0.085), relief), wing, at=(0.072 * side, 0.006, 0.13)),
            _piece(_ellipsoid((0.015, 0.023, 0.01)), 0.35, 0.02, at=(0.028 * side, -0.045, 0.022)),
            _piece(icosphere(6, 0.0165), iris, 0.04, at=(0.031 * side, -0.046, 0.236)),
        ]
    branch = cylinder(0.012, sections=240, segment=[(-0.5, 0, 0), (0.5, 0, 0)])
    return [*pieces, _piece(branch, 0.15, at=(0, -0.02, 0.012))]


def _table() -> list[Trimesh]:
    """Things of many materials, half hidden by each other; reflectances are assumed."""
    mug = [(0, 0), (0, 0.036), (0.004, 0.04), (0.09, 0.041), (0.095, 0.039), (0.09, 0.037),
           (0.02, 0.036), (0.008, 0.03), (0.008, 0)]  # fmt: skip
    bottle = np.array([(0, 0), (0, 0.9), (0.02, 0.99), (0.06, 1), (0.5, 1), (0.58, 0.99),
                       (0.69, 0.8), (0.79, 0.42), (0.86, 0.36), (1, 0.36), (1, 0)])  # fmt: skip
    apple = [(0.01, 0), (0, 0.012), (0.01, 0.027), (0.03, 0.036), (0.05, 0.03), (0.058, 0.014),
             (0.052, 0.004), (0.048, 0)]  # fmt: skip
    pot = [(0, 0), (0, 0.026), (0.045, 0.034), (0.047, 0.036), (0.05, 0.034), (0.044, 0)]
    cactus = [(0.04, 0.016), (0.06, 0.028), (0.09, 0.031), (0.115, 0.022), (0.125, 0)]

    def label(x: Array, y: Array, z: Array) -> Array:
        turn = np.arctan2(x, -y)
        printed = np.sin(z / 0.0028) * np.sin(40 * turn) > 0.5
        paper = (np.abs(turn) < 1.9) & (np.abs(z - 0.073) < 0.035)
        return np.where(z > 0.2, 0.35, np.where(paper, np.where(printed, 0.06, 0.75), 0.12))

    def banded(x: Array, y: Array, z: Array) -> Array:
        return np.where(abs(z - 0.057) < 0.012, 0.08, 0.7)

    def ribs(x: Array, y: Array, z: Array) -> Array:
        return 0.003 * np.cos(14 * np.arctan2(x, -y))

    def stripes(x: Array, y: Array, z: Array) -> Array:
        return _mix(0.1, 0.65, np.floor((0.8 * x + 0.2 * y + 0.56 * z) / 0.0125) % 2)

    upright = [[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]]
    handle = torus(0.024, 0.0052, 160, 96, upright)
    return [
        _piece(_body(mug), banded, 0.05, at=(0, -0.13, 0)),
        _piece(handle, 0.7, 0.05, at=(0.04, -0.145, 0.05)),
        _piece(_body(bottle * [0.235, 0.036], grid=(600, 600)), label, 0.2, at=(0.055, 0.05, 0)),
        _piece(icosphere(6, 0.034), stripes, 0.02, at=(0.14, -0.07, 0.034)),
        _piece(_box((0.11, 0.09, 0.085)), 0.4, at=(-0.14, 0.11, 0), turn=0.35),
        _piece(_box((0.06, 0.07, 0.03)), 0.05, 0.1, at=(-0.145, 0.105, 0.085), turn=-0.25),
        _piece(_body(apple), 0.22, 0.06, at=(0.085, -0.17, 0)),
        _piece(_box((0.15, 0.11, 0.022)), 0.3, at=(-0.13, -0.05, 0), turn=0.2),
        _piece(_box((0.14, 0.1, 0.015)), 0.62, at=(-0.132, -0.048, 0.022), turn=-0.1),
        _piece(_box((0.12, 0.085, 0.028)), 0.1, 0.1, at=(-0.128, -0.052, 0.037), turn=0.45),
        _piece(_body(pot), 0.5, at=(0.15, 0.11, 0)),
        _piece(_body(cactus, ribs), 0.15, at=(0.15, 0.11, 0)),
    ]


# pieces, height of the point that the axis meets, m, and angle down, rad
OBJECTS: dict[str, tuple[Callable[[], list[Trimesh]], float, float]] = {
    "bust": (_bust, 0.145, 0.1),
    "helmet": (_helmet, 0.155, 0.08),
    "owl": (_owl, 0.15, 0.08),
    "table": (_table, 0.075, 0.38),
}
