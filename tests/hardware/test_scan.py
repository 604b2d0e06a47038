"""The scan on instruments without wires: what it asks for, in which order, and what it makes."""

import json
from dataclasses import replace

import numpy as np
import pytest
from fake_instruments import GAIN, OFFSETS, FakeRig, settings

from cmtof.correlation import centred, phase_from_depth
from cmtof.hardware import bench as bench_module
from cmtof.hardware.dry_run import description, duration
from cmtof.hardware.errors import BadReply, Unsafe
from cmtof.hardware.journal import journal_path, read_journal
from cmtof.hardware.plan import point_list
from cmtof.hardware.rig_settings import ScanSettings
from cmtof.hardware.scan import planned, scan
from cmtof.instrument.optics import group_index


def make(tmp_path, rig=None, *, size=4, **options):
    rig = rig or FakeRig()
    plan = options.pop("plan", None) or planned(rig.settings, size=size)
    return rig, scan(rig, plan, tmp_path / "m.nc", **options)


def expected_range(rig, measurement):
    """Optical range of each pixel of the fake's tilted wall, m."""
    x, y = np.moveaxis(measurement.dataset["angle"].to_numpy(), -1, 0)
    return group_index() * (rig.depth + 0.01 * x + 0.02 * y)


def test_phases_are_those_of_the_optical_range_in_both_modes(tmp_path):
    rig, measurement = make(tmp_path)
    assert measurement.frequencies.tolist() == [7.15e9, 14.32e9]
    z = expected_range(rig, measurement)
    for seen, frequency in zip(measurement.phase, measurement.frequencies, strict=True):
        error = centred(seen - phase_from_depth(z, frequency))
        assert np.abs(error).max() < 2e-4  # the converter's steps
    np.testing.assert_allclose(
        measurement.dataset.attrs["phase_offset"], list(OFFSETS.values()), atol=2e-4
    )


def test_without_a_stage_the_target_stands_where_it_is(tmp_path):
    rig = FakeRig(stage_missing=True)
    devices = {k: v for k, v in rig.settings.devices.items() if k != "stage"}
    rig.settings = replace(rig.settings, devices=devices)
    plan = planned(rig.settings, size=2)
    assert plan.sweep == (0.0,)
    rig, measurement = make(tmp_path, rig, plan=plan)
    offset = measurement.dataset.attrs["phase_offset"]
    # the fake's stage stays at 0, which is 25 mm before its zero
    low = OFFSETS["single"] + phase_from_depth(-0.025 * group_index(), 7.15e9)
    assert abs(centred(offset[0] - low)) < 2e-4


def test_counts_become_volts_at_the_power_of_the_first_line(tmp_path):
    rig, measurement = make(tmp_path)
    amplitude = measurement.amplitude
    # the fake's laser wanders by 20 %, its modulation is bright / 2 at the first line's power
    power = measurement.dataset["laser_power"].to_numpy()
    assert np.ptp(power[0]) > 1e-4
    lines = measurement.dataset["raw_counts"].to_numpy()
    assert lines.min() > 0
    first = power[:, :1, :1] / 3e-3
    # within a line the laser wanders on; its power is read at the line's end
    np.testing.assert_allclose(amplitude / first, rig.bright / 2, rtol=0.08)


def test_dark_is_the_mean_behind_the_shutter(tmp_path):
    _, measurement = make(tmp_path)
    dark = GAIN.volts_from_counts(measurement.dataset["dark"].to_numpy())
    np.testing.assert_allclose(dark, 0.05, atol=2e-4)


def test_the_file_says_all_and_no_time_or_address(tmp_path):
    _, measurement = make(tmp_path, seed=5)
    attributes = measurement.dataset.attrs
    held = json.loads(attributes["settings"])
    assert held["detection"]["phases"] == 16
    assert held["devices"]["daq"] == {
        "driver": "labjack-t7", "stage": "", "serial_number": "", "counts_per_unit": 0.0,
    }  # fmt: skip
    assert "fake:" not in str(attributes)
    assert json.loads(attributes["instruments"])["daq"] == "T7 1"
    assert (attributes["seed"], attributes["complete"]) == (5, 1)
    assert attributes["source"] == "simulated instrument"
    assert measurement.range == (0.0, pytest.approx(7.4948, abs=1e-4))
    assert measurement.dataset["time"].attrs["units"] == "s"
    assert measurement.dataset["correlation"].attrs["units"] == "V"
    assert np.unique(measurement.dataset["time"]).size == 2 * 16
    rig = FakeRig()
    assert "seed" not in scan(rig, planned(rig.settings, size=1), tmp_path / "n.nc").dataset.attrs


def test_plates_turn_in_the_dark_with_rf_off_and_light_comes_last(tmp_path):
    rig, _ = make(tmp_path)  # the fake asserts it at each move of a plate
    plates = [call for call in rig.calls if call[0] == "plate_emission" and call[1] == "move"]
    assert np.rad2deg([angle for *_, angle in plates]) == pytest.approx([11.25, 22.5])
    lights = [call for call in rig.calls if call[0] in ("laser", "interlock", "rf_emission")]
    assert lights[0] == ("interlock", "shutter", False)
    assert lights.index(("interlock", "laser", True)) < lights.index(("interlock", "shutter", True))
    assert rig.calls[-3:] == [
        ("interlock", "shutter", False), ("galvo", "park"), ("rig", "closed"),
    ]  # fmt: skip


def test_the_target_is_always_approached_from_below_in_short_moves(tmp_path):
    rig, _ = make(tmp_path, size=1)
    moves = [call[2] for call in rig.calls if call[:2] == ("stage", "move")]
    steps = np.diff([0.0, *moves])
    seconds = np.abs(steps) / bench_module.STAGE_SPEED
    assert seconds.max() < rig.settings.drive.dead_man / 2
    plan = planned(rig.settings, size=1)
    for position in plan.sweep:
        arrivals = [n for n, at in enumerate(moves) if abs(at - 0.025 - position) < 1e-12]
        assert arrivals
        assert all(steps[n] > 0 for n in arrivals)


def test_lost_packets_and_edges_are_taken_again(tmp_path):
    _, plain = make(tmp_path)
    first = planned(settings(), size=4).lines[3].first
    rig = FakeRig(lose={first, first + 2}, skip_edges={first + 5})
    again = scan(rig, planned(rig.settings, size=4), tmp_path / "again.nc")
    np.testing.assert_array_equal(again.dataset["raw_counts"], plain.dataset["raw_counts"])


@pytest.mark.parametrize(
    ("trouble", "error", "named"),
    [
        ({"break_at": 200}, Unsafe, "interlock"),
        ({"unlock_at": 200}, Unsafe, "locked"),
        ({"bright": 0.0}, ValueError, "reference target"),
    ],
)
def test_trouble_ends_in_one_sentence_with_the_rig_closed(tmp_path, trouble, error, named):
    rig = FakeRig(**trouble)
    with pytest.raises(error, match=f"^Expected .*{named}"):
        make(tmp_path, rig, size=8)
    assert rig.calls[-1] == ("rig", "closed")
    assert not (tmp_path / "m.nc").exists()
    assert journal_path(tmp_path / "m.nc").exists()


def test_a_trigger_line_that_fails_for_good_is_an_error(tmp_path, monkeypatch):
    monkeypatch.setattr(bench_module.Bench, "stepped", lambda self: False)
    with pytest.raises(BadReply, match="trigger line"):
        make(tmp_path)


def test_resume_goes_on_where_it_was_and_gives_the_same_bytes(tmp_path):
    rig, _ = make(tmp_path, size=8)
    whole = (tmp_path / "m.nc").read_bytes()
    broken = FakeRig(break_at=180)
    output = tmp_path / "again.nc"
    with pytest.raises(Unsafe):
        scan(broken, planned(broken.settings, size=8), output)
    done = len(read_journal(journal_path(output))[1])
    assert 2 < done < len(planned(broken.settings, size=8).lines)
    seen, read_lines = [], planned(broken.settings, size=8).lines
    rig = FakeRig()
    scan(rig, planned(rig.settings, size=8), output, resume=True, report=seen.append)
    assert [line.index for line in seen] == list(range(done - 1, len(read_lines)))
    first = min(call[2] for call in rig.calls if call[:2] == ("daq", "burst"))
    assert first == planned(rig.settings, size=8).lines[done].first
    assert output.read_bytes() == whole
    assert not journal_path(output).exists()


def test_a_finished_scan_is_not_taken_again(tmp_path):
    rig, first = make(tmp_path)
    again = scan(rig, planned(rig.settings, size=4), tmp_path / "m.nc", resume=True)
    assert rig.opened == 1
    with pytest.raises(ValueError, match="another one that is finished"):
        scan(rig, planned(rig.settings, size=5), tmp_path / "m.nc", resume=True)
    np.testing.assert_array_equal(again.dataset["correlation"], first.dataset["correlation"])


def test_a_scan_that_was_begun_is_not_written_over(tmp_path):
    rig = FakeRig(break_at=200)
    with pytest.raises(Unsafe):
        make(tmp_path, rig, size=8)
    with pytest.raises(ValueError, match="--resume"):
        make(tmp_path, rig, size=8)
    with pytest.raises(ValueError, match=r"belong to these settings, got plan\.camera"):
        make(tmp_path, FakeRig(), size=9, resume=True)
    with pytest.raises(ValueError, match="got seed = null where now it is 3"):
        make(tmp_path, FakeRig(), size=8, resume=True, seed=3)


def test_pixels_where_the_converter_clips_are_masked(tmp_path):
    _, measurement = make(tmp_path, FakeRig(bright=6.9))
    assert 0 < measurement.mask.sum() < measurement.mask.size


def test_without_a_power_meter_nothing_is_normalised(tmp_path):
    rig = FakeRig(no_power_meter=True)
    devices = {k: v for k, v in rig.settings.devices.items() if k != "power_meter"}
    rig.settings = replace(rig.settings, devices=devices)
    _, measurement = make(tmp_path, rig)
    assert "laser_power" not in measurement.dataset
    assert measurement.mask.all()


def test_parts_that_a_kill_has_left_are_swept_up(tmp_path):
    (tmp_path / ".m.part-1.nc").write_bytes(b"half")
    (tmp_path / ".other.part-1.nc").write_bytes(b"half")
    make(tmp_path, size=1)
    assert sorted(path.name for path in tmp_path.iterdir()) == [".other.part-1.nc", "m.nc"]


def test_a_list_of_points_has_no_camera(tmp_path):
    points = np.deg2rad([[0.0, 0.0], [1.0, 2.0], [-3.0, 1.0]])
    plan = point_list(points, sweep=(0.0,))
    rig, measurement = make(tmp_path, plan=plan)
    assert measurement.camera is None
    assert measurement.shape == (1, 3)
    error = centred(
        measurement.phase[0] - phase_from_depth(expected_range(rig, measurement), 7.15e9)
    )
    assert np.abs(error).max() < 2e-3


def test_mirrors_go_ahead_where_a_burst_is_too_short_for_their_step(tmp_path):
    points = np.array([[0.0, 0.0], [0.01, 0.0], [0.4, 0.0], [0.41, 0.0]])
    rig, _ = make(tmp_path, plan=point_list(points))
    ahead = [call[2] for call in rig.calls if call[:2] == ("galvo", "move")]
    assert ahead == [0.4, 0.4]  # once in each mode


def test_what_the_mirrors_do_not_reach_is_refused_before_anything_moves():
    with pytest.raises(ValueError, match=r"^Expected directions within 10 V"):
        planned(settings(), points=np.deg2rad([[0.0, 41.0]]))


def test_one_mode_alone(tmp_path):
    rig = FakeRig(settings=settings(scan=ScanSettings(modes=("doubled",))))
    _, measurement = make(tmp_path, rig)
    assert measurement.frequencies.tolist() == [14.32e9]


def test_the_dry_run_describes_and_estimates():
    held = settings()
    plan = planned(held, size=64)
    text = "\n".join(description(plan, held))
    assert "8192" not in text  # calibration counts too
    assert f"{plan.bursts} bursts" in text
    assert "7.16 GHz, plates at 22.5 and 22.5 deg" in text
    assert plan.bursts * 0.0133 < duration(plan) < 2 * plan.bursts * 0.0133 + 150


def test_dead_man_is_fed_on_long_lines(tmp_path, monkeypatch):
    clock = iter(np.arange(0, 1e6, 2.0))
    monkeypatch.setattr(bench_module, "monotonic", lambda: next(clock))
    rig, _ = make(tmp_path, size=2)
    bursts = sum(call[0] == "daq" for call in rig.calls)
    assert sum(call == ("rf_detection", "ping") for call in rig.calls) > bursts / 2
