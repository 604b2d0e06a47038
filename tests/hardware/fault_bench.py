"""A bench for the fault table: the drivers before the simulated devices, and what they are to do.

Each line to a device is recorded on the host's side, so that a fault can be made to happen at the
very request that matters, however many others a driver sends before, and that one can be counted.
"""

import re
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import pytest

from cmtof.hardware.codecs import apt
from cmtof.hardware.drivers import apt_stage
from cmtof.hardware.drivers.apt_stage import Stage
from cmtof.hardware.drivers.galvo import Galvo
from cmtof.hardware.drivers.interlock import Interlock
from cmtof.hardware.drivers.labjack_t7 import LabJackT7
from cmtof.hardware.drivers.power_meter import PowerMeter
from cmtof.hardware.drivers.rf_driver import RfDriver
from cmtof.hardware.drivers.signal_generator import SignalGenerator
from cmtof.hardware.drivers.stage_table import STAGES
from cmtof.hardware.rig import Instruments, Rig
from cmtof.hardware.safety import EmergencyStop
from cmtof.hardware.transport import Transport, open_transport
from cmtof.hardware.twin.run import Twin
from cmtof.instrument.panel import Panel

RF = ("rf_emission", "rf_detection")
PLATES = ("plate_emission", "plate_detection")
MOTORS = (*PLATES, "stage")
ROLES = (*RF, "clock", "daq", *MOTORS, "power_meter")
SCPI = ("clock", "power_meter")
"""Whose settings are not answered."""
BINARY = ("daq", *MOTORS)
"""Where a garbled head makes a message another one, and the answer never comes."""
ON_THE_DAQ = ("galvo", "interlock")

TIMEOUT = 0.5
"""What the drivers are given, s; generous, as the machine may be busy."""
CAP = 0.02
"""How long an answer is awaited that is known not to come, s."""
DELAYS = {"late": 0.01, "too late": 0.1}
"""Lateness of an answer inside the time that it has, and beyond it, s."""
MUTE = ("silence", "cut", "too late")
"""Kinds after which nothing, or not enough, comes in time."""

START = {"stage": 20e-3, "plate_emission": 0.3, "plate_detection": 0.3}
"""Where the motors' own moves begin, m or rad."""
_FULL_SPEED = 2**31 - 1  # more than any motor has: clamped


class Recorder:
    """Transport that strikes at the first request with a mark, and counts those that have it."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self._mark: re.Pattern[bytes] | None = None
        self._strike: Callable[[], None] | None = None
        self._capped = self._cap_next = False
        self.dead = False  # no answer will come, whatever is asked
        self.marked = self.written = 0

    def watch(self, mark: bytes, strike: Callable[[], None] | None, *, cap: bool = False) -> None:
        """Count requests from now on; ``strike`` comes before the first. ``cap``: none answers."""
        self._mark, self._strike = re.compile(mark, re.DOTALL), strike
        self._cap_next, self._capped = cap, False
        self.marked = self.written = 0

    def write(self, data: bytes) -> None:
        self._capped = False
        if self._mark is not None and self._mark.search(data):
            self.marked += 1
            if self._strike is not None:
                self._strike()
                self._strike, self._capped = None, self._cap_next
        self.written += 1
        self._transport.write(data)

    def read_exact(self, size: int, timeout: float) -> bytes:
        return self._transport.read_exact(size, self._limited(timeout))

    def read_until(self, end: bytes, timeout: float, limit: int = 65536) -> bytes:
        return self._transport.read_until(end, self._limited(timeout), limit)

    def _limited(self, timeout: float) -> float:
        return min(timeout, CAP) if self._capped or self.dead else timeout

    def flush(self) -> bytes:
        return self._transport.flush()

    def reconnect(self) -> None:
        self._transport.reconnect()

    def close(self) -> None:
        self._transport.close()


class Bench:
    """The default rig's drivers, connected to a twin; a context manager."""

    def __init__(self) -> None:
        self.twin = Twin.default(seed=0)
        self.lines: dict[str, Recorder] = {}
        self.devices: dict[str, Any] = {}
        self.clean = True  # no case has failed here
        self._open = ExitStack()

    def __enter__(self) -> "Bench":
        with ExitStack() as stack:
            patch = stack.enter_context(pytest.MonkeyPatch.context())
            patch.setattr(apt_stage, "_POLL", 0.02)  # motors here are fast
            stack.enter_context(self.twin)
            rig = self.twin.rig
            for role in ROLES:
                self.lines[role] = Recorder(open_transport(rig.address(role)))
                stack.callback(self.lines[role].close)
            self.devices = self._drivers(rig, stack)
            self.order = Instruments(**self.devices).in_order_of_stopping()
            self._set_up()
            self._open = stack.pop_all()
        return self

    def __exit__(self, *error: object) -> None:
        self.twin.faults.clear()
        self._open.close()

    def _drivers(self, rig: Rig, stack: ExitStack) -> dict[str, Any]:
        line = self.lines
        stream = open_transport(rig.address("daq", "stream"))
        stack.callback(stream.close)
        daq = LabJackT7(line["daq"], stream, timeout=TIMEOUT)
        kinds = {"stage": "mts50-z8", **dict.fromkeys(PLATES, "k10cr1")}
        return {
            **{role: RfDriver(line[role], role, timeout=TIMEOUT) for role in RF},
            "clock": SignalGenerator(line["clock"], timeout=TIMEOUT),
            "daq": daq,
            "galvo": Galvo(daq),
            "interlock": Interlock(daq, rig.settings.lines),
            **{
                role: Stage(line[role], STAGES[kind], role, timeout=TIMEOUT / 2)
                for role, kind in kinds.items()
            },
            "power_meter": PowerMeter(line["power_meter"], timeout=TIMEOUT),
        }

    def _set_up(self) -> None:
        self.devices["clock"].set_load(1, 50.0)
        for role in RF:
            self.devices[role].set_power(30.0)
            self.devices[role].set_frequency(7.15e9)
            self.devices[role].set_dead_man(60.0)
        for role in MOTORS:
            self.devices[role].home()

    def line(self, device: str) -> Recorder:
        """Line on which a device is reached."""
        return self.lines[role_of(device)]

    def stop(self) -> EmergencyStop:
        """Emergency stop of all devices, as `Instruments` has it."""
        return EmergencyStop(*self.order)

    def light_up(self, *, but: str = "") -> None:
        """Everything on, the beam off its park position, every motor under way but one."""
        devices = self.devices
        devices["clock"].set_sine(1, frequency=10e6, amplitude=1.0)
        devices["clock"].output(1, True)
        for role in RF:
            devices[role].clear_trip()
            devices[role].output(True)
        devices["interlock"].beam_block(False)
        devices["interlock"].laser(True)
        devices["interlock"].shutter(True)
        devices["galvo"].move_to(0.1, -0.1)
        for role in MOTORS:
            if role != but:
                self.send_away(role)
        panel = self.twin.panel
        assert panel.emission.on and panel.detection.on and panel.shutter_open and panel.laser_on
        assert abs(panel.galvo_volts[0]) > 1 and abs(panel.galvo_volts[1]) > 1

    def send_away(self, role: str) -> None:
        """Start a move that takes seconds, and do not wait for it."""
        stage = self.devices[role]
        at = shown(self.twin.panel, role)
        goal = (at - 30.0 if at > 0 else at + 30.0) if role in PLATES else 50e-3 * (at < 25e-3)
        slow = 1e-4 if role == "stage" else 0.02
        counts = round(slow * stage.kind.velocity_scale)
        self.lines[role].write(apt.set_velocity(_FULL_SPEED, counts))
        self.lines[role].write(apt.move_absolute(stage.kind.counts(goal)))
        assert stage.status().moving

    def strike_at(self, device: str, mark: bytes, fault: str) -> Recorder:
        """Let a fault happen at the next request with a mark; return the line it passes."""
        line, role = self.line(device), role_of(device)
        requests = self.twin.faults.watch(role)
        before = requests.requests

        def strike() -> None:
            # commands that are not answered may still be on their way
            end = time.monotonic() + 5.0
            while role in SCPI and requests.requests < before + line.written:
                assert time.monotonic() < end, "a command never arrived"
                time.sleep(1e-3)
            kind = "late" if fault == "too late" else fault
            self.twin.faults.add(role, kind, delay=DELAYS.get(fault, 0.0))

        line.watch(mark, strike, cap=fault in MUTE or (fault == "garble" and role in BINARY))
        return line

    def to_start(self, role: str) -> None:
        """Bring a motor to where its own moves begin."""
        stage = self.devices[role]
        if not stage.status() & apt.Status.HOMED:
            stage.home()
        self.lines[role].write(apt.set_velocity(_FULL_SPEED, _FULL_SPEED))
        stage.move_to(START[role])

    def assert_safe(self, *, but: str = "") -> None:
        """No light, no RF, beam parked, motors at rest; ``but`` cannot be reached."""
        panel = self.twin.panel
        with panel.lock:
            on = {
                "rf_emission": panel.emission.on,
                "rf_detection": panel.detection.on,
                "clock": panel.clock_on,
                "daq": panel.laser_on or panel.shutter_open or not panel.beam_block_in,
                "galvo": panel.galvo_volts != [0.0, 0.0],
            }
        assert not [name for name, wrong in on.items() if wrong and role_of(name) != but]
        for role in MOTORS:
            if role != but:
                stage = self.devices[role]
                assert not stage.status().moving
                # the panel learns of a position when a move has ended
                assert shown(panel, role) == pytest.approx(stage.position(), abs=1e-9)


def role_of(device: str) -> str:
    """Role of the device that carries the wire."""
    return "daq" if device in ON_THE_DAQ else device


def shown(panel: Panel, role: str) -> float:
    """Position that the panel shows, m or rad."""
    return panel.stage_position if role == "stage" else panel.plate_angle[PLATES.index(role)]
