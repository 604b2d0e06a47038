"""The one way that a notebook's numbers take: into records, and from there to whoever reads them.

A record is a JSON file in the folder of a run. It holds ``numbers`` by name, and the run that made
them. There is one for each figure (`cmtof_book.plotting.save`), one for what was checked against
the paper (`cmtof_book.paper.check`), and one for what the text shows (`cmtof_book.notes`). A
number is plain, or has a kind (`cmtof_book.compared`), and then tests compare it with a stored one.
The accepted figures, the scoreboard and the tests read records and nothing else.
"""

from pathlib import Path
from typing import Any, NamedTuple

from cmtof.types import Fields, Named
from cmtof_book import provenance

PAPER = "paper"  # name of the record of what a chapter checked against the paper

TEXT = "text"  # name of the record of what a chapter's text shows

# Numbers that this process has added, by folder and name: in JupyterLab chapters share a folder.
_HELD: Fields = {}


class Record(NamedTuple):
    """Numbers of one figure, or of one chapter's checks or text, by name."""

    chapter: str
    name: str
    content: Fields

    @property
    def numbers(self) -> Fields:
        """Numbers, plain or as a mapping that says the kind."""
        return self.content["numbers"]


def show(content: Fields, kind: str, **about: Any) -> None:
    """Show an output of a notebook, with what `cmtof_book.stage` needs to place it on the page."""
    from IPython.display import display

    display(content, raw=True, metadata={"cmtof": {"kind": kind, **about}})


def write(name: str, numbers: Named, **about: Any) -> None:
    """Write a record, with what else there is to say about it, whole or not at all."""
    provenance.write_json(
        provenance.output_folder() / f"{name}.json",
        {**about, "numbers": numbers, "provenance": provenance.RUN},
    )


def add(name: str, numbers: Named) -> None:
    """Add numbers to a record, which is made if need be."""
    read(name).update(numbers)
    write(name, read(name))


def read(name: str) -> Fields:
    """Numbers of a record of this run, {} where there is none."""
    return _HELD.setdefault(f"{provenance.output_folder()}/{name}", {})


def read_all(results: Path) -> list[Record]:
    """Every record of a build, whose chapters have a folder each."""
    return [
        Record(path.parent.name, path.stem, provenance.read_json(path))
        for path in sorted(results.glob("*/*.json"))
    ]
