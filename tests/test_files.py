"""Files are whole or not there, and only regular files are replaced."""

import os
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from pytest import mark, raises
from refusals import WRONG, refused

from cmtof.files import atomic_output, check_output, exclusive_lock, read_document

pytestmark = mark.usefixtures("own_folder")


def test_a_file_appears_whole_or_not_at_all():
    target = Path("a.txt")
    target.write_text("old")
    with raises(RuntimeError), atomic_output(target) as part:
        part.write_text("half")
        raise RuntimeError
    assert target.read_text() == "old"
    with atomic_output(target) as part:
        assert part.match(f".a.part-{os.getpid()}-*.txt")
        part.write_text("new")
    assert target.read_text() == "new"
    assert [*Path().iterdir()] == [target]


def test_a_link_and_who_may_read_its_file_stay():
    link = Path("link.txt")
    real = Path("real.txt")
    real.touch(0o600)
    link.symlink_to(real)
    with atomic_output(link) as part:
        part.write_text("new")
        assert part.stat().st_mode & 0o777 == 0o600
    assert link.is_symlink()
    assert real.read_text() == "new"
    assert real.stat().st_mode & 0o777 == 0o600


def test_threads_that_write_one_file_lose_none():
    def write(number):
        with atomic_output("a.txt") as part:
            part.write_text(str(number))
        return number

    with ThreadPoolExecutor(8) as threads:
        assert sorted(threads.map(write, range(160))) == list(range(160))
    assert [*Path().iterdir()] == [Path("a.txt")]


@mark.parametrize(
    "process, age, left",
    [(2**22, 900, False), (2**22, 0, True), (1, 900, True)],
)
def test_what_a_killed_process_left_is_removed(process, age, left):
    lost = Path(f".a.part-{process}-0.txt")
    lost.touch()
    os.utime(lost, (time.time() - age,) * 2)
    with atomic_output("b" * 251 + ".txt") as part:
        part.touch()
    assert lost.exists() == left


def test_a_write_protected_file_is_refused_at_once():
    Path().chmod(0o777)
    Path("a.txt").touch(0o444)
    before = os.geteuid()
    try:
        os.seteuid(before or 65534)  # for root may write all
        with refused("a.txt .Permission denied", PermissionError):
            check_output("a.txt")
    finally:
        os.seteuid(before)


def test_an_error_under_a_lock_stays_what_it_is():
    with raises(BlockingIOError, match="full"), exclusive_lock(Path()):
        raise BlockingIOError("a pipe is full")


@mark.parametrize("path, message", WRONG["paths"])
def test_what_cannot_be_written_is_refused_at_once(path, message):
    os.mkfifo("pipe")
    Path("loop").symlink_to("loop")
    with refused(message, OSError):
        check_output(path)
    with refused(message, OSError), atomic_output(path):
        pytest.fail("entered")


@mark.parametrize(
    "text, message",
    [
        ("[" * 20_000, "a depth above 20"),
        ("a: " + "x" * 2**20, "at most 1048576 bytes"),
        ("a: " + "9" * 5000, "Expected YAML"),
        *WRONG["documents"],
    ],
    ids=lambda text: text[-20:],
)
def test_hostile_documents_are_refused(text, message):
    Path("a.yml").write_text(text, "latin-1")
    with refused(message):
        read_document("a.yml")
