"""Which figure, table and equation of the paper stands in which chapter, and what is missing."""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

FIGURES, TABLES, EQUATIONS = 16, 4, 20
"""How many the paper has."""


class Item(NamedTuple):
    """One figure, table or equation of the paper."""

    kind: str
    number: int

    def __str__(self) -> str:
        return f"{self.kind} {self.number}"


ITEMS = [
    Item(kind, number)
    for kind, count in (("Figure", FIGURES), ("Table", TABLES), ("Equation", EQUATIONS))
    for number in range(1, count + 1)
]

_DRAWN = re.compile(r"(fig|table)(\d+)_")
_CHECKED = re.compile(r'"table(\d)\.')
_LABELLED = re.compile(r":label: eq-(\d+)\b(?!-)")


def chapters_by_item(results: Iterable[Path], notebooks: Iterable[Path]) -> dict[Item, list[str]]:
    """Chapters in which each item stands, in order; an item that no chapter has is left out.

    A figure stands where ``figNN_*`` was drawn, a table where ``tableN_*`` was drawn or its numbers
    were checked, an equation where it bears the label ``eq-N``.

    Parameters
    ----------
    results : iterable of Path
        One folder a chapter, of the chapter's name: what `cmtof.book.plotting.save` and
        `cmtof.book.paper.check` wrote.
    notebooks : iterable of Path
        The chapters themselves, ``.ipynb`` or ``.py``.
    """
    found: dict[Item, set[str]] = {}
    kinds = {"fig": "Figure", "table": "Table"}
    for folder in results:
        for file in folder.glob("*.json"):
            if drawn := _DRAWN.match(file.name):
                found.setdefault(Item(kinds[drawn[1]], int(drawn[2])), set()).add(folder.name)
            elif file.name == "checks.json":
                for number in _CHECKED.findall(file.read_text(encoding="utf-8")):
                    found.setdefault(Item("Table", int(number)), set()).add(folder.name)
    for notebook in notebooks:
        for number in _LABELLED.findall(notebook.read_text(encoding="utf-8")):
            found.setdefault(Item("Equation", int(number)), set()).add(notebook.stem)
    return {item: sorted(chapters) for item, chapters in found.items()}


def section(results: Iterable[Path], notebooks: Iterable[Path]) -> str:
    """Write the section of the scoreboard as MyST Markdown."""
    found = chapters_by_item(results, notebooks)
    missing = [str(item) for item in ITEMS if item not in found]
    rows = [f"| {item} | {_links(found[item])} |" for item in ITEMS if item in found]
    said = f"Not yet reached: {', '.join(missing)}." if missing else "None of them is missing."
    head = ["## Figures, tables and equations", "", "Where each of the paper's stands. " + said, ""]
    table = ["| of the paper | chapters |", "| :-- | :-- |", *rows, ""] if rows else []
    return "\n".join(head + table)


def _links(chapters: Iterable[str]) -> str:
    return ", ".join(f"{{doc}}`{name[:2]} <../notebooks/{name}>`" for name in chapters)
