"""The committed figures follow the build, but never lose measured data to a simulation."""

import json

import figures


def draw(folder, stem, *, source=None, drawing="<svg/>"):
    folder.mkdir(parents=True, exist_ok=True)
    numbers = {} if source is None else {"source": source}
    (folder / f"{stem}.json").write_text(json.dumps({"numbers": numbers}))
    (folder / f"{stem}.svg").write_text(drawing)


def test_new_figures_come_and_old_ones_go(tmp_path, capsys):
    draw(tmp_path / "results" / "01", "new", drawing="new")
    draw(tmp_path / "figures", "old")
    (tmp_path / "results" / "01" / "checks.json").write_text("{}")
    figures.main(tmp_path / "results", tmp_path / "figures")
    assert sorted(p.name for p in (tmp_path / "figures").iterdir()) == ["new.json", "new.svg"]
    assert capsys.readouterr().out.split() == ["new.json", "new.svg"]


def test_measured_figures_stay_where_the_data_are_missing(tmp_path):
    draw(tmp_path / "figures", "scan", source="measured", drawing="real")
    draw(tmp_path / "results" / "08", "scan", source="simulated", drawing="made up")
    figures.main(tmp_path / "results", tmp_path / "figures")
    assert (tmp_path / "figures" / "scan.svg").read_text() == "real"
    draw(tmp_path / "results" / "08", "scan", source="measured", drawing="new scan")
    figures.main(tmp_path / "results", tmp_path / "figures")
    assert (tmp_path / "figures" / "scan.svg").read_text() == "new scan"
