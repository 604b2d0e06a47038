"""Reliefs, holes and reflectances of the objects, as functions of the place on them.

Each takes coordinates x, y, z, m, of the body itself: it stands on z = 0 with its front to -y.
Reliefs return how far the skin stands out, m, holes where it is open, looks the reflectance.
"""

from pathlib import Path
from typing import Any

from numpy import (
    abs,
    arctan2,
    clip,
    cos,
    exp,
    floor,
    hypot,
    multiply,
    pi,
    sin,
    sqrt,
    where,
)
from numpy.typing import ArrayLike

from cmtof.correlation import TAU
from cmtof.files import read_document
from cmtof.types import Array, Flags

# All objects, and the tables of their finishes.
CATALOGUE = read_document(Path(__file__).with_name("objects.yml"))
# Reflectance of the owl's black feathers.
DARK = 0.03
# Reflectance of its white ones.
PALE = 0.8
# From one row of feathers to the next, m.
FEATHER = 0.0135


def by_name(table: str, stated: Any) -> Any:
    """Entry of a catalogue's table by its name; anything else is returned as it is."""
    return CATALOGUE[table].get(stated, stated) if isinstance(stated, str) else stated


def bump(off: Array, width: float) -> Array:
    """Gaussian bump of height 1: ``exp(-(off / width)^2)`` at offsets from its middle."""
    return exp(-((off / width) ** 2))


def mix(dark: ArrayLike, pale: float, share: ArrayLike) -> Array:
    """Reflectance between two others, by the share of the second, clipped to 0 and 1."""
    return dark + (pale - dark) * clip(share, 0, 1)  # pyright: ignore[reportOperatorIssue, reportReturnType]


def relief(stated: Any, x: Array, y: Array, z: Array) -> Array:
    """Relief, m, at x, y, z by a list of waves, its catalogue name, or a function's name."""
    waves = by_name("waves", stated)
    if isinstance(waves, str):
        return globals()[waves](x, y, z)
    turn = arctan2(x, -y)
    out = 0 * x
    for height, *along, around, phase in waves:
        turned = map(multiply, [around, *along], [turn, x, y, z])
        out += height * sin(sum(turned, phase))
    return out


def portrait(x: Array, y: Array, z: Array) -> Array:
    """Relief of the bust: a face, ears and hair."""
    out = curls(x, y, z)
    out += (y < 0) * features_of_a_face(x, z)
    ear = bump(y - 0.008, 0.011)
    ear *= bump(z - 0.213, 0.017)
    ear *= abs(x) > 0.03
    return out + 0.014 * ear


def features_of_a_face(x: Array, z: Array) -> Array:
    """Relief, m, of nose, nostrils, sockets, eyes, brows, lips and chin."""
    apart = abs(x)
    out = 0.019 * bump(x, 0.0075)
    out *= clip(7.8 - z / 0.03, 0, 1)
    out /= 1 + exp((0.2 - z) / 0.0015)
    for depth, aside, breadth, height, tall in CATALOGUE["face"]:
        rise = depth * bump(apart - aside, breadth)
        out += rise * bump(z - height, tall)
    return out


def curls(x: Array, y: Array, z: Array) -> Array:
    """Relief, m, of hair above a line that falls towards the neck."""
    line = z - 0.25 + 0.9 * clip(y + 0.02, 0, 0.06)
    above = clip(line / 0.006, 0, 1)
    above *= clip((z - 0.18) / 0.02, 0, 1)
    above *= z > 0.15
    return above * (0.004 + relief("curls", x, y, z))


def visor(x: Array, y: Array, z: Array) -> Array:
    """Relief of the helmet: comb, brow, keel and rim."""
    out = 0.003 * bump(z - 0.006, 0.004)
    out += 0.007 * clip(z / 0.0224 - 8.25, 0, 1) * bump(x, 0.006)
    front = clip(-30 * y, 0, 1)
    bow = 0.193 - 0.9 * x**2
    out += 0.004 * front * bump(z - bow, 0.006)
    fall = clip(1 - z / 0.185, 0, 1)
    keel = exp(-abs(x) / 0.012)
    keel *= sqrt(fall)
    return out + 0.012 * front * keel


def openings(table: Any, x: Array, y: Array, z: Array) -> Flags:
    """Whether the helmet is open at x, y, z: behind, and at a table's openings in front."""
    opened = (y > 0.02) & (z < 0.2184)
    for aside, height, breadth, tall, flat, steep, slope in table:
        across = abs(x) - aside
        along = z - height - slope * across
        far = abs(across / breadth) ** flat
        far += abs(along / tall) ** steep
        opened |= (y < -0.01) & (far < 1)
    return opened


def feathers(x: Array, y: Array, z: Array) -> tuple[Array, Array, Array]:
    """Nearness to a feather's tip and its random number, both 0 to 1; share of its mark."""
    height = z / FEATHER
    level = floor(height)
    across = arctan2(x, -y) * 24 / TAU
    across += level % 2 / 2
    column = floor(across)
    aside = 2 * (across - column) - 1
    # 0 at the tip
    above = height - level
    tip = clip(1 - aside**2, 0, 1)
    tip *= cos(pi / 2 * above) ** 1.5
    tip *= clip(6 * above, 0, 1)
    number = sin(12.9898 * level + 78.233 * column)
    which = number * 43758.5453 % 1
    return tip, which, 6 * (which < 0.6) * (tip - 0.5)


def plumage(x: Array, y: Array, z: Array) -> Array:
    """Relief of feathers."""
    tip, *_ = feathers(x, y, z)
    return 7e-4 * tip


def breast(x: Array, y: Array, z: Array) -> Array:
    """Reflectance of the owl's body: pale in front, with dark tips."""
    tip, _, mark = feathers(x, y, z)
    share = clip(0.5 - y / 0.04, 0, 1)
    share *= 0.8 + 0.4 * tip
    return mix(mix(0.12, PALE, share), DARK, mark)


def wing(x: Array, y: Array, z: Array) -> Array:
    """Reflectance of the owl's wings: dark with pale tips."""
    _, which, mark = feathers(x, y, z)
    return mix(mix(0.04, 0.16, which), PALE, mark)


def owl_face(x: Array, y: Array, z: Array) -> Array:
    """Reflectance of the owl's head: two pale, ringed, dark-rimmed discs, otherwise as `wing`."""
    front = y < 0
    far = hypot(abs(x) - 0.03, z)
    rings = cos(TAU / 0.0075 * far)
    disc = mix(0.45, PALE, 0.5 + 0.5 * rings)
    seen = where(front & (far < 0.036), disc, wing(x, y, z))
    rim = front * bump(far - 0.036, 0.0035)
    return mix(seen, DARK, rim)


def iris(x: Array, y: Array, z: Array) -> Array:
    """Reflectance of the owl's eye: dark pupil, bright iris, dark around."""
    far = hypot(x, z)
    coloured = where(far < 0.0145, 0.5, 0.05)
    return where(far < 0.0072, DARK, coloured)


def label(x: Array, y: Array, z: Array) -> Array:
    """Reflectance of a bottle: glass with a printed label and a cork."""
    turn = arctan2(x, -y)
    letters = sin(40 * turn)
    letters *= sin(z / 0.0028)
    paper = where(letters > 0.5, 0.06, 0.75)
    pasted = (abs(turn) < 1.9) & (abs(z - 0.073) < 0.035)
    glass = where(pasted, paper, 0.12)
    return where(z > 0.2, 0.35, glass)


def banded(x: Array, y: Array, z: Array) -> Array:
    """Reflectance: white with a dark band 24 mm high about z = 57 mm."""
    return where(abs(z - 0.057) < 0.012, 0.08, 0.7)


def stripes(x: Array, y: Array, z: Array) -> Array:
    """Reflectance: dark and bright stripes that run askew."""
    along = 64 * x + 16 * y + 44.8 * z
    return mix(0.1, 0.65, floor(along) % 2)


def folds(x: Array, y: Array, z: Array) -> Array:
    """Relief, m, of a cloth that hangs: folds, wider below."""
    wide = x * (70 + 60 * z)
    return 0.012 * sin(wide) + 0.004 * sin(2.3 * wide + 12 * z)
