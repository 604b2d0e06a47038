"""Patterns of a surface, evaluated in its own space: mix of two colours and a tint.

Every pattern is a function of position alone, so marks ignore edges. Coordinates are in repeats:
(x, y, z) has x along the grain, and (u, v) is the face's plane, u along the grain where it can be.
Compiled, because each pixel asks once. Numba keeps the compiled `shading` although something here
changed: touch that file too.
"""

import math

from numba import njit

from cmtof.scenes.rooms.materials import PATTERNS

_PLAIN, _WOOD, _PLANKS, _HERRINGBONE, _TILES, _BRICKS, _STRIPES, _CHECKS = range(8)
_NOISE, _WEAVE, _MARBLE, _TERRAZZO, _MARKS, _PICTURE, _RUG, _LEAF, _DOTS = range(8, len(PATTERNS))


@njit(cache=True, error_model="numpy")
def lattice(i, j, k):  # pragma: no cover - compiled
    """Random number in [0, 1) of a lattice point: integers mixed until no bit is predictable."""
    h = (i * 374761393 + j * 668265263 + k * 2147483647 + 1274126177) & 0xFFFFFFFF
    h = ((h ^ (h >> 15)) * 2246822519) & 0xFFFFFFFF
    h = ((h ^ (h >> 13)) * 3266489917) & 0xFFFFFFFF
    return ((h ^ (h >> 16)) & 0xFFFFFF) / 16777216.0


@njit(cache=True, error_model="numpy")
def value_noise(x, y, z):  # pragma: no cover - compiled
    """Smooth noise between the lattice's random values, 0 to 1, one bump a unit."""
    i, j, k = math.floor(x), math.floor(y), math.floor(z)
    a, b, c = x - i, y - j, z - k
    a, b, c = a * a * (3 - 2 * a), b * b * (3 - 2 * b), c * c * (3 - 2 * c)
    total = 0.0
    for di in range(2):
        wi = a if di else 1 - a
        for dj in range(2):
            wj = b if dj else 1 - b
            near = lattice(int(i) + di, int(j) + dj, int(k))
            far = lattice(int(i) + di, int(j) + dj, int(k) + 1)
            total += wi * wj * (near + c * (far - near))
    return total


@njit(cache=True, error_model="numpy")
def turbulence(x, y, z):  # pragma: no cover - compiled
    """Three octaves of noise, 0 to 1."""
    return (
        4 * value_noise(x, y, z)
        + 2 * value_noise(2 * x + 5, 2 * y, 2 * z)
        + value_noise(4 * x, 4 * y + 7, 4 * z)
    ) / 7


@njit(cache=True, error_model="numpy")
def _grain(x, y, z):  # pragma: no cover - compiled
    """Year rings about a far-off heart, stretched along x."""
    wobble = 2.2 * value_noise(0.06 * x, 0.5 * y, 0.5 * z)
    ring = math.hypot(y + 9.3, z + 4.1) + wobble
    saw = ring - math.floor(ring)
    late = saw * saw if saw < 0.86 else (1 - saw) / 0.14 * 0.74
    return min(1.0, 0.75 * late + 0.35 * value_noise(0.9 * x, 12 * y, 12 * z))


@njit(cache=True, error_model="numpy")
def _joint(u, v, width, height, gap):  # pragma: no cover - compiled
    """Distance into a cell's joint: 0 inside the joint, 1 on the cell."""
    edge = min(min(u, 1 - u) * width, min(v, 1 - v) * height)
    return min(1.0, max(0.0, edge / gap))


@njit(cache=True, error_model="numpy")
def _planks(u, v, herringbone):  # pragma: no cover - compiled
    """Boards 1 wide and 8 long, staggered, or blocks of 1 by 4 in herringbone."""
    if not herringbone:
        row = math.floor(v)
        along = u / 8 + lattice(int(row), 3, 1)
        board, across = math.floor(along), v - row
        f, length = along - board, 8.0
        number, other = int(board), int(row)
    else:
        i, j = math.floor(u), math.floor(v)
        m = (i + j) % 8
        if m < 4:  # lies along u
            number, other = int(i - m), int(j)
            f, across, length = (u - (i - m)) / 4, v - j, 4.0
        else:  # stands along v
            m = (j + i) % 8 - 4
            number, other = int(i), int(j - m)
            f, across, length = (v - (j - m)) / 4, u - i, 4.0
            u, v = v, u
    shade = 0.72 + 0.5 * lattice(number, other, 11)
    shade *= 0.35 + 0.65 * _joint(f, across, length, 1.0, 0.03)
    shift = 40 * lattice(number, other, 5)
    return _grain(4 * u + shift, 4 * v, 40 * lattice(other, number, 7)), shade


@njit(cache=True, error_model="numpy")
def _marks(u, v):  # pragma: no cover - compiled
    """Lines of something like writing: words of upright, level and slanted strokes."""
    line = math.floor(v)
    y = v - line
    if y < 0.18 or y > 0.72 or lattice(int(line), 0, 21) < 0.12:
        return 0.0
    word = math.floor(u / 2.6)
    if lattice(int(word), int(line), 22) < 0.22:
        return 0.0
    letter = math.floor(u * 2.6)
    x = u * 2.6 - letter
    shape = lattice(int(letter), int(line), 23)
    if x < 0.15:
        return 0.0
    upright = 1.0 if abs(x - 0.35) < 0.11 else 0.0
    level = 1.0 if abs(y - 0.3 - 0.3 * lattice(int(letter), int(line), 24)) < 0.06 else 0.0
    slant = 1.0 if abs(x - 0.2 - 0.9 * (y - 0.18)) < 0.1 else 0.0
    if shape < 0.35:
        return max(upright, level)
    if shape < 0.65:
        return max(slant, level)
    return max(upright, slant) if shape < 0.85 else 0.0


@njit(cache=True, error_model="numpy")
def _terrazzo(u, v):  # pragma: no cover - compiled
    """Chips of stone: the nearest of the scattered points, if it is near enough."""
    i, j = math.floor(u), math.floor(v)
    best, chip = 9.0, 0.0
    for di in range(-1, 2):
        for dj in range(-1, 2):
            a, b = int(i) + di, int(j) + dj
            du, dv = a + lattice(a, b, 31) - u, b + lattice(a, b, 32) - v
            d = du * du + dv * dv
            if d < best:
                best, chip = d, lattice(a, b, 33)
    return 1.0 if best < 0.13 * (0.3 + chip) else 0.0, chip


@njit(cache=True, error_model="numpy")
def _rug(u, v):  # pragma: no cover - compiled
    """Nested diamonds in fields of their own, as knotted rugs have them."""
    i, j = math.floor(u), math.floor(v)
    a, b = abs(u - i - 0.5), abs(v - j - 0.5)
    ring = math.floor(7 * (a + b))
    return lattice(int(ring), int(i + j) % 2, 41), lattice(int(ring), 5, 42)


@njit(cache=True, error_model="numpy")
def pattern(kind, x, y, z, u, v):  # pragma: no cover - compiled
    """Mix of the second colour into the first, 0 to 1, and factors on red, green and blue.

    Parameters
    ----------
    kind : int
        Position in `cmtof.scenes.rooms.materials.PATTERNS`.
    x, y, z, u, v : float
        Position, in repeats of the pattern.
    """
    mix, r, g, b = 0.0, 1.0, 1.0, 1.0
    if kind == _WOOD:
        mix = _grain(x, y, z)
    elif kind in (_PLANKS, _HERRINGBONE):
        mix, r = _planks(u, v, kind == _HERRINGBONE)
        g = b = r
    elif kind == _TILES:
        i, j = math.floor(u), math.floor(v)
        on = _joint(u - i, v - j, 1.0, 1.0, 0.02)
        mix = 1 - on
        r = g = b = 1 - on * 0.12 * lattice(int(i), int(j), 51)
    elif kind == _BRICKS:
        row = math.floor(3 * v)
        along = u + 0.5 * (row % 2)
        brick = math.floor(along)
        on = _joint(along - brick, 3 * v - row, 1.0, 0.33, 0.03)
        mix = 1 - on
        rough = 0.45 * lattice(int(brick), int(row), 52) + 0.2 * turbulence(9 * u, 9 * v, 0.0)
        r = g = b = 1 - on * (rough - 0.1)
    elif kind == _STRIPES:
        mix = 1.0 if v - math.floor(v) < 0.35 + 0.3 * lattice(math.floor(v), 1, 53) else 0.0
    elif kind == _CHECKS:
        mix = 0.5 * (math.floor(u) % 2) + 0.5 * (math.floor(v) % 2)
    elif kind == _NOISE:
        mix = turbulence(x, y, z)
    elif kind == _WEAVE:
        mix = 0.5 + 0.25 * (math.sin(6.2832 * u) + math.sin(6.2832 * v))
        r = g = b = 0.85 + 0.3 * value_noise(0.3 * x, 0.3 * y, 0.3 * z)
    elif kind == _MARBLE:
        vein = abs(math.sin(2.1 * (x + 0.6 * y) + 5.5 * turbulence(0.7 * x, 0.7 * y, 0.7 * z)))
        mix = (1 - vein) ** 3
    elif kind == _TERRAZZO:
        mix, chip = _terrazzo(u, v)
        r, g, b = (0.6 + 0.8 * chip, 1.0, 1.4 - 0.8 * chip) if mix > 0 else (1.0, 1.0, 1.0)
    elif kind == _MARKS:
        mix = _marks(u, v)
    elif kind == _PICTURE:
        tone = turbulence(1.3 * u, 1.3 * v, z)
        mix = min(1.0, max(0.0, 4 * turbulence(0.6 * u + 3, 0.6 * v, 2 * tone) - 1.5))
        level = math.floor(6 * tone)
        r = 0.75 + 0.5 * lattice(level, 0, 54)
        g = 0.75 + 0.5 * lattice(level, 1, 54)
        b = 0.75 + 0.5 * lattice(level, 2, 54)
    elif kind == _RUG:
        mix, other = _rug(u, v)
        r, g, b = 0.6 + 0.6 * other, 1.0, 1.25 - 0.6 * other
    elif kind == _LEAF:
        mix = max(0.0, 1 - 6 * abs(math.sin(3.1416 * (u + 0.7 * abs(v)))))
        r = g = b = 0.8 + 0.4 * value_noise(2 * x, 2 * y, 2 * z)
    elif kind == _DOTS:
        row = math.floor(v)
        f = u + 0.5 * (row % 2)
        mix = 1.0 if math.hypot(f - math.floor(f) - 0.5, v - row - 0.5) < 0.27 else 0.0
    return mix, r, g, b
