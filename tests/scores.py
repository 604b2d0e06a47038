"""Rates of a method, as tables count them."""

import cmtof
from cmtof.evaluation import score, scored_pixels


def scores(measurement, **method):
    """Rates over the scored pixels of a measurement."""
    return score(scored_pixels(cmtof.unwrap(measurement, **method), measurement))
