"""What a scan asks of the instruments, each question in its order and with its checks."""

from dataclasses import asdict, is_dataclass
from enum import IntFlag
from time import monotonic
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.constants import LASER_WAVELENGTH
from cmtof.hardware.codecs.apt import Status
from cmtof.hardware.errors import BadReply, ConnectionLost, InstrumentTimeout, Unsafe
from cmtof.hardware.plan import Kind
from cmtof.hardware.reduction import Sampling, drive_phases
from cmtof.hardware.rig_settings import RigSettings

CLOCK_FREQUENCY = 10e6
"""Clock that both RF drivers are locked to, Hz."""

CLOCK_AMPLITUDE = 1.0
"""Of the clock into its load, V peak to peak."""

CLOCK_LOAD = 50.0
"""Input of the RF drivers, ohm."""

LOCK_SHARE = 0.5
"""Share of the dead man's time that one RF driver may look for its resonance: the other waits."""

WATCHDOG = 30.0
"""Silence after which the read-out's own watchdog acts, s."""

POWER_READINGS = 10
"""Readings that the power meter averages, about 3 ms each."""

STAGE_SPEED = 2.4e-3
"""Speed of the target's stage, m/s (MTS50-Z8, largest)."""

BACKLASH = 1e-3
"""How far below a position the target turns round, m: it is always approached from below."""

ATTEMPTS = 3
"""How often a burst is taken, or a line begun, before lost bytes are an error."""

RECOVERABLE = (BadReply, ConnectionLost, InstrumentTimeout)
"""Errors after which a burst may be taken again: bytes went astray on the way."""

ROLES = ("rf_emission", "rf_detection", "clock", "daq", "plate_emission", "plate_detection")
"""Instruments that no scan can do without."""


class Bench:
    """Instruments of a rig as a scan uses them.

    Parameters
    ----------
    instruments
        What ``Rig.open`` gives.
    settings : RigSettings
    sampling : Sampling

    Raises
    ------
    ValueError
        If the rig lacks an instrument.
    """

    def __init__(self, instruments: Any, settings: RigSettings, sampling: Sampling) -> None:
        missing = [role for role in ROLES if getattr(instruments, role) is None]
        if missing:
            raise ValueError(
                f"Expected a rig with {', '.join(ROLES)}, got none of {', '.join(missing)}. "
                "Add them to `devices`."
            )
        self.instruments, self.settings, self.sampling = instruments, settings, sampling
        self.rf = (instruments.rf_emission, instruments.rf_detection)
        self.plates = (instruments.plate_emission, instruments.plate_detection)
        self._fed = monotonic()
        self._edges = 0
        self._aim = 0.0, 0.0

    def set_up(self) -> None:
        """Bring everything but light and RF to where a scan begins."""
        devices = self.instruments
        self.shut()
        devices.interlock.check()
        for moved in (*self.plates, devices.stage):
            if moved is not None and not moved.status() & Status.HOMED:
                moved.home()
        # homing takes longer than the watchdogs allow
        devices.daq.watchdog(WATCHDOG)
        self.configure_read_out()
        self._start_clock()
        for rf in self.rf:
            if rf.status().tripped:  # a scan that was killed leaves it so
                rf.clear_trip()
            rf.output(False)
            rf.set_dead_man(self.settings.drive.dead_man)
            rf.set_power(self.settings.drive.power_dbm)
            rf.set_phase(0.0)
            rf.trigger(False)
        if devices.power_meter is not None:
            devices.power_meter.set_wavelength(LASER_WAVELENGTH)
            devices.power_meter.set_averaging(POWER_READINGS)
            devices.power_meter.zero()
        devices.interlock.laser(True)

    def configure_read_out(self) -> None:
        """Tell the read-out what a burst is."""
        detection = self.settings.detection
        self.instruments.daq.configure_burst(
            channel=detection.channel_number,
            rate=detection.rate,
            scans=self.sampling.scans,
            range=detection.range,
            pulse_line=self.settings.lines.trigger,
            scans_per_pulse=detection.samples_per_phase,
        )

    def _start_clock(self) -> None:
        clock = self.instruments.clock
        for channel in (1, 2):
            clock.set_load(channel, CLOCK_LOAD)
            clock.set_sine(channel, frequency=CLOCK_FREQUENCY, amplitude=CLOCK_AMPLITUDE)
        clock.phase_locked()
        clock.align_phases()
        for channel in (1, 2):
            clock.output(channel, True)

    def choose_mode(self, mode: str) -> None:
        """Turn both plates and run both modulators at the mode's frequency; the shutter is closed.

        RF is off while plates turn: that may take longer than the dead man's time.
        """
        self.shut()
        drive = self.settings.drive
        for rf in self.rf:
            rf.output(False)
        for plate, angle in zip(self.plates, self.settings.plates.mount_angles(mode), strict=True):
            plate.move_to(angle)
        for rf in self.rf:
            rf.set_frequency(drive.frequency(mode))
            rf.output(True, lock_timeout=LOCK_SHARE * drive.dead_man)
            self.feed(at_once=True)
        detection = self.instruments.rf_detection
        detection.load_table(drive_phases(self.sampling.phases, mode))
        detection.trigger(True)
        self.feed(at_once=True)

    def shut(self) -> None:
        """Close the shutter and park the beam."""
        self.instruments.interlock.shutter(False)
        self.instruments.galvo.park()
        self._aim = 0.0, 0.0

    def look_at(self, kind: Kind) -> None:
        """Send light to the reference target or the scene, or nowhere."""
        interlock = self.instruments.interlock
        interlock.check()
        if kind == "dark":
            self.shut()
            return
        interlock.flip_mirror(kind == "reference")
        interlock.beam_block(True)
        interlock.shutter(True)

    def move_target(self, offset: float, *, first: bool) -> None:
        """Bring the reference target to an offset (m) from its zero, from below."""
        stage = self.instruments.stage
        if stage is None:
            return
        goal = self.settings.reference.stage_zero + offset
        if first:
            self._creep(goal - BACKLASH)
        self._creep(goal)

    def _creep(self, goal: float) -> None:
        """Move the target in steps so short that the dead man's timers are fed between."""
        stage = self.instruments.stage
        step = STAGE_SPEED * self.settings.drive.dead_man / 3
        at = stage.position()
        while abs(goal - at) > step:
            at += step if goal > at else -step
            stage.move_to(at)
            self.feed()
        stage.move_to(goal)
        self.feed()

    def begin_line(self) -> None:
        """Bring the phase table to its first entry; that may be said twice, as nothing moves."""
        for attempt in range(1, ATTEMPTS + 1):
            try:
                self.instruments.rf_detection.arm()
                break
            except RECOVERABLE:
                if attempt == ATTEMPTS:
                    raise
        self._edges = 0

    def approach(self, direction: ArrayLike) -> None:
        """Turn the mirrors ahead of a burst where its first phase is too short for their step."""
        x, y = (float(angle) for angle in np.asarray(direction, float))
        step = np.hypot(x - self._aim[0], y - self._aim[1])
        self._aim = x, y
        room = self.sampling.settle_first / self.settings.detection.rate
        if self.instruments.galvo.settling_time(step) > room + 1e-9:
            self.instruments.galvo.move_to(x, y)

    def burst(self, label: int, direction: ArrayLike | None = None) -> NDArray[Any]:
        """Counts (scans,) of one burst; mirrors, label and start travel in one frame.

        Parameters
        ----------
        label : int
            Number of the burst in the plan.
        direction : array_like, shape (2,)
            Optical angles, rad; without it the mirrors stay.

        Raises
        ------
        BadReply, InstrumentTimeout, ConnectionLost
            If packets of every attempt were lost.
        """
        before: dict[str, float | int] = {"USER_RAM0_U32": label}
        if direction is not None:
            x, y = np.asarray(direction, float)
            before |= self.instruments.galvo.registers(float(x), float(y))
        for attempt in range(1, ATTEMPTS + 1):
            try:
                counts = self.instruments.daq.burst(before).counts
            except RECOVERABLE:
                if attempt == ATTEMPTS:
                    raise
                self.begin_line()  # nobody knows how many edges the broken burst sent
                continue
            self._edges += self.sampling.phases
            self.feed()
            return counts
        raise AssertionError("unreachable")

    def stepped(self) -> bool:
        """Whether the phase table was stepped once a phase since the line began."""
        return self.instruments.rf_detection.index()[1] == self._edges

    def check(self) -> None:
        """Check what a line stands on.

        Raises
        ------
        Unsafe
            If a modulator or the interlock has given way.
        """
        for rf in self.rf:
            status = rf.status()
            if status.tripped or not (status.on and status.locked):
                raise Unsafe(
                    f"Expected {rf.name} on and locked at the end of a line, got {status}. "
                    "Wait until the crystal is warm, then go on with --resume."
                )
        self.instruments.interlock.check()

    def power(self) -> float:
        """Laser power behind the emission module, W; 1 without a power meter.

        Raises
        ------
        Unsafe
            If there is no light.
        """
        meter = self.instruments.power_meter
        power = 1.0 if meter is None else float(meter.power())
        if not power > 0:
            raise Unsafe(f"Expected laser power above 0 W, got {power:g}. Check laser and shutter.")
        return power

    def feed(self, *, at_once: bool = False) -> None:
        """Keep the dead man's timers from running out while the scan is alive."""
        if at_once or monotonic() - self._fed > self.settings.drive.dead_man / 4:
            for rf in self.rf:
                rf.ping()
            self._fed = monotonic()

    def identities(self) -> dict[str, Any]:
        """What the devices call themselves, by role."""
        devices = self.instruments
        asked = ("rf_emission", "rf_detection", "clock", "daq", "power_meter")
        return {
            role: _plain(getattr(devices, role).identify())
            for role in asked
            if getattr(devices, role) is not None
        }


def _plain(value: Any) -> Any:
    """Identity as JSON has it."""
    if is_dataclass(value) and not isinstance(value, type):
        return _plain(asdict(value))
    if isinstance(value, dict):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    return int(value) if isinstance(value, IntFlag) else value
