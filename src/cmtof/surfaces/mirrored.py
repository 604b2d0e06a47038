"""The vote of `surfaces` on four mirror images of a measurement.

Where the odds of two answers are nearly even, chance decides about a whole surface: the order in
which windows start, or the pixels that a fit looks at. A mirror image is the same evidence with
other chances, so that a vote over all four is more often right, and the same for each of them.
"""

from itertools import product

import numpy as np

from cmtof.correlation import consistent_wrap_count
from cmtof.estimate import Estimate
from cmtof.measurement import Measurement
from cmtof.surfaces.method import surfaces


def surfaces_mirrored(measurement: Measurement) -> Estimate:
    """Vote of `surfaces` on four mirror images, in four times the time."""
    found = []
    for down, right in product((1, -1), repeat=2):
        answer = surfaces(mirror_image(measurement, down, right))
        found.append([image[::down, ::right] for image in answer[:2]])
    depth, confidence = np.swapaxes(found, 0, 1)
    wraps = consistent_wrap_count(
        depth, measurement.phase[0], measurement.frequencies[0]
    )
    confidence = np.maximum(confidence, 1e-9)
    votes = np.array([np.where(wraps == one, confidence, 0).mean(0) for one in wraps])
    # the nearer one of two alike
    best = (votes - 1e-9 * wraps).argmax(axis=0)
    agree = wraps == np.take_along_axis(wraps, best[None], axis=0)
    depth = np.average(depth, axis=0, weights=agree * confidence)
    return Estimate(depth, votes.max(axis=0))


def mirror_image(measurement: Measurement, down: int, right: int) -> Measurement:
    """The measurement with its rows and columns in the other order where a step is -1, not 1."""
    data = measurement.dataset.isel(
        y=slice(None, None, down), x=slice(None, None, right)
    )
    if "camera" in data:
        count = data.camera.size
        signs = np.resize([1, 1, right, down, down * right], count)
        size = np.resize([0, 0, *measurement.shape[::-1], 0], count)
        data["camera"] = data.camera * signs + size * (1 - signs) / 2
    return Measurement(data)
