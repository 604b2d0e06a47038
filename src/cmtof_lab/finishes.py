"""Reliefs, holes and reflectances of the objects, as functions of the place on them.

Each takes coordinates x, y, z, m, of the body itself: it stands on z = 0 with its front to -y.
Reliefs return how far the skin stands out, m, holes where it is open, looks the reflectance.
"""

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from cmtof.correlation import TAU
from cmtof.files import read_document
from cmtof.types import Array, Flags

CATALOGUE = read_document(Path(__file__).with_name("objects.yml"))  # of all objects
DARK = 0.03  # reflectance of the owl's black feathers
PALE = 0.8  # and of its white ones
FEATHER = 0.0135  # m from one row of feathers to the next


def bump(*offsets: tuple[Array, float]) -> Array:
    """A Gaussian bump: exp of minus the sum of (offset / width)^2."""
    return np.exp(-sum((off / width) ** 2 for off, width in offsets))


def mix(dark: ArrayLike, pale: float, share: ArrayLike) -> Array:
    """Reflectance between two others, by the share of the second, clipped to 0 and 1."""
    return dark + (pale - dark) * np.clip(share, 0, 1)


def portrait(x: Array, y: Array, z: Array) -> Array:
    """Relief of the bust: a face, ears and hair."""
    return features_of_a_face(x, z) * (y < 0) + ear(x, y, z) + curls(x, y, z)


def features_of_a_face(x: Array, z: Array) -> Array:
    """Nose, nostrils, sockets, eyes, brows, lips and chin."""
    apart = np.abs(x)
    nose = np.clip((0.234 - z) / 0.03, 0, 1)
    nose = nose / (1 + np.exp((0.2 - z) / 0.0015))
    out = 0.019 * nose * bump((x, 0.0075))
    for depth, aside, breadth, height, tall in CATALOGUE["face"]:
        out += depth * bump((apart - aside, breadth), (z - height, tall))
    return out


def ear(x: Array, y: Array, z: Array) -> Array:
    """An ear on either side of the head."""
    return 0.014 * bump((y - 0.008, 0.011), (z - 0.213, 0.017)) * (np.abs(x) > 0.03)


def curls(x: Array, y: Array, z: Array) -> Array:
    """Hair above a line that falls towards the neck."""
    turn = np.arctan2(x, -y)
    locks = np.sin(9 * turn + 250 * z) + np.sin(5 * turn - 420 * z)
    line = z - 0.25 + 0.9 * np.clip(y + 0.02, 0, 0.06)
    hair = np.clip(line / 0.006, 0, 1) * np.clip((z - 0.18) / 0.02, 0, 1)
    return hair * (0.004 + 0.0014 * locks) * (z > 0.15)


HELMET_HEIGHT = 0.28  # m


def visor(x: Array, y: Array, z: Array) -> Array:
    """Relief of the helmet: comb, brow, keel and rim."""
    front = np.clip(-30 * y, 0, 1)
    rise = np.clip((z / HELMET_HEIGHT - 0.66) / 0.08, 0, 1)
    comb = 0.007 * bump((x, 0.006)) * rise
    brow = 0.004 * bump((z - 0.193 + 0.9 * x**2, 0.006)) * front
    fall = np.sqrt(np.clip(1 - z / 0.185, 0, 1))
    keel = 0.012 * np.exp(-np.abs(x) / 0.012) * front * fall
    return comb + brow + keel + 0.003 * bump((z - 0.006, 0.004))


def openings(x: Array, y: Array, z: Array) -> Flags:
    """Slits, eyes and breathing holes of the helmet, which is open behind."""
    u = np.abs(x) - 0.02
    slits = np.zeros(x.shape, bool)
    for k in range(4):
        across = (u - 0.015 * k) / 0.0042
        along = (z - 0.095) / (0.03 - 0.003 * k)
        slits |= across**2 + along**4 < 1
    slope = z - 0.171 - 0.12 * (u - 0.022)
    eyes = ((u - 0.022) / 0.028) ** 4 + (slope / 0.0085) ** 2 < 1
    for aside, height in ((0.01, 0.04), (0.03, 0.042)):
        slits |= np.hypot(u - aside, z - height) < 0.0055
    front = (eyes | slits) & (y < -0.01)
    return front | ((y > 0.02) & (z < 0.78 * HELMET_HEIGHT))


def feathers(x: Array, y: Array, z: Array) -> tuple[Array, Array, Array]:
    """How near to the tip of a feather, 0 to 1, a fixed number of each, and its mark's share."""
    level = np.floor(z / FEATHER)
    across = np.arctan2(x, -y) * 24 / TAU + 0.5 * (level % 2)
    column = np.floor(across)
    s = across - column - 0.5
    t = z / FEATHER - level  # 0 at the tip
    inside = np.clip(1 - (2 * s) ** 2, 0, 1)
    tip = inside * np.cos(np.pi / 2 * t) ** 1.5 * np.clip(6 * t, 0, 1)
    number = np.sin(12.9898 * level + 78.233 * column) * 43758.5453
    which = np.mod(number, 1.0)
    return tip, which, 6 * (tip - 0.5) * (which < 0.6)


def plumage(x: Array, y: Array, z: Array) -> Array:
    """Relief of feathers."""
    return 7e-4 * feathers(x, y, z)[0]


def breast(x: Array, y: Array, z: Array) -> Array:
    """Pale in front, with dark tips."""
    tip, _, mark = feathers(x, y, z)
    base = mix(0.12, PALE, np.clip(0.5 - y / 0.04, 0, 1) * (0.8 + 0.4 * tip))
    return mix(base, DARK, mark)


def wing(x: Array, y: Array, z: Array) -> Array:
    """Brown with pale tips."""
    _, which, mark = feathers(x, y, z)
    return mix(mix(0.04, 0.16, which), PALE, mark)


def owl_face(x: Array, y: Array, z: Array) -> Array:
    """Two pale discs with rings and a dark rim under a brown crown."""
    far = np.hypot(np.abs(x) - 0.03, z)
    disc = mix(0.45, PALE, 0.5 + 0.5 * np.cos(TAU * far / 0.0075))
    seen = np.where((far < 0.036) & (y < 0), disc, wing(x, y, z))
    return seen + (DARK - seen) * bump((far - 0.036, 0.0035)) * (y < 0)


def iris(x: Array, y: Array, z: Array) -> Array:
    """Pupil and iris of the owl's eye."""
    far = np.hypot(x, z)
    return np.select([far < 0.0072, far < 0.0145], [DARK, 0.5], 0.05)


def label(x: Array, y: Array, z: Array) -> Array:
    """Glass with a printed label and a cork."""
    turn = np.arctan2(x, -y)
    printed = np.sin(z / 0.0028) * np.sin(40 * turn) > 0.5
    paper = (np.abs(turn) < 1.9) & (np.abs(z - 0.073) < 0.035)
    glass = np.where(paper, np.where(printed, 0.06, 0.75), 0.12)
    return np.where(z > 0.2, 0.35, glass)


def banded(x: Array, y: Array, z: Array) -> Array:
    """White with a dark band."""
    return np.where(abs(z - 0.057) < 0.012, 0.08, 0.7)


def ribs(x: Array, y: Array, z: Array) -> Array:
    """Fourteen ribs of a cactus."""
    return 0.003 * np.cos(14 * np.arctan2(x, -y))


def stripes(x: Array, y: Array, z: Array) -> Array:
    """Stripes that run askew."""
    return mix(0.1, 0.65, np.floor((0.8 * x + 0.2 * y + 0.56 * z) / 0.0125) % 2)


def lumps(x: Array, y: Array, z: Array) -> Array:
    """Dents and creases of leather and leaves."""
    return 0.0015 * np.sin(90 * x + 60 * z) + 0.001 * np.sin(140 * z - 70 * y)


def folds(x: Array, y: Array, z: Array) -> Array:
    """Folds of a cloth that hangs, wider below."""
    wide = 70 + 60 * z
    return 0.012 * np.sin(wide * x) + 0.004 * np.sin(2.3 * wide * x + 12 * z)


def plush(x: Array, y: Array, z: Array) -> Array:
    """Tufts of a plush toy."""
    return 0.0012 * np.sin(300 * x + 100 * z) * np.sin(310 * z - 90 * x)
