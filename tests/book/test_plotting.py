"""Figures and the numbers beside them: same bytes, one style, clear refusals."""

import json

import matplotlib.pyplot as plt
import numpy as np
from pytest import fixture, mark
from refusals import refused

from cmtof import __version__
from cmtof_book import plotting, provenance
from cmtof_book.compared import closed_form


@fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(provenance.OUTPUT_VARIABLE, str(tmp_path / "out"))
    plotting.begin(profile="ci", seed=3)
    yield tmp_path / "out"
    plt.close("all")
    plotting.begin()


def drawn(name="fig03_precision", format="svg", size=(7, 4), **changes):
    fig, ax = plt.subplots(figsize=size)
    ax.plot([0, 1], [0, 2])
    words = {"numbers": {"ratio": 99.8}, "caption": "A line.", "alt": "It rises."}
    plotting.save(fig, name, format=format, **words | changes)
    return provenance.output_folder() / f"{name}.{format}"


@mark.parametrize("format", ["svg", "png"])
def test_same_run_writes_same_bytes_without_date_or_library_version(format):
    first = drawn(format=format).read_bytes()
    assert drawn(format=format).read_bytes() == first
    for word in (b"<dc:date>", b"Matplotlib v", b"matplotlib.org"):
        assert word not in first


def test_json_holds_numbers_texts_and_provenance(folder):
    right = closed_form(np.array([0.5, 2]))
    drawn(
        numbers={"ratio": np.float64(1 / 3), "list": np.array([1, 2]), "right": right}
    )
    assert json.loads((folder / "fig03_precision.json").read_text()) == {
        "figure": "fig03_precision.svg",
        "caption": "A line.",
        "alt": "It rises.",
        "numbers": {
            "ratio": 0.3333333333,
            "list": [1, 2],
            "right": {"value": [0.5, 2.0], "kind": "closed form"},
        },
        "provenance": {"profile": "ci", "seed": 3, "version": __version__},
    }


@mark.parametrize(
    "changes",
    [
        {"name": "Fig 3"},
        {"numbers": {"x": float("nan")}},
        {"numbers": {"x": object()}},
        {"size": (14, 4)},  # text too small on a page
    ],
)
def test_refusals_leave_nothing_behind(folder, changes):
    with refused("Expected .*, got "):
        drawn(**changes)
    assert not folder.exists() or not list(folder.iterdir())


def test_numbers_are_offered_where_there_are_lines(folder):
    drawn()
    fig, ax = plt.subplots()
    plotting.image(ax, [[1]], label="m")
    plotting.save(fig, "an_image", caption="One.", alt="One.")
    assert [*folder.glob("*.csv")] == [folder / "fig03_precision.csv"]
