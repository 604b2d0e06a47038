"""The journal gives back what was written, or less, never anything else."""

import json
import os

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cmtof.hardware.journal import (
    MAGIC,
    Journal,
    Record,
    contents,
    framed,
    journal_path,
    read_journal,
)

HEADER = {"plan": {"shape": [2, 3]}, "seed": 0}


def record(line: int, bursts: int = 3, phases: int = 4) -> Record:
    rng = np.random.default_rng(line)
    sums = rng.integers(0, 2**20, (bursts, phases)).astype(np.uint32)
    return Record(line, 1e-3 * (line + 1) / 3, sums, rng.integers(0, 9, bursts).astype(np.uint16))


def same(one: Record, other: Record) -> bool:
    return (
        (one.line, one.power) == (other.line, other.power)
        and np.array_equal(one.sums, other.sums)
        and np.array_equal(one.clipped, other.clipped)
    )


@pytest.fixture
def written(tmp_path):
    path = tmp_path / "m.nc.journal"
    with Journal(path, HEADER) as journal:
        for line in range(5):
            journal.append(record(line))
    return path


def test_records_come_back_bit_for_bit(written):
    header, records = read_journal(written)
    assert header == HEADER
    assert len(records) == 5
    assert all(same(one, record(line)) for line, one in enumerate(records))


def test_it_lies_beside_the_output(tmp_path):
    assert journal_path(tmp_path / "m.nc") == tmp_path / "m.nc.journal"


WHOLE = MAGIC + b"".join(
    framed(number, content)
    for number, content in enumerate([json.dumps(HEADER).encode(), *map(bytes, (b"a", b"bb", b""))])
)
PARTS = [content for content, _ in contents(WHOLE)]


@given(st.integers(0, len(WHOLE)))
def test_any_truncation_leaves_a_beginning(size):
    kept = [content for content, end in contents(WHOLE[:size]) if end <= size]
    assert kept == PARTS[: len(kept)]


@given(st.integers(0, len(WHOLE) - 1), st.integers(1, 255), st.binary(max_size=40))
def test_any_flipped_byte_and_any_tail_never_give_a_wrong_record(at, flip, tail):
    data = bytearray(WHOLE)
    data[at] ^= flip
    kept = [content for content, _ in contents(bytes(data) + tail)]
    assert kept == PARTS[: len(kept)]
    assert len(kept) < len(PARTS)


@given(st.permutations(range(1, 4)))
def test_records_out_of_order_end_the_reading(order):
    frames = [framed(number, content) for number, content in enumerate(PARTS)]
    data = MAGIC + frames[0] + b"".join(frames[number] for number in order)
    kept = [content for content, _ in contents(data)]
    assert kept == PARTS[: len(kept)]


@given(st.binary(max_size=64))
def test_garbage_holds_nothing(data):
    assert not list(contents(data)) or data.startswith(MAGIC)


@pytest.mark.parametrize("cut", [1, 7, 9, 40])
def test_a_torn_tail_is_dropped_and_written_over(written, cut):
    whole = written.read_bytes()
    written.write_bytes(whole[:-cut])
    with Journal(written, HEADER) as journal:
        assert len(journal.records) == 4
        journal.append(record(4))
    assert written.read_bytes() == whole


def test_every_line_is_on_the_disk_before_the_scan_goes_on(tmp_path, monkeypatch):
    synced = []
    monkeypatch.setattr(os, "fsync", lambda handle: synced.append(os.fstat(handle).st_size))
    with Journal(tmp_path / "j", HEADER) as journal:
        for line in range(3):
            journal.append(record(line))
            assert synced[-1] == (tmp_path / "j").stat().st_size
    assert len(synced) == 4


@pytest.mark.parametrize(
    ("other", "named"),
    [
        ({"plan": {"shape": [2, 4]}, "seed": 0}, "plan.shape = [2, 3] where now it is [2, 4]"),
        ({"plan": {"shape": [2, 3]}, "seed": 1}, "seed = 0 where now it is 1"),
        ({"plan": {"shape": [2, 3]}}, "seed = 0 where now it is null"),
    ],
)
def test_other_settings_are_refused_by_name(written, other, named):
    with pytest.raises(ValueError, match=r"Expected .* to belong to these settings") as caught:
        Journal(written, other)
    assert named in str(caught.value)


def test_lines_come_in_order(written):
    with Journal(written, HEADER) as journal, pytest.raises(ValueError, match="Expected line 5"):
        journal.append(record(7))


def test_two_scans_cannot_write_one_journal(written):
    with Journal(written, HEADER), pytest.raises(ValueError, match="another scan writes"):
        Journal(written, HEADER)


@pytest.mark.parametrize("content", [b"", MAGIC, MAGIC + framed(0, b"{}")[:-1], b"CDF\x01" * 9])
def test_what_is_no_journal_is_refused_and_left_alone(tmp_path, content):
    path = tmp_path / "j"
    path.write_bytes(content)
    with pytest.raises(ValueError, match="Expected a journal of a scan"):
        Journal(path, HEADER)
    assert path.read_bytes() == content
