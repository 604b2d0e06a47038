"""The scoreboard page of the book, written from what the notebooks checked."""

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cmtof import coverage
from cmtof.book.paper import Outcome, Published, Verdict, published, read_checks, verdict
from cmtof.book.quantity import quantity_text

# from the one that must not be missed to the one that needs no look
_WORST_FIRST: tuple[Outcome, ...] = ("differs", "paper errs", "not comparable", "agrees")

_MEANING: dict[Outcome, str] = {
    "agrees": "Ours lies within the tolerance of the paper's number.",
    "differs": "Ours lies outside, and nothing explains it. It is an open question, or our fault.",
    "paper errs": "Ours lies outside, and the paper is wrong there: "
    "see the {doc}`errata <../notebooks/07_errata>`.",
    "not comparable": "Ours is another quantity, or comes from other data. The note says how.",
    "not yet reached": "No chapter has come to this number yet.",
}

_SPACE = "\N{NO-BREAK SPACE}"

_GROUPS = {"table": "Table", "fig": "Figure", "abstract": "Abstract", "sec": "Section"}

_HEAD = """# Scoreboard

Every number that the paper {{cite}}`baek2023` prints, and what this book found instead of it.
The page is written anew with each build, from the checks in the chapters.
It was written from {runs}.

{summary}

The tolerance stands beside the paper's number.
Unless a note says otherwise it is half a unit of the last digit printed.
In Tables 1 to 3 it is two percentage points, or a fifth of the number where that is less.

{meanings}
"""


@dataclass(frozen=True, slots=True)
class Run:
    """Where and how a number of ours was made."""

    notebook: str
    profile: str
    seed: int
    version: str

    def link(self) -> str:
        """Return a link to the chapter, or a plain name for a folder that is none."""
        number = re.match(r"(\d\d)_", self.notebook)
        if number is None:
            return f"`{self.notebook}`"
        return f"{{doc}}`{number[1]} <../notebooks/{self.notebook}>`"


Found = dict[str, tuple[Verdict, Run]]
"""Our number and its verdict, and the run that made it, by key."""


def page(
    numbers: Mapping[str, Published],
    checks: Iterable[Path],
    results: Iterable[Path] = (),
    notebooks: Iterable[Path] = (),
) -> str:
    """Write the page; see :func:`cmtof.book.paper.scoreboard`."""
    found = _found(checks)
    groups: dict[str, list[Published]] = {}
    for number in numbers.values():
        groups.setdefault(number.key.partition(".")[0], []).append(number)
    runs = {run for _, run in found.values()}
    parts = [
        _HEAD.format(
            runs=f"{len(runs)} runs" if len(runs) != 1 else "one run",
            summary=_summary(numbers.values(), found),
            meanings="\n".join(f"- **{name}**: {text}" for name, text in _MEANING.items()),
        )
    ]
    parts.append(coverage.section(results, notebooks))
    parts += [_section(name, groups[name], found) for name in sorted(groups, key=_order)]
    if runs:
        parts.append(_runs(runs))
    return "\n".join(parts)


def _found(checks: Iterable[Path]) -> Found:
    found: Found = {}
    for path in checks:
        for key, record in read_checks(path).items():
            new = _judged(key, record)
            old = found.get(key)
            if old is None or _rank(new) < _rank(old[0]):
                found[key] = (new, _run(path.parent.name, record))
    return found


def _judged(key: str, record: Mapping[str, Any]) -> Verdict:
    value = float("nan") if record["value"] is None else record["value"]
    return verdict(
        published(key), value, reason=record.get("reason"), tolerance=record.get("tolerance")
    )


def _run(notebook: str, record: Mapping[str, Any]) -> Run:
    return Run(notebook, record["profile"], record["seed"], record["version"])


def _rank(judged: Verdict) -> int:
    return _WORST_FIRST.index(judged.outcome)


def _outcome(number: Published, found: Found) -> Outcome:
    if number.key in found:
        return found[number.key][0].outcome
    # a part of their bench or another's work is nothing that a later chapter could reach
    out_of_reach = not number.comparable and number.kind != "result"
    return "not comparable" if out_of_reach else "not yet reached"


def _summary(numbers: Iterable[Published], found: Found) -> str:
    counts: dict[str, Counter[Outcome]] = {"result": Counter(), "setting": Counter()}
    for number in numbers:
        kind = "result" if number.kind == "result" else "setting"
        counts[kind][_outcome(number, found)] += 1
    head = ["| verdict | results | settings |", "| :-- | --: | --: |"]
    found_of, chosen = counts["result"], counts["setting"]
    rows = [f"| {name} | {found_of[name]} | {chosen[name]} |" for name in _MEANING]
    rows.append(f"| **all** | **{found_of.total()}** | **{chosen.total()}** |")
    said = (
        "Results are what the paper found. "
        "Settings are what it chose, or took from the work of others."
    )
    return "\n".join([*head, *rows, "", said])


def _split(group: str) -> tuple[str, str]:
    name = group.rstrip("0123456789")
    return name, group[len(name) :]


def _order(group: str) -> tuple[int, int]:
    name, digits = _split(group)
    return list(_GROUPS).index(name), int(digits or 0)


def _title(group: str) -> str:
    name, digits = _split(group)
    return f"{_GROUPS[name]} {digits}".strip()


def _section(group: str, numbers: list[Published], found: Found) -> str:
    notes: dict[str, str] = {}
    rows = [_row(number, found, notes) for number in numbers]
    table = [
        f"## {_title(group)}",
        "",
        "```{table}",
        ":class: scoreboard",
        "",
        "| number | paper | ours |",
        "| :-- | :-- | :-- |",
        *rows,
        "```",
        "",
    ]
    return "\n".join(table + [f"**{letter}** {reason}\n" for reason, letter in notes.items()])


def _row(number: Published, found: Found, notes: dict[str, str]) -> str:
    judged, run = found.get(number.key, (None, None))
    reason = judged.reason if judged else number.reason
    said: str = _outcome(number, found)
    if number.erratum is not None:
        reason = f"{reason} (erratum {number.erratum})" if reason else f"Erratum {number.erratum}."
    if reason:
        said += f"{_SPACE}<sup>{notes.setdefault(reason, _letter(len(notes)))}</sup>"
    if judged and run:
        ours = _unbroken(quantity_text(judged.value, number.unit))
        said = f"{ours}<br>{said}<br>{run.link()}"
    paper = number.text(judged.tolerance if judged else number.tolerance, joint="<br>")
    # the key may break over lines, or a phone would have to scroll sideways
    key = re.sub(r"(\.|_(?!\d))", r"\1<wbr>", number.key.partition(".")[2])
    what = re.sub(r" ([<≥]) (?=\d)", rf"{_SPACE}\1{_SPACE}", number.what)
    return f"| {what}<br><code>{key}</code> | {_unbroken(paper)} | {said} |"


def _unbroken(text: str) -> str:
    return text.replace(" ", _SPACE)


def _letter(index: int) -> str:
    return "abcdefghijklmnopqrstuvwxyz"[index]


def _runs(runs: Iterable[Run]) -> str:
    ordered = sorted(runs, key=lambda run: (run.notebook, run.profile, run.seed, run.version))
    rows = [f"| {run.link()} | {run.profile} | {run.seed} | {run.version} |" for run in ordered]
    head = ["## Runs", "", "| chapter | profile | seed | version |", "| :-- | :-- | --: | :-- |"]
    return "\n".join([*head, *rows, ""])
