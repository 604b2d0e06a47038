"""Checks of inputs before any computation, each with an error message of one line."""

import json
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from cmtof.types import Array

T = TypeVar("T")
# Lowest and highest modulation frequency that is accepted, Hz.
LOWEST_FREQUENCY = 1e5
HIGHEST_FREQUENCY = 1e12


def checked_values(kind: type[T], values: Any, source: object) -> T:
    """Values converted to a type and checked by pydantic; a ValueError names the first fault.

    >>> checked_values(tuple[int, int], [1, "x"], "a.yml")
    Traceback (most recent call last):
    ...
    ValueError: Expected 1 in a.yml to be a valid integer, ..., got 'x'. Correct it.
    """
    from pydantic import TypeAdapter, ValidationError

    try:
        # as JSON a mapping may stand for a section, and a list for a tuple, and nothing else
        return TypeAdapter(kind).validate_json(json.dumps(values, default=str))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        rule = first["msg"].removeprefix("Value error, ").removeprefix("Input should ")
        if first["type"] == "value_error":
            raise ValueError(f"{rule} ({source})") from None
        place = ".".join(map(str, first["loc"])) or "names and values"
        words = {
            "unexpected_keyword_argument": "be a known key",
            "extra_forbidden": "be a known key",
            "missing": "be there",
        }
        rule = words.get(first["type"], rule)
        found = repr(first["input"])[:60]
        raise ValueError(
            f"Expected {place} in {source} to {rule}, got {found}. Correct it."
        ) from None


def numbers(values: ArrayLike, what: str, dtype: DTypeLike = np.float64) -> Array:
    """Values as a new array of floats; a ValueError for text, complex, structured and time types.

    >>> numbers(["1.0"], "depth")
    Traceback (most recent call last):
    ...
    ValueError: Expected numbers as depth, got values of type <U3. Store them as float.
    """
    array = np.asarray(values)
    if array.dtype.kind not in "biuf":
        raise ValueError(
            f"Expected numbers as {what}, got values of type {array.dtype}. Store them as float."
        )
    with np.errstate(over="ignore"):  # beyond float32 is infinite, and refused as such
        return array.astype(dtype)


def check_claim(claimed: int, path: Path) -> None:
    """Raise a ValueError if a header claims far more bytes than its file can hold.

    Up to 256 MiB pass; beyond, 200 times the bytes on disk: real images are packed less.
    """
    stored = path.stat().st_size
    if claimed > max(2**28, 200 * stored):
        raise ValueError(f"its header claims {claimed:.3g} bytes, it holds {stored}")


def checked_frequencies(values: ArrayLike) -> Array:
    """Modulation frequencies (F,), Hz; a ValueError unless they rise and are plausible."""
    found = np.atleast_1d(numbers(values, "frequencies"))
    within = (found >= LOWEST_FREQUENCY) & (found <= HIGHEST_FREQUENCY)  # false for NaN
    if not (found.size and within.all() and (np.diff(found) > 0).all()):
        raise ValueError(
            f"Expected modulation frequencies in rising order, from {LOWEST_FREQUENCY:g} up to "
            f"{HIGHEST_FREQUENCY:g} Hz, got {found.tolist()}. "
            "State them in Hz, for instance 7.15e9, 14.32e9."
        )
    return found


def checked_camera(values: ArrayLike, where: str) -> Array:
    """Camera fx, fy, cx, cy (and skew), px; a ValueError unless finite with fx, fy > 0."""
    found = numbers(values, f"camera of {where}")
    known = found.shape in ((4,), (5,)) and np.isfinite(found).all()
    if not (known and (found[:2] > 0).all()):
        raise ValueError(
            f"Expected camera fx fy cx cy (skew), px, with fx, fy > 0, in {where}, "
            f"got {found.tolist()}. Correct it."
        )
    return found
