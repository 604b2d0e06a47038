"""Simulated devices of the instrument, in process: the interfaces of `cmtof.hardware`'s drivers.

They share one `Panel`, whose knobs the `World` reads. Nothing waits: a move or a lock is over when
the call returns, and the only clock is the number of a burst.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cmtof.instrument.electronics import CENTRE, SLOPE
from cmtof.instrument.light import CODES, Panel, RfKnobs
from cmtof.instrument.world import LABEL_TIME, World

TDAC_STEP = 20.0 / 2**14
"""Step of the LJTick-DAC, 14 bit, V."""


class Lock(NamedTuple):
    """Frequency lock: detuning from the resonance, Hz; reflected power, dBm."""

    locked: bool
    detuning: float
    reflected: float


class Status(NamedTuple):
    """Whether RF is on and locked, entry that plays, edges since arming, whether RF tripped."""

    on: bool
    locked: bool
    index: int
    edges: int
    tripped: bool


class SimulatedDevice:
    """A device with a name; ``identify`` marks it as simulated."""

    MODEL = ""

    def __init__(self, panel: Panel, world: World, name: str) -> None:
        self.panel, self.world, self.name = panel, world, name

    def identify(self) -> dict[str, str]:
        """Model, and a serial number that says what it is."""
        return {"model": self.MODEL, "serial_number": f"TWIN-{self.name}"}

    def nothing(self, *values: float, **options: float) -> None:
        """Nothing: what takes its time or can fail on a real device does not here."""

    safe_state = nothing


class SimulatedRf(SimulatedDevice):
    """RF driver of the emission or the detection."""

    MODEL = "CMTOF-RF"
    edges = 0
    set_dead_man = clear_trip = ping = SimulatedDevice.nothing

    @property
    def knobs(self) -> RfKnobs:
        """Knobs of this driver."""
        return self.panel.detection if "detection" in self.name else self.panel.emission

    def set_frequency(self, hz: float) -> None:
        """Set the frequency, whole Hz."""
        self.knobs.frequency = float(round(hz))

    def set_power(self, dbm: float) -> None:
        """Set the power, dBm."""
        self.knobs.power = float(dbm)

    def set_phase(self, rad: float) -> float:
        """Set the phase outside the table; return what was set, rad."""
        self.knobs.phase = float(_coded(np.array(rad)))
        return self.knobs.phase

    def output(self, on: bool, *, lock_timeout: float = 0.0) -> None:
        """Switch RF."""
        self.knobs.on = on

    def lock(self) -> Lock:
        """Lock: on, clocked and within its range; reflection of a matched resonance."""
        drive, knobs = self.world.settings.drive, self.knobs
        detuning = knobs.frequency - drive.resonance
        ratio = (2 * detuning / drive.width) ** 2
        reflected = knobs.power + 10 * np.log10(ratio / (1 + ratio) + 1e-3)  # no match is ideal
        locked = knobs.on and self.panel.clock_on and abs(detuning) <= drive.lock_range
        return Lock(bool(locked), detuning, float(reflected) if knobs.on else -np.inf)

    def status(self) -> Status:
        """Output, lock, table and trip."""
        last = (self.edges - 1) % max(len(self.knobs.table), 1)
        return Status(self.knobs.on, self.lock().locked, last, self.edges, False)

    def load_table(self, phases: NDArray[np.float64]) -> None:
        """Load phases of the drive, rad, that the trigger steps through."""
        self.knobs.table = _coded(np.asarray(phases, float))

    def trigger(self, on: bool) -> None:
        """Let edges step the table, or not."""
        if not on:
            self.knobs.table = np.zeros(0)

    def arm(self) -> None:
        """Count no edges yet."""
        self.edges = 0

    def safe_state(self) -> None:
        """Turn RF off."""
        self.knobs.on = False


class SimulatedClock(SimulatedDevice):
    """Function generator that both RF drivers are locked to."""

    MODEL = "SDG2042X"
    sine = lock_phases = SimulatedDevice.nothing

    def output(self, channel: int, on: bool) -> None:
        """Switch the clock."""
        self.panel.clock_on = on

    def safe_state(self) -> None:
        """Switch the clock off."""
        self.panel.clock_on = False


class SimulatedMotor(SimulatedDevice):
    """Rotation mount of a half-wave plate, rad, or the target's stage, m."""

    MODEL, homed = "APT", False

    def home(self, timeout: float = 0.0) -> None:
        """Find the home position."""
        self.homed = True
        self.move_to(0.0)

    def move_to(self, position: float) -> float:
        """Move to a position; return it."""
        if "plate" in self.name:
            self.panel.plate_angle["detection" in self.name] = float(position)
        else:
            self.panel.stage_position = float(position)
        return self.position

    @property
    def position(self) -> float:
        """Position, m or rad."""
        if "plate" in self.name:
            return self.panel.plate_angle["detection" in self.name]
        return self.panel.stage_position


class SimulatedPowerMeter(SimulatedDevice):
    """Integrating sphere behind the first beam splitter; it averages nothing."""

    MODEL, wavelength, averaging = "PM100D", 0.0, 1
    zero = SimulatedDevice.nothing

    @property
    def power(self) -> float:
        """Power, W."""
        return self.world.laser_power(self.panel)


class SimulatedReadOut(SimulatedDevice):
    """Read-out: digital lines by ``roles``, mirrors on two registers, bursts, the trigger line."""

    MODEL = "T7"
    watchdog = SimulatedDevice.nothing

    def __init__(
        self,
        panel: Panel,
        world: World,
        roles: Mapping[str, str],
        mirrors: tuple[str, str],
        triggered: SimulatedRf,
    ) -> None:
        super().__init__(panel, world, "daq")
        self._roles, self._mirrors, self._triggered = roles, mirrors, triggered
        self._burst: dict[str, Any] = {}

    def gain(self, volts_range: float) -> tuple[float, float, float]:
        """Nominal slopes, V per count, and count of 0 V."""
        slope = SLOPE * volts_range / 10
        return slope, -slope, CENTRE

    def line(self, dio: str) -> bool:
        """Level of a digital line; the interlock's is high while it is closed."""
        return self._roles[dio] == "interlock" and self.panel.interlock_closed

    def set_line(self, dio: str, high: bool) -> None:
        """Set a digital line, and with it what hangs on it."""
        role = self._roles[dio]
        if role == "beam_block":
            self.panel.beam_block_in = not high
        knobs = {"laser": "laser_on", "shutter": "shutter_open", "flip_mirror": "flip_mirror_in"}
        if role in knobs:
            setattr(self.panel, knobs[role], high)

    def write_many(self, values: Mapping[str, float]) -> None:
        """Write registers: those of the mirrors count."""
        for axis, name in enumerate(self._mirrors):
            if name in values:
                self.panel.galvo_volts[axis] = round(values[name] / TDAC_STEP) * TDAC_STEP

    def configure_burst(
        self, *, channel: str, rate: float, scans: int, range: float, pulse_line: str, pulse: int
    ) -> None:
        """Set up bursts; ``channel`` is the detector's."""
        edges = np.arange(scans) // pulse
        self._burst = {"scans": scans, "rate": rate, "volts_range": range, "pulses": edges}

    def bursts(self, requests: Iterable[Mapping[str, float]]) -> Iterator[NDArray[np.uint16]]:
        """Counts (scans,) of a burst for each request, all computed at once."""
        angles, labels = [], []
        for registers in requests:
            self.write_many(registers)
            angles.append(self.world.angles(self.panel))
            labels.append(int(registers["USER_RAM0_U32"]))
        counts = self.world.bursts(self.panel, angles, labels=labels, **self._burst)
        steps = int(self._burst["pulses"][-1]) + 1
        for label, one in zip(labels, counts, strict=True):
            self.panel.time = LABEL_TIME * label + self._burst["scans"] / self._burst["rate"]
            self._triggered.edges += steps
            yield one


def simulated_devices(
    world: World, roles: Mapping[str, str], mirrors: tuple[str, str]
) -> dict[str, Any]:
    """Every device by role; ``roles`` of the read-out's lines, and the mirrors' registers."""
    panel = Panel()
    detection = SimulatedRf(panel, world, "rf detection")
    return {
        "rf_emission": SimulatedRf(panel, world, "rf emission"),
        "rf_detection": detection,
        "clock": SimulatedClock(panel, world, "clock"),
        "daq": SimulatedReadOut(panel, world, roles, mirrors, detection),
        "plate_emission": SimulatedMotor(panel, world, "plate emission"),
        "plate_detection": SimulatedMotor(panel, world, "plate detection"),
        "stage": SimulatedMotor(panel, world, "stage"),
        "power_meter": SimulatedPowerMeter(panel, world, "power meter"),
    }


def _coded(phases: NDArray[np.float64]) -> NDArray[np.float64]:
    """Phases as the drivers' codes hold them, rad in [0, 2 pi)."""
    return np.rint(phases * CODES / (2 * np.pi)) % CODES * (2 * np.pi / CODES)
