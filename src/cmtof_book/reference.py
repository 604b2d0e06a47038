"""Store the numbers of the ci profile that tests compare with, each by its kind.

    python -m cmtof_book.reference

Reads the records of ``build/ci/results`` and writes ``tests/reference/numbers.json``, a line for
each number that has a kind (`cmtof_book.compared`). Names those that left their tolerance.
"""

import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from cmtof_book import ROOT
from cmtof_book.compared import Compared
from cmtof_book.provenance import read_json
from cmtof_book.record import read_all

STORED = ROOT / "tests" / "reference" / "numbers.json"
# Records of the build to compare; the variable names one that was made as on another machine.
RESULTS = Path(os.environ.get("CMTOF_RESULTS") or ROOT / "build" / "ci" / "results")

# Numbers by chapter, record and name, such as ``02_precision/fig03_precision/ratio``.
Numbers = dict[str, Compared]


def found_numbers() -> Numbers:
    """Numbers of a build that have a kind."""
    return {
        f"{record.chapter}/{record.name}/{name}": number
        for record in read_all(RESULTS)
        for name, number in record.compared().items()
    }


def stored_numbers() -> Numbers:
    """Numbers as they were stored."""
    return {name: Compared(**record) for name, record in read_json(STORED).items()}


def differences(found: Numbers, stored: Numbers) -> Iterator[str]:
    """What is missing, new, or farther apart than its kind allows; a line for each."""
    for name in sorted(found.keys() ^ stored.keys()):
        yield f"{name}: {'new' if name in found else 'gone'}"
    for name in sorted(found.keys() & stored.keys()):
        new = found[name]
        old = stored[name]
        if new.kind != old.kind or not old.accepts(new.value, new.error or 0.0):
            yield f"{name}: {new.value} instead of {old.record()}"


def main() -> None:
    """Write the file; exit code 1 where there are no results."""
    found = found_numbers()
    if not found:
        sys.exit(f"Expected results in {RESULTS}, got none. Run make test first.")
    for line in differences(found, stored_numbers()):
        print(line)
    lines = [
        f' "{name}": {json.dumps(number.record())}'
        for name, number in sorted(found.items())
    ]
    STORED.write_text("{\n" + ",\n".join(lines) + "\n}\n", "utf-8")
    print(
        f"{sum(np.size(number.value) for number in found.values())} numbers in {STORED.name}"
    )


if __name__ == "__main__":
    main()
