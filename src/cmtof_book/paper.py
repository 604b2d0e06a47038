"""The published numbers, and the comparison of our results with them.

A notebook calls `check` for each number of ``paper.yml`` that it touches; the verdict never stops a
run. `cmtof_book.scoreboard` writes the book's page.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from typing import Any, Literal, NamedTuple

import numpy as np
import yaml
from matplotlib.ticker import EngFormatter

from cmtof_book import record
from cmtof_book.compared import Compared

CROPS = 500_000  # on which the paper's networks were trained: 1000 epochs of 500 (Sec. 8.1)

Outcome = Literal["reproduced", "contradicted", "untested", "input"]
Value = float | Sequence[float]  # a number, or the ends of a band
WORST_FIRST: tuple[Outcome, ...] = ("contradicted", "untested", "reproduced", "input")
_SIGNS = {"eq": "", "approx": "≈ ", "lt": "< ", "gt": "> "}


@dataclass(frozen=True, kw_only=True)
class Published:
    """One number of the paper, as ``paper.yml`` explains it; SI units, percentages as fractions."""

    key: str
    value: float
    unit: str
    where: str
    what: str
    relation: Literal["eq", "approx", "lt", "gt"]
    tolerance: float
    kind: Literal["result", "setting"]
    untested: str = ""
    note: str = ""
    erratum: int | None = None

    def text(self, joint: str = " ") -> str:
        """Return the number with the sign of its relation and its tolerance."""
        text = _SIGNS[self.relation] + quantity_text(self.value, self.unit)
        allowed = quantity_text(self.tolerance, self.unit, 2)
        return f"{text}{joint}± {allowed}" if self.tolerance else text

    def outcome(self, value: Value = math.nan) -> Outcome:
        """Computed from value and tolerance; a band counts by its value nearest to the paper's."""
        if self.kind == "setting":
            return "input"
        value = float(np.clip(self.value, *np.broadcast_to(value, 2)))
        if self.untested or not math.isfinite(value):
            return "untested"
        above = value - self.value
        # the slack keeps a value on the very edge from failing by the last bit of a float
        holds = abs(above) <= self.tolerance + 4e-16 * (abs(value) + abs(self.value))
        if self.relation in ("lt", "gt"):
            holds = (above if self.relation == "lt" else -above) < self.tolerance
        return "reproduced" if holds else "contradicted"


class Claim(NamedTuple):
    """One of the paper's ten main claims, and the published numbers on which it rests."""

    text: str
    keys: tuple[str, ...]

    def outcome(self, values: Mapping[str, Value]) -> Outcome:
        """Worst verdict of its numbers; one that no run computed is untested."""
        said = (published(key).outcome(values.get(key, math.nan)) for key in self.keys)
        return min(said, key=WORST_FIRST.index)


@cache
def _document() -> dict[str, Any]:
    return yaml.safe_load(files("cmtof_book").joinpath("paper.yml").read_text("utf-8"))


def claims() -> list[Claim]:
    """The ten claims, in the order of the paper."""
    return [Claim(text, tuple(keys)) for text, keys in _document()["_claims"].items()]


@cache
def published_numbers() -> dict[str, Published]:
    """Every published number by its key, in the order of the paper."""
    entries = {key: held for key, held in _document().items() if not key.startswith("_")}
    found = {}
    for name, fields in entries.items():
        columns = fields.get("columns", {"": ""})  # those of a row of a table
        values = np.atleast_1d(fields["value"]).tolist()
        for (column, title), value in zip(columns.items(), values, strict=True):
            scale = {"absolute": 1.0, "relative": abs(value)}
            tolerance = min(scale[kind] * size for kind, size in fields["tolerance"].items())
            key, what = f"{name}.{column}".strip("."), f"{fields['what']}, {title}".strip(", ")
            one = fields | {"key": key, "what": what, "value": value, "tolerance": tolerance}
            found[key] = Published(**{k: v for k, v in one.items() if k != "columns"})
    return found


def published(key: str) -> Published:
    """One published number; ValueError, which names the closest key, if there is none."""
    numbers = published_numbers()
    if key not in numbers:
        (closest,) = get_close_matches(key, numbers, n=1, cutoff=0.0)
        raise ValueError(f"Expected a key of paper.yml, got {key!r}. Use {closest!r}.")
    return numbers[key]


def check(
    key: str, value: Value | Compared, *, crops: int = 0, photon: Value | None = None
) -> None:
    """Compare a result with the paper, print one line, and note it for the scoreboard.

    ``value`` is in the unit of the published number, a pair the ends of a band; ``crops`` how many
    a network was trained on. Where the simulated instrument has the captures' noise, ``photon`` is
    the value at the photon limit, which is shown too and decides nothing.
    """
    number = published(key)
    kind = value.record() if isinstance(value, Compared) else {}
    ours: Value = np.asarray(kind.get("value", value), float).tolist()
    said = number.outcome(ours)
    beside = ""
    if photon is not None:
        beside = f"at the photon limit {ours_text(number, photon)}: {number.outcome(photon)}"
    print(f"{key}: paper {number.text()}, ours {ours_text(number, ours)}: ", end="")
    print(f"{said}{training_text(crops)}{beside and '; ' + beside}")
    kept = ours if np.isfinite(ours).all() else None
    found = {**kind, "value": kept, "verdict": said, "crops": crops, "beside": beside}
    record.add(record.PAPER, {key: found})


def ours_text(number: Published, value: Value) -> str:
    """Our number, or the ends of its band, with the ratio to the paper's, such as ``(0.43 ×)``."""
    ends = np.atleast_1d(value)
    text = " to ".join(quantity_text(end, number.unit) for end in ends)
    if number.kind == "setting" or number.value == 0 or not np.isfinite(ends).all():
        return text
    return f"{text} ({' to '.join(_digits(end / number.value, 3) for end in ends)} ×)"


def training_text(crops: int) -> str:
    """Addition to the verdict on a network: its training beside the paper's."""
    return f" after {crops:,} crops of the paper's {CROPS:,}" if crops else ""


def quantity_text(value: float, unit: str, digits: int = 4) -> str:
    """Number with its unit: ``fraction`` in percent, ``1`` as a plain number.

    >>> quantity_text(0.516, "fraction"), quantity_text(3.35e-5, "m"), quantity_text(14.32e9, "Hz")
    ('51.6 %', '33.5 µm', '14.32 GHz')
    """
    if not math.isfinite(value):
        return "not finite"
    if unit in {"m", "s", "Hz", "W"}:
        return EngFormatter(unit)(float(f"{value:.{digits}g}"))
    if unit == "fraction":
        return f"{_digits(100 * value, digits)} %"
    return _digits(value, digits) + ("" if unit == "1" else f" {unit}")


def _digits(value: float, count: int) -> str:
    """So many significant digits of a number, without an exponent."""
    return np.format_float_positional(value, precision=count, fractional=False, trim="-")
