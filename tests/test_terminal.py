"""Output in any encoding, into closed streams, and of names that would steer a terminal."""

import os
import subprocess
import sys

import h5py
import numpy as np
from pytest import mark

COMMAND = [sys.executable, "-m", "cmtof.cli"]


def unwrapping(measurement_file, folder, name="m.nc"):
    source = folder / name
    source.write_bytes(measurement_file.read_bytes())
    return [
        *COMMAND,
        "unwrap",
        str(source),
        "-o",
        str(folder / "out.nc"),
        "--method",
        "middle",
    ]


@mark.parametrize("encoding", ["cp1252", "ascii", "utf-8"])
def test_tables_print_in_any_encoding(measurement_file, tmp_path, encoding):
    ended = subprocess.run(
        unwrapping(measurement_file, tmp_path),
        capture_output=True,
        env=os.environ | {"PYTHONIOENCODING": encoding},
    )
    assert ended.returncode == 0, ended.stderr
    assert ("δ<1" if encoding == "utf-8" else "d<1") in ended.stdout.decode(encoding)


@mark.parametrize("closed", ["2>&-", ">&-", ">&- 2>&-"])
def test_closed_streams_change_no_exit_code(measurement_file, tmp_path, closed):
    script = f'exec "$@" {closed}'
    command = ["bash", "-c", script, "bash", *unwrapping(measurement_file, tmp_path)]
    assert subprocess.run(command, stdin=subprocess.DEVNULL).returncode == 0
    assert (tmp_path / "out.nc").is_file()


def test_names_are_printed_as_they_are(succeeds, measurement_file, tmp_path):
    assert "[red]x.nc" in succeeds(
        *unwrapping(measurement_file, tmp_path, "[red]x.nc")[3:]
    )


def test_a_circle_of_links_is_no_defect(fails, tmp_path):
    loop = tmp_path / "loop.nc"
    loop.symlink_to(loop)
    assert "got no file at" in fails("unwrap", loop, "-o", tmp_path / "out.nc")


@mark.parametrize("kind", ["nc", "npz"])
def test_a_file_cannot_steer_the_terminal(succeeds, measurement_file, tmp_path, kind):
    path = tmp_path / f"m.{kind}"
    if kind == "nc":
        path.write_bytes(measurement_file.read_bytes())
        with h5py.File(path, "r+") as file:
            file.attrs["note"] = "\x1b[2Jgone"
    else:
        np.savez(path, **{"a\x1b[2J": np.ones(3)})
    text = succeeds("info", path)
    assert "\x1b" not in text
    assert "\\x1b[2J" in text


def test_info_lists_an_archive_without_reading_it(succeeds, tmp_path, monkeypatch):
    np.savez(tmp_path / "a.npz", depth=np.ones((3, 4)))
    monkeypatch.setattr(np, "load", None)
    assert "depth (3, 4) float64" in succeeds("info", tmp_path / "a.npz")


def test_a_picture_of_no_known_kind_is_refused_at_once(fails, tmp_path):
    assert "a picture named .png" in fails("replicate", "-o", tmp_path / "fig.xyz")
