"""Counts of right pixels in unwrapped measurements, kept in a file: none is computed twice."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from cmtof import __version__, unwrap
from cmtof.evaluation import Tally, scored_pixels
from cmtof.measurement import Measurement
from cmtof.types import Fields
from cmtof_book.provenance import read_json, write_json


class Counts:
    """What a module counted, in a JSON file of its name that is written after each count."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.held = read_json(path)
        self.store(command=f"python -m cmtof_book.{path.stem}", version=__version__)

    def keep(
        self, keys: Sequence[str], count: Callable, *given: Any, **how: Any
    ) -> Any:
        """Value below some keys of the file, counted from what is given if it is missing."""
        *above, last = keys
        place = self.held
        for key in above:
            place = place.setdefault(key, {})
        if last not in place:
            place[last] = count(*given, **how)
            print(*keys, place[last], flush=True)
            self.store()
        return place[last]

    def store(self, **about: Any) -> None:
        """Add ``about`` to what is held, and write it all to the file."""
        self.held |= about
        write_json(self.path, self.held)


def counts_of(scans: Iterable[Measurement], **options: Any) -> list[Fields]:
    """Counts by `Tally.add`, of pixels by error, of each measurement, unwrapped with options."""
    pixels = (scored_pixels(unwrap(scan, **options), scan) for scan in scans)
    return [*map(Tally().add, pixels)]
