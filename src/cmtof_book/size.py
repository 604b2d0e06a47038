"""Volume and density of the code beside their budgets; exit code 1 where a part exceeds its limit.

    python -m cmtof_book.size [-v] [--accept]

Volume counts the nodes of the syntax tree, density those nodes a code line: packing lines gains
nothing. A code line is one that is not blank, comment or docstring. ``-v`` names the functions and
modules that are over the budget. A limit is the budget, or the last accepted value where that is
still larger; ``--accept`` stores the values of today as limits.
"""

import ast
import json
import sys
from collections import Counter
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import NamedTuple

from cmtof_book import ROOT

ACCEPTED = ROOT / "configs" / "size.json"
# Nodes that a part may have.
VOLUME = {
    "src/cmtof": 80_000,
    "src/cmtof_rooms": 22_000,
    "src/cmtof_lab": 24_000,
    "src/cmtof_book": 16_000,
    "tests": 80_000,
    "notebooks": 60_000,
}

DENSITY = 11  # nodes a code line of a part
PACKED = 3  # percent of assignments such as `a, b = x, y`
PAGES = 1_500  # lines of JavaScript, CSS and templates together
# What a module or a function may have.
LIMITS = {
    "dense modules": 13,  # nodes a code line
    "long modules": 400,  # lines; notebooks are as long as their subject
    "functions of many names": 15,  # that it binds, parameters included
    "functions of many parameters": 7,
    "long functions": 60,
}

Function = ast.FunctionDef | ast.AsyncFunctionDef
Rows = dict[str, tuple[float, float]]  # A value and its budget, by name


class Finding(NamedTuple):
    """What was measured of a module or function: the limit's name, the value, and where."""

    limit: str
    value: float
    place: str


class Module(NamedTuple):
    """One file: nodes of its syntax tree, its number of code lines, and that of all lines."""

    path: Path
    nodes: list[ast.AST]
    code: int
    lines: int


def read_module(path: Path) -> Module:
    """Parse a file and count its code lines."""
    source = path.read_text("utf-8")
    nodes = [*ast.walk(ast.parse(source))]
    lines = source.splitlines()
    used = {
        number
        for number, line in enumerate(lines, 1)
        if line.strip()[:1] not in ("", "#")
    }
    for node in nodes:
        if isinstance(node, ast.Module | ast.ClassDef | Function) and ast.get_docstring(
            node
        ):
            used.difference_update(lines_of(node.body[0]))
    return Module(path, nodes, len(used), len(lines))


def lines_of(statement: ast.stmt) -> range:
    """Numbers of a statement's lines."""
    return range(statement.lineno, (statement.end_lineno or 0) + 1)


def parameters(function: Function) -> list[str]:
    """Parameters of a function."""
    given = function.args
    return [one.arg for one in given.posonlyargs + given.args + given.kwonlyargs]


def bound_names(function: Function) -> set[str]:
    """Names that a function binds, those of its parameters included."""
    stored = {
        node.id
        for node in ast.walk(function)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
    }
    return stored.union(parameters(function))


def packed_share(modules: list[Module]) -> float:
    """Share of assignments that pack several values into one line, percent."""
    packed = [
        {type(node.value), type(node.targets[0])} == {ast.Tuple}
        for module in modules
        for node in module.nodes
        if isinstance(node, ast.Assign)
    ]
    return 100 * sum(packed) / max(len(packed), 1)


def measured(module: Module) -> Iterator[Finding]:
    """What has a limit in a module and in its functions."""
    name = str(module.path.relative_to(ROOT))
    yield Finding("dense modules", len(module.nodes) / max(module.code, 1), name)
    if not name.startswith("notebooks"):
        yield Finding("long modules", module.lines, name)
    for function in module.nodes:
        if not isinstance(function, Function):
            continue
        place = f"{name}:{function.lineno} {function.name}"
        yield Finding("long functions", len(lines_of(function)), place)
        yield Finding("functions of many names", len(bound_names(function)), place)
        yield Finding("functions of many parameters", len(parameters(function)), place)


def page_lines() -> int:
    """Lines of JavaScript, CSS and templates of the book."""
    files = chain(
        (ROOT / "book").rglob("*.*"), (ROOT / "src" / "cmtof_book").rglob("*.jinja")
    )
    kinds = {".css", ".html", ".jinja", ".js"}
    return sum(path.read_bytes().count(b"\n") for path in files if path.suffix in kinds)


def rows_of(part: str, modules: list[Module]) -> Rows:
    """Volume, density and packing of a part."""
    nodes = sum(len(module.nodes) for module in modules)
    density = nodes / sum(module.code for module in modules)
    return {
        f"{part} volume": (nodes, VOLUME[part]),
        f"{part} density": (round(density, 1), DENSITY),
        f"{part} packed %": (round(packed_share(modules), 1), PACKED),
    }


def everything() -> tuple[Rows, list[Finding]]:
    """All rows of the table, and what is over its limit."""
    rows: Rows = {}
    found: list[Finding] = []
    for part in VOLUME:
        modules = [read_module(path) for path in sorted((ROOT / part).rglob("*.py"))]
        rows |= rows_of(part, modules)
        found += [one for module in modules for one in measured(module)]
    rows["book pages lines"] = (page_lines(), PAGES)
    over = [one for one in found if one.value > LIMITS[one.limit]]
    counts = Counter(one.limit for one in over)
    rows |= {name: (count, 0) for name, count in counts.items()}
    return rows, over


def main(options: list[str]) -> int:
    """Print the table; return the exit code."""
    rows, found = everything()
    if "--accept" in options:
        accepted = {
            name: value for name, (value, budget) in rows.items() if value > budget
        }
        ACCEPTED.write_text(json.dumps(accepted, indent=1) + "\n", "utf-8")
    accepted = json.loads(ACCEPTED.read_text("utf-8"))
    failed = False
    for name, (value, budget) in rows.items():
        over = value > max(budget, accepted.get(name, 0))
        failed |= over
        note = "OVER" if over else "to do" * (value > budget)
        print(f"{name:32} {value:9,g} of {budget:7,g}  {note}".rstrip())
    if "-v" in options:
        for one in sorted(found, reverse=True):
            print(f"{one.limit}: {one.value:.3g}  {one.place}")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
