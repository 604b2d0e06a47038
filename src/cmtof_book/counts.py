"""Counts of right pixels in unwrapped measurements, kept in a file: none is computed twice."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from cmtof import unwrap
from cmtof.evaluation import Tally, scored_pixels
from cmtof.measurement import Measurement
from cmtof.types import Fields
from cmtof_book.provenance import read_json, write_json


class Counts:
    """What was counted, in a file of JSON that is written after each count."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.held = read_json(path)

    def keep(self, *keys: str, of: Callable[[], Any]) -> Any:
        """Value below some keys of the file, computed by ``of`` and stored if it is missing."""
        *above, last = keys
        place = self.held
        for key in above:
            place = place.setdefault(key, {})
        if last not in place:
            place[last] = of()
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
