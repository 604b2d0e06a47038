"""The floors of the house: imports lead down only, and in no circle."""

import re
import subprocess
import sys
from copy import deepcopy
from graphlib import TopologicalSorter
from itertools import pairwise
from pathlib import Path

import grimp
from pytest import fixture, mark
from refusals import HOUSE

from cmtof_book import ROOT

# Packages from the roof to the ground: none knows a higher one.
PACKAGES = [
    "cmtof_book",
    grimp.Layer("cmtof_rooms", "cmtof_lab", independent=False),
    "cmtof",
]

FLOORS = [{*floor} for floor in HOUSE["floors"]]


@fixture(scope="module")
def graph():
    """Imports of all packages, but of the root: it loads its names on first use."""
    found = grimp.build_graph(
        "cmtof_book",
        "cmtof_rooms",
        "cmtof_lab",
        "cmtof",
        exclude_type_checking_imports=True,
        cache_dir=None,
    )
    for module in found.find_modules_that_directly_import("cmtof"):
        found.remove_import(importer=module, imported="cmtof")
    return found


def test_imports_lead_down(graph):
    rooms = {name.split(".")[1] for name in graph.find_children("cmtof")}
    assert rooms == set().union(*FLOORS)
    assert not graph.find_illegal_dependencies_for_layers(FLOORS, containers={"cmtof"})


def test_no_package_knows_a_higher_one(graph):
    """But the command line, which asks a companion within the function that needs it."""
    below = deepcopy(graph)
    for module in below.find_descendants("cmtof.cli"):
        below.remove_module(module)
    assert not below.find_illegal_dependencies_for_layers(PACKAGES)


def test_no_module_is_part_of_a_circle(graph):
    above = {
        module: graph.find_modules_directly_imported_by(module)
        for module in graph.modules
    }
    TopologicalSorter(above).prepare()  # raises CycleError, which names the circle


def test_no_two_classes_have_one_name():
    modules = (ROOT / "src").rglob("*.py")
    names = re.findall(r"(?m)^class (\w+)", "".join(map(Path.read_text, modules)))
    assert sorted(names) == sorted(set(names))


def walks():
    """Modules of each walk through the code that CONTRIBUTING describes, by its title."""
    text = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
    section = text.split("## A newcomer's walk")[1].split("\n## ")[0]
    flow = r"(?s)\*\*(.+?)\*\*.*?:(.*?)(?=\n\n|\Z)"
    return {
        title: [*map(module_of, re.findall(r"`([\w/]+)\.py`", files))]
        for title, files in re.findall(flow, section)
    }


def module_of(name):
    within = ROOT / "src" / "cmtof" / f"{name}.py"
    return ("cmtof." if within.is_file() else "") + name.replace("/", ".")


@mark.parametrize("modules", walks().values(), ids=walks())
def test_each_step_of_a_walk_is_imported_by_one_before_it(modules, graph):
    known = set()
    for before, module in pairwise(modules):
        known |= graph.find_modules_directly_imported_by(before)
        # a package's own `__init__` hands its modules on
        assert {module, module.removesuffix(".method")} & known, module


@mark.parametrize("modules, heavy", HOUSE["late"].items())
def test_heavy_libraries_are_imported_late(modules, heavy):
    code = f"import sys, {modules}; print(*sys.modules.keys() & '{heavy}'.split())"
    assert not subprocess.check_output([sys.executable, "-c", code]).strip()
