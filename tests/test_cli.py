"""The command line as its users meet it: what it writes, prints, and how it fails."""

import json
import warnings
from importlib.resources import files
from pathlib import Path
from unittest.mock import Mock

import xarray as xr
from pytest import approx, mark, raises
from refusals import WRONG
from walls import flat_wall

import cmtof
from cmtof.cli import main
from cmtof.measurement import Measurement
from cmtof_book.provenance import read_json

SCORES = Path("scores.json")


def test_from_frame_to_depth_and_points(succeeds):
    assert "0.755-1.195 m" in succeeds("simulate still_life -o m.nc --seed 5")
    assert "δ<1" in succeeds("unwrap m.nc -o out.nc --ply cloud.ply")
    measurement = cmtof.open("m.nc")
    assert measurement.dataset.attrs["seed"] == 5
    result = xr.load_dataset("out.nc")
    xr.testing.assert_equal(result, cmtof.unwrap(measurement))
    sets = {"wrap_count", "depth", "confidence", "within_90", "within_95"}
    assert set(result.data_vars) == sets | {"component", "component_odds"}
    text = succeeds("info out.nc")
    assert "int32 wrap_count(y, x)" in text
    assert "largest components" in text
    succeeds("unwrap m.nc -o out.nc --tile 256 --range 0.9 1")
    tiled = xr.load_dataset("out.nc")
    assert set(tiled.data_vars) == sets
    assert 0.9 - 1e-6 <= tiled.depth.min() < tiled.depth.max() < 1
    assert {*map(str, Path().iterdir())} == {"cloud.ply", "m.nc", "out.nc"}


@mark.parametrize("known", [0, 1])
def test_depth_is_written_where_no_truth_is_known(succeeds, measured, known):
    truth = measured.dataset["depth"].where(measured.dataset["x"] < known)
    Measurement(measured.dataset.assign(depth=truth)).save("m.nc")
    assert ("δ<1" in succeeds("unwrap m.nc -o out.nc --method beat --tile 32")) == known
    assert xr.load_dataset("out.nc").depth.notnull().any()


def test_light_of_a_covered_beam_is_taken_away(succeeds, measured):
    dim = measured.dataset["correlation"] / 9
    covered = Measurement(measured.dataset.assign(correlation=dim))
    measured.save("m.nc")
    covered.save("covered.nc")
    succeeds("unwrap m.nc -o out.nc --covered covered.nc")
    left = cmtof.unwrap(measured.without_stray_light(covered))
    xr.testing.assert_equal(xr.load_dataset("out.nc"), left)
    assert not left.equals(cmtof.unwrap(measured))


def test_simulate_options_reach_the_file(succeeds, tilted_wall):
    tilted_wall.save("wall.npz")
    options = "--protocol full --frequencies 7.15e9,7.16e9 --noise 300"
    succeeds("simulate . -o m.nc", options)  # the folder's first frame
    made = cmtof.open("m.nc")
    assert made.frequencies.tolist() == [7.15e9, 7.16e9]
    assert made.range[1] == approx(14.99, abs=0.01)
    assert made.dataset.attrs["noise_sigma"] == 300
    succeeds("simulate wall.npz -o m.nc --noise-free")
    assert cmtof.open("m.nc").dataset.attrs["photon_noise"] == 0


def test_evaluate_writes_the_contract(succeeds):
    command = "evaluate still_life room --method crt,beat --json scores.json"
    assert "beat" in succeeds(command)
    report = read_json(SCORES)
    told = {"protocol", "noise", "seed", "frames", "notes", "coverage", "methods"}
    assert set(report) == told
    assert 0 < report["coverage"] < 1
    for scores in report["methods"].values():
        assert set(scores) == {
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
        assert scores["delta_lt_3"] + scores["delta_ge_3"] == approx(1)
    crt, beat = (report["methods"][name]["delta_lt_1"] for name in ("crt", "beat"))
    assert beat > 3 * crt


def test_methods_and_info(succeeds, measurement_file):
    listed = json.loads(succeeds("methods --json"))
    assert [one["name"] for one in listed if one["default"]] == ["surfaces"]
    assert {one["state"] for one in listed if one["kind"] == "learned"} <= {
        "trained",
        "untrained",
        "no weights",
    }
    rates = {one["name"]: one["validation"] for one in listed}
    assert rates["crt"] is None
    [text] = succeeds("methods").split("…")  # no word is cut
    assert f"{rates['fast-scnn']:.1%}" in text
    assert f"cmtof {cmtof.__version__}" in succeeds("info")
    text = succeeds("info", measurement_file)
    assert "float32 correlation(frequency, step, y, x)" in text
    assert ":seed = 3" in text
    assert "depth (240, 320) float32" in succeeds("info room")


def test_rooms_are_rendered_and_evaluated_as_a_folder(succeeds, fails):
    command = "render --scenes 1 --views 2 --size 48x64 --seed 2 --workers 1 -o rooms"
    assert "1 rooms, 2 views each; 2 views rendered" in succeeds(command)
    assert "0 views rendered" in succeeds(command)
    lost = next(Path().rglob("frame.0001.color.hdf5"))
    lost.write_bytes(lost.read_bytes()[:100])
    command = "evaluate rooms --method beat --protocol full --json scores.json"
    assert "frame.0001.color.hdf5" in fails(command)
    assert len(read_json(SCORES)["frames"]) == 1


def test_a_frame_that_fails_takes_no_other_with_it(fails):
    Path("set").mkdir()
    flat_wall(8, 0.9).save("set/near.npz")
    flat_wall(8, 300.0).save("set/far.npz")
    command = "evaluate set set/far.npz --method middle --json scores.json"
    assert "Expected depths between" in fails(command)
    report = read_json(SCORES)
    assert report["frames"] == ["near"]
    assert "Expected depths between" in report["notes"]["skipped far"]


def test_a_broken_file_takes_no_other_with_it(run, measured):
    measured.save("whole.nc")
    Path("broken.nc").write_bytes(b"no measurement")
    code, out, err = run("unwrap broken.nc none.nc whole.nc -o found --method crt")
    assert code == 1
    assert "whole.nc" in out
    assert err.startswith("cmtof: left out broken.nc. Expected a whole netCDF4 file")
    assert [one.name for one in Path("found").iterdir()] == ["whole.nc"]


# --- bad input: one line, exit code 1, nothing left behind -----------------------------------


@mark.parametrize("line, words", WRONG["outputs"])
def test_inputs_are_never_replaced(fails, measured, line, words):
    m = Path("m.nc")
    Measurement(measured.dataset.drop_vars("camera")).save(m)
    before = m.read_bytes()
    assert words in fails(line)
    assert m.read_bytes() == before
    assert [*Path().iterdir()] == [m]


@mark.parametrize("line, code, words", WRONG["commands"])
def test_a_wrong_command_says_so_and_leaves_nothing(run, line, code, words):
    found, _, err = run(line)
    assert found == code
    assert words in err
    assert not list(Path().iterdir())


@mark.parametrize(
    "command",
    ["simulate", "unwrap", "evaluate", "methods", "info", "replicate", "scan"],
)
def test_help_teaches(succeeds, command):
    assert command in succeeds("--help")
    assert "Usage" in succeeds(f"{command} --help")


@mark.parametrize(
    "error, code, message",
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
def test_what_goes_wrong_inside(run, monkeypatch, error, code, message):
    monkeypatch.setattr("cmtof.evaluation.unwrap", Mock(side_effect=error))
    found, _, err = run("evaluate stairs --method crt --json s.json")
    assert found == code
    assert message in err
    assert "Traceback" not in err
    assert not list(Path().iterdir())
    if code == 1:
        with raises(type(error)):
            main(["evaluate", "stairs", "--method", "crt", "--debug"])


def test_own_warnings_are_one_line(run, measurement_file, monkeypatch):
    def warned(*_arguments, **_options):
        warnings.warn("fast-scnn is untrained: no gain", stacklevel=1)
        warnings.warn("a library's own", RuntimeWarning, stacklevel=1)
        raise ValueError("Expected an end, got one. Stop.")

    monkeypatch.setattr("cmtof.unwrapping.unwrap", warned)
    *_, err = run("unwrap", measurement_file, "-o out.nc")
    assert err.splitlines() == [
        "cmtof: fast-scnn is untrained: no gain",
        "cmtof: Expected an end, got one. Stop.",
    ]


def test_a_rig_file_is_simulated_with_its_own_twin(succeeds):
    """Without --twin its devices would be opened."""
    default = files("cmtof.hardware").joinpath("rig.yml").read_text()
    Path("rig.yml").write_text(
        default + "twin: {phase_noise: [0.3, 0.3], grain: 0.2}\n"
    )
    succeeds("scan rig.yml --twin --size 2 -o m.nc --quiet")
    attributes = cmtof.open("m.nc").dataset.attrs
    assert json.loads(attributes["twin"])["phase_noise"] == [0.3, 0.3]
    assert attributes["scene"] == "still_life"


def test_a_training_that_is_there_is_not_replaced(succeeds, fails):
    stage = "{name: a, crops: 8, crop: 32, batch: 2, noise: [30, 60], rate: [1.0e-3, 1.0e-4]}"
    Path("a.yml").write_text(f"{{rooms: null, stages: [{stage}]}}")
    command = "train a.yml --model fast-scnn-light -o run --quiet"
    succeeds(command)
    assert "--resume" in fails(command)
