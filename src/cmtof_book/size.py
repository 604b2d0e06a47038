"""Volume and density of the code beside their budgets; exit code 1 where a part exceeds its limit.

    python -m cmtof_book.size [-v] [--accept]

Volume counts the nodes of the syntax tree, density those nodes a code line: packing lines gains
nothing. A code line is one that is not blank, comment or docstring. ``-v`` names the functions and
modules that are over the budget. A limit is the budget, or the last accepted value where that is
still larger; ``--accept`` stores the values of today as limits.
"""

import ast
import io
import json
import subprocess
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
ACCEPTED = ROOT / "configs" / "size.json"
VOLUME = {
    "src/cmtof": 80_000,
    "src/cmtof_rooms": 22_000,
    "src/cmtof_lab": 24_000,
    "src/cmtof_book": 16_000,
    "tests": 80_000,
    "notebooks": 60_000,
}
"""Nodes that a part may have."""

DENSITY = 11  # nodes a code line of a part
MODULE_DENSITY = 13
MODULE_LINES = 400
NAMES = 15  # that a function binds, parameters included
PARAMETERS = 7
FUNCTION_LINES = 60
COMPLEXITY = 12
PACKED = 3  # percent of assignments such as `a, b = x, y`
PAGES = 1_500  # lines of JavaScript, CSS and templates together
PAGE_FILES = {".css", ".html", ".jinja", ".js"}

SCOPES = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
SILENT = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
}


class Module(NamedTuple):
    """One file: its syntax tree and its number of code lines."""

    path: Path
    tree: ast.Module
    code: int
    lines: int

    @property
    def nodes(self) -> int:
        """Nodes of the syntax tree."""
        return sum(1 for _ in ast.walk(self.tree))

    @property
    def density(self) -> float:
        """Nodes a code line."""
        return self.nodes / max(self.code, 1)


class Finding(NamedTuple):
    """What exceeds its budget: the budget's name, the value, and where."""

    budget: str
    value: float
    place: str


def read_module(path: Path) -> Module:
    """Parse a file and count its code lines."""
    source = path.read_text(encoding="utf-8")
    tree = ast.parse(source)
    used: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in SILENT:
            used.update(range(token.start[0], token.end[0] + 1))
    for node in ast.walk(tree):
        if isinstance(node, SCOPES) and ast.get_docstring(node, clean=False) is not None:
            text = node.body[0]
            used.difference_update(range(text.lineno, (text.end_lineno or text.lineno) + 1))
    return Module(path, tree, len(used), source.count("\n"))


def modules_of(part: str) -> list[Module]:
    """All Python files of a part."""
    return [read_module(path) for path in sorted((ROOT / part).rglob("*.py"))]


def bound_names(function: ast.AST) -> set[str]:
    """Names that a function binds, those of its parameters included."""
    stored = {
        node.id
        for node in ast.walk(function)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
    }
    return stored | {node.arg for node in parameters(function)}


def parameters(function: ast.AST) -> list[ast.arg]:
    """Parameters of a function."""
    given = function.args  # type: ignore[attr-defined]
    return [*given.posonlyargs, *given.args, *given.kwonlyargs]


def is_packed(assignment: ast.Assign) -> bool:
    """Whether several values are assigned to as many names in one line."""
    return isinstance(assignment.targets[0], ast.Tuple) and isinstance(assignment.value, ast.Tuple)


def packed_share(modules: list[Module]) -> float:
    """Share of packed assignments, percent."""
    every = [n for m in modules for n in ast.walk(m.tree) if isinstance(n, ast.Assign)]
    return 100 * sum(map(is_packed, every)) / max(len(every), 1)


def findings_of(module: Module) -> Iterator[Finding]:
    """What a module and its functions have too much of."""
    name = str(module.path.relative_to(ROOT))
    if module.density > MODULE_DENSITY:
        yield Finding("dense modules", round(module.density, 1), name)
    if module.lines > MODULE_LINES and not name.startswith("notebooks"):
        yield Finding("long modules", module.lines, name)
    for function in ast.walk(module.tree):
        if not isinstance(function, FUNCTIONS):
            continue
        place = f"{name}:{function.lineno} {function.name}"
        length = (function.end_lineno or 0) - function.lineno + 1
        measured = {
            "functions of many names": (len(bound_names(function)), NAMES),
            "functions of many parameters": (len(parameters(function)), PARAMETERS),
            "long functions": (length, FUNCTION_LINES),
        }
        for budget, (value, limit) in measured.items():
            if value > limit:
                yield Finding(budget, value, place)


def complex_functions() -> Iterator[Finding]:
    """Functions of too many branches, as ruff counts them (C901)."""
    command = [sys.executable, "-m", "ruff", "check", "--isolated", "--select", "C901", *VOLUME]
    command += ["--config", f"lint.mccabe.max-complexity={COMPLEXITY}", "--output-format", "json"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    for found in json.loads(done.stdout):
        path = Path(found["filename"]).relative_to(ROOT)
        value = float(found["message"].split("(")[1].split()[0])
        yield Finding("complex functions", value, f"{path}:{found['location']['row']}")


def page_lines() -> int:
    """Lines of JavaScript, CSS and templates of the book."""
    folders = (ROOT / "book", ROOT / "src" / "cmtof_book" / "templates")
    files = [path for folder in folders for path in folder.rglob("*") if path.suffix in PAGE_FILES]
    return sum(path.read_bytes().count(b"\n") for path in files)


def measured_values(parts: dict[str, list[Module]]) -> dict[str, float]:
    """Volume, density and packing of each part."""
    values: dict[str, float] = {}
    for part, modules in parts.items():
        nodes = sum(module.nodes for module in modules)
        code = sum(module.code for module in modules)
        values[f"{part} volume"] = nodes
        values[f"{part} density"] = round(nodes / code, 1)
        values[f"{part} packed %"] = round(packed_share(modules), 1)
    values["book pages lines"] = page_lines()
    return values


def budget_of(name: str) -> float:
    """Budget of a value by its name; what is counted in findings may not occur."""
    part, _, what = name.rpartition(" ")
    fixed = {"density": DENSITY, "%": PACKED, "lines": PAGES}
    return VOLUME[part] if what == "volume" else fixed.get(what, 0)


def main(options: list[str]) -> int:
    """Print the table; return the exit code."""
    parts = {part: modules_of(part) for part in VOLUME}
    values = measured_values(parts)
    found = [f for modules in parts.values() for m in modules for f in findings_of(m)]
    found += complex_functions()
    for finding in found:
        values[finding.budget] = values.get(finding.budget, 0) + 1
    accepted = json.loads(ACCEPTED.read_text("utf-8")) if ACCEPTED.is_file() else {}
    if "--accept" in options:
        accepted = {name: value for name, value in values.items() if value > budget_of(name)}
        ACCEPTED.write_text(json.dumps(accepted, indent=1) + "\n", encoding="utf-8")
    notes = {name: judged(name, value, accepted) for name, value in values.items()}
    for name, note in notes.items():
        print(f"{name:32} {values[name]:9,g} of {budget_of(name):7,g}  {note}".rstrip())
    for finding in sorted(found, reverse=True) if "-v" in options else ():
        print(f"{finding.budget}: {finding.value:g}  {finding.place}")
    return int("OVER" in notes.values())


def judged(name: str, value: float, accepted: dict[str, float]) -> str:
    """What is to be said of a value: nothing within its budget, OVER beyond the accepted one."""
    if value <= budget_of(name):
        return ""
    return "OVER" if value > accepted.get(name, 0) else "to do"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
