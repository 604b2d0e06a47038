"""RF demodulation at every pixel of a scan (Fig. 16): the light that each pixel sends back.

The same laser, emission, spot and speckle as in the scan without wires, but the light falls on the
fast photodiode, and `RfReceiver` demodulates its current for the 13.3 ms of a point. Offset and
imbalance count as calibrated away without a rest, and nothing drifts: what is left is noise.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.correlation import phase_from_depth
from cmtof.instrument import optics as free_space
from cmtof.instrument.optics import sent_power
from cmtof.instrument.settings import TwinSettings
from cmtof.instrument.targets import Target
from cmtof.ranging.rf import FREQUENCY, modulation_depth, seen_share
from cmtof.ranging.rf_receiver import RfReceiver

Array = NDArray[np.float64]


class RfImage(NamedTuple):
    """What the receiver says of each direction (...)."""

    phase: Array
    """Wrapped phase in [0, 2 pi), rad."""
    amplitude: Array
    """Envelope at the converter, V."""
    power: Array
    """Mean light on the photodiode, W."""
    bound: Array
    """Cramer-Rao bound on the phase, rad; infinite where nothing returns."""


def rf_image(
    settings: TwinSettings,
    target: Target,
    angles: Array,
    *,
    seed: int,
    mode: str = "single",
    receiver: RfReceiver | None = None,
) -> RfImage:
    """Demodulate the light of every direction after photo-conversion.

    Parameters
    ----------
    settings : TwinSettings
    target : Target
    angles : ndarray, shape (..., 2)
        Optical angles x and y, rad, as ``angle`` of a scan.
    seed : int
        Of speckle, which is that of a scan of the same seed, and of noise.
    mode : {"single", "doubled"}
    receiver : RfReceiver, optional

    Examples
    --------
    >>> from cmtof.instrument.targets import Plane
    >>> seen = rf_image(TwinSettings(), Plane(1.0), np.zeros((1, 2)), seed=0)
    >>> bool(seen.bound[0] > 0.3)  # rad: of little use
    True
    """
    receiver = receiver or RfReceiver()
    frequency, depth = FREQUENCY[mode], modulation_depth(settings, mode)
    paths = free_space.trace(target, np.reshape(angles, (-1, 2)), settings, seed)
    with np.errstate(divide="ignore"):  # where nothing returns the fraction is 0
        share = seen_share(settings, receiver.parts, paths.range)
    sent = sent_power(settings, mode) * free_space.inward(settings.optics)
    power = sent * paths.fraction * share
    index = free_space.group_index(settings.air, settings.laser.wavelength)
    # each ray of the spot has a phase of its own: on a slope they partly cancel
    field = (power * np.exp(1j * phase_from_depth(index * paths.range, frequency))).sum(-1)
    total = power.sum(-1)
    modulation = depth * np.abs(field) / np.where(total > 0, total, 1.0)
    reading = receiver.estimate(
        receiver.phasor(
            total,
            modulation,
            np.angle(field),
            frequency=frequency,
            rng=np.random.default_rng([seed, 16, mode == "doubled"]),
        )
    )
    bound = receiver.phase_bound(total, modulation, frequency=frequency)
    shape = np.shape(angles)[:-1]
    found = (np.asarray(reading.phase, float), reading.amplitude, total, bound)
    return RfImage(*(one.reshape(shape) for one in found))
