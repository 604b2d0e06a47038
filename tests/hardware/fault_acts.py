"""What each driver does in the fault table, and the request of it that a fault hits."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from fault_bench import MOTORS, RF, START, TIMEOUT, Bench, shown

from cmtof.instrument.panel import Panel

GOAL = {"stage": 21e-3, "plate_emission": 0.4, "plate_detection": 0.4}
"""Where the motors' own moves end, m or rad."""


def _always(panel: Panel, result: Any) -> bool:
    return True


@dataclass(frozen=True)
class Act:
    """Something that a driver does, and the request of it that a fault hits.

    Attributes
    ----------
    does : callable
        Takes the driver.
    mark : bytes
        Regular expression that finds the request among those on the wire.
    shows : callable
        Whether panel and result show that it was done.
    once : bool
        Whether it may be sent once only: a setting, a move, an output.
    before : callable
        Brings bench and driver to where the act makes a difference.
    """

    does: Callable[[Any], Any]
    mark: bytes = b""
    shows: Callable[[Panel, Any], bool] = _always
    once: bool = True
    before: Callable[[Bench, Any], object] = lambda bench, device: None


def _rf_acts(role: str) -> dict[str, Act]:
    def knobs(panel: Panel) -> Any:
        return panel.emission if role == "rf_emission" else panel.detection

    return {
        "asks for the lock": Act(
            lambda rf: rf.lock(), rb" LOCK\?", lambda panel, lock: lock.locked, once=False
        ),
        "feeds the dead man's timer": Act(lambda rf: rf.ping(), rb" PING", once=False),
        "sets the frequency": Act(
            lambda rf: rf.set_frequency(7.152e9),
            rb" FREQ \d",
            lambda panel, hz: knobs(panel).frequency == hz == 7.152e9,
            before=lambda bench, rf: rf.set_frequency(7.15e9),
        ),
        "sets the dead man's time": Act(
            lambda rf: rf.set_dead_man(30.0),
            rb" DEAD \d",
            lambda panel, seconds: seconds == 30,
            before=lambda bench, rf: rf.set_dead_man(60.0),
        ),
        "switches RF on": Act(
            lambda rf: rf.output(True, lock_timeout=TIMEOUT),
            rb" RF ON",
            lambda panel, _: knobs(panel).on,
            before=lambda bench, rf: (rf.clear_trip(), rf.output(False)),
        ),
        "loads a table": Act(
            lambda rf: rf.load_table([0.0, 1.0, 2.0]),
            rb" TABL \d",
            lambda panel, _: np.allclose(knobs(panel).table, [0.0, 1.0, 2.0], atol=1e-4),
            before=lambda bench, rf: rf.load_table([0.5, 0.6, 0.7]),
        ),
        "is made safe": Act(
            lambda rf: rf.safe_state(),
            rb" SAFE",
            lambda panel, _: not knobs(panel).on,
            once=False,
        ),
    }


def _ten_megahertz(bench: Bench, clock: Any) -> None:
    clock.set_sine(1, frequency=10e6, amplitude=1.0)


_CLOCK = {
    "says who it is": Act(lambda clock: clock.identify(), rb"\*IDN\?", once=False),
    "sets a sine": Act(
        lambda clock: clock.set_sine(1, frequency=11e6, amplitude=1.0),
        rb"C1:BSWV WVTP",
        lambda panel, wave: panel.clock_frequency == 11e6,
        before=_ten_megahertz,
    ),
    "reads the sine back": Act(
        lambda clock: clock.set_sine(1, frequency=11e6, amplitude=1.0),
        rb"C1:BSWV\?",
        lambda panel, wave: panel.clock_frequency == wave.frequency == 11e6,
        once=False,
        before=_ten_megahertz,
    ),
    "switches its output on": Act(
        lambda clock: clock.output(1, True),
        rb"C1:OUTP ON",
        lambda panel, _: panel.clock_on,
        before=lambda bench, clock: clock.output(1, False),
    ),
    "is made safe": Act(
        lambda clock: clock.safe_state(),
        rb"C1:OUTP OFF",
        lambda panel, _: not panel.clock_on,
        once=False,
    ),
}

# Modbus: function 16 writes, 3 reads, 76 (0x4C) does several; FIO0 is at 2000 = 0x07D0
_BURST = {"rate": 24000.0, "scans": 320, "pulse_line": "FIO4"}
_DAQ = {
    "reads a register": Act(
        lambda daq: daq.read("TEST"), rb"", lambda panel, found: found == 0x00112233, once=False
    ),
    "drives a line": Act(
        lambda daq: daq.set_line("FIO5", True),
        rb"^.{7}\x10\x07\xd5",
        lambda panel, _: panel.flip_mirror_in,
        before=lambda bench, daq: daq.set_line("FIO5", False),
    ),
    "reads a line back": Act(
        lambda daq: daq.set_line("FIO5", True),
        rb"^.{7}\x03\x09\xc4",
        lambda panel, _: panel.flip_mirror_in,
        once=False,
        before=lambda bench, daq: daq.set_line("FIO5", False),
    ),
    "sets up bursts": Act(
        lambda daq: daq.configure_burst(range=1.0, **_BURST),
        rb"^.{7}\x4c\x01\x9c\x40",
        lambda panel, settings: settings.scans == 320,
        before=lambda bench, daq: daq.configure_burst(**_BURST),
    ),
    "takes a burst": Act(
        lambda daq: daq.burst().counts,
        rb"^.{7}\x4c\x01\x13\x7e\x02\x00\x00\x00\x01",
        lambda panel, counts: counts.shape == (320,) and counts.max() < 65535,
        before=lambda bench, daq: daq.configure_burst(**_BURST),
    ),
    "is made safe": Act(lambda daq: daq.safe_state(), rb"^.{7}\x4c", once=False),
}
_GALVO = {
    "turns the beam": Act(
        lambda galvo: galvo.move_to(0.2, 0.05),
        rb"^.{7}\x4c\x01\x75\x34\x02(?!\x00{4})",  # TDAC2 anywhere but at 0 V
        lambda panel, _: np.allclose(panel.galvo_volts, np.degrees([0.2, 0.05]) / 4, atol=2e-3),
    ),
    "is made safe": Act(
        lambda galvo: galvo.safe_state(),
        rb"^.{7}\x4c",
        lambda panel, _: panel.galvo_volts == [0.0, 0.0],
        once=False,
    ),
}
_INTERLOCK = {
    "looks at the loop": Act(lambda lock: lock.check(), rb"^.{7}\x03\x07\xd7", once=False),
    "looks at the loop before it opens the shutter": Act(
        lambda lock: lock.shutter(True),
        rb"^.{7}\x03\x07\xd7",
        lambda panel, _: panel.shutter_open,
        once=False,
        before=lambda bench, lock: lock.shutter(False),
    ),
    "opens the shutter": Act(
        lambda lock: lock.shutter(True),
        rb"^.{7}\x10\x07\xd1.*\x01$",
        lambda panel, _: panel.shutter_open,
        before=lambda bench, lock: lock.shutter(False),
    ),
    "switches the laser on": Act(
        lambda lock: lock.laser(True),
        rb"^.{7}\x10\x07\xd0.*\x01$",
        lambda panel, _: panel.laser_on,
        before=lambda bench, lock: lock.laser(False),
    ),
    "is made safe": Act(
        lambda lock: lock.safe_state(),
        rb"^.{7}\x10\x07\xd1",
        lambda panel, _: not (panel.shutter_open or panel.laser_on) and panel.beam_block_in,
        once=False,
    ),
}


def _motor_acts(role: str) -> dict[str, Act]:
    """APT numbers its messages in the first two bytes, the low one first."""

    def at(goal: float) -> Callable[[Panel, Any], bool]:
        return lambda panel, _: abs(shown(panel, role) - goal) < 1e-5

    def start(bench: Bench, stage: Any) -> None:
        bench.to_start(role)

    return {
        "asks for its position": Act(
            lambda stage: stage.position(), rb"^\x11\x04", at(START[role]), False, start
        ),
        "moves": Act(
            lambda stage: stage.move_to(GOAL[role]), rb"^\x53\x04", at(GOAL[role]), True, start
        ),
        "homes": Act(lambda stage: stage.home(), rb"^\x43\x04", at(0.0), True, start),
        "is made safe": Act(
            lambda stage: stage.safe_state(),
            rb"^\x65\x04",
            once=False,
            before=lambda bench, stage: bench.send_away(role),
        ),
    }


def _reset(bench: Bench, meter: Any) -> None:
    """As it is when switched on: not zeroed, it reads a little in the dark."""
    meter.identify()  # a question: opens the line anew where it was lost
    bench.lines["power_meter"].write(b"*RST\n")
    meter.identify()


_POWER_METER = {
    "reads the power": Act(
        lambda meter: meter.power(), rb"MEAS:POW\?", lambda panel, watts: watts > 0, False, _reset
    ),
    "sets the wavelength": Act(
        lambda meter: meter.set_wavelength(532e-9),
        rb"WAV \d",
        lambda panel, metres: metres == 532e-9,
        before=lambda bench, meter: (meter.identify(), meter.set_wavelength(600e-9)),
    ),
    "reads the wavelength back": Act(
        lambda meter: meter.set_wavelength(532e-9),
        rb"WAV\?\n",
        lambda panel, metres: metres == 532e-9,
        once=False,
    ),
    "sets the averaging": Act(
        lambda meter: meter.set_averaging(2000),
        rb"COUN \d",
        lambda panel, count: count == 2000,
        before=lambda bench, meter: (meter.identify(), meter.set_averaging(1)),
    ),
    "zeroes": Act(
        lambda meter: meter.zero(),
        rb"ZERO:INIT",
        lambda panel, watts: watts > 0,
        before=_reset,
    ),
    "is made safe": Act(lambda meter: meter.safe_state(), once=False),
}

ACTS: dict[str, dict[str, Act]] = {
    **{role: _rf_acts(role) for role in RF},
    "clock": _CLOCK,
    "daq": _DAQ,
    "galvo": _GALVO,
    "interlock": _INTERLOCK,
    **{role: _motor_acts(role) for role in MOTORS},
    "power_meter": _POWER_METER,
}
"""What each device does, by words that the table uses."""

QUESTIONS = {
    **dict.fromkeys(RF, "asks for the lock"),
    "clock": "says who it is",
    "daq": "reads a register",
    **dict.fromkeys(MOTORS, "asks for its position"),
    "power_meter": "reads the power",
}
"""An act of each role that changes nothing."""
