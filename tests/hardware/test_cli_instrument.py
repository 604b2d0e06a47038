"""`cmtof scan` and `cmtof twin` as a user meets them."""

import pytest

from cmtof.cli import app


def test_help_lists_the_instrument_last(run):
    code, out, _ = run("--help")
    assert code == 0
    assert out.index("replicate") < out.index("scan") < out.index("twin")


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ([], "either a RIG file or --twin, got neither"),
        (["rig.yml", "--twin"], "got both"),
        (["rig.yml", "--seed", "3"], "--seed with --twin only"),
        (["rig.yml", "--scene", "still_life"], "--scene with --twin only"),
    ],
)
def test_rig_or_twin_and_the_seed_is_the_twins(fails, tmp_path, arguments, named):
    assert named in fails("scan", "-o", tmp_path / "m.nc", *arguments)


def test_a_dry_run_prints_the_plan_and_touches_nothing(run, tmp_path, monkeypatch):
    from cmtof.hardware.rig import Rig

    monkeypatch.setattr(Rig, "open", lambda self: pytest.fail("opened"))
    code, out, err = run("scan", "--twin", "--size", "8", "-o", tmp_path / "m.nc", "--dry-run")
    assert (code, err) == (0, "")
    assert "8 x 8 image" in out
    assert "s on the instrument" in out
    assert not list(tmp_path.iterdir())


def test_a_dry_run_of_points(run, tmp_path):
    table = tmp_path / "points.csv"
    table.write_text("x_deg,y_deg\n1,2\n3,4\n")
    code, out, _ = run("scan", "--twin", "--points", table, "-o", tmp_path / "m.nc", "--dry-run")
    assert code == 0
    assert "2 directions" in out


def test_a_missing_rig_and_bad_points_are_one_line(fails, tmp_path):
    assert "nowhere.yml" in fails("scan", tmp_path / "nowhere.yml", "-o", tmp_path / "m.nc")
    (tmp_path / "p.csv").write_text("a\n")
    fails("scan", "--twin", "--points", tmp_path / "p.csv", "-o", tmp_path / "m.nc")


def test_an_output_of_another_kind_is_refused_before_anything_starts(fails, tmp_path):
    assert "*.nc" in fails("scan", "--twin", "--size", "2", "-o", tmp_path / "m.txt")


def test_commands_are_registered_in_the_order_of_the_help():
    names = [getattr(command.callback, "__name__", "") for command in app.registered_commands]
    assert names[-2:] == ["scan", "twin"]
