"""Accept the figures of a build: copy them into the folder that is committed.

python -m cmtof_book.figures RESULTS FIGURES

Prints the name of every figure. A figure that no notebook draws any more is removed. One that was
drawn from measured data stays where a machine without those data draws a simulated one instead.
"""

import json
import sys
from pathlib import Path

SUFFIXES = {".svg", ".png", ".json"}


def main(results: Path, figures: Path) -> None:
    """Make ``figures`` hold what the notebooks' folders in ``results`` hold, checks left out."""
    drawn = {
        file.name: file
        for file in sorted(results.glob("*/*"))
        if file.suffix in SUFFIXES and file.name != "checks.json"
    }
    figures.mkdir(exist_ok=True)
    for file in figures.iterdir():
        if file.suffix in SUFFIXES and file.name not in drawn:
            file.unlink()
    for name, file in drawn.items():
        content, target = file.read_bytes(), figures / name
        sources = [_source(path.with_suffix(".json")) for path in (target, file)]
        if sources == ["measured", "simulated"]:
            continue
        if not target.is_file() or target.read_bytes() != content:
            part = figures / f".{name}.part"
            part.write_bytes(content)
            part.replace(target)
        print(name)


def _source(numbers: Path) -> str | None:
    """Return what a figure's numbers say of their source, if they do."""
    if not numbers.is_file():
        return None
    return json.loads(numbers.read_text(encoding="utf-8"))["numbers"].get("source")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
