"""Faults by devices: each ends in recovery or in one clear error, and always in the safe state.

`TABLE` is the table, as data. Every row is played by the drivers against the simulated devices:
everything is on and moving, the fault hits the one request that matters, the emergency stop runs,
and afterwards the same driver does the same thing without a fault.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import pytest
from fault_acts import ACTS, QUESTIONS, Act
from fault_bench import RF, ROLES, Bench, role_of

from cmtof.hardware.errors import (
    BadReply,
    ConnectionLost,
    InstrumentError,
    InstrumentTimeout,
    Refused,
    Unsafe,
)
from cmtof.hardware.twin.faults import KINDS


@dataclass(frozen=True)
class Ending:
    """How a fault ends.

    Attributes
    ----------
    error : class or tuple of class
        What is raised, one of them; none where the driver does what was asked all the same.
    words : str
        Part of the message, or why the driver cannot know.
    unseen : bool
        Nothing on the wire tells the fault: the driver goes on.
    """

    error: type[InstrumentError] | tuple[type[InstrumentError], ...] = ()
    words: str = ""
    unseen: bool = False

    def __str__(self) -> str:
        if self.unseen:
            return f"unseen: {self.words}"
        names = " or ".join(error.__name__ for error in self.errors)
        return f"{names}: {self.words}" if names else "recovers"

    @property
    def errors(self) -> tuple[type[InstrumentError], ...]:
        return self.error if isinstance(self.error, tuple) else (self.error,)


@dataclass(frozen=True)
class Row:
    """One row: a device (role, or what hangs on the daq), what it does, the fault, the ending."""

    device: str
    act: str
    fault: str
    ending: Ending

    def __str__(self) -> str:
        return f"{self.device} {self.act} - {self.fault}"


Endings = Mapping[str, Ending]
Table = Mapping[str, Mapping[str, Endings]]

RECOVERS = Ending()
MUTE_LINE = Ending(InstrumentTimeout, "within")
GARBLED = Ending(BadReply, "got")
HUNG_UP = Ending(ConnectionLost, "Expected an open line")
LOOP_OPEN = Ending(Unsafe, "Expected the interlock at FIO7 closed")

ON_THE_LINE = ("silence", "late", "too late", "cut", "garble", "drop-connection")

ASKED: Endings = dict.fromkeys(ON_THE_LINE, RECOVERS)
"""A question changes nothing, so it is asked again; a late answer to the first is passed over."""

READ_BACK: Endings = dict.fromkeys(("silence", "cut", "garble", "drop-connection"), RECOVERS)
"""A question too, but what was set before it must not be set again."""

MADE_SAFE: Endings = READ_BACK
"""What only ever switches off is said again."""

TOLD: Endings = {
    "silence": MUTE_LINE,
    "late": RECOVERS,
    "too late": MUTE_LINE,
    "cut": MUTE_LINE,
    "garble": GARBLED,
    "drop-connection": HUNG_UP,
}
"""A command that is answered is sent once: without a sound answer nobody knows if it was done."""

TOLD_DAQ: Endings = {**TOLD, "garble": Ending((BadReply, InstrumentTimeout), "Expected")}
"""Modbus: an answer with a number of the past is passed over, one of the future is an error."""


def unheeded(words: str, *more: str) -> Endings:
    """A command that is not answered: what was not done shows when the setting is read back."""
    return dict.fromkeys(("silence", "drop-connection", "ignore", *more), Ending(Refused, words))


_RF = {
    "asks for the lock": ASKED,
    "feeds the dead man's timer": {**ASKED, "lost-lock": Ending(Unsafe, "trip (LOCK)")},
    "sets the frequency": {
        **TOLD,
        "clamp": Ending(Refused, "to set its frequency to 7.152e+09 Hz, got 7.149e+09 Hz"),
        "ignore": Ending(Refused, "to set its frequency to 7.152e+09 Hz, got 7.15e+09 Hz"),
    },
    "sets the dead man's time": {
        **TOLD,
        "clamp": Ending(Refused, "to set its dead man's time to 30 s, got 24.01 s"),
        "ignore": Ending(Refused, "to set its dead man's time to 30 s, got 60 s"),
    },
    "switches RF on": {
        **TOLD,
        "ignore": Ending(Refused, "to answer RF ON, got OFF"),
        "lost-lock": Ending(Unsafe, "trip (LOCK)"),
    },
    "is made safe": MADE_SAFE,
}

_RF_DETECTION = {
    "asks for the lock": ASKED,
    "sets the frequency": {"clamp": _RF["sets the frequency"]["clamp"]},
    "switches RF on": _RF["switches RF on"],
    "loads a table": {**TOLD, "ignore": Ending(Refused, "to hold the table")},
    "is made safe": MADE_SAFE,
}
"""The same driver: what a scan asks of this one."""

# a motor does not answer a move: it speaks when it has arrived, and is asked meanwhile
_MOTOR = {
    "asks for its position": ASKED,
    "moves": {
        "silence": Ending(Refused, "Home it and try again"),
        "ignore": Ending(Refused, "Home it and try again"),
        "clamp": Ending(Refused, "Home it and try again"),
        "stall": Ending(InstrumentError, "a motion error"),
        "drop-connection": HUNG_UP,
    },
    "homes": {
        "silence": Ending(InstrumentError, "home it again"),
        "ignore": Ending(InstrumentError, "home it again"),
        "stall": Ending(InstrumentError, "a motion error"),
        "drop-connection": HUNG_UP,
    },
    "is made safe": MADE_SAFE,
}

TABLE: Table = {
    "rf_emission": _RF,
    "rf_detection": _RF_DETECTION,
    "clock": {
        "says who it is": ASKED,
        "sets a sine": {
            **unheeded("to set its frequency to 11000000 Hz, got 10000000 Hz"),
            "clamp": Ending(Refused, "to set its frequency to 11000000 Hz, got 7000000 Hz"),
        },
        "reads the sine back": READ_BACK,
        "switches its output on": unheeded("Expected output 1 of clock ON, got the contrary"),
        "is made safe": dict.fromkeys(("silence", "drop-connection", "ignore"), RECOVERS),
    },
    "daq": {
        "reads a register": ASKED,
        "drives a line": {**TOLD_DAQ, "ignore": Ending(Refused, "FIO5 of daq to go high")},
        "reads a line back": READ_BACK,
        "sets up bursts": {**TOLD_DAQ, "ignore": Ending(Refused, "to set its AIN0_RANGE to 1")},
        "takes a burst": {
            **TOLD_DAQ,
            "ignore": Ending(InstrumentTimeout, "Expected 320 samples"),
            "lost-packets": Ending(BadReply, "Take the burst again"),
            "overlap": Ending(BadReply, "overlapping scans (status 2942)"),
            "saturate": Ending(
                words="counts at the end of the converter are data; the file marks the pixel",
                unseen=True,
            ),
        },
        "is made safe": MADE_SAFE,
    },
    "galvo": {
        "turns the beam": {
            **TOLD_DAQ,
            "ignore": Ending(words="the LJTick-DAC cannot be read back", unseen=True),
            "clamp": Ending(words="the LJTick-DAC cannot be read back", unseen=True),
        },
        "is made safe": MADE_SAFE,
    },
    "interlock": {
        "looks at the loop": {**ASKED, "interlock-open": LOOP_OPEN},
        "looks at the loop before it opens the shutter": {**READ_BACK, "interlock-open": LOOP_OPEN},
        "opens the shutter": {**TOLD_DAQ, "ignore": Ending(Refused, "FIO1 of daq to go high")},
        "switches the laser on": {**TOLD_DAQ, "ignore": Ending(Refused, "FIO0 of daq to go high")},
        "is made safe": {**MADE_SAFE, "ignore": RECOVERS},
    },
    **dict.fromkeys(("plate_emission", "stage"), _MOTOR),
    "plate_detection": {
        "asks for its position": {**READ_BACK, "late": RECOVERS},
        "moves": _MOTOR["moves"],
        "is made safe": dict.fromkeys(("silence", "drop-connection"), RECOVERS),
    },
    "power_meter": {
        "reads the power": ASKED,
        "sets the wavelength": {
            **unheeded("to set its wavelength to 532 nm, got 600 nm"),
            "clamp": Ending(Refused, "to set its wavelength to 532 nm, got 457 nm"),
        },
        "reads the wavelength back": READ_BACK,
        "sets the averaging": {
            **unheeded("to set its averaging to 2000 readings, got 1 readings"),
            "clamp": Ending(Refused, "to set its averaging to 2000 readings, got 1000 readings"),
        },
        "zeroes": {
            "drop-connection": Ending(words="the meter keeps its zero", unseen=True),
            "silence": Ending(words="the meter keeps its zero", unseen=True),
            "ignore": Ending(words="the meter keeps its zero", unseen=True),
        },
    },
}
"""Device, what it does, fault, ending."""

LASTING: Endings = {
    "silence": MUTE_LINE,
    "cut": MUTE_LINE,
    "garble": Ending((BadReply, InstrumentTimeout), "Expected"),
    "drop-connection": HUNG_UP,
}
"""A fault that stays: a question is asked twice, then there is one error."""


def rows(table: Table) -> list[Row]:
    """A table row by row."""
    return [
        Row(device, act, fault, ending)
        for device, acts in table.items()
        for act, faults in acts.items()
        for fault, ending in faults.items()
    ]


ROWS = rows(TABLE)


class Benches:
    """One bench for all rows; a new one after a row that failed."""

    def __init__(self) -> None:
        self._bench: Bench | None = None

    def get(self) -> Bench:
        if self._bench is not None and not self._bench.clean:
            self.close()
        if self._bench is None:
            self._bench = Bench().__enter__()
        self._bench.clean = False  # until the row has passed
        return self._bench

    def close(self) -> None:
        if self._bench is not None:
            self._bench.__exit__()
            self._bench = None


@pytest.fixture(scope="module")
def benches() -> Iterator[Benches]:
    benches = Benches()
    yield benches
    benches.close()


@pytest.fixture
def bench(benches: Benches) -> Bench:
    return benches.get()


def play(bench: Bench, row: Row, act: Act) -> None:
    """Do what the row says under the emergency stop, and check the ending."""
    device = bench.devices[row.device]
    if not row.ending.errors:
        with bench.stop():
            result = act.does(device)
            assert act.shows(bench.twin.panel, result) != row.ending.unseen
        return

    def acting() -> None:
        with bench.stop():
            act.does(device)

    error = complaint(acting)
    assert type(error) in row.ending.errors, repr(error)
    assert row.ending.words in str(error)
    assert "Then: " not in str(error)  # the stop itself failed nowhere


def complaint(act: Callable[[], object]) -> InstrumentError:
    """The one clear error of what fails: a line that says what was expected and what came."""
    with pytest.raises(InstrumentError, match=r"^Expected .*, got .*\. .*\.$") as caught:
        act()
    assert "\n" not in str(caught.value)
    return caught.value


@pytest.mark.parametrize("row", ROWS, ids=str)
def test_every_fault_ends_well(bench: Bench, row: Row):
    act, device = ACTS[row.device][row.act], bench.devices[row.device]
    bench.light_up(but=row.device)
    act.before(bench, device)
    line = bench.strike_at(row.device, act.mark, row.fault)
    play(bench, row, act)
    assert line.marked == 1 if act.once else line.marked >= 1
    bench.assert_safe()

    bench.twin.faults.clear()
    if row.device in RF:
        bench.light_up(but=row.device)
    act.before(bench, device)
    line.watch(act.mark, None)
    result = act.does(device)
    assert act.shows(bench.twin.panel, result)
    bench.clean = True


@pytest.mark.parametrize("fault", LASTING)
@pytest.mark.parametrize("role", ["rf_emission", "clock", "daq", "stage", "power_meter"])
def test_a_fault_that_stays_is_one_clear_error(bench: Bench, role: str, fault: str):
    act, device, faults = ACTS[role][QUESTIONS[role]], bench.devices[role], bench.twin.faults
    bench.light_up(but=role)
    act.before(bench, device)
    line = bench.line(role)
    line.watch(act.mark, None)
    line.dead = fault != "drop-connection"
    faults.add(role, fault, times=0)
    error = complaint(lambda: act.does(device))
    assert type(error) in LASTING[fault].errors and LASTING[fault].words in str(error), repr(error)

    faults.clear()
    line.dead = False
    with bench.stop():
        assert act.shows(bench.twin.panel, act.does(device))
    bench.assert_safe()
    bench.clean = True


@pytest.mark.parametrize("role", ROLES)
def test_a_dead_device_does_not_keep_the_others_running(bench: Bench, role: str):
    """RF goes off all the same: its dead man's timer needs nobody."""
    bench.light_up()
    device, line = bench.devices[role], bench.line(role)
    if role in RF:
        device.set_dead_man(0.2)
    line.dead = True
    bench.twin.faults.add(role, "silence", times=0)
    if role == "power_meter":  # has nothing to be made safe
        with bench.stop():
            pass
    else:
        with pytest.raises(Unsafe) as caught, bench.stop():
            pass
        failed = 3 if role == "daq" else 1  # mirrors, lines and read-out
        assert f"got {failed} that are not: " in str(caught.value)
        assert "Switch them off by hand." in str(caught.value)
    knobs = {"rf_emission": bench.twin.panel.emission, "rf_detection": bench.twin.panel.detection}
    end = time.monotonic() + 5.0
    while role in RF and knobs[role].on and time.monotonic() < end:
        time.sleep(0.01)
    bench.assert_safe(but="" if role in RF else role)

    bench.twin.faults.clear()
    line.dead = False
    with bench.stop():
        ACTS[role][QUESTIONS[role]].does(device)
    bench.assert_safe()
    bench.clean = True


def test_every_kind_of_fault_is_in_the_table():
    played = {(role_of(row.device), row.fault) for row in ROWS}
    assert {(role, kind) for kind, (_, roles) in KINDS.items() for role in roles} <= played
    assert {row.fault for row in ROWS} - set(KINDS) == {"too late"}
    assert set(TABLE) == set(ACTS) >= set(ROLES)
    for device, acts in TABLE.items():
        assert set(acts) <= set(ACTS[device])
