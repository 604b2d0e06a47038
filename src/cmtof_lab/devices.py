"""Simulated devices of the instrument, in process: the interfaces of `cmtof.hardware`'s drivers.

They share one `Panel`, whose knobs the `World` reads. Nothing waits, and the only clock is the
number of a burst. Methods are documented at the drivers of the same names.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof_lab.electronics import CENTRE, SLOPE
from cmtof_lab.world import CODES, LABEL_TIME, Panel, RfKnobs, World

TDAC_STEP = 20.0 / 2**14  # Step of the LJTick-DAC, 14 bit, V
VOLTS_PER_DEGREE = 0.5  # GVS012, per mechanical degree, half an optical one (its manual)
# Knobs of the panel that follow a digital line
SWITCHES = {"laser": "laser_on", "shutter": "shutter_open"}
SWITCHES |= {"flip_mirror": "flip_mirror_in", "beam_block": "beam_block_out"}


class Status(NamedTuple):
    """Whether RF is on and locked, entry that plays, edges since arming, whether RF tripped."""

    on: bool
    locked: bool
    index: int
    edges: int
    tripped: bool


class SimulatedDevice:
    """A device by its role; ``identify`` marks it as simulated."""

    def __init__(self, panel: Panel, world: World, role: str) -> None:
        self.panel, self.world, self.role = panel, world, role
        self.name = role.replace("_", " ")

    def identify(self) -> dict[str, str]:
        return {"model": type(self).__name__, "serial_number": f"TWIN-{self.name}"}

    def nothing(self, *values: float, **options: float) -> None:
        """No operation: on a real device it takes time or may fail."""

    safe_state = close = nothing


class SimulatedRf(SimulatedDevice):
    """RF driver of the emission or the detection."""

    edges = 0
    set_dead_man = clear_trip = ping = SimulatedDevice.nothing

    @property
    def knobs(self) -> RfKnobs:
        return getattr(self.panel, self.role.removeprefix("rf_"))

    def set_frequency(self, hz: float) -> None:
        self.knobs.frequency = float(round(hz))

    def set_power(self, dbm: float) -> None:
        self.knobs.power = float(dbm)

    def set_phase(self, rad: float) -> float:
        self.knobs.phase = float(_coded(rad))
        return self.knobs.phase

    def output(self, on: bool, *, lock_timeout: float = 0.0) -> None:
        self.knobs.on = on

    def status(self) -> Status:
        on, last = self.knobs.on, (self.edges - 1) % max(len(self.knobs.table), 1)
        return Status(on, on and self.panel.clock_on, last, self.edges, False)

    def load_table(self, phases: NDArray[np.float64]) -> None:
        self.knobs.table = _coded(phases)

    def trigger(self, on: bool) -> None:
        if not on:
            self.knobs.table = np.zeros(0)

    def arm(self) -> None:
        self.edges = 0

    def safe_state(self) -> None:
        self.knobs.on = False


class SimulatedClock(SimulatedDevice):
    """Function generator that both RF drivers are locked to."""

    sine = lock_phases = SimulatedDevice.nothing

    def output(self, channel: int, on: bool) -> None:
        self.panel.clock_on = on

    def safe_state(self) -> None:
        self.panel.clock_on = False


class SimulatedMotor(SimulatedDevice):
    """Rotation mount of a half-wave plate, rad, or the target's stage, m."""

    homed = False

    def home(self) -> None:
        self.homed = True
        self.move_to(0.0)

    def move_to(self, position: float) -> float:
        setattr(self.panel, self.role, float(position))
        return self.position

    @property
    def position(self) -> float:
        return getattr(self.panel, self.role)


class SimulatedPowerMeter(SimulatedDevice):
    """Integrating sphere behind the first beam splitter; it averages nothing."""

    set_up = SimulatedDevice.nothing

    @property
    def power(self) -> float:
        return self.world.laser_power(self.panel)


class SimulatedReadOut(SimulatedDevice):
    """Read-out: digital lines by ``roles``, mirrors on two registers, bursts, the trigger line."""

    watchdog = SimulatedDevice.nothing
    roles: Mapping[str, str]
    mirrors: tuple[str, str]
    triggered: SimulatedRf

    def gain(self, volts_range: float) -> tuple[float, float, float]:
        return SLOPE, -SLOPE, CENTRE  # of 10 V, whatever was asked

    def line(self, dio: str) -> bool:
        return self.roles[dio] == "interlock" and self.panel.interlock_closed

    def set_line(self, dio: str, high: bool) -> None:
        if knob := SWITCHES.get(self.roles[dio]):
            setattr(self.panel, knob, high)

    def write_many(self, values: Mapping[str, float]) -> None:
        for axis, name in enumerate(self.mirrors):
            if name in values:
                self.panel.galvo_volts[axis] = round(values[name] / TDAC_STEP) * TDAC_STEP

    def configure_burst(
        self, *, channel: str, rate: float, scans: int, range: float, pulse_line: str, pulse: int
    ) -> None:
        self._burst = {"rate": rate, "pulses": np.arange(scans) // pulse}

    def bursts(self, requests: Iterable[Mapping[str, float]]) -> Iterator[NDArray[np.uint16]]:
        angles, labels = [], []  # all are computed at once
        for registers in requests:
            self.write_many(registers)
            angles.append(np.deg2rad(2 * np.array(self.panel.galvo_volts) / VOLTS_PER_DEGREE))
            labels.append(int(registers["USER_RAM0_U32"]))
        counts = self.world.bursts(self.panel, angles, labels=labels, **self._burst)
        for label, one in zip(labels, counts, strict=True):
            self.panel.time = LABEL_TIME * label + one.size / self._burst["rate"]
            self.triggered.edges += int(self._burst["pulses"][-1]) + 1
            yield one


def simulated_devices(
    world: World, roles: Mapping[str, str], mirrors: tuple[str, str]
) -> dict[str, Any]:
    """Every device by role; ``roles`` of the read-out's lines, and the mirrors' registers."""
    panel, motors = Panel(), ("plate_emission", "plate_detection", "stage")
    kinds = dict.fromkeys(("rf_emission", "rf_detection"), SimulatedRf)
    kinds |= {"clock": SimulatedClock, "daq": SimulatedReadOut, "power_meter": SimulatedPowerMeter}
    kinds |= dict.fromkeys(motors, SimulatedMotor)
    devices: dict[str, Any] = {role: kind(panel, world, role) for role, kind in kinds.items()}
    daq = devices["daq"]
    daq.roles, daq.mirrors, daq.triggered = roles, mirrors, devices["rf_detection"]
    return devices


def _coded(phases: Any) -> NDArray[np.float64]:
    """Phases as the drivers' codes hold them, rad in [0, 2 pi)."""
    return np.rint(np.asarray(phases) * CODES / (2 * np.pi)) % CODES * (2 * np.pi / CODES)
