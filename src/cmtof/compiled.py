"""Compilation by Numba, cached on disk where a folder can be written."""

import os
import sys
import warnings
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numba


def njit(**options: Any) -> Callable[[Callable], Any]:
    """Decorator like ``numba.njit`` that works without the cache where it cannot be written.

    Loops let other threads run, and divide by zero as NumPy does. Numba keeps what it compiled
    beside the module or in the user's cache folder. An installation that is read-only and a user
    without a home have neither: each process compiles again.
    """

    options |= {"nogil": True, "error_model": "numpy"}

    def compiled(function: Callable) -> Any:
        try:
            found = numba.njit(cache=True, **options)(function)
        except RuntimeError:  # no folder for a cache
            _warn_uncached()
            return numba.njit(**options)(function)
        # none while compilation is switched off
        if stored := getattr(found, "_cache", None):
            stored.save_overload = partial(_save_if_possible, stored.save_overload)
        return found

    return compiled


# Written into each caller, so that it is not compiled apart: for what is short or called once.
inlined = njit(inline="always")


def _save_if_possible(save: Callable, *what: Any) -> None:
    """Write compiled code to the cache, or warn if that fails, as on a full disk."""
    _say_compiling()
    try:
        save(*what)
    except OSError:
        _warn_uncached()


@cache
def _say_compiling() -> None:
    """Tell who waits at a terminal or in Jupyter that loops are compiled, once per process."""
    waits = sys.stderr and (sys.stderr.isatty() or "ipykernel" in sys.modules)
    if waits and not os.environ.get("CI"):
        print("Compiling loops, once: about a minute ...", file=sys.stderr)


@cache
def _warn_uncached() -> None:
    """Warn once per process that compiled code cannot be cached."""
    warnings.warn(
        "Expected a folder to cache compiled code in, got none that can be written: "
        "every run compiles again. Set NUMBA_CACHE_DIR.",
        stacklevel=4,
    )
