"""Copy the figures of a build into the folder that is committed, only where they changed.

python tools/figures.py RESULTS FIGURES

Prints the name of every figure. A figure that no notebook draws any more is removed.
"""

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
        if not target.is_file() or target.read_bytes() != content:
            part = figures / f".{name}.part"
            part.write_bytes(content)
            part.replace(target)
        print(name)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
