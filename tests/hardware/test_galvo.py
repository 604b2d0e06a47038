"""Scan mirrors: angles to volts and back, limits, settling."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cmtof.hardware.drivers import galvo as galvo_module
from cmtof.hardware.drivers.galvo import Galvo
from cmtof.hardware.errors import ConnectionLost


class Recorder:
    def __init__(self, failures=0):
        self.written = []
        self.failures = failures

    def write_many(self, values):
        if self.failures:
            self.failures -= 1
            raise ConnectionLost("Expected an open line, got none. Reconnect.")
        self.written.append(dict(values))


@pytest.fixture(autouse=True)
def slept(monkeypatch):
    times = []
    monkeypatch.setattr(galvo_module.time, "sleep", times.append)
    return times


@pytest.mark.parametrize(
    ("optical", "volts"), [(0, 0.0), (4, 1.0), (-4, -1.0), (20, 5.0), (40, 10.0), (-40, -10.0)]
)
def test_half_a_volt_turns_the_mirror_by_a_degree_and_the_beam_by_two(optical, volts):
    x, y = Galvo(Recorder()).volts_from_angles(math.radians(optical), 0.0)
    assert (x, y) == pytest.approx((volts, 0.0))


@given(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), st.floats(-0.5, 0.5), st.floats(10.0, 16.0))
def test_volts_and_angles_are_inverse(x, y, offset, scale):
    mirrors = Galvo(Recorder(), volts_per_radian=scale, offset=(offset, -offset), limit=20.0)
    volts = mirrors.volts_from_angles(x, y)
    assert mirrors.angles_from_volts(*volts) == pytest.approx((x, y), abs=1e-12)


@given(st.floats(-2, 2), st.floats(-2, 2))
def test_no_voltage_leaves_beyond_the_limit(x, y):
    recorder = Recorder()
    mirrors = Galvo(recorder, limit=5.0)
    try:
        mirrors.move_to(x, y)
    except ValueError:
        assert max(abs(x), abs(y)) > math.radians(20) - 1e-9
        assert recorder.written == []
    else:
        assert all(abs(volts) <= 5.0 for volts in recorder.written[0].values())


@pytest.mark.parametrize(
    ("x", "y", "words"),
    [
        (0.71, 0.0, "mirror x within 10 V, got 10.17 V for 0.71 rad"),
        (0.0, -0.8, "mirror y within 10 V, got -11.46 V"),
        (math.nan, 0.0, "mirror x within 10 V, got nan"),
    ],
)
def test_beyond_the_limit(x, y, words):
    with pytest.raises(ValueError, match=words):
        Galvo(Recorder()).registers(x, y)


def test_registers_are_those_of_the_channels():
    mirrors = Galvo(Recorder(), ("TDAC4", "TDAC5"))
    assert mirrors.registers(math.radians(4), math.radians(-8)) == {"TDAC4": 1.0, "TDAC5": -2.0}


def test_a_step_is_waited_for_by_its_length(slept):
    mirrors = Galvo(Recorder(), settling=3e-4)
    mirrors.move_to(0.0, math.radians(0.4))
    mirrors.move_to(0.0, math.radians(0.4))
    mirrors.move_to(0.0, math.radians(-39.6))
    assert slept[:2] == pytest.approx([3e-4, 3e-4])
    assert 3e-4 < slept[2] < 5e-3
    times = [mirrors.settling_time(math.radians(step)) for step in (0, 1, 10, 80, 160)]
    assert times == sorted(times)
    assert times[-1] == pytest.approx(5e-3)


def test_parking_is_no_voltage_whatever_the_offset():
    recorder = Recorder()
    mirrors = Galvo(recorder, offset=(0.3, -0.2))
    mirrors.move_to(0.1, 0.1)
    mirrors.park()
    mirrors.safe_state()
    assert recorder.written[1:] == [{"TDAC2": 0.0, "TDAC3": 0.0}] * 3


def test_parking_is_written_twice_and_each_write_tried_twice():
    """Nothing tells whether the converter has taken a value."""
    recorder = Recorder(failures=1)
    Galvo(recorder).safe_state()
    assert recorder.written == [{"TDAC2": 0.0, "TDAC3": 0.0}] * 2
    with pytest.raises(ConnectionLost):
        Galvo(Recorder(failures=2)).safe_state()
