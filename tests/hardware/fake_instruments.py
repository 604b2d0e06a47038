"""Instruments without wires: what a scan calls, on a little physics of its own."""

from contextlib import contextmanager
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np

from cmtof.hardware.codecs.apt import Status
from cmtof.hardware.codecs.labjack import NOMINAL
from cmtof.hardware.errors import BadReply, Unsafe
from cmtof.hardware.rig_settings import DeviceSettings, RigSettings
from cmtof.instrument.optics import group_index

OFFSETS = {"single": 0.7, "doubled": -1.9}
"""Phases that cables and crystals add, rad."""

GAIN = NOMINAL.high_speed[0]


def settings(**sections):
    roles = {
        "rf_emission": "rf-driver",
        "rf_detection": "rf-driver",
        "clock": "sdg2042x",
        "daq": "labjack-t7",
        "plate_emission": "k10cr1",
        "plate_detection": "k10cr1",
        "stage": "kdc101",
        "power_meter": "pm100d",
    }
    devices = {role: DeviceSettings(driver, f"fake:{role}") for role, driver in roles.items()}
    return RigSettings(devices=devices, **sections)


@dataclass
class FakeRig:
    """Opens onto devices that share one `state`; `calls` lists what moves or lights something."""

    settings: RigSettings = field(default_factory=settings)
    depth: float = 1.2
    noise: float = 0.0
    lose: set = field(default_factory=set)
    """Labels whose first burst loses a packet."""
    skip_edges: set = field(default_factory=set)
    """Labels whose first burst loses an edge."""
    break_at: int = 0
    """Label at which the interlock opens."""
    unlock_at: int = 0
    bright: float = 2.0
    stage_missing: bool = False
    no_power_meter: bool = False
    calls: list = field(default_factory=list)
    opened: int = 0

    @contextmanager
    def open(self):
        self.opened += 1
        instruments = FakeInstruments(self)
        try:
            yield instruments
        finally:
            self.calls.append(("rig", "closed"))


class FakeInstruments(SimpleNamespace):
    def __init__(self, rig):
        state = State(rig)
        super().__init__(
            rf_emission=Rf(state, "rf_emission"),
            rf_detection=Rf(state, "rf_detection"),
            clock=Clock(state),
            daq=Daq(state),
            galvo=Galvo(state),
            plate_emission=Mover(state, "plate_emission"),
            plate_detection=Mover(state, "plate_detection"),
            stage=None if rig.stage_missing else Mover(state, "stage"),
            interlock=Interlock(state),
            power_meter=None if rig.no_power_meter else PowerMeter(state),
            state=state,
        )


class State:
    def __init__(self, rig):
        self.rig, self.calls = rig, rig.calls
        self.label, self.edges, self.index = 0, 0, 0
        self.shutter = self.laser = self.flip = False
        self.table = np.zeros(0)
        self.position = {"stage": 0.0, "plate_emission": 0.0, "plate_detection": 0.0}
        self.rf = {"rf_emission": False, "rf_detection": False}
        self.clock = False
        self.volts = (0.0, 0.0)

    @property
    def mode(self):
        angle = np.rad2deg(self.position["plate_emission"])
        assert self.position["plate_emission"] == self.position["plate_detection"]
        return {11.25: "single", 22.5: "doubled"}[round(float(angle), 6)]

    @property
    def range(self):
        if self.flip:
            return 0.60 + self.position["stage"] - 0.025
        return self.rig.depth + 0.01 * self.volts[0] + 0.02 * self.volts[1]

    @property
    def power(self):
        return 3e-3 * (1 + 0.2 * np.sin(self.label / 9)) if self.shutter and self.laser else 0.0

    def samples(self, scans, per_pulse):
        volts = np.full(scans, 0.05)
        if self.power and all(self.rf.values()) and self.clock:
            twice = 2 if self.mode == "doubled" else 1
            frequency = 7.16e9 * 2 if twice == 2 else 7.15e9
            drive = np.repeat(
                self.table[np.arange(scans // per_pulse) % len(self.table)], per_pulse
            )
            phase = 4 * np.pi * frequency * group_index() * self.range / 299792458.0
            wave = np.cos(phase - twice * drive + OFFSETS[self.mode])
            volts = volts + self.power / 3e-3 * self.rig.bright * (1 + 0.5 * wave)
        volts = volts + np.random.default_rng([7, self.label]).normal(size=scans) * self.rig.noise
        counts = np.where(
            volts >= 0,
            volts / GAIN.positive_slope + GAIN.centre,
            GAIN.centre - volts / GAIN.negative_slope,
        )
        return np.clip(np.rint(counts), 0, 65535).astype(np.uint16)


class Fake:
    def __init__(self, state, name=""):
        self.state, self.name = state, name or type(self).__name__.lower()

    def note(self, *what):
        self.state.calls.append((self.name, *what))


class Rf(Fake):
    tripped = True

    def identify(self):
        return f"CMTOF-RF,TWIN-{self.name},1.0"

    def status(self):
        unlocked = self.state.label >= self.state.rig.unlock_at > 0
        return SimpleNamespace(
            on=self.state.rf[self.name],
            locked=self.state.rf[self.name] and not unlocked,
            index=self.state.index,
            edges=self.state.edges,
            tripped=self.tripped,
        )

    def clear_trip(self):
        self.tripped = False

    def output(self, on, *, lock_timeout=2.0):
        assert not (on and self.tripped)
        self.state.rf[self.name] = on
        self.note("output", on)

    def set_frequency(self, hz):
        self.note("frequency", hz)
        return hz

    def load_table(self, phases):
        self.state.table = np.asarray(phases)

    def arm(self):
        self.state.edges = self.state.index = 0

    def index(self):
        return self.state.index, self.state.edges

    def ping(self):
        self.note("ping")

    def set_dead_man(self, s): ...
    def set_power(self, dbm): ...
    def set_phase(self, rad): ...
    def trigger(self, on): ...


class Clock(Fake):
    def identify(self):
        return "Siglent Technologies,SDG2042X,1,1"

    def output(self, channel, on):
        self.state.clock = on

    def set_load(self, channel, ohm): ...
    def set_sine(self, channel, *, frequency, amplitude, offset=0, phase=0): ...
    def phase_locked(self): ...
    def align_phases(self): ...


class Daq(Fake):
    def identify(self):
        return "T7 1"

    def calibration(self):
        return NOMINAL

    def watchdog(self, seconds, lines=None): ...

    def configure_burst(self, *, channel, rate, scans, range, pulse_line, scans_per_pulse):
        self.shape = scans, scans_per_pulse
        assert (pulse_line, range, rate) == ("FIO4", 10.0, 24000.0)

    def burst(self, before):
        state = self.state
        state.label = int(before["USER_RAM0_U32"])
        state.volts = (before.get("x", state.volts[0]), before.get("y", state.volts[1]))
        scans, per_pulse = self.shape
        state.edges += scans // per_pulse
        if state.label in state.rig.skip_edges:
            state.rig.skip_edges.remove(state.label)
            state.edges -= 1
        if state.label in state.rig.lose:
            state.rig.lose.remove(state.label)
            raise BadReply("Expected unbroken packets, got 1 missing. Take the burst again.")
        self.note("burst", state.label)
        return SimpleNamespace(counts=state.samples(scans, per_pulse), timestamp=0)


class Galvo(Fake):
    def registers(self, x, y):
        return {"x": x, "y": y}

    def settling_time(self, step):
        return 4e-4 + 0.1 * max(step - 0.2, 0)

    def move_to(self, x, y):
        self.note("move", x, y)
        self.state.volts = (x, y)

    def park(self):
        self.state.volts = (0.0, 0.0)
        self.note("park")


class Mover(Fake):
    homed = False

    def status(self):
        return Status.HOMED if self.homed else Status(0)

    def home(self):
        self.homed = True
        self.state.position[self.name] = 0.0

    def move_to(self, position):
        assert self.homed
        if self.name.startswith("plate"):
            assert not any(self.state.rf.values())
            assert not self.state.shutter
        self.note("move", position)
        self.state.position[self.name] = position
        return position

    def position(self):
        return self.state.position[self.name]


class Interlock(Fake):
    def laser(self, on):
        self.state.laser = on
        self.note("laser", on)

    def shutter(self, open_):
        self.state.shutter = open_
        self.note("shutter", open_)

    def flip_mirror(self, inserted):
        self.state.flip = inserted

    def beam_block(self, inserted): ...

    def check(self):
        if self.state.label >= self.state.rig.break_at > 0:
            raise Unsafe("Expected the interlock closed, got it open. Close the door.")


class PowerMeter(Fake):
    def identify(self):
        return "THORLABS,PM100D,1,1"

    def power(self):
        return self.state.power

    def set_wavelength(self, metres):
        assert 500e-9 < metres < 600e-9

    def set_averaging(self, n): ...
    def zero(self):
        assert not self.state.shutter
