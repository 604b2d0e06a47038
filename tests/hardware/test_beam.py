"""Galvo and interlock on a read-out that records."""

import numpy as np
import pytest

from cmtof.hardware.beam import Galvo, Interlock, settling_time
from cmtof.hardware.device import InstrumentTimeout, Refused, Unsafe
from cmtof.hardware.rig import GalvoSettings, LineSettings


class Recorder:
    """Digital lines and registers; lines in ``stuck`` do not follow."""

    def __init__(self, *stuck):
        self.lines, self.written, self.stuck, self.closed = {}, [], stuck, True

    def line(self, dio):
        return self.closed

    def set_line(self, dio, high):
        if dio in self.stuck:
            raise Refused(f"Expected {dio} to follow, got nothing. Look.")
        self.lines[dio] = high

    def write_many(self, values):
        self.written.append(dict(values))


def test_volts_are_those_of_half_the_optical_angle():
    daq = Recorder()
    Galvo(daq, GalvoSettings()).move_to(0.0, np.deg2rad(8.0))
    assert daq.written == [{"TDAC2": 0.0, "TDAC3": 2.0}]


@pytest.mark.parametrize("angle", [1.0, np.nan])
def test_mirrors_stay_within_their_limit(angle):
    with pytest.raises(ValueError, match="Expected the mirrors within 10 V"):
        Galvo(Recorder(), GalvoSettings()).registers(angle, 0.0)


def test_a_long_step_takes_longer():
    assert settling_time(np.deg2rad(0.4), 4e-4) == pytest.approx(4e-4)
    assert settling_time(np.deg2rad(80), 4e-4) == pytest.approx(5e-3)


def test_parking_is_sent_twice():
    daq = Recorder()
    Galvo(daq, GalvoSettings(offset_x_volts=0.3)).safe_state()
    assert daq.written == [{"TDAC2": 0.0, "TDAC3": 0.0}] * 2


def test_light_needs_a_closed_interlock():
    daq = Recorder()
    interlock = Interlock(daq, LineSettings())
    interlock.laser(True)
    interlock.shutter(True)
    assert daq.lines == {"FIO0": True, "FIO1": True}
    daq.closed = False
    for act in (interlock.laser, interlock.shutter):
        with pytest.raises(Unsafe, match="Expected the interlock at FIO7 closed"):
            act(True)
        act(False)
    assert not any(daq.lines.values())


def test_safe_state_does_each_act_even_if_another_fails():
    daq = Recorder("FIO1")
    interlock = Interlock(daq, LineSettings())
    interlock.laser(True)
    with pytest.raises(Refused, match="Expected FIO1 to follow"):
        interlock.safe_state()
    assert daq.lines == {"FIO0": False, "FIO6": False}


def test_safe_acts_are_repeated():
    daq, failures = Recorder(), [InstrumentTimeout("late")]
    follow = daq.set_line

    def late(dio, high):
        if failures:
            raise failures.pop()
        follow(dio, high)

    daq.set_line = late
    Interlock(daq, LineSettings()).safe_state()
    assert daq.lines == {"FIO0": False, "FIO1": False, "FIO6": False}
