"""Chapters of the instrument, on the simulation and on a rig whose wires lead to peers."""

import re
import textwrap
from dataclasses import replace
from importlib.util import find_spec

import numpy as np
from numpy.testing import assert_allclose
from pytest import mark
from wire import DEFAULT, with_device
from xarray import open_dataset

from cmtof_book import ROOT
from cmtof_lab.objects import GRADE_2, gage_blocks
from cmtof_lab.targets import MeshTarget


def found_in(chapter, name, **parameters):
    """What a chapter's cells have found, the first of them with other parameters."""
    seen = {}
    for cell in (ROOT / "notebooks" / f"{chapter}.py").read_text("utf-8").split("# %%"):
        exec(cell.partition("\n")[2], seen)
        if "parameters" in cell.partition("\n")[0]:
            seen |= parameters
        if name in seen:
            return seen[name]
    raise LookupError(name)


def first_blocks():
    """Seed and blocks of the first repeat of chapter 19."""
    lengths = np.random.default_rng([0, 0]).uniform(-GRADE_2, GRADE_2, 2)
    blocks = gage_blocks(5e-4, 1.0, tilt=0.02, errors=tuple(lengths))
    seed = int(np.random.SeedSequence([0, 0]).generate_state(1)[0])
    return {"scene": MeshTarget.from_mesh(blocks), "seed": seed}


PHOTODIODE = {"rig": replace(DEFAULT, flip_mirror="photodiode")}
CHAPTERS = {  # what is measured, sizes, and the rig and what it stands before
    "14_correlation_profiles": (
        "taken",
        {"bursts": 2},
        {"scene": {"kind": "mirror", "distance": 0.6, "reflectance": 6e-6}},
    ),
    "17_precision_sweep": ("day", {"repeats": 1}, PHOTODIODE),
    "19_gage_blocks": (
        "clouds",
        {"repeats": 2, "rows": 4, "columns": 8},
        first_blocks(),
    ),
}


@mark.parametrize("chapter", CHAPTERS)
def test_a_chapter_measures_on_a_rig_what_it_simulates(world_of, chapter):
    name, sizes, before = CHAPTERS[chapter]
    world = world_of(**{"rig": DEFAULT} | before)
    world.models["stage"].scale = 1e9  # the simulated stage has no counts
    world.rig = with_device(world.rig, "stage", counts_per_unit=1e9)
    world.write()
    measured = found_in(chapter, name, **sizes, rig="rig.yml")
    simulated = found_in(chapter, name, **sizes)
    assert world.dark
    if chapter.startswith("19"):  # the other blocks are those of the first repeat, too
        measured, simulated = ({"points": one[0]} for one in (measured, simulated))
    for key, value in simulated.items():
        assert_allclose(measured[key], value, atol=1e-8, err_msg=key)


def test_the_guides_lines_run_on_a_rig(world_of, capsys, monkeypatch):
    world = world_of(**PHOTODIODE)
    world.write()
    asked = []
    monkeypatch.setattr("builtins.input", asked.append)
    seen = {}
    guide = (ROOT / "book" / "hardware.md").read_text("utf-8")
    for block in re.findall(r"(?s)```python\n(.*?)```", guide):
        if "bluesky" not in block or find_spec("bluesky"):
            exec(textwrap.dedent(block), seen)
    assert asked[:2] == ["laser high? Then Enter. ", "laser low? Then Enter. "]
    assert float(asked[-1].partition(" ")[0]) > 1  # mW
    printed = capsys.readouterr().out
    assert "emission: add -0.00 to plate_zero_emission_deg; extinction 100\n" in printed
    assert "resonance at 7.1550 GHz, 20.0 MHz wide\n" in printed
    assert open_dataset("sweep_rf.nc")["volts"].shape == (21, 2)
    assert world.dark
