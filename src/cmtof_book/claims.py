"""The paper's ten main claims: the table on the first page, a page each, and our own findings."""

import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from cmtof.files import read_document
from cmtof.types import Texts
from cmtof_book import Values, pages
from cmtof_book.paper import estimate_text, result_text
from cmtof_book.record import TEXT, Record
from cmtof_book.scoreboard import Scores
from cmtof_book.verdict import Estimate, Score, sentence, worst

TOKEN = re.compile(r"\{([^{}|]+)(?:\|([^{}]+))?\}")
UNIT = re.compile(r"(?<=\d) (?=[%µ]|[GM]?Hz|rad|points|[fkmp]?[ms]\b)")


class Claim(NamedTuple):
    """One main claim, what ``claims.yml`` tells about it, and the numbers that decide it."""

    name: str
    about: Values
    scores: list[Score]

    @property
    def outcome(self) -> str:
        """The worst verdict of its numbers."""
        return worst(self.scores)

    @property
    def why(self) -> str:
        """What stands behind that verdict, in one line."""
        behind = [one for one in self.scores if one.verdict == self.outcome]
        if self.outcome == "untested":
            return behind[0].reason
        differing = [one.short for score in behind for one in score.differing]
        told = ", ".join(dict.fromkeys(differing))
        if told and self.outcome == "reproduced":
            return f"It holds although {told} differ or are not stated."
        lines = self.left_open(behind)
        if told:
            lines.append(f"Different or not stated: {told}.")
        return " ".join(lines) or behind[0].number.depends[0].ours

    def left_open(self, behind: Iterable[Score]) -> list[str]:
        """What our numbers leave undecided, with the names of those where there are several."""
        names: dict[str, list[str]] = {}
        for one in behind:
            called = self.about["keys"][one.number.key]
            names.setdefault(one.undecided, []).append(called)
        names.pop("", None)
        return [
            sentence(f"{' and '.join(called)}: {text}".removeprefix(": "))
            for text, called in names.items()
        ]

    @property
    def dependencies(self) -> dict[str, bool]:
        """What we have of each thing on which its numbers depend, and whether it is the paper's."""
        held: dict[str, tuple[str, bool]] = {}
        for score in sorted(self.scores, key=lambda one: not one.chapter):
            for one in score.number.depends:
                held.setdefault(one.name, (score.ours(one), score.has_papers(one)))
        if held.get("sizes", ("", False))[1]:
            del held["sizes"]  # the book's own
        return dict(held.values())


@cache
def _document() -> Values:
    return read_document(Path(__file__).with_name("claims.yml"))


def claims(scores: Scores) -> list[Claim]:
    """The ten claims, in the order of the paper."""
    return [
        Claim(name, held, [scores[key] for key in held["keys"]])
        for name, held in _document()["claims"].items()
    ]


class Numbers:
    """All numbers of a build: our results, and those that its figures and its pages tell."""

    def __init__(self, scores: Scores, records: Iterable[Record]) -> None:
        self.scores = scores
        self.records = {f"{one.chapter}/{one.name}": one for one in records}

    def fill(self, text: str) -> str:
        """Put numbers into a text of ``claims.yml``."""
        filled = TOKEN.sub(lambda token: self.number(token[1], token[2] or ""), text)
        return UNIT.sub("\u00a0", filled)

    def number(self, name: str, style: str) -> str:
        """One number as text: by the key of a published one, of a figure, or of a page.

        ``key@0`` is our first case of a published number, and the style ``alone`` leaves out its
        interval.
        """
        key, _, case = name.partition("@")
        if score := self.scores.get(key):
            if not score.cases:
                return "(not computed)"
            if not case:
                return result_text(score, 3)
            one = [*score.cases.values()][int(case)]
            shown = Estimate(*[one.value] * 3) if style == "alone" else one
            return estimate_text(shown, score.number.unit, 3)
        figure, *path = name.replace(":", f"/{TEXT}.").split(".")
        held: Any = self.records[figure].numbers
        for step in path:
            held = held[int(step) if isinstance(held, list) else step]
            held = held["value"] if isinstance(held, dict) and "kind" in held else held
        return f"{held:{style}}".replace("%", " %")


def texts(numbers: Numbers) -> Texts:
    """Pages by name: each claim's, the table of the first page, and what we found beyond the paper.

    The table has each claim, our answer, the verdict and why. A claim's figure is that of a build.
    """
    every = claims(numbers.scores)
    found = _document()["findings"]
    made = {
        "claims": pages.page("claims", claims=every, fill=numbers.fill),
        "findings": pages.page("findings", findings=found, fill=numbers.fill),
    }
    for claim in every:
        drawn = numbers.records["{chapter}/{figure}".format(**claim.about)].content
        text = pages.page("claim", claim=claim, drawn=drawn, fill=numbers.fill)
        made[f"claims/{claim.name}"] = text
    return made
