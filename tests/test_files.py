"""Files are whole or not there, and only regular files are replaced."""

import os

import pytest

from cmtof.files import check_output, read_document, written_whole


def test_a_file_appears_whole_or_not_at_all(tmp_path):
    target = tmp_path / "a.txt"
    target.write_text("old")
    with pytest.raises(RuntimeError), written_whole(target) as part:
        part.write_text("half")
        raise RuntimeError
    assert target.read_text() == "old"
    with written_whole(target) as part:
        assert part.suffix == ".txt"
        part.write_text("new")
    assert target.read_text() == "new"
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_a_link_keeps_its_place(tmp_path):
    (tmp_path / "real.txt").write_text("old")
    (tmp_path / "link.txt").symlink_to(tmp_path / "real.txt")
    with written_whole(tmp_path / "link.txt") as part:
        part.write_text("new")
    assert (tmp_path / "link.txt").is_symlink()
    assert (tmp_path / "real.txt").read_text() == "new"


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda p: p / "none" / "a.txt", "Expected an existing folder"),
        (lambda p: p, "got the folder"),
        (lambda p: os.mkfifo(p / "pipe") or p / "pipe", "got a device or pipe"),
        (lambda p: "/proc/a.txt", "can be written to"),  # not even by root
    ],
)
def test_what_cannot_be_written_is_refused_at_once(tmp_path, make, message):
    path = make(tmp_path)
    with pytest.raises(OSError, match=message):
        check_output(path)
    with pytest.raises(OSError, match=message), written_whole(path):
        pytest.fail("entered")


def test_hostile_documents_are_refused(tmp_path):
    for text, message in (
        (b"[" * 20_000, "a depth above 20"),
        (b"a: &a [1]\nb: *a\n", "aliases or"),
        (b"a: " + b"9" * 5000, "Expected YAML"),
        (b"\xff\xfe\x00", "Expected YAML|names and values"),
        (b"1: 2", "names and values"),
        (b"- a\n- b\n", "names and values"),
        (b"a: " + b"x" * 2**20, "at most 1048576 bytes"),
        (b"!!python/object/apply:os.system ['true']", "Expected YAML"),
    ):
        (tmp_path / "a.yml").write_bytes(text)
        with pytest.raises(ValueError, match=message):
            read_document(tmp_path / "a.yml")
