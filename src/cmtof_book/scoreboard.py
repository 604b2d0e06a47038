"""The scoreboard page of the book: the published numbers, ours, and the verdicts.

Written from the records of each run (`cmtof_book.record`) and from the equations of the chapters.
Where several chapters checked one number, the first is shown. A picture sets our results over the
paper's, a line for each number. It is HTML, so that it reads on a phone and in the dark; the
script of the book hides the lines that a reader does not want.
"""

import math
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from pathlib import Path
from string import ascii_lowercase

from cmtof.types import Fields
from cmtof_book import pages
from cmtof_book.paper import published_numbers
from cmtof_book.record import PAPER, Record
from cmtof_book.verdict import RANK, Score

Scores = dict[str, Score]  # all published numbers with our results, by key

GROUPS = {"table": "Table", "fig": "Figure", "abstract": "Abstract", "sec": "Section"}
ITEMS = {"Figure": 16, "Table": 4, "Equation": 20}  # how many of each the paper has

# What was drawn; or checked, if it is a number of a table.
DRAWN = re.compile(r"^(fig(?=\d+_)|table)(\d+)[_.]", re.MULTILINE)

NUMBERED = re.compile(r"\\tag\{(\d+)\}")

SPAN = 30  # greatest ratio that is drawn, and its inverse
SHOWN = ("reproduced", "contradicted", "open")


def scores_in(records: Sequence[Record]) -> Scores:
    """Every published number with the result of the first chapter that checked it."""
    scores = {key: Score(number, {}) for key, number in published_numbers().items()}
    for record in reversed(records):
        for key, held in record.numbers.items() if record.name == PAPER else ():
            scores[key] = Score(
                scores[key].number,
                held["cases"],
                profile=record.content["provenance"]["profile"],
                crops=held["crops"],
                chapter=record.chapter,
            )
    return scores


def page(
    scores: Scores, records: Iterable[Record] = (), notebooks: Iterable[Path] = ()
) -> str:
    """Return the page as MyST Markdown; ``notebooks`` are the chapters themselves."""
    return pages.page(
        "scoreboard",
        counts=counts(scores.values()),
        picture=picture(scores),
        sections=sections(scores),
        coverage=coverage(records, notebooks),
        rank=RANK,
        breakable=lambda key: re.sub(r"(\.|_(?!\d))", r"\1<wbr>", key),
    )


def counts(scores: Iterable[Score]) -> dict[str, int]:
    """How many numbers have each verdict."""
    return dict.fromkeys(RANK, 0) | Counter(score.verdict for score in scores)


def accepted_scores(scores: Scores) -> Fields:
    """Return the scoreboard for ``figures/scoreboard.json``: counts, and each number's verdict."""
    numbers = {
        key: {"paper": score.number.value, "unit": score.number.unit}
        | {
            name: getattr(score, name)
            for name in ("verdict", "cases", "profile", "crops", "chapter")
        }
        for key, score in sorted(scores.items())
        if score.chapter
    }
    return {"counts": counts(scores.values()), "numbers": numbers}


def sections(scores: Scores) -> Iterator[Fields]:
    """Tables, figures and sections of the paper: title, numbers, and the notes below them."""
    for kind, title in GROUPS.items():
        chosen = [key for key in scores if key.startswith(kind)]
        for group, keys in groupby(chosen, lambda key: key.partition(".")[0]):
            numbers = [scores[key] for key in keys]
            texts = filter(None, dict.fromkeys(map(note, numbers)))
            notes = dict(zip(texts, ascii_lowercase, strict=False))
            yield {
                "title": f"{title} {group.removeprefix(kind)}".strip(),
                "counts": counts(numbers),
                "rows": [(one, notes.get(note(one))) for one in numbers],
                "notes": notes,
            }


def note(score: Score) -> str:
    """Everything that is to be said about a number under its table."""
    number = score.number
    erratum = f"Erratum {number.erratum}." if number.erratum else ""
    return " ".join(filter(None, (score.reason, number.note, score.deciding, erratum)))


def picture(scores: Scores) -> str:
    """Return the picture of our results over the paper's as MyST Markdown."""
    drawn = [
        one for one in scores.values() if one.number.value and one.verdict in SHOWN
    ]
    kinds = {name: counts(drawn)[name] for name in SHOWN}
    return pages.page("ratios", drawn=drawn, kinds=kinds, span=SPAN, across=_across)


def _across(ratio: float) -> float:
    """Place of a ratio on a log scale: 50 for 1, 98 for `SPAN` or more, 2 for 1/`SPAN` or less."""
    held = min(max(ratio, 1 / SPAN), SPAN)
    return round(50 + 48 * math.log(held, SPAN), 1)


def coverage(
    records: Iterable[Record], notebooks: Iterable[Path]
) -> dict[str, list[str]]:
    """Return the chapters in which each figure, table and equation of the paper stands.

    A figure stands where ``figNN_*`` was drawn, a table where ``tableN_*`` was drawn or its numbers
    were checked, an equation where it bears its number. ``notebooks`` are the chapters.
    """
    found = defaultdict(set)
    for record in records:
        names = record.numbers if record.name == PAPER else [record.name]
        for kind, number in DRAWN.findall("\n".join(names)):
            found[f"{GROUPS[kind]} {int(number)}"].add(record.chapter)
    for notebook in notebooks:
        for number in NUMBERED.findall(notebook.read_text("utf-8")):
            found[f"Equation {number}"].add(notebook.stem)
    items = (f"{kind} {n + 1}" for kind, count in ITEMS.items() for n in range(count))
    return {item: sorted(found[item]) for item in items}
