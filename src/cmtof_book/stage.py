"""Pages of the book that a build makes: notebooks, scoreboard, claims, provenance.

    python -m cmtof_book.stage BUILD STAGE NOTEBOOK...

``BUILD`` is ``build/PROFILE`` with the executed notebooks and their results. In ``STAGE``, whose
layout is that of the checkout, so that links to the source stay right, the Snakefile has put the
chapters before, the figures, and the points of figures and scenes.
"""

import re
import sys
from pathlib import Path
from typing import Any

import nbformat
from nbformat.v4 import new_code_cell, new_markdown_cell

from cmtof_book import Values, claims, laboratory, pages, scoreboard
from cmtof_book.markdown import myst
from cmtof_book.record import read_all

NUMBERS = "_static/numbers"  # of the figures, where the Snakefile puts them


def figure_cell(output: Any, about: Values, stem: str) -> Any:
    """A cell of its own for a saved figure, numbered, with its caption and how to get at it."""
    name = about["name"]
    paper = re.match(r"(fig|table)0*(\d+)_", name)
    text = pages.page("caption", about=about, stem=stem, paper=paper, folder=NUMBERS)
    figure = {"caption": myst(text), "name": f"fig-{name}".replace("_", "-")}
    metadata = {
        "tags": ["remove-input", *["hide-output"] * about["folded"]],
        "mystnb": {"figure": figure, "image": {"alt": about["alt"]}},
    }
    return new_code_cell("# continued", outputs=[output], metadata=metadata)


def place_shown(notebook: Any, stem: str) -> None:
    """Make every saved figure, and every sentence that a run has written, a cell of its own.

    The answer is repeated behind the first paragraph, which asks for it. What a reader moves needs
    no frame on a page.
    """
    cells: list[Any] = []
    for cell in notebook.cells:
        if "injected-parameters" in cell.metadata.get("tags", []):
            continue  # they stand at the end of the page
        shown = []
        for output in [*cell.get("outputs", ())]:
            about = output.get("metadata", {}).pop("cmtof", {"kind": ""})
            kind = about["kind"]
            if kind == "page":
                output.data["text/html"] = about["html"]
            elif kind:
                cell.outputs.remove(output)
            if kind == "figure":
                shown.append(figure_cell(output, about, stem))
            elif kind in ("text", "answer"):
                text = output.data["text/markdown"]
                shown.append(new_markdown_cell(text))
                if kind == "answer":
                    paragraphs = cells[0].source.split("\n\n")
                    paragraphs.insert(2, text)
                    cells[0].source = "\n\n".join(paragraphs)
        if not cell.source.startswith(("notes.say", "notes.answer")):
            cells.append(cell)
        cells += shown
    notebook.cells = cells


def lead_with_figure(notebook: Any) -> None:
    """Move the first figure to behind the introduction."""
    cells = notebook.cells
    figures = [
        n for n, c in enumerate(cells) if "figure" in c.metadata.get("mystnb", {})
    ]
    if figures:
        cells.insert(1, cells.pop(figures[0]))


def stage_notebook(executed: Path, target: Path) -> None:
    """Write the page of an executed notebook."""
    notebook: Any = nbformat.read(executed, as_version=4)
    place_shown(notebook, executed.stem)
    lead_with_figure(notebook)
    about = pages.page("provenance", **notebook.metadata.pop("cmtof"))
    notebook.cells.append(new_markdown_cell(about))
    for number, cell in enumerate(notebook.cells):
        if cell.cell_type == "markdown":
            cell.source = myst(cell.source)
        cell["id"] = f"cell-{number:02d}"
    nbformat.write(notebook, target)


def main(build: Path, stage: Path, *notebooks: Path) -> None:
    """Add the pages of ``build``, executed notebooks among them, to the chapters in ``stage``."""
    for executed in notebooks:
        stage_notebook(executed, stage / "notebooks" / executed.name)
    records = list(read_all(build / "results"))
    scores = scoreboard.scores_in(records)
    texts = {"scoreboard": scoreboard.page(scores)} | claims.texts(scores, records)
    for name, text in texts.items():
        (stage / "book" / f"{name}.md").write_text(text, "utf-8")
    laboratory.write(stage / "book" / "_static" / "laboratory")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
