"""Count methods over all test frames and store the counts where the chapters find them.

    python -m cmtof_book.tables [--protocol released|full] [--noise SIGMA] [--size 768x1024]
                                [--offset LOW HIGH] [METHOD...]
    python -m cmtof_book.tables --runs FOLDER

Without names: every method and reference. Only methods that are new or have other weights are
counted; without its file a table is counted again. With ``--runs`` weights are counted by their
folders' names. With ``--size`` the test views are rendered at that size first; ``--offset`` adds to
the phases of the two frequencies, mrad (Table 3). The file is named by table and options.
"""

import json
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import typer

from cmtof_book import RESULTS, THREADS

for variable in THREADS:
    os.environ.setdefault(variable, "1")  # before NumPy and torch are loaded

from cmtof import __version__  # noqa: E402
from cmtof.evaluation import Evaluation, digest  # noqa: E402
from cmtof.files import atomic_output  # noqa: E402
from cmtof.frame import Frame, held_out_frames  # noqa: E402
from cmtof.methods import METHODS, find_method  # noqa: E402
from cmtof.network.weights import read_card, weights_path  # noqa: E402
from cmtof.types import Fields, Pair, Texts  # noqa: E402
from cmtof_book.provenance import read_json  # noqa: E402
from cmtof_rooms.held_out import views_of_size  # noqa: E402
from cmtof_rooms.rendering import shape_from_text  # noqa: E402


class Row(NamedTuple):
    """A row of a table: its name, its method, and the file of its weights, if it has any."""

    name: str
    method: str
    file: Path

    @property
    def weights(self) -> Texts:
        """Hash of the weights by the row's name, {} for none."""
        return {self.name: read_card(self.file).sha256} if self.file.is_file() else {}


def rows_of(methods: Sequence[str], protocol: str, runs: Path | None) -> list[Row]:
    """A row for each training in a folder, or each method.

    Without names: the methods that are ready, and the references.
    """
    if runs:
        files = sorted(runs.glob(f"*/*.{protocol}.safetensors"))
        return [Row(file.parent.name, read_card(file).model, file) for file in files]
    named = map(find_method, methods or METHODS)
    return [
        Row(one.name, one.name, weights_path(one.network, protocol))
        for one in named
        if methods or one.state(protocol) not in ("untrained", "no weights")
    ]


def is_counted(row: Row, held: Fields) -> bool:
    """Whether a stored table has a row already, counted with the same weights."""
    same = row.weights.items() <= held["weights"].items()
    return same and any(row.name in frame["methods"] for frame in held["frames"])


def count(held: Fields, row: Row, frames: Iterable[Frame]) -> None:
    """Join the counts of a method over all frames with those of the others."""
    evaluation = Evaluation([row.method], **held["settings"])
    if row.weights:
        held["weights"] |= row.weights
        evaluation.options = {"weights": row.file}
    counts = evaluation.add_all(frames).counts()
    held["frames"] = held["frames"] or counts
    for old, new in zip(held["frames"], counts, strict=True):
        old["methods"][row.name] = new["methods"].pop(row.method)
    print(row.name, evaluation.report()["methods"][row.method], flush=True)


def write(held: Fields, path: Path) -> None:
    """Store counts, one frame a line, with their hash."""
    held |= {"version": __version__, "sha256": digest(held["frames"])}
    text = json.dumps(held).replace('{"frame": ', '\n{"frame": ')
    with atomic_output(path) as part:
        part.write_text(text + "\n", "utf-8")


def main(
    methods: Annotated[
        list[str], typer.Argument(metavar="METHOD", default_factory=list)
    ],
    protocol: Literal["released", "full"] = "released",
    noise: float = 1200.0,
    runs: Path | None = None,
    size: str = "",
    offset: Pair = (0.0, 0.0),
) -> None:
    """Count methods over all test frames and store the counts."""
    settings: Fields = {"protocol": protocol, "noise": noise, "seed": 0}
    number = 1 if runs else 3 if any(offset) else 2
    words = [f"table{number}", protocol, size, f"{noise:g}"]
    if any(offset):
        settings["phase_offset"] = [phase / 1e3 for phase in offset]
        words += [f"{phase:g}" for phase in offset]
    path = RESULTS / f"{'_'.join(filter(None, words))}.json"
    held = read_json(path)
    if held.get("settings") != settings:
        held = {"settings": settings, "size": size, "weights": {}, "frames": []}
    rows = [
        row for row in rows_of(methods, protocol, runs) if not is_counted(row, held)
    ]
    if rows:
        frames = views_of_size(*shape_from_text(size)) if size else held_out_frames()
        for row in rows:
            count(held, row, frames)
            if runs:
                held.setdefault("cards", {})[row.name] = read_card(row.file).model_dump(
                    exclude={"sha256"}
                )
            write(held, path)


if __name__ == "__main__":
    typer.run(main)
