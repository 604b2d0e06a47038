"""The scoreboard page of the book: the published numbers, ours, and the verdicts.

Written from the records of each run (`cmtof_book.record`) and from the equations of the chapters.
Where several runs checked one number, the worst verdict is shown.
"""

import math
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cmtof_book.paper import (
    WORST_FIRST,
    Outcome,
    Published,
    Value,
    claims,
    ours_text,
    published,
    published_numbers,
    training_text,
)
from cmtof_book.record import PAPER, Record

MEANING: dict[Outcome, str] = {
    "reproduced": "Ours lies within the tolerance of the paper's number.",
    "contradicted": "Ours, in simulation, lies outside; the ratio says by how much. "
    "Where the paper is at fault, the {doc}`errata <../notebooks/22_errata>` say so.",
    "untested": "No result of ours can be compared with it; the note says why.",
    "input": "A setting of the paper, typed in. It is no result of either side.",
}

NO_CHECK = "No chapter computes it."

GROUPS = {"table": "Table", "fig": "Figure", "abstract": "Abstract", "sec": "Section"}

SPACE = "\N{NO-BREAK SPACE}"

HEAD = """# Scoreboard

The paper's {{cite}}`baek2023` ten main claims, and what this book found, in simulation.
A claim has the worst verdict of the numbers on which it rests.

{claims}

{meanings}

The numbers below fold out: all that the paper prints, a heading for each figure and table.
The page is written with each build, from the checks of {runs} runs.

{summary}

The tolerance stands beside the paper's number, the ratio of ours to the paper's beside ours.
Unless a note says otherwise the tolerance is half a unit of the last digit printed.
In Tables 1 to 3 it is two percentage points, or a fifth of the number where that is less.
"""


@dataclass(frozen=True, slots=True)
class Run:
    """Where and how a number of ours was made."""

    notebook: str
    profile: str
    seed: int
    version: str
    crops: int
    beside: str

    def link(self) -> str:
        """Return a link to the chapter, or a plain name for a folder that is none."""
        if re.match(r"\d\d_", self.notebook) is None:
            return f"`{self.notebook}`"
        return chapter_link(self.notebook)


def chapter_link(notebook: str) -> str:
    """Return a link to a chapter by its number."""
    return f"{{doc}}`{notebook[:2]} <../notebooks/{notebook}>`"


Found = dict[str, tuple[Value, Run]]
"""Our number, or the ends of its band, and the run that made it, by key."""


def page(records: Sequence[Record], notebooks: Iterable[Path] = ()) -> str:
    """Return the page as MyST Markdown, from the records of all runs.

    ``notebooks`` are the chapters themselves; ValueError for an unknown key.
    """
    found = found_in(records)
    groups: dict[str, list[Published]] = {}
    for number in published_numbers().values():
        groups.setdefault(number.key.partition(".")[0], []).append(number)
    runs = {run for _, run in found.values()}
    meanings = "\n".join(f"- **{name}**: {text}" for name, text in MEANING.items())
    filled = {"summary": summary(found), "claims": claims_table(found)}
    parts = [HEAD.format(runs=len({run.notebook for run in runs}), meanings=meanings, **filled)]
    parts += [section(name, groups[name], found) for name in sorted(groups, key=_order)]
    parts.append(coverage_section(records, notebooks))
    rows = {f"| {run.link()} | {run.profile} | {run.seed} | {run.version} |" for run in runs}
    head = ["## Runs", "", "| chapter | profile | seed | version |", "| :-- | :-- | --: | :-- |"]
    return "\n".join([*parts, *head, *sorted(rows), ""])


def claims_table(found: Found) -> str:
    """Return the table of claims: what the paper says, what we found, and where."""
    values, rows = {key: value for key, (value, _) in found.items()}, []
    for claim in claims():
        runs = [(key, *found[key]) for key in claim.keys if key in found]
        ours = {re.sub(r" (?!\(|to )", SPACE, ours_text(published(k), v)): None for k, v, _ in runs}
        ours |= {run.beside: None for _, _, run in runs if run.beside}
        places = {run.link(): None for _, _, run in runs}
        said = badge(claim.outcome(values))
        said += max((training_text(run.crops) for *_, run in runs), default="")
        rows.append(f"| {claim.text} | {';<br>'.join(ours)} | {said} | {', '.join(places)} |")
    head = ["| the paper | this book | verdict | chapter |", "| :-- | :-- | :-- | :-- |"]
    return "\n".join([*head, *rows])


def badge(said: str) -> str:
    """Return a verdict as a word in its colour."""
    return f'<span class="verdict {said}">{said}</span>'


def found_in(records: Iterable[Record]) -> Found:
    """Return the numbers of runs, that of the worst verdict where several checked one."""
    found: Found = {}
    for record in records:
        for key, number in record.numbers.items() if record.name == PAPER else ():
            value = math.nan if number["value"] is None else number["value"]
            said = published(key).outcome  # computed again
            rank = WORST_FIRST.index(said(value))
            if key not in found or rank < WORST_FIRST.index(said(found[key][0])):
                about = record.content["provenance"] | number
                names = ("profile", "seed", "version", "crops", "beside")
                found[key] = (value, Run(record.chapter, *(about[name] for name in names)))
    return found


def accepted(records: Iterable[Record]) -> dict[str, Any]:
    """Return the scoreboard for ``figures/scoreboard.json``: counts, and each number's verdict."""
    found = found_in(records)
    numbers = {
        key: {
            "paper": published(key).value,
            "ours": None if value != value else value,
            "unit": published(key).unit,
            "verdict": published(key).outcome(value),
            "chapter": run.notebook,
        }
        for key, (value, run) in sorted(found.items())
    }
    return {"counts": verdict_counts(found), "numbers": numbers}


def verdict_counts(found: Found) -> dict[str, int]:
    """Return how many of the paper's numbers have each verdict."""
    numbers = published_numbers().values()
    counts = Counter(number.outcome(*found.get(number.key, ())[:1]) for number in numbers)
    return {name: counts[name] for name in MEANING}


def summary(found: Found) -> str:
    """Return the table of verdicts; inputs are counted apart."""
    counts = verdict_counts(found)
    rows = [f"| {name} | {counts[name]} |" for name in MEANING if name != "input"]
    results = len(published_numbers()) - counts["input"]
    apart = [f"| **results** | **{results}** |", f"| inputs, apart | {counts['input']} |"]
    return "\n".join(["| verdict | numbers |", "| :-- | --: |", *rows, *apart])


def section(group: str, numbers: list[Published], found: Found) -> str:
    """Return the table of one table, figure or section of the paper, with its notes."""
    notes: dict[str, str] = {}
    rows = [row(number, found, notes) for number in numbers]
    name, digits = _split(group)
    said = Counter(number.outcome(*found.get(number.key, ())[:1]) for number in numbers)
    counted = ", ".join(f"{said[one]} {one}" for one in WORST_FIRST if said[one])
    head = [f":::{{dropdown}} {GROUPS[name]} {digits}".rstrip() + f": {counted}", ""]
    table = ["| number | paper | ours | verdict |", "| :-- | :-- | :-- | :-- |", *rows, ""]
    return "\n".join([*head, *table, *(f"**{c}** {text}\n" for text, c in notes.items()), ":::\n"])


def row(number: Published, found: Found, notes: dict[str, str]) -> str:
    """Return the row of a number; a note that it needs joins ``notes``."""
    value, run = found.get(number.key, (math.nan, None))
    said: str = number.outcome(value)
    missing = NO_CHECK if run is None and said == "untested" else ""
    texts = [number.untested or missing, number.note]
    texts.append(f"Erratum {number.erratum}." if number.erratum is not None else "")
    verdict, ours = badge(said), ""
    if note := " ".join(filter(None, texts)):
        verdict += f"{SPACE}<sup>{notes.setdefault(note, chr(ord('a') + len(notes)))}</sup>"
    if run:
        ours = "<br>".join(filter(None, (ours_text(number, value), run.beside, run.link())))
        verdict += training_text(run.crops)
    key = re.sub(r"(\.|_(?!\d))", r"\1<wbr>", number.key.partition(".")[2])  # a phone's lines
    what = re.sub(r" ([<≥]) (?=\d)", rf"{SPACE}\1{SPACE}", number.what)
    paper = number.text(joint="<br>").replace(" ", SPACE)
    ours = ours.replace(" ×", f"{SPACE}×")
    return f"| {what}<br><code>{key}</code> | {paper} | {ours} | {verdict} |"


def _split(group: str) -> tuple[str, str]:
    name = group.rstrip("0123456789")
    return name, group[len(name) :]


def _order(group: str) -> tuple[int, int]:
    name, digits = _split(group)
    return list(GROUPS).index(name), int(digits or 0)


ITEMS = [
    f"{kind} {number}"
    for kind, count in (("Figure", 16), ("Table", 4), ("Equation", 20))
    for number in range(1, count + 1)
]

_DRAWN = re.compile(r"(fig|table)(\d+)_")
_CHECKED = re.compile(r"table(\d)\.")
_LABELLED = re.compile(r":label: eq-(\d+)\b(?!-)")


def chapters_by_item(records: Iterable[Record], notebooks: Iterable[Path]) -> dict[str, list[str]]:
    """Return the chapters in which each item stands; an item that no chapter has is left out.

    A figure stands where ``figNN_*`` was drawn, a table where ``tableN_*`` was drawn or its numbers
    were checked, an equation where it bears the label ``eq-N``. ``notebooks`` are the chapters.
    """
    found: dict[str, set[str]] = {}
    kinds = {"fig": "Figure", "table": "Table"}
    for record in records:
        if drawn := _DRAWN.match(record.name):
            found.setdefault(f"{kinds[drawn[1]]} {int(drawn[2])}", set()).add(record.chapter)
        for key in record.numbers if record.name == PAPER else ():
            if checked := _CHECKED.match(key):
                found.setdefault(f"Table {checked[1]}", set()).add(record.chapter)
    for notebook in notebooks:
        for number in _LABELLED.findall(notebook.read_text(encoding="utf-8")):
            found.setdefault(f"Equation {number}", set()).add(notebook.stem)
    return {item: sorted(chapters) for item, chapters in found.items()}


def coverage_section(records: Iterable[Record], notebooks: Iterable[Path]) -> str:
    """Return the section on figures, tables and equations as MyST Markdown."""
    found = chapters_by_item(records, notebooks)
    missing = [item for item in ITEMS if item not in found]
    said = f"Not yet reached: {', '.join(missing)}." if missing else "None of them is missing."
    links = {item: ", ".join(map(chapter_link, found[item])) for item in ITEMS if item in found}
    rows = [f"| {item} | {chapters} |" for item, chapters in links.items()]
    head = ["## Figures, tables and equations", "", "Where each of the paper's stands. " + said, ""]
    return "\n".join([*head, "| of the paper | chapters |", "| :-- | :-- |", *rows, ""])
