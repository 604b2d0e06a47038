"""Scans over sockets and pseudo-terminals, by the drivers, before devices that fail."""

import signal
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

from numpy.testing import assert_array_equal
from pytest import approx, fixture, mark
from refusals import refused
from wire import RIG, TODAY, WALL, with_device

from cmtof.hardware.connect import DARK_FIRST, connected_bench, connected_driver
from cmtof.hardware.device import ConnectionLost, InstrumentError, Refused, Unsafe
from cmtof.hardware.plan import plan_scan
from cmtof.hardware.scan import scan
from cmtof_lab.rehearsal import simulated_bench


@fixture
def take(world):
    """Scan the wall over the wires."""

    def taken(**changes):
        rig = replace(world.rig, **changes)
        return scan(plan_scan(rig, size=2), partial(connected_bench, rig), Path("m.nc"))

    return taken


def test_counts_are_those_of_the_simulation_with_slow_parts(world, take):
    """A flipper of 2.8 s, 10 s for a home and a move with light and RF on, and thin, warm air."""
    air = {"pressure": 83e3, "temperature": 303.15}
    world.models["daq"].flip_time = 2.8
    world.models["stage"].slow = iter([200, 200])
    found = take(**air, shutter_settling=8.0)  # longer than a watchdog waits
    assert world.dark
    bench = partial(simulated_bench, RIG, WALL, seed=4)
    wanted = scan(plan_scan(replace(RIG, **air), size=2), bench, Path("simulated.nc"))
    assert (found.dataset["time"] > TODAY).all()
    usual, thin = (one.dataset.attrs["group_index"] - 1 for one in (wanted, found))
    # of an ideal gas
    assert thin / usual == approx(83e3 / 101325 * 293.15 / 303.15, rel=2e-3)
    for name in ("raw_counts", "laser_power", "detuning", "angle"):
        assert_array_equal(found.dataset[name], wanted.dataset[name])


def test_a_check_asks_every_device_and_leaves_its_port_free(world, run, succeeds):
    world.write()
    text = succeeds("scan rig.yml --check")
    assert text.count("not homed") == 3
    assert text.count("RF off") == 2
    told = ["closed", "0 mW at the meter", "SDG2042X", "S140C", "T7 470010001 1.0292"]
    assert all(part in text for part in told)
    assert succeeds("scan rig.yml --check") == text
    world.panel.interlock_closed = False
    code, text, _ = run("scan rig.yml --check")
    assert code == 1
    assert "Close doors and covers" in text


# Request at which a device falls silent or hangs up.
PLACES = {
    "rf_emission": b"FREQ",
    "rf_detection": b"TABL",
    "clock": b"BSWV",
    "daq": b"\xb4\x14",  # label of a burst
    "plate_emission": b"\x53\x04",
    "plate_detection": b"\x53\x04",
    "stage": b"\x53\x04",
    "power_meter": b"MEAS:POW",
}


def goes_dark(world, lost):
    """Whether all is dark, and at the latest when the timer of a device that is lost ends."""
    soon = world.dark or lost in DARK_FIRST
    world.silence(6.0)
    return soon and world.dark


@mark.parametrize("fault", [b"", ConnectionResetError()], ids=["silent", "hangs up"])
@mark.parametrize("role", PLACES)
def test_a_device_that_goes_leaves_no_light(world, take, role, fault):
    world.ends[role].wire.fail(PLACES[role], fault)
    world.rig = with_device(world.rig, role, timeout=0.05)  # nobody waits longer for it
    with refused("Expected", InstrumentError):
        take()
    assert goes_dark(world, role)


# --- starts and ends -----------------------------------------------------------------------------


@fixture
def lit(world):
    """The world as a killed scan leaves it, and its read-out's driver."""
    daq = connected_driver(world.rig, "daq")
    daq.watchdog(5)
    daq.set_line("FIO0", True)
    daq.set_line("FIO1", True)
    world.panel.emission.on = True
    world.panel.detection.on = True
    yield daq
    daq.close()


@mark.parametrize("role", [*PLACES, "stream"])
def test_a_device_that_is_missing_at_the_start_leaves_no_light(world, lit, role):
    lit.close()
    world.ends[role].close()
    with refused("Expected", ConnectionLost), connected_bench(world.rig):
        pass
    assert world.lit == (role == "daq")
    assert world.panel.detection.on == (role == "rf_detection")
    assert goes_dark(world, role)


def test_a_start_where_nothing_is_there_says_so(world):
    for role in DARK_FIRST:
        world.ends[role].close()
    with refused("to be there", InstrumentError), connected_bench(world.rig):
        pass


@mark.parametrize("role", DARK_FIRST)
def test_a_device_that_is_silent_at_the_start_keeps_no_other_on(world, lit, role):
    world.ends[role].wire.fail(b"", b"")
    world.rig = with_device(world.rig, role, timeout=0.05)
    with refused("in time", InstrumentError), connected_bench(world.rig):
        pass
    assert world.panel.detection.on == (role == "rf_detection")


@mark.parametrize("role", ["rf_emission", "daq"])
def test_a_device_whose_name_is_garbled_goes_dark(world, lit, role):
    world.ends["stream"].close()
    world.ends[role].wire.fail(b"", b"nonsense\n", times=2)
    with refused("Expected", InstrumentError), connected_bench(world.rig):
        pass
    assert world.dark


@mark.parametrize("role", PLACES)
def test_another_device_than_the_rig_names_is_refused(world, role):
    with (
        refused("OTHER, got .* Check the address", Refused),
        connected_bench(with_device(world.rig, role, serial_number="OTHER")),
    ):
        pass
    assert world.dark
    assert not any(b"SAFE" in line for line in world.ends[role].wire.sent)


def test_a_read_out_whose_power_comes_back_is_dark_once_that_is_saved(world, lit):
    lit.safe_state()
    world.models["daq"].cycle_power()
    assert world.panel.laser_on  # from the factory, without a resistor to ground
    lit.save_power_up_state()
    world.models["daq"].cycle_power()
    assert not world.lit


def test_all_goes_dark_when_the_interlock_opens_while_a_person_is_asked(
    world, monkeypatch, capsys
):
    def press_enter(text):
        world.panel.interlock_closed = False
        while world.lit:
            time.sleep(0.01)

    monkeypatch.setattr("builtins.input", press_enter)
    with refused("the interlock closed", Unsafe), connected_bench(world.rig) as bench:
        bench.switch("laser", True)
        bench.ask("Enter? ")
    assert (
        "got it open. Close doors and covers. Press Enter." in capsys.readouterr().err
    )


def test_a_program_whose_terminal_is_closed_ends_in_the_dark(world):
    world.write(flip_mirror_settling=0.0)
    wire = world.ends["power_meter"].wire
    works = wire.answer

    def answer(request):
        if b"MEAS:POW" in request and world.panel.shutter_open:
            scan.send_signal(signal.SIGHUP)
        return works(request)

    wire.answer = answer
    command = f"{sys.executable} -m cmtof scan rig.yml --size 2 -o m.nc"
    with subprocess.Popen(command.split(), stderr=-1) as scan:
        scan.communicate(timeout=60)
    assert scan.returncode == 128 + signal.SIGHUP
    assert world.dark
