"""Record of a running scan: an append-only file that a kill at any moment cannot damage.

A line of text each: the CRC-32 of what follows, a space, and a JSON object. The first is the
header, everything that the result depends on; the others are the lines of the plan. Each is on the
disk (fsync) before the scan goes on. What follows a line that is torn or damaged does not count.
"""

import json
import os
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cmtof.hardware.plan import Line, Plan, Record
from cmtof.validation import expect


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


def append(path: Path, content: Mapping[str, Any]) -> None:
    """Add a line to a journal; it is on the disk when this returns."""
    with path.open("ab") as file:
        file.write(framed(json.dumps(content, default=np.ndarray.tolist).encode()))
        file.flush()
        os.fsync(file.fileno())


def begun(path: Path, header: Mapping[str, Any], plan: Plan) -> list[Record]:
    """Records of a plan's journal, which is cut behind them, or begun where there is none.

    Raises ValueError if it belongs to other settings, or is none.
    """
    if not path.exists() or not path.stat().st_size:
        append(path, header)
    lines = whole_lines(path)
    try:
        old, new = (one["settings"] | one for one in (json.loads(lines[0]), header))
        other = [name for name in new if old.get(name) != new[name]]
        rows = [] if other else lines[1:]
        records = [_record(row, plan.lines[n], plan.kept.size) for n, row in enumerate(rows)]
    except (ArithmeticError, LookupError, RecursionError, TypeError, ValueError):
        what = f"a journal of this scan, got another file or a damaged one, {path}"
        raise ValueError(f"Expected {what}. Remove it, or restore it from a copy.") from None
    got = f"another {other[0]}, {old.get(other[0])!r:.60}" if other else ""
    advice = "Scan with its settings, or remove it to begin again."
    expect(not other, f"{path} to be of these settings", got, advice)
    os.truncate(path, sum(len(framed(line)) for line in lines))  # without a torn end
    return records


def _record(content: bytes, line: Line, phases: int) -> Record:
    """Record of a line of the plan; an error of any kind where it does not fit."""
    found = json.loads(content)
    sums = np.array(found["sums"], np.uint32)
    clipped = np.array(found["clipped"], np.uint16)
    times = np.array(found["times"], float)
    power = float(found["power"])
    rate = float(found["rate"])
    bursts = len(line.labels)
    shapes = (sums.shape, clipped.shape, times.shape) == ((bursts, phases), (bursts,), (bursts,))
    sensible = 1e-15 < power < 1e3 and 0 < rate < 1e9 and np.isfinite(times).all()
    if not (shapes and sensible and found["line"] == line.index):
        raise ValueError("another line")
    return Record(line.index, power, rate, times, sums, clipped)
