"""What a scan has measured so far: an append-only file that a kill at any moment cannot spoil.

A line of text each: the CRC-32 of what follows, a space, and a JSON object. The first is the
header, everything that the result depends on; the others are the lines of the plan. Each is on the
disk (fsync) before the scan goes on. What follows a line that is torn or damaged does not count.
"""

import fcntl
import json
import os
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import inf
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from cmtof.files import written_whole
from cmtof.hardware.plan import Line, Plan, Record


def journal_path(output: str | Path) -> Path:
    """Where the journal of an output lies: beside it, ``m.nc.journal``."""
    return Path(f"{output}.journal")


def framed(content: bytes) -> bytes:
    """Line of a journal."""
    return b"%08x %s\n" % (zlib.crc32(content), content)


def whole_lines(path: str | Path) -> list[bytes]:
    """JSON of the header and of every line that is whole; nothing of a file that is no journal."""
    found = []
    for line in Path(path).read_bytes().splitlines(keepends=True):
        if line != framed(line[9:-1]):
            break
        found.append(line[9:-1])
    return found


class Journal(NamedTuple):
    """A journal that is open for writing, with the records that it holds."""

    file: BinaryIO
    records: list[Record]

    def append(self, record: Record) -> None:
        """Add the next line; it is on the disk when this returns."""
        content = json.dumps(record._asdict(), default=np.ndarray.tolist)
        self.file.write(framed(content.encode()))
        self.file.flush()
        os.fsync(self.file.fileno())
        self.records.append(record)


@contextmanager
def open_journal(path: Path, header: Mapping[str, Any], plan: Plan) -> Iterator[Journal]:
    """Journal of a plan, by one process at a time; made with the header where there is none.

    Raises ValueError if it belongs to other settings, is none, or another process writes it.
    """
    if not path.exists():
        with written_whole(path) as part:
            part.write_bytes(framed(json.dumps(header).encode()))
    with path.open("r+b") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ValueError(
                f"Expected {path} for this scan alone, got one that another scan writes. "
                "Wait for it, or name another output."
            ) from None
        lines = whole_lines(path)
        try:
            other = difference(json.loads(lines[0]), json.loads(json.dumps(header)))
            rows = [] if other else lines[1:]
            records = [_record(row, plan.lines[n], plan.kept.size) for n, row in enumerate(rows)]
        except (ArithmeticError, LookupError, RecursionError, TypeError, ValueError):
            raise ValueError(
                f"Expected a journal of this scan, got another file or a damaged one, {path}. "
                "Remove it, or restore it from a copy."
            ) from None
        if other:
            raise ValueError(
                f"Expected {path} to belong to these settings, got {other}. Scan with its "
                "settings, or remove it to begin again."
            )
        file.truncate(sum(len(framed(line)) for line in lines))  # without a torn end
        file.seek(0, os.SEEK_END)
        yield Journal(file, records)


def _record(content: bytes, line: Line, phases: int) -> Record:
    """Record of a line of the plan; an error of any kind where it does not fit."""
    found = json.loads(content)
    sums = np.array(found["sums"], np.uint32)
    clipped = np.array(found["clipped"], np.uint16)
    right = sums.shape == (len(line.labels), phases) and clipped.shape == (len(line.labels),)
    if not (right and found["line"] == line.index and 0 < found["power"] < inf):
        raise ValueError("another line")
    return Record(line.index, float(found["power"]), sums, clipped)


def difference(old: Any, new: Any, name: str = "") -> str:
    """Name and values of the first setting that differs; empty where none does."""
    if isinstance(old, dict) and isinstance(new, dict):
        inside = (difference(old.get(k), new.get(k), f"{name}.{k}") for k in sorted({*old, *new}))
        return next(filter(None, inside), "")
    texts = json.dumps(old)[:60], json.dumps(new)[:60]
    return "" if old == new else f"{name[1:]} = {texts[0]} where now it is {texts[1]}"
