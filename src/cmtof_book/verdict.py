"""The verdict on a published number, by one rule.

A number is *reproduced* where ours agrees and could have disagreed; *contradicted* where ours
differs and everything that it depends on is the paper's; *open* otherwise. A setting is *as stated*
or *changed*. What nobody can compare is *untested*.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import BeforeValidator
from pydantic.dataclasses import dataclass

# on which the paper's networks were trained: 1000 epochs of 500 (Sec. 8.1)
CROPS = 500_000
WIDEST = 3  # an interval over so great a factor, or so many tolerances, decides nothing

# Verdicts, and their rank from the worst on.
RANK = {
    "reproduced": 5,
    "contradicted": 0,
    "open": 1,
    "untested": 2,
    "as stated": 4,
    "changed": 3,
}
BESIDE = {
    "inside": "ours agrees",
    "outside": "ours differs",
    "undecided": "our interval is too wide",
}
Value = float | Sequence[float]


class OwnNumber(NamedTuple):
    """A number of ours with the ends of its 95 % interval, equal where it has no error."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Dependency:
    """Something on which a number depends, and whether ours is the paper's."""

    name: str
    ours: str
    same: tuple[str, ...] = ()  # the profiles in which it is
    short: str = ""
    decides: str = ""


@dataclass(frozen=True, kw_only=True)
class Published:
    """One number of the paper, as ``paper.yml`` explains it; SI units, percentages as fractions."""

    key: str
    value: int | float
    unit: str
    where: str
    what: str
    relation: Literal["eq", "approx", "lt", "gt"]
    tolerance: float
    kind: Literal["result", "setting"]
    depends: tuple[Dependency, ...] = ()
    untested: str = ""
    changed: str = ""
    note: str = ""
    erratum: int | None = None

    def place_of(self, ours: OwnNumber) -> str:
        """Whether the number agrees with an estimate, disagrees, or neither can be said."""
        if sign := {"lt": 1, "gt": -1}.get(self.relation):
            met = [sign * (end - self.value) < self.tolerance for end in ours[1:]]
            return "inside" if all(met) else "undecided" if any(met) else "outside"
        value, low, high = ours
        # the slack keeps a value on the very edge from failing by the last bit of a float
        slack = self.tolerance + 4e-16 * (abs(value) + abs(self.value))
        if max(low - self.value, self.value - high) > slack:
            return "outside"
        widest = min(WIDEST * self.tolerance, (WIDEST - 1) * abs(low))
        near = abs(value - self.value) <= slack
        return "inside" if near and high - low <= widest else "undecided"


def _finite_cases(value: Value | Mapping[str, Value]) -> dict[str, list[float]]:
    """Finite numbers by their case, each with the ends of its interval."""
    given = value if isinstance(value, Mapping) else {"": value}
    return {
        case: np.broadcast_to(one, 3).tolist()
        for case, one in given.items()
        if np.isfinite(one).all()
    }


@dataclass(frozen=True)
class Score:
    """A published number beside ours, and what follows from the two.

    ``cases`` are our numbers as a notebook has them: one, with the ends of its interval or without,
    or several by their case. What is not finite is left out.
    """

    number: Published
    cases: Annotated[dict[str, OwnNumber], BeforeValidator(_finite_cases)]
    profile: str = "book"
    crops: int = 0  # on which the network was trained
    chapter: str = ""  # that computed ours

    @property
    def places(self) -> dict[str, list[str]]:
        """Our cases by their place beside the paper's number."""
        places = defaultdict(list)
        for case, one in self.cases.items():
            places[self.number.place_of(one)].append(case)
        return places

    def has_papers(self, one: Dependency) -> bool:
        """Whether our number was made with the paper's version of a dependency."""
        if one.name == "training":
            return self.crops >= CROPS
        return self.profile in one.same

    @property
    def differing(self) -> list[Dependency]:
        """What the number depends on that is not the paper's."""
        return [one for one in self.number.depends if not self.has_papers(one)]

    def ours(self, one: Dependency) -> str:
        """Sentence on what we have of a dependency."""
        return one.ours.format(crops=self.crops)

    @property
    def untested(self) -> str:
        """Why the number cannot be compared, '' if it can."""
        if self.number.untested or not self.cases:
            return self.number.untested or "No chapter computes it."
        return next((one.ours for one in self.differing if one.name == "sizes"), "")

    @property
    def verdict(self) -> str:
        """The verdict; every case counts."""
        found = set(self.places)
        if self.number.kind == "setting" and found:
            return "as stated" if found == {"inside"} else "changed"
        if self.untested:
            return "untested"
        if found == {"inside"}:
            return "reproduced"
        return "contradicted" if found == {"outside"} and not self.differing else "open"

    @property
    def undecided(self) -> str:
        """Which cases of ours agree, differ or are too uncertain; '' if all agree."""
        places = self.places
        if places.keys() <= {"inside"}:
            return ""
        told = (f"{BESIDE[one]} {' and '.join(cases)}" for one, cases in places.items())
        return "; ".join(told).strip()

    @property
    def note(self) -> str:
        """What stands behind the verdict, and what would decide an open one."""
        number = self.number
        said = [sentence(self.undecided), *map(self.ours, self.differing)]
        if self.untested or self.verdict == "changed":
            said = [self.untested or number.changed]
        said.append(number.note)
        if self.verdict == "open" and self.differing:
            deciding = "; ".join(one.decides for one in self.differing)
            said.append(f"It would be decided by: {deciding}.")
        if number.erratum:
            said.append(f"Erratum {number.erratum}.")
        return " ".join(filter(None, said))


def sentence(text: str) -> str:
    """A text as a sentence of its own; none if there is no text."""
    return f"{text[0].upper()}{text[1:]}." if text else ""
