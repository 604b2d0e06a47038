"""RIG files, the way to the instruments, and the beam on a read-out that records."""

import json
from dataclasses import replace

import numpy as np
import pytest

from cmtof.hardware import bench as bench_module
from cmtof.hardware.bench import Bench, driver, opened, registers, simulated
from cmtof.hardware.device import ConnectionLost, InstrumentTimeout, Refused, Unsafe
from cmtof.hardware.plan import settling_time
from cmtof.hardware.rig import DRIVERS, Rig

RIG = Rig.default()


def test_the_default_rig_holds_every_device_of_section_7():
    assert set(RIG.devices) == set(DRIVERS)
    assert RIG.scans / RIG.rate == pytest.approx(13.3e-3, rel=5e-3)
    assert [RIG.drive_frequency(mode) for mode in ("single", "doubled")] == [7.15e9, 7.16e9]
    assert "address" not in RIG.as_dict()["devices"]["daq"]


HOSTILE = {
    "typing mistake": ("frequency_singel: 7.15e9", "frequency_singel in rig.yml to be a known key"),
    "text": ("power_dbm: high", "power_dbm in rig.yml to be a valid number"),
    "nan": ("power_dbm: .nan", "got nan"),
    "out of bounds": ("frequency_single: 1.0e15", "less than or equal to 7170000000"),
    "fraction": ("phases: 16.5", "phases in rig.yml to be a valid integer"),
    "settling": ("settle_samples: 20", "below samples_per_phase"),
    "view": ("field_of_view_deg: [0, 20]", "field_of_view_deg.0"),
    "role": ("devices: {lamp: {driver: pm100d}}", "Expected devices."),
    "no driver": ("devices: {daq: {address: x}}", "devices.daq.driver in rig.yml to be there"),
    "twin": ("twin: {laser_power: -1}", "twin.laser_power"),
    "list": ("[1, 2]", "Expected names and values"),
    "tag": ("!!python/object/apply:os.system [ls]", "Expected YAML"),
}


def test_a_file_that_cannot_be_is_one_line(tmp_path):
    path, whole = tmp_path / "rig.yml", json.dumps(RIG.as_dict()["devices"])
    for what, (text, words) in HOSTILE.items():
        path.write_text(text if text[0] in "[!d" else f"devices: {whole}\n{text}")
        with pytest.raises(ValueError, match="Expected") as error:
            Rig.load(path)
        assert words in str(error.value), what
        assert "\n" not in str(error.value), what


def test_a_role_with_another_driver_is_refused():
    clock = {"clock": RIG.devices["daq"]}
    with pytest.raises(ValueError, match=r"devices.clock: sdg2042x, got labjack-t7"):
        replace(RIG, devices=dict(RIG.devices) | clock)


def test_instruments_that_were_reached_are_closed_when_one_is_not(monkeypatch):
    closed = []

    class Opened:
        def __init__(self, name):
            self.close = lambda: closed.append(name)

    def connect(name, device):
        if name == "daq":
            raise ConnectionLost("Expected a T7, got none. Check.")
        return Opened(name)

    monkeypatch.setattr(bench_module, "driver", connect)
    with pytest.raises(ConnectionLost):
        opened(RIG)
    assert closed == ["clock", "rf detection", "rf emission"]


@pytest.mark.parametrize("role", ["rf_emission", "daq", "stage"])
def test_nothing_at_an_address_is_one_line(role):
    address = "127.0.0.1:9" if role == "daq" else "/no/port"
    with pytest.raises(ConnectionLost, match="Expected .* at"):
        driver(role, replace(RIG.devices[role], address=address))


def test_the_light_is_stopped_first_and_everything_is_closed():
    calls = []
    with simulated(RIG) as bench:
        for name, device in {"beam": bench, **bench.devices}.items():
            device.safe_state = lambda name=name: calls.append(name)
            device.close = lambda name=name: calls.append(f"close {name}")
    assert calls[:9] == ["beam", *DRIVERS]
    assert sorted(calls[9:]) == sorted(f"close {role}" for role in DRIVERS)


# --- the beam ------------------------------------------------------------------------------------


class Recorder:
    """Digital lines and registers; lines in ``stuck`` do not follow, the first calls come late."""

    def __init__(self, *stuck, late=0):
        self.lines, self.written, self.stuck, self.late = {}, [], stuck, late
        self.closed = True

    def line(self, dio):
        return self.closed

    def set_line(self, dio, high):
        if dio in self.stuck:
            raise Refused(f"Expected {dio} to follow, got nothing. Look.")
        self.late -= 1
        if self.late >= 0:
            raise InstrumentTimeout("Expected an answer, got none. Check.")
        self.lines[dio] = high

    def write_many(self, values):
        self.written.append(dict(values))


def bench_on(daq):
    """Bench whose only device is a read-out."""
    return Bench(RIG, dict.fromkeys(DRIVERS, daq))


def test_volts_are_those_of_half_the_optical_angle():
    assert registers(0.0, np.deg2rad(8.0)) == {"TDAC2": 0.0, "TDAC3": 2.0}
    for angle in (1.0, np.nan):
        with pytest.raises(ValueError, match="Expected mirrors within 10 V"):
            registers(0.0, angle)
    for degrees, seconds in ((0.4, 4e-4), (80, 5e-3)):
        assert settling_time(np.deg2rad(degrees)) == pytest.approx(seconds)


def test_light_needs_a_closed_interlock():
    daq = Recorder()
    beam = bench_on(daq)
    for part in ("laser", "shutter"):
        beam.switch(part, True)
    assert daq.lines == {"FIO0": True, "FIO1": True}
    daq.closed = False
    for part in ("laser", "shutter"):
        with pytest.raises(Unsafe, match="Expected the interlock at FIO7 closed"):
            beam.switch(part, True)
        beam.switch(part, False)
    assert not any(daq.lines.values())


@pytest.mark.parametrize("daq", [Recorder(), Recorder(late=1), Recorder("FIO1")])
def test_the_safe_state_does_and_repeats_each_act_even_if_another_fails(daq):
    if daq.stuck:
        with pytest.raises(Refused, match="Expected FIO1 to follow"):
            bench_on(daq).safe_state()
    else:
        bench_on(daq).safe_state()
    assert daq.lines == {line: False for line in ("FIO0", "FIO1", "FIO6") if line not in daq.stuck}
    assert daq.written == [{"TDAC2": 0.0, "TDAC3": 0.0}] * 2
