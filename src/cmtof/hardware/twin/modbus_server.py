"""A simulated LabJack T7 with an LJTick-DAC: Modbus TCP on one port, stream packets on another.

The register map is the published one (`cmtof.hardware.codecs.registers`). What each part does
stands in `t7_registers`, `t7_lines`, `t7_stream`, `t7_stream_out` and `t7_watchdog`; here are the
analog side and the dialogue. USER_RAM0_U32 is plain memory on a real T7; the twin takes it for the
number of the burst.
"""

import math
import time
from collections.abc import Mapping, Sequence
from threading import RLock
from typing import Any

from cmtof.hardware.codecs.registers import REGISTERS
from cmtof.hardware.twin.faults import Watch
from cmtof.hardware.twin.lines import Channel
from cmtof.hardware.twin.modbus_frames import (
    DEVICE_FAILURE,
    ILLEGAL_VALUE,
    ModbusError,
    reply_to,
    split_frames,
)
from cmtof.hardware.twin.t7_lines import WIRING, T7Lines
from cmtof.hardware.twin.t7_registers import FLASH_ADDRESS, T7Registers, calibration_flash
from cmtof.hardware.twin.t7_stream import T7Stream, counts_from_volts
from cmtof.hardware.twin.t7_watchdog import T7Watchdog
from cmtof.instrument.electronics import RANGES
from cmtof.instrument.panel import Panel

TDAC_LIMIT = 10.0
"""Range of the LJTick-DAC, V."""
TDAC_STEP = 20.0 / 2**14
"""Step of the LJTick-DAC, 14 bit, V."""
_READING_TIME = 1e-3  # of an analog input by command, s on the virtual clock
_PARTIAL_TIMEOUT = 0.25  # a frame that stays incomplete so long is thrown away, s; not verified
_NO_TDAC, _WATCHDOG_ENABLED = 2763, 2671  # ljm_constants.json, errors
_MIXED = {"RANGE": -9999.0, "SETTLING_US": -9999.0, "NEGATIVE_CH": 65535.0,
          "RESOLUTION_INDEX": 65535.0}  # fmt: skip
_CHANNELS = range(14)


class T7Server:
    """One T7.

    Parameters
    ----------
    panel : Panel
    world : World
        Asked for what the analog inputs see.
    watch : Watch
        Faults of this device.
    wiring : mapping of str to int
        DIO number of each digital line, see `t7_lines.WIRING`.
    galvo : sequence of int
        Numbers of the TDAC outputs to the x and y input of the mirror driver.
    """

    def __init__(
        self,
        panel: Panel,
        world: Any,
        watch: Watch,
        *,
        wiring: Mapping[str, int] = WIRING,
        galvo: Sequence[int] = (2, 3),
    ) -> None:
        self._panel, self._world, self._watch = panel, world, watch
        self._lock = RLock()
        self._opened = False
        self.registers = T7Registers()
        self.lines = T7Lines(panel, self.registers, wiring)
        self.stream = T7Stream(panel, world, self.registers, self.lines, watch, self._lock)
        self._watchdog = T7Watchdog(self.registers, self.lines, self._lock)
        self._flash = calibration_flash()
        self._hook_analog()
        self._hook_dac(list(galvo))
        self._hook_system()

    def serve(self, channel: Channel) -> None:
        """Talk to one client of the command port until it has gone."""
        rest, arrived = b"", 0.0
        while True:
            patience = max(0.0, arrived + _PARTIAL_TIMEOUT - time.monotonic()) if rest else None
            data = channel.receive(patience)
            if data is None:
                rest = b""
                continue
            if not data:
                return
            frames, rest = split_frames(rest + data)
            arrived = time.monotonic()
            for frame in frames:
                self._answer(frame, channel)

    def _answer(self, frame: bytes, channel: Channel) -> None:
        trouble = self._watch.next()
        if trouble.unheard:
            trouble.deliver(channel, b"")
            return
        self._set_interlock("interlock-open" in trouble)
        with self._lock:
            reply, error = reply_to(frame, self)
            self._watchdog.feed()
            if error is not None:
                self.registers.put("LAST_ERR_DETAIL", error.detail)
            trouble.deliver(channel, reply)
            self.stream.run_started()

    def read(self, address: int, count: int) -> bytes:
        """Bytes of ``count`` registers."""
        return self.registers.read(address, count)

    def write(self, address: int, data: bytes) -> None:
        """Set registers, unless the fault ``ignore`` is due."""
        if not self._watch.takes("ignore"):
            self.registers.write(address, data)

    def stop(self) -> None:
        """End a stream that runs, and the watchdog."""
        self.stream.stop()
        self._watchdog.stop()

    def _set_interlock(self, opened: bool) -> None:
        """Open the interlock for a fault and close it after; leave alone what others opened."""
        if opened or self._opened:
            with self._panel.lock:
                self._panel.interlock_closed = not opened
            self._opened = opened

    def _hook_analog(self) -> None:
        registers = self.registers
        for n in _CHANNELS:
            registers.on_read(f"AIN{n}", lambda n=n: self._volts(n))
            registers.on_read(f"AIN{n}_BINARY", lambda n=n: self._binary(n))
            registers.on_write(f"AIN{n}_RANGE", _check_range)
        for setting in _MIXED:
            name = f"AIN_ALL_{setting}"
            registers.on_read(name, lambda s=setting: self._common(s))
            registers.on_write(name, lambda value, s=setting: self._set_all(s, value))

    def _volts(self, channel: int) -> float:
        self.stream.check_idle()
        with self._panel.lock:
            volts = self._world.analog_input(self._panel, channel)
            self._panel.time += _READING_TIME
        span = self.registers.value(f"AIN{channel}_RANGE") or 10.0
        return max(-1.06 * span, min(1.06 * span, volts))  # where the converter ends

    def _binary(self, channel: int) -> float:
        span = self.registers.value(f"AIN{channel}_RANGE") or 10.0
        return 256.0 * counts_from_volts(self._volts(channel), span)

    def _common(self, setting: str) -> float:
        values = {self.registers.value(f"AIN{n}_{setting}") for n in _CHANNELS}
        return values.pop() if len(values) == 1 else _MIXED[setting]

    def _set_all(self, setting: str, value: float) -> None:
        if setting == "RANGE":
            _check_range(value)
        for n in _CHANNELS:
            self.registers.put(f"AIN{n}_{setting}", value)

    def _hook_dac(self, galvo: list[int]) -> None:
        pairs = {n // 2 for n in galvo}
        for n in range(23):
            axis = galvo.index(n) if n in galvo else None
            there = n // 2 in pairs
            self.registers.on_write(f"TDAC{n}", lambda v, a=axis, t=there: self._set_tdac(v, a, t))

    def _set_tdac(self, volts: float, axis: int | None, there: bool) -> None:
        """Output of the LJTick-DAC; beyond +-10 V it stays there (not verified)."""
        if not there:
            raise ModbusError(DEVICE_FAILURE, _NO_TDAC)
        volts = math.copysign(self._watch.pulled(abs(volts), 0.0, TDAC_LIMIT), volts)
        volts = max(-TDAC_LIMIT, min(TDAC_LIMIT - TDAC_STEP, volts))
        if axis is not None:
            with self._panel.lock:
                self._panel.galvo_volts[axis] = round(volts / TDAC_STEP) * TDAC_STEP

    def _hook_system(self) -> None:
        registers = self.registers
        registers.on_write("USER_RAM0_U32", self._set_label)
        registers.on_buffer_read("INTERNAL_FLASH_READ", self._read_flash)
        registers.on_write("IO_CONFIG_SET_CURRENT_TO_FACTORY", self._factory)
        for name in REGISTERS:
            if name.startswith("WATCHDOG_") and name != "WATCHDOG_ENABLE_DEFAULT":
                registers.on_write(name, self._check_watchdog)

    def _set_label(self, value: float) -> None:
        with self._panel.lock:
            self._panel.label = int(value)

    def _read_flash(self, size: int) -> bytes:
        """Flash from the pointer on, which moves along; erased flash is all ones."""
        pointer = int(self.registers.value("INTERNAL_FLASH_READ_POINTER"))
        start = pointer - FLASH_ADDRESS
        data = bytes(
            self._flash[i] if 0 <= i < len(self._flash) else 0xFF
            for i in range(start, start + size)
        )
        self.registers.put("INTERNAL_FLASH_READ_POINTER", (pointer + size) & 0xFFFFFFFF)
        return data

    def _factory(self, value: float) -> None:
        if value != 1:
            raise ModbusError(ILLEGAL_VALUE)
        self.lines.factory()
        for n in _CHANNELS:
            self.registers.put(f"AIN{n}_RANGE", 0.0)
        self.registers.put("DAC0", 0.0)
        self.registers.put("DAC1", 0.0)

    def _check_watchdog(self, value: float) -> None:
        if self.registers.value("WATCHDOG_ENABLE_DEFAULT"):
            raise ModbusError(DEVICE_FAILURE, _WATCHDOG_ENABLED)


def _check_range(value: float) -> None:
    """Ranges of the T7; 0 is its default of 10 V."""
    if not any(abs(value - known) < 1e-6 for known in (0.0, *RANGES)):
        raise ModbusError(ILLEGAL_VALUE)
