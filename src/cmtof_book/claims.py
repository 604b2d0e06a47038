"""The paper's ten main claims: the table on the first page, a page each, and our own findings."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import yaml

from cmtof_book.paper import (
    Published,
    estimate_text,
    published,
    published_numbers,
    result_text,
)
from cmtof_book.record import TEXT, Record
from cmtof_book.verdict import (
    WORST_FIRST,
    Dependency,
    Estimate,
    Outcome,
    Result,
    differing,
    reason,
    undecided,
    verdict,
)

Results = Mapping[str, Result]
SPACE = "\N{NO-BREAK SPACE}"
TOKEN = re.compile(r"\{([^{}|]+)(?:\|([^{}]+))?\}")


@dataclass(frozen=True, kw_only=True)
class Claim:
    """One main claim, as ``claims.yml`` explains it."""

    name: str
    title: str
    says: str
    quote: str
    where: str
    answer: str
    keys: dict[str, str]  # and what a number is called where there are several
    figure: str
    chapter: str
    overturn: str

    def numbers(self) -> list[Published]:
        """The published numbers that decide it."""
        return [published(key) for key in self.keys]

    def outcome(self, results: Results) -> Outcome:
        """The worst verdict of its numbers."""
        said: list[Outcome] = [verdict(one, results.get(one.key)) for one in self.numbers()]
        return min(said, key=WORST_FIRST.index)

    def why(self, results: Results) -> str:
        """What stands behind that verdict, in one line."""
        worst = self.outcome(results)
        found = [(one, results.get(one.key)) for one in self.numbers()]
        behind = [
            (one, result or Result()) for one, result in found if verdict(one, result) == worst
        ]
        if worst == "untested":
            return reason(*behind[0])
        told = ", ".join(
            dict.fromkeys(other.short for pair in behind for other in differing(*pair))
        )
        if told and worst == "reproduced":
            return f"It holds although {told} differ or are not stated."
        lines = [*self.left_open(behind), *([f"Different or not stated: {told}."] if told else [])]
        return " ".join(lines) or behind[0][0].dependencies()[0].ours

    def left_open(self, behind: Iterable[tuple[Published, Result]]) -> Iterable[str]:
        """What our numbers leave undecided, with the names of those where there are several."""
        names: dict[str, list[str]] = {}
        for one, result in behind:
            for text in undecided(one, result):
                names.setdefault(text, []).append(self.keys[one.key])
        for text, called in names.items():
            sentence = f"{' and '.join(called)}: {text}".removeprefix(": ")
            yield f"{sentence[0].upper()}{sentence[1:]}."

    def dependencies(self) -> list[Dependency]:
        """What its numbers depend on, each once."""
        return list({d.name: d for one in self.numbers() for d in one.dependencies()}.values())


@cache
def _document() -> dict[str, Any]:
    return yaml.safe_load(files("cmtof_book").joinpath("claims.yml").read_text("utf-8"))


@cache
def claims() -> list[Claim]:
    """The ten claims, in the order of the paper."""
    return [Claim(name=name, **held) for name, held in _document()["claims"].items()]


class Numbers:
    """All numbers of a build: our results, those of its figures, and those that its pages tell."""

    def __init__(self, results: Results, records: Iterable[Record]) -> None:
        self.results = results
        self.records = {f"{one.chapter}/{one.name}": one for one in records}

    def fill(self, text: str) -> str:
        """Put numbers into a text of ``claims.yml``."""
        filled = TOKEN.sub(lambda token: self.number(token[1], token[2] or ""), text)
        return re.sub(r"(?<=\d) (?=[%µ]|[GM]?Hz|rad|points|[fkmp]?[ms]\b)", SPACE, filled)

    def number(self, name: str, style: str) -> str:
        """One number as text: by the key of a published one, of a figure, or of a page.

        ``key@0`` is our first case of a published number, and the style ``alone`` leaves out its
        interval.
        """
        key, _, case = name.partition("@")
        if key in published_numbers():
            found = self.results.get(key, Result())
            if case and found.cases:
                one = list(found.cases.values())[int(case)]
                one = Estimate.of(one.value) if style == "alone" else one
                return estimate_text(one, published(key).unit, 3)
            return result_text(published(key), found, 3) if found.cases else "(not computed)"
        figure, *path = name.replace(":", f"/{TEXT}.").split(".")
        held: Any = self.records[figure].numbers
        for step in path:
            held = held["value"] if isinstance(held, dict) and "kind" in held else held
            held = held[int(step) if isinstance(held, list) else step]
        held = held["value"] if isinstance(held, dict) else held
        return f"{held:{style}}".replace("%", " %")


def badge(said: str) -> str:
    """Return a verdict as a word in its colour."""
    return f'<span class="verdict {said.replace(" ", "-")}">{said}</span>'


def figure_link(figure: str, text: str) -> str:
    """Return a link to a figure where it stands in its chapter."""
    return f"{{ref}}`{text} <fig-{figure.replace('_', '-')}>`"


def table(numbers: Numbers) -> str:
    """Return the table of the first page: each claim, our answer, the verdict and why."""
    rows = ["| the paper says | this book finds | verdict |", "| :-- | :-- | :-- |"]
    for claim in claims():
        answer = numbers.fill(claim.answer)
        told = [badge(claim.outcome(numbers.results)), claim.why(numbers.results)]
        told.append(f"{{doc}}`More <claims/{claim.name}>`, {figure_link(claim.figure, 'figure')}")
        rows.append(f"| {numbers.fill(claim.says)} | {answer} | {' '.join(told)} |")
    return "\n".join([*rows, ""])


def page(claim: Claim, numbers: Numbers) -> str:
    """Return the page of a claim as MyST Markdown; its figure lies beside it."""
    results = numbers.results
    about = numbers.records[f"{claim.chapter}/{claim.figure}"].content
    rows = "\n".join(_row(one, results.get(one.key)) for one in claim.numbers())
    depends = "\n".join(f"| {text} | {same} |" for text, same in dependency_rows(claim, results))
    return f"""# {claim.title}

{claim.says}

> {claim.quote}
>
> {{cite:t}}`baek2023`, {claim.where}

**This book:** {numbers.fill(claim.answer)}

{badge(claim.outcome(results))} {claim.why(results)}

| number | the paper | this book |
| :-- | :-- | :-- |
{rows}

```{{figure}} {about["figure"]}
:alt: {about["alt"]}
```

*From {figure_link(claim.figure, f"chapter {int(claim.chapter[:2])}")}.* {about["caption"]}

## What the numbers depend on

| what we have | as the paper |
| :-- | :-- |
{depends}

## What would overturn the verdict

{claim.overturn}

One command draws the figure again and computes the numbers: `make figure F={claim.figure}`.
"""


def _row(number: Published, result: Result | None) -> str:
    ours = result_text(number, result) if result else ""
    return f"| {number.what} | {number.text()} | {ours} {badge(verdict(number, result))} |"


def dependency_rows(claim: Claim, results: Results) -> Iterable[tuple[str, str]]:
    """What the claim's numbers depend on, and whether ours is the paper's."""
    for one in claim.dependencies():
        held = [
            results[n.key] for n in claim.numbers() if one.name in n.depends and n.key in results
        ]
        result = held[0] if held else Result()
        papers = one.is_papers(result)
        if not (papers and one.name == "sizes"):
            yield one.text(result), "yes" if papers else "no"


def findings(numbers: Numbers) -> str:
    """Return what we found that the paper does not have, as a list."""
    lines = []
    for one in _document()["findings"]:
        link = f"{{ref}}`Derivation <{one['place']}>`" if "place" in one else ""
        link = link or figure_link(one["figure"], "Figure")
        lines.append(f"1. {numbers.fill(one['text'])} {link}.")
    return "\n".join([*lines, ""])
