"""One command that replicates: Fig. 10 drawn again, and the chain from frame to depth checked.

Each line compares what this machine computed with ``replication.yml``. How far the two may be apart
follows from the kind of the number (`cmtof_book.compared`), and for methods from how far they moved
over ten seeds.
"""

from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cmtof.bounds import phase_spread, simulated_phase_noise, wrap_probability
from cmtof.constants import FREQUENCIES
from cmtof.correlation import centred, depth_from_phase, phase_from_depth
from cmtof.evaluation import Evaluation, measure_frame
from cmtof.files import atomic_output
from cmtof.frame import embedded_frames
from cmtof.scenes import Frame, load_frame
from cmtof.simulation import simulate
from cmtof.unwrapping import unwrap
from cmtof_book import package_data
from cmtof_book.compared import Compared

# Columns of the figure: the paper's that need no training, and three that it leaves out.
METHODS = ("phasor", "crt", "kde", "beat", "mrf", "surfaces")


class Outcome(NamedTuple):
    """One line of the replication: our value and the one that is expected."""

    what: str
    value: float
    expected: Compared

    @property
    def passed(self) -> bool:
        """Whether the value agrees with the expected one; NaN never does."""
        return self.expected.accepts(self.value)

    def __str__(self) -> str:
        allowed = f"{self.expected.value:.4g} ± {self.expected.tolerance():.2g}"
        if self.expected.kind == "decision":
            allowed = f"at least {self.expected.at_least:.4g}"
        return (
            f"{'PASS' if self.passed else 'FAIL'}  {self.what}: {self.value:.4g} "
            f"(expected {allowed})"
        )


def replicate(figure: Path) -> Iterator[Outcome]:
    """Every check in turn; then, if matplotlib is there, Fig. 10 is drawn to ``figure``."""
    stored = package_data("replication")
    for name, value in _numbers():
        yield Outcome(stored[name]["what"], value, Compared(**stored[name]))
    if find_spec("matplotlib"):
        draw(figure)


def _numbers() -> Iterator[tuple[str, float]]:
    """What this machine computes, by the names of ``replication.yml``.

    Phase noise of the simulation against its law, what follows for one pixel's wrap, and the share
    of right wraps of each method on the embedded frames.
    """
    tones = np.geomspace(0.1e9, 10e9, 21)
    wall = Frame(np.full((1, 1000), 0.6), np.full((1, 1000), 0.5))
    noisy = simulate(wall, protocol="full", frequencies=tones)
    error = centred(noisy.phase[:, 0] - phase_from_depth(0.6, tones)[:, None])
    spread = depth_from_phase(error.std(1), tones)
    yield "precision_ratio", spread[0] / spread[-1]
    law = phase_spread(simulated_phase_noise(0.5))  # pyright: ignore[reportArgumentType]
    yield "phase_noise_ratio", error.std(1).mean() / law
    noise = simulated_phase_noise(1.0)
    yield "wrap_odds", wrap_probability(noise, noise, frequencies=FREQUENCIES)  # pyright: ignore[reportReturnType]

    frames = [*map(load_frame, embedded_frames())]
    clean = Evaluation(["crt"], noise_free=True).add_all(frames).report()
    yield "crt_noise_free", clean["methods"]["crt"]["consistent_lt_1"]
    for method in METHODS:
        scored = Evaluation([method]).add_all(frames).report()
        yield method, scored["methods"][method]["delta_lt_1"]


def draw(figure: Path) -> None:
    """Draw Fig. 10 of the first frame, whole or not at all."""
    from cmtof_book import plotting
    from cmtof_book.comparison import Scene, comparison_figure

    frame = load_frame(next(iter(embedded_frames())))
    given = measure_frame(frame, METHODS)
    answers = {name: unwrap(one, method=name) for name, one in given.items()}
    plotting.begin()
    with atomic_output(figure) as part:
        scene = Scene(frame, given["beat"], answers)
        comparison_figure(scene, METHODS).savefig(part)
