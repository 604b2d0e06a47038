"""Count methods over all test frames and store the counts where the chapters find them.

    python -m cmtof_book.tables [--protocol released|full] [--noise SIGMA] [--again] [METHOD...]
    python -m cmtof_book.tables --runs FOLDER

Without names: every method and reference. Only methods that are new or have other weights are
counted, unless ``--again`` is given. With ``--runs`` weights are counted by their folders' names.
"""

import argparse
import hashlib
import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

RESULTS = Path(__file__).resolve().parents[2] / "book" / "results"


def main(arguments: Sequence[str] | None = None) -> None:
    """Count and store."""
    given = options(arguments)
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # before NumPy and torch are loaded
    from cmtof.evaluation import Evaluation
    from cmtof.frame import held_out_frames

    settings = {"protocol": given.protocol, "noise": given.noise, "seed": 0}
    path = given.into / f"table{1 if given.runs else 2}_{given.protocol}_{given.noise:g}.json"
    held = stored_counts(path, settings, runs=given.runs is not None)
    frames = held_out_frames()
    for row in rows_of(given):
        if row.counted_in(held) and not given.again:
            continue
        evaluation = Evaluation([row.method], **settings)
        if row.weights:
            held["weights"][row.name] = row.weights
            evaluation.options = {"weights": row.file}
        add(held, row.name, evaluation.add_all(frames))
        if given.runs:
            held["cards"][row.name] = row.card().model_dump(exclude={"sha256"})
        write(held, path)


def options(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Options of the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("methods", nargs="*", metavar="METHOD")
    parser.add_argument("--protocol", default="released", choices=("released", "full"))
    parser.add_argument("--noise", type=float, default=1200.0, help="Gaussian sigma, counts")
    parser.add_argument("--again", action="store_true", help="count these methods again")
    parser.add_argument("--runs", type=Path, help="folder of trainings")
    parser.add_argument("--into", type=Path, default=RESULTS, help="folder of the counts")
    return parser.parse_args(arguments)


class Row(NamedTuple):
    """A row of a table: its name, its method, and the file of its weights, if it has any."""

    name: str
    method: str
    file: Path

    @property
    def weights(self) -> str:
        """Hash of the weights, or ''."""
        return hashlib.sha256(self.file.read_bytes()).hexdigest() if self.file.is_file() else ""

    def card(self) -> Any:
        """Card of the weights."""
        from cmtof.network.weights import read_card

        return read_card(self.file)

    def counted_in(self, held: dict[str, Any]) -> bool:
        """Whether these weights were counted before."""
        if not held["frames"] or self.name not in held["frames"][0]["methods"]:
            return False
        return held["weights"].get(self.name, "") == self.weights


def rows_of(given: argparse.Namespace) -> list[Row]:
    """Rows that the options ask for: methods, or the trainings of a folder."""
    from cmtof.methods import METHODS, find_method, names_of
    from cmtof.network.weights import read_card, weights_path

    if given.runs:
        files = sorted(given.runs.glob(f"*/*.{given.protocol}.safetensors"))
        return [Row(file.parent.name, read_card(file).model, file) for file in files]
    references = [name for name, method in METHODS.items() if method.kind == "reference"]
    names = given.methods or [*names_of("all", given.protocol), *references]
    names = [find_method(name).name for name in names]
    return [Row(name, name, weights_path(name, given.protocol)) for name in names]


def stored_counts(path: Path, settings: dict[str, Any], *, runs: bool) -> dict[str, Any]:
    """Counts of a file, or an empty store where it is missing or has other settings."""
    if path.is_file():
        held = json.loads(path.read_text("utf-8"))
        if held["settings"] == settings:
            return held
    command = (
        f"python -m cmtof_book.tables --protocol {settings['protocol']} "
        f"--noise {settings['noise']:g}{' --runs FOLDER' if runs else ''}"
    )
    return {"command": command, "settings": settings, "weights": {}, "cards": {}, "frames": []}


def add(held: dict[str, Any], name: str, evaluation: Any) -> None:
    """Join the counts of a method over all frames with those of the others, under a name."""
    counts = evaluation.counts()
    ((method, scores),) = evaluation.report()["methods"].items()
    old = held["frames"] or [{"methods": {}} for _ in counts]
    held["frames"] = [
        new | {"methods": before["methods"] | {name: new["methods"][method]}}
        for before, new in zip(old, counts, strict=True)
    ]
    print(name, {key: round(rate, 4) for key, rate in scores.items()}, flush=True)


def write(held: dict[str, Any], path: Path) -> None:
    """Store counts, one frame a line, with their hash."""
    from cmtof import __version__
    from cmtof.evaluation import digest
    from cmtof.files import written_whole

    frames = ",\n".join(json.dumps(frame) for frame in held["frames"])
    head = {key: part for key, part in held.items() if key != "frames"}
    head |= {"version": __version__, "sha256": digest(held["frames"])}
    with written_whole(path) as part:
        part.write_text(json.dumps(head)[:-1] + f',\n"frames": [\n{frames}\n]}}\n', "utf-8")


if __name__ == "__main__":
    main()
