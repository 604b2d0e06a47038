"""Instruments of a rig, real or simulated, and what a scan asks of them, each step checked."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial
from math import ceil, pi
from time import monotonic, sleep
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.constants import LASER_WAVELENGTH
from cmtof.hardware import apt, rf, scpi, t7
from cmtof.hardware.device import BadReply, InstrumentTimeout, Unsafe, insist, insist_on_all
from cmtof.hardware.plan import REFERENCE_BURSTS, Line, Plan, Record, settling_time
from cmtof.hardware.reduction import drive_phases, sums_from_counts
from cmtof.hardware.rig import DRIVERS, PLATE_DEGREES, DeviceSettings, GalvoSettings
from cmtof.hardware.rig import LineSettings, Rig
from cmtof.hardware.safety import EmergencyStop
from cmtof.instrument.devices import simulated_devices
from cmtof.instrument.world import World

SAFE_LEVELS = {"laser": False, "shutter": False, "beam_block": False}
"""Levels of the outputs when nobody speaks to the read-out: laser off, shutter shut, block in."""
CLOCK_FREQUENCY, CLOCK_AMPLITUDE = 10e6, 1.0
"""Clock that both RF drivers are locked to, Hz, and V peak to peak into 50 Ohm."""
LOCK_SHARE = 0.5
"""Share of the dead man's time that one RF driver may look for its resonance: the other waits."""
WATCHDOG = 30
"""Silence after which the read-out's own watchdog acts, s."""
POWER_READINGS = 10
"""Readings that the power meter averages, about 3 ms each."""
STAGE_SPEED = 2.4e-3
"""Speed of the target's stage, m/s (MTS50-Z8, largest)."""
BACKLASH = 1e-3
"""How far below a position the target turns round, m: it is always approached from below."""
ATTEMPTS = 3
"""How often a burst is taken, or a line begun, before lost bytes are an error."""
LINE_ATTEMPTS = 2
"""How often a line is taken before a missed edge is an error."""
DARK = 1.0
"""Stands for the laser power of a line without light, W: nothing is divided by it."""


class Galvo:
    """Scan mirrors, steered by an LJTick-DAC on the read-out; angles are optical, rad."""

    name = "galvo"

    def __init__(self, daq: Any, settings: GalvoSettings) -> None:
        self._daq, self._settings = daq, settings

    def registers(self, x: float, y: float) -> dict[str, float]:
        """Register writes that turn the beam; a ValueError beyond the limit."""
        volts = self._settings.volts([x, y]).tolist()
        return dict(zip((self._settings.x, self._settings.y), volts, strict=True))

    def move_to(self, x: float, y: float) -> None:
        """Turn the beam, and wait as long as the longest step takes."""
        self._daq.write_many(self.registers(x, y))
        if self._settings.settling:  # simulated mirrors have none
            sleep(settling_time(pi, self._settings.settling))

    def park(self) -> None:
        """Bring both mirrors to 0 V, where they also rest without power."""
        self._daq.write_many({self._settings.x: 0.0, self._settings.y: 0.0})

    def safe_state(self) -> None:
        """Park twice: the LJTick-DAC cannot be read back, so nobody sees a write that was lost."""
        insist(self.park)
        insist(self.park)


class Interlock:
    """Laser, shutter, flip mirror and beam block on the read-out's lines, and the interlock.

    All outputs are wired so that a low line, a cut cable or a read-out without power is safe. The
    interlock's loop of door contacts brings the T7's supply to its line, and a resistor of 10 kOhm
    pulls that line down against the T7's own pull-up of 100 kOhm (T-Series Datasheet, 13.0): an
    open door or a cut cable reads low.
    """

    name = "interlock"

    def __init__(self, daq: Any, lines: LineSettings) -> None:
        self._daq, self._lines = daq, lines

    def check(self) -> None:
        """Raise `Unsafe` when the interlock is open."""
        if not self._daq.line(self._lines.interlock):
            raise Unsafe(
                f"Expected the interlock at {self._lines.interlock} closed, got it open. "
                "Close doors and covers."
            )

    def switch(self, part: str, on: bool) -> None:
        """Switch the laser, open the shutter, put in the flip mirror or take out the beam block.

        Light comes on only with the interlock closed.
        """
        if on and part in ("laser", "shutter"):
            self.check()
        self._daq.set_line(getattr(self._lines, part), on)

    def safe_state(self) -> None:
        """Bring laser, shutter and block to their safe levels; each even if another fails."""
        insist_on_all([partial(self.switch, *level) for level in SAFE_LEVELS.items()])


class Instruments(EmergencyStop):
    """Connected instruments of a rig; as a context manager their emergency stop, and closed.

    The light is stopped first, then RF, then what moves.
    """

    rf_emission: Any
    rf_detection: Any
    plate_emission: Any
    plate_detection: Any
    stage: Any
    daq: Any
    clock: Any
    power_meter: Any

    def __init__(self, rig: Rig, devices: Mapping[str, Any]) -> None:
        vars(self).update(devices)
        self.galvo = Galvo(self.daq, rig.galvo)
        self.interlock = Interlock(self.daq, rig.lines)
        super().__init__([self.interlock, self.galvo, *(devices[role] for role in DRIVERS)])

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        try:
            super().__exit__(kind, error, trace)
        finally:
            for role in DRIVERS:
                getattr(getattr(self, role), "close", int)()


def open_instruments(rig: Rig) -> Instruments:
    """Connect to every device of a rig; use the result as a context manager.

    Raises
    ------
    ValueError
        If the rig lacks a device.
    InstrumentError
        If one cannot be reached; those that could are closed again.
    """
    if missing := DRIVERS.keys() - rig.devices.keys():
        raise ValueError(
            f"Expected a rig with {', '.join(DRIVERS)}, got none of "
            f"{', '.join(sorted(missing))}. Add them to `devices`."
        )
    devices: dict[str, Any] = {}
    try:
        for role, device in rig.devices.items():
            devices[role] = _opened(role.replace("_", " "), device, rig.lines)
    except BaseException:
        for device in devices.values():
            device.close()
        raise
    return Instruments(rig, devices)


def simulated(rig: Rig, scene: Any = None, *, seed: int = 0) -> Instruments:
    """Simulated instruments of a rig, in process, before a scene; ``daq.world`` is their light."""
    parts = {line: part for part, line in asdict(rig.lines).items()}
    world = World(rig.twin, scene, seed=seed)
    devices = simulated_devices(world, parts, (rig.galvo.x, rig.galvo.y))
    return Instruments(replace(rig, galvo=replace(rig.galvo, settling=0.0)), devices)


def _opened(name: str, settings: DeviceSettings, lines: LineSettings) -> Any:
    """Driver of a device, connected."""
    address = settings.address
    match settings.driver:
        case "labjack-t7":
            safe = {getattr(lines, part): level for part, level in SAFE_LEVELS.items()}
            stream = rf.open_serial(f"socket://{address.partition(':')[0]}:702")
            return t7.LabJackT7(t7.open_modbus(address), stream, name, safe)
        case "rf-driver":
            return rf.RfDriver(rf.open_serial(address), name)
        case "sdg2042x":
            return scpi.SignalGenerator(scpi.open_visa(address), name)
        case "pm100d":
            return scpi.PowerMeter(scpi.open_visa(address), name)
    kind = apt.MOTORS[settings.driver]
    if settings.counts_per_unit:
        kind = kind._replace(scale=settings.counts_per_unit)
    port = rf.open_serial(address, rtscts="://" not in address)
    return apt.Motor(port, kind, name, settings.serial_number)


class Bench:
    """Instruments of a rig as a scan uses them, each step with its checks."""

    def __init__(self, instruments: Instruments, rig: Rig) -> None:
        self.instruments, self.rig = instruments, rig
        self.rf = (instruments.rf_emission, instruments.rf_detection)
        self._fed = monotonic()
        self._edges = 0

    def set_up(self) -> None:
        """Bring everything but light and RF to where a scan begins."""
        held, detection = self.instruments, self.rig.detection
        self.shut()
        held.interlock.check()
        for motor in (held.plate_emission, held.plate_detection, held.stage):
            if not motor.homed:
                motor.home()
        held.daq.watchdog(WATCHDOG)  # homing takes longer than it allows
        held.daq.configure_burst(
            channel=detection.channel,
            rate=detection.rate,
            scans=detection.scans,
            range=detection.range,
            pulse_line=self.rig.lines.trigger,
            pulse=detection.samples_per_phase,
        )
        for channel in (1, 2):
            held.clock.sine(channel, frequency=CLOCK_FREQUENCY, amplitude=CLOCK_AMPLITUDE)
        held.clock.lock_phases()
        for channel in (1, 2):
            held.clock.output(channel, True)
        for one in self.rf:
            if one.status().tripped:  # a scan that was killed leaves it so
                one.clear_trip()
            one.output(False)
            one.set_dead_man(self.rig.drive.dead_man)
            one.set_power(self.rig.drive.power_dbm)
            one.set_phase(0.0)
            one.trigger(False)
        held.power_meter.wavelength = LASER_WAVELENGTH
        held.power_meter.averaging = POWER_READINGS
        held.power_meter.zero()
        held.interlock.switch("laser", True)

    def choose_mode(self, mode: str) -> None:
        """Turn both plates and run both modulators at the mode's frequency; the shutter is closed.

        RF is off while plates turn: that may take longer than the dead man's time.
        """
        self.shut()
        held, rig = self.instruments, self.rig
        for one in self.rf:
            one.output(False)
        held.plate_emission.move_to(_mount_angle(mode, rig.plates.zero_emission_deg))
        held.plate_detection.move_to(_mount_angle(mode, rig.plates.zero_detection_deg))
        for one in self.rf:
            one.set_frequency(rig.drive.frequency(mode))
            one.output(True, lock_timeout=LOCK_SHARE * rig.drive.dead_man)
            self.feed(at_once=True)
        held.rf_detection.load_table(drive_phases(rig.detection.phases, mode))
        held.rf_detection.trigger(True)
        self.feed(at_once=True)

    def shut(self) -> None:
        """Close the shutter and park the beam."""
        self.instruments.interlock.switch("shutter", False)
        self.instruments.galvo.park()

    def look_at(self, kind: str) -> None:
        """Send the beam to the "scan", to the "reference" target, or nowhere ("dark")."""
        if kind == "dark":
            self.shut()
            return
        self.instruments.interlock.switch("flip_mirror", kind == "reference")
        self.instruments.interlock.switch("beam_block", False)
        self.instruments.interlock.switch("shutter", True)

    def move_target(self, offset: float, *, first: bool) -> None:
        """Bring the reference target to an offset (m) from its zero, from below.

        The steps are so short that the dead man's timers are fed between them.
        """
        stage, goal = self.instruments.stage, self.rig.reference.stage_zero + offset
        step = STAGE_SPEED * self.rig.drive.dead_man / 3
        for end in [goal - BACKLASH, goal] if first else [goal]:
            for at in np.linspace(stage.position, end, ceil(abs(end - stage.position) / step) + 1):
                stage.move_to(float(at))
                self.feed()

    def begin_line(self) -> None:
        """Bring the phase table to its first entry; that may be sent twice, as nothing moves."""
        insist(self.instruments.rf_detection.arm, tries=ATTEMPTS)
        self._edges = 0

    def bursts(
        self, labels: Sequence[int], directions: ArrayLike | None = None
    ) -> NDArray[np.uint16]:
        """Counts (N, scans) of bursts by their labels; mirrors, label and start share one frame.

        ``directions`` (N, 2) are optical angles, rad; without them the mirrors stay. A burst whose
        samples were lost is taken again, ``ATTEMPTS`` times at most.
        """
        held, requests = self.instruments, [{"USER_RAM0_U32": float(label)} for label in labels]
        if directions is not None:
            aims = np.asarray(directions, float).tolist()
            held.galvo.move_to(*aims[0])  # from the end of the last line
            for request, aim in zip(requests, aims, strict=True):
                request.update(held.galvo.registers(*aim))
        taken: list[NDArray[np.uint16]] = []
        failures = 0
        while len(taken) < len(requests):
            try:
                for counts in held.daq.bursts(requests[len(taken) :]):
                    taken.append(counts)
                    self._edges += self.rig.detection.phases
                    failures = 0
                    self.feed()
            except (BadReply, InstrumentTimeout):
                failures += 1
                if failures == ATTEMPTS:
                    raise
                self.begin_line()  # nobody knows how many edges the broken burst sent
        return np.array(taken)

    def check(self) -> None:
        """Raise `Unsafe` if a modulator or the interlock has given way."""
        for one in self.rf:
            status = one.status()
            if status.tripped or not (status.on and status.locked):
                raise Unsafe(
                    f"Expected {one.name} on and locked at the end of a line, got {status}. "
                    "Wait until the crystal is warm, then go on with --resume."
                )
        self.instruments.interlock.check()

    def power(self) -> float:
        """Laser power behind the emission module, W."""
        power = float(self.instruments.power_meter.power)
        if not power > 0:
            raise Unsafe(f"Expected laser power above 0 W, got {power:g}. Check laser and shutter.")
        return power

    def feed(self, *, at_once: bool = False) -> None:
        """Keep the dead man's timers from running out while the scan is alive."""
        if at_once or monotonic() - self._fed > self.rig.drive.dead_man / 4:
            for one in self.rf:
                one.ping()
            self._fed = monotonic()

    def measure(self, plan: Plan, line: Line) -> Record:
        """Record of one line; it is begun again once when the phase table has missed an edge.

        The laser power is read at the end, on the clock of the last burst: so it is the same
        whether the line came after others or after a resume.
        """
        self.look_at(line.kind)
        for _ in range(LINE_ATTEMPTS):
            self.begin_line()
            if line.kind == "reference":
                parts = []
                for n, offset in enumerate(plan.sweep):
                    self.move_target(offset, first=n == 0)
                    parts.append(self.bursts(line.labels[n * REFERENCE_BURSTS :][:REFERENCE_BURSTS]))
                counts = np.concatenate(parts)
            else:
                aims = plan.angles[line.row] if line.kind == "scan" else None
                counts = self.bursts(line.labels, aims)
            self.check()
            if self.instruments.rf_detection.status().edges == self._edges:
                power = DARK if line.kind == "dark" else self.power()
                return Record(line.index, power, *sums_from_counts(counts, plan.kept))
        raise BadReply(
            f"Expected one edge a phase at the trigger of the phase table, got another number "
            f"{LINE_ATTEMPTS} times in line {line.index}. Check the trigger line."
        )


def _mount_angle(mode: str, zero: float) -> float:
    """Angle of a plate's mount in a mode, rad; ``zero`` is where theta_h is 0, degrees."""
    return float(np.deg2rad(PLATE_DEGREES[mode] + zero))
