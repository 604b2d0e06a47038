"""Keep the two halves of every notebook the same: the text is the source, the .ipynb follows.

What is folded on the page is folded in JupyterLab too.

python -m cmtof_book.pairs          write each .ipynb that is missing or differs
python -m cmtof_book.pairs --newer  take over what was changed in the .ipynb alone, as by an editor
"""

import sys
from pathlib import Path
from typing import Any

import jupytext
import nbformat
from jupytext.cli import jupytext as jupytext_cli

from cmtof.files import atomic_output
from cmtof_book import ROOT

KERNEL = {"display_name": "Python 3", "language": "python", "name": "python3"}
# What JupyterLab folds by a tag that folds it on the page.
FOLDED = {
    "hide-input": {"source_hidden": True},
    "hide-cell": {"source_hidden": True, "outputs_hidden": True},
}


def notebook_from_script(script: Path) -> nbformat.NotebookNode:
    """Return the notebook of a percent-format script, without outputs, the same on every run."""
    notebook: Any = jupytext.read(script)
    notebook.metadata = nbformat.from_dict({"kernelspec": KERNEL})
    for number, cell in enumerate(notebook.cells):
        cell["id"] = f"cell-{number:02d}"
        cell.metadata.pop("lines_to_next_cell", None)  # jupytext's note on the text
        if folded := FOLDED.keys() & cell.metadata.get("tags", []):
            cell.metadata["jupyter"] = FOLDED[min(folded)]
    nbformat.validate(notebook)
    return notebook


def is_up_to_date(script: Path) -> bool:
    """Tell whether the notebook is the one that follows from the script, without outputs."""
    notebook = script.with_suffix(".ipynb")
    return notebook.is_file() and nbformat.read(notebook, 4) == notebook_from_script(
        script
    )


def take_newer(script: Path) -> None:
    """Write the script again where the cells of the notebook differ and are younger."""
    notebook = script.with_suffix(".ipynb")
    if notebook.is_file() and notebook.stat().st_mtime > script.stat().st_mtime:
        old = [cell.source for cell in notebook_from_script(script).cells]
        if old != [cell.source for cell in nbformat.read(notebook, 4).cells]:
            jupytext_cli(["--sync", "--quiet", str(notebook)])


def main(*, newer: bool) -> None:
    """Write each stale .ipynb, or take over the newer ones."""
    for script in sorted((ROOT / "notebooks").glob("[0-9][0-9]_*.py")):
        if newer:
            take_newer(script)
        elif not is_up_to_date(script):
            with atomic_output(script.with_suffix(".ipynb")) as part:
                nbformat.write(notebook_from_script(script), part)
            print(f"written: {script.stem}.ipynb")


if __name__ == "__main__":
    main(newer="--newer" in sys.argv)
