"""Which files a notebook depends on: its own source, the modules it reaches, the data it reads.

The Snakefile asks here, so that a change re-runs what depends on it and nothing else. grimp follows
the imports, those inside functions included. Data files belong to the modules in whose folder, or
in a folder of it, they lie.
"""

import os
import re
import shlex
import sys
from functools import cache
from pathlib import Path

import grimp
import yaml

from cmtof import WHERE
from cmtof.captures import data_root
from cmtof.files import read_document
from cmtof.types import Fields
from cmtof_book import RESULTS, ROOT

PACKAGES = ("cmtof", "cmtof_rooms", "cmtof_lab", "cmtof_book", "notebooks")
SOURCE = {".py", ".pyc", ".nbc", ".nbi", ".ipynb"}


@cache
def imports() -> grimp.ImportGraph:
    """Imports among packages and notebooks; the names of `cmtof` lead to where each is defined."""
    sys.path.insert(0, str(ROOT))  # where grimp finds the notebooks
    graph = grimp.build_graph(*PACKAGES, cache_dir=None)
    sys.path.remove(str(ROOT))
    for module in graph.find_modules_directly_imported_by("cmtof"):
        graph.remove_import(importer="cmtof", imported=module)
    for module in graph.find_modules_that_directly_import("cmtof"):
        words = re.findall(r"\w+", path_of(module).read_text("utf-8"))
        for name in WHERE.keys() & words:
            graph.add_import(importer=module, imported=WHERE[name])
    return graph


def path_of(module: str) -> Path:
    """Source of a module, or the text half of a notebook."""
    path = ROOT.joinpath("src" * module.startswith("cmtof"), *module.split("."))
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


@cache
def files_of(module: str) -> set[Path]:
    """A module's file and the data beside it."""
    own = path_of(module)
    beside = (one for one in own.parent.rglob("*") if one.suffix not in SOURCE)
    return {own, *filter(Path.is_file, beside)}


def closure(module: str) -> set[Path]:
    """Files that a module or notebook reaches, data included."""
    return set().union(
        *map(files_of, imports().find_upstream_modules(module) | {module})
    )


def notebooks() -> list[str]:
    """Stems of the notebooks that the table of contents lists, in its order."""
    contents = (ROOT / "_toc.yml").read_text("utf-8")
    return re.findall(r"(?m)^\s*- file: notebooks/(\S+)$", contents)


def inputs(module: str) -> list[str]:
    """Every file that a module or notebook reaches or reads.

    ``configs/inputs.yml`` names what a notebook reads beside the packages; data are optional.
    """
    declared = read_document(ROOT / "configs/inputs.yml").get(
        module.rpartition(".")[2], {}
    )
    read = [RESULTS / name for name in declared.get("results", ())]
    if base := data_root():
        for word in declared.get("data", ()):
            read += Path(base, word).rglob("*")
    found = closure(module).union(filter(Path.is_file, read))
    return sorted(map(os.path.relpath, found))


def parameters_from_text(text: str) -> Fields:
    """Parameters from ``name=value`` pairs, values as in YAML: ``distance=1.0 repeats=6``."""
    pairs = [word.partition("=") for word in shlex.split(text)]
    if wrong := ["".join(pair) for pair in pairs if not all(pair)]:
        raise ValueError(
            f'Expected name=value, got {" ".join(wrong)}. Try P="seed=1 repeats=6".'
        )
    return {name: yaml.safe_load(value) for name, _, value in pairs}
