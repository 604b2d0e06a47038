"""The floors of the house: imports lead down only, and in no circle."""

import re
import subprocess
import sys
from graphlib import TopologicalSorter

import grimp
from pytest import fixture, mark

from cmtof_book import ROOT

PACKAGES = {"cmtof": 0, "cmtof_rooms": 1, "cmtof_lab": 1, "cmtof_book": 2}
"""Packages, and how high each stands: none knows a higher one."""

# floors of `cmtof`, from the roof to the ground; rooms of one floor do not see each other
FLOORS = [
    {"cli"},
    {"hardware"},
    {"evaluation"},
    {"unwrapping"},
    {"methods"},
    {"hybrid"},
    {"network", "surfaces"},
    {"classical"},
    {"noise", "statistics"},
    {"estimate"},
    {"simulation"},
    {"measurement", "pointcloud"},
    {"storage"},
    {"contract"},
    {"scenes"},
    {"captures", "hypersim", "images"},
    {"frame"},
    {"bounds", "detector", "hardness"},
    {"correlation", "modulator"},
    {"waveform", "jones"},
    {"air"},
    {"compiled", "constants", "files", "terminal", "validation"},
    {"types"},
]
HEIGHT = {room: len(FLOORS) - k for k, floor in enumerate(FLOORS) for room in floor}
LATE = "cmtof.cli."
"""Modules that may ask a companion, within the function that needs it."""
STILL_UPWARD = {
    ("cmtof.network.data", "cmtof_rooms.rendering"),
}
"""Arrows against the plan that are still to be turned round."""


@fixture(scope="module")
def imports():
    graph = grimp.build_graph(
        *PACKAGES, exclude_type_checking_imports=True, cache_dir=None
    )
    # the root loads its names on first use, and gives its version to everybody
    modules = graph.modules - {"cmtof"}
    return [
        (a, b)
        for a in modules
        for b in graph.find_modules_directly_imported_by(a)
        if b in modules
    ]


def height(module):
    return PACKAGES[module.partition(".")[0]]


def room(module):
    return module.split(".")[1]


def test_imports_lead_down(imports):
    upward = [
        f"{a} imports {b}"
        for a, b in imports
        if height(a) == height(b) == 0
        and room(a) != room(b)
        and HEIGHT[room(a)] <= HEIGHT[room(b)]
    ]
    assert not upward


def test_no_package_knows_a_higher_one(imports):
    known = {(a, b) for a, b in imports if not a.startswith(LATE)}
    assert {(a, b) for a, b in known if height(a) < height(b)} == STILL_UPWARD


def test_no_module_is_part_of_a_circle(imports):
    above = {}
    for a, b in imports:
        above.setdefault(a, set()).add(b)
    order = TopologicalSorter(
        above
    ).static_order()  # raises CycleError, which names the circle
    assert set(order) >= above.keys()


def walks():
    """Modules of each walk through the code that CONTRIBUTING describes."""
    text = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
    section = text.split("## A newcomer's walk")[1].split("\n## ")[0]
    flows = re.findall(r"\*\*(.+?)\*\*.*?:(.*?)(?=\n\n|\Z)", section, re.DOTALL)
    return {
        title: [module_of(name) for name in re.findall(r"`([\w/]+)\.py`", files)]
        for title, files in flows
    }


def module_of(name):
    within = ROOT / "src" / "cmtof" / f"{name}.py"
    return ("cmtof." if within.is_file() else "") + name.replace("/", ".")


@mark.parametrize("title", walks())
def test_each_step_of_a_walk_is_imported_by_one_before_it(title, imports):
    modules = walks()[title]
    # a package's own `__init__` hands its modules on
    known = set(imports) | {(a, f"{b}.method") for a, b in imports}
    for number, module in enumerate(modules[1:], start=1):
        assert any((before, module) in known for before in modules[:number]), module


@mark.parametrize(
    ("statement", "heavy"),
    [
        ("import cmtof", "numpy torch xarray matplotlib scipy"),
        ("import cmtof.cli", "numpy torch xarray matplotlib lightning pyvista"),
        ("import cmtof.methods", "torch lightning"),
        ("import cmtof.simulation, cmtof.scenes", "torch matplotlib trimesh pyvista"),
        (
            "import cmtof.hardware.rig",
            "serial pyvisa pymodbus thorlabs_apt_protocol torch",
        ),
        ("import cmtof_lab.stereo", "cv2 torch"),
        ("import cmtof_book.views", "pyvista vtkmodules"),
    ],
)
def test_heavy_libraries_are_imported_late(statement, heavy):
    code = f"import sys\n{statement}\nprint(*sorted(set(sys.modules) & set('{heavy}'.split())))"
    found = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert found.stdout.strip() == ""
