"""RIG files, the way to the instruments, and the beam on a read-out that records."""

import errno
import json
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest
import serial
from pytest import approx

from cmtof.hardware.connect import connected_driver
from cmtof.hardware.device import ConnectionLost, Unsafe, one_error
from cmtof.hardware.rig import DRIVERS, Rig
from cmtof_lab.rehearsal import simulated_bench

RIG = Rig.default()


def test_the_default_rig_holds_every_device_of_section_7():
    assert set(RIG.devices) == set(DRIVERS)
    assert RIG.scans / RIG.rate == approx(13.3e-3, rel=5e-3)
    assert [RIG.drive_frequency(mode) for mode in ("single", "doubled")] == [7.15e9, 7.16e9]
    assert "address" not in RIG.as_dict()["devices"]["daq"]


DEVICES = f"devices: {json.dumps(RIG.as_dict()['devices'])}\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            DEVICES + "frequency_singel: 7.15e9",
            "frequency_singel in rig.yml to be a known key",
        ),
        (DEVICES + "power_dbm: .nan", "got nan"),
        (DEVICES + "frequency_single: 1.0e15", "less than or equal to 7170000000"),
        (DEVICES + "phases: 16.5", "phases in rig.yml to be a valid integer"),
        (DEVICES + "settle_samples: 20", "below samples_per_phase"),
        (DEVICES + "field_of_view_deg: [0, 20]", "field_of_view_deg.0"),
        (DEVICES + "power_dbm: 31", "Expected power_dbm up to power_dbm_limit, 30, got 31"),
        ("devices: {lamp: {driver: pm100d}}", "Expected devices."),
        (
            DEVICES.replace("sdg2042x", "labjack-t7"),
            "Expected devices.clock: sdg2042x, got labjack-t7",
        ),
        ("devices: {daq: {}}", "devices.daq.driver in rig.yml to be there"),
    ],
)
def test_a_file_that_cannot_be_is_one_line(tmp_path, text, words):
    path = tmp_path / "rig.yml"
    path.write_text(text)
    with pytest.raises(ValueError, match="Expected") as error:
        Rig.load(path)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def moved(role, address):
    """The rig with a device at another address."""
    one = replace(RIG.devices[role], address=address)
    return replace(RIG, devices=RIG.devices | {role: one})


@pytest.mark.parametrize(
    ("role", "address"),
    [
        ("rf_emission", "/no/port"),
        ("daq", "127.0.0.1:9"),
        ("clock", "TCPIP::127.0.0.1::9::SOCKET"),
        ("power_meter", "nonsense"),
    ],
)
def test_nothing_at_an_address_is_one_line(role, address):
    with pytest.raises(ConnectionLost, match="Expected .*Check"):
        connected_driver(moved(role, address), role).identify()


def test_a_port_that_may_not_be_opened_says_what_helps():
    refusal = serial.SerialException(errno.EACCES, "could not open port")
    with (
        pytest.raises(ConnectionLost, match="Add yourself to the group dialout"),
        one_error("a serial port"),
    ):
        raise refusal
    with pytest.raises(ConnectionLost, match="ls -l /dev/serial/by-id"):
        connected_driver(moved("stage", "/dev/no-port"), "stage")


def test_the_default_rig_finds_its_libraries_in_the_extra():
    text = (Path(__file__).parents[2] / "pyproject.toml").read_text()
    extra = tomllib.loads(text)["project"]["optional-dependencies"]["hardware"]
    assert {"pyserial", "pyusb", "pyvisa", "pyvisa-py", "thorlabs-apt-protocol"} <= set(extra)


# --- the beam ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("part", "knob"), [("laser", "laser_on"), ("shutter", "shutter_open")])
def test_light_needs_a_closed_interlock(part, knob):
    bench = simulated_bench(RIG)
    panel = bench.daq.panel
    bench.switch(part, True)
    assert getattr(panel, knob)
    panel.interlock_closed = False
    with pytest.raises(Unsafe, match="Expected the interlock closed, got it open"):
        bench.switch(part, True)
    bench.switch(part, False)
    assert not getattr(panel, knob)
