"""The wheel alone: command line, weights, frames and configurations without the checkout."""

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """Folder that the wheel is unpacked into."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "-o", folder, ROOT]
    subprocess.run(command, check=True, capture_output=True, cwd=folder)
    (wheel,) = folder.glob("*.whl")
    assert wheel.stat().st_size < 25e6
    zipfile.ZipFile(wheel).extractall(folder / "site")
    return folder / "site"


@pytest.fixture
def installed(site, tmp_path):
    """Run a program of the wheel in an empty folder; return what it printed."""

    def runner(*arguments):
        done = subprocess.run(
            [sys.executable, *map(str, arguments)],
            cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": str(site)},
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    return runner


def test_from_a_frame_to_scores(installed, site, tmp_path):
    assert str(site) in installed("-c", "import cmtof; print(cmtof.__file__)")
    cmtof = ("-m", "cmtof.cli")
    assert "still_life" in installed(*cmtof, "info")
    installed(*cmtof, "simulate", "still_life", "-o", "m.nc")
    assert "δ<1" in installed(*cmtof, "unwrap", "m.nc", "-o", "out.nc", "--ply", "out.ply")
    names = "surfaces,beat,fast-scnn"
    installed(*cmtof, "evaluate", "still_life", "--method", names, "--json", "scores.json")
    assert set(json.loads((tmp_path / "scores.json").read_text())["methods"]) == set(
        names.split(",")
    )


@pytest.mark.slow
def test_it_replicates(installed, tmp_path):
    text = installed("-m", "cmtof.cli", "replicate", "-o", "fig10.png")
    assert "PASS" in text
    assert (tmp_path / "fig10.png").is_file()
