"""Stream mode of the simulated T7: set-up, bursts, spontaneous packets.

Sources: T-Series Datasheet 3.2 Stream Mode, 3.2.4 Low-Level Stream; ljm_constants.json (registers,
errors, status); LabJack's C example for low-level streaming (layout of a packet). A burst comes at
once, its time passes on the virtual clock. Not verified: that a finished burst stays enabled until
0 is written to STREAM_ENABLE; that its last packet carries status 2944; that transaction numbers
begin at 0.
"""

import struct
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cmtof.hardware.codecs.registers import REGISTERS
from cmtof.hardware.twin.faults import Watch
from cmtof.hardware.twin.modbus_frames import DEVICE_FAILURE, ModbusError
from cmtof.hardware.twin.t7_lines import T7Lines
from cmtof.hardware.twin.t7_registers import T7Registers
from cmtof.hardware.twin.t7_stream_out import StreamOut
from cmtof.instrument.electronics import CENTRE, slope
from cmtof.instrument.panel import Panel

DETECTOR = 0
"""Analog input that the detector is wired to."""
CORE_TIMER_HZ = 40e6
"""Half the core's clock, Hz."""
MAX_SAMPLE_RATE = 100e3
SCAN_OVERLAP, BURST_COMPLETE = 2942, 2944
_FULL_SCALE = 65535
_ANALOG = {REGISTERS[f"AIN{n}"].address: n for n in range(14)}
_PORTS = {REGISTERS[f"{port}_STATE"].address: port for port in ("FIO", "EIO", "CIO", "MIO")}
_OUTS = {REGISTERS[f"STREAM_OUT{n}"].address: n for n in range(4)}
_FIO_STATE = REGISTERS["FIO_STATE"].address
# errors of ljm_constants.json
_NEEDS_CHANNEL, _IS_ACTIVE, _CONFIG_INVALID, _LIST_INVALID, _RATE_INVALID = (
    2600, 2605, 2606, 2607, 2608)  # fmt: skip
_OUT_INVALID, _DATATYPE_INVALID, _TARGET_INVALID, _BUFFER_INVALID = 2610, 2611, 2612, 2615
_PACKET_INVALID, _NOT_RUNNING, _SETTLING_INVALID = 2618, 2620, 2621


class T7Stream:
    """Stream mode.

    Parameters
    ----------
    panel : Panel
    world : World
        Asked for the samples.
    registers : T7Registers
    lines : T7Lines
        Stepped by a stream-out on FIO_STATE.
    watch : Watch
        Faults of this device.
    lock : RLock
        Of the device; an unending stream takes it for every packet.
    """

    def __init__(
        self,
        panel: Panel,
        world: Any,
        registers: T7Registers,
        lines: T7Lines,
        watch: Watch,
        lock: "threading.RLock",
    ) -> None:
        self._panel, self._world, self._registers = panel, world, registers
        self._lines, self._watch, self._lock = lines, watch, lock
        self.publish: Callable[[bytes], None] = lambda packet: None
        """Where packets go: to every client of port 702."""
        self.active = False
        self._started = False
        self._ending = threading.Event()
        self._thread: threading.Thread | None = None
        self._transaction = 0
        self._outs = [StreamOut(registers, n, self.check_idle) for n in range(4)]
        registers.on_write("STREAM_ENABLE", self._enable)
        registers.on_read("STREAM_ENABLE", lambda: float(self.active))
        registers.on_write("STREAM_DATATYPE", self._set_datatype)
        registers.on_read("STREAM_SCANRATE_HZ_ACTUAL", lambda: self._value("SCANRATE_HZ"))
        registers.on_read("CORE_TIMER", lambda: float(_ticks(panel.time)))
        self._datatype_written = False

    def check_idle(self) -> None:
        """Refuse what cannot be done while a stream is on."""
        if self.active:
            raise ModbusError(DEVICE_FAILURE, _IS_ACTIVE)

    def run_started(self) -> None:
        """Take the burst that a request has started; called when it has been answered."""
        if not self._started:
            return
        self._started = False
        scans = int(self._value("NUM_SCANS"))
        if scans:
            self._burst(scans, last=True)
        else:
            self._thread = threading.Thread(target=self._run_on, name="twin-stream", daemon=True)
            self._thread.start()

    def stop(self) -> None:
        """End an unending stream and wait for it."""
        self._ending.set()
        if self._thread is not None:
            self._thread.join()

    def _run_on(self) -> None:
        ending = self._ending
        scans = max(1, int(self._value("SAMPLES_PER_PACKET")) // max(1, len(self._inputs())))
        period = scans / self._value("SCANRATE_HZ")
        while not ending.wait(period):
            with self._lock:
                if not ending.is_set():
                    self._burst(scans, last=False)

    def _enable(self, value: float) -> None:
        if not value:
            if not self.active:
                raise ModbusError(DEVICE_FAILURE, _NOT_RUNNING)
            self._ending.set()
            self.active = self._started = False
            return
        self.check_idle()
        self._check()
        self.active = self._started = True
        self._ending = threading.Event()
        self._transaction = 0

    def _set_datatype(self, value: float) -> None:
        if value:
            raise ModbusError(DEVICE_FAILURE, _DATATYPE_INVALID)
        self._datatype_written = True

    def _value(self, name: str) -> float:
        return self._registers.value(f"STREAM_{name}")

    def _scan_list(self) -> list[int]:
        count = int(self._value("NUM_ADDRESSES"))
        return [int(self._value(f"SCANLIST_ADDRESS{n}")) for n in range(count)]

    def _inputs(self) -> list[int]:
        return [address for address in self._scan_list() if address not in _OUTS]

    def _check(self) -> None:
        """Refuse a set-up that the device would refuse."""
        count = int(self._value("NUM_ADDRESSES"))
        rate, size = self._value("SCANRATE_HZ"), int(self._value("BUFFER_SIZE_BYTES"))
        unknown = [
            address
            for address in (self._scan_list() if 0 < count <= 128 else [])
            if address not in _ANALOG and address not in _PORTS and address not in _OUTS
        ]
        outs = [_OUTS[one] for one in self._scan_list() if one in _OUTS] if count <= 128 else []
        for wrong, error in (
            (not 0 < count <= 128, _NEEDS_CHANNEL),
            (unknown, _LIST_INVALID),
            (any(not self._outs[n].enabled for n in outs), _OUT_INVALID),
            (not 0 < rate * count <= MAX_SAMPLE_RATE, _RATE_INVALID),
            (not 0 < self._value("SAMPLES_PER_PACKET") <= 512, _PACKET_INVALID),
            (self._value("RESOLUTION_INDEX") > 8, _CONFIG_INVALID),
            (self._value("CLOCK_SOURCE") or self._value("TRIGGER_INDEX"), _CONFIG_INVALID),
            (not 0 <= self._value("SETTLING_US") <= 4400, _SETTLING_INVALID),
            (not int(self._value("AUTO_TARGET")) & 1, _TARGET_INVALID),
            (size > 32768 or size & (size - 1), _BUFFER_INVALID),
            (not self._datatype_written, _DATATYPE_INVALID),
        ):
            if wrong:
                raise ModbusError(DEVICE_FAILURE, error)

    def _burst(self, scans: int, *, last: bool) -> None:
        rate = self._value("SCANRATE_HZ")
        with self._panel.lock:
            played = self._played(scans)
            pulses = self._lines.play(played, scans)
            samples = self._samples(scans, rate, pulses)
            self._lines.end_play(played, pulses)
            begin = self._panel.time - scans / rate
        self._registers.put("STREAM_START_TIME_STAMP", _ticks(begin))
        if self._watch.takes("saturate"):
            samples[:] = _FULL_SCALE
        self._send(samples.reshape(-1), last=last)

    def _played(self, scans: int) -> NDArray[np.int64] | None:
        """What a stream-out on FIO_STATE writes; others play unseen."""
        played = None
        for address in self._scan_list():
            if address in _OUTS:
                out = self._outs[_OUTS[address]]
                values = out.take(scans)
                played = values if out.target == _FIO_STATE else played
        return played

    def _samples(self, scans: int, rate: float, pulses: NDArray[np.int64]) -> NDArray[np.uint16]:
        """Samples (scans, inputs) in the order of the scan list."""
        inputs = self._inputs()
        samples = np.zeros((scans, len(inputs)), np.uint16)
        taken = False
        for column, address in enumerate(inputs):
            channel = _ANALOG.get(address)
            if channel is None:
                samples[:, column] = int.from_bytes(self._registers.read(address, 1), "big")
                continue
            span = self._registers.value(f"AIN{channel}_RANGE") or 10.0
            if channel == DETECTOR and not taken:
                taken = True
                samples[:, column] = self._world.burst(
                    self._panel, scans=scans, rate=rate, pulses=pulses, volts_range=span
                )
            else:
                volts = self._world.analog_input(self._panel, channel)
                samples[:, column] = counts_from_volts(volts, span)
        if not taken:
            self._panel.time += scans / rate
        return samples

    def _send(self, samples: NDArray[np.uint16], *, last: bool) -> None:
        """Cut samples into packets and send them."""
        size = int(self._value("SAMPLES_PER_PACKET"))
        raw = samples.astype(">u2").tobytes()
        starts = range(0, len(raw), 2 * size)
        overlap, lost = self._watch.takes("overlap"), self._watch.takes("lost-packets")
        for start in starts:
            data = raw[start : start + 2 * size]
            status = BURST_COMPLETE if last and start == starts[-1] else 0
            if overlap:
                status, overlap = SCAN_OVERLAP, False
            backlog = min(len(raw) - start - len(data), 0xFFFF)
            if lost:
                lost = False
            else:
                self.publish(packet(self._transaction, data, backlog=backlog, status=status))
            self._transaction = (self._transaction + 1) & 0xFFFF


def packet(transaction: int, data: bytes, *, backlog: int = 0, status: int = 0) -> bytes:
    """Spontaneous packet: MBAP header, function 76, type 16, reserved, backlog, status, extra.

    Examples
    --------
    >>> packet(1, b"\\x82\\xf3", status=2944).hex(" ", 2)
    '0001 0000 000c 014c 1000 0000 0b80 0000 82f3'
    """
    head = struct.pack(">HHHBB", transaction, 0, 10 + len(data), 1, 76)
    return head + struct.pack(">BBHHH", 16, 0, backlog, status, 0) + data


def counts_from_volts(volts: float, volts_range: float) -> int:
    """Raw 16-bit count of a voltage without noise, by the nominal calibration."""
    return int(np.clip(round(volts / slope(volts_range) + CENTRE), 0, _FULL_SCALE))


def _ticks(seconds: float) -> int:
    return round(seconds * CORE_TIMER_HZ) & 0xFFFFFFFF
