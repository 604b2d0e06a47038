"""The floors of the house: imports lead down only, and in no circle."""

import subprocess
import sys
from graphlib import TopologicalSorter

import grimp
import pytest

# from the roof to the ground; rooms of one floor do not see each other
FLOORS = [
    {"cli"},
    {"replication"},
    {"book"},
    {"ranging", "stereo"},
    {"hardware"},
    {"instrument"},
    {"evaluation"},
    {"unwrapping"},
    {"methods"},
    {"network", "surfaces"},
    {"baselines"},
    {"noise", "statistics", "simulation"},
    {"measurement", "pointcloud"},
    {"scenes.rooms"},
    {"scenes"},
    {"bounds", "detector"},
    {"correlation", "modulator"},
    {"waveform", "jones"},
    {"constants", "files", "validation"},
]
HEIGHT = {room: len(FLOORS) - k for k, floor in enumerate(FLOORS) for room in floor}


@pytest.fixture(scope="module")
def imports() -> list[tuple[str, str]]:
    graph = grimp.build_graph("cmtof", exclude_type_checking_imports=True, cache_dir=None)
    # the root loads its names on first use, and gives its version to everybody
    modules = graph.modules - {"cmtof"}
    return [
        (a, b) for a in modules for b in graph.find_modules_directly_imported_by(a) if b in modules
    ]


def room(module: str) -> str:
    parts = module.split(".")[1:]
    return "scenes.rooms" if parts[:2] == ["scenes", "rooms"] else parts[0]


def test_imports_lead_down(imports):
    upward = [
        f"{a} imports {b}"
        for a, b in imports
        if room(a) != room(b) and HEIGHT[room(a)] <= HEIGHT[room(b)]
    ]
    assert not upward


def test_no_module_is_part_of_a_circle(imports):
    above: dict[str, set[str]] = {}
    for a, b in imports:
        above.setdefault(a, set()).add(b)
    TopologicalSorter(above).prepare()  # raises CycleError, which names the circle


@pytest.mark.parametrize(
    ("statement", "heavy"),
    [
        ("import cmtof", "numpy torch xarray matplotlib scipy"),
        ("import cmtof.cli", "numpy torch xarray matplotlib lightning pyvista"),
        ("import cmtof.methods", "torch lightning"),
        ("import cmtof.simulation, cmtof.scenes", "torch matplotlib trimesh pyvista"),
        ("import cmtof.hardware.rig", "serial pyvisa pymodbus thorlabs_apt_protocol torch"),
        ("import cmtof.stereo", "cv2 torch"),
        ("import cmtof.book.views", "pyvista vtkmodules"),
    ],
)
def test_heavy_libraries_are_imported_late(statement, heavy):
    code = f"import sys\n{statement}\nprint(*sorted(set(sys.modules) & set('{heavy}'.split())))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == ""
