"""Numbers that are compared with stored ones; how far they may move follows from their kind.

No tolerance is typed by hand. A closed form moves by rounding alone. A sum over draws moves as its
standard error says, for another processor may round a rate differently and so draw other noise. A
share of pixels moves by the few pixels that lie on an edge. A decision may flip a whole surface by
a last digit: it is not compared, only bounded from below.

>>> stored = sum_over_draws(10.0, error=0.1)
>>> stored.accepts(10.4), stored.accepts(10.6), stored.accepts(10.6, error=0.1)
(True, False, True)
"""

from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic.dataclasses import dataclass

from cmtof.types import Array, Fields

Kind = Literal["closed form", "sum over draws", "share of pixels", "decision"]

ROUNDING = 1e-9  # relative tolerance of a closed form

# tolerance of a sum over draws, in standard errors of the difference
STANDARD_ERRORS = 5

EDGE_PIXELS = 20  # pixels of an image that may change sides by rounding


@dataclass(frozen=True)
class Compared:
    """A number, or a list of them, and what its kind needs to tell how far it may move.

    ``error`` is the standard error, ``pixels`` how many a share counts, ``at_least`` the bound of
    a decision; each is one number for all, or a list as long as ``value``. Raises ValueError for
    another kind; what else a record says of a number is left out.
    """

    value: Any
    kind: Kind
    error: Any = None
    pixels: Any = None
    at_least: Any = None

    def record(self) -> Fields:
        """Value, kind and what belongs to the kind, for JSON."""
        return {name: part for name, part in vars(self).items() if part is not None}

    def tolerance(self, error: ArrayLike = 0.0) -> Array:
        """Largest difference allowed to a number found now, whose standard error is ``error``."""
        if self.kind == "closed form":
            return ROUNDING * np.abs(self.value)
        noise = STANDARD_ERRORS * np.hypot(self.error or 0.0, error)
        return np.maximum(noise, np.divide(EDGE_PIXELS, self.pixels or np.inf))

    def accepts(self, value: ArrayLike, error: ArrayLike = 0.0) -> bool:
        """Whether a number found now agrees with this stored one; NaN never does."""
        found = np.asarray(value, float)
        if found.shape != np.shape(self.value):
            return False
        if self.kind == "decision":
            return bool((found >= self.at_least).all())
        return np.allclose(found, self.value, rtol=0, atol=self.tolerance(error))


# follows from physics alone: equal everywhere but for rounding
closed_form = partial(Compared, kind="closed form")

# mean, spread or rate of random draws with its standard ``error``; five of them are allowed
sum_over_draws = partial(Compared, kind="sum over draws")

# fraction of so many ``pixels``; 20 of them may change sides, or five standard errors of the
# scenes, for a share over several of them
share_of_pixels = partial(Compared, kind="share of pixels")

# result of a method that a last digit may turn on a whole surface; only bounded from below, by
# ``at_least``
decision = partial(Compared, kind="decision")
