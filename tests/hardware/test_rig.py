"""RIG files, the way to the instruments, and the beam on a read-out that records."""

import errno
import json
import re
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock, call

import numpy as np
import serial
from pytest import approx, mark
from refusals import WRONG, refused
from wire import with_device

from cmtof.hardware.connect import connected_driver
from cmtof.hardware.device import ConnectionLost, Unsafe, one_error
from cmtof.hardware.plan import plan_scan
from cmtof.hardware.rig import DRIVERS, Rig
from cmtof_lab.rehearsal import simulated_bench

pytestmark = mark.usefixtures("own_folder")
RIG = Rig.default()
PATH = Path("rig.yml")


def test_the_default_rig_holds_every_device_of_section_7():
    assert set(RIG.devices) == set(DRIVERS)
    assert RIG.scans / RIG.rate == approx(13.3e-3, rel=5e-3)
    assert "address" not in RIG.as_dict()["devices"]["daq"]


def with_devices(text):
    """A RIG file of the default devices, which a text may replace."""
    devices = f"devices: {json.dumps(RIG.as_dict()['devices'])}\n"
    return devices * (not text.startswith("devices")) + text


@mark.parametrize("text, words", WRONG["rigs"])
def test_a_file_that_cannot_be_is_one_line(text, words):
    PATH.write_text(with_devices(text))
    with refused(re.escape(words), (ValueError, OSError)):
        Rig.load(PATH)


def test_a_bench_record_moves_lines_and_turns_mirrors():
    """It lies beside the rig, whose own keys come first, and is part of the measurement."""
    Path("bench.yml").write_text(
        "lines: {laser: FIO6, beam_block: FIO0}\n"
        "mirrors: [TDAC3, TDAC2]\npower_dbm: 20\n"
        "mirror_volts_per_degree: [-0.8, 0.5]\nmirror_offset_volts: [0.1, 0]\n"
    )
    PATH.write_text(with_devices("bench: bench.yml\npower_dbm: 25\n"))
    rig = Rig.load(PATH)
    bench = simulated_bench(rig)
    written = []
    bench.daq.write_many = written.append
    bench.fly_back(np.deg2rad([[10.0, 4.0]]))
    assert written == [{"TDAC3": approx(0.1 - 0.8 * 5), "TDAC2": approx(0.5 * 2)}]
    bench.daq.set_line("FIO6", True)
    assert bench.daq.panel.laser_on
    settings = rig.as_dict()
    assert (settings["power_dbm"], settings["mirror_offset_volts"]) == (25, [0.1, 0.0])


def test_a_view_beyond_the_mirrors_is_refused():
    steep = replace(
        RIG, mirror_volts_per_degree=(1.0, 1.0), field_of_view_deg=(60.0, 20.0)
    )
    with refused("Expected mirrors within 10 V, got 13.4 V"):
        plan_scan(steep, size=8)


@mark.parametrize("role, address, help", WRONG["addresses"])
def test_nothing_at_an_address_is_one_line(role, address, help):
    with refused(f"Expected .*{help}", ConnectionLost):
        connected_driver(with_device(RIG, role, address=address), role).identify()


def test_a_port_that_may_not_be_opened_says_what_helps():
    refusal = serial.SerialException(errno.EACCES, "could not open port")
    with (
        refused("Add yourself to the group dialout", ConnectionLost),
        one_error("a serial port"),
    ):
        raise refusal
    with (
        refused("apt install libusb", ConnectionLost),
        one_error("a meter", ConnectionLost),
    ):
        raise ValueError("No backend available")


def test_the_clock_begins_from_its_own_state_and_runs_as_the_rig_says():
    bench = simulated_bench(
        replace(RIG, clock_channels=(1, 2), clock_frequency=5e6, clock_amplitude=2.0)
    )
    bench.clock = Mock()
    bench.start_clock()
    assert bench.clock.mock_calls == [
        call.reset(),
        *[call.sine(channel, frequency=5e6, amplitude=2.0) for channel in (1, 2)],
        call.lock_phases(),
        *[call.output(channel, True) for channel in (1, 2)],
    ]


def test_a_wrong_setting_below_twin_is_named():
    with refused("Expected laser_power in twin to be .*, got -1"):
        simulated_bench(replace(RIG, twin={"laser_power": -1}))


# --- the beam ------------------------------------------------------------------------------------


@mark.parametrize(
    "part, knob",
    [
        ("laser", "laser_on"),
        ("shutter", "shutter_open"),
        ("beam_block", "beam_block_out"),
    ],
)
def test_light_needs_a_closed_interlock(part, knob):
    bench = simulated_bench(RIG)
    panel = bench.daq.panel
    bench.switch(part, True)
    assert getattr(panel, knob)
    panel.interlock_closed = False
    with refused("Expected the interlock closed, got it open", Unsafe):
        bench.switch(part, True)
    bench.switch(part, False)
    assert not getattr(panel, knob)
