"""Simulated devices of the instrument, in process: each fulfils a role of `cmtof.hardware.roles`.

They share one `Panel`, whose knobs the `SimulatedInstrument` reads. Nothing waits, and the only
clock is the number of a burst. Methods are documented at the roles.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cmtof.correlation import TAU
from cmtof.hardware.plan import BURST_INTERVAL, mirror_angles
from cmtof.hardware.reduction import Gain
from cmtof.hardware.rf import CODES
from cmtof.hardware.rig import LIGHT, SAMPLE_RATE, Rig
from cmtof.hardware.roles import Requests, RfLock, RfStatus, Waiting
from cmtof.types import Array, Counts, Fields, Named, Texts
from cmtof_lab.compared_bursts import fringes, quadratures
from cmtof_lab.electronics import GAIN
from cmtof_lab.instrument import Panel, RfKnobs, SimulatedInstrument

TDAC_STEP = 20.0 / 2**14  # Step of the LJTick-DAC, 14 bit, V
DAC_STEP = 5.0 / 2**12  # of DAC0 and DAC1, 12 bit, V
# rad off the target among the scene, at which the beam misses it (assumed)
BESIDE = 1e-3
SWITCHES = {
    "laser": "laser_on",
    "shutter": "shutter_open",
    "beam_block": "beam_block_out",
}
FLIPPED = {"reference": "target_in_beam", "photodiode": "photodiode_lit"}
# knobs of the panel that follow a digital line, and that of the flip mirror by where it leads


def do_nothing(self: object, *values: float, **options: float) -> None:
    """No operation: on a real device it takes time or may fail."""


@dataclass
class SimulatedDevice:
    """A device by its role; ``identify`` marks it as simulated."""

    panel: Panel
    instrument: SimulatedInstrument
    role: str

    @property
    def name(self) -> str:
        return self.role.replace("_", " ")

    def identify(self) -> Texts:
        return {"model": type(self).__name__, "serial_number": f"TWIN-{self.name}"}

    safe_state = close = do_nothing


class SimulatedRf(SimulatedDevice):
    """RF driver of the emission or the detection."""

    edges = 0
    set_dead_man = clear_trip = ping = do_nothing

    @property
    def knobs(self) -> RfKnobs:
        return getattr(self.panel, self.role.removeprefix("rf_"))

    def set_frequency(self, hz: float) -> None:
        self.knobs.frequency = float(round(hz))

    def set_power(self, dbm: float) -> None:
        self.knobs.power = dbm

    def set_phase(self, rad: float) -> None:
        self.knobs.phase = float(_round_to_codes(rad))

    def output(self, on: bool, *, lock_timeout: float = 10.0) -> None:
        self.knobs.on = on

    def status(self) -> RfStatus:
        on = self.knobs.on
        entry = (self.edges - 1) % max(len(self.knobs.table), 1)
        return RfStatus(
            on, on and self.panel.clock_on, entry, self.edges, tripped=False
        )

    def lock(self) -> RfLock:
        settings = self.instrument.settings
        detuning = self.knobs.frequency - settings.resonance
        off = (2 * detuning / settings.resonance_width) ** 2
        lost = 10 * np.log10(off / (1 + off) + 1e-6)
        return RfLock(self.status().locked, detuning, self.knobs.power + lost)

    def load_table(self, phases: Array) -> None:
        self.knobs.table = _round_to_codes(phases)

    def trigger(self, on: bool) -> None:
        if not on:
            self.knobs.table = ()

    def arm(self) -> None:
        self.edges = 0

    def safe_state(self) -> None:
        self.knobs.on = False


class SimulatedClock(SimulatedDevice):
    """Function generator that both RF drivers are locked to."""

    reset = sine = lock_phases = do_nothing

    def output(self, channel: int, on: bool) -> None:
        self.panel.clock_on = on

    def output_is_on(self, channel: int) -> bool:
        return self.panel.clock_on

    def safe_state(self) -> None:
        self.panel.clock_on = False


class SimulatedMotor(SimulatedDevice):
    """Rotation mount of a half-wave plate, rad, or the target's stage, m."""

    homed = False

    def home(self, *, waiting: Waiting = None) -> None:
        self.homed = True
        self.move_to(0.0)

    def move_to(self, position: float, *, waiting: Waiting = None) -> float:
        setattr(self.panel, self.role, position)
        return position

    @property
    def position(self) -> float:
        return getattr(self.panel, self.role)


class SimulatedPowerMeter(SimulatedDevice):
    """Integrating sphere behind the first beam splitter; it averages nothing."""

    set_up = do_nothing

    @property
    def power(self) -> float:
        return self.instrument.laser_power(self.panel)


class SimulatedReadOut(SimulatedDevice):
    """Read-out: digital lines, mirrors on two registers, bursts, the trigger line."""

    watchdog = do_nothing
    rate = SAMPLE_RATE
    rig: Rig  # how it is wired
    triggered: SimulatedRf  # whose table the trigger line steps through

    def safe_state(self) -> None:
        for part in LIGHT:
            self.set_line(self.rig.line(part), False)
        self.write_many(dict.fromkeys(self.rig.mirrors, 0.0))

    def gain(self) -> Gain:
        return GAIN

    def line(self, dio: str) -> bool:
        return dio == self.rig.line("interlock") and self.panel.interlock_closed

    def set_line(self, dio: str, high: bool) -> None:
        for part, knob in (
            SWITCHES | {"flip_mirror": FLIPPED[self.rig.flip_mirror]}
        ).items():
            if self.rig.line(part) == dio:
                setattr(self.panel, knob, high)

    def write_many(self, values: Named) -> None:
        rig = self.rig
        panel = self.panel
        for axis, name in enumerate(rig.mirrors):
            if name in values:
                panel.galvo_volts[axis] = round(values[name] / TDAC_STEP) * TDAC_STEP
        if rig.flip_mirror == "photodiode":  # the target stands among the scene
            off = mirror_angles(rig, panel.galvo_volts)
            off -= np.deg2rad(rig.reference_direction_deg)
            panel.target_in_beam = bool(abs(off).max() < BESIDE)
        if (volts := values.get(rig.reference_mirror)) is not None:
            step = rig.reference_mirror_travel * DAC_STEP  # m
            panel.mirror_travel = step * round(volts / DAC_STEP)

    def configure_burst(
        self,
        *,
        channels: Sequence[str],
        rate: float,
        scans: int,
        pulse_line: str,
        pulse: int,
    ) -> None:
        self.quadratures = len(channels) > 1
        self.rate = rate
        self._pulses = np.arange(scans) // pulse

    def bursts(self, requests: Requests) -> Iterator[Counts]:
        panel = self.panel
        states = []
        for registers in requests:
            self.write_many(registers)
            label = registers["USER_RAM0_U32"]
            states.append([label, panel.mirror_travel, *panel.galvo_volts])
        labels, travels, *volts = np.transpose(states)
        labels = labels.astype(int)
        size = self._pulses.size
        asked = self.instrument, panel, labels
        if self.quadratures:
            every = quadratures(*asked, size, self.rate)
        elif panel.beam_block_out:
            every = fringes(*asked, travels, size, self.rate)
        else:
            every = self.instrument.bursts(  # all at once
                panel,
                mirror_angles(self.rig, np.transpose(volts)),
                labels=labels,
                pulses=self._pulses,
                rate=self.rate,
            )
        for label, counts in zip(labels, every, strict=True):
            panel.time = BURST_INTERVAL * label + size / self.rate
            self.triggered.edges += int(self._pulses[-1]) + 1
            yield counts


# Simulated device of each role.
KINDS = {
    "rf_emission": SimulatedRf,
    "rf_detection": SimulatedRf,
    "plate_emission": SimulatedMotor,
    "plate_detection": SimulatedMotor,
    "stage": SimulatedMotor,
    "daq": SimulatedReadOut,
    "clock": SimulatedClock,
    "power_meter": SimulatedPowerMeter,
}


def simulated_devices(instrument: SimulatedInstrument, rig: Rig) -> Fields:
    """Every device of an instrument by its role, wired as a rig has it."""
    panel = Panel()
    devices: Fields = {
        role: kind(panel, instrument, role) for role, kind in KINDS.items()
    }
    devices["daq"].rig = rig
    devices["daq"].triggered = devices["rf_detection"]
    return devices


def _round_to_codes(phases: ArrayLike) -> Array:
    """Phases as the drivers' codes hold them, rad in [0, 2 pi)."""
    return np.rint(np.multiply(phases, CODES) / TAU) % CODES * (TAU / CODES)
