"""Accept the figures of a build, and its scoreboard: copy them into the folder that is committed.

python -m cmtof_book.figures RESULTS FIGURES

Prints the name of every figure. A figure that no notebook draws any more is removed. One that was
drawn from measured data stays where a machine without those data draws a simulated one instead.
"""

import shutil
from pathlib import Path

import typer

from cmtof_book.provenance import read_json, write_json
from cmtof_book.record import read_all
from cmtof_book.scoreboard import accepted_scores, scores_in

SUFFIXES = {".svg", ".png", ".json"}


def main(results: Path, figures: Path) -> None:
    """Make ``figures`` hold the figures of the chapters' folders in ``results``, and the scores."""
    drawn = {
        file.name: file
        for file in results.glob("*/*_*")  # other records have plain names
        if file.suffix in SUFFIXES
    }
    for file in figures.glob("*_*"):
        if file.name not in drawn:
            file.unlink()
    for name, file in sorted(drawn.items()):
        if (source_of(figures / name), source_of(file)) != ("measured", "simulated"):
            shutil.copyfile(file, figures / name)
            print(name)
    write_json(
        figures / "scoreboard.json", accepted_scores(scores_in(read_all(results)))
    )


def source_of(figure: Path) -> str | None:
    """Source of a figure's data, such as ``measured``, from the JSON beside it, if stated."""
    return read_json(figure.with_suffix(".json")).get("numbers", {}).get("source")


if __name__ == "__main__":
    typer.run(main)
