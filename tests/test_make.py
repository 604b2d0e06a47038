"""The Makefile: what is wrong with a setting is said in one line, and no setting is run."""

import subprocess
import sys
from pathlib import Path

from pytest import mark
from refusals import WRONG

from cmtof_book import ROOT


@mark.parametrize("arguments, message", WRONG["make"])
def test_settings_are_checked_and_never_run(tmp_path, arguments, message):
    mark = tmp_path / "mark"
    words = [word.replace("MARK", str(mark)) for word in arguments]
    ended = subprocess.run(
        ["make", "-o", "setup", *words], cwd=ROOT, capture_output=True, text=True
    )
    assert ended.returncode == 2
    assert message in ended.stderr
    assert len(ended.stderr.splitlines()) <= 2
    assert not mark.exists()


@mark.parametrize("lost", ["", "html/index.html", "results/07_captures"])
def test_what_is_lost_of_a_book_is_made_again(own_folder, lost):
    built = ["stage/a", "html/index.html"]
    for path in ROOT.glob("notebooks/*.py"):
        built = [f"results/{path.stem}/a", f"notebooks/{path.stem}.ipynb", *built]
    for name in built:
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).touch()
    if lost:
        Path(lost).rename("lost")
    line = f"-m snakemake -n --nolock --config profile=ci build={Path.cwd()}"
    said = subprocess.check_output([sys.executable, *line.split()], cwd=ROOT)
    assert (b"rule book:" in said) == bool(lost)
