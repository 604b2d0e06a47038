"""Wrong physics is found: each mistake in the source fails the test that names it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from pytest import fixture, mark
from refusals import HOUSE

from cmtof_book import ROOT

MISTAKES = HOUSE["mistakes"]


def run_with(source, line):
    """Run a program with the packages of a folder."""
    return subprocess.run(
        [sys.executable, *line.split()],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": source, "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
    )


def failures(test, source):
    """What pytest says of a test with the packages of a folder."""
    return run_with(source, f"-m pytest -p no:cacheprovider -rf {test}").stdout


@fixture
def source(tmp_path):
    """A copy of the packages."""
    left_out = shutil.ignore_patterns("weights", "test")
    return Path(shutil.copytree(ROOT / "src", tmp_path / "src", ignore=left_out))


def make(source, module, right, wrong, test):
    """Write the wrong line of a module in place of the right one; return the test that fails."""
    path = source / "cmtof" / module
    text = path.read_text("utf-8")
    assert text.count(right) == 1
    path.write_text(text.replace(right, wrong), "utf-8")
    return f"tests/{test}"


@mark.slow
@mark.parametrize("name", MISTAKES)
def test_a_mistake_fails_the_test_that_names_it(name, source):
    assert "FAILED" not in failures(f"tests/{MISTAKES[name]['test']}", source)
    test = make(source, **MISTAKES[name])
    assert f"FAILED {test}" in failures(test, source)


@mark.slow
@mark.parametrize("name", ["sign of psi", "Poisson without gain"])
def test_a_mistake_in_the_chain_fails_replicate(name, source, tmp_path):
    make(source, **MISTAKES[name])
    done = run_with(source, f"-m cmtof replicate -o {tmp_path}/fig10.png")
    assert done.returncode == 1
    assert "FAIL  " in done.stdout
