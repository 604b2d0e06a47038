"""Volume and density of the code beside their budgets; exit code 1 where a part exceeds its limit.

    python -m cmtof_book.size [-v]

Volume counts the nodes of the syntax tree, density those nodes a code line: packing lines gains
nothing. A code line is one that is not blank, comment or docstring. ``-v`` names the functions and
modules that are over the budget. A limit is the budget, or what ``configs/size.json`` allows until
the budget is reached.
"""

import ast
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

Rows = dict[str, tuple[float, float]]  # a value and its budget, by name
Finding = tuple[str, float, str]  # name of a limit, value, and where


def code_lines(source: str, nodes: list[ast.AST]) -> int:
    """Number of lines that are not blank, comment or docstring."""
    starts = [line.strip()[:1] for line in source.splitlines()]
    used = {number for number, start in enumerate(starts, 1) if start not in ("", "#")}
    for node in nodes:
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            used -= {*lines_of(node)} if isinstance(node.value.value, str) else set()
    return len(used)


def lines_of(statement: ast.stmt) -> range:
    """Numbers of a statement's lines."""
    return range(statement.lineno, (statement.end_lineno or 0) + 1)


def sizes_of(function: ast.FunctionDef, place: str) -> Iterator[Finding]:
    """What has a limit in a function."""
    given = function.args
    names = {one.arg for one in given.posonlyargs + given.args + given.kwonlyargs}
    yield "functions of many parameters", len(names), place
    for node in ast.walk(function):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
    yield "functions of many names", len(names), place
    yield "long functions", len(lines_of(function)), place


def measured(path: Path) -> tuple[Counter, list[Finding]]:
    """Counts of a file, and what has a limit in it and in its functions."""
    source = path.read_text("utf-8")
    nodes = [*ast.walk(ast.parse(source))]
    name = str(path.relative_to(ROOT))
    counts = Counter(nodes=len(nodes), code=code_lines(source, nodes))
    found: list[Finding] = [
        ("dense modules", counts["nodes"] / max(counts["code"], 1), name)
    ]
    if not name.startswith("notebooks"):
        found.append(("long modules", len(source.splitlines()), name))
    for node in nodes:
        if isinstance(node, ast.Assign):
            kinds = {type(node.value), type(node.targets[0])}
            counts.update(assigned=1, packed=kinds == {ast.Tuple})
        if isinstance(node, ast.FunctionDef):
            found += sizes_of(node, f"{name}:{node.lineno} {node.name}")
    return counts, found


def page_lines() -> int:
    """Lines of JavaScript, CSS and templates of the book."""
    files = [*ROOT.glob("book/**/*.*"), *ROOT.glob("src/cmtof_book/templates/*")]
    kinds = {".css", ".html", ".jinja", ".js"}
    return sum(path.read_bytes().count(b"\n") for path in files if path.suffix in kinds)


def everything() -> tuple[Rows, list[Finding]]:
    """All rows of the table, and what is over its limit."""
    rows: Rows = {}
    over: list[Finding] = []
    for part, budget in VOLUME.items():
        total = Counter()
        for path in sorted((ROOT / part).rglob("*.py")):
            counts, found = measured(path)
            total.update(counts)
            over += [one for one in found if one[1] > LIMITS[one[0]]]
        density = total["nodes"] / total["code"]
        packed = 100 * total["packed"] / total["assigned"]
        rows[f"{part} volume"] = total["nodes"], budget
        rows[f"{part} density"] = round(density, 1), DENSITY
        rows[f"{part} packed %"] = round(packed, 1), PACKED
    rows["book pages lines"] = page_lines(), PAGES
    for limit, count in Counter(limit for limit, *_ in over).items():
        rows[limit] = count, 0
    return rows, over


def main(verbose: bool) -> int:
    """Print the table; return the exit code."""
    rows, over = everything()
    allowed = read_json(ROOT / "configs" / "size.json")
    failed = False
    for name, (value, budget) in rows.items():
        exceeds = value > max(budget, allowed.get(name, 0))
        failed |= exceeds
        note = "OVER" if exceeds else "to do" * (value > budget)
        print(f"{name:32} {value:9,g} of {budget:7,g}  {note}".rstrip())
    for limit, value, place in sorted(over, reverse=True) if verbose else ():
        print(f"{limit}: {value:.3g}  {place}")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main("-v" in sys.argv))
