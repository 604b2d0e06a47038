"""Volume and density of the code beside their budgets; exit code 1 where a part exceeds its limit.

    python -m cmtof_book.size

Volume counts the nodes of the syntax tree, density those nodes a code line: packing lines gains
nothing. A code line is one that is not blank, comment or docstring. Modules and functions are named
where they exceed a budget. A limit is the budget, or what ``configs/size.json`` allows until the
budget is reached.
"""

import ast
import re
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from cmtof_book import ROOT
from cmtof_book.provenance import read_json

# Nodes that a part may have.
VOLUME = {
    "src/cmtof": 80_000,
    "src/cmtof_rooms": 22_000,
    "src/cmtof_lab": 24_000,
    "src/cmtof_book": 16_000,
    "tests": 80_000,
    "notebooks": 60_000,
}

# What anything else may have.
LIMITS = {
    "density": 11,  # nodes a code line of a part
    "packed %": 3,  # of assignments, such as `a, b = x, y`
    "lines": 1_500,  # of JavaScript, CSS and templates together
    "density of a module": 13,
    "lines of a module": 400,  # notebooks are as long as their subject
    "lines of a function": 60,
    "parameters": 7,  # of a function
    "names": 15,  # that a function binds, parameters included
}

Size = tuple[str, str, float]  # where, what, and its value


def lines_of(statement: ast.stmt) -> range:
    """Numbers of a statement's lines."""
    return range(statement.lineno, (statement.end_lineno or 0) + 1)


def sizes_of(function: ast.FunctionDef, place: str) -> Iterator[Size]:
    """Sizes of a function that have a limit: parameters, names, lines."""
    given = function.args
    names = {one.arg for one in given.posonlyargs + given.args + given.kwonlyargs}
    yield place, "parameters", len(names)
    for node in ast.walk(function):
        match node:
            case ast.Name(id=name, ctx=ast.Store()):
                names.add(name)
    yield place, "names", len(names)
    yield place, "lines of a function", len(lines_of(function))


def sizes_in(path: Path, total: Counter) -> Iterator[Size]:
    """Sizes of a module and its functions that have a limit; what a part has is added to ``total``.

    A code line is one that is not blank, comment or docstring.
    """
    name = str(path.relative_to(ROOT))
    source = path.read_text("utf-8")
    lines = source.splitlines()
    code = {n for n, line in enumerate(lines, 1) if re.match(r"\s*[^\s#]", line)}
    nodes = [*ast.walk(ast.parse(source))]
    for node in nodes:
        match node:
            case ast.Expr(value=ast.Constant(value=str())):
                code.difference_update(lines_of(node))
            case ast.Assign(targets=[ast.Tuple(), *_], value=ast.Tuple()):
                total["packed"] += 1
            case ast.FunctionDef():
                yield from sizes_of(node, f"{name} {node.name}")
        total["assigned"] += isinstance(node, ast.Assign)
    total.update(nodes=len(nodes), code=len(code))
    yield name, "density of a module", len(nodes) / max(len(code), 1)
    if not name.startswith("notebooks"):
        yield name, "lines of a module", len(lines)


def sizes() -> Iterator[Size]:
    """Every size that has a limit: of functions, modules, parts, and pages of the book."""
    for part in VOLUME:
        total = Counter()
        for path in sorted((ROOT / part).rglob("*.py")):
            yield from sizes_in(path, total)
        yield part, "volume", total["nodes"]
        yield part, "density", round(total["nodes"] / total["code"], 1)
        yield part, "packed %", round(100 * total["packed"] / total["assigned"], 1)
    files = [*ROOT.glob("book/**/*.*"), *ROOT.glob("src/cmtof_book/templates/*")]
    pages = (one for one in files if one.suffix in {".css", ".html", ".jinja", ".js"})
    yield "book pages", "lines", sum(one.read_bytes().count(b"\n") for one in pages)


def main() -> int:
    """Print parts, and what else exceeds its budget; return the exit code."""
    allowed = read_json(ROOT / "configs/size.json")
    failed = False
    for place, what, value in sizes():
        budget = LIMITS.get(what) or VOLUME[place]
        named = f"{place} {what}"
        exceeds = value > max(budget, allowed.get(named, 0))
        failed |= exceeds
        if value > budget or place in (*VOLUME, "book pages"):
            note = "OVER" if exceeds else "to do" * (value > budget)
            print(f"{named:32} {value:9,g} of {budget:7,g}  {note}".rstrip())
    return failed


if __name__ == "__main__":
    sys.exit(main())
