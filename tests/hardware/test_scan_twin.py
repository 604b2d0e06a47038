"""From drivers to depth: the simulated instrument is scanned over its wires."""

import os
import signal
import socket
import subprocess
import sys
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

import cmtof
from cmtof.correlation import centred, phase_from_depth
from cmtof.hardware.errors import Unsafe
from cmtof.hardware.journal import journal_path, read_journal
from cmtof.hardware.plan import raster
from cmtof.hardware.scan import scan
from cmtof.hardware.twin.run import Twin
from cmtof.instrument.optics import group_index

WALL = {"kind": "plane", "distance": 1.0, "tilt_x": 0.1, "reflectance": 0.8}
VIEW = (np.deg2rad(8.0), np.deg2rad(8.0))


def plan_of(size=8):
    return raster(size, field_of_view=VIEW, sweep=(-4e-3, 4e-3))


@pytest.fixture(scope="module")
def scanned(tmp_path_factory):
    """A tilted wall, scanned; with its true ranges and the twin's group index."""
    output = tmp_path_factory.mktemp("scan") / "m.nc"
    with Twin.default(seed=2, scene=WALL) as twin:
        scan(twin.rig, plan_of(), output, seed=2)
        ranges = twin.world.ranges(plan_of().angles).reshape(8, 8)
        settings = twin.world.settings
        return output, ranges, group_index(settings.air, settings.laser.wavelength)


def test_phases_are_right_to_a_wrap_of_the_beat(scanned):
    output, ranges, index = scanned
    measurement = cmtof.open(output)
    attributes = measurement.dataset.attrs
    assert attributes["source"] == "simulated instrument"
    assert attributes["group_index"] == pytest.approx(index, abs=1e-6)
    errors = [
        centred(phase - phase_from_depth(index * ranges, frequency))
        for phase, frequency in zip(measurement.phase, measurement.frequencies, strict=True)
    ]
    for error, tolerance in zip(errors, (0.005, 0.01), strict=True):
        assert abs(np.median(error)) < tolerance
    # half a wrap of 20.96 mm in the beat of 20 MHz, pooled over the wall
    assert abs(np.mean(errors[1] - 2 * errors[0])) < np.pi * 20e6 / 7.15e9


def test_unwrapping_gives_the_distance(scanned):
    output, ranges, index = scanned
    measurement = cmtof.open(output)
    # the wall is smaller than a wrap of the doubled mode is deep in noise: narrow the choice
    result = cmtof.unwrap(measurement, method="crt", range=(0.9, 1.1))
    depth = result["depth"].to_numpy() / index
    close = np.abs(depth - ranges) < 1e-3
    assert close.mean() > 0.5
    assert np.median(np.abs(depth - ranges)[close]) < 3e-4


def test_lost_packets_and_late_answers_change_nothing(scanned, tmp_path):
    output, *_ = scanned
    with Twin.default(seed=2, scene=WALL) as twin:
        twin.faults.add("daq", "lost-packets", after=400, times=2)
        twin.faults.add("rf_detection", "garble", after=60, times=1)
        twin.faults.add("power_meter", "late", after=8, times=1, delay=0.05)
        scan(twin.rig, plan_of(), tmp_path / "m.nc", seed=2)
    assert (tmp_path / "m.nc").read_bytes() == output.read_bytes()


@pytest.mark.parametrize(
    ("device", "kind", "after"),
    [("rf_emission", "lost-lock", 30), ("daq", "interlock-open", 500)],
)
def test_what_is_unsafe_ends_the_scan_in_the_dark(tmp_path, scanned, device, kind, after):
    with Twin.default(seed=2, scene=WALL) as twin:
        twin.faults.add(device, kind, after=after, times=1 if kind == "lost-lock" else 300)
        with pytest.raises(Unsafe, match=r"^Expected"):
            scan(twin.rig, plan_of(), tmp_path / "m.nc", seed=2)
        panel = twin.panel
        assert not (panel.emission.on or panel.detection.on or panel.shutter_open or panel.laser_on)
        assert panel.galvo_volts == [0.0, 0.0]
    assert read_journal(journal_path(tmp_path / "m.nc"))[1]
    assert not (tmp_path / "m.nc").exists()
    with Twin.default(seed=2, scene=WALL) as twin:
        scan(twin.rig, plan_of(), tmp_path / "m.nc", seed=2, resume=True)
    assert (tmp_path / "m.nc").read_bytes() == scanned[0].read_bytes()


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


@pytest.fixture
def rig_file(tmp_path):
    """The default rig at free ports."""
    text = files("cmtof.hardware").joinpath("rig.yml").read_text(encoding="utf-8")
    for port in ("15025", "15502", "15702"):
        text = text.replace(port, str(free_port()))
    path = tmp_path / "rig.yml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.slow
def test_two_terminals(rig_file, run, tmp_path):
    command = [sys.executable, "-m", "cmtof.cli", "twin", str(rig_file), "--seed", "3"]
    environment = os.environ | {"COLUMNS": "200", "PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment
    ) as twin:
        try:
            assert twin.stdout is not None
            shown = b""
            while b"power_meter" not in shown:
                shown += (line := twin.stdout.readline())
                assert line, "the twin ended"
            outputs = [tmp_path / name for name in ("a.nc", "b.nc")]
            for output in outputs:
                code, out, err = run("scan", rig_file, "--size", "6", "-o", output, "--quiet")
                assert (code, err) == (0, "")
                assert "6x6 px" in out
        finally:
            twin.send_signal(signal.SIGTERM)
            _, errors = twin.communicate(timeout=20)
    assert twin.returncode == 128 + signal.SIGTERM
    assert errors == b""
    assert outputs[0].read_bytes() == outputs[1].read_bytes()
    assert "seed" not in cmtof.open(outputs[0]).dataset.attrs
    assert not list(Path(rig_file.parent, "twin").glob("*"))


def test_nobody_answers_at_the_rig(fails, rig_file, tmp_path):
    message = fails("scan", rig_file, "--size", "2", "-o", tmp_path / "m.nc")
    assert "127.0.0.1" in message or "rf-emission" in message
    assert not list(tmp_path.glob("m.nc*"))
