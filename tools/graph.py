"""Which files a notebook depends on: its own source, the modules it reaches, the data it reads.

The Snakefile asks here, so that a change re-runs just what depends on it. Imports are followed
through the syntax tree, imports inside functions included. A package that loads members on first
use (``__getattr__`` in its ``__init__``) is followed only to the members that are used, which its
``if TYPE_CHECKING`` block names; one that loads members by a computed name counts as a whole. A
text such as ``package.module:function`` counts as an import.
"""

import ast
import json
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import yaml

NOTEBOOK = re.compile(r"\d\d_[a-z0-9_]+")

_ENTRY = re.compile(r"(\w+(?:\.\w+)+):(\w+)")
"""What a table of methods writes for a function to be loaded later: ``package.module:function``."""

NO_DATA = {".py", ".pyc", ".nbc", ".nbi"}
"""Suffixes of source and of what Python and Numba keep beside it."""

Reference = tuple[str, str | None]
"""A module's dotted name, and the member of it that is used (None: the module as such)."""


@dataclass(frozen=True)
class Source:
    """Where modules are looked up: a folder such as ``src`` and the package in it."""

    root: Path
    package: str

    def file(self, module: str) -> Path | None:
        """Return the file of a dotted module name, or None if the package has no such module."""
        if module.split(".")[0] != self.package:
            return None
        stem = self.root.joinpath(*module.split("."))
        for path in (stem / "__init__.py", stem.with_suffix(".py")):
            if path.is_file():
                return path
        return None

    def folder(self, module: str) -> list[Reference]:
        """Return every module below the package that ``module`` is or lies in."""
        path = self.file(module)
        if path is None:
            return []
        names = (file.relative_to(self.root).with_suffix("") for file in path.parent.rglob("*.py"))
        return [(".".join(name.parts).removesuffix(".__init__"), None) for name in sorted(names)]


@cache
def _tree(path: Path, stamp: int) -> ast.Module:
    del stamp  # part of the key only: a changed file is read again
    return ast.parse(path.read_text(encoding="utf-8"), filename=str(path))


def _parsed(path: Path) -> ast.Module:
    return _tree(path, path.stat().st_mtime_ns)


def closure(entry: Path, source: Source) -> set[Path]:
    """Return the files of the package that a Python file reaches, data files they name included.

    Parameters
    ----------
    entry : Path
        A Python file, of the package or not; it is not part of the answer.
    source : Source
        Where the package lies.
    """
    seen: set[Reference] = set()
    files: set[Path] = set()
    waiting = list(_references(_parsed(entry).body, "", source))
    while waiting:
        reference = waiting.pop()
        if reference in seen:
            continue
        seen.add(reference)
        module, member = reference
        path = source.file(module)
        if path is None:
            continue
        files |= {path, *_data_files(path, source.root / source.package)}
        parent = module.rpartition(".")[0]
        waiting += [(parent, None)] if parent else []
        member = member if path.name == "__init__.py" else None  # else all of it is reached
        waiting += _reached_from(path, path.stat().st_mtime_ns, module, member, source)
    return files


@cache
def _reached_from(
    path: Path, stamp: int, module: str, member: str | None, source: Source
) -> tuple[Reference, ...]:
    """Return what a module reaches; many notebooks reach it, so it is remembered."""
    return tuple(_followed(_tree(path, stamp).body, path, module, member, source))


def _followed(
    body: list[ast.stmt], path: Path, module: str, member: str | None, source: Source
) -> Iterable[Reference]:
    if path.name != "__init__.py":
        return _references(body, module, source)
    defined = {
        node.name: node for node in body if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    }
    if member is None:
        rest = [n for n in body if n not in defined.values() and not _is_typing_block(n)]
        return _references(rest, module, source)
    if member in defined:
        called = {n.id for n in ast.walk(defined[member]) if isinstance(n, ast.Name)}
        found = list(_references([defined[member]], module, source))
        return found + [(module, name) for name in called & defined.keys() - {member}]
    if source.file(f"{module}.{member}"):
        return [(f"{module}.{member}", None)]
    if "__getattr__" not in defined or member in _bound(body):
        return []  # a name bound by the body, which is followed anyway
    lazy = [n for block in body if _is_typing_block(block) for n in ast.walk(block)]
    for node in lazy:
        if isinstance(node, ast.ImportFrom):
            for alias in node.names:
                if (alias.asname or alias.name) == member:
                    return [(_absolute(node, module, source), alias.name)]
    return source.folder(module) if _loads_by_name(defined["__getattr__"]) else []


def _references(body: Iterable[ast.stmt], module: str, source: Source) -> Iterator[Reference]:
    """Yield what the imports in ``body`` reach, and the members used of a package as a whole."""
    nodes = [node for statement in body for node in ast.walk(statement)]
    names: dict[str, str] = {}
    for node in nodes:
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name, None
                names[alias.asname or alias.name.split(".")[0]] = (
                    alias.name if alias.asname else alias.name.split(".")[0]
                )
        elif isinstance(node, ast.ImportFrom):
            origin = _absolute(node, module, source)
            for alias in node.names:
                yield origin, None
                yield from source.folder(origin) if alias.name == "*" else [(origin, alias.name)]
                names[alias.asname or alias.name] = f"{origin}.{alias.name}"
        elif isinstance(node, ast.Call) and _loads_by_name(node):
            yield from _loaded_by_name(node, module, source)
        elif isinstance(node, ast.Constant) and (entry := _ENTRY.fullmatch(str(node.value))):
            yield entry[1], entry[2]
    for node in nodes:
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            yield names.get(node.value.id, ""), node.attr


def _absolute(node: ast.ImportFrom, module: str, source: Source) -> str:
    if not node.level:
        return node.module or ""
    path = source.file(module)
    is_package = path is not None and path.name == "__init__.py"
    parts = module.split(".")
    base = parts[: len(parts) - node.level + is_package]
    return ".".join([*base, *([node.module] if node.module else [])])


def _bound(body: Iterable[ast.stmt]) -> set[str]:
    """Return the names that a module's own statements bind, and those that every module has."""
    names = {"__all__", "__doc__", "__file__", "__name__", "__path__", "__version__"}
    for node in body:
        if isinstance(node, ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            names |= {alias.asname or alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            names |= {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}
    return names


def _is_typing_block(node: ast.stmt) -> bool:
    return isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test)


def _loads_by_name(node: ast.AST) -> bool:
    return any(
        isinstance(n, ast.Call)
        and (n.func.id if isinstance(n.func, ast.Name) else getattr(n.func, "attr", ""))
        in {"import_module", "__import__"}
        for n in ([node] if isinstance(node, ast.Call) else ast.walk(node))
    )


def _loaded_by_name(call: ast.Call, module: str, source: Source) -> Iterable[Reference]:
    """Return the module of ``import_module("a.b")``, the folder of ``import_module(f"a.{x}")``."""
    wanted = call.args[0] if call.args else None
    prefix = wanted.values[0] if isinstance(wanted, ast.JoinedStr) and wanted.values else wanted
    if not isinstance(prefix, ast.Constant) or not isinstance(prefix.value, str):
        return source.folder(module)
    name = prefix.value if not prefix.value.startswith(".") else module + prefix.value
    return [(name, None)] if wanted is prefix else source.folder(name.rstrip(".") or module)


@cache  # a checkout has thousands of words, and each notebook asks for most of them again
def _data_files(path: Path, package: Path) -> set[Path]:
    """Return the data that a module's strings name, beside it or at the package's top.

    The name may be that of a file, or of a folder, which counts with all that it holds.
    """
    words = {
        node.value
        for node in ast.walk(_parsed(path))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value
    }
    found: set[Path] = set()
    for word in words:
        if len(word) > 80 or not re.fullmatch(r"\w[\w.\-]*(/\w[\w.\-]*)*", word):
            continue
        for named in (path.parent / word, package / word):
            below = named.rglob("*") if named.is_dir() else [named]
            found |= {f for f in below if f.is_file() and f.suffix not in NO_DATA}
    return found


@dataclass(frozen=True)
class Book:
    """The notebooks of a checkout and what each of them depends on."""

    root: Path

    @property
    def source(self) -> Source:
        """Where the package lies."""
        return Source(self.root / "src", "cmtof")

    def notebooks(self) -> list[str]:
        """Return the stems of the notebooks that the table of contents lists, in its order."""
        text = (self.root / "_toc.yml").read_text(encoding="utf-8")
        listed = [entry.removeprefix("notebooks/") for entry in _files_of(yaml.safe_load(text))]
        stems = [name for name in listed if NOTEBOOK.fullmatch(name)]
        for stem in stems:
            if not self.script(stem).is_file():
                raise FileNotFoundError(
                    f"Expected notebooks/{stem}.py, which _toc.yml lists, got no such file. "
                    "Write it or take it off the list."
                )
        return stems

    def chapters(self) -> list[str]:
        """Return every file that the book is built from, notebooks and generated pages left out."""
        kept = [self.root / "_config.yml", self.root / "_toc.yml"]
        kept += [file for file in (self.root / "book").rglob("*") if file.is_file()]
        return sorted(_relative(file, self.root) for file in kept)

    def script(self, stem: str) -> Path:
        """Return the source of a notebook: the text half of its pair."""
        return self.root / "notebooks" / f"{stem}.py"

    def parameters(self, stem: str, profile: str) -> dict[str, Any]:
        """Return the parameters that a profile sets for a notebook."""
        path = self.root / "configs" / f"{profile}.yml"
        if not path.is_file():
            raise FileNotFoundError(
                f"Expected a profile of configs/, got {profile!r}. Choose ci, book or paper."
            )
        slices = (yaml.safe_load(path.read_text(encoding="utf-8")) or {}).get("notebooks") or {}
        unknown = sorted(name for name in slices if not self.script(name).is_file())
        if unknown:
            raise ValueError(
                f"Expected names of notebooks in configs/{profile}.yml, got {', '.join(unknown)}. "
                "Correct or remove them."
            )
        return {**(slices.get(stem) or {}), "profile": profile}

    def inputs(self, stem: str) -> list[str]:
        """Return every file that a notebook's results depend on, relative to the checkout."""
        script = self.script(stem)
        reached = closure(script, self.source)
        fixed = {script, self.root / "environment.lock", self.root / "tools" / "execute.py"}
        files = reached | fixed | set(self._data(script)) | set(self._stored(script))
        return sorted(_relative(file, self.root) for file in files)

    def tool(self, name: str) -> list[str]:
        """Return a script of ``tools`` and the files of the package that it reaches."""
        script = self.root / "tools" / name
        return sorted(_relative(f, self.root) for f in {script, *closure(script, self.source)})

    def _stored(self, script: Path) -> Iterator[Path]:
        """Yield stored results that a notebook shows: ``cmtof: {results: [...]}`` names them."""
        for name in _front_matter(script).get("cmtof", {}).get("results", []):
            path = self.root / "book" / "results" / name
            yield from [path] if path.is_file() else []

    def _data(self, script: Path) -> Iterator[Path]:
        """Yield data outside the package that a notebook reads.

        These are what its front matter names under ``cmtof: {data: [...]}``, and the captures if
        it imports their module. Data folders are optional; one that is absent is no input.
        """
        named: list[str] = _front_matter(script).get("cmtof", {}).get("data", [])
        direct = set(_references(_parsed(script).body, "", self.source))
        if direct & {("cmtof.scenes", "captures"), ("cmtof.scenes.captures", None)}:
            named = [*named, "captures"]
        if not named:
            return
        from cmtof.scenes.captures import data_root

        base = data_root()
        if base is None:
            return
        for word in named:
            for path in Path(base).glob(word):
                below = path.rglob("*") if path.is_dir() else [path]
                yield from (file for file in below if file.is_file())


def _front_matter(script: Path) -> dict[str, Any]:
    """Return the YAML header of a percent-format notebook, {} without one."""
    lines = script.read_text(encoding="utf-8").splitlines()
    if not lines or lines[0].strip() != "# ---":
        return {}
    header: list[str] = []
    for line in lines[1:]:
        if line.strip() == "# ---":
            return yaml.safe_load("\n".join(header)) or {}
        header.append(line.removeprefix("# ").removeprefix("#"))
    return {}


def _files_of(node: Any) -> Iterator[str]:
    """Yield every ``root`` and ``file`` of a table of contents."""
    if isinstance(node, dict):
        for key, value in node.items():
            if key in {"root", "file"}:
                yield value
            else:
                yield from _files_of(value)
    elif isinstance(node, list):
        for item in node:
            yield from _files_of(item)


def _relative(file: Path, root: Path) -> str:
    return str(file.relative_to(root)) if file.is_relative_to(root) else str(file)


if __name__ == "__main__":
    book = Book(Path(__file__).resolve().parents[1])
    print(json.dumps({stem: book.inputs(stem) for stem in book.notebooks()}, indent=2))
