"""The scoreboard page of the book: the published numbers, ours, and the verdicts.

Written from the records of each run (`cmtof_book.record`) and from the equations of the chapters.
Where several runs checked one number, the worst verdict is shown.
"""

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from cmtof_book import ratios
from cmtof_book.claims import badge
from cmtof_book.paper import Published, published, published_numbers, result_text
from cmtof_book.record import PAPER, Record
from cmtof_book.verdict import WORST_FIRST, Outcome, Result, deciding, reason, verdict

MEANING: dict[Outcome, str] = {
    "reproduced": "The paper's number lies within our tolerance, and our uncertainty is small "
    "enough to have missed it.",
    "contradicted": "It lies outside our 95 % interval, and everything on which the number depends "
    "is the paper's.",
    "open": "It lies outside, but something on which it depends is not the paper's; or our "
    "interval is too wide; or two cases of ours disagree. The note says which.",
    "untested": "No result of ours can be compared with it; the note says why.",
    "as stated": "A setting of the paper that is ours too.",
    "changed": "A setting that is another one here; the note says why.",
}

GROUPS = {"table": "Table", "fig": "Figure", "abstract": "Abstract", "sec": "Section"}

SPACE = "\N{NO-BREAK SPACE}"

HEAD = """# Scoreboard

Each number that the paper {{cite}}`baek2023` reports or chooses, beside this book's, in simulation.
The ten main claims stand on the {{doc}}`first page <intro>`.

{meanings}

{summary}

## Our results over the paper's

{picture}

## Number by number

The tables fold out, one for each figure, table and section. The tolerance stands beside the paper's
number. It is half a unit of the last digit printed, in Tables 1 to 3 two percentage points, or a
fifth of the number where that is less. Brackets hold 95 % intervals.
"""


Found = dict[str, tuple[Result, str]]
"""Our result and the chapter that computed it, by key."""


def chapter_link(notebook: str) -> str:
    """Return a link to a chapter by its number."""
    return f"{{doc}}`{notebook[:2]} <../notebooks/{notebook}>`"


def page(found: Found, records: Iterable[Record] = (), notebooks: Iterable[Path] = ()) -> str:
    """Return the page as MyST Markdown, from what was found and the records of all runs.

    ``notebooks`` are the chapters themselves; ValueError for an unknown key.
    """
    groups: dict[str, list[Published]] = {}
    for number in published_numbers().values():
        groups.setdefault(number.key.partition(".")[0], []).append(number)
    meanings = "\n".join(f"- {badge(name)} {text}" for name, text in MEANING.items())
    picture = ratios.picture({key: result for key, (result, _) in found.items()})
    parts = [HEAD.format(meanings=meanings, summary=summary(found), picture=picture)]
    parts += [section(name, groups[name], found) for name in sorted(groups, key=_order)]
    parts.append(coverage_section(records, notebooks))
    return "\n".join(parts)


def found_in(records: Iterable[Record]) -> Found:
    """Return the results of runs, that of the worst verdict where several checked one number."""
    found: Found = {}
    for record in records:
        profile = record.content.get("provenance", {}).get("profile", "")
        for key, number in record.numbers.items() if record.name == PAPER else ():
            result = Result.of(number["cases"], profile, number["crops"])
            if key not in found or _rank(key, result) < _rank(key, found[key][0]):
                found[key] = (result, record.chapter)
    return found


def accepted(records: Iterable[Record]) -> dict[str, Any]:
    """Return the scoreboard for ``figures/scoreboard.json``: counts, and each number's verdict."""
    found = found_in(records)
    numbers = {}
    for key, (result, chapter) in sorted(found.items()):
        number = published(key)
        held = {"paper": number.value, "unit": number.unit, "verdict": verdict(number, result)}
        numbers[key] = held | asdict(result) | {"chapter": chapter}
    counts = verdicts(published_numbers().values(), found)
    return {"counts": {name: counts[name] for name in MEANING}, "numbers": numbers}


def _rank(key: str, result: Result) -> int:
    return WORST_FIRST.index(verdict(published(key), result))


def verdicts(numbers: Iterable[Published], found: Found) -> Counter[Outcome]:
    """Return how many numbers have each verdict."""
    return Counter(verdict(number, found.get(number.key, (None,))[0]) for number in numbers)


def summary(found: Found) -> str:
    """Return the table of verdicts."""
    counts = verdicts(published_numbers().values(), found)
    rows = [f"| {badge(name)} | {counts[name]} |" for name in MEANING]
    total = f"| **numbers** | **{counts.total()}** |"
    return "\n".join(["| verdict | numbers |", "| :-- | --: |", *rows, total])


def section(group: str, numbers: list[Published], found: Found) -> str:
    """Return the table of one table, figure or section of the paper, with its notes."""
    notes: dict[str, str] = {}
    rows = [row(number, found, notes) for number in numbers]
    name, digits = _split(group)
    said = verdicts(numbers, found)
    counted = ", ".join(f"{said[one]} {one}" for one in WORST_FIRST if said[one])
    head = [f":::{{dropdown}} {GROUPS[name]} {digits}".rstrip() + f": {counted}", ""]
    table = ["| number | paper | ours | verdict |", "| :-- | :-- | :-- | :-- |", *rows, ""]
    return "\n".join([*head, *table, *(f"**{c}** {text}\n" for text, c in notes.items()), ":::\n"])


def row(number: Published, found: Found, notes: dict[str, str]) -> str:
    """Return the row of a number; a note that it needs joins ``notes``."""
    result, chapter = found.get(number.key, (None, ""))
    texts = [reason(number, result), number.note, *deciding(number, result)]
    texts.append(f"Erratum {number.erratum}." if number.erratum is not None else "")
    said, ours = badge(verdict(number, result)), ""
    if note := " ".join(filter(None, texts)):
        said += f"{SPACE}<sup>{notes.setdefault(note, chr(ord('a') + len(notes)))}</sup>"
    if result:
        ours = f"{result_text(number, result).replace('; ', '<br>')}<br>{chapter_link(chapter)}"
    key = re.sub(r"(\.|_(?!\d))", r"\1<wbr>", number.key.partition(".")[2])  # a phone's lines
    what = re.sub(r" ([<≥]) (?=\d)", rf"{SPACE}\1{SPACE}", number.what)
    paper = number.text(joint="<br>").replace(" ", SPACE)
    return f"| {what}<br><code>{key}</code> | {paper} | {ours} | {said} |"


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
