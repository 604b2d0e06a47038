"""What lets light out, and what must not while the interlock is open."""

import pytest

from cmtof.hardware.drivers.interlock import Interlock
from cmtof.hardware.errors import InstrumentTimeout, Refused, Unsafe
from cmtof.hardware.rig_settings import LineSettings


class Lines:
    """Levels by line; `stuck` lines fail so many times."""

    def __init__(self, closed=True):
        self.levels = {"FIO7": closed}
        self.stuck = {}
        self.log = []

    def line(self, dio):
        return self.levels[dio]

    def set_line(self, dio, high):
        if self.stuck.get(dio, 0):
            self.stuck[dio] -= 1
            raise InstrumentTimeout(f"Expected an answer about {dio}, got none. Ask again.")
        self.levels[dio] = high
        self.log.append((dio, high))


@pytest.fixture
def lines():
    return Lines()


@pytest.fixture
def interlock(lines):
    return Interlock(lines, LineSettings())


@pytest.mark.parametrize(
    ("call", "line", "true", "false"),
    [
        ("laser", "FIO0", True, False),
        ("shutter", "FIO1", True, False),
        ("flip_mirror", "FIO5", True, False),
        ("beam_block", "FIO6", False, True),  # low puts it in: without power it falls in
    ],
)
def test_levels(interlock, lines, call, line, true, false):
    getattr(interlock, call)(True)
    getattr(interlock, call)(False)
    assert lines.log == [(line, true), (line, false)]


@pytest.mark.parametrize("call", ["check", "laser", "shutter"])
def test_no_light_with_an_open_interlock(interlock, lines, call):
    lines.levels["FIO7"] = False
    with pytest.raises(Unsafe, match="Expected the interlock at FIO7 closed, got it open"):
        getattr(interlock, call)(*[] if call == "check" else [True])
    assert lines.log == []


@pytest.mark.parametrize("call", ["laser", "shutter"])
def test_light_goes_off_with_an_open_interlock(interlock, lines, call):
    lines.levels["FIO7"] = False
    getattr(interlock, call)(False)
    assert [high for _, high in lines.log] == [False]


def test_the_safe_state_is_all_lines_low_and_may_be_asked_for_twice(interlock, lines):
    interlock.safe_state()
    interlock.safe_state()
    assert lines.log == [("FIO1", False), ("FIO0", False), ("FIO6", False)] * 2


@pytest.mark.parametrize("failures", [1, 2])
@pytest.mark.parametrize("line", ["FIO0", "FIO1", "FIO6"])
def test_one_line_that_fails_does_not_stop_the_others(interlock, lines, line, failures):
    lines.stuck[line] = failures
    if failures == 1:
        interlock.safe_state()
    else:
        with pytest.raises(Refused, match=f"answer about {line}"):
            interlock.safe_state()
    others = {"FIO0", "FIO1", "FIO6"} - ({line} if failures == 2 else set())
    assert {dio for dio, _ in lines.log} == others


def test_lines_of_another_rig(lines):
    Interlock(lines, LineSettings(shutter="FIO6", beam_block="FIO1")).shutter(True)
    assert lines.log == [("FIO6", True)]
