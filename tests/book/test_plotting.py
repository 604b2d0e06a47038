"""Figures and the numbers beside them: same bytes, one style, clear refusals."""

import json
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

from cmtof.book import plotting, provenance


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(provenance.OUTPUT_VARIABLE, str(tmp_path / "out"))
    plotting.begin(profile="ci", seed=3)
    yield tmp_path / "out"
    plt.close("all")
    provenance.begin()


def drawn(name: str = "fig03_precision", format: str = "svg", **changes: object) -> Path:
    fig, ax = plt.subplots()
    ax.plot([0, 1], [0, 2])
    words = {"numbers": {"ratio": 99.8}, "caption": "A line.", "alt": "It rises.", **changes}
    plotting.save(fig, name, format=format, **words)
    return provenance.output_folder() / f"{name}.{format}"


@pytest.mark.parametrize("format", ["svg", "png"])
def test_same_run_writes_same_bytes(format: str):
    first = drawn(format=format).read_bytes()
    assert drawn(format=format).read_bytes() == first


@pytest.mark.parametrize("word", [b"<dc:date>", b"Matplotlib v", b"matplotlib.org"])
def test_svg_names_no_date_and_no_library_version(word: bytes):
    assert word not in drawn().read_bytes()


def test_json_holds_numbers_texts_and_provenance(folder: Path):
    drawn(numbers={"ratio": np.float64(1 / 3), "list": np.array([1, 2])})
    assert json.loads((folder / "fig03_precision.json").read_text()) == {
        "figure": "fig03_precision.svg",
        "caption": "A line.",
        "alt": "It rises.",
        "numbers": {"ratio": 0.3333333333, "list": [1, 2]},
        "provenance": {"profile": "ci", "seed": 3, "version": provenance.current().version},
    }


def test_save_closes_the_figure():
    drawn()
    assert plt.get_fignums() == []


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": "Fig 3"}, "stem like"),
        ({"format": "jpg"}, "'svg' or 'png'"),
        ({"alt": " "}, "alternative text"),
        ({"caption": ""}, "caption"),
        ({"numbers": {"x": float("nan")}}, "finite"),
        ({"numbers": {"x": object()}}, "finite numbers, strings"),
    ],
)
def test_refusals_leave_nothing_behind(folder: Path, changes: dict[str, object], message: str):
    with pytest.raises(ValueError, match=message):
        drawn(**changes)
    assert not folder.exists() or not list(folder.iterdir())


def test_output_folder_is_figures_of_the_checkout(tmp_path, monkeypatch):
    monkeypatch.delenv(provenance.OUTPUT_VARIABLE)
    (tmp_path / "src" / "cmtof").mkdir(parents=True)
    (tmp_path / "pyproject.toml").touch()
    (tmp_path / "notebooks").mkdir()
    monkeypatch.chdir(tmp_path / "notebooks")
    assert provenance.output_folder() == tmp_path / "figures"


@pytest.mark.parametrize("seed", [-1, 1.5, True, "0"])
def test_begin_refuses_what_is_no_seed(seed: object):
    with pytest.raises(ValueError, match="seed"):
        provenance.begin(seed=seed)


def test_lines_take_the_palette_in_order():
    _, ax = plt.subplots()
    colours = [ax.plot([0, 1])[0].get_color() for _ in plotting.PALETTE]
    assert colours == list(plotting.PALETTE.values())


def test_phase_image_is_cyclic_and_marks_missing_pixels():
    _, ax = plt.subplots()
    phase = np.array([[0.0, np.nan], [3.0, 6.0]])
    shown = plotting.phase_image(ax, phase)
    assert shown.get_clim() == (0.0, 2 * np.pi)
    start, end = shown.cmap(0.0), shown.cmap(1.0)
    np.testing.assert_allclose(start, end, atol=0.02)
    assert shown.cmap.get_bad()[0] == pytest.approx(0xB0 / 255)


def test_image_refuses_a_stack():
    _, ax = plt.subplots()
    with pytest.raises(ValueError, match="shape"):
        plotting.image(ax, np.zeros((2, 3, 4)), label="depth (m)")


def test_panels_are_lettered_in_order():
    _, axes = plt.subplots(1, 2)
    axes[0].set_title("near")
    plotting.label_panels(axes)
    assert [ax.get_title(loc="left") for ax in axes] == ["(a) near", "(b)"]
