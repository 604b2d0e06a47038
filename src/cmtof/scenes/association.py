"""Pairs of images by time stamp, as the TUM RGB-D benchmark lists them.

Source: Sturm et al., IROS 2012, and the benchmark's description of file formats.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

Stamped = list[tuple[float, str]]


def read_stamps(path: Path) -> Stamped:
    """Read lines «time file» (``rgb.txt``, ``depth.txt``); comments begin with ``#``.

    Raises
    ------
    ValueError
        If a line holds something else.
    """
    return [(float(fields[0]), fields[1]) for fields in _lines(path, 2)]


def read_pairs(path: Path) -> list[tuple[str, str]]:
    """Read lines «time file time file» (``associations.txt``): depth and colour file of each pair.

    The order is told by the names: the file below ``depth`` is depth.

    Raises
    ------
    ValueError
        If a line holds something else.
    """
    pairs = []
    for _, one, _, other in _lines(path, 4):
        ordered = [name for name in (one, other) if "depth" in name.lower()]
        if len(ordered) != 1:
            raise ValueError(
                f"Expected one file of each pair in a folder depth, got {one} and {other} in "
                f"{path}. Write its lines as «time rgb/FILE time depth/FILE»."
            )
        pairs.append((ordered[0], other if ordered[0] == one else one))
    return pairs


def associate(
    first: Sequence[float], second: Sequence[float], within: float = 0.02
) -> list[tuple[int, int]]:
    """Pair time stamps, nearest ones first, each used once.

    Parameters
    ----------
    first, second : sequence of float
        Times, s, in any order.
    within : float
        Largest difference of a pair, s.

    Returns
    -------
    list of (int, int)
        Indices into both, in the order of ``first``.

    Examples
    --------
    >>> associate([0.00, 0.033, 0.067], [0.002, 0.034, 0.5])
    [(0, 0), (1, 1)]
    """
    order = np.argsort(second, kind="stable")
    times = np.asarray(second, float)[order]
    near = []
    for i, time in enumerate(first):
        start = np.searchsorted(times, time - 1.01 * within, side="left")
        stop = np.searchsorted(times, time + 1.01 * within, side="right")
        near += [(abs(time - times[k]), i, int(order[k])) for k in range(start, stop)]
    taken_first: set[int] = set()
    taken_second: set[int] = set()
    pairs = []
    for difference, i, j in sorted(near):
        if difference <= within and i not in taken_first and j not in taken_second:
            pairs.append((i, j))
            taken_first.add(i)
            taken_second.add(j)
    return sorted(pairs)


def _lines(path: Path, fields: int) -> list[list[str]]:
    """Fields of each line that is no comment; every other one is a time."""
    lines = []
    text = path.read_text(encoding="utf-8", errors="replace")
    for number, line in enumerate(text.splitlines(), start=1):
        parts = line.replace(",", " ").split()
        if not parts or parts[0].startswith("#"):
            continue
        if len(parts) < fields or not all(_is_time(part) for part in parts[:fields:2]):
            raise ValueError(
                f"Expected «{' '.join(['time file'] * (fields // 2))}» in line {number} of {path}, "
                f"got {line[:80]!r}. Write the list anew."
            )
        lines.append(parts[:fields])
    return lines


def _is_time(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False
