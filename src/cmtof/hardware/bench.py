"""The bench: devices of a rig by their roles, and the steps of a scan, each checked."""

from collections.abc import Mapping, Sequence
from functools import partial
from math import ceil
from time import monotonic, sleep
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.constants import LASER_WAVELENGTH
from cmtof.hardware.device import BadReply, InstrumentTimeout, Unsafe, insist
from cmtof.hardware.plan import SETTLING, VOLTS_PER_RADIAN, Line, Plan, Record
from cmtof.hardware.reduction import drive_phases, sums_from_counts
from cmtof.hardware.rig import LINES, MIRRORS, PLATES, Rig
from cmtof.hardware.roles import ROLES, ClockRole, MotorRole, PowerMeterRole, ReadOutRole, RfRole
from cmtof.hardware.safety import EmergencyStop

LIGHT = ("laser", "shutter", "beam_block")  # low is safe: laser off, shutter shut, block in
CHANNEL, VOLTS_RANGE = "AIN0", 10.0  # input of the detector, V
STAGE_SPEED = 2.4e-3  # of the target's stage, m/s (MTS50-Z8, largest)
ATTEMPTS = 3  # at a line before lost samples or a missed edge are an error


class Bench(EmergencyStop):
    """Instruments of a rig, by role; as a context manager their emergency stop.

    First it stops the light and parks the mirrors, then RF, then what moves. All lines are wired so
    that low, a cut cable or a read-out without power is safe; an open interlock reads low.
    ``flyback`` is how long the longest step of the mirrors takes, s; ``about`` goes into the file.
    """

    name = "beam"

    def __init__(
        self, rig: Rig, devices: Mapping[str, Any], flyback: float = SETTLING[1], **about: Any
    ) -> None:
        self.rig = rig
        self.devices = devices
        self.about = about
        self.rf_emission: RfRole = devices["rf_emission"]
        self.rf_detection: RfRole = devices["rf_detection"]
        self.rf = (self.rf_emission, self.rf_detection)
        self.plate_emission: MotorRole = devices["plate_emission"]
        self.plate_detection: MotorRole = devices["plate_detection"]
        self.stage: MotorRole = devices["stage"]
        self.daq: ReadOutRole = devices["daq"]
        self.clock: ClockRole = devices["clock"]
        self.power_meter: PowerMeterRole = devices["power_meter"]
        self._flyback = flyback
        self._fed = monotonic()
        super().__init__([self, *(devices[role] for role in ROLES)])

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
            raise Unsafe("Expected the interlock closed, got it open. Close doors and covers.")

    def park(self) -> None:
        """Bring both mirrors to 0 V."""
        self.daq.write_many(dict.fromkeys(MIRRORS, 0.0))

    def set_up(self) -> None:
        """Set up everything but light and RF for a scan."""
        rig = self.rig
        self.safe_state()
        self.check_interlock()
        for motor in (self.plate_emission, self.plate_detection, self.stage):
            if not motor.homed:
                motor.home()
        self.daq.watchdog(30)  # s of silence; homing takes longer
        self.daq.configure_burst(
            channel=CHANNEL,
            rate=rig.rate,
            scans=rig.scans,
            range=VOLTS_RANGE,
            pulse_line=LINES["trigger"],
            pulse=rig.samples_per_phase,
        )
        for channel in (1, 2):
            self.clock.sine(channel, frequency=10e6, amplitude=1.0)  # Hz, V peak to peak
        self.clock.lock_phases()
        for channel in (1, 2):
            self.clock.output(channel, True)
        for rf in self.rf:
            rf.clear_trip()  # a scan that was killed leaves it so
            rf.output(False)
            rf.set_dead_man(rig.dead_man)
            rf.set_power(rig.power_dbm)
            rf.set_phase(0.0)
            rf.trigger(False)
        self.power_meter.set_up(wavelength=LASER_WAVELENGTH, readings=10)  # about 3 ms each
        self.switch("laser", True)

    def choose_mode(self, mode: str) -> None:
        """Turn both plates and run both modulators as a mode requires; the shutter is closed."""
        self.shut()
        rig = self.rig
        for rf in self.rf:
            rf.output(False)  # plates may take longer than the dead man's time
        self.plate_emission.move_to(float(np.deg2rad(PLATES[mode] + rig.plate_zero_emission_deg)))
        self.plate_detection.move_to(float(np.deg2rad(PLATES[mode] + rig.plate_zero_detection_deg)))
        for rf in self.rf:
            rf.set_frequency(rig.drive_frequency(mode))
            rf.output(True, lock_timeout=rig.dead_man / 2)  # the other driver waits
            self.feed()
        self.rf_detection.load_table(drive_phases(rig.phases, mode))
        self.rf_detection.trigger(True)

    def shut(self) -> None:
        """Close the shutter and park the beam."""
        self.switch("shutter", False)
        self.park()

    def look_at(self, kind: str) -> None:
        """Send the beam to the "scan", to the "reference" target, or nowhere ("dark")."""
        self.switch("flip_mirror", kind == "reference")
        self.switch("shutter", kind != "dark")

    def move_target(self, offset: float) -> None:
        """Bring the target to an offset (m) from below, in steps with the timers fed between."""
        goal, step = self.rig.stage_zero + offset, STAGE_SPEED * self.rig.dead_man / 3
        for end in (goal - 1e-3, goal):
            start = self.stage.position
            for at in np.linspace(start, end, ceil(abs(end - start) / step) + 1):
                self.stage.move_to(float(at))
                self.feed()

    def bursts(
        self, labels: Sequence[int], directions: ArrayLike | None = None
    ) -> NDArray[np.uint16]:
        """Counts (N, scans) of bursts by their labels; mirrors, label and start share one frame.

        ``directions`` (N, 2) are optical angles, rad; without them the mirrors stay. The phase
        table begins again, and a `BadReply` says that it was not stepped once a phase.
        """
        requests = [{"USER_RAM0_U32": float(label)} for label in labels]
        if directions is not None:
            volts = np.round(VOLTS_PER_RADIAN * np.asarray(directions, float), 6).tolist()
            for request, pair in zip(requests, volts, strict=True):
                request.update(zip(MIRRORS, pair, strict=True))
            self.daq.write_many({name: requests[0][name] for name in MIRRORS})
            sleep(self._flyback)  # from the end of the last line
        insist(self.rf_detection.arm, tries=ATTEMPTS)  # may be sent twice, as nothing moves
        counts = []
        for burst in self.daq.bursts(requests):
            counts.append(burst)
            self.feed()
        edges = self.rf_detection.status().edges
        if edges != (wanted := len(counts) * self.rig.phases):
            raise BadReply(f"Expected {wanted} trigger edges, got {edges}. Check the trigger line.")
        return np.array(counts)

    def check(self) -> None:
        """Raise `Unsafe` if a modulator or the interlock has given way."""
        for rf in self.rf:
            status = rf.status()
            if status.tripped or not (status.on and status.locked):
                raise Unsafe(f"Expected {rf.name} on and locked, got {status}. Let it warm up.")
        self.check_interlock()

    def feed(self) -> None:
        """Keep the dead man's timers from running out while the scan is alive."""
        if monotonic() - self._fed > self.rig.dead_man / 4:
            for rf in self.rf:
                rf.ping()
            self._fed = monotonic()

    def measure(self, plan: Plan, line: Line, attempts: int = ATTEMPTS) -> Record:
        """Record of one line, which is begun again when samples or an edge were lost."""
        self.look_at(line.kind)
        if line.kind == "reference":
            self.move_target(plan.sweep[line.row])
        aims = plan.angles[line.row] if line.kind == "scan" else None
        try:
            counts = self.bursts(line.labels, aims)
        except (BadReply, InstrumentTimeout):
            if attempts == 1:
                raise
            return self.measure(plan, line, attempts - 1)
        self.check()
        # on the clock of the last burst: so it is the same after other lines and after a resume
        power = 1.0 if line.kind == "dark" else float(self.power_meter.power)
        if not power > 0:
            raise Unsafe(f"Expected laser power above 0 W, got {power:g}. Check laser and shutter.")
        return Record(line.index, power, *sums_from_counts(counts, plan.kept))
