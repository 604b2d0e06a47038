"""Lay out what the book is built from: chapters, executed notebooks, scoreboard, provenance.

    python -m cmtof_book.stage BUILD STAGE

``BUILD`` is ``build/PROFILE`` with the executed notebooks and their results. The layout of
``STAGE`` is that of the checkout, so that links to the source stay right.
"""

import re
import shutil
import sys
from pathlib import Path
from typing import Any

import nbformat
from nbformat.v4 import new_code_cell, new_markdown_cell

from cmtof_book import claims, laboratory, scoreboard
from cmtof_book.graph import Book
from cmtof_book.markdown import myst
from cmtof_book.notes import SAID
from cmtof_book.record import read_all
from cmtof_book.views import STATIC

ROOT = Path(__file__).resolve().parents[2]

NUMBERS = "_static/numbers"  # of the figures, in the book


def caption(about: dict[str, Any], stem: str) -> str:
    """Caption of a figure with its number in the paper, and a line on how to get at it."""
    paper = re.match(r"(fig|table)0*(\d+)_", about["name"])
    title = f"**Paper {'Fig.' if paper[1] == 'fig' else 'Table'} {paper[2]}.** " if paper else ""
    return (
        f'{title}{about["caption"]}\n\n<a href="../{NUMBERS}/{about["name"]}.csv">numbers</a> · '
        f'<a href="../_sources/notebooks/{stem}.ipynb">notebook</a> · '
        f"`make figure F={about['name']}`"
    )


def place_figures(notebook: Any, stem: str) -> None:
    """Make every saved figure a cell of its own, with the metadata that number it.

    The source of the cell that drew it folds away.
    """
    cells: list[Any] = []
    for cell in notebook.cells:
        cells.append(cell)
        drawn = [o for o in cell.get("outputs", []) if "cmtof" in o.get("metadata", {})]
        if drawn:  # how it was drawn is for whoever wants to know
            cell.metadata["tags"] = sorted({*cell.metadata.get("tags", []), "hide-input"})
        for output in drawn:
            cell.outputs.remove(output)
            cells.append(new_code_cell("# continued", outputs=[output]))
            about = output.metadata.pop("cmtof")
            name = "fig-" + about["name"].replace("_", "-")
            figure = {"caption": caption(about, stem), "name": name}
            placed = {"figure": figure, "image": {"alt": about["alt"]}}
            cells[-1].metadata |= {"tags": ["remove-input"], "mystnb": placed}
    notebook.cells = cells


def place_sentences(notebook: Any) -> None:
    """Make every sentence that a run has written a cell of text; repeat the answer at the head."""
    cells: list[Any] = []
    for cell in notebook.cells:
        outputs = cell.get("outputs", [])
        said = [output for output in outputs if SAID in output.get("metadata", {})]
        if not said or not cell.source.startswith("notes."):
            cells.append(cell)
        for output in said:
            outputs.remove(output)
            cells.append(new_markdown_cell(output.data["text/markdown"]))
            if output.metadata[SAID] == "answer":
                put_behind_question(cells, cells[-1].source)
    notebook.cells = cells


def put_behind_question(cells: list[Any], answer: str) -> None:
    """Insert the answer behind the first paragraph of the chapter, which asks for it."""
    head = next(cell for cell in cells if cell.cell_type == "markdown")
    title, question, *rest = head.source.split("\n\n")
    head.source = "\n\n".join([title, question, answer, *rest])


def lead_with_figure(notebook: Any) -> None:
    """Move the first figure to behind the introduction; a link stays where text stood between."""
    cells = notebook.cells
    place = next((n for n, c in enumerate(cells) if "figure" in c.metadata.get("mystnb", {})), 0)
    texts = [n for n, cell in enumerate(cells[:place]) if cell.cell_type == "markdown"]
    if texts:
        figure = cells.pop(place)
        cells.insert(texts[0] + 1, figure)
        if texts[1:]:
            name = figure.metadata["mystnb"]["figure"]["name"]
            seen = f"See {{numref}}`{name}` at the head of this chapter."
            cells.insert(place + 1, new_markdown_cell(seen))


def join_folded(notebook: Any) -> None:
    """Join neighbouring cells whose source is folded and that show nothing between into one."""
    cells: list[Any] = []
    for cell in notebook.cells:
        if "injected-parameters" in cell.metadata.get("tags", []):
            continue  # they stand at the end of the page
        before = cells[-1] if cells else None
        if before is not None and _is_folded(before) and _is_folded(cell) and not before.outputs:
            cell.source = f"{before.source}\n\n{cell.source}"
            cells.pop()
        cells.append(cell)
    notebook.cells = cells


def _is_folded(cell: Any) -> bool:
    return cell.cell_type == "code" and "hide-input" in cell.metadata.get("tags", [])


def provenance_block(about: dict[str, Any]) -> str:
    """Return the last block of a page: what was run, with what, when and for how long."""
    parameters = dict(about["parameters"])
    rows = {
        "profile": parameters.pop("profile"),
        "seed": parameters.pop("seed", ""),
        "parameters": ", ".join(f"{k} = {v}" for k, v in parameters.items()),
        "cmtof": about["version"] + (f", commit {about['commit']}" if about["commit"] else ""),
        "run": f"{about['date']}, {about['seconds']:.1f} s on one thread",
        "Python": about["python"],
        "libraries": ", ".join(f"{k} {v}" for k, v in about["libraries"].items()),
    }
    lines = "\n".join(f"| {key} | {value} |" for key, value in rows.items() if value != "")
    return (
        ":::{admonition} How this page was made\n:class: note provenance\n\n"
        f"| | |\n|---|---|\n{lines}\n:::"
    )


def stage_notebook(executed: Path, target: Path) -> None:
    """Write the page of an executed notebook."""
    notebook: Any = nbformat.read(executed, as_version=4)
    place_sentences(notebook)
    place_figures(notebook, executed.stem)
    lead_with_figure(notebook)
    join_folded(notebook)
    notebook.cells.append(new_markdown_cell(provenance_block(notebook.metadata.pop("cmtof"))))
    notebook.metadata.pop("papermill", None)
    for number, cell in enumerate(notebook.cells):
        if cell.cell_type == "markdown":
            cell.source = myst(cell.source)
        cell["id"] = f"cell-{number:02d}"
        for key in ("papermill", "execution"):
            cell.metadata.pop(key, None)
    nbformat.write(notebook, target)


def place_results(build: Path, stage: Path) -> None:
    """Copy scenes and the numbers of figures to where pages look for them; never committed."""
    for place, suffix in ((STATIC, "js"), (NUMBERS, "csv")):
        (stage / "book" / place).mkdir(parents=True, exist_ok=True)
        for file in build.glob(f"results/*/*_*.{suffix}"):
            shutil.copyfile(file, stage / "book" / place / file.name)


def place_claims(numbers: claims.Numbers, build: Path, book: Path) -> None:
    """Write what the first page includes, and a page for each claim with its figure beside it."""
    (book / "claims.md").write_text(claims.table(numbers), encoding="utf-8")
    (book / "findings.md").write_text(claims.findings(numbers), encoding="utf-8")
    (book / "claims").mkdir()
    for claim in claims.claims(numbers.scores):
        page = claims.page(claim, numbers)
        (book / "claims" / f"{claim.name}.md").write_text(page, encoding="utf-8")
        for drawn in build.glob(f"results/*/{claim.figure}.[sp][vn]g"):
            shutil.copyfile(drawn, book / "claims" / drawn.name)


def main(build: Path, stage: Path) -> None:
    """Lay out the book of ``build`` in ``stage``."""
    book = Book(ROOT)
    shutil.rmtree(stage, ignore_errors=True)
    (stage / "notebooks").mkdir(parents=True)
    for chapter in book.chapters():
        (stage / chapter).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / chapter, stage / chapter)
    for stem in book.notebooks():
        stage_notebook(build / "notebooks" / f"{stem}.ipynb", stage / "notebooks" / f"{stem}.ipynb")
    place_results(build, stage)
    laboratory.write(stage / "book" / "_static" / "laboratory")
    records = list(read_all(build / "results"))
    chapters = sorted((build / "notebooks").glob("*.ipynb"))
    scores = scoreboard.scores_in(records)
    page = scoreboard.page(scores, records, chapters)
    (stage / "book" / "scoreboard.md").write_text(page, encoding="utf-8")
    place_claims(claims.Numbers(scores, records), build, stage / "book")
    for name in re.findall(r"\w+\.(?:png|svg)$", (ROOT / "book/intro.md").read_text(), re.M):
        shutil.copyfile(next(build.glob(f"results/*/{name}")), stage / "book" / name)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
