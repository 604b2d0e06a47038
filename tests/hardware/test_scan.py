"""Whole scans of the simulated instrument: truth, faults, safe states, kill and resume."""

import itertools
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pytest import approx

import cmtof
from cmtof.correlation import centred, phase_from_depth
from cmtof.files import alone
from cmtof.hardware.device import BadReply, ConnectionLost, InstrumentTimeout, Refused, Unsafe
from cmtof.hardware.journal import journal_path, whole_lines
from cmtof.hardware.plan import mirror_settling, planned
from cmtof.hardware.rig import LINES, Rig
from cmtof.hardware.scan import scan
from cmtof.measurement import open_measurement
from cmtof_lab.optics import directions_from_angles
from cmtof_lab.rehearsal import scan_scene, simulated_bench
from cmtof_lab.settings import TwinSettings
from cmtof_lab.targets import MIRROR, Plane

RIG = replace(Rig.default(), phases=4, samples_per_phase=14)
PLAN = planned(RIG, size=4)
WALL = Plane(0.9, tilt_x=0.3, reflectance=0.8)
DARK = TwinSettings.ideal(reference=Plane(0.6, reflectance=0.0), ambient_radiance=0.1)


def take(output, rig=RIG, prepare=lambda bench: None, twin=None, **options):
    """Scan the wall; ``prepare`` sees the bench before. Returns the bench and the error."""
    held = []

    def opened():
        held.append(simulated_bench(rig, WALL, twin, seed=4))
        prepare(held[0])
        return held[0]

    try:
        scan(planned(rig, size=4), opened, output, **options)
    except BaseException as error:
        return held[0] if held else None, error
    return held[0] if held else None, None


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """File of an uninterrupted scan."""
    output = tmp_path_factory.mktemp("whole") / "m.nc"
    bench, error = take(output)
    assert error is None
    assert_safe(bench)
    return output


def assert_safe(bench):
    """Laser and shutter dark, RF off, beam parked."""
    panel = bench.daq.panel
    assert not (panel.laser_on or panel.shutter_open)
    assert not (panel.emission.on or panel.detection.on)
    assert panel.galvo_volts == [0.0, 0.0]
    assert not panel.beam_block_out


def test_phases_are_those_of_the_true_ranges():
    settings = replace(TwinSettings.ideal(), noise=True)
    seen = scan_scene(settings, WALL, size=6, field_of_view=0.3, seed=1)
    truth = seen.dataset["depth"].to_numpy()
    expected = [phase_from_depth(truth, frequency) for frequency in seen.frequencies]
    assert np.abs(centred(seen.phase - expected)).max() < 0.02
    rays = directions_from_angles(seen.dataset["angle"].to_numpy())
    assert_allclose(truth, WALL.look(rays).range, rtol=1e-6)
    assert seen.mask.all()


def test_a_file_holds_raw_counts_power_and_settings(whole):
    data = open_measurement(whole).dataset
    assert data["raw_counts"].shape == (2, 4, 4, 4)
    assert 33523 < float(data["dark"][0]) < data["raw_counts"].mean()
    assert (data["laser_power"] > 1e-3).all()
    assert (data.attrs["source"], data.attrs["seed"]) == ("simulated instrument", 4)
    assert not journal_path(whole).exists()


# --- stop and resume -----------------------------------------------------------------------------


@pytest.mark.parametrize("stop", [5, len(PLAN.lines) - 1])
def test_stopped_and_resumed_gives_equal_bytes(tmp_path, whole, stop):
    def report(line):
        if line.index == stop:
            raise KeyboardInterrupt

    output = tmp_path / "m.nc"
    bench, error = take(output, report=report)
    assert isinstance(error, KeyboardInterrupt)
    assert_safe(bench)
    assert len(whole_lines(journal_path(output))) == stop + 2
    assert take(output, resume=True)[1] is None
    assert output.read_bytes() == whole.read_bytes()


def test_a_scan_begun_is_not_overwritten(tmp_path, whole):
    output = tmp_path / "m.nc"
    take(output, report=lambda line: (_ for _ in ()).throw(KeyboardInterrupt))
    assert "Expected no scan begun, got 1 lines" in str(take(output)[1])
    other = replace(RIG, power_dbm=29.0)
    error = take(output, rig=other, resume=True)[1]
    assert "got another power_dbm, 30.0. Scan with its settings" in str(error)
    output.write_bytes(whole.read_bytes())
    journal_path(output).unlink()
    assert take(output, resume=True)[1] is None
    error = take(output, rig=other, resume=True)[1]
    assert "got another power_dbm, 30.0. Scan with its settings" in str(error)


def test_a_foreign_measurement_is_not_a_finished_scan(tmp_path):
    cmtof.simulate(cmtof.load_frame("still_life")).save(tmp_path / "m.nc")
    error = take(tmp_path / "m.nc", resume=True)[1]
    assert "to be of these settings, got another" in str(error)


def test_a_journal_that_another_scan_is_writing_is_left_alone(tmp_path):
    output = tmp_path / "m.nc"
    take(output, report=lambda line: (_ for _ in ()).throw(KeyboardInterrupt))
    before = journal_path(output).read_bytes()
    with alone(journal_path(output)):
        assert "to be free, got a process that is writing it" in str(take(output, resume=True)[1])
    assert journal_path(output).read_bytes() == before
    assert take(output, resume=True)[1] is None


# --- faults --------------------------------------------------------------------------------------

PLACES = {
    "rf_emission": "set_frequency",
    "rf_detection": "load_table",
    "clock": "sine",
    "daq": "configure_burst",
    "plate_emission": "move_to",
    "plate_detection": "move_to",
    "stage": "move_to",
    "power_meter": "set_up",
}
SET_UP_ONCE = ("clock", "daq", "power_meter")


def failing(bench, role, method, error, at=1, times=10**9):
    """Have a method of a device raise an error from its nth call on, so many times."""
    device = getattr(bench, role)
    calls = itertools.count(1)
    works = getattr(device, method)

    def act(*values, **options):
        call = next(calls)
        if at <= call < at + times:
            raise error(f"Expected an answer of {role}, got none. Check it.")
        return works(*values, **options)

    setattr(device, method, act)


@pytest.mark.parametrize("fault", [InstrumentTimeout, Refused, BadReply, ConnectionLost])
@pytest.mark.parametrize("role", PLACES)
def test_every_fault_of_every_device_ends_in_the_safe_state(tmp_path, whole, role, fault):
    output = tmp_path / "m.nc"
    fail = partial(failing, role=role, method=PLACES[role], error=fault)
    bench, error = take(output, prepare=partial(fail, at=1 if role in SET_UP_ONCE else 2))
    assert isinstance(error, fault)
    assert_safe(bench)
    assert not output.exists()
    assert take(output, resume=True)[1] is None
    assert output.read_bytes() == whole.read_bytes()


def after_lines(bench, act):
    """Have something happen after the bursts of each line, by its number."""
    works = bench.daq.bursts
    calls = itertools.count()

    def bursts(requests):
        yield from works(requests)
        act(next(calls))

    bench.daq.bursts = bursts


def lose_samples(bench, times):
    failing(bench, "daq", "bursts", InstrumentTimeout, at=4, times=times)


def miss_edges(bench, times):
    rf = bench.rf_detection
    after_lines(bench, lambda n: setattr(rf, "edges", rf.edges - (4 <= n < 4 + times)))


@pytest.mark.parametrize("lose", [lose_samples, miss_edges])
def test_bursts_with_lost_samples_or_edges_are_taken_again(tmp_path, whole, lose):
    output = tmp_path / "m.nc"
    assert take(output, prepare=lambda bench: lose(bench, 2))[1] is None
    assert output.read_bytes() == whole.read_bytes()
    bench, error = take(tmp_path / "n.nc", prepare=lambda bench: lose(bench, 3))
    assert isinstance(error, InstrumentTimeout | BadReply)
    assert_safe(bench)


def test_more_light_than_allowed_ends_the_scan_before_the_first_lit_line(tmp_path):
    stronger = TwinSettings(laser_power=1.5 * TwinSettings().laser_power)
    bench, error = take(tmp_path / "m.nc", twin=stronger)
    assert "above 0 and up to 4 mW sent out, got" in str(error)
    assert_safe(bench)
    assert len(whole_lines(journal_path(tmp_path / "m.nc"))) == 2  # the header and the dark line


@pytest.mark.parametrize(("settling", "same"), [(2.8, True), (0.5, False)])
def test_a_flip_mirror_that_takes_two_seconds_is_waited_for(tmp_path, whole, settling, same):
    """With too short a settling time the lines behind a flip see another target."""
    rig = replace(RIG, flip_mirror_settling=settling)
    turning = []

    def prepare(bench):
        works = bench.daq.set_line

        def set_line(dio, high):
            if dio == LINES["flip_mirror"]:
                turning.append(high)
            else:
                works(dio, high)

        def wait(seconds):
            if seconds > 2 and turning:
                works(LINES["flip_mirror"], turning[-1])

        bench.daq.set_line = set_line
        bench.wait = wait

    output = tmp_path / "m.nc"
    _, error = take(output, rig=rig, prepare=prepare)
    seen = [open_measurement(p).dataset["raw_counts"] for p in (output, whole) if p.exists()]
    assert (error is None and bool((seen[0] == seen[1]).all())) == same


def test_the_mirrors_are_waited_for_as_long_as_their_step_requires(tmp_path):
    waited = []

    def prepare(bench):
        bench.wait = waited.append

    assert take(tmp_path / "m.nc", prepare=prepare)[1] is None
    across = np.abs(PLAN.angles[0, -1] - PLAN.angles[0, 0]).max()
    down = PLAN.angles[0, 0]
    expected = [mirror_settling(float(step)) for step in (np.abs(down).max(), across)]
    flybacks = [seconds for seconds in waited if 0 < seconds < 0.05]
    assert flybacks[:2] == approx(expected)
    assert expected[1] == approx(3.3e-3, abs=2e-4)  # 15 degrees


def test_rf_comes_up_in_steps(tmp_path):
    powers = []

    def prepare(bench):
        works = bench.rf_emission.output
        knobs = bench.rf_emission.knobs

        def output(on, **options):
            powers.append(knobs.power if on else None)
            works(on, **options)

        bench.rf_emission.output = output

    assert take(tmp_path / "m.nc", prepare=prepare)[1] is None
    ramp = [10.0, 20.0, 24.0, 27.0, 30.0]
    assert powers == [None, None, *ramp, None, *ramp]  # set up, then both modes


@pytest.mark.parametrize("lost", ["interlock_closed", "clock_on"])
def test_an_open_interlock_and_a_lost_lock_end_the_scan(tmp_path, lost):
    def spoil(bench):
        after_lines(bench, lambda n: setattr(bench.daq.panel, lost, n < 20))

    bench, error = take(tmp_path / "m.nc", prepare=spoil)
    assert isinstance(error, Unsafe)
    assert_safe(bench)
    assert len(whole_lines(journal_path(tmp_path / "m.nc"))) == 21  # the line is not recorded


@pytest.mark.parametrize(
    ("twin", "text"),
    [
        (TwinSettings(reference=MIRROR), "it saturates. Put a grey filter"),
        (DARK, "Expected a reference target with a contrast"),
    ],
)
def test_a_reference_target_that_cannot_calibrate_ends_the_scan(tmp_path, twin, text):
    bench, error = take(tmp_path / "m.nc", twin=twin)
    assert isinstance(error, ValueError)
    assert text in str(error)
    assert_safe(bench)
    assert len(whole_lines(journal_path(tmp_path / "m.nc"))) == 9


def test_a_generator_that_is_lost_is_noticed_at_the_end_of_the_line(tmp_path):
    lose = partial(failing, role="clock", method="output_is_on", error=InstrumentTimeout, at=13)
    bench, error = take(tmp_path / "m.nc", prepare=lose)
    assert isinstance(error, InstrumentTimeout)
    assert_safe(bench)
    assert len(whole_lines(journal_path(tmp_path / "m.nc"))) == 13  # header and twelve lines
    assert take(tmp_path / "m.nc", resume=True)[1] is None


# --- command line --------------------------------------------------------------------------------


def test_a_check_prints_what_every_device_reports(run):
    code, text, _ = run("scan", "--twin", "--check")
    assert code == 0
    lines = text.splitlines()
    assert any("interlock" in line and "closed" in line for line in lines)
    assert sum("TWIN" in line for line in lines) == 8
    assert sum("not homed" in line for line in lines) == 3


@pytest.mark.parametrize(
    ("line", "code", "text"),
    [
        ("--twin", 1, "Expected an output, got none"),
        ("-o m.nc", 1, "either a RIG file or --twin"),
        ("--twin -o m.txt", 1, "Expected an output named *.nc"),
        ("--twin -o no/m.nc", 1, "Expected an existing folder"),
        ("no.yml -o m.nc", 1, "no.yml"),
        ("--twin --size 100000 -o m.nc", 2, "--size"),
        ("--twin --scene nobody -o m.nc", 1, "nobody"),
    ],
)
def test_a_wrong_command_is_one_line(tmp_path, monkeypatch, run, line, code, text):
    monkeypatch.chdir(tmp_path)
    found, _, err = run("scan", *line.split())
    assert found == code
    assert text in err
    assert not list(tmp_path.iterdir())
