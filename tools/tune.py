"""Score options of a method on validation views, to choose its constants by.

    python tools/tune.py beat window=21,41,81 --data TREE [--protocol full] [--views 20]

Every combination of the values is run on the same views with the same noise; the rates are those
of `cmtof.metrics`, in %. Only the validation part of a tree is opened: what test rooms have chosen
could not be tested on them. Views are taken evenly over all validation rooms.
"""

import argparse
import ast
import sys
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any

RATES = ("delta_lt_1", "delta_lt_2", "delta_lt_3", "delta_ge_10", "consistent_lt_1")


def read_grid(words: Sequence[str]) -> list[dict[str, Any]]:
    """Every combination of ``OPTION=V1,V2`` words; numbers are read as such.

    Raises
    ------
    ValueError
        If a word is not of that form.

    Examples
    --------
    >>> read_grid(["window=21,41", "shape=box"])
    [{'window': 21, 'shape': 'box'}, {'window': 41, 'shape': 'box'}]
    """
    axes = {}
    for word in words:
        name, equals, values = word.partition("=")
        if not (name.isidentifier() and equals and values):
            raise ValueError(f"Expected OPTION=V1,V2, got {word}. Write for instance window=21,41.")
        axes[name] = [_read_value(value) for value in values.split(",")]
    return [dict(zip(axes, values, strict=True)) for values in product(*axes.values())]


def _read_value(text: str) -> Any:
    try:
        return ast.literal_eval(text)
    except (SyntaxError, ValueError):
        return text


def validation_views(tree: Path, count: int) -> list[Any]:
    """Up to ``count`` views, evenly over the validation rooms of a tree.

    Raises
    ------
    ValueError
        If the tree has no validation rooms (a test room alone, for instance).
    """
    from cmtof.scenes.hypersim import Hypersim

    views = Hypersim(tree).split()["val"]
    if not views:
        raise ValueError(
            f"Expected validation rooms in {tree}, got none. Tune on the tree that was trained on."
        )
    count = min(count, len(views))
    return [views[i * len(views) // count] for i in range(count)]


def score_grid(
    method: str, grid: Sequence[dict[str, Any]], frames: Sequence[Any], protocol: str, seed: int
) -> Iterator[dict[str, float]]:
    """Scores of a method for each setting of its options."""
    from cmtof.evaluation import Evaluation

    for options in grid:
        contest = Evaluation([method], protocol=protocol, seed=seed, options={method: options})
        yield contest.add_all(frames).report()["methods"][method]


def main(arguments: Sequence[str] | None = None) -> int:
    """Score and print; return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("method")
    parser.add_argument("options", nargs="*", metavar="OPTION=V1,V2")
    parser.add_argument("--data", type=Path, required=True, metavar="TREE")
    parser.add_argument("--protocol", choices=("released", "full"), default="released")
    parser.add_argument("--views", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1, help="of the noise; tests use 0")
    said = parser.parse_intermixed_args(arguments)
    try:
        grid = read_grid(said.options)
        frames = [view.frame() for view in validation_views(said.data, max(1, said.views))]
        print(f"{len(frames)} views, {said.protocol}:", *RATES, "seconds", flush=True)
        scores = score_grid(said.method, grid, frames, said.protocol, said.seed)
        for options, rates in zip(grid, scores, strict=True):
            told = " ".join(f"{name}={value}" for name, value in options.items())
            percent = " ".join(f"{100 * rates[name]:5.1f}" for name in RATES)
            print(f"{told:32} {percent}  {rates['seconds_per_frame']:.2f}", flush=True)
    except (OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
