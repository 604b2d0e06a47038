"""Store the numbers of the ci profile that tests compare with, each by its kind.

    python -m cmtof_book.reference

Reads the records of ``build/ci/results`` and writes ``tests/reference/numbers.json``, a line for
each number that has a kind (`cmtof_book.compared`). Names those that left their tolerance.
"""

import json
import os
from collections.abc import Iterator
from pathlib import Path

from cmtof_book import ROOT
from cmtof_book.compared import Compared
from cmtof_book.provenance import read_json
from cmtof_book.record import read_all

STORED = ROOT / "tests/reference/numbers.json"
# Records of the build to compare; the variable names one that was made as on another machine.
RESULTS = Path(os.environ.get("CMTOF_RESULTS") or ROOT / "build/ci/results")

# Numbers by chapter, record and name, such as ``02_precision/fig03_precision/ratio``.
Numbers = dict[str, Compared]


def found_numbers() -> Numbers:
    """Numbers of a build that have a kind."""
    return {
        f"{record.chapter}/{record.name}/{name}": Compared(**number)
        for record in read_all(RESULTS)
        for name, number in record.numbers.items()
        if isinstance(number, dict) and "kind" in number
    }


def stored_numbers() -> Numbers:
    """Numbers as they were stored."""
    return {name: Compared(**record) for name, record in read_json(STORED).items()}


def differences(found: Numbers, stored: Numbers) -> Iterator[str]:
    """What is missing, new, or farther apart than its kind allows; a line for each."""
    for name in sorted(found.keys() | stored.keys()):
        new = found.get(name)
        old = stored.get(name)
        if not new or not old:
            yield f"{name}: {'new' if new else 'gone'}"
        elif new.kind != old.kind or not old.accepts(new.value, new.error or 0.0):
            yield f"{name}: {new.value} instead of {old.record()}"


def main() -> None:
    """Store the numbers of the build, and print what differs from those stored before."""
    found = found_numbers()
    for line in differences(found, stored_numbers()):
        print(line)
    lines = [
        f' "{name}": {json.dumps(number.record())}'
        for name, number in sorted(found.items())
    ]
    STORED.write_text("{\n" + ",\n".join(lines) + "\n}\n", "utf-8")


if __name__ == "__main__":
    main()
