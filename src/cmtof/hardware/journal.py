"""Record of a running scan: an append-only file that a kill at any moment cannot damage.

A line of text each: the CRC-32 of what follows, a space, and a JSON object. The first is the
header, everything that the result depends on; the others are the lines of the plan. Each is on the
disk (fsync) before the scan goes on. What follows a line that is torn or damaged does not count.
"""

import json
import os
import zlib
from functools import partial
from pathlib import Path

import numpy as np

from cmtof.files import AnyPath, reading
from cmtof.hardware.plan import Line, LineRecord, Plan
from cmtof.types import Named

# Arrays of a record, and their types.
KINDS = {"locks": float, "times": float, "sums": np.uint32, "clipped": np.uint16}


def journal_path(output: AnyPath) -> Path:
    """Path of the journal of an output, beside it: ``m.nc.journal``."""
    return Path(f"{output}.journal")


def journal_line(content: bytes) -> bytes:
    """Line of a journal: checksum, content and newline."""
    return b"%08x %s\n" % (zlib.crc32(content), content)


def whole_lines(path: Path) -> list[bytes]:
    """JSON of a journal's lines, header first, up to the first damaged one; may be empty."""
    found = []
    for line in path.read_bytes().splitlines(keepends=True):
        if line != journal_line(line[9:-1]):
            break
        found.append(line[9:-1])
    return found


def append_line(path: Path, content: Named) -> None:
    """Add a line to a journal; it is on the disk when this returns."""
    with path.open("ab") as file:
        file.write(
            journal_line(json.dumps(content, default=np.ndarray.tolist).encode())
        )
        file.flush()
        os.fsync(file.fileno())


def check_settings(path: Path, old: Named, new: Named) -> None:
    """Raise a ValueError unless the ``old`` settings of a file equal the ``new`` ones."""
    for name in new:
        if old.get(name) != new[name]:
            raise ValueError(
                f"Expected {path} to be of these settings, got another {name}, "
                f"{old.get(name)!s:.60}. Scan with its settings, or remove it to begin again."
            )


def resume_journal(path: Path, header: Named, plan: Plan) -> list[LineRecord]:
    """Records in a plan's journal, whose damaged end is cut off; an empty one gets its header.

    Raises ValueError if it belongs to other settings, or is none.
    """
    if not path.stat().st_size:
        append_line(path, header)
    lines = whole_lines(path)
    whole = partial(
        reading,
        "a whole journal of this scan",
        path,
        "Remove it, or restore it from a copy.",
    )
    with whole():
        old = json.loads(lines[0])
        old = old["settings"] | old
    check_settings(path, old, header["settings"] | header)
    with whole():
        records = [
            _record(row, plan.lines[n], plan.kept.size)
            for n, row in enumerate(lines[1:])
        ]
    # without a torn end
    os.truncate(path, sum(len(journal_line(line)) for line in lines))
    return records


def _record(content: bytes, line: Line, phases: int) -> LineRecord:
    """Record of one line of the plan from JSON; an error if it does not fit that line."""
    found = json.loads(content)
    arrays = {name: np.array(found[name], kind) for name, kind in KINDS.items()}
    record = LineRecord(**found | arrays)
    bursts = len(line.labels)
    shapes = [one.shape for one in arrays.values()]
    sensible = 1e-15 < record.power < 1e3 and 0 < record.rate < 1e9
    fit = shapes == [(2, 2), (bursts,), (bursts, phases), (bursts,)]
    if not (
        fit
        and sensible
        and np.isfinite(record.times).all()
        and record.line == line.index
    ):
        raise ValueError("another line")
    return record
