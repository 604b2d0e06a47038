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
from itertools import chain
from pathlib import Path

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
Rows = dict[str, tuple[float, float]]  # a value and its budget, by name
Finding = tuple[str, float, str]  # name of a limit, value, and where


def code_lines(source: str, nodes: list[ast.AST]) -> int:
    """Number of lines that are not blank, comment or docstring."""
    starts = [line.strip()[:1] for line in source.splitlines()]
    used = {number for number, start in enumerate(starts, 1) if start not in ("", "#")}
    for node in nodes:
        if isinstance(node, ast.Module | ast.ClassDef | Function) and ast.get_docstring(
            node
        ):
            used.difference_update(lines_of(node.body[0]))
    return len(used)


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


def measured(path: Path) -> tuple[Counter, list[Finding]]:
    """Counts of a file, and what has a limit in it and in its functions."""
    source = path.read_text("utf-8")
    nodes = [*ast.walk(ast.parse(source))]
    name = str(path.relative_to(ROOT))
    counts = Counter(nodes=len(nodes), code=code_lines(source, nodes))
    density = counts["nodes"] / max(counts["code"], 1)
    found: list[Finding] = [("dense modules", density, name)]
    if not name.startswith("notebooks"):
        found.append(("long modules", len(source.splitlines()), name))
    for node in nodes:
        if isinstance(node, ast.Assign):
            kinds = {type(node.value), type(node.targets[0])}
            counts.update(assigned=1, packed=kinds == {ast.Tuple})
        if isinstance(node, Function):
            place = f"{name}:{node.lineno} {node.name}"
            names = len(bound_names(node))
            found += [
                ("long functions", len(lines_of(node)), place),
                ("functions of many names", names, place),
                ("functions of many parameters", len(parameters(node)), place),
            ]
    return counts, found


def page_lines() -> int:
    """Lines of JavaScript, CSS and templates of the book."""
    files = chain(
        (ROOT / "book").rglob("*.*"), (ROOT / "src" / "cmtof_book").rglob("*.jinja")
    )
    kinds = {".css", ".html", ".jinja", ".js"}
    return sum(path.read_bytes().count(b"\n") for path in files if path.suffix in kinds)


def everything() -> tuple[Rows, list[Finding]]:
    """All rows of the table, and what is over its limit."""
    rows: Rows = {}
    over: list[Finding] = []
    for part in VOLUME:
        total = Counter()
        for path in sorted((ROOT / part).rglob("*.py")):
            counts, found = measured(path)
            total.update(counts)
            over += [one for one in found if one[1] > LIMITS[one[0]]]
        density = round(total["nodes"] / total["code"], 1)
        packed = round(100 * total["packed"] / total["assigned"], 1)
        rows[f"{part} volume"] = total["nodes"], VOLUME[part]
        rows[f"{part} density"] = density, DENSITY
        rows[f"{part} packed %"] = packed, PACKED
    rows["book pages lines"] = page_lines(), PAGES
    counted = Counter(limit for limit, *_ in over)
    return rows | {name: (count, 0) for name, count in counted.items()}, over


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
        for limit, value, place in sorted(found, reverse=True):
            print(f"{limit}: {value:.3g}  {place}")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
