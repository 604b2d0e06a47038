"""The verdict on a published number, by one rule.

A number is *reproduced* where ours agrees and could have disagreed; *contradicted* where ours
differs and everything that it depends on is the paper's; *open* otherwise. A setting is *as stated*
or *changed*. What nobody can compare is *untested*.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from cmtof_book.paper import Published

CROPS = 500_000  # on which the paper's networks were trained: 1000 epochs of 500 (Sec. 8.1)
WIDEST = 3  # an interval over so great a factor, or so many tolerances, decides nothing

Outcome = Literal["reproduced", "contradicted", "open", "as stated", "changed", "untested"]
WORST_FIRST: tuple[Outcome, ...] = (
    "contradicted",
    "open",
    "untested",
    "changed",
    "as stated",
    "reproduced",
)
Place = Literal["inside", "outside", "undecided"]
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
class Result:
    """Our estimates of one number, by case, and with what they were made."""

    cases: dict[str, Estimate] = field(default_factory=dict)
    profile: str = "book"
    crops: int = 0  # on which the network was trained

    @classmethod
    def of(cls, value: Value | Mapping[str, Value], profile: str, crops: int) -> Result:
        """From one number, or from several by their case; what is not finite is left out."""
        given = value if isinstance(value, Mapping) else {"": value}
        cases = {case: Estimate.of(one) for case, one in given.items()}
        return cls({c: one for c, one in cases.items() if np.isfinite(one).all()}, profile, crops)


@dataclass(frozen=True)
class Dependency:
    """Something on which a number depends, and whether ours is the paper's."""

    name: str
    same: bool | list[str]
    ours: str
    short: str = ""
    decides: str = ""

    def is_papers(self, result: Result) -> bool:
        """Whether a result was made with the paper's."""
        if self.name == "training":
            return result.crops >= CROPS
        return self.same if isinstance(self.same, bool) else result.profile in self.same

    def text(self, result: Result) -> str:
        """What we have."""
        return self.ours.format(crops=result.crops)


def place_of(number: Published, ours: Estimate) -> Place:
    """Whether the paper's number agrees with an estimate, disagrees, or neither can be said."""
    # the slack keeps a value on the very edge from failing by the last bit of a float
    slack = number.tolerance + 4e-16 * (abs(ours.value) + abs(number.value))
    if number.relation in ("lt", "gt"):
        sign = 1 if number.relation == "lt" else -1
        met = {sign * (end - number.value) < number.tolerance for end in (ours.low, ours.high)}
        return "undecided" if len(met) == 2 else "inside" if met.pop() else "outside"
    if max(ours.low - number.value, number.value - ours.high) > slack:
        return "outside"
    near = abs(ours.value - number.value) <= slack
    return "inside" if near and ours.is_narrow(number.tolerance) else "undecided"


def differing(number: Published, result: Result) -> list[Dependency]:
    """What the number depends on that is not the paper's."""
    return [one for one in number.dependencies() if not one.is_papers(result)]


def verdict(number: Published, result: Result | None) -> Outcome:
    """The verdict; every case counts."""
    places = {place_of(number, one) for one in result.cases.values()} if result else set()
    if result is None or not places:
        return "untested"
    if number.kind == "setting":
        return "as stated" if places == {"inside"} else "changed"
    others = differing(number, result)
    if number.untested or any(one.name == "sizes" for one in others):
        return "untested"
    if places == {"inside"}:
        return "reproduced"
    return "contradicted" if places == {"outside"} and not others else "open"


def reason(number: Published, result: Result | None) -> str:
    """What stands behind the verdict: what is undecided, and what is not the paper's."""
    if number.untested or result is None or not result.cases:
        return number.untested or "No chapter computes it."
    if number.kind == "setting":
        return number.changed if verdict(number, result) == "changed" else ""
    others = differing(number, result)
    small = [one.text(result) for one in others if one.name == "sizes"]
    told = [f"{one[0].upper()}{one[1:]}." for one in undecided(number, result)]
    return " ".join(small or [*told, *(one.text(result) for one in others)])


def deciding(number: Published, result: Result | None) -> list[str]:
    """What would decide an open number."""
    if result is None or verdict(number, result) != "open":
        return []
    found = [one.decides.rstrip(".") for one in differing(number, result)]
    return [f"It would be decided by: {'; '.join(found)}."] if found else []


def undecided(number: Published, result: Result) -> list[str]:
    """What our own numbers leave undecided: cases that disagree, an interval that is too wide."""
    cases: dict[Place, list[str]] = {}
    for case, one in result.cases.items():
        cases.setdefault(place_of(number, one), []).append(case)
    if cases.keys() == {"undecided"}:
        return ["our interval is too wide to decide"]
    if len(cases) == 1:
        return []
    agree = " and ".join(cases.get("inside", []))
    wide = " and ".join(cases.get("undecided", []))
    return [f"it agrees {agree}, not otherwise" if agree else f"our interval is too wide {wide}"]
