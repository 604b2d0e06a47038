"""Count methods over all test frames and store the counts where the chapters find them.

    python -m cmtof_book.tables [--protocol released|full] [--noise SIGMA] [--size 768x1024]
                                [--offset LOW HIGH] [METHOD...]
    python -m cmtof_book.tables --runs FOLDER

Without names: every method and reference that is not yet counted. With ``--runs`` weights are
counted by their folders' names. With ``--size`` the test views are rendered at that size first;
``--offset`` adds to the phases of the two frequencies, mrad (Table 3). The file is named by table
and options.
"""

import json
from itertools import zip_longest
from pathlib import Path
from typing import Annotated, Literal

import typer

from cmtof import __version__
from cmtof.evaluation import Evaluation, digest
from cmtof.files import written_whole
from cmtof.frame import held_out_frames
from cmtof.methods import METHODS, find_method, names_of
from cmtof.network.weights import read_card, weights_path
from cmtof_book import RESULTS, Values
from cmtof_book.frames import views_of_size
from cmtof_book.provenance import read_json
from cmtof_rooms.rendering import shape_from_text


def files_of_rows(
    methods: list[str], protocol: str, runs: Path | None
) -> dict[str, Path]:
    """Weights of each row, a training or a method; those of a method may be missing."""
    if runs:
        files = sorted(runs.glob(f"*/*.{protocol}.safetensors"))
        return {file.parent.name: file for file in files}
    references = [name for name, one in METHODS.items() if one.kind == "reference"]
    asked = map(find_method, methods or [*names_of("all", protocol), *references])
    return {one.name: weights_path(one.network, protocol) for one in asked}


def count(held: Values, row: str, file: Path, *, is_run: bool) -> None:
    """Join the counts of a row over all frames with those of the others."""
    size = held["size"]
    frames = views_of_size(*shape_from_text(size)) if size else held_out_frames()
    method = row
    options: Values = {}
    if file.is_file():
        card = read_card(file)
        held.setdefault("weights", {})[row] = card.sha256
        options["weights"] = file
        if is_run:
            method = card.model
            about = card.model_dump(exclude={"sha256"})
            held.setdefault("cards", {})[row] = about
    evaluation = Evaluation([method], **held["settings"])
    evaluation.options = options
    counts = evaluation.add_all(frames).counts()
    for new, old in zip_longest(counts, held["frames"], fillvalue={"methods": {}}):
        new["methods"] = old["methods"] | {row: new["methods"][method]}
    held |= {"frames": counts, "version": __version__, "sha256": digest(counts)}
    print(row, evaluation.report()["methods"], flush=True)


def write(held: Values, path: Path) -> None:
    """Store counts, one frame a line."""
    text = json.dumps(held).replace('{"frame": ', '\n{"frame": ')
    with written_whole(path) as part:
        part.write_text(text + "\n", "utf-8")


def main(
    methods: Annotated[
        list[str], typer.Argument(metavar="METHOD", default_factory=list)
    ],
    protocol: Literal["released", "full"] = "released",
    noise: float = 1200.0,
    runs: Path | None = None,
    size: str = "",
    offset: tuple[float, float] = (0.0, 0.0),
) -> None:
    """Count methods over all test frames and store the counts."""
    settings: Values = {"protocol": protocol, "noise": noise, "seed": 0}
    words = ["table1" if runs else "table2", protocol, size, f"{noise:g}"]
    if any(offset):
        settings["phase_offset"] = [phase / 1e3 for phase in offset]
        words = ["table3", *words[1:], *(f"{phase:g}" for phase in offset)]
    path = RESULTS / f"{'_'.join(filter(None, words))}.json"
    held = read_json(path) or {"settings": settings, "size": size, "frames": []}
    counted = held["frames"][0]["methods"] if held["frames"] else ()
    for row, file in files_of_rows(methods, protocol, runs).items():
        if methods or row not in counted:
            count(held, row, file, is_run=bool(runs))
            write(held, path)


if __name__ == "__main__":
    typer.run(main)
