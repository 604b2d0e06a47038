"""Phases of known depths, without noise."""

import numpy as np
import pytest

from cmtof.constants import FREQUENCIES
from cmtof.correlation import phase_from_depth
from cmtof.measurement import Measurement


@pytest.fixture(scope="session")
def exact():
    """Measurement of depths in double precision; another truth may be claimed."""

    def measure(depth, frequencies=FREQUENCIES, truth=None, **attributes):
        depth = np.atleast_2d(np.asarray(depth, float))
        phase = np.stack([phase_from_depth(depth, f) for f in frequencies])
        truth = depth if truth is None else truth
        return Measurement.from_phase(phase, frequencies, depth=truth, **attributes)

    return measure
