"""Output in any encoding, into closed streams, and of names that would steer a terminal."""

import subprocess
import sys
from pathlib import Path
from shutil import copy

import h5py
import numpy as np
from pytest import fixture, mark

NAME = "[red]x.nc"
COMMAND = f"{sys.executable} -m cmtof unwrap {NAME} -o out.nc --method middle".split()


@fixture(autouse=True)
def stored(own_folder, measurement_file):
    """A measurement in the test's folder."""
    copy(measurement_file, NAME)


@mark.parametrize("encoding", ["cp1252", "ascii", "utf-8"])
def test_tables_print_in_any_encoding_and_width_and_names_as_they_are(
    encoding, monkeypatch
):
    monkeypatch.setenv("PYTHONIOENCODING", encoding)
    monkeypatch.setenv("COLUMNS", "20")
    text = subprocess.check_output(COMMAND, encoding=encoding)
    assert ("δ<1" if encoding == "utf-8" else "d<1") in text
    assert NAME in text


@mark.parametrize("closed", ["2>&-", ">&-", ">&- 2>&-"])
def test_closed_streams_change_no_exit_code(closed):
    command = ["bash", "-c", f'exec "$@" {closed}', "bash", *COMMAND]
    subprocess.run(command, stdin=subprocess.DEVNULL, check=True)
    assert Path("out.nc").is_file()


def test_a_circle_of_links_is_no_defect(fails):
    Path("loop.nc").symlink_to("loop.nc")
    assert "got no file at" in fails("unwrap loop.nc -o out.nc")


@mark.parametrize("name", [NAME, "a.npz"])
def test_a_file_cannot_steer_the_terminal(succeeds, name):
    with h5py.File(NAME, "r+") as file:
        file.attrs["note"] = "\x1b[2Jgone"
    np.savez("a.npz", **{"a\x1b[2J": np.ones(3)})
    text = succeeds("info", name)
    assert "\x1b" not in text
    assert "\\x1b[2J" in text


def test_info_lists_an_archive_without_reading_it(succeeds, monkeypatch):
    np.savez("a.npz", depth=np.ones((3, 4)))
    monkeypatch.setattr(np, "load", None)
    assert "depth (3, 4) float64" in succeeds("info a.npz")
