"""Unwrapping methods, one a file, one signature; found by name.

A method maps a `Measurement` to an `Estimate`: the depth it believes in and how much. From that
depth `cmtof.unwrapping` derives the paper's wrap count and the one consistent with the phase.
"""

from cmtof.baselines.catalogue import DEFAULT, METHODS, find_method
from cmtof.baselines.method import Estimate, Method, within_range, wraps_in_range

__all__ = [
    "DEFAULT",
    "METHODS",
    "Estimate",
    "Method",
    "find_method",
    "within_range",
    "wraps_in_range",
]
