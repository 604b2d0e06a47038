"""The published numbers, and how a result of ours is held against them.

Every number that the paper prints stands in ``paper.yml``. A notebook calls :func:`check` for each
one that it touches; the verdict never stops a run. :func:`scoreboard` writes the book's page.
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

Outcome = Literal["agrees", "differs", "paper errs", "not comparable", "not yet reached"]
"""What came of holding a result against a published number."""

CHECKS = "checks.json"
"""Name of the file, in a run's output folder, that holds what was checked."""

_SIGNS = {"eq": "", "approx": "≈ ", "lt": "< ", "gt": "> "}


@dataclass(frozen=True, slots=True, kw_only=True)
class Published:
    """One number of the paper, in SI units; percentages are fractions.

    Attributes
    ----------
    key : str
        Its name, such as ``table2.proposed.delta_lt_1``.
    value : float
        The number in ``unit``.
    unit : str
        SI symbol, ``fraction`` for a percentage, ``1`` for a plain number.
    where, what : str
        Its place in the paper, and what it counts.
    relation : {"eq", "approx", "lt", "gt"}
        How the paper states it.
    tolerance : float
        How far ours may lie from it, in ``unit``.
    comparable : bool
        Whether ours is the same quantity from the same data.
    kind : {"result", "setting", "cited"}
        Whether the paper found it, chose it, or reports it from elsewhere.
    reason : str
        Why it cannot be compared, or where the paper errs.
    erratum : int or None
        Its number in the errata chapter.
    """

    key: str
    value: float
    unit: str
    where: str
    what: str
    relation: Literal["eq", "approx", "lt", "gt"]
    tolerance: float
    comparable: bool
    kind: Literal["result", "setting", "cited"]
    reason: str = ""
    erratum: int | None = None

    def text(self, tolerance: float, joint: str = " ") -> str:
        """Write the number with the sign of its relation and a tolerance.

        Examples
        --------
        >>> published("fig14.height_error").text(5e-7)
        '12 µm ± 0.5 µm'
        """
        return _SIGNS[self.relation] + toleranced_text(self.value, tolerance, self.unit, joint)


@dataclass(frozen=True, slots=True)
class Verdict:
    """A result beside the published number; ``str`` gives the line that :func:`check` prints."""

    published: Published
    value: float
    tolerance: float
    outcome: Outcome
    reason: str

    def __str__(self) -> str:
        """Return one line: key, paper, ours, tolerance, verdict, reason."""
        number, ours = self.published, quantity_text(self.value, self.published.unit)
        line = f"{number.key}: paper {number.text(self.tolerance)}, ours {ours}"
        return f"{line}: {self.outcome}" + (f" ({self.reason})" if self.reason else "")


@cache
def published_numbers() -> dict[str, Published]:
    """Return every published number by its key, in the order of the paper.

    Examples
    --------
    >>> published_numbers()["table2.proposed.delta_lt_1"].value
    0.516
    """
    import yaml

    text = files("cmtof.book").joinpath("paper.yml").read_text(encoding="utf-8")
    entries = yaml.safe_load(text)
    return {key: _published(key, fields) for key, fields in entries.items() if key != "_shared"}


def _published(key: str, fields: dict[str, Any]) -> Published:
    tolerance = fields.pop("tolerance")
    scale = abs(fields["value"]) if "relative" in tolerance else 1.0
    (amount,) = tolerance.values()
    return Published(key=key, tolerance=amount * scale, **fields)


def published(key: str) -> Published:
    """Return one published number.

    Raises
    ------
    ValueError
        If the paper prints nothing under that key; the message names the closest one.

    Examples
    --------
    >>> published("fig3.precision_ratio").where
    'Figure 3'
    """
    numbers = published_numbers()
    if key not in numbers:
        (closest,) = get_close_matches(key, numbers, n=1, cutoff=0.0)
        raise ValueError(f"Expected a key of paper.yml, got {key!r}. Use {closest!r}.")
    return numbers[key]


def verdict(
    number: Published, value: float, *, reason: str | None = None, tolerance: float | None = None
) -> Verdict:
    """Hold a result against a published number.

    What is not the same quantity is "not comparable", however near it lies. Else it "agrees" within
    the tolerance. Beyond it, the "paper errs" where it has an erratum; a reason given by the caller
    makes it "not comparable"; without either it "differs". A value that is not finite differs.

    Parameters
    ----------
    number : Published
        The paper's number.
    value : float
        Ours, in the same unit.
    reason : str, optional
        Why they cannot agree; shown with the verdict.
    tolerance : float, optional
        Instead of the number's own, absolute and in its unit, ≥ 0.

    Raises
    ------
    ValueError
        If the tolerance is negative or not finite.

    Examples
    --------
    >>> verdict(published("fig3.precision_ratio"), 99.0).outcome
    'agrees'
    """
    allowed = number.tolerance if tolerance is None else float(tolerance)
    if not (math.isfinite(allowed) and allowed >= 0):
        raise ValueError(f"Expected a tolerance ≥ 0, got {tolerance}. Pass it in {number.unit}.")
    why = reason or number.reason
    outcome: Outcome
    if not math.isfinite(value):
        outcome = "differs"
    elif not number.comparable:
        outcome = "not comparable"
    elif _agrees(number, float(value), allowed):
        outcome = "agrees"
    elif number.erratum is not None:
        outcome = "paper errs"
    else:
        outcome = "not comparable" if reason else "differs"
    return Verdict(number, float(value), allowed, outcome, why)


def _agrees(number: Published, value: float, tolerance: float) -> bool:
    if number.relation == "lt":
        return value < number.value + tolerance
    if number.relation == "gt":
        return value > number.value - tolerance
    # the slack keeps a value on the very edge from failing by the last bit of a float
    slack = 4e-16 * (abs(value) + abs(number.value))
    return abs(value - number.value) <= tolerance + slack


def check(
    key: str, value: float, *, reason: str | None = None, tolerance: float | None = None
) -> None:
    """Hold a result against the paper, print one line, and note it for the scoreboard.

    A bad verdict never stops a run; `verdict` gives it as a value.

    Parameters
    ----------
    key : str
        Key of ``paper.yml``.
    value : float
        Our number, in the unit of the published one.
    reason : str, optional
        Why they cannot agree, or where the paper errs.
    tolerance : float, optional
        Instead of the number's own, absolute.

    Raises
    ------
    ValueError
        If the key is unknown.
    """
    found = verdict(published(key), float(value), reason=reason, tolerance=tolerance)
    print(found)
    path = provenance.output_folder() / CHECKS
    records = read_checks(path) if path.exists() else {}
    records[key] = {
        "value": found.value if math.isfinite(found.value) else None,
        "verdict": found.outcome,
        "reason": reason,
        "tolerance": tolerance,
        **provenance.as_dict(),
    }
    provenance.write_json(path, dict(sorted(records.items())))


def read_checks(path: Path) -> dict[str, dict[str, Any]]:
    """Read what a run checked: records by key.

    Raises
    ------
    ValueError
        If the file is no JSON object.
    """
    try:
        records = json.loads(path.read_text(encoding="utf-8"))
    except json.JSONDecodeError as error:
        raise ValueError(f"Expected JSON in {path}, got {error}. Delete it, run again.") from error
    if not isinstance(records, dict):
        kind = type(records).__name__
        raise ValueError(f"Expected a JSON object in {path}, got a {kind}. Delete it, run again.")
    return records


# --- numbers with their units --------------------------------------------------------------------

_PREFIXES = {9: "G", 6: "M", 3: "k", 0: "", -3: "m", -6: "µ", -9: "n", -12: "p", -15: "f"}
_PREFIXED = {"m", "s", "Hz", "W"}


def quantity_text(value: float, unit: str) -> str:
    """Write a number with four digits and its unit.

    Parameters
    ----------
    value : float
        The number in ``unit``.
    unit : str
        SI symbol; ``fraction`` is written in percent, ``1`` as a plain number.

    Examples
    --------
    >>> quantity_text(0.516, "fraction"), quantity_text(3.35e-5, "m"), quantity_text(14.32e9, "Hz")
    ('51.6 %', '33.5 µm', '14.32 GHz')
    """
    if not math.isfinite(value):
        return "not finite"
    size, label = _scale(value, unit)
    return _digits(value / size) + label


def toleranced_text(value: float, tolerance: float, unit: str, joint: str = " ") -> str:
    """Write a number and its tolerance in one unit; a tolerance of zero is left out.

    Parameters
    ----------
    value, tolerance : float
        Both in ``unit`` and finite.
    unit : str
        As in :func:`quantity_text`.
    joint : str
        What stands between them.

    Examples
    --------
    >>> toleranced_text(1.2e-5, 5e-7, "m")
    '12 µm ± 0.5 µm'
    """
    size, label = _scale(value, unit)
    text = _digits(value / size) + label
    return f"{text}{joint}± {_digits(tolerance / size, 2)}{label}" if tolerance else text


def _scale(value: float, unit: str) -> tuple[float, str]:
    if unit == "fraction":
        return 0.01, " %"
    if unit not in _PREFIXED or value == 0:
        return 1.0, "" if unit == "1" else f" {unit}"
    # read from the decimal form: 999.96 Hz rounds to 1 kHz, and 1e-3 is no less than a milli
    exponent = int(f"{value:.3e}".partition("e")[2])
    power = min(max(3 * (exponent // 3), min(_PREFIXES)), max(_PREFIXES))
    return float(f"1e{power}"), f" {_PREFIXES[power]}{unit}"


def _digits(value: float, count: int = 4) -> str:
    text = f"{value:.{count}g}"
    # without an exponent where a reader would not write one
    return format(Decimal(text), "f") if 1e-6 < abs(value) < 1e7 else text
