"""RIG files: strict keys and kinds, hostile YAML, and the way to the instruments."""

from dataclasses import replace

import pytest

from cmtof.hardware import rig as rig_module
from cmtof.hardware.device import ConnectionLost
from cmtof.hardware.rig import Rig, open_instruments, simulated


def load(tmp_path, text):
    """Rig of a file with a text."""
    path = tmp_path / "rig.yml"
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    return Rig.load(path)


def test_the_default_rig_holds_every_device_of_section_7():
    rig = Rig.default()
    assert set(rig.devices) == set(rig_module.DRIVERS)
    assert rig.detection.duration == pytest.approx(13.3e-3, rel=5e-3)
    assert (rig.drive.frequency("single"), rig.drive.frequency("doubled")) == (7.15e9, 7.16e9)


def test_numbers_of_yaml_1_2_are_numbers(tmp_path):
    assert load(tmp_path, "drive: {frequency_single: 7.15e9}").drive.frequency_single == 7.15e9


BOMB = "a: &a [x, x]\n" + "".join(f"b{n}: &b{n} [*a, *a]\n" for n in range(9))
HOSTILE = {
    "alias": (BOMB, "an alias"),
    "deep": ("twin: " + "{a: " * 30 + "1" + "}" * 30, "more than 8 levels"),
    "very deep": ("[" * 5000, "Expected YAML"),
    "large": ("#" * 70000, "Expected a RIG file to 65536 bytes"),
    "twice": ("name: a\nname: b", "a key twice"),
    "binary": ("\udcff\udcfe", "Expected YAML"),
    "tag": ("!!python/object/apply:os.system [ls]", "Expected YAML"),
    "list": ("[1, 2]", "Expected rig.yml"),
    "number key": ("1: 2", "known key"),
    "list key": ("? [1]\n: 2", "no text"),
    "typing mistake": ("drive: {frequency_singel: 7.15e9}", "drive.frequency_singel to be a known"),
    "text": ("drive: {power_dbm: high}", "drive.power_dbm to be a valid number"),
    "text number": ("drive: {power_dbm: '30'}", "drive.power_dbm to be a valid number"),
    "nan": ("drive: {power_dbm: .nan}", "got nan"),
    "out of bounds": ("drive: {frequency_single: 1.0e15}", "less than or equal to 7170000000"),
    "fraction": ("detection: {phases: 16.5}", "detection.phases to be a valid integer"),
    "range": ("detection: {range: 5.0}", "detection.range"),
    "settling": ("detection: {settle_samples: 20}", "below samples_per_phase"),
    "line": ("lines: {laser: FIO9}", "lines.laser"),
    "shared line": ("lines: {laser: FIO1}", "used once"),
    "mirror's line": ("lines: {laser: FIO3}", "used once"),
    "mode twice": ("scan: {modes: [single, single]}", "each once"),
    "mode": ("scan: {modes: [triple]}", "scan.modes.0"),
    "view": ("scan: {field_of_view_deg: [0, 20]}", "from 0 to 80"),
    "role": ("devices: {lamp: {driver: pm100d, address: x}}", "Expected devices out of"),
    "driver": ("devices: {daq: {driver: pm100d, address: x}}", "daq: pm100d"),
    "no address": ("devices: {daq: {driver: labjack-t7}}", "devices.daq.address to be there"),
    "twin": ("twin: {laser: {power: -1}}", "twin.laser.power"),
}


def test_a_file_that_cannot_be_is_one_line(tmp_path):
    for what, (text, words) in HOSTILE.items():
        with pytest.raises(ValueError, match="Expected") as error:
            load(tmp_path, text)
        assert words in str(error.value), what
        assert "\n" not in str(error.value), what
        assert len(str(error.value)) < 500, what


def test_a_rig_without_an_instrument_is_refused():
    devices = dict(Rig.default().devices)
    del devices["clock"]
    with pytest.raises(ValueError, match="got none of clock"):
        open_instruments(Rig(devices=devices))


def test_instruments_that_were_reached_are_closed_when_one_is_not(monkeypatch):
    closed = []

    class Opened:
        def __init__(self, name):
            self.name = name

        def close(self):
            closed.append(self.name)

    def opened(name, device, lines):
        if name == "daq":
            raise ConnectionLost("Expected a T7, got none. Check.")
        return Opened(name)

    monkeypatch.setattr(rig_module, "_opened", opened)
    with pytest.raises(ConnectionLost):
        open_instruments(Rig.default())
    assert closed == ["rf emission", "rf detection", "clock"]


def test_the_light_is_stopped_first():
    names = [one.name for one in simulated(Rig.default()).in_order_of_stopping()]
    assert names[:4] == ["interlock", "galvo", "rf emission", "rf detection"]
    assert len(names) == 10


@pytest.mark.parametrize("role", ["rf_emission", "daq", "stage"])
def test_nothing_at_an_address_is_one_line(role):
    device = Rig.default().devices[role]
    address = "127.0.0.1:9" if role == "daq" else "/no/port"
    with pytest.raises(ConnectionLost, match="Expected .* at"):
        rig_module._opened(role, replace(device, address=address), Rig.default().lines)
