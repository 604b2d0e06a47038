"""RIG files: what they say, what they cannot say, and what opening one does."""

import copy
import math
import re
import socket
from dataclasses import asdict
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from cmtof.hardware import rig as rig_module
from cmtof.hardware.drivers.apt_stage import Stage
from cmtof.hardware.drivers.labjack_t7 import LabJackT7
from cmtof.hardware.drivers.rf_driver import RfDriver
from cmtof.hardware.errors import ConnectionLost, Unsafe
from cmtof.hardware.rig import Rig
from cmtof.hardware.rig_settings import DRIVERS, SECTIONS, settings_from_dict
from cmtof.hardware.transport import ReplayTransport

TEXT = Path(rig_module.__file__).with_name("rig.yml").read_text(encoding="utf-8")
PLAIN = yaml.load(TEXT, rig_module._StrictLoader)


def changed(path, value):
    held = copy.deepcopy(PLAIN)
    *sections, key = path
    place = held
    for section in sections:
        place = place[section]
    place[key] = value
    return held


# --- what it says ------------------------------------------------------------------------------


def test_the_default_rig():
    settings = Rig.default().settings
    assert set(settings.devices) == set(DRIVERS)
    assert settings.devices["daq"].stream == "tcp://127.0.0.1:15702"
    assert settings.detection.scans == 320
    assert settings.detection.duration == pytest.approx(13.3e-3, rel=0.01)
    assert settings.detection.channel_number == 0
    assert (settings.drive.frequency("single"), settings.drive.frequency("doubled")) == (
        7.15e9,
        7.16e9,
    )
    assert settings.scan.field_of_view == pytest.approx((math.radians(20),) * 2)
    assert settings.galvo.volts_per_radian == pytest.approx(0.25 * 180 / math.pi)
    assert settings.plates.mount_angles("doubled") == pytest.approx((math.radians(22.5),) * 2)


def test_the_file_states_every_default_and_nothing_else():
    """What a section leaves out is what the classes say, so the file can be read as the manual."""
    bare = settings_from_dict({"devices": PLAIN["devices"]})
    full = Rig.default().settings
    for name in SECTIONS:
        assert getattr(bare, name) == getattr(full, name)
        missing = set(asdict(getattr(bare, name))) - set(PLAIN[name])
        assert missing <= {"offset_x_volts", "offset_y_volts"}


def test_the_file_speaks_of_si_units():
    assert not re.search(
        r"\b(mm|um|ms|us|kHz|MHz|GHz|mV)\b", TEXT.replace("13 ms", "").replace("10 kHz", "")
    )
    assert not re.search(r"/(home|root|tmp|work)/", TEXT)


def test_zero_angles_shift_the_mounts():
    held = changed(("plates", "zero_detection_deg"), 10.0)
    angles = settings_from_dict(held).plates.mount_angles("single")
    assert angles == pytest.approx((math.radians(11.25), math.radians(21.25)))


def test_the_twin_section_is_left_to_the_twin():
    held = changed(("twin",), {"anything": [1, {"goes": True}]})
    assert settings_from_dict(held).twin == {"anything": [1, {"goes": True}]}


# --- what it cannot say ------------------------------------------------------------------------

WRONG = [
    (
        ("extra",),
        1,
        "Expected keys of the RIG file out of name, devices, .* got 'extra'. Correct or remove it",
    ),
    (("drive", "power"), 1.0, "Expected keys of drive out of power_dbm, .* got 'power'"),
    (("devices", "laser"), {}, "Expected keys of devices out of rf_emission, .* got 'laser'"),
    (("devices", "clock"), {"driver": "sdg2042x"}, "Expected devices.clock.address, got none"),
    (("devices", "clock"), "tcp://x:1", "Expected devices.clock to be a mapping, got 'tcp"),
    (("devices", "clock", "driver"), "sdg1032x", "devices.clock.driver sdg2042x, got sdg1032x"),
    (("devices", "clock", "address"), 15025, "devices.clock.address to be text, got 15025"),
    (("devices", "daq", "stream"), "", "devices.daq.stream, the address of port 702, got none"),
    (("devices", "stage", "stage"), "", "stage mts50-z8 or prm1-z8, got ''"),
    (("devices", "stage", "counts_per_unit"), -1.0, "counts_per_unit from 0 to 1e.12, got -1"),
    (("drive", "power_dbm"), "30 dBm", "drive.power_dbm to be a number, got '30 dBm'"),
    (("drive", "power_dbm"), True, "drive.power_dbm to be a number, got True"),
    (("drive", "power_dbm"), math.nan, "drive.power_dbm to be a number, got nan"),
    (("drive", "power_dbm"), math.inf, "drive.power_dbm to be a number, got inf"),
    (("devices", "stage", "counts_per_unit"), math.inf, "from 0 to 1e.12, got inf"),
    (("drive", "dead_man"), 0.0, "drive.dead_man from 0.1 to 60, got 0"),
    (("drive", "frequency_single"), 14.3e9, "frequency_single from 7.14e.09 to 7.17e.09"),
    (("lines", "laser"), "FIO9", "Expected lines.laser of FIO0 to FIO7, got 'FIO9'"),
    (("lines", "laser"), "FIO1", "Expected lines.shutter on a line of its own, got FIO1"),
    (("lines", "laser"), "FIO3", "on a line of its own, got FIO3, which lines.laser uses"),
    (("galvo", "x"), "DAC0", "Expected galvo.x of TDAC0 to TDAC7, got 'DAC0'"),
    (("galvo", "limit_volts"), 12.0, "galvo.limit_volts from 0 to 10"),
    (("detection", "range"), 5.0, "detection.range of 10, 1, 0.1 or 0.01 V, got 5"),
    (("detection", "settle_samples"), 20, "settle_samples below samples_per_phase, got 20"),
    (("detection", "phases"), 65, "detection.phases from 3 to 64"),
    (("detection", "phases"), 16.0, "detection.phases to be a whole number, got 16.0"),
    (("detection", "channel"), "AIN14", "AIN0 to AIN13"),
    (("detection", "rate"), 60e3, "detection.rate from 1 to 50000"),
    (("scan", "field_of_view_deg"), [20.0], "two angles from 0 to 80, got"),
    (("scan", "field_of_view_deg"), 20.0, r"such as \[20.0, 20.0\], got 20.0"),
    (("scan", "modes"), ["tripled"], "modes out of single, doubled, each once"),
    (("scan", "modes"), ["single", "single"], "each once"),
    (("scan", "modes"), [], "each once"),
    (("galvo",), None, "Expected galvo to be a mapping, got None"),
    (("twin",), [1], "Expected twin to be a mapping"),
]


@pytest.mark.parametrize(("path", "value", "words"), WRONG)
def test_wrong_values_are_named(path, value, words):
    with pytest.raises(ValueError, match=words) as caught:
        settings_from_dict(changed(path, value))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("- a\n- b", "Expected bad.yml to be a mapping"),
        ("name: {a: [1}", "Expected YAML in bad.yml"),
        ("devices: {}\ndevices: {}", "the key devices twice in line 1"),
        ("drive: {dead_man: 1.0, dead_man: 2.0}", "the key dead_man twice"),
        ("name: !!python/object/apply:os.getcwd []", "Expected YAML in bad.yml"),
        ("", "Expected bad.yml to be a mapping, got None"),
    ],
)
def test_files_that_are_no_rig(tmp_path, text, words):
    path = tmp_path / "bad.yml"
    path.write_text(text)
    with pytest.raises(ValueError, match=words) as caught:
        Rig.load(path)
    assert "\n" not in str(caught.value)


def test_a_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError, match="Expected a RIG file, got no file"):
        Rig.load(tmp_path / "rig.yml")


@pytest.mark.parametrize(
    ("text", "value"), [("7.15e9", 7.15e9), ("7150000000", 7.15e9), ("7.15e+9", 7.15e9)]
)
def test_numbers_are_written_as_one_likes(tmp_path, text, value):
    path = tmp_path / "rig.yml"
    path.write_text(TEXT.replace("frequency_single: 7.15e9", f"frequency_single: {text}"))
    assert Rig.load(path).settings.drive.frequency_single == value


plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=8,
)


@given(st.sampled_from(["name", "devices", "twin", *SECTIONS]), plain)
def test_any_values_are_settings_or_one_error(section, value):
    try:
        settings_from_dict(changed((section,), value))
    except ValueError as error:
        assert str(error).startswith("Expected ")


# --- addresses and opening ---------------------------------------------------------------------


def test_relative_paths_count_from_the_folder_of_the_file(tmp_path):
    path = tmp_path / "lab.yml"
    path.write_text(
        TEXT.replace('"serial:twin/stage"', '"serial:/dev/ttyUSB3?rtscts=1"').replace(
            '"serial:twin/power-meter"', '"serial:sub/pm?baud=9600"'
        )
    )
    rig = Rig.load(path)
    assert rig.address("stage") == "serial:/dev/ttyUSB3?rtscts=1"
    assert rig.address("power_meter") == f"serial:{tmp_path}/sub/pm?baud=9600"
    assert rig.address("daq", "stream") == "tcp://127.0.0.1:15702"


def test_other_addresses():
    rig = Rig.default().with_addresses({"daq": {"address": "tcp://127.0.0.1:1", "stream": "s"}})
    assert (rig.address("daq"), rig.address("daq", "stream")) == ("tcp://127.0.0.1:1", "s")
    assert Rig.default().address("daq") == "tcp://127.0.0.1:15502"


class Line(ReplayTransport):
    """A line that nobody answers on, but whoever closes it is remembered."""

    closed: list = []  # noqa: RUF012

    def __init__(self, address):
        super().__init__([])
        self.address = address

    def close(self):
        self.closed.append(self.address)
        super().close()


@pytest.fixture
def lines(monkeypatch):
    Line.closed = []
    monkeypatch.setattr(rig_module, "open_transport", Line)
    return Line


def test_opening_makes_every_instrument(lines):
    instruments = Rig.default().open()
    assert isinstance(instruments.rf_emission, RfDriver)
    assert isinstance(instruments.daq, LabJackT7)
    assert instruments.stage.kind.name == "MTS50-Z8"
    assert instruments.plate_detection.kind.name == "K10CR1"
    assert instruments.galvo.registers(0.0, math.radians(4)) == {"TDAC2": 0.0, "TDAC3": 1.0}
    assert [device.name for device in instruments.in_order_of_stopping()] == [
        "interlock",
        "galvo",
        "rf emission",
        "rf detection",
        "plate emission",
        "plate detection",
        "stage",
        "daq",
        "clock",
        "power meter",
    ]
    instruments.close()
    assert len(lines.closed) == 9  # the read-out has two


def test_a_rig_without_some_devices(lines):
    held = copy.deepcopy(PLAIN)
    held["devices"] = {"stage": held["devices"]["stage"]}
    held["devices"]["stage"]["counts_per_unit"] = 34304000.0
    instruments = Rig(settings_from_dict(held)).open()
    assert isinstance(instruments.stage, Stage)
    assert instruments.stage.kind.counts(0.010) == 343040
    assert instruments.daq is instruments.galvo is instruments.interlock is None
    instruments.close()


def test_a_device_that_is_not_there_closes_the_others(lines, monkeypatch):
    def opened(address):
        if "15702" in address:
            raise ConnectionLost(f"Expected an open line to {address}, got none. Switch it on.")
        return Line(address)

    monkeypatch.setattr(rig_module, "open_transport", opened)
    with pytest.raises(ConnectionLost, match="15702"):
        Rig.default().open()
    assert lines.closed == [
        "tcp://127.0.0.1:15502",
        "tcp://127.0.0.1:15025",
        "serial:twin/rf-detection",
        "serial:twin/rf-emission",
    ]


def test_nobody_listens():
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    held = copy.deepcopy(PLAIN)
    held["devices"] = {"clock": {"driver": "sdg2042x", "address": f"tcp://127.0.0.1:{port}"}}
    with pytest.raises(ConnectionLost, match="Expected an open line to tcp://"):
        Rig(settings_from_dict(held)).open()


def test_leaving_stops_and_closes_even_if_nothing_answers(lines):
    words = r"got 9 that are not: interlock: .* Switch them off by hand"
    with pytest.raises(Unsafe, match=words), Rig.default().open():
        pass
    assert len(lines.closed) == 9
