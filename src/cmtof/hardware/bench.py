"""The bench: instruments of a rig, real or simulated, and the steps of a scan, each checked."""

from collections.abc import Mapping, Sequence
from contextlib import ExitStack, closing
from functools import partial
from math import ceil
from time import monotonic, sleep
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.constants import LASER_WAVELENGTH
from cmtof.hardware.device import BadReply, InstrumentTimeout, Unsafe, insist
from cmtof.hardware.plan import FULL_STEP, VOLTS_PER_RADIAN, Line, Plan, Record
from cmtof.hardware.reduction import drive_phases, sums_from_counts
from cmtof.hardware.rig import DRIVERS, LINES, MIRRORS, DeviceSettings, Rig
from cmtof.hardware.safety import EmergencyStop
from cmtof.instrument.devices import simulated_devices
from cmtof.instrument.world import World

LIGHT = ("laser", "shutter", "beam_block")  # low is safe: laser off, shutter shut, block in
CHANNEL, VOLTS_RANGE = "AIN0", 10.0  # input of the detector, V
CLOCK = {"frequency": 10e6, "amplitude": 1.0}  # of both RF drivers, Hz, V peak to peak
PLATES = {"single": 11.25, "doubled": 22.5}  # theta_h in the modes, degrees (Sec. 6.2)
LOCK_SHARE = 0.5  # of the dead man's time to look for a resonance: the other driver waits
WATCHDOG = 30  # s of silence after which the read-out's own watchdog acts
POWER_READINGS = 10  # averaged by the power meter, about 3 ms each
STAGE_SPEED = 2.4e-3  # of the target's stage, m/s (MTS50-Z8, largest)
BACKLASH = 1e-3  # how far below its first position the target turns round, m
ATTEMPTS = 3  # at a line before lost samples or a missed edge are an error


class Bench(EmergencyStop):
    """Instruments of a rig, by role; as a context manager their emergency stop, and closed.

    First it stops the light and parks the mirrors, then RF, then what moves. All lines are wired so
    that low, a cut cable or a read-out without power is safe; an open interlock reads low.
    ``flyback`` is how long the longest step of the mirrors takes, s. Angles are optical, rad.
    """

    name = "beam"

    def __init__(self, rig: Rig, devices: Mapping[str, Any], flyback: float = FULL_STEP[1]) -> None:
        self.rig, self.devices = rig, devices
        self.rf = (devices["rf_emission"], devices["rf_detection"])
        self._flyback, self._fed = flyback, monotonic()
        super().__init__([self, *(devices[role] for role in DRIVERS)])

    def __getattr__(self, role: str) -> Any:
        if role not in DRIVERS:
            raise AttributeError(role)
        return self.devices[role]

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        try:
            super().__exit__(kind, error, trace)
        finally:
            for device in self.devices.values():
                device.close()

    def safe_state(self) -> None:
        """Laser off, shutter shut, block in, mirrors parked; each even if another fails."""
        # parked twice: the mirrors cannot be read back, so nobody sees a write that was lost
        insist(*(partial(self.switch, part, False) for part in LIGHT), self.park, self.park)

    def switch(self, part: str, on: bool) -> None:
        """Switch one of `LINES` of the rig; light comes on only with the interlock closed."""
        if on and part in ("laser", "shutter"):
            self.check_interlock()
        self.daq.set_line(LINES[part], on)

    def check_interlock(self) -> None:
        """Raise `Unsafe` when the interlock is open."""
        if not self.daq.line(LINES["interlock"]):
            raise Unsafe(
                f"Expected the interlock at {LINES['interlock']} closed, got it open. "
                "Close doors and covers."
            )

    def park(self) -> None:
        """Bring both mirrors to 0 V."""
        self.daq.write_many(dict.fromkeys(MIRRORS, 0.0))

    def set_up(self) -> None:
        """Bring everything but light and RF to where a scan begins."""
        rig = self.rig
        self.safe_state()
        self.check_interlock()
        for motor in (self.plate_emission, self.plate_detection, self.stage):
            if not motor.homed:
                motor.home()
        self.daq.watchdog(WATCHDOG)  # homing takes longer than it allows
        self.daq.configure_burst(
            channel=CHANNEL,
            rate=rig.rate,
            scans=rig.scans,
            range=VOLTS_RANGE,
            pulse_line=LINES["trigger"],
            pulse=rig.samples_per_phase,
        )
        for channel in (1, 2):
            self.clock.sine(channel, **CLOCK)
        self.clock.lock_phases()
        for channel in (1, 2):
            self.clock.output(channel, True)
        for rf in self.rf:
            if rf.status().tripped:  # a scan that was killed leaves it so
                rf.clear_trip()
            rf.output(False)
            rf.set_dead_man(rig.dead_man)
            rf.set_power(rig.power_dbm)
            rf.set_phase(0.0)
            rf.trigger(False)
        self.power_meter.set_up(wavelength=LASER_WAVELENGTH, readings=POWER_READINGS)
        self.switch("laser", True)

    def choose_mode(self, mode: str) -> None:
        """Turn both plates and run both modulators as a mode wants it; the shutter is closed."""
        self.shut()
        rig = self.rig
        for rf in self.rf:
            rf.output(False)  # plates may take longer than the dead man's time
        self.plate_emission.move_to(float(np.deg2rad(PLATES[mode] + rig.plate_zero_emission_deg)))
        self.plate_detection.move_to(float(np.deg2rad(PLATES[mode] + rig.plate_zero_detection_deg)))
        for rf in self.rf:
            rf.set_frequency(rig.drive_frequency(mode))
            rf.output(True, lock_timeout=LOCK_SHARE * rig.dead_man)
            self.feed(at_once=True)
        self.rf_detection.load_table(drive_phases(rig.phases, mode))
        self.rf_detection.trigger(True)
        self.feed(at_once=True)

    def shut(self) -> None:
        """Close the shutter and park the beam."""
        self.switch("shutter", False)
        self.park()

    def look_at(self, kind: str) -> None:
        """Send the beam to the "scan", to the "reference" target, or nowhere ("dark")."""
        self.switch("flip_mirror", kind == "reference")
        self.switch("shutter", kind != "dark")

    def move_target(self, offset: float) -> None:
        """Bring the reference target to an offset (m) from its zero, always from below."""
        # in steps so short that the dead man's timers are fed between them
        goal, step = self.rig.stage_zero + offset, STAGE_SPEED * self.rig.dead_man / 3
        below = [goal - BACKLASH] if self.stage.position > goal - BACKLASH else []
        for end in [*below, goal]:
            start = self.stage.position
            for at in np.linspace(start, end, ceil(abs(end - start) / step) + 1):
                self.stage.move_to(float(at))
                self.feed()

    def bursts(
        self, labels: Sequence[int], directions: ArrayLike | None = None
    ) -> NDArray[np.uint16]:
        """Counts (N, scans) of bursts by their labels; mirrors, label and start share one frame.

        ``directions`` (N, 2) are optical angles, rad; without them the mirrors stay. The phase
        table begins anew, and a `BadReply` says that it was not stepped once a phase.
        """
        requests = [{"USER_RAM0_U32": float(label)} for label in labels]
        if directions is not None:
            for request, aim in zip(requests, np.asarray(directions, float).tolist(), strict=True):
                request.update(registers(*aim))
            self.daq.write_many({name: requests[0][name] for name in MIRRORS})
            sleep(self._flyback)  # from the end of the last line
        insist(self.rf_detection.arm, tries=ATTEMPTS)  # may be sent twice, as nothing moves
        counts = []
        for burst in self.daq.bursts(requests):
            counts.append(burst)
            self.feed()
        edges = self.rf_detection.status().edges
        if edges != (wanted := len(counts) * self.rig.phases):
            raise BadReply(
                f"Expected {wanted} edges at the trigger of the phase table, got {edges}. "
                "Check the trigger line."
            )
        return np.array(counts)

    def check(self) -> None:
        """Raise `Unsafe` if a modulator or the interlock has given way."""
        for rf in self.rf:
            status = rf.status()
            if status.tripped or not (status.on and status.locked):
                raise Unsafe(
                    f"Expected {rf.name} on and locked at the end of a line, got {status}. "
                    "Wait until the crystal is warm, then go on with --resume."
                )
        self.check_interlock()

    def power(self) -> float:
        """Laser power behind the emission module, W."""
        power = float(self.power_meter.power)
        if not power > 0:
            raise Unsafe(f"Expected laser power above 0 W, got {power:g}. Check laser and shutter.")
        return power

    def feed(self, *, at_once: bool = False) -> None:
        """Keep the dead man's timers from running out while the scan is alive."""
        if at_once or monotonic() - self._fed > self.rig.dead_man / 4:
            for rf in self.rf:
                rf.ping()
            self._fed = monotonic()

    def measure(self, plan: Plan, line: Line) -> Record:
        """Record of one line; its bursts are taken again when samples or an edge were lost.

        The laser power is read at the end, on the clock of the last burst: so it is the same
        whether the line came after others or after a resume.
        """
        self.look_at(line.kind)
        if line.kind == "reference":
            self.move_target(plan.sweep[line.row])
        aims = plan.angles[line.row] if line.kind == "scan" else None
        for attempt in range(ATTEMPTS):
            try:
                counts = self.bursts(line.labels, aims)
                break
            except (BadReply, InstrumentTimeout):
                if attempt == ATTEMPTS - 1:
                    raise
        self.check()
        power = 1.0 if line.kind == "dark" else self.power()
        return Record(line.index, power, *sums_from_counts(counts, plan.kept))


def registers(x: float, y: float) -> dict[str, float]:
    """Register writes that turn the mirrors to optical angles, rad; a ValueError beyond 10 V."""
    volts = [round(VOLTS_PER_RADIAN * angle, 6) for angle in (x, y)]
    if not all(abs(value) <= 10 for value in volts):  # a comparison that NaN fails
        raise ValueError(f"Expected mirrors within 10 V, got {volts}. Turn them less.")
    return dict(zip(MIRRORS, volts, strict=True))


def opened(rig: Rig) -> Bench:
    """Bench of a rig's real devices, connected; use it as a context manager.

    Raises `InstrumentError` if one cannot be reached; those that could are closed again.
    """
    devices: dict[str, Any] = {}
    with ExitStack() as reached:
        for role, device in rig.devices.items():
            devices[role] = reached.enter_context(closing(driver(role.replace("_", " "), device)))
        reached.pop_all()
    return Bench(rig, devices)


def simulated(rig: Rig, scene: Any = None, *, seed: int = 0) -> Bench:
    """Bench of simulated devices, in process, before a scene; ``daq.world`` is their light."""
    world = World(rig.twin, scene, seed=seed)
    parts = {line: part for part, line in LINES.items()}
    return Bench(rig, simulated_devices(world, parts, MIRRORS), flyback=0.0)


def driver(name: str, device: DeviceSettings) -> Any:
    """Driver of a device, connected."""
    from cmtof.hardware import apt, rf, scpi, t7

    address = device.address
    match device.driver:
        case "labjack-t7":
            stream = rf.open_serial(f"socket://{address.partition(':')[0]}:702")
            safe = [LINES[part] for part in LIGHT]
            return t7.LabJackT7(t7.open_modbus(address), stream, name, safe)
        case "rf-driver":
            return rf.RfDriver(rf.open_serial(address), name)
        case "sdg2042x":
            return scpi.SignalGenerator(scpi.open_visa(address), name)
        case "pm100d":
            return scpi.PowerMeter(scpi.open_visa(address), name)
    kind = apt.MOTORS[device.driver]
    if device.counts_per_unit:
        kind = kind._replace(scale=device.counts_per_unit)
    port = rf.open_serial(address, rtscts="://" not in address)
    return apt.Motor(port, kind, name, device.serial_number)
