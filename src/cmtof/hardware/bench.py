"""What a scan asks of the instruments, each step in its order and with its checks."""

from collections.abc import Sequence
from math import ceil
from time import monotonic
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.constants import LASER_WAVELENGTH
from cmtof.hardware.device import BadReply, InstrumentTimeout, Unsafe, insist
from cmtof.hardware.plan import REFERENCE_BURSTS, Line, Plan, Record
from cmtof.hardware.reduction import Sampling, drive_phases
from cmtof.hardware.rig import Instruments, Rig

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


class Bench:
    """Instruments of a rig as a scan uses them, each step with its checks."""

    def __init__(self, instruments: Instruments, rig: Rig, sampling: Sampling) -> None:
        self.instruments, self.rig, self.sampling = instruments, rig, sampling
        self.rf = (instruments.rf_emission, instruments.rf_detection)
        self._fed = monotonic()
        self._edges = 0

    def identities(self) -> dict[str, Any]:
        """What the devices call themselves, by role."""
        roles = ("rf_emission", "rf_detection", "clock", "daq", "power_meter")
        found = {role: getattr(self.instruments, role) for role in roles}
        return {role: one.identify() for role, one in found.items() if one is not None}

    def set_up(self) -> None:
        """Bring everything but light and RF to where a scan begins."""
        held, detection = self.instruments, self.rig.detection
        self.shut()
        held.interlock.check()
        for motor in (held.plate_emission, held.plate_detection, held.stage):
            if motor is not None and not motor.homed:
                motor.home()
        held.daq.watchdog(WATCHDOG)  # homing takes longer than it allows
        held.daq.configure_burst(
            channel=detection.channel,
            rate=detection.rate,
            scans=self.sampling.scans,
            range=detection.range,
            pulse_line=self.rig.lines.trigger,
            pulse=detection.samples_per_phase,
        )
        for channel in (1, 2):
            held.clock.sine(channel, frequency=CLOCK_FREQUENCY, amplitude=CLOCK_AMPLITUDE)
        held.clock.lock_phases()
        for channel in (1, 2):
            held.clock.output(channel, True)
        for rf in self.rf:
            if rf.status().tripped:  # a scan that was killed leaves it so
                rf.clear_trip()
            rf.output(False)
            rf.set_dead_man(self.rig.drive.dead_man)
            rf.set_power(self.rig.drive.power_dbm)
            rf.set_phase(0.0)
            rf.trigger(False)
        if held.power_meter is not None:
            held.power_meter.wavelength = LASER_WAVELENGTH
            held.power_meter.averaging = POWER_READINGS
            held.power_meter.zero()
        held.interlock.laser(True)

    def choose_mode(self, mode: str) -> None:
        """Turn both plates and run both modulators at the mode's frequency; the shutter is closed.

        RF is off while plates turn: that may take longer than the dead man's time.
        """
        self.shut()
        held, drive = self.instruments, self.rig.drive
        for rf in self.rf:
            rf.output(False)
        plates = (held.plate_emission, held.plate_detection)
        for plate, angle in zip(plates, self.rig.plates.mount_angles(mode), strict=True):
            plate.move_to(angle)
        for rf in self.rf:
            rf.set_frequency(drive.frequency(mode))
            rf.output(True, lock_timeout=LOCK_SHARE * drive.dead_man)
            self.feed(at_once=True)
        held.rf_detection.load_table(drive_phases(self.sampling.phases, mode))
        held.rf_detection.trigger(True)
        self.feed(at_once=True)

    def shut(self) -> None:
        """Close the shutter and park the beam."""
        self.instruments.interlock.shutter(False)
        self.instruments.galvo.park()

    def look_at(self, kind: str) -> None:
        """Send the beam to the "scene", to the "reference" target, or nowhere ("dark")."""
        interlock = self.instruments.interlock
        if kind == "dark":
            self.shut()
            return
        interlock.flip_mirror(kind == "reference")
        interlock.beam_block(True)
        interlock.shutter(True)

    def move_target(self, offset: float, *, first: bool) -> None:
        """Bring the reference target to an offset (m) from its zero, from below.

        The steps are so short that the dead man's timers are fed between them.
        """
        stage = self.instruments.stage
        if stage is None:
            return
        goal = self.rig.reference.stage_zero + offset
        step = STAGE_SPEED * self.rig.drive.dead_man / 3
        for end in ([goal - BACKLASH] if first else []) + [goal]:
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
                    self._edges += self.sampling.phases
                    failures = 0
                    self.feed()
            except (BadReply, InstrumentTimeout):
                failures += 1
                if failures == ATTEMPTS:
                    raise
                self.begin_line()  # nobody knows how many edges the broken burst sent
        return np.array(taken)

    def stepped(self) -> bool:
        """Whether the phase table was stepped once a phase since the line began."""
        return self.instruments.rf_detection.status().edges == self._edges

    def check(self) -> None:
        """Raise `Unsafe` if a modulator or the interlock has given way."""
        for rf in self.rf:
            status = rf.status()
            if status.tripped or not (status.on and status.locked):
                raise Unsafe(
                    f"Expected {rf.name} on and locked at the end of a line, got {status}. "
                    "Wait until the crystal is warm, then go on with --resume."
                )
        self.instruments.interlock.check()

    def power(self) -> float:
        """Laser power behind the emission module, W; 1 without a power meter."""
        meter = self.instruments.power_meter
        power = 1.0 if meter is None else float(meter.power)
        if not power > 0:
            raise Unsafe(f"Expected laser power above 0 W, got {power:g}. Check laser and shutter.")
        return power

    def feed(self, *, at_once: bool = False) -> None:
        """Keep the dead man's timers from running out while the scan is alive."""
        if at_once or monotonic() - self._fed > self.rig.drive.dead_man / 4:
            for rf in self.rf:
                rf.ping()
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
                    first = n * REFERENCE_BURSTS
                    parts.append(self.bursts(line.labels[first : first + REFERENCE_BURSTS]))
                counts = np.concatenate(parts)
            else:
                aims = plan.angles[line.row] if line.kind == "scan" else None
                counts = self.bursts(line.labels, aims)
            self.check()
            if self.stepped():
                power = DARK if line.kind == "dark" else self.power()
                return Record(line.index, power, *self.sampling.sums(counts))
        raise BadReply(
            f"Expected one edge a phase at the trigger of the phase table, got another number "
            f"{LINE_ATTEMPTS} times in line {line.index}. Check the trigger line."
        )
