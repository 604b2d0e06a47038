"""Store the numbers of the ci profile as those that the tests compare with.

    python -m cmtof_book.reference [SEED...] [NOTEBOOK...]

Reads ``build/ci/results`` and writes ``tests/reference/ci``: one file for each figure, and one for
the checks of each notebook. Every number carries its relative tolerance, at first `TOLERANCE`. With
seeds the notebooks are run with each of them too: a number that moves from seed to seed gets an
absolute tolerance of twice the range it moved over, for another processor may round a rate
differently and so draw other noise. Tolerances stay when the numbers are stored again. With
notebooks named, such as ``08_network``, only theirs are stored.

A figure whose numbers name their ``source``, measured or simulated, has a file for each.
"""

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cmtof_book.graph import Book

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "build" / "ci" / "results"
REFERENCE = ROOT / "tests" / "reference" / "ci"

TOLERANCE = 1e-5
"""Relative tolerance of a number: processors differ by 3e-6 in sums over spectra."""

FLOOR = 1e-12
"""Absolute tolerance, for numbers that are zero but for rounding."""

Plain = float | int | str | bool | None


def flat(value: Any, name: str = "") -> dict[str, Plain]:
    """Every number of nested dicts and lists under a name such as ``sigma[2].bound``."""
    if isinstance(value, dict):
        pairs = [(f"{name}.{key}" if name else key, item) for key, item in value.items()]
    elif isinstance(value, list):
        pairs = [(f"{name}[{index}]", item) for index, item in enumerate(value)]
    else:
        return {name: value}
    return {key: number for path, item in pairs for key, number in flat(item, path).items()}


def found(results: Path = RESULTS, stems: Sequence[str] = ()) -> dict[str, dict[str, Plain]]:
    """Numbers that notebooks drew or checked, by the name of their reference file."""
    tables: dict[str, dict[str, Plain]] = {}
    for file in sorted(results.glob("*/*.json")):
        if stems and file.parent.name not in stems:
            continue
        content = json.loads(file.read_text(encoding="utf-8"))
        if file.name == "checks.json":
            values = {key: record["value"] for key, record in content.items()}
            tables[f"{file.parent.name}.checks.json"] = flat(values)
        else:
            source = content["numbers"].get("source")
            tables[f"{file.stem}.{source}.json" if source else file.name] = flat(content["numbers"])
    return tables


def stored(reference: Path = REFERENCE) -> dict[str, dict[str, dict[str, Any]]]:
    """Stored numbers with their tolerances, by file name."""
    files = sorted(reference.glob("*.json"))
    return {file.name: json.loads(file.read_text(encoding="utf-8")) for file in files}


def agrees(value: Plain, entry: dict[str, Any]) -> bool:
    """Whether a number lies within the tolerance of its stored one; texts must be equal."""
    expected = entry["value"]
    plain = (bool, str, type(None))
    if isinstance(value, plain) or isinstance(expected, plain):
        return value == expected
    return abs(value - expected) <= entry["rtol"] * abs(expected) + entry.get("atol", FLOOR)


def spread(seeds: Sequence[int], stems: Sequence[str]) -> dict[tuple[str, str], float]:
    """Run notebooks of the ci profile with other seeds; how far each number moved."""
    book, runs = Book(ROOT), [found(stems=stems)]
    for seed in seeds:
        build = ROOT / "build" / f"ci-seed-{seed}"
        for stem in stems or book.notebooks():
            parameters = json.dumps(book.parameters(stem, "ci") | {"seed": seed})
            targets = [f"{build}/notebooks/{stem}.ipynb", f"{build}/results/{stem}"]
            command = ["-m", "cmtof_book.execute", f"notebooks/{stem}.py", parameters, *targets]
            subprocess.run([sys.executable, *command], cwd=ROOT, check=True)
        runs.append(found(build / "results", stems))
    moved = {}
    for name, numbers in runs[0].items():
        for key, value in numbers.items():
            if isinstance(value, int | float) and not isinstance(value, bool):
                values: list[Any] = [run[name][key] for run in runs]
                moved[name, key] = float(max(values) - min(values))
    return moved


def main(seeds: Sequence[int], stems: Sequence[str] = ()) -> int:
    """Write the reference files; return the exit code."""
    tables, before = found(stems=stems), stored()
    if not tables:
        print(f"Expected results in {RESULTS}, got none. Run make test first.", file=sys.stderr)
        return 1
    REFERENCE.mkdir(parents=True, exist_ok=True)
    known = {name for name in before if not name.endswith((".measured.json", ".simulated.json"))}
    for name in () if stems else known - tables.keys():
        (REFERENCE / name).unlink()
    moved = spread(seeds, stems) if seeds else {}
    for name, numbers in tables.items():
        old = before.get(name, {})
        entries = {
            key: {"rtol": TOLERANCE, **old.get(key, {}), "value": value}
            for key, value in sorted(numbers.items())
        }
        for key, entry in entries.items():
            distance = moved.get((name, key), 0.0)
            if distance and distance > TOLERANCE * abs(float(entry["value"] or 0)):
                entry["atol"] = float(f"{2 * distance:.2g}")
        text = json.dumps(entries, indent=1, ensure_ascii=False) + "\n"
        (REFERENCE / name).write_text(text, encoding="utf-8")
        other = [k for k, value in numbers.items() if k in old and not agrees(value, old[k])]
        print(f"{name}: {len(numbers)} numbers" + (f", moved: {', '.join(other)}" if other else ""))
    return 0


if __name__ == "__main__":
    words = sys.argv[1:]
    seeds = [int(word) for word in words if word.isdigit()]
    sys.exit(main(seeds, [word for word in words if not word.isdigit()]))
