"""Keep the two halves of every notebook the same: the text is the source, the .ipynb follows.

python tools/pairs.py          write each .ipynb that is missing or differs
python tools/pairs.py --check  only tell, and exit 1 if one is missing or differs
"""

import sys
from pathlib import Path
from typing import Any

import jupytext
import nbformat

ROOT = Path(__file__).resolve().parents[1]

KERNEL = {"display_name": "Python 3", "language": "python", "name": "python3"}
# the metadata that a pair shares; anything else is some editor's
CELL_KEYS = {"tags", "mystnb"}
NOTEBOOK_KEYS = {"cmtof", "jupytext", "kernelspec"}


def notebook_from_script(script: Path) -> nbformat.NotebookNode:
    """Return the notebook of a percent-format script, without outputs, the same on every run."""
    notebook: Any = jupytext.read(script)
    notebook.metadata = nbformat.NotebookNode(
        {k: v for k, v in notebook.metadata.items() if k in NOTEBOOK_KEYS}
    )
    notebook.metadata["kernelspec"] = KERNEL
    notebook.metadata.pop("jupytext", None)
    for number, cell in enumerate(notebook.cells):
        cell["id"] = f"cell-{number:02d}"
        cell["metadata"] = {k: v for k, v in cell.metadata.items() if k in CELL_KEYS}
    notebook.nbformat, notebook.nbformat_minor = 4, 5
    nbformat.validate(notebook)
    return notebook


def same(script: Path, notebook: Path) -> bool:
    """Tell whether a pair holds the same cells, and the notebook no output."""
    if not notebook.is_file():
        return False
    ours, theirs = notebook_from_script(script), nbformat.read(notebook, as_version=4)
    return _cells(ours) == _cells(theirs) and not any(c.get("outputs") for c in theirs.cells)


def _cells(notebook: nbformat.NotebookNode) -> list[tuple[str, str, dict[str, Any]]]:
    return [
        (
            cell.cell_type,
            cell.source.strip(),
            {k: v for k, v in cell.metadata.items() if k in CELL_KEYS},
        )
        for cell in notebook.cells
    ]


def main(mode: str) -> int:
    """Write, or with ``--check`` only name, every pair that is not the same; give the exit code."""
    check = mode == "--check"
    stale = [
        (script, script.with_suffix(".ipynb"))
        for script in sorted((ROOT / "notebooks").glob("[0-9][0-9]_*.py"))
        if not same(script, script.with_suffix(".ipynb"))
    ]
    for script, notebook in stale:
        print(f"{'differs' if check else 'written'}: {notebook.relative_to(ROOT)}")
        if not check:
            part = notebook.with_name(f".{notebook.name}.part")
            nbformat.write(notebook_from_script(script), part)
            part.replace(notebook)
    return 1 if check and stale else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else ""))
