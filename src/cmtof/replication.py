"""One command that replicates: Fig. 10 drawn anew, the chain from frame to depth held to account.

Each line compares what this machine computed with a stored value and tolerance
(``replication.yml``, written by the same code at the same seed) or with the paper's number.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from cmtof.book import paper
from cmtof.book.comparison import Scene, comparison_figure
from cmtof.bounds import phase_spread, simulated_phase_noise, wrap_probability
from cmtof.constants import FREQUENCIES
from cmtof.correlation import centred, depth_from_phase, phase_from_depth
from cmtof.evaluation import Evaluation, measured, score, scored_pixels
from cmtof.scenes import Frame, load_frame
from cmtof.scenes.frame import embedded_frames
from cmtof.simulation import simulate, true_phase
from cmtof.unwrapping import unwrap

SEED = 0

FIG3_FREQUENCIES = np.geomspace(0.1e9, 10e9, 21)
"""Frequencies of Fig. 3, Hz."""

METHODS = ("phasor", "crt", "kde", "beat", "mrf", "surfaces")
"""Columns of the figure: the paper's that need no training, and three that it leaves out."""


@dataclass(frozen=True)
class Outcome:
    """One line of the replication.

    Attributes
    ----------
    name, what : str
    value, expected, tolerance : float
        Ours, the stored or published one, and how far they may lie apart.
    passed : bool
    """

    name: str
    what: str
    value: float
    expected: float
    tolerance: float

    @property
    def passed(self) -> bool:
        """Whether the value lies within the tolerance; NaN never does."""
        return bool(abs(self.value - self.expected) <= self.tolerance)

    def __str__(self) -> str:
        verdict = "PASS" if self.passed else "FAIL"
        return (
            f"{verdict}  {self.what}: {self.value:.4g} "
            f"(expected {self.expected:.4g} ± {self.tolerance:.2g})"
        )


def replicate(figure: Path | None = None) -> Iterator[Outcome]:
    """Run every check in turn; draw Fig. 10 to ``figure`` on the way.

    Parameters
    ----------
    figure : Path, optional
        Where to write the figure (``.png``, ``.svg`` or ``.pdf``).

    Yields
    ------
    Outcome
    """
    published = paper.published("fig3.precision_ratio")
    noise = fig3_phase_noise()
    spread = depth_from_phase(noise, FIG3_FREQUENCIES)
    yield Outcome(
        published.key,
        "Fig. 3, precision gained from 100 MHz to 10 GHz (paper)",
        float(spread[0] / spread[-1]),
        published.value,
        published.tolerance,
    )
    stored = stored_values()
    scenes: list[Scene] = []
    for name, value in computed_values(noise, scenes):
        entry = stored[name]
        yield Outcome(name, entry["what"], value, entry["value"], entry["tolerance"])
    if figure is not None:
        _draw(scenes, figure)


def fig3_phase_noise() -> NDArray[np.floating]:
    """Phase noise, rad, at each frequency of Fig. 3: 1000 pixels half as bright as white."""
    depth = np.full((1, 1000), 0.6)
    wall = Frame(depth, np.full(depth.shape, 0.5))
    noisy = simulate(wall, protocol="full", frequencies=FIG3_FREQUENCIES, seed=SEED)
    truth = phase_from_depth(0.6, FIG3_FREQUENCIES)
    return centred(noisy.phase[:, 0] - truth[:, None]).std(axis=1)


def computed_values(
    noise_of_fig3: NDArray[np.floating], scenes: list[Scene]
) -> Iterator[tuple[str, float]]:
    """Compute the quantities of ``replication.yml`` in turn, by name; add what Fig. 10 shows."""
    law = phase_spread(float(simulated_phase_noise(0.5)))
    yield "law_ratio", float(noise_of_fig3.mean()) / law
    wall = Frame(np.ones((256, 256)), np.ones((256, 256)))
    noisy = simulate(wall, seed=SEED)
    error = centred(noisy.phase[0] - true_phase(noisy))
    noise = float(simulated_phase_noise(1.0))
    yield "phase_noise_ratio", float(error.std()) / phase_spread(noise)
    yield "wrap_odds", float(wrap_probability(noise, noise, frequencies=FREQUENCIES))
    frames = [load_frame(name) for name in embedded_frames()]
    clean_report = Evaluation(["crt"], noise_free=True).add_all(frames).report()
    yield "crt_noise_free", clean_report["methods"]["crt"]["consistent_lt_1"]
    taken = [measured(frame, METHODS, number=k, seed=SEED) for k, frame in enumerate(frames)]
    answers: list[dict[str, xr.Dataset]] = [{} for _ in frames]
    for method in METHODS:
        for given, found in zip(taken, answers, strict=True):
            found[method] = unwrap(given[method], method=method)
        scored = [
            scored_pixels(found[method], given[method])
            for given, found in zip(taken, answers, strict=True)
        ]
        yield method, score(scored)["delta_lt_1"]
    usual = [given["beat"] for given in taken]
    scenes += [Scene(*three) for three in zip(frames, usual, answers, strict=True)]


def stored_values() -> dict[str, dict[str, Any]]:
    """Read ``replication.yml``: name -> what, value, tolerance."""
    import yaml

    return yaml.safe_load(files("cmtof").joinpath("replication.yml").read_text("utf-8"))


def _draw(scenes: list[Scene], path: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from cmtof.book import plotting
    from cmtof.files import written_whole

    plotting.begin()
    with written_whole(path) as part:
        comparison_figure(scenes, METHODS).savefig(part)
