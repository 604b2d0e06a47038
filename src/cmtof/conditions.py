"""How a frame is measured: everything that decides a simulated measurement but the frame."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any

from cmtof.baselines import find_method
from cmtof.constants import FREQUENCIES, NOISE_SIGMA
from cmtof.detector import NoiseOrder
from cmtof.measurement import Measurement
from cmtof.scenes.frame import Frame
from cmtof.simulation import QUADRATURES, Protocol, simulate


@dataclass(frozen=True)
class Conditions:
    """Options of `cmtof.simulation.simulate` that all frames and all methods share.

    The noise of frame k is drawn from (seed, k).
    """

    protocol: Protocol = "released"
    noise: float = NOISE_SIGMA
    noise_free: bool = False
    seed: int = 0
    frequencies: Sequence[float] = FREQUENCIES
    psi: Sequence[float] = QUADRATURES
    order: NoiseOrder = "paper"
    phase_offset: Sequence[float] = (0.0,)

    def measure(
        self, frame: Frame, number: int = 0, frequencies: Sequence[float] = ()
    ) -> Measurement:
        """Simulate the frame of that number, at other frequencies if they are given."""
        options = {one.name: getattr(self, one.name) for one in fields(self)}
        options["frequencies"] = frequencies or self.frequencies
        return simulate(frame, frame_number=number, **options)

    def settings(self) -> dict[str, Any]:
        """Plain values: those that every table states, and whatever else is unusual."""
        plain = {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(self).items()}
        usual = asdict(Conditions())
        always = ("protocol", "noise", "seed")
        changed = {k: v for k, v in plain.items() if getattr(self, k) != usual[k]}
        return {key: plain[key] for key in always} | changed


class Measured:
    """One frame, measured once for all methods and once more for those that need other frequencies.

    Pixels are scored where the usual measurement has them in range, whatever the method.

    Examples
    --------
    >>> from cmtof import load_frame
    >>> taken = Measured(Conditions(), load_frame("still_life"))
    >>> [float(f) / 1e9 for f in taken.by("phasor").frequencies]
    [7.15, 7.16]
    >>> taken.by("beat") is taken.by("crt")
    True
    """

    def __init__(self, conditions: Conditions, frame: Frame, number: int = 0) -> None:
        self._conditions, self._frame, self._number = conditions, frame, number
        self.usual = conditions.measure(frame, number)
        self._held: dict[tuple[float, ...], Measurement] = {(): self.usual}

    def by(self, method: str) -> Measurement:
        """What a method is given."""
        tones = find_method(method).tones
        if tones not in self._held:
            other = self._conditions.measure(self._frame, self._number, tones)
            scored = (("y", "x"), other.mask & self.usual.mask)
            self._held[tones] = Measurement(other.dataset.assign(mask=scored))
        found = self._held[tones]
        _ = found.decoded  # shared by all methods, so no method is charged for it
        return found
