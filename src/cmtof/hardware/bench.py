"""The bench: devices of a rig by role, and the steps of a scan with checks."""

import sys
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import repeat
from threading import Event
from time import monotonic, sleep, time
from typing import Any

import numpy as np

from cmtof.constants import LASER_WAVELENGTH
from cmtof.hardware.device import BadReply, InstrumentTimeout, Unsafe, insist
from cmtof.hardware.plan import Line, LineRecord, Plan, mirror_settling, mirror_volts
from cmtof.hardware.reduction import drive_phases, sums_from_counts
from cmtof.hardware.rig import LIGHT, PLATES, Rig
from cmtof.hardware.roles import (
    ClockRole,
    MotorRole,
    PowerMeterRole,
    ReadOutRole,
    Requests,
    RfRole,
)
from cmtof.hardware.safety import EmergencyStop
from cmtof.types import Array, Counts, Named, Values

ATTEMPTS = 3  # at a line before lost samples or a missed edge are an error
WATCHDOG = 5  # s without a request, after which the read-out makes itself dark
FAINTEST = 1e-7  # W at the meter, below which the laser counts as off
RAMP = (-20.0, -10.0, -6.0, -3.0, 0.0)  # dB: steps by which RF comes up to its power


class Bench(EmergencyStop):
    """Instruments of a rig, by role; a context that leaves all of them in their safe states.

    All lines are wired so that low, a cut cable or a read-out without power is safe; an open
    interlock reads low. ``patience`` is the share of all settling times that is waited for, 0 for
    simulated devices; ``clock_of`` gives the time at which the burst of a label was read, by
    default the computer's, s since 1970; ``about`` goes into the file.
    """

    rf_emission: RfRole
    rf_detection: RfRole
    plate_emission: MotorRole
    plate_detection: MotorRole
    stage: MotorRole
    daq: ReadOutRole
    clock: ClockRole
    power_meter: PowerMeterRole

    def __init__(
        self,
        rig: Rig,
        devices: Named,
        *,
        patience: float = 1.0,
        clock_of: Callable[[int], float] | None = None,
        **about: Any,
    ) -> None:
        self.rig = rig
        self.devices = devices
        self.about = about
        vars(self).update(devices)
        self.rf = (self.rf_emission, self.rf_detection)
        self._patience = patience
        self._clock_of = clock_of or (lambda label: time())
        self._aim = np.zeros(2)  # of the mirrors, optical angles, rad
        self._levels = {}
        self._brightest = 0.0  # most power sent out in this mode, W
        self._silence = min(rig.dead_man, WATCHDOG)  # that some device's timer allows
        self._fed = monotonic()
        super().__init__(devices.values())

    def switch(self, part: str, on: bool) -> None:
        """Switch a part, such as "shutter", and wait until it settles."""
        if on and part in LIGHT:
            self.check_interlock()
        self.daq.set_line(self.rig.line(part), on)
        if self._levels.get(part) != on:
            self.wait(getattr(self.rig, f"{part}_settling", 0.0))
        self._levels[part] = on

    def wait(self, seconds: float) -> None:
        """Wait so many seconds, while the devices' watchdogs are kept from expiring."""
        end = monotonic() + self._patience * seconds
        while (left := end - monotonic()) > 0:
            sleep(min(left, self._silence / 8))
            self.feed()

    def ask(self, text: str) -> None:
        """Wait until a person presses Enter, while the watchdogs are kept from expiring.

        All goes dark if the interlock opens or a device fails meanwhile; that is printed, and
        raised after Enter.
        """
        answered = Event()
        with ThreadPoolExecutor(1) as pool:
            feeding = pool.submit(self._feed_until, answered)
            try:
                input(text)
            finally:
                answered.set()
        feeding.result()

    def _feed_until(self, answered: Event) -> None:
        """Reset the watchdogs, also of RF drives that tripped, until an event; or go dark."""
        try:
            while not answered.wait(self._silence / 8):
                self.check_interlock()  # any request feeds the read-out's watchdog
                for rf in self.rf:
                    rf.status()
        except OSError as failure:
            self._make_safe()
            print(f"{failure} Press Enter.", file=sys.stderr)
            raise

    def check_interlock(self) -> None:
        """Raise `Unsafe` when the interlock is open."""
        if not self.daq.line(self.rig.line("interlock")):
            raise Unsafe(
                "Expected the interlock closed, got it open. Close doors and covers."
            )

    def mirror_outputs(self, directions: Array) -> list[Values]:
        """Voltages of the mirrors, by output, that send the beam in each direction (N, 2), rad."""
        volts = mirror_volts(self.rig, directions).tolist()
        return [dict(zip(self.rig.mirrors, pair, strict=True)) for pair in volts]

    def fly_back(self, directions: Array) -> None:
        """Aim at the first of a line's directions (N, 2), rad, and wait for the mirrors."""
        self.daq.write_many(self.mirror_outputs(directions)[0])
        self.wait(mirror_settling(self.rig, abs(directions[0] - self._aim).max()))
        self._aim = directions[-1]

    def set_up(self) -> None:
        """Prepare all devices for a scan: laser on, shutter closed, RF off."""
        self.daq.safe_state()
        self._levels.clear()
        self.check_interlock()
        self.daq.watchdog(WATCHDOG)
        for rf in self.rf:
            rf.clear_trip()  # a scan that was killed leaves it so
            rf.output(False)
            rf.set_dead_man(self.rig.dead_man)
            rf.set_phase(0.0)
            rf.trigger(False)
        for motor in (self.plate_emission, self.plate_detection, self.stage):
            if not motor.homed:
                motor.home(waiting=self.feed)
        self.listen(self.rig.detector_input)
        self.start_clock()
        # ten readings of about 3 ms each
        self.power_meter.set_up(
            wavelength=LASER_WAVELENGTH, readings=10, waiting=self.feed
        )
        self.switch("laser", True)

    def listen(self, *inputs: str) -> None:
        """Choose the analog inputs that bursts sample."""
        self.daq.configure_burst(
            channels=inputs,
            rate=self.rig.rate,
            scans=self.rig.scans,
            pulse_line=self.rig.line("trigger"),
            pulse=self.rig.samples_per_phase,
        )

    def start_clock(self) -> None:
        """Reset the clock generator, and switch on the channels that the rig uses."""
        rig = self.rig
        self.clock.reset()
        for channel in rig.clock_channels:
            self.clock.sine(
                channel, frequency=rig.clock_frequency, amplitude=rig.clock_amplitude
            )
        if len(rig.clock_channels) > 1:
            self.clock.lock_phases()
        for channel in rig.clock_channels:
            self.clock.output(channel, True)

    def choose_mode(self, mode: str) -> None:
        """Close the shutter, then turn both plates and drive both modulators for a mode."""
        self.close_and_park()
        rig = self.rig
        self._brightest = 0.0
        self.turn_rf_off()
        for module in ("emission", "detection"):
            self.turn_plate(module, PLATES[mode])
        for rf in self.rf:
            rf.set_frequency(rig.drive_frequency(mode))
            self.ramp_up(rf, rig.power_dbm)
        self.rf_detection.load_table(drive_phases(rig.phases, mode))
        self.rf_detection.trigger(True)

    def turn_rf_off(self) -> None:
        """Turn the RF of both drives off."""
        for rf in self.rf:
            rf.output(False)

    def turn_plate(self, module: str, angle: float) -> None:
        """Turn a module's half-wave plate to theta_h, degrees."""
        mount = angle + getattr(self.rig, f"plate_zero_{module}_deg")
        self.devices[f"plate_{module}"].move_to(
            float(np.deg2rad(mount)), waiting=self.feed
        )

    def ramp_up(self, rf: RfRole, power: float) -> None:
        """Switch RF on and raise it to a power, dBm, in steps, waiting for the lock at each."""
        if power > self.rig.power_dbm_limit:
            raise ValueError(
                f"Expected RF up to power_dbm_limit, {self.rig.power_dbm_limit:g} dBm, "
                f"got {power:g}. Lower it."
            )
        for step in RAMP:
            rf.set_power(max(power + step, -30.0))
            rf.output(True, lock_timeout=self._silence / 2)  # the other driver waits
            self.feed()

    def close_and_park(self) -> None:
        """Close the shutter, and set both scan mirrors to 0 V."""
        self.switch("shutter", False)
        self.daq.write_many(dict.fromkeys(self.rig.mirrors, 0.0))
        self._aim = np.zeros(2)

    def look_at(self, kind: str) -> None:
        """Choose the path of the light: "scan", "reference" target, or "dark" for none.

        Two more look at the target, too: "rf" by the fast photodiode, and "interferometer" beside
        the light of the reference mirror, whose beam block is raised. Light that is not as
        `metered_power` expects it is an error.
        """
        at_target = kind not in ("scan", "dark")
        to_photodiode = self.rig.flip_mirror == "photodiode"
        if kind == "rf" and not to_photodiode:
            raise ValueError(
                f"Expected flip_mirror: photodiode, got {self.rig.flip_mirror}. "
                "Set flip_mirror to photodiode, if it leads there."
            )
        self.switch("flip_mirror", kind == "rf" if to_photodiode else at_target)
        if at_target and to_photodiode:
            self.fly_back(np.deg2rad([self.rig.reference_direction_deg]))
        self.switch("beam_block", kind == "interferometer")
        self.switch("shutter", kind != "dark")
        if kind != "dark":
            self.metered_power()

    def move_target(self, offset: float) -> None:
        """Move the target to an offset, m, always from below, against backlash of the screw."""
        goal = self.rig.stage_zero + offset
        for position in (goal - 1e-3, goal):
            self.stage.move_to(position, waiting=self.feed)

    def bursts(
        self, labels: Sequence[int], outputs: Iterable[Named] = repeat({})
    ) -> Counts:
        """Counts (N, samples) of one burst for each label; ``outputs`` are set as each starts.

        The phase table begins again; `BadReply` if it was not stepped once per phase.
        """
        requests = [
            {"USER_RAM0_U32": float(label), **output}
            for label, output in zip(labels, outputs, strict=False)
        ]
        # may be sent twice, as nothing moves
        insist(self.rf_detection.arm, tries=ATTEMPTS)
        counts = []
        self.times = []  # at which these are read, s
        for label, burst in zip(labels, self.daq.bursts(requests), strict=True):
            self.times.append(self._clock_of(label))
            counts.append(burst)
            self.feed()
        edges = self.rf_detection.status().edges
        wanted = len(counts) * self.rig.phases
        if edges != wanted:
            raise BadReply(
                f"Expected {wanted} trigger edges, got {edges}. Check the trigger line."
            )
        return np.array(counts)

    def check(self) -> None:
        """Raise `Unsafe` unless both modulators are on and locked, clock on, interlock closed."""
        if not all(map(self.clock.output_is_on, self.rig.clock_channels)):
            raise Unsafe("Expected the clock on, got it off. Check the generator.")
        for rf in self.rf:
            status = rf.status()
            if status.tripped or not (status.on and status.locked):
                raise Unsafe(
                    f"Expected {rf.name} on and locked, got {status}. Let it warm up."
                )
        self.check_interlock()

    def feed(self) -> None:
        """Reset the watchdogs and check the interlock, at most each quarter of a timeout."""
        if monotonic() - self._fed < self._silence / 4:
            return
        self._fed = monotonic()
        self.check_interlock()  # any request feeds the read-out's watchdog
        for rf in self.rf:
            rf.ping()

    def metered_power(self) -> float:
        """Laser power at the meter, W.

        `Unsafe` if more is sent out than allowed, less than half of the most since the mode was
        chosen, or hardly any.
        """
        metered = self.power_meter.power
        emitted = self.rig.emitted_share * metered
        limit = self.rig.power_limit
        least = max(self.rig.emitted_share * FAINTEST, self._brightest / 2)
        if not least <= emitted <= limit:
            raise Unsafe(
                f"Expected laser power of {1e3 * least:.3g} to {1e3 * limit:g} mW sent out, "
                f"got {1e3 * emitted:.3g} mW. Check laser, shutter and fibre."
            )
        self._brightest = max(self._brightest, emitted)
        return metered

    def measure(self, plan: Plan, line: Line, attempts: int = ATTEMPTS) -> LineRecord:
        """Record of a plan's line, measured up to three times if samples or edges are lost."""
        self.look_at(line.kind)
        if line.kind == "reference":
            self.move_target(plan.sweep[line.row])
        outputs: Requests = repeat({})
        try:
            if line.kind == "scan":
                aims = plan.angles[line.row]
                self.fly_back(aims)
                outputs = self.mirror_outputs(aims)
            counts = self.bursts(line.labels, outputs)
        except (BadReply, InstrumentTimeout):
            if attempts == 1:
                raise
            return self.measure(plan, line, attempts - 1)
        self.check()
        # on the clock of the last burst: so it is the same after other lines and after a resume
        power = 1.0 if line.kind == "dark" else self.metered_power()
        measured = sums_from_counts(counts, plan.kept)
        locks = np.array([rf.lock()[1:] for rf in self.rf])
        return LineRecord(
            line.index, power, self.daq.rate, locks, np.array(self.times), *measured
        )
