"""What a notebook depends on, found on toy packages and on this one."""

from pathlib import Path

import pytest

import graph

ROOT = Path(__file__).resolve().parents[1]


def reached(root: Path, files: dict[str, str], entry: str) -> set[str]:
    """Write a package ``toy`` and return what the script ``entry`` reaches of it."""
    for name, text in files.items():
        path = root / "toy" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    script = root / "entry.py"
    script.write_text(entry)
    found = graph.closure(script, graph.Source(root, "toy"))
    return {str(path.relative_to(root / "toy")) for path in found}


PLAIN = {
    "__init__.py": "",
    "light.py": "from toy.speed import C\n",
    "speed.py": "C = 3e8\n",
    "noise.py": "def draw():\n    from . import light\n    return light\n",
    "lonely.py": "import numpy\n",
}


@pytest.mark.parametrize(
    ("entry", "expected"),
    [
        ("import numpy\n", set()),
        ("from toy import speed\n", {"__init__.py", "speed.py"}),
        ("import toy.light as l\n", {"__init__.py", "light.py", "speed.py"}),
        ("from toy.noise import draw\n", {"__init__.py", "noise.py", "light.py", "speed.py"}),
        ("def f():\n    import toy.speed\n", {"__init__.py", "speed.py"}),
        ("import toy\ntoy.light.C\n", {"__init__.py", "light.py", "speed.py"}),
        ("METHODS = ['toy.light:method', 'toy light']\n", {"__init__.py", "light.py", "speed.py"}),
    ],
)
def test_imports_are_followed_wherever_they_stand(tmp_path, entry, expected):
    assert reached(tmp_path, PLAIN, entry) == expected


LAZY = {
    "__init__.py": (
        "from importlib import import_module\n"
        "from typing import TYPE_CHECKING\n"
        "if TYPE_CHECKING:\n"
        "    from toy.simulation import simulate\n"
        "    from toy.store import open_file as open\n"
        "def __getattr__(name):\n    return import_module('toy.' + name)\n"
        "def helper():\n    from toy import extra\n    return extra\n"
    ),
    "simulation.py": "",
    "store.py": "",
    "extra.py": "",
    "other.py": "",
}


@pytest.mark.parametrize(
    ("entry", "expected"),
    [
        ("import toy\n", {"__init__.py"}),
        ("import toy\ntoy.simulate()\n", {"__init__.py", "simulation.py"}),
        ("import toy as t\nt.open()\n", {"__init__.py", "store.py"}),
        ("from toy import helper\n", {"__init__.py", "extra.py"}),
        ("import toy\ntoy.unknown()\n", set(LAZY)),
    ],
)
def test_a_lazy_package_is_followed_to_the_members_used(tmp_path, entry, expected):
    assert reached(tmp_path, LAZY, entry) == expected


REGISTRY = {
    "__init__.py": "",
    "methods/__init__.py": (
        "from importlib import import_module\n"
        "def get(name):\n    return import_module(f'toy.methods.{name}')\n"
    ),
    "methods/beat.py": "from toy import tools\n",
    "methods/crt.py": "",
    "tools.py": "",
    "other.py": "",
}


def test_loading_by_a_computed_name_takes_the_whole_folder(tmp_path):
    everything = reached(tmp_path, REGISTRY, "from toy.methods import get\n")
    assert everything == set(REGISTRY) - {"other.py"}


def test_data_named_by_a_module_belongs_to_it(tmp_path):
    files = {
        "__init__.py": "",
        "board.py": "NAME = 'board.yml'\n",
        "board.yml": "",
        "scenes.py": "FOLDER = 'frames'\n",
        "frames/a.npz": "",
    }
    assert reached(tmp_path, files, "from toy import board\n") == {
        "__init__.py",
        "board.py",
        "board.yml",
    }
    assert "frames/a.npz" in reached(tmp_path, files, "from toy import scenes\n")


def test_touching_one_module_concerns_only_who_reaches_it(tmp_path):
    scripts = {
        "a": "from toy import light\n",
        "b": "from toy import lonely\n",
    }
    concerned = {
        name for name, text in scripts.items() if "speed.py" in reached(tmp_path, PLAIN, text)
    }
    assert concerned == {"a"}


def checkout(root: Path, toc: str = "") -> graph.Book:
    (root / "notebooks").mkdir()
    (root / "configs").mkdir()
    (root / "notebooks" / "01_one.py").write_text("# # One\n")
    (root / "_toc.yml").write_text(toc or "root: book/intro\nchapters: [{file: notebooks/01_one}]")
    (root / "configs" / "ci.yml").write_text("notebooks: {01_one: {samples: 5}}\n")
    return graph.Book(root)


def test_a_profile_sets_its_slice_and_its_name(tmp_path):
    assert checkout(tmp_path).parameters("01_one", "ci") == {"samples": 5, "profile": "ci"}


def test_an_unknown_profile_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match="'nix'"):
        checkout(tmp_path).parameters("01_one", "nix")


def test_a_profile_that_names_no_notebook_is_refused(tmp_path):
    book = checkout(tmp_path)
    (tmp_path / "configs" / "ci.yml").write_text("notebooks: {01_on: {samples: 5}}\n")
    with pytest.raises(ValueError, match="01_on"):
        book.parameters("01_one", "ci")


def test_a_missing_chapter_is_named(tmp_path):
    book = checkout(tmp_path, "chapters: [{file: notebooks/02_two}]")
    with pytest.raises(FileNotFoundError, match="02_two"):
        book.notebooks()


def test_this_book_lists_its_notebooks_and_their_lock():
    book = graph.Book(ROOT)
    for stem in book.notebooks():
        inputs = book.inputs(stem)
        assert {f"notebooks/{stem}.py", "environment.lock", "tools/execute.py"} <= set(inputs)
        assert all((ROOT / path).is_file() for path in inputs)


def test_stored_results_that_a_notebook_shows_are_inputs(tmp_path):
    folder = tmp_path / "book" / "results"
    folder.mkdir(parents=True)
    (tmp_path / "notebooks").mkdir()
    (folder / "table.json").write_text("{}")
    header = "# ---\n# cmtof:\n#   results: [table.json, absent.json]\n# ---\n"
    (tmp_path / "notebooks" / "01_table.py").write_text(header)
    inputs = graph.Book(tmp_path).inputs("01_table")
    assert "book/results/table.json" in inputs
    assert not [name for name in inputs if "absent" in name]
