"""What a method finds, and its rates, as tables count them."""

import cmtof
from cmtof.evaluation import score, scored_pixels


def images(measurement, **method):
    """Wrap count, depth and confidence (H, W) of a measurement."""
    result = cmtof.unwrap(measurement, **method)
    return [result[name].to_numpy() for name in ("wrap_count", "depth", "confidence")]


def scores(measurement, **method):
    """Rates over the scored pixels of a measurement."""
    return score(scored_pixels(cmtof.unwrap(measurement, **method), measurement))
