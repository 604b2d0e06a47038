"""The paper's ten main claims: the table on the first page, a page each, and our own findings."""

from collections import defaultdict
from collections.abc import Iterable
from functools import partial
from typing import NamedTuple

from cmtof.types import Fields, Texts
from cmtof_book import package_data, pages
from cmtof_book.notes import replaced
from cmtof_book.paper import estimate_text, quantity_text, result_text
from cmtof_book.record import Record
from cmtof_book.scoreboard import Scores
from cmtof_book.verdict import RANK, Score, sentence

DOCUMENT = package_data("claims")
UNITS = {  # set apart from their number, on the same line
    r"(?<=\d)%": " %",
    r"(?<=\d) (?=[%µ]|[GM]?Hz|rad|points|[fkmp]?[ms]\b)": "\u00a0",
}


class Claim(NamedTuple):
    """One main claim, what ``claims.yml`` tells about it, and the numbers that decide it."""

    name: str
    about: Fields
    scores: list[Score]

    @property
    def outcome(self) -> str:
        """The worst verdict of its numbers."""
        return min((one.verdict for one in self.scores), key=RANK.__getitem__)

    @property
    def why(self) -> str:
        """Why the claim has this outcome, in one line, with names if its numbers differ in it."""
        behind = [one for one in self.scores if one.verdict == self.outcome]
        if self.outcome == "untested":
            return behind[0].untested
        told = ", ".join(
            dict.fromkeys(one.short for score in behind for one in score.differing)
        )
        if told and self.outcome == "reproduced":
            return f"It holds although {told} differ or are not stated."
        names = defaultdict(list)
        for one in behind:
            names[one.undecided].append(self.about["keys"][one.number.key])
        lines = [
            sentence(f"{' and '.join(called)}: {text}".removeprefix(": "))
            for text, called in names.items()
            if text
        ]
        if told:
            lines.append(f"Different or not stated: {told}.")
        return " ".join(lines) or behind[0].number.depends[0].ours

    @property
    def dependencies(self) -> dict[str, bool]:
        """Whether each thing on which the numbers depend is the paper's, by a text on ours."""
        held = {}
        for score in self.scores:
            for one in score.number.depends:
                is_papers = score.has_papers(one)
                if one.name != "sizes" or not is_papers:  # they are the book's own
                    held.setdefault(one.name, (score.ours(one), is_papers))
        return dict(held.values())


def claims(scores: Scores) -> list[Claim]:
    """The ten claims, in the order of the paper."""
    return [
        Claim(name, held, [scores[key] for key in held["keys"]])
        for name, held in DOCUMENT["claims"].items()
    ]


def numbers_of(scores: Scores, records: Iterable[Record]) -> Fields:
    """All numbers of a build, as the texts of ``claims.yml`` name them."""
    results = defaultdict(lambda: "(not computed)")
    for key, score in scores.items():
        unit = score.number.unit
        for place, one in enumerate(score.cases.values()):
            results[key] = result_text(score, 3)
            results[f"{key}@{place}"] = estimate_text(one, unit, 3)
            results[f"{key}@{place} alone"] = quantity_text(one.value, unit, 3)
    figures = {
        f"{record.chapter}/{record.name}": {
            name: one.get("value", one) if isinstance(one, dict) else one
            for name, one in record.numbers.items()
        }
        for record in records
    }
    return {"p": results, "f": figures}


def fill_in(text: str, numbers: Fields) -> str:
    """Put numbers into a text of ``claims.yml``; a line never breaks before a unit."""
    return replaced(text.format(**numbers), UNITS)


def texts(scores: Scores, records: list[Record]) -> Texts:
    """Pages by name: each claim's, the table of the first page, and what we found beyond the paper.

    The table has each claim, our answer, the verdict and why. A claim's figure is that of a build.
    """
    numbers = numbers_of(scores, records)
    page = partial(pages.page, fill=partial(fill_in, numbers=numbers))
    every = claims(scores)
    drawn = {record.name: record.content for record in records}
    shown = {
        "claims": page("claims", claims=every),
        "findings": page("findings", findings=DOCUMENT["findings"]),
    }
    return shown | {
        f"claims/{one.name}": page("claim", claim=one, drawn=drawn[one.about["figure"]])
        for one in every
    }
