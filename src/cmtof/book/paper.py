"""The published numbers, and how a result of ours is held against them.

The numbers that the paper prints stand in ``paper.yml``. A notebook calls `check` for each one
that it touches; the verdict never stops a run. ``tools/scoreboard.py`` writes the book's page.
"""

import json
import math
from dataclasses import dataclass
from decimal import Decimal
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal

from cmtof.book import provenance

Outcome = Literal["reproduced", "contradicted", "untested", "input"]
"""What came of holding a result against a published number."""

CHECKS = "checks.json"
"""Name of the file, in a run's output folder, that holds what was checked."""

_SIGNS = {"eq": "", "approx": "≈ ", "lt": "< ", "gt": "> "}


@dataclass(frozen=True, slots=True, kw_only=True)
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
        size, label = _scale(self.value, self.unit)
        text = _SIGNS[self.relation] + _digits(self.value / size) + label
        allowed = _digits(self.tolerance / size, 2) + label
        return f"{text}{joint}± {allowed}" if self.tolerance else text

    def holds(self, value: float) -> bool:
        """Whether a value lies within the tolerance."""
        # the slack keeps a value on the very edge from failing by the last bit of a float
        slack = 4e-16 * (abs(value) + abs(self.value))
        above = value - self.value
        if self.relation in ("lt", "gt"):
            return (above if self.relation == "lt" else -above) < self.tolerance
        return abs(above) <= self.tolerance + slack


@dataclass(frozen=True, slots=True)
class Verdict:
    """A result beside the published number; ``str`` gives the line that `check` prints."""

    published: Published
    value: float

    @property
    def outcome(self) -> Outcome:
        """Computed from value and tolerance, unless the number is an input or cannot be tested."""
        if self.published.kind == "setting":
            return "input"
        if self.published.untested or not math.isfinite(self.value):
            return "untested"
        return "reproduced" if self.published.holds(self.value) else "contradicted"

    @property
    def ratio(self) -> str:
        """Ours over the paper's, such as ``0.43 ×``; empty where there is none."""
        if self.published.value == 0 or not math.isfinite(self.value):
            return ""
        return f"{_digits(self.value / self.published.value, 3)} ×"

    def __str__(self) -> str:
        number, ratio = self.published, f" ({self.ratio})" if self.ratio else ""
        ours = quantity_text(self.value, number.unit)
        return f"{number.key}: paper {number.text()}, ours {ours}{ratio}: {self.outcome}"


@cache
def published_numbers() -> dict[str, Published]:
    """Every published number by its key, in the order of the paper."""
    import yaml

    entries = yaml.safe_load(files("cmtof.book").joinpath("paper.yml").read_text("utf-8"))
    found: dict[str, Published] = {}
    for key, fields in entries.items():
        if "rows" not in fields:
            found |= {} if key == "_shared" else {key: _published(key, fields)}
            continue
        for row, (name, *values) in fields["rows"].items():
            for column, value in zip(fields["columns"], values, strict=True):
                label = f"{key}.{row}.{column}"
                what = f"{name}, {fields['columns'][column]}"
                found[label] = _published(label, {"value": value, "what": what, **fields["about"]})
    return found


def _published(key: str, fields: dict[str, Any]) -> Published:
    amounts = dict(fields)
    allowed = amounts.pop("tolerance")
    scale = {"absolute": 1.0, "relative": abs(fields["value"])}
    tolerance = min(amount * scale[kind] for kind, amount in allowed.items())
    return Published(key=key, tolerance=tolerance, **amounts)


def published(key: str) -> Published:
    """One published number; ValueError, which names the closest key, if there is none.

    Examples
    --------
    >>> published("table2.proposed.delta_lt_1").value
    0.516
    """
    numbers = published_numbers()
    if key not in numbers:
        (closest,) = get_close_matches(key, numbers, n=1, cutoff=0.0)
        raise ValueError(f"Expected a key of paper.yml, got {key!r}. Use {closest!r}.")
    return numbers[key]


def check(key: str, value: float) -> None:
    """Hold a result against the paper, print one line, and note it for the scoreboard.

    ``value`` is in the unit of the published number; ValueError if ``paper.yml`` lacks the key.
    """
    found = Verdict(published(key), float(value))
    print(found)
    path = provenance.output_folder() / CHECKS
    records = read_checks(path) if path.exists() else {}
    kept = found.value if math.isfinite(found.value) else None
    records[key] = {"value": kept, "verdict": found.outcome, **provenance.as_dict()}
    provenance.write_json(path, dict(sorted(records.items())))


def read_checks(path: Path) -> dict[str, dict[str, Any]]:
    """Records by key of what a run checked; ValueError if the file is no JSON object."""
    try:
        records = json.loads(path.read_text(encoding="utf-8"))
    except json.JSONDecodeError as error:
        raise ValueError(f"Expected JSON in {path}, got {error}. Delete it, run again.") from error
    if not isinstance(records, dict):
        kind = type(records).__name__
        raise ValueError(f"Expected a JSON object in {path}, got a {kind}. Delete it, run again.")
    return records


# --- numbers with their units -------------------------------------------------------------------

_PREFIXES = {9: "G", 6: "M", 3: "k", 0: "", -3: "m", -6: "µ", -9: "n", -12: "p", -15: "f"}


def quantity_text(value: float, unit: str) -> str:
    """Number with four digits and its unit: ``fraction`` in percent, ``1`` as a plain number.

    Examples
    --------
    >>> quantity_text(0.516, "fraction"), quantity_text(3.35e-5, "m"), quantity_text(14.32e9, "Hz")
    ('51.6 %', '33.5 µm', '14.32 GHz')
    """
    if not math.isfinite(value):
        return "not finite"
    size, label = _scale(value, unit)
    return _digits(value / size) + label


def _scale(value: float, unit: str) -> tuple[float, str]:
    """Size of the prefixed unit, and its name."""
    if unit == "fraction":
        return 0.01, " %"
    if unit not in {"m", "s", "Hz", "W"} or value == 0:
        return 1.0, "" if unit == "1" else f" {unit}"
    # read from the decimal form: 999.96 Hz rounds to 1 kHz, and 1e-3 is no less than a milli
    exponent = int(f"{value:.3e}".partition("e")[2])
    power = min(max(3 * (exponent // 3), min(_PREFIXES)), max(_PREFIXES))
    return float(f"1e{power}"), f" {_PREFIXES[power]}{unit}"


def _digits(value: float, count: int = 4) -> str:
    """Digits of a number, without an exponent where a reader would not write one."""
    text = f"{value:.{count}g}"
    return format(Decimal(text), "f") if 1e-6 < abs(value) < 1e7 else text
