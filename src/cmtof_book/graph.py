"""Which files a notebook depends on: its own source, the modules it reaches, the data it reads.

The Snakefile asks here, so that a change re-runs what depends on it and nothing else. grimp follows
the imports, those inside functions included. A data file of the package belongs to the modules of
its folder; `DATA` says which folder of data alone a module reads.
"""

import ast
import re
import shlex
from collections.abc import Iterable, Iterator
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import grimp
import yaml

import cmtof
from cmtof.captures import data_root
from cmtof.files import read_document
from cmtof_book import Values

PACKAGES = ("cmtof", "cmtof_rooms", "cmtof_lab", "cmtof_book")
DATA = {
    "cmtof.frame": "cmtof/frames",
    "cmtof.network.weights": "cmtof/weights",
    "cmtof_book.pages": "cmtof_book/templates",
}
SOURCE = {".py", ".pyc", ".nbc", ".nbi"}


class Book:
    """The notebooks of a checkout and what each of them depends on."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.source = root / "src"

    @cached_property
    def imports(self) -> grimp.ImportGraph:
        """Imports among the packages; the root of `cmtof`, which loads late, left out."""
        graph = grimp.build_graph(*PACKAGES, cache_dir=None)
        for module in graph.find_modules_directly_imported_by("cmtof"):
            graph.remove_import(importer="cmtof", imported=module)
        return graph

    def notebooks(self) -> list[str]:
        """Stems of the notebooks that the table of contents lists, in its order."""
        text = (self.root / "_toc.yml").read_text("utf-8")
        listed = re.findall(r"^\s*- file: notebooks/(\S+)$", text, re.MULTILINE)
        if missing := self._missing(listed):
            raise FileNotFoundError(
                f"Expected the notebooks that _toc.yml lists, got no {missing}. "
                "Write them or take them off the list."
            )
        return listed

    def _missing(self, stems: Iterable[str]) -> str:
        """Those names of notebooks that there are none of."""
        return ", ".join(
            sorted(stem for stem in stems if not self.script(stem).is_file())
        )

    def script(self, stem: str) -> Path:
        """Source of a notebook: the text half of its pair."""
        return self.root / "notebooks" / f"{stem}.py"

    def chapters(self) -> list[str]:
        """Every file that the book is built from, notebooks and generated pages left out."""
        pages = filter(Path.is_file, (self.root / "book").rglob("*"))
        shown = (self.source / "cmtof" / "hardware").glob(
            "rig.*"
        )  # by the guide to the hardware
        return self._relative([*self.root.glob("_*.yml"), *shown, *pages])

    def parameters(self, stem: str, profile: str) -> Values:
        """Parameters that a profile sets for a notebook."""
        path = self.root / "configs" / f"{profile}.yml"
        if not path.is_file():
            raise FileNotFoundError(
                f"Expected a profile of configs/, got {profile!r}. Choose ci, book or paper."
            )
        sizes = read_document(path).get("notebooks") or {}
        if unknown := self._missing(sizes):
            raise ValueError(
                f"Expected names of notebooks in configs/{profile}.yml, got {unknown}. "
                "Correct or remove them."
            )
        return {**(sizes.get(stem) or {}), "profile": profile}

    def inputs(self, stem: str) -> list[str]:
        """Every file that a notebook's results depend on, relative to the checkout."""
        script = self.script(stem)
        return self._relative(
            {
                script,
                self.root / "environment.lock",
                self.source / "cmtof_book" / "execute.py",
                *self.closure(script),
                *self._declared(stem),
            }
        )

    def tool(self, name: str) -> list[str]:
        """A module of `cmtof_book` and the files of the packages that it reaches."""
        script = self.source / "cmtof_book" / f"{name}.py"
        return self._relative({script, *self.closure(script)})

    def closure(self, script: Path) -> set[Path]:
        """Files of the package that a Python file reaches, data included."""
        named = set(self._imported(script))
        modules = named.union(*map(self.imports.find_upstream_modules, named))
        return set().union(*map(self._files, modules))

    @cache  # noqa: B019 (one book a process)
    def _files(self, module: str) -> set[Path]:
        """A module's file and the data that belong to it."""
        path = self.source.joinpath(*module.split("."))
        own = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
        data = [*own.parent.glob("*" if own.parent.parent == self.source else "**/*")]
        if module in DATA:
            data += (self.source / DATA[module]).rglob("*")
        return {
            own,
            *(file for file in data if file.is_file() and file.suffix not in SOURCE),
        }

    def _imported(self, script: Path) -> Iterator[str]:
        """Modules of the package that a script names in its imports, or uses as ``cmtof.name``."""
        for node in ast.walk(ast.parse(script.read_text("utf-8"))):
            names: list[str] = []
            match node:
                case ast.Import(names=aliases):
                    names = [alias.name for alias in aliases]
                case ast.ImportFrom(module=str(module), names=aliases):
                    names = [module, *(f"{module}.{alias.name}" for alias in aliases)]
                case ast.Attribute(value=ast.Name(id="cmtof"), attr=name):
                    names = [cmtof.WHERE.get(name, "")]
            yield from self.imports.modules.intersection(names)

    def _declared(self, stem: str) -> Iterator[Path]:
        """Files that ``configs/inputs.yml`` names for a notebook; data are optional."""
        declared = read_document(self.root / "configs" / "inputs.yml").get(stem, {})
        places = [
            self.root / "book" / "results" / name
            for name in declared.get("results", [])
        ]
        if base := data_root():
            for word in declared.get("data", []):
                places += Path(base, word).rglob("*")
        return filter(Path.is_file, places)

    def _relative(self, files: Any) -> list[str]:
        inside = (
            f.relative_to(self.root) if f.is_relative_to(self.root) else f
            for f in files
        )
        return sorted(map(str, inside))


def parameters_from_text(text: str) -> Values:
    """Parameters from ``name=value`` pairs, values as in YAML: ``distance=1.0 repeats=6``."""
    pairs = [word.partition("=") for word in shlex.split(text)]
    if wrong := [
        name + sign + value for name, sign, value in pairs if not (name and value)
    ]:
        raise ValueError(
            f'Expected name=value, got {" ".join(wrong)}. Try P="seed=1 repeats=6".'
        )
    return {name: yaml.safe_load(value) for name, _, value in pairs}
