"""Pages of the book that a build makes: notebooks, scoreboard, claims, provenance.

    python -m cmtof_book.stage BUILD STAGE NOTEBOOK...

``BUILD`` is ``build/PROFILE`` with the executed notebooks and their results. In ``STAGE``, whose
layout is that of the checkout, so that links to the source stay right, the Snakefile has put the
chapters before, the figures, the points of figures and scenes, and the laboratory's data.
"""

import re
import sys
from pathlib import Path
from typing import Any

import nbformat
from nbformat.v4 import new_code_cell, new_markdown_cell

from cmtof.types import Fields
from cmtof_book import claims, pages, scoreboard
from cmtof_book.markdown import myst
from cmtof_book.record import read_all


def figure_cell(output: Any, about: Fields, stem: str) -> Any:
    """A cell of its own for a saved figure, with the metadata that number it.

    The caption has its number in the paper, and a line on how to get at it.
    """
    caption = pages.page(
        "caption",
        about=about,
        stem=stem,
        paper=re.match(r"(fig|table)0*(\d+)_", about["name"]),
    )
    figure = {
        "caption": myst(caption),
        "name": "fig-" + about["name"].replace("_", "-"),
    }
    return new_code_cell(
        "# continued",
        outputs=[output],
        metadata={
            "tags": ["remove-input", *["hide-output"] * about["folded"]],
            "mystnb": {"figure": figure, "image": {"alt": about["alt"]}},
        },
    )


def place_shown(notebook: Any, stem: str) -> None:
    """Make every saved figure, and every sentence that a run has written, a cell of its own.

    The answer is repeated in the chapter's first cell. What a reader moves needs no frame.
    """
    cells = []
    for cell in notebook.cells:
        figures = []
        said = []
        for output in [*cell.get("outputs", ())]:
            about = output.get("metadata", {}).pop("cmtof", {"kind": ""})
            kind = about["kind"]
            if kind == "page":
                output.data["text/html"] = about["html"]
            elif kind:
                cell.outputs.remove(output)
            if kind == "figure":
                figures.append(figure_cell(output, about, stem))
            if kind in ("text", "answer"):
                said.append(new_markdown_cell(output.data["text/markdown"]))
            if kind == "answer":  # goes behind the first paragraph, which asks for it
                paragraphs = notebook.cells[0].source.split("\n\n")
                paragraphs.insert(2, said[-1].source)
                notebook.cells[0].source = "\n\n".join(paragraphs)
        if not said or not cell.source.startswith("notes."):
            cells.append(cell)
        cells += figures + said
    notebook.cells = cells


def lead_with_figure(notebook: Any) -> None:
    """Move the first figure to behind the introduction; a link stays where text stood between."""
    cells = notebook.cells
    for place, cell in enumerate(cells):
        if figure := cell.metadata.get("mystnb", {}).get("figure"):
            if any(one.cell_type == "markdown" for one in cells[1:place]):
                link = f"See {{numref}}`{figure['name']}` at the head of this chapter."
                cells.insert(place, new_markdown_cell(link))
            cells.remove(cell)
            cells.insert(1, cell)
            return


def join_folded(notebook: Any) -> None:
    """Join neighbouring cells whose source is folded and that show nothing between into one."""
    cells = []
    for cell in notebook.cells:
        if "injected-parameters" in _tags(cell):
            continue  # they stand at the end of the page
        folded = all("hide-input" in _tags(one) for one in (cell, *cells[-1:]))
        if cells and folded and not cells[-1].outputs:
            cell.source = f"{cells.pop().source}\n\n{cell.source}"
        cells.append(cell)
    notebook.cells = cells


def _tags(cell: Any) -> list[str]:
    return cell.metadata.get("tags", [])


def stage_notebook(executed: Path, target: Path) -> None:
    """Write the page of an executed notebook."""
    notebook: Any = nbformat.read(executed, as_version=4)
    place_shown(notebook, executed.stem)
    lead_with_figure(notebook)
    join_folded(notebook)
    notebook.cells.append(
        new_markdown_cell(pages.page("provenance", **notebook.metadata))
    )
    del notebook.metadata["cmtof"]
    for number, cell in enumerate(notebook.cells):
        if cell.cell_type == "markdown":
            cell.source = myst(cell.source)
        cell["id"] = f"cell-{number:02d}"
    nbformat.write(notebook, target)


def main(build: Path, stage: Path, *notebooks: Path) -> None:
    """Add the pages of ``build``, executed notebooks among them, to the chapters in ``stage``."""
    for executed in notebooks:
        stage_notebook(executed, stage / "notebooks" / executed.name)
    records = read_all(build / "results")
    scores = scoreboard.scores_in(records)
    texts = claims.texts(scores, records)
    texts["scoreboard"] = scoreboard.page(scores, records, notebooks)
    for name, text in texts.items():
        (stage / f"book/{name}.md").write_text(text, "utf-8")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
