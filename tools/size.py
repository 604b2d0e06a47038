"""Lines of every part of the project beside its budget; exit code 1 where one has more.

python tools/size.py

Lines of Python, YAML, JavaScript, CSS and shell, comments and blank lines included. The rooms of
the package stand below for orientation; the rows above them are the budget.
"""

import re
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
COUNTED = re.compile(r"\.(py|yml|js|css|sh)$|(^|/)(Snakefile|Makefile)$")
BUDGET = {
    "src/cmtof/scenes/rooms": (2_500, r"src/cmtof/scenes/rooms/"),
    "src/cmtof without them": (12_500, r"src/cmtof/"),
    "tests": (9_000, r"tests/"),
    "notebooks/*.py": (8_000, r"notebooks/.*\.py$"),
    "tools, benchmarks, book/_ext, Snakefile, Makefile": (
        1_700,
        r"(tools|benchmarks|book/_ext)/|Snakefile$|Makefile$",
    ),
}
CHAPTERS = 24
ROOMS = {
    "constants jones waveform modulator correlation detector bounds": 1_200,
    "measurement simulation statistics noise": 900,
    "methods unwrapping evaluation": 450,
    "scenes": 900,
    "baselines": 1_200,
    "surfaces": 1_300,
    "network": 1_350,
    "instrument": 950,
    "hardware": 1_700,
    "ranging": 950,
    "stereo": 350,
    "book": 850,
    "cli": 400,
}
"""What each room of ``src/cmtof`` aims at; a name is a module or a folder."""


def tracked() -> list[Path]:
    """Files that git knows or would add and that count, relative to the checkout."""
    command = ["git", "ls-files", "-co", "--exclude-standard", "-z"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, check=True).stdout.decode()
    names = {name for name in listed.split("\0") if COUNTED.search(name)}
    return [Path(name) for name in sorted(names) if (ROOT / name).is_file()]


def lines(files: Iterable[Path]) -> int:
    """Sum of the lines of files."""
    return sum((ROOT / file).read_bytes().count(b"\n") for file in files)


def parts(files: Iterable[Path]) -> dict[str, list[Path]]:
    """Files by the row of the budget that they belong to: the first that fits."""
    found: dict[str, list[Path]] = {name: [] for name in BUDGET}
    for file in files:
        rows = (name for name, (_, place) in BUDGET.items() if re.match(place, file.as_posix()))
        if name := next(rows, None):
            found[name].append(file)
    return found


def main() -> int:
    """Print the table; return the exit code."""
    found = parts(tracked())
    counts = {name: (lines(found[name]), allowed) for name, (allowed, _) in BUDGET.items()}
    counts["chapters"] = (len(found["notebooks/*.py"]), CHAPTERS)
    for name, (count, allowed) in counts.items():
        print(f"{name:64} {count:6} of {allowed:6}{'  OVER' if count > allowed else ''}")
    rest = found["src/cmtof without them"]
    for room, aim in ROOMS.items():
        inside = [file for file in rest if file.parts[2].removesuffix(".py") in room.split()]
        rest = [file for file in rest if file not in inside]
        print(f"  {room:62} {lines(inside):6} of {aim:6}")
    print(f"  {' '.join(sorted({file.parts[2] for file in rest})):62} {lines(rest):6}")
    return int(any(count > allowed for count, allowed in counts.values()))


if __name__ == "__main__":
    sys.exit(main())
