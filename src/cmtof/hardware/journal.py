"""What a scan has measured so far: an append-only file that a kill at any moment cannot spoil.

Layout, little-endian: the eight bytes ``cmtofJ1\\n``, then records. A record is its length (u32), a
CRC-32 of its number, its length and its content (u32), and the content. Record 0 is the header, a
JSON object; record n + 1 is line n of the plan: a JSON object, a newline, and arrays. Every record
is on the disk (fsync) before the scan goes on. A reader stops at the first record that is torn or
does not match its checksum, so what it gives back is always what was written.
"""

import json
import os
import struct
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from pydantic import ConfigDict, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from cmtof.files import written_whole
from cmtof.hardware.plan import Plan, Record
from cmtof.hardware.reduction import Sampling

MAGIC = b"cmtofJ1\n"
"""First bytes of a journal; the digit is the version of the layout."""
PREFIX = struct.Struct("<II")
"""Length and checksum of a record."""


@dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid", strict=True))
class Header:
    """Everything that the result of a scan depends on, as JSON has it; no address, no clock."""

    version: str
    source: str
    seed: int | None
    scene: str | None
    plan: dict[str, Any]
    sampling: dict[str, int]
    gain: dict[str, float]
    group_index: float
    frequencies: dict[str, float]
    settings: dict[str, Any]
    instruments: dict[str, Any]


def framed(number: int, content: bytes) -> bytes:
    """A record with its length and checksum."""
    return PREFIX.pack(len(content), _checksum(number, content)) + content


def contents(data: bytes) -> Iterator[tuple[bytes, int]]:
    """Whole records of a journal's bytes, each with the place where it ends.

    Examples
    --------
    >>> data = MAGIC + framed(0, b"{}") + framed(1, b"line")
    >>> [content for content, end in contents(data[:-1])]
    [b'{}']
    """
    at, number = len(MAGIC), 0
    while data.startswith(MAGIC) and at + PREFIX.size <= len(data):
        length, checksum = PREFIX.unpack_from(data, at)
        content = data[at + PREFIX.size : at + PREFIX.size + length]
        if len(content) < length or _checksum(number, content) != checksum:
            return
        at, number = at + PREFIX.size + length, number + 1
        yield content, at


def _checksum(number: int, content: bytes) -> int:
    return zlib.crc32(content, zlib.crc32(struct.pack("<II", number, len(content))))


def bytes_from_record(record: Record) -> bytes:
    """Content of a record."""
    shape = list(record.sums.shape)
    about = {"line": record.line, "power": float(record.power), "shape": shape}
    arrays = record.sums.astype("<u4").tobytes() + record.clipped.astype("<u2").tobytes()
    return json.dumps(about).encode() + b"\n" + arrays


def record_from_bytes(content: bytes, plan: Plan, number: int, phases: int) -> Record:
    """Record of a line of a plan; a ValueError where it does not fit."""
    head, _, arrays = content.partition(b"\n")
    about, shape = json.loads(head), (plan.lines[number].bursts, phases)
    power, at = float(about["power"]), 4 * shape[0] * phases
    if (about["line"], tuple(about["shape"]), len(arrays)) != (number, shape, at + 2 * shape[0]):
        raise ValueError("another size")
    if not 0 < power < 1e3:
        raise ValueError("a power that cannot be")
    sums = np.frombuffer(arrays[:at], "<u4").reshape(shape)
    return Record(number, power, sums, np.frombuffer(arrays[at:], "<u2"))


def journal_path(output: str | Path) -> Path:
    """Where the journal of an output lies: beside it.

    Examples
    --------
    >>> journal_path("scans/m.nc").name
    'm.nc.journal'
    """
    output = Path(output)
    return output.with_name(output.name + ".journal")


def read_journal(path: str | Path) -> tuple[dict[str, Any], list[Record]]:
    """Header and whole records of a journal; a torn tail is left out.

    Raises
    ------
    ValueError
        If the file is no journal, or what is in it does not fit its own plan.
    """
    header, records, _ = _read(Path(path))
    return header, records


def _read(path: Path) -> tuple[dict[str, Any], list[Record], int]:
    """Header, records and the place where the last whole record ends."""
    whole = list(contents(path.read_bytes()))
    try:
        header = json.loads(whole[0][0])
        TypeAdapter(Header).validate_json(whole[0][0])
        plan, sampling = Plan.from_dict(header["plan"]), Sampling(**header["sampling"])
        records = [
            record_from_bytes(content, plan, number, sampling.phases)
            for number, (content, _) in enumerate(whole[1:])
        ]
        float(header["settings"]["reference"]["distance"])
        float(header["settings"]["detection"]["limit_volts"])
        dict(header["settings"]["devices"])
        if {*plan.modes} != {*header["frequencies"]} or len(header["gain"]) != 3:
            raise ValueError("other modes")
    except (ValueError, KeyError, IndexError, TypeError, RecursionError) as error:
        reason = "a damaged header" if isinstance(error, ValidationError) else str(error)[:80]
        raise ValueError(
            f"Expected a journal of a scan, whole and fitting its plan, got {path} "
            f"({' '.join(reason.split()) or 'no header'}). Remove it, or restore it from a copy."
        ) from None
    return header, records, whole[-1][1]


class Journal:
    """A journal that is open for writing, by one process at a time.

    Parameters
    ----------
    path : Path
        The file; made with the header where there is none.
    header : mapping
        What the scan depends on. An existing journal must hold the same.

    Raises
    ------
    ValueError
        If the journal belongs to other settings, is none, or another process writes it.
    """

    def __init__(self, path: str | Path, header: Mapping[str, Any]) -> None:
        self.path = Path(path)
        content = json.dumps(header, sort_keys=True).encode()
        if not self.path.exists():
            with written_whole(self.path) as part:
                part.write_bytes(MAGIC + framed(0, content))
        self._file = self.path.open("r+b")
        try:
            _lock(self._file, self.path)
            self.header, self.records, end = _read(self.path)
            check_same(self.header, json.loads(content), self.path)
            self._file.truncate(end)  # the torn tail
            self._file.seek(end)
            self._settle()
        except BaseException:
            self._file.close()
            raise

    def append(self, record: Record) -> None:
        """Add the next line; it is on the disk when this returns."""
        if record.line != len(self.records):
            raise ValueError(
                f"Expected line {len(self.records)} next, got {record.line}. Keep the plan's order."
            )
        self._file.write(framed(record.line + 1, bytes_from_record(record)))
        self._settle()
        self.records.append(record)

    def _settle(self) -> None:
        self._file.flush()
        os.fsync(self._file.fileno())

    def __enter__(self) -> "Journal":
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()


def _lock(file: BinaryIO, path: Path) -> None:
    try:
        import fcntl
    except ImportError:  # Windows has no advisory locks of this kind
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise ValueError(
            f"Expected {path} for this scan alone, got one that another scan writes. "
            "Wait for it, or name another output."
        ) from None


def check_same(found: Mapping[str, Any], wanted: Mapping[str, Any], path: Path) -> None:
    """Raise a ValueError that names the first setting in which a journal differs."""
    for key, old, new in _differences(found, wanted):
        old, new = json.dumps(old)[:60], json.dumps(new)[:60]
        raise ValueError(
            f"Expected {path} to belong to these settings, got {key} = {old} where now it "
            f"is {new}. Scan with its settings, or remove it to begin again."
        )


def _differences(old: Any, new: Any, name: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Names and values of the settings that differ."""
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        for key in sorted({*old, *new}):
            yield from _differences(old.get(key), new.get(key), f"{name}.{key}".lstrip("."))
    elif old != new:
        yield name, old, new
