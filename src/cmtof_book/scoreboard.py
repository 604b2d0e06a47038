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

import numpy as np

from cmtof.types import Fields
from cmtof_book import pages
from cmtof_book.paper import published_numbers
from cmtof_book.record import PAPER, Record
from cmtof_book.verdict import RANK, Score

Scores = dict[str, Score]  # all published numbers with our results, by key

GROUPS = {"table": "Table", "fig": "Figure", "abstract": "Abstract", "sec": "Section"}
# What the paper has by the word before its number, and how many: figures and tables that were
# drawn, or checked, if it is a number of a table; equations that bear their number.
ITEMS = {"fig": ("Figure", 16), "table": ("Table", 4), r"\tag{": ("Equation", 20)}
REACHED = re.compile(r"(^fig(?=\d+_)|^table(?=\d+[_.])|\\tag\{(?=\d+\}))(\d+)")

SPAN = 30  # greatest ratio that is drawn, and its inverse
SHOWN = ("reproduced", "contradicted", "open")


def scores_in(records: Sequence[Record]) -> Scores:
    """Every published number with the result of the first chapter that checked it."""
    scores = {key: Score(number, {}) for key, number in published_numbers().items()}
    for record in reversed(records):
        if record.name == PAPER:
            about = {
                "profile": record.content["provenance"]["profile"],
                "chapter": record.chapter,
            }
            for key, held in record.numbers.items():
                scores[key] = Score(scores[key].number, **held | about)
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
    """Tables, figures and sections of the paper: title, numbers, and letters for their notes."""
    for kind, title in GROUPS.items():
        chosen = [key for key in scores if key.startswith(kind)]
        for group, keys in groupby(chosen, lambda key: key.partition(".")[0]):
            numbers = [scores[key] for key in keys]
            notes = filter(None, dict.fromkeys(one.note for one in numbers))
            yield {
                "title": f"{title} {group.removeprefix(kind)}".strip(),
                "counts": counts(numbers),
                "numbers": numbers,
                "notes": dict(zip(notes, ascii_lowercase, strict=False)),
            }


def picture(scores: Scores) -> str:
    """Return the picture of our results over the paper's as MyST Markdown."""
    drawn = [
        one for one in scores.values() if one.number.value and one.verdict in SHOWN
    ]
    kinds = {name: counts(drawn)[name] for name in SHOWN}
    return pages.page("ratios", drawn=drawn, kinds=kinds, span=SPAN, across=_across)


def _across(ratio: float) -> float:
    """Place of a ratio on a log scale: 50 for 1, 98 for `SPAN` or more, 2 for 1/`SPAN` or less."""
    return round(50 + 48 * math.log(np.clip(ratio, 1 / SPAN, SPAN), SPAN), 1)


def coverage(
    records: Iterable[Record], notebooks: Iterable[Path]
) -> dict[str, list[str]]:
    """Return the chapters in which each figure, table and equation of the paper stands.

    A figure stands where ``figNN_*`` was drawn, a table where ``tableN_*`` was drawn or its numbers
    were checked, an equation where it bears its number. ``notebooks`` are the chapters.
    """
    held = [(one.stem, one.read_text("utf-8")) for one in notebooks]
    for one in records:
        held += [(one.chapter, name) for name in (one.name, *one.numbers)]
    found = defaultdict(set)
    for chapter, text in held:
        for kind, number in REACHED.findall(text):
            found[kind, int(number)].add(chapter)
    return {
        f"{title} {n}": sorted(found[kind, n])
        for kind, (title, count) in ITEMS.items()
        for n in range(1, count + 1)
    }
