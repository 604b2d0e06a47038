"""The verdict on a published number, by one rule.

A number is *reproduced* where ours agrees and could have disagreed; *contradicted* where ours
differs and everything that it depends on is the paper's; *open* otherwise. A setting is *as stated*
or *changed*. What nobody can compare is *untested*.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from cmtof_book.paper import Published

# on which the paper's networks were trained: 1000 epochs of 500 (Sec. 8.1)
CROPS = 500_000
WIDEST = 3  # an interval over so great a factor, or so many tolerances, decides nothing

Outcome = Literal[
    "reproduced", "contradicted", "open", "untested", "as stated", "changed"
]
WORST_FIRST: tuple[Outcome, ...] = (
    "contradicted",
    "open",
    "untested",
    "changed",
    "as stated",
    "reproduced",
)
Place = Literal["inside", "outside", "undecided"]
BESIDE = {
    "inside": "ours agrees",
    "outside": "ours differs",
    "undecided": "our interval is too wide",
}
Value = float | Sequence[float]


class Estimate(NamedTuple):
    """A number of ours with the ends of its 95 % interval, equal where it has no error."""

    value: float
    low: float
    high: float

    @classmethod
    def of(cls, given: Value) -> Estimate:
        """From a number, or from a number and the ends of its interval."""
        return cls(*np.broadcast_to(np.asarray(given, float), 3).tolist())

    def is_narrow(self, tolerance: float) -> bool:
        """Whether the interval is narrow enough to have missed the paper's number."""
        width = self.high - self.low
        return width <= min(WIDEST * tolerance, (WIDEST - 1) * abs(self.low))


@dataclass(frozen=True)
class Dependency:
    """Something on which a number depends, and whether ours is the paper's."""

    name: str
    same: bool | list[str]
    ours: str
    short: str = ""
    decides: str = ""

    def is_papers(self, score: Score) -> bool:
        """Whether our number was made with the paper's."""
        if self.name == "training":
            return score.crops >= CROPS
        return self.same if isinstance(self.same, bool) else score.profile in self.same

    def text(self, score: Score) -> str:
        """What we have."""
        return self.ours.format(crops=score.crops)


def place_of(number: Published, ours: Estimate) -> Place:
    """Whether the paper's number agrees with an estimate, disagrees, or neither can be said."""
    # the slack keeps a value on the very edge from failing by the last bit of a float
    slack = number.tolerance + 4e-16 * (abs(ours.value) + abs(number.value))
    if sign := {"lt": 1, "gt": -1}.get(number.relation):
        met = [sign * (end - number.value) < number.tolerance for end in ours[1:]]
        return "inside" if all(met) else "undecided" if any(met) else "outside"
    if max(ours.low - number.value, number.value - ours.high) > slack:
        return "outside"
    near = abs(ours.value - number.value) <= slack
    return "inside" if near and ours.is_narrow(number.tolerance) else "undecided"


@dataclass(frozen=True)
class Score:
    """A published number beside ours, by case, and what follows from the two."""

    number: Published
    cases: dict[str, Estimate] = field(default_factory=dict)
    profile: str = "book"
    crops: int = 0  # on which the network was trained
    chapter: str = ""  # that computed ours

    @classmethod
    def of(
        cls, number: Published, value: Value | Mapping[str, Value], **about: Any
    ) -> Score:
        """From one number of ours, or several by their case; what is not finite is left out."""
        given = value if isinstance(value, Mapping) else {"": value}
        cases = {case: Estimate.of(one) for case, one in given.items()}
        finite = {case: one for case, one in cases.items() if np.isfinite(one).all()}
        return cls(number, finite, **about)

    @property
    def places(self) -> dict[Place, list[str]]:
        """Our cases by their place beside the paper's number."""
        places: dict[Place, list[str]] = {}
        for case, one in self.cases.items():
            places.setdefault(place_of(self.number, one), []).append(case)
        return places

    @property
    def differing(self) -> list[Dependency]:
        """What the number depends on that is not the paper's."""
        return [one for one in self.number.dependencies() if not one.is_papers(self)]

    @property
    def small(self) -> list[Dependency]:
        """The sizes of a quick build, which decide nothing."""
        return [one for one in self.differing if one.name == "sizes"]

    @property
    def verdict(self) -> Outcome:
        """The verdict; every case counts."""
        found = set(self.places)
        if self.number.kind == "setting" and found:
            return "as stated" if found == {"inside"} else "changed"
        if self.number.untested or self.small or not found:
            return "untested"
        if found == {"inside"}:
            return "reproduced"
        return "contradicted" if found == {"outside"} and not self.differing else "open"

    @property
    def undecided(self) -> str:
        """What our own number leaves undecided: cases that disagree, or too wide an interval."""
        places = self.places
        if len(places) < 2 and "undecided" not in places:
            return ""
        told = (f"{BESIDE[one]} {' and '.join(cases)}" for one, cases in places.items())
        return "; ".join(told).strip()

    @property
    def reason(self) -> str:
        """What stands behind the verdict: what is undecided, and what is not the paper's."""
        if self.number.untested or not self.places:
            return self.number.untested or "No chapter computes it."
        if self.number.kind == "setting":
            return self.number.changed if self.verdict == "changed" else ""
        told = [] if self.small else [sentence(self.undecided)]
        told += [one.text(self) for one in self.small or self.differing]
        return " ".join(filter(None, told))

    @property
    def deciding(self) -> str:
        """What would decide an open number."""
        found = [one.decides.rstrip(".") for one in self.differing]
        if self.verdict != "open" or not found:
            return ""
        return f"It would be decided by: {'; '.join(found)}."


def worst(scores: Iterable[Score]) -> Score:
    """The score of the worst verdict, the first of several."""
    return min(scores, key=lambda one: WORST_FIRST.index(one.verdict))


def sentence(text: str) -> str:
    """A text as a sentence of its own; none if there is no text."""
    return f"{text[0].upper()}{text[1:]}." if text else ""
