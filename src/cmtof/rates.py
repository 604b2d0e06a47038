"""Rates of methods side by side, as the chapters on limits and on our method print them."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cmtof.resampling import Interval, draws_of, ratio_interval
from cmtof.tally import Record, below, scored

COLUMNS = {"delta_lt_1": "δ < 1", "delta_lt_3": "δ < 3", "delta_ge_10": "δ ≥ 10"}
"""The rates that are shown, by their names in the JSON of ``cmtof evaluate``."""


def rates_of_counts(
    records: Sequence[Record], labels: Sequence[str], *, draws: int, seed: int
) -> dict[str, Interval]:
    """Rates (3,) of `COLUMNS` for the methods that counts hold, with intervals over scenes.

    Parameters
    ----------
    records : list of dict
        Of `cmtof.tally.count`.
    labels : sequence of str
        What is wanted; those that were not counted are left out.
    draws, seed : int
        Sets of scenes drawn again, the same ones for every method.
    """
    if not records:
        return {}
    whole = scored(records)
    drawn = draws_of(len(records), draws=draws, rng=np.random.default_rng(seed))
    found = {}
    for label in labels:
        if label in records[0]["methods"]:
            under = below(records, label)
            part = np.stack([under[0], under[2], whole - under[3]])
            found[label] = ratio_interval(part, whole, drawn)
    return found


def rates_of_report(report: Mapping[str, Any], labels: Sequence[str]) -> dict[str, Interval]:
    """The same from the JSON of ``cmtof evaluate``; it has no intervals, so their ends are NaN."""
    unknown = np.full(len(COLUMNS), np.nan)
    return {
        label: Interval(np.array([report["methods"][label][c] for c in COLUMNS]), unknown, unknown)
        for label in labels
        if label in report["methods"]
    }


def markdown_table(
    labels: Sequence[str], rates: Mapping[str, Mapping[str, Interval]], *rows: tuple[str, Sequence]
) -> str:
    """Rates in % as a table in markdown, a method a line.

    Parameters
    ----------
    labels : sequence of str
        Methods, in order; ``cmtof`` is set in bold.
    rates : dict of dict of Interval
        By protocol and method; an interval follows the first rate where there is one.
    *rows : (str, sequence)
        Further lines: a name and three cells for each protocol.

    Examples
    --------
    >>> report = {"methods": {"crt": dict.fromkeys(COLUMNS, 0.5)}}
    >>> print(markdown_table(["crt"], {"released": rates_of_report(report, ["crt"])}))
    | | released: δ < 1 | δ < 3 | δ ≥ 10 |
    | --- | --: | --: | --: |
    | `crt` | 50.0 | 50.0 | 50.0 |
    """
    first, *others = COLUMNS.values()
    heads = [head for protocol in rates for head in (f"{protocol}: {first}", *others)]
    lines = [f"| | {' | '.join(heads)} |", "| --- |" + " --: |" * len(heads)]
    for label in labels:
        cells = [cell for found in rates.values() for cell in _cells(found.get(label))]
        mark = "**" if label == "cmtof" else ""
        lines.append(f"| {mark}`{label}`{mark} | {' | '.join(cells)} |")
    lines += [f"| {name} | {' | '.join(map(str, cells))} |" for name, cells in rows]
    return "\n".join(lines)


def _cells(rate: Interval | None) -> list[str]:
    if rate is None:
        return [""] * len(COLUMNS)
    cells = [f"{100 * value:.1f}" for value in rate.value]
    if np.isfinite(rate.low[0]):
        # word joiners keep the ends of the interval in one line
        cells[0] += f"<br>({100 * rate.low[0]:.1f}\u2060–\u2060{100 * rate.high[0]:.1f})"
    return cells
