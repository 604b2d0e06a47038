"""One command that replicates: Fig. 10 drawn again, and the chain from frame to depth checked.

Each line compares what this machine computed with ``replication.yml``. How far the two may be apart
follows from the kind of the number (`cmtof_book.compared`), and for methods from how far they moved
over ten seeds.

    python -m cmtof_book.replication SEED

prints every value at a seed.
"""

import sys
from collections.abc import Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from cmtof.bounds import phase_spread, simulated_phase_noise, wrap_probability
from cmtof.constants import FREQUENCIES
from cmtof.correlation import centred, depth_from_phase, phase_from_depth
from cmtof.evaluation import Evaluation, measured, score, scored_pixels
from cmtof.files import read_document, written_whole
from cmtof.frame import embedded_frames
from cmtof.scenes import Frame, load_frame
from cmtof.simulation import simulate
from cmtof.unwrapping import unwrap
from cmtof_book.compared import STANDARD_ERRORS, Compared

SEED = 0
# Columns of the figure: the paper's that need no training, and three that it leaves out.
METHODS = ("phasor", "crt", "kde", "beat", "mrf", "surfaces")

Named = Iterator[tuple[str, float]]  # numbers by their names in ``replication.yml``


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
        said = "PASS" if self.passed else "FAIL"
        return f"{said}  {self.what}: {self.value:.4g} (expected {allowed})"


def replicate(figure: Path) -> Iterator[Outcome]:
    """Every check in turn; then, if matplotlib is there, Fig. 10 is drawn to ``figure``."""
    stored = read_document(Path(__file__).with_name("replication.yml"))
    for name, value in values(SEED, figure):
        yield Outcome(stored[name]["what"], value, expected(stored[name]))


def expected(entry: Mapping[str, Any]) -> Compared:
    """Number of an entry of ``replication.yml``.

    From the values at several ``seeds`` follow their mean and standard deviation, and the bound of
    a decision: five of these below the mean.
    """
    if "seeds" not in entry:
        return Compared(**entry)
    mean = np.mean(entry["seeds"])
    spread = np.std(entry["seeds"], ddof=1)
    least = mean - STANDARD_ERRORS * spread
    return Compared(value=mean, kind=entry["kind"], error=spread, at_least=least)


def values(seed: int, figure: Path | None = None) -> Named:
    """Every number by its name in ``replication.yml``; Fig. 10 is drawn where a file is named."""
    yield from _noise(seed)
    yield from _methods(seed, figure)


def _noise(seed: int) -> Named:
    """Phase noise of the simulation against its law, and what follows for one pixel's wrap."""
    tones = np.geomspace(0.1e9, 10e9, 21)
    wall = Frame(np.full((1, 1000), 0.6), np.full((1, 1000), 0.5))
    noisy = simulate(wall, protocol="full", frequencies=tones, seed=seed)
    error = centred(noisy.phase[:, 0] - phase_from_depth(0.6, tones)[:, None])
    spread = depth_from_phase(error.std(axis=1), tones)
    yield "precision_ratio", spread[0] / spread[-1]
    law = phase_spread(simulated_phase_noise(0.5))
    yield "phase_noise_ratio", error.std(axis=1).mean() / law
    noise = simulated_phase_noise(1.0)
    yield "wrap_odds", wrap_probability(noise, noise, frequencies=FREQUENCIES)


def _methods(seed: int, figure: Path | None) -> Named:
    """Share of right wraps of each method on the embedded frames."""
    frames = [*map(load_frame, embedded_frames())]
    clean = Evaluation(["crt"], noise_free=True).add_all(frames).report()
    yield "crt_noise_free", clean["methods"]["crt"]["consistent_lt_1"]
    taken = [
        measured(frame, METHODS, number=k, seed=seed) for k, frame in enumerate(frames)
    ]
    answers: dict[str, xr.Dataset] = {}
    for method in METHODS:
        given = [measurements[method] for measurements in taken]
        found = [unwrap(one, method=method) for one in given]
        yield method, score(map(scored_pixels, found, given))["delta_lt_1"]
        answers[method] = found[0]
    if figure and find_spec("matplotlib"):
        _draw(figure, frames[0], taken[0]["beat"], answers)


def _draw(figure: Path, *shown: Any) -> None:
    """Draw Fig. 10 of a frame, its measurement and the answers, whole or not at all."""
    from cmtof_book import plotting
    from cmtof_book.comparison import Scene, comparison_figure

    plotting.begin()
    with written_whole(figure) as part:
        comparison_figure(Scene(*shown), METHODS).savefig(part)


if __name__ == "__main__":
    for name, value in values(int(sys.argv[1])):
        print(f"{name}: {value:.10g}", flush=True)
