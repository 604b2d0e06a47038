"""The scoreboard page of the book, written from what the notebooks checked."""

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from cmtof.book.paper import (
    Outcome,
    Published,
    Verdict,
    published,
    published_numbers,
    quantity_text,
    read_checks,
    verdict,
)

# from the one that must not be missed to the one that needs no look
_WORST_FIRST: tuple[Outcome, ...] = ("differs", "paper errs", "not comparable", "agrees")

_MEANING: dict[Outcome, str] = {
    "agrees": "Ours lies within the tolerance of the paper's number.",
    "differs": "Ours lies outside, and nothing explains it. It is an open question, or our fault.",
    "paper errs": "Ours lies outside, and the paper is wrong there: "
    "see the {doc}`errata <../notebooks/22_errata>`.",
    "not comparable": "Ours is another quantity, or comes from other data. The note says how.",
    "not yet reached": "No chapter has come to this number yet.",
}

_SPACE = "\N{NO-BREAK SPACE}"

_GROUPS = {"table": "Table", "fig": "Figure", "abstract": "Abstract", "sec": "Section"}

_HEAD = """# Scoreboard

Every number that the paper {{cite}}`baek2023` prints, and what this book found instead of it.
The page is written anew with each build, from the checks in the chapters.
It was written from {runs}.

{summary}

The tolerance stands beside the paper's number.
Unless a note says otherwise it is half a unit of the last digit printed.
In Tables 1 to 3 it is two percentage points, or a fifth of the number where that is less.

{meanings}
"""


@dataclass(frozen=True, slots=True)
class Run:
    """Where and how a number of ours was made."""

    notebook: str
    profile: str
    seed: int
    version: str

    def link(self) -> str:
        """Return a link to the chapter, or a plain name for a folder that is none."""
        number = re.match(r"(\d\d)_", self.notebook)
        if number is None:
            return f"`{self.notebook}`"
        return f"{{doc}}`{number[1]} <../notebooks/{self.notebook}>`"


Found = dict[str, tuple[Verdict, Run]]
"""Our number and its verdict, and the run that made it, by key."""


def page(
    checks: Iterable[Path], results: Iterable[Path] = (), notebooks: Iterable[Path] = ()
) -> str:
    """Write the page from the ``checks.json`` and the folder of each run, and the chapters."""
    numbers = published_numbers()
    found = _found(checks)
    groups: dict[str, list[Published]] = {}
    for number in numbers.values():
        groups.setdefault(number.key.partition(".")[0], []).append(number)
    runs = {run for _, run in found.values()}
    parts = [
        _HEAD.format(
            runs=f"{len(runs)} runs" if len(runs) != 1 else "one run",
            summary=_summary(numbers.values(), found),
            meanings="\n".join(f"- **{name}**: {text}" for name, text in _MEANING.items()),
        )
    ]
    parts.append(coverage_section(results, notebooks))
    parts += [_section(name, groups[name], found) for name in sorted(groups, key=_order)]
    if runs:
        parts.append(_runs(runs))
    return "\n".join(parts)


def _found(checks: Iterable[Path]) -> Found:
    found: Found = {}
    for path in checks:
        for key, record in read_checks(path).items():
            new = _judged(key, record)
            old = found.get(key)
            if old is None or _rank(new) < _rank(old[0]):
                found[key] = (new, _run(path.parent.name, record))
    return found


def _judged(key: str, record: Mapping[str, Any]) -> Verdict:
    value = float("nan") if record["value"] is None else record["value"]
    return verdict(
        published(key), value, reason=record.get("reason"), tolerance=record.get("tolerance")
    )


def _run(notebook: str, record: Mapping[str, Any]) -> Run:
    return Run(notebook, record["profile"], record["seed"], record["version"])


def _rank(judged: Verdict) -> int:
    return _WORST_FIRST.index(judged.outcome)


def _outcome(number: Published, found: Found) -> Outcome:
    if number.key in found:
        return found[number.key][0].outcome
    # a part of their bench or another's work is nothing that a later chapter could reach
    out_of_reach = not number.comparable and number.kind != "result"
    return "not comparable" if out_of_reach else "not yet reached"


def _summary(numbers: Iterable[Published], found: Found) -> str:
    counts: dict[str, Counter[Outcome]] = {"result": Counter(), "setting": Counter()}
    for number in numbers:
        kind = "result" if number.kind == "result" else "setting"
        counts[kind][_outcome(number, found)] += 1
    head = ["| verdict | results | settings |", "| :-- | --: | --: |"]
    found_of, chosen = counts["result"], counts["setting"]
    rows = [f"| {name} | {found_of[name]} | {chosen[name]} |" for name in _MEANING]
    rows.append(f"| **all** | **{found_of.total()}** | **{chosen.total()}** |")
    said = (
        "Results are what the paper found. "
        "Settings are what it chose, or took from the work of others."
    )
    return "\n".join([*head, *rows, "", said])


def _split(group: str) -> tuple[str, str]:
    name = group.rstrip("0123456789")
    return name, group[len(name) :]


def _order(group: str) -> tuple[int, int]:
    name, digits = _split(group)
    return list(_GROUPS).index(name), int(digits or 0)


def _title(group: str) -> str:
    name, digits = _split(group)
    return f"{_GROUPS[name]} {digits}".strip()


def _section(group: str, numbers: list[Published], found: Found) -> str:
    notes: dict[str, str] = {}
    rows = [_row(number, found, notes) for number in numbers]
    table = [
        f"## {_title(group)}",
        "",
        "```{table}",
        ":class: scoreboard",
        "",
        "| number | paper | ours |",
        "| :-- | :-- | :-- |",
        *rows,
        "```",
        "",
    ]
    return "\n".join(table + [f"**{letter}** {reason}\n" for reason, letter in notes.items()])


def _row(number: Published, found: Found, notes: dict[str, str]) -> str:
    judged, run = found.get(number.key, (None, None))
    reason = judged.reason if judged else number.reason
    said: str = _outcome(number, found)
    if number.erratum is not None:
        reason = f"{reason} (erratum {number.erratum})" if reason else f"Erratum {number.erratum}."
    if reason:
        said += f"{_SPACE}<sup>{notes.setdefault(reason, _letter(len(notes)))}</sup>"
    if judged and run:
        ours = _unbroken(quantity_text(judged.value, number.unit))
        said = f"{ours}<br>{said}<br>{run.link()}"
    paper = number.text(judged.tolerance if judged else number.tolerance, joint="<br>")
    # the key may break over lines, or a phone would have to scroll sideways
    key = re.sub(r"(\.|_(?!\d))", r"\1<wbr>", number.key.partition(".")[2])
    what = re.sub(r" ([<≥]) (?=\d)", rf"{_SPACE}\1{_SPACE}", number.what)
    return f"| {what}<br><code>{key}</code> | {_unbroken(paper)} | {said} |"


def _unbroken(text: str) -> str:
    return text.replace(" ", _SPACE)


def _letter(index: int) -> str:
    return "abcdefghijklmnopqrstuvwxyz"[index]


def _runs(runs: Iterable[Run]) -> str:
    ordered = sorted(runs, key=lambda run: (run.notebook, run.profile, run.seed, run.version))
    rows = [f"| {run.link()} | {run.profile} | {run.seed} | {run.version} |" for run in ordered]
    head = ["## Runs", "", "| chapter | profile | seed | version |", "| :-- | :-- | --: | :-- |"]
    return "\n".join([*head, *rows, ""])


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


def coverage_section(results: Iterable[Path], notebooks: Iterable[Path]) -> str:
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
