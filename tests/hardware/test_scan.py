"""Whole scans of the simulated instrument: truth, faults, safe states, kill and resume."""

import itertools
import json
from dataclasses import replace
from functools import partial
from pathlib import Path
from unittest.mock import DEFAULT, Mock, call

from numpy.testing import assert_allclose, assert_array_equal
from pytest import approx, fixture, mark, raises
from refusals import refused
from wire import WALL

import cmtof
from cmtof.correlation import centred, phase_from_depth
from cmtof.files import exclusive_lock
from cmtof.hardware.device import BadReply, InstrumentTimeout, Unsafe
from cmtof.hardware.journal import journal_path, whole_lines
from cmtof.hardware.plan import mirror_settling, plan_scan
from cmtof.hardware.rig import Rig
from cmtof.hardware.scan import scan
from cmtof.measurement import open_measurement
from cmtof_lab.optics import directions_from_angles
from cmtof_lab.rehearsal import scan_scene, simulated_bench
from cmtof_lab.settings import TwinSettings
from cmtof_lab.targets import MIRROR, Plane

RIG = replace(Rig.default(), phases=4, samples_per_phase=14)
PLAN = plan_scan(RIG, size=4)
pytestmark = mark.usefixtures("own_folder")
OUTPUT = Path("m.nc")
JOURNAL = journal_path(OUTPUT)
STOP = Mock(side_effect=KeyboardInterrupt)  # a report


def take(output=OUTPUT, rig=RIG, prepare=lambda bench: None, twin=None, **options):
    """Scan the wall, which ends in the safe state; ``prepare`` sees the bench before."""
    bench = simulated_bench(rig, WALL, twin, seed=4)
    panel = bench.daq.panel
    prepare(bench)
    try:
        scan(plan_scan(rig, size=4), lambda: bench, output, **options)
    finally:
        assert not (panel.laser_on or panel.shutter_open or panel.beam_block_out)
        assert not (panel.emission.on or panel.detection.on)
        assert panel.galvo_volts == [0.0, 0.0]


def recorded():
    """Lines in the journal of a scan, its header included."""
    return len(whole_lines(JOURNAL))


@fixture(scope="module")
def whole(tmp_path_factory):
    """File of an uninterrupted scan."""
    output = tmp_path_factory.mktemp("whole") / "m.nc"
    take(output)
    return output


def test_phases_are_those_of_the_true_ranges():
    settings = TwinSettings.ideal(noise=True)
    seen = scan_scene(settings, WALL, size=6, field_of_view=0.3, seed=1)
    truth = seen.depth
    expected = [phase_from_depth(truth, frequency) for frequency in seen.frequencies]
    assert abs(centred(seen.phase - expected)).max() < 0.02
    rays = directions_from_angles(seen.dataset["angle"].to_numpy())
    assert_allclose(truth, WALL.look(rays).range, rtol=1e-6)
    assert seen.mask.all()


def test_a_file_holds_raw_counts_power_and_settings(whole):
    data = open_measurement(whole).dataset
    assert data["raw_counts"].shape == (2, 4, 4, 4)
    assert 33523 < data["dark"][0] < data["raw_counts"].mean()
    assert (data["laser_power"] > 1e-3).all()
    assert_allclose(data["detuning"][:, 0], [[-5e6, -5e6], [5e6, 5e6]])
    assert_allclose(data["reflected_power"], 23.01, atol=0.01)  # of 30 dBm
    assert json.loads(data.attrs["settings"])["detector_gain"] == 50
    assert (data.attrs["source"], data.attrs["seed"]) == ("simulated instrument", 4)
    assert not journal_path(whole).exists()


def test_a_target_among_the_scene_calibrates_as_one_behind_the_flip_mirror(whole):
    take(
        rig=replace(RIG, flip_mirror="photodiode", reference_direction_deg=(-6.0, 2.0))
    )
    found, wanted = (open_measurement(one).dataset for one in (OUTPUT, whole))
    for name in ("raw_counts", "psi"):
        assert_array_equal(found[name], wanted[name])


# --- stop and resume -----------------------------------------------------------------------------


@mark.parametrize("last", [5, len(PLAN.lines) - 1])
def test_stopped_and_resumed_gives_equal_bytes(whole, last):
    def report(line):
        if line.index == last:
            raise KeyboardInterrupt

    with raises(KeyboardInterrupt):
        take(report=report)
    assert recorded() == last + 2
    take(resume=True)
    assert OUTPUT.read_bytes() == whole.read_bytes()


@fixture
def stopped(own_folder):
    """A scan that was stopped after its first line."""
    with raises(KeyboardInterrupt):
        take(report=STOP)


@mark.parametrize("kept", [0, 1, -9, -1])
def test_a_torn_line_is_measured_again(stopped, whole, kept):
    *others, last = JOURNAL.read_bytes().splitlines(keepends=True)
    JOURNAL.write_bytes(b"".join(others) + last[:kept])
    with raises(KeyboardInterrupt):
        take(report=STOP, resume=True)
    assert recorded() == 2
    take(resume=True)
    assert OUTPUT.read_bytes() == whole.read_bytes()


def test_a_scan_begun_is_not_overwritten_nor_gone_on_with_otherwise(stopped):
    before = JOURNAL.read_bytes()
    with refused("Expected no unfinished scan, got 1 lines"):
        take()
    with refused("got another phases, 4"):
        take(rig=replace(RIG, phases=8), resume=True)
    with (
        exclusive_lock(JOURNAL),
        refused("to be free, got a process that is writing it"),
    ):
        take(resume=True)
    assert JOURNAL.read_bytes() == before
    take(resume=True)


def test_a_whole_scan_needs_no_journal_to_be_resumed(whole):
    OUTPUT.write_bytes(whole.read_bytes())
    take(resume=True)
    with refused(r"got another power_dbm, 30\.0\. Scan with its settings"):
        take(rig=replace(RIG, power_dbm=29.0), resume=True)
    with refused("got another group_index, 1.0"):
        take(twin=TwinSettings.ideal(), resume=True)


def test_a_foreign_measurement_is_not_a_finished_scan():
    cmtof.simulate(cmtof.load_frame("still_life")).save(OUTPUT)
    with refused("to be of these settings, got another"):
        take(resume=True)


# --- faults --------------------------------------------------------------------------------------


def silence(device, method, at, times=1000):
    """Have a method of a device time out from its nth call on, so many times."""
    fault = InstrumentTimeout("Expected an answer, got none. Check it.")
    calls = [DEFAULT] * (at - 1) + [fault] * times + [DEFAULT] * 1000
    setattr(device, method, Mock(wraps=getattr(device, method), side_effect=calls))


def after_lines(bench, act):
    """Have something happen after the bursts of each line, by its number."""
    works = bench.daq.bursts
    calls = itertools.count()

    def bursts(requests):
        yield from works(requests)
        act(next(calls))

    bench.daq.bursts = bursts


def lose_samples(bench, times):
    silence(bench.daq, "bursts", 4, times)


def miss_edges(bench, times):
    rf = bench.rf_detection
    after_lines(bench, lambda n: setattr(rf, "edges", rf.edges - (4 <= n < 4 + times)))


@mark.parametrize(
    "lose, error", [(lose_samples, InstrumentTimeout), (miss_edges, BadReply)]
)
def test_bursts_with_lost_samples_or_edges_are_taken_three_times(whole, lose, error):
    take(prepare=partial(lose, times=2))
    assert OUTPUT.read_bytes() == whole.read_bytes()
    with raises(error):
        take(Path("lost.nc"), prepare=partial(lose, times=3))


@mark.parametrize("stronger, share", [(1.5, 1), (1, 1.5)])
def test_more_light_than_allowed_ends_the_scan_before_the_first_lit_line(
    stronger, share
):
    twin = TwinSettings(laser_power=stronger * TwinSettings().laser_power)
    with refused("e-05 to 4 mW sent out, got", Unsafe):
        take(rig=replace(RIG, emitted_share=share * RIG.emitted_share), twin=twin)
    assert recorded() == 2  # the header and the dark line


@mark.parametrize("share", [2.0, 0.4])
def test_light_that_grows_or_fades_ends_the_scan_with_its_line(share):
    def prepare(bench):
        instrument = bench.daq.instrument
        usual = instrument.laser_power

        def grow(n):
            instrument.laser_power = lambda panel: (
                usual(panel) * (share if n == 4 else 1)
            )

        after_lines(bench, grow)

    with refused("of 1.61 to 4 mW sent out, got", Unsafe):
        take(prepare=prepare)
    assert recorded() == 5  # the header and four lines


def test_the_mirrors_are_waited_for_as_long_as_their_step_requires():
    waited = []
    take(prepare=lambda bench: setattr(bench, "wait", waited.append))
    flybacks = [seconds for seconds in waited if 0 < seconds < 0.05]
    down = mirror_settling(RIG, abs(PLAN.angles[0, 0]).max())
    assert flybacks[:2] == [down, approx(3.3e-3, abs=2e-4)]  # 15 degrees


def watched(device, *names):
    """Record of the calls of some methods of a device, which work as before."""
    acts = Mock()
    for name in names:
        acts.attach_mock(Mock(wraps=getattr(device, name)), name)
        setattr(device, name, getattr(acts, name))
    return acts.mock_calls


def test_a_scan_begins_in_the_dark_and_arms_its_timers_before_light_and_rf(whole):
    """Also where a killed scan left light and RF on; RF comes up in steps, in either mode."""
    acts = []

    def prepare(bench):
        panel = bench.daq.panel
        for knob in ("laser_on", "shutter_open", "beam_block_out"):
            setattr(panel, knob, True)
        acts.append(watched(bench.daq, "set_line", "watchdog"))
        for rf in bench.rf:
            rf.knobs.on = True
            acts.append(watched(rf, "output", "set_dead_man", "set_power"))

    take(prepare=prepare)
    light, *both = acts
    assert light[:3] == [call.set_line(f"FIO{line}", False) for line in (0, 1, 6)]
    assert light.index(call.watchdog(5)) < light.index(call.set_line("FIO0", True))
    off = call.output(False)
    ramp = [off]
    for power in (10.0, 20.0, 24.0, 27.0, 30.0):
        ramp += [call.set_power(power), call.output(True, lock_timeout=2.5)]
    assert both == [[off, call.set_dead_man(5.0), *ramp, *ramp]] * 2
    assert OUTPUT.read_bytes() == whole.read_bytes()


@mark.parametrize("lost", ["interlock_closed", "clock_on", "on"])
def test_an_open_interlock_and_a_lost_lock_end_the_scan(lost):
    def prepare(bench):
        panel = bench.daq.panel
        holder = panel.emission if lost == "on" else panel
        after_lines(bench, lambda n: setattr(holder, lost, n < 20))

    with raises(Unsafe):
        take(prepare=prepare)
    assert recorded() == 21  # the line is not recorded


@mark.parametrize(
    "twin, text",
    [
        (TwinSettings(reference=MIRROR), "it saturates. Put a grey filter"),
        (
            TwinSettings.ideal(
                reference=Plane(0.6, reflectance=0.0), ambient_radiance=0.1
            ),
            "reference target with a contrast above 0.001",
        ),
    ],
)
def test_a_reference_target_that_cannot_calibrate_ends_the_scan(twin, text):
    with refused(text):
        take(twin=twin)
    assert recorded() == 9


def test_a_generator_that_is_lost_is_noticed_at_the_end_of_the_line():
    with raises(InstrumentTimeout):
        take(prepare=lambda bench: silence(bench.clock, "output_is_on", 13))
    assert recorded() == 13  # header and twelve lines
