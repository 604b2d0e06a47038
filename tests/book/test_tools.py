"""What the build leans on: dependencies of notebooks, accepted figures, notebook pairs, sizes."""

import json

from pytest import approx, mark
from refusals import refused

from cmtof.estimate import SETS
from cmtof.evaluation import Evaluation, read_counts
from cmtof.files import read_document
from cmtof.frame import held_out_frames
from cmtof_book import RESULTS, ROOT, figures, graph, pairs, tables


@mark.parametrize(
    ("module", "reached", "unreached"),
    [
        ("cmtof_book.laboratory", {"objects.py"}, {"stereo.py"}),  # in a function
        ("cmtof_book.comparison", {"measurement.py"}, {"unwrapping.py"}),
        ("cmtof_book.scanned", {"unwrapping.py", "fast-scnn.released.json"}, set()),
        ("cmtof.scenes", {"still_life.npz"}, {"paper.yml"}),
        ("notebooks.01_correlation", {"paper.yml"}, {"02_precision.py"}),
    ],
)
def test_a_module_depends_on_what_it_reaches(module, reached, unreached):
    found = {file.name for file in graph.closure(module)}
    assert found >= reached
    assert not found & unreached


@mark.parametrize("profile", ["ci", "book", "paper"])
def test_profiles_and_contents_name_notebooks(profile):
    sizes = read_document(ROOT / "configs" / f"{profile}.yml")["notebooks"] or {}
    for stem in (*sizes, *graph.notebooks()):
        assert graph.path_of(f"notebooks.{stem}").is_file()


def test_notebook_pairs_agree():
    scripts = (ROOT / "notebooks").glob("[0-9]*.py")
    assert not [s.stem for s in scripts if not pairs.is_up_to_date(s)], "run make pairs"


def test_sets_of_wraps_have_the_half_widths_that_were_calibrated():
    held = json.loads((RESULTS / "coverage.json").read_text())["half-widths"]
    assert held == approx(SETS, abs=0.01)


def draw(folder, stem, *, drawing="<svg/>", **numbers):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{stem}.json").write_text(json.dumps({"numbers": numbers}))
    (folder / f"{stem}.svg").write_text(drawing)


def test_accepted_figures_follow_the_build_and_keep_measured_data(tmp_path):
    results = tmp_path / "results"
    accepted = tmp_path / "figures"
    draw(results / "01", "wall_new")
    draw(results / "08", "wall_scan", source="simulated", drawing="rehearsal")
    checked = {
        "numbers": {"sec8.gain": {"cases": {"": [20, 20, 20]}, "crops": 0}},
        "provenance": {"profile": "ci", "seed": 0, "version": "1"},
    }
    (results / "01" / "paper.json").write_text(json.dumps(checked))
    draw(accepted, "wall_old")
    draw(accepted, "wall_scan", source="measured", drawing="real")
    figures.main(results, accepted)
    kept = {path.name for path in accepted.iterdir()}
    assert kept == {
        "wall_new.json",
        "wall_new.svg",
        "wall_scan.json",
        "wall_scan.svg",
        "scoreboard.json",
    }
    scores = json.loads((accepted / "scoreboard.json").read_text())
    assert scores["numbers"]["sec8.gain"]["verdict"] == "as stated"
    assert (accepted / "wall_scan.svg").read_text() == "real"


def test_tables_count_once_and_are_not_edited(tmp_path, monkeypatch, capsys):
    frames = [frame.middle(48, 64) for frame in held_out_frames()[:2]]
    monkeypatch.setattr(tables, "held_out_frames", lambda: frames)
    monkeypatch.setattr(tables, "RESULTS", tmp_path)
    path = tmp_path / "table3_released_1200_0_35.json"
    assert read_counts(path) == []
    for _ in range(2):  # the second time nothing is left to count
        tables.main(["beat", "middle"], offset=(0.0, 35.0))
    assert len(capsys.readouterr().out.splitlines()) == 2
    again = Evaluation(["beat", "middle"], phase_offset=(0, 0.035)).add_all(frames)
    assert read_counts(path) == again.counts()
    path.write_text(path.read_text().replace(frames[0].name, "another"))
    with refused("edited ones. Count again"):
        read_counts(path)
