"""The notebooks as a reader of JupyterLab has them, and the way from there to the page."""

import re
import shutil
from pathlib import Path
from statistics import median

import jupytext
import nbformat
import pytest
from jupyter_server.services.contents.largefilemanager import LargeFileManager
from jupytext.sync_contentsmanager import build_sync_jupytext_contents_manager_class

from cmtof_book.graph import parameters_from_text
from cmtof_book.markdown import myst

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = sorted((ROOT / "notebooks").glob("[0-9]*.py"))


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_text_has_no_roles(script):
    texts = [c.source for c in jupytext.read(script).cells if c.cell_type == "markdown"]
    assert not re.findall(r"\{[a-z:]+\}`|:label:|^\(.*\)=$|^:::", "\n".join(texts), re.M)


def test_visible_cells_are_short():
    cells = [cell for script in SCRIPTS for cell in jupytext.read(script).cells]
    hidden = {"hide-input", "hide-cell"}
    seen = [
        c for c in cells if c.cell_type == "code" and not hidden & set(c.metadata.get("tags", []))
    ]
    lines = [len([line for line in cell.source.splitlines() if line.strip()]) for cell in seen]
    assert median(lines) <= 8
    assert max(lines) <= 20


def test_saving_in_jupyterlab_changes_nothing_but_outputs(tmp_path):
    stem = SCRIPTS[0].stem
    shutil.copy(ROOT / "jupytext.toml", tmp_path)
    for suffix in (".py", ".ipynb"):
        shutil.copy(ROOT / "notebooks" / f"{stem}{suffix}", tmp_path)
    before = (tmp_path / f"{stem}.py").read_text("utf-8")
    plain = nbformat.read(tmp_path / f"{stem}.ipynb", 4)
    manager = build_sync_jupytext_contents_manager_class(LargeFileManager)(root_dir=str(tmp_path))
    opened = manager.get(f"{stem}.ipynb")
    run = next(cell for cell in opened["content"].cells if cell.cell_type == "code")
    run.outputs = [nbformat.v4.new_output("stream", text="done\n")]
    manager.save(opened, f"{stem}.ipynb")
    assert (tmp_path / f"{stem}.py").read_text("utf-8") == before
    saved = nbformat.read(tmp_path / f"{stem}.ipynb", 4)
    assert sum(len(cell.get("outputs", [])) for cell in saved.cells) == 1
    for old, new in zip(plain.cells, saved.cells, strict=True):
        assert (old.source, old.metadata.get("jupyter")) == (
            new.source,
            new.metadata.get("jupyter"),
        )


@pytest.mark.parametrize(
    ("plain", "page"),
    [
        ("$$\nx = 1,\n\\tag{8}$$", "$$\nx = 1,\n$$ (eq-8)"),
        ("$$y\n\\tag{17.1}$$", "$$y\n$$ (eq-17.1)"),
        ("by [Eq. 8](05_simulation.ipynb#eq-8).", "by Eq. {eq}`eq-8`."),
        ("([Eq. 2.1](#eq-2.1))", "(Eq. {eq}`eq-2.1`)"),
        ("[erratum 6](22_errata.ipynb#erratum-6)", "{ref}`erratum 6 <erratum-6>`"),
        ("### 6 · Gain\ntext", "(erratum-6)=\n### 6 · Gain\ntext"),
        ("[Kay 1993](../book/references.bib#kay1993)", "{cite:t}`kay1993`"),
        ("[chapter 7](07_captures.ipynb)", "[chapter 7](07_captures.ipynb)"),
    ],
)
def test_pages_get_roles_from_links(plain, page):
    assert myst(plain) == page


def test_parameters_of_a_reader():
    given = parameters_from_text('repeats=6 distance=1.5e-1 "methods=[beat, mrf]" name=still_life')
    assert given == {
        "repeats": 6,
        "distance": 0.15,
        "methods": ["beat", "mrf"],
        "name": "still_life",
    }
    with pytest.raises(ValueError, match="Expected name=value, got repeats"):
        parameters_from_text("repeats")
