"""Numba's compiler, also where no folder can keep what it compiled."""

import warnings
from collections.abc import Callable
from functools import partial
from typing import Any

import numba


def njit(**options: Any) -> Callable[[Callable], Any]:
    """Decorator like ``numba.njit`` that goes on without the cache where nothing can be written.

    Loops let other threads run, and divide by zero as NumPy does. Numba keeps what it compiled
    beside the module or in the user's cache folder. An installation that is read-only and a user
    without a home have neither: each process compiles again.
    """

    options |= {"nogil": True, "error_model": "numpy"}

    def compiled(function: Callable) -> Any:
        try:
            found = numba.njit(cache=True, **options)(function)
        except RuntimeError as error:
            if "cannot cache" not in str(error):
                raise
            _say_uncached()
            return numba.njit(**options)(function)
        if cache := getattr(
            found, "_cache", None
        ):  # none while compilation is switched off
            cache.save_overload = partial(_saved_if_possible, cache.save_overload)
        return found

    return compiled


def _saved_if_possible(save: Callable, *what: Any) -> None:
    """Save what was compiled unless the disk is full."""
    try:
        save(*what)
    except OSError:
        _say_uncached()


_said = False


def _say_uncached() -> None:
    """Warn once a process."""
    global _said
    if not _said:
        warnings.warn(
            "Expected a folder that keeps compiled code, got none that can be written: "
            "every run compiles again. Set NUMBA_CACHE_DIR.",
            stacklevel=4,
        )
    _said = True
