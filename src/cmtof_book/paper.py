"""The published numbers, and the comparison of our results with them.

A notebook calls `check` for each number of ``paper.yml`` that it touches; the verdict
(`cmtof_book.verdict`) never stops a run. `cmtof_book.scoreboard` writes the book's page.
"""

import math
from collections import Counter
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from matplotlib.ticker import EngFormatter

from cmtof.types import Fields, Named
from cmtof_book import notes, provenance, record
from cmtof_book.compared import Compared
from cmtof_book.verdict import OwnNumber, Published, Score, Value

_SIGNS = {"eq": "", "approx": "≈ ", "lt": "< ", "gt": "> "}


@cache
def published_numbers() -> dict[str, Published]:
    """Every published number by its key, in the order of the paper.

    A row of a table has a number for each column, with key ``row.column``.
    """
    numbers = {}
    document = yaml.safe_load(Path(__file__).with_name("paper.yml").read_bytes())
    for name, held in document.items():
        if name.startswith("_"):  # only referred to
            continue
        columns = held.get("columns", {"": ""})
        values = np.atleast_1d(held["value"]).tolist()
        for (column, title), value in zip(columns.items(), values, strict=True):
            allowed = (
                abs(value) * size if kind == "relative" else size
                for kind, size in held["tolerance"].items()
            )
            key = f"{name}.{column}".rstrip(".")
            what = f"{held['what']}, {title}".rstrip(", ")
            own = {"key": key, "value": value, "what": what, "tolerance": min(allowed)}
            numbers[key] = Published(**held | own)
    return numbers


def published_number(key: str) -> Published:
    """Published number of a key of ``paper.yml``."""
    return published_numbers()[key]


def check(
    key: str, value: Value | Compared | Mapping[str, Value], *, crops: int = 0
) -> None:
    """Compare a result with the paper, for `table` and for the scoreboard.

    ``value`` is in the unit of the published number: one number, or three with the ends of its 95 %
    interval; several by their case, such as «with photon noise alone», all decide. ``crops`` is how
    many a network was trained on. The standard error of a sum over draws gives its interval.
    """
    found: Fields = {}
    given: Any = value
    if isinstance(value, Compared):
        found = value.record()
        given = value.value + 1.96 * (value.error or 0.0) * np.array([0, -1, 1])
    score = Score(published_number(key), given, provenance.RUN["profile"], crops)
    found |= {"cases": score.cases, "verdict": score.verdict, "crops": crops}
    record.add(record.PAPER, {key: found})


def check_all(reached: Named) -> None:
    """`check` results by the key of their published number."""
    for key, value in reached.items():
        check(key, value)


def table() -> None:
    """Show what a chapter has checked so far: the paper's number, ours, the verdict."""
    rows = []
    for key, held in record.read(record.PAPER).items():
        number = published_number(key)
        rows.append(
            [
                f"{number.where}, {number.what}",
                published_text(number),
                result_text(Score(number, held["cases"])),
                held["verdict"],
            ]
        )
    verdicts = Counter(row[-1] for row in rows).most_common()
    said = ", ".join(f"{count} {name}" for name, count in verdicts)
    fold = f"{len(rows)} numbers: {said}" if len(rows) > 12 else ""
    notes.table(["number", "paper", "here", "verdict"], rows, fold=fold)


def published_text(number: Published) -> str:
    """A published number with the sign of its relation and its tolerance."""
    text = _SIGNS[number.relation] + quantity_text(number.value, number.unit)
    allowed = quantity_text(number.tolerance, number.unit, 2)
    return f"{text} ± {allowed}" if number.tolerance else text


def result_text(score: Score, digits: int = 4) -> str:
    """Text of our numbers with intervals and cases; ``digits`` significant figures where exact."""
    return (
        "; ".join(
            f"{estimate_text(one, score.number.unit, digits)} {case}".strip()
            for case, one in score.cases.items()
        )
        or "not finite"
    )


def estimate_text(one: OwnNumber, unit: str, digits: int) -> str:
    """Text of a number with its interval, where it has one.

    >>> estimate_text(OwnNumber(0.435, 0.345, 0.525), "fraction", 3)
    '43.5 % (34.5–52.5 %)'
    """
    if one.low == one.high:
        return quantity_text(one.value, unit, digits)
    value, low, high = (quantity_text(part, unit, 3) for part in one)
    number, _, unit_of_low = low.partition(" ")
    return f"{value} ({number if high.endswith(f' {unit_of_low}') else low}–{high})"


def quantity_text(value: float, unit: str, digits: int = 4) -> str:
    """Text of a number and unit: ``fraction`` in percent, ``points`` times 100, ``1`` plain.

    >>> quantity_text(0.516, "fraction"), quantity_text(3.35e-5, "m"), quantity_text(14.32e9, "Hz")
    ('51.6 %', '33.5 µm', '14.32 GHz')
    """
    if not math.isfinite(value):
        return "not finite"
    if unit in {"m", "s", "Hz", "W"}:
        return EngFormatter(unit)(float(f"{value:.{digits}g}"))
    text = np.format_float_positional(
        100 * value if unit in ("fraction", "points") else value,
        precision=digits,
        fractional=False,
        trim="-",
    )
    return f"{text} {'%' if unit == 'fraction' else unit}".removesuffix(" 1")
