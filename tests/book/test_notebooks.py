"""The notebooks as a reader of JupyterLab has them, and the way from there to the page."""

import re
import shutil
from statistics import median

import jupytext
import nbformat
from jupyter_server.services.contents.largefilemanager import LargeFileManager
from jupytext.sync_contentsmanager import build_sync_jupytext_contents_manager_class
from pytest import mark

from cmtof_book import ROOT, pairs
from cmtof_book.graph import parameters_from_text
from cmtof_book.markdown import myst

SCRIPTS = sorted((ROOT / "notebooks").glob("[0-9]*.py"))


@mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_text_has_no_roles(script):
    texts = [c.source for c in jupytext.read(script).cells if c.cell_type == "markdown"]
    assert not re.findall(r"(?m)\{[a-z:]+\}`|:label:|^\(.*\)=$|^:::", "\n".join(texts))


def test_visible_cells_are_short():
    seen = [
        c
        for script in SCRIPTS
        for c in pairs.notebook_from_script(script).cells
        if c.cell_type == "code" and "jupyter" not in c.metadata
    ]
    lines = [len(re.findall(r"\S.*", cell.source)) for cell in seen]
    assert median(lines) <= 8
    assert max(lines) <= 20


def test_saving_in_jupyterlab_changes_nothing_but_outputs(tmp_path):
    script = SCRIPTS[0]
    notebook = script.with_suffix(".ipynb")
    for file in (ROOT / "jupytext.toml", script, notebook):
        shutil.copy(file, tmp_path)
    manager = build_sync_jupytext_contents_manager_class(LargeFileManager)(
        root_dir=str(tmp_path)
    )
    opened = manager.get(notebook.name)
    run = next(cell for cell in opened["content"].cells if cell.cell_type == "code")
    run.outputs = [nbformat.v4.new_output("stream", text="done\n")]
    manager.save(opened, notebook.name)
    assert (tmp_path / script.name).read_text("utf-8") == script.read_text("utf-8")
    saved = nbformat.read(tmp_path / notebook.name, 4)
    assert sum(len(cell.get("outputs", [])) for cell in saved.cells) == 1
    plain = nbformat.read(notebook, 4)
    old, new = (
        [(c.source, c.metadata.get("jupyter")) for c in n.cells] for n in (plain, saved)
    )
    assert new == old


@mark.parametrize(
    ("plain", "page"),
    [
        ("$$\nx = 1,\n\\tag{8}$$", "```{index} ! Eq. 8\n```\n$$\nx = 1,\n$$ (eq-8)"),
        ("$$y\n\\tag{17.1}$$", "```{index} ! Eq. 17.1\n```\n$$y\n$$ (eq-17.1)"),
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
    given = parameters_from_text(
        'repeats=6 distance=1.5e-1 "methods=[beat, mrf]" name=still_life'
    )
    assert given == {
        "repeats": 6,
        "distance": 0.15,
        "methods": ["beat", "mrf"],
        "name": "still_life",
    }
