"""The command line as its users meet it: what it writes, prints, and how it fails."""

import json
import warnings
from importlib.resources import files

import xarray as xr
from pytest import approx, mark, raises

import cmtof
from cmtof.measurement import Measurement


def test_from_frame_to_depth_and_points(succeeds, tmp_path):
    m, out, cloud = (tmp_path / name for name in ("m.nc", "out.nc", "cloud.ply"))
    text = succeeds("simulate", "still_life", "-o", m, "--seed", 5)
    assert "0.755-1.195 m" in text
    text = succeeds("unwrap", m, "-o", out, "--ply", cloud)
    assert "δ<1" in text
    result = xr.load_dataset(out)
    xr.testing.assert_equal(result, cmtof.unwrap(cmtof.open(m)))
    sets = {"wrap_count", "depth", "confidence", "within_90", "within_95"}
    assert set(result.data_vars) == sets | {"component", "component_odds"}
    text = succeeds("info", out)
    assert "int32 wrap_count(y, x)" in text
    assert "largest components" in text
    succeeds("unwrap", m, "-o", out, "--tile", 256, "--range", 0.9, 1)
    tiled = xr.load_dataset(out)
    assert set(tiled.data_vars) == sets
    assert 0.9 - 1e-6 <= tiled.depth.min() < tiled.depth.max() < 1
    assert cmtof.open(m).dataset.attrs["seed"] == 5
    assert sorted(p.name for p in tmp_path.iterdir()) == ["cloud.ply", "m.nc", "out.nc"]


def test_light_of_a_covered_beam_is_taken_away(succeeds, measurement_file, tmp_path):
    m = cmtof.open(measurement_file)
    dim = Measurement(m.dataset.assign(correlation=m.dataset["correlation"] / 9))
    covered, out = tmp_path / "covered.nc", tmp_path / "out.nc"
    dim.save(covered)
    succeeds("unwrap", measurement_file, "-o", out, "--covered", covered)
    left = cmtof.unwrap(m.without_stray_light(dim))
    xr.testing.assert_equal(xr.load_dataset(out), left)
    assert not left.equals(cmtof.unwrap(m))


def test_simulate_options_reach_the_file(succeeds, tmp_path, tilted_wall):
    tilted_wall.save(tmp_path / "wall.npz")
    m = tmp_path / "m.nc"
    options = ("--protocol", "full", "--frequencies", "7.15e9,7.16e9", "--noise", "300")
    succeeds("simulate", tmp_path, "-o", m, *options)  # the folder's first frame
    made = cmtof.open(m)
    assert made.frequencies.tolist() == [7.15e9, 7.16e9]
    assert made.range[1] == approx(14.99, abs=0.01)
    assert made.dataset.attrs["noise_sigma"] == 300
    succeeds("simulate", tmp_path / "wall.npz", "-o", m, "--noise-free")
    assert cmtof.open(m).dataset.attrs["photon_noise"] == 0


SCORES = {
    "delta_lt_1",
    "delta_lt_2",
    "delta_lt_3",
    "delta_ge_3",
    "delta_ge_10",
    "consistent_lt_1",
    "depth_rmse_m",
    "depth_median_error_m",
    "mean_confidence",
    "seconds_per_frame",
}


def test_evaluate_writes_the_contract(succeeds, tmp_path):
    path = tmp_path / "scores.json"
    text = succeeds(
        "evaluate", "still_life", "room", "--method", "crt,beat", "--json", path
    )
    assert "beat" in text
    report = json.loads(path.read_text())
    told = {"protocol", "noise", "seed", "frames", "notes", "coverage", "methods"}
    assert set(report) == told
    assert 0 < report["coverage"] < 1
    for scores in report["methods"].values():
        assert set(scores) == SCORES
        assert scores["delta_lt_3"] + scores["delta_ge_3"] == approx(1)
    assert (
        report["methods"]["beat"]["delta_lt_1"]
        > 3 * report["methods"]["crt"]["delta_lt_1"]
    )


def test_methods_and_info(succeeds, measurement_file):
    listed = {
        entry["name"]: entry for entry in json.loads(succeeds("methods", "--json"))
    }
    assert [name for name, entry in listed.items() if entry["default"]] == ["surfaces"]
    learned = {
        entry["state"] for entry in listed.values() if entry["kind"] == "learned"
    }
    assert learned <= {"trained", "untrained", "no weights"}
    assert "Default: surfaces." in succeeds("methods")
    assert f"cmtof {cmtof.__version__}" in succeeds("info")
    text = succeeds("info", measurement_file)
    assert "float32 correlation(frequency, step, y, x)" in text
    assert ":seed = 3" in text
    assert "depth (240, 320) float32" in succeeds("info", "room")


def test_rooms_are_rendered_and_evaluated_as_a_folder(succeeds, tmp_path):
    rooms = tmp_path / "rooms"
    scores = tmp_path / "scores.json"
    options = (
        "--scenes",
        1,
        "--views",
        2,
        "--size",
        "48x64",
        "--seed",
        2,
        "--workers",
        1,
    )
    text = succeeds("render", *options, "-o", rooms)
    assert "1 rooms, 2 views each; 2 views rendered" in text
    assert "0 views rendered" in succeeds("render", *options, "-o", rooms)
    lost = next(rooms.rglob("frame.0001.color.hdf5"))
    lost.write_bytes(lost.read_bytes()[:100])
    arguments = ("--method", "beat", "--protocol", "full", "--json", scores)
    text = succeeds("evaluate", rooms, *arguments)
    assert len(json.loads(scores.read_text())["frames"]) == 1
    assert "skipped" in text
    assert "frame.0001.color.hdf5" in text


def test_a_frame_that_fails_takes_no_other_with_it(fails, tmp_path, flat_wall):
    (tmp_path / "set").mkdir()
    flat_wall(8, 0.9).save(tmp_path / "set" / "near.npz")
    flat_wall(8, 300.0).save(far := tmp_path / "set" / "far.npz")
    scores = tmp_path / "scores.json"
    told = fails(
        "evaluate", tmp_path / "set", far, "--method", "middle", "--json", scores
    )
    assert "Expected depths between" in told
    report = json.loads(scores.read_text())
    assert report["frames"] == ["near"]
    assert "Expected depths between" in report["notes"]["skipped far"]


# --- bad input: one line, exit code 1, nothing left behind -----------------------------------


def test_inputs_are_never_replaced(fails, tmp_path, measured):
    Measurement(measured.dataset.drop_vars("camera")).save(tmp_path / "m.nc")
    before = (tmp_path / "m.nc").read_bytes()
    m = tmp_path / "m.nc"
    out = tmp_path / "out.nc"
    assert "got m.nc twice" in fails("unwrap", m, "-o", m)
    assert "named *.ply, got m.nc" in fails("unwrap", m, "-o", out, "--ply", m)
    assert "named *.json, got m.nc" in fails("evaluate", "room", "--json", m)
    assert "Expected a camera" in fails(
        "unwrap", m, "-o", out, "--ply", tmp_path / "c.ply"
    )
    assert m.read_bytes() == before
    assert not out.exists()


@mark.parametrize("line", ["frobnicate", "simulate", "unwrap m.nc", "info --no"])
def test_wrong_command_lines_end_with_2(run, line):
    assert run(*line.split())[0] == 2


@mark.parametrize(
    "command",
    ["simulate", "unwrap", "evaluate", "methods", "info", "replicate", "scan"],
)
def test_help_teaches(succeeds, command):
    assert command in succeeds("--help")
    assert "Usage" in succeeds(command, "--help")


@mark.parametrize(
    ("error", "code", "message"),
    [
        (KeyboardInterrupt(), 130, ""),
        (MemoryError(), 1, "Expected enough memory"),
        (
            RuntimeError("out of order"),
            1,
            "RuntimeError: out of order (a defect, please report",
        ),
    ],
)
def test_what_goes_wrong_inside(run, tmp_path, monkeypatch, error, code, message):
    def broken(*_arguments, **_options):
        raise error

    monkeypatch.setattr("cmtof.evaluation.unwrap", broken)
    found, _, err = run(
        "evaluate", "stairs", "--method", "crt", "--json", tmp_path / "s.json"
    )
    assert found == code
    assert message in err
    assert "Traceback" not in err
    assert not list(tmp_path.iterdir())
    if code == 1:
        with raises(type(error)):
            from cmtof.cli import main

            main(["evaluate", "stairs", "--method", "crt", "--debug"])


def test_own_warnings_are_one_line(run, measurement_file, tmp_path, monkeypatch):
    def warned(*_arguments, **_options):
        warnings.warn("fast-scnn is untrained: no gain", stacklevel=1)
        warnings.warn("a library's own", RuntimeWarning, stacklevel=1)
        raise ValueError("Expected an end, got one. Stop.")

    monkeypatch.setattr("cmtof.unwrapping.unwrap", warned)
    _, _, err = run("unwrap", measurement_file, "-o", tmp_path / "out.nc")
    assert err.splitlines() == [
        "cmtof: fast-scnn is untrained: no gain",
        "cmtof: Expected an end, got one. Stop.",
    ]


def test_a_rig_file_is_simulated_with_its_own_twin(succeeds, tmp_path):
    """Without --twin its devices would be opened."""
    rig = tmp_path / "rig.yml"
    default = files("cmtof.hardware").joinpath("rig.yml").read_text()
    rig.write_text(default + "twin: {phase_noise: [0.3, 0.3], grain: 0.2}\n")
    succeeds("scan", rig, "--twin", "--size", 2, "-o", tmp_path / "m.nc", "--quiet")
    settings = json.loads(cmtof.open(tmp_path / "m.nc").dataset.attrs["twin"])
    assert settings["phase_noise"] == [0.3, 0.3]


def test_a_training_that_is_there_is_not_replaced(succeeds, fails, tmp_path):
    stage = "{name: a, crops: 8, crop: 32, batch: 2, noise: [30, 60], rate: [1.0e-3, 1.0e-4]}"
    (recipe := tmp_path / "a.yml").write_text(f"{{rooms: null, stages: [{stage}]}}")
    train = (
        "train",
        recipe,
        "--model",
        "fast-scnn-light",
        "-o",
        tmp_path / "run",
        "--quiet",
    )
    succeeds(*train)
    assert "--resume" in fails(*train)
