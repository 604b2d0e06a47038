"""Lines of every part of the project beside what it may have; exit code 1 where one has more.

python tools/size.py

Lines of Python, YAML, JavaScript, CSS and shell, comments and blank lines included. The rooms of
the package are listed for orientation; the five rows above them are the budget.
"""

import re
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SUFFIXES = {".py", ".yml", ".js", ".css", ".sh"}
BUDGET = {
    "src/cmtof without scenes/rooms": 12_500,
    "src/cmtof/scenes/rooms": 2_500,
    "tests": 9_000,
    "notebooks/*.py": 8_000,
    "tools, benchmarks, book/_ext, Snakefile, Makefile": 1_700,
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
    """Files that git knows or would add, relative to the checkout."""
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard", "-z"],
        cwd=ROOT,
        capture_output=True,
        check=True,
    )
    return [Path(name) for name in sorted(set(listed.stdout.decode().split("\0"))) if name]


def lines(files: Iterable[Path]) -> int:
    """Sum of the lines of those files that are there and count."""
    counted = (ROOT / file for file in files if file.suffix in SUFFIXES or file.stem == file.name)
    return sum(path.read_bytes().count(b"\n") for path in counted if path.is_file())


def parts(files: Iterable[Path]) -> dict[str, list[Path]]:
    """Files by the row of the budget that they belong to."""
    found: dict[str, list[Path]] = {name: [] for name in BUDGET}
    package, rooms, tests, notebooks, tools = found
    patterns = {
        rooms: r"src/cmtof/scenes/rooms/",
        package: r"src/cmtof/",
        tests: r"tests/",
        notebooks: r"notebooks/.*\.py$",
        tools: r"(tools|benchmarks|book/_ext)/|Snakefile$|Makefile$",
    }
    for file in files:
        name = next((n for n, p in patterns.items() if re.match(p, file.as_posix())), None)
        if name and (file.suffix in SUFFIXES or file.name in ("Snakefile", "Makefile")):
            found[name].append(file)
    return found


def main() -> int:
    """Print the table; return the exit code."""
    files = tracked()
    found = parts(files)
    over = False
    for name, allowed in BUDGET.items():
        count = lines(found[name])
        over |= count > allowed
        print(f"{name:66} {count:6} of {allowed:6}{'  OVER' if count > allowed else ''}")
    chapters = sum((ROOT / file).is_file() for file in found["notebooks/*.py"])
    over |= chapters > CHAPTERS
    print(f"{'chapters':66} {chapters:6} of {CHAPTERS:6}{'  OVER' if chapters > CHAPTERS else ''}")
    print()
    package = found["src/cmtof without scenes/rooms"]
    for room, aim in ROOMS.items():
        names = set(room.split())
        inside = [f for f in package if f.parts[2].removesuffix(".py") in names]
        print(f"{room:66} {lines(inside):6} of {aim:6}")
        package = [f for f in package if f not in inside]
    rest = ", ".join(sorted({f.parts[2].removesuffix(".py") for f in package if f.suffix == ".py"}))
    print(f"{rest:66} {lines(package):6}")
    return int(over)


if __name__ == "__main__":
    sys.exit(main())
