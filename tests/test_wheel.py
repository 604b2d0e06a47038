"""The wheel in an environment that holds only what it declares: no checkout, no other package.

The quick form links the declared packages out of this environment; the slow form installs them
with pip into an empty one. Both run the same tests.
"""

import json
import re
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from importlib.metadata import PathDistribution, distribution
from itertools import product
from pathlib import Path
from typing import NamedTuple

from packaging.requirements import Requirement
from pytest import fixture, mark, param, skip
from refusals import WRONG

from cmtof.methods import METHODS
from cmtof_book import ROOT

RECIPE = """
{rooms: null, validation_views: 2, stages: [{name: a, crops: 4, crop: 32, batch: 2,
noise: [30, 60], rate: [2.0e-3, 1.0e-3]}]}
"""
LEARNED = {name for name, method in METHODS.items() if method.kind == "learned"}


class Environment(NamedTuple):
    """An environment and a folder to work in."""

    python: Path
    folder: Path

    def run(self, *arguments, code=0):
        """Run its interpreter in an empty environment; check the exit code."""
        command = [self.python, "-I", *arguments]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True)
        assert done.returncode == code, done.stderr
        return done

    def cmtof(self, line, code=0):
        """Run a command line."""
        return self.run("-m", "cmtof", *line.split(), code=code)


def link(found, site):
    """Link the files of a distribution into a folder of packages."""
    for entry in {file.parts[0] for file in found.files or []} - {"..", "__pycache__"}:
        if not (site / entry).exists():
            (site / entry).symlink_to(str(found.locate_file(entry)))


def share_compiled(site):
    """Let unpacked sources use what Numba compiled for their equals in the checkout."""
    for path in site.glob("cmtof*/**/*.py"):
        own = ROOT / "src" / path.relative_to(site)
        if own.is_file() and path.read_bytes() == own.read_bytes():
            shutil.copystat(own, path)
            cache = own.with_name("__pycache__")
            cache.mkdir(exist_ok=True)
            if not (link := path.with_name("__pycache__")).exists():
                link.symlink_to(cache)


def linked(folder, wheel, extra):
    """Make an environment of the wheel with links to what it declares, and what that declares."""
    venv.create(folder)
    site = Path(sysconfig.get_path("purelib", "venv", {"base": str(folder)}))
    zipfile.ZipFile(wheel).extractall(site)
    share_compiled(site)
    (about,) = site.glob("cmtof-*.dist-info")
    wanted = [("cmtof", extra)]
    for name, with_extra in wanted:  # which grows
        found = PathDistribution(about) if name == "cmtof" else distribution(name)
        link(found, site)
        for one in map(Requirement, found.requires or []):
            if not one.marker or one.marker.evaluate({"extra": with_extra}):
                pairs = product([one.name], ["", *one.extras])
                wanted += [pair for pair in pairs if pair not in wanted]


def installed(folder, wheel, extra):
    """Make an empty environment and install the wheel into it; skip where no registry answers."""
    venv.create(folder, with_pip=True)
    pip = [folder / "bin/python", "-m", "pip", "--disable-pip-version-check"]
    probe = [*pip, "download", "-q", "--no-deps", "-d", folder / "probe", "rich"]
    answer = subprocess.run(probe, capture_output=True, text=True)
    if answer.returncode:
        skip(f"pip reaches no registry: {answer.stderr.strip()[-200:]}")
    what = f"cmtof[{extra}] @ {wheel.as_uri()}" if extra else wheel
    subprocess.run([*pip, "install", "-q", what], check=True, capture_output=True)


@fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "-o", folder]
    subprocess.run([*build, ROOT], check=True, capture_output=True, cwd=folder)
    (built,) = folder.glob("*.whl")
    assert built.stat().st_size < 25e6
    return built


@fixture(scope="module")
def inputs(tmp_path_factory, tilted_wall, measured):
    """Folder with a frame, a measurement, a rig that is not there, a recipe, and a chapter."""
    folder = tmp_path_factory.mktemp("inputs")
    tilted_wall.save(folder / "wall.npz")
    measured.save(folder / "wall.nc")
    rig = (ROOT / "src/cmtof/hardware/rig.yml").read_text("utf-8")
    (folder / "rig.yml").write_text(rig.replace("/dev/ttyUSB0", "/dev/none"), "utf-8")
    (folder / "own.yml").write_text(RECIPE)
    shutil.copy(ROOT / "notebooks/16_stereo.ipynb", folder)
    return folder


@fixture(
    scope="module",
    params=[linked, param(installed, marks=mark.slow)],
    ids=["linked", "installed"],
)
def environment(request, wheel, inputs, tmp_path_factory):
    """Make an environment of the wheel with one extra, or with none."""
    root = tmp_path_factory.mktemp("environment")

    def make(extra=""):
        folder = root / (extra or "bare")
        request.param(folder, wheel, extra)
        shutil.copytree(inputs, folder / "work", dirs_exist_ok=True)
        return Environment(folder / "bin/python", folder / "work")

    yield make
    shutil.rmtree(root)


@fixture(scope="module")
def bare(environment):
    return environment()


def test_bare_from_a_frame_to_scores(bare):
    assert (
        "site-packages" in bare.run("-c", "import cmtof; print(cmtof.__file__)").stdout
    )
    assert "torch is not installed" in bare.cmtof("info").stdout
    listed = json.loads(bare.cmtof("methods --json").stdout)
    assert {row["name"] for row in listed} == {*METHODS}
    bare.cmtof("simulate wall.npz -o m.nc")
    assert "δ<1" in bare.cmtof("unwrap m.nc -o out.nc --ply out.ply").stdout


def test_bare_evaluate_leaves_out_what_needs_an_extra(bare):
    (line,) = bare.cmtof("evaluate wall.npz --json all.json").stderr.splitlines()
    assert line.endswith(
        "onnxruntime, got none. Install it: pip install 'cmtof[networks]'."
    )
    ran = json.loads((bare.folder / "all.json").read_text())["methods"].keys()
    kinds = ("classical", "trivial")
    assert ran == {name for name, one in METHODS.items() if one.kind in kinds}


def test_bare_every_method_runs_or_names_its_extra(bare):
    command = f"evaluate wall.npz --method {','.join(METHODS)} --json named.json"
    line = bare.cmtof(command, code=1).stderr.splitlines()[-1]
    assert {*re.findall("[a-z-]+", re.findall(r":([^.]*)", line)[0])} >= LEARNED
    ran = json.loads((bare.folder / "named.json").read_text())["methods"].keys()
    assert ran == METHODS.keys() - LEARNED


def test_bare_the_simulated_instrument_scans(bare):
    bare.cmtof("scan --twin --size 8 -o scan.nc")
    bare.cmtof("info scan.nc")


@mark.parametrize("extra, words", WRONG["extras"].items())
def test_bare_a_command_names_the_extra_that_it_needs(bare, extra, words):
    (line,) = bare.cmtof(words, code=1).stderr.splitlines()
    assert f"pip install 'cmtof[{extra}]'" in line


def test_bare_python_of_the_readme_runs(bare):
    blocks = re.findall(
        r"(?s)```python\n(.*?)```", (ROOT / "README.md").read_text("utf-8")
    )
    assert blocks
    for block in blocks:
        bare.run("-c", block)


@mark.slow
def test_bare_replicates_without_a_figure(bare):
    text = bare.cmtof("replicate -o fig10.png").stdout
    assert "PASS" in text
    assert "needs cmtof[plot]" in text


COMMANDS = {  # before the program of an extra
    "networks": [
        "unwrap wall.nc -o wall_depth.nc --method fast-scnn",
        "evaluate wall.npz --method all --json all.json",
    ],
    "rooms": ["render --scenes 1 --views 1 --size 32x32 --workers 1 -o rooms"],
    "train": [
        "evaluate wall.npz --method fast-scnn",
        "train own.yml --accelerator cpu -o run",
    ],
}


@mark.parametrize(
    "extra",
    [
        "book",
        "hardware",
        "lab",
        "networks",
        "plot",
        "rooms",
        "view",
        param("notebooks", marks=mark.slow),
        param("train", marks=mark.slow),
    ],
)
def test_an_extra_alone_is_enough_for_what_it_promises(environment, extra):
    alone = environment(extra)
    for command in COMMANDS.get(extra, []):
        alone.cmtof(command)
    alone.run(ROOT / f"tests/alone/{extra}.py")


@mark.slow
def test_with_plot_alone_it_replicates_and_draws(environment):
    alone = environment("plot")
    assert "Fig. 10, drawn" in alone.cmtof("replicate -o fig10.png").stdout
    assert (alone.folder / "fig10.png").is_file()
