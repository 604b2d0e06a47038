"""LabJack T7 over Modbus TCP: registers by name, digital lines, bursts of samples, watchdog.

Registers: ``codecs/registers.py``. A reply that is late or garbled is asked for again only where
nothing moves by it; a write is sent once.
"""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.hardware.codecs import labjack, modbus
from cmtof.hardware.codecs.registers import register
from cmtof.hardware.device import QUERY_TIMEOUT, Device, check_set
from cmtof.hardware.drivers.modbus_link import ModbusLink
from cmtof.hardware.drivers.stream_burst import (
    Burst,
    BurstSettings,
    read_burst,
    write,
    writes,
)
from cmtof.hardware.errors import BadReply, Refused
from cmtof.hardware.transport import Transport

__all__ = ["Burst", "BurstSettings", "LabJackT7", "T7Identity"]

_NOT_RUNNING = 2620  # STREAM_NOT_RUNNING: stopping a stream that has ended by itself
_TEST = 0x00112233


@dataclass(frozen=True)
class T7Identity:
    """Which T7 answers: serial number, versions, T7-Pro or not, own calibration or nominal."""

    serial_number: int
    firmware: float
    hardware: float
    pro: bool
    calibrated: bool


class LabJackT7(Device):
    """A T7 with its two connections.

    Parameters
    ----------
    command, stream : Transport
        To ports 502 and 702.
    name : str
    safe_lines : mapping of str to bool
        FIO lines and the levels that the device's own watchdog gives them.
    timeout : float
        For an answer, and for a burst beyond its duration, s.
    """

    def __init__(
        self,
        command: Transport,
        stream: Transport,
        name: str = "daq",
        *,
        safe_lines: Mapping[str, bool] | None = None,
        timeout: float = QUERY_TIMEOUT,
    ) -> None:
        super().__init__(name, command, stream)
        self._safe_lines = dict(safe_lines or {})
        self._link = ModbusLink(command, timeout=timeout)
        self._stream = stream
        self._timeout = timeout
        self._calibration: labjack.Calibration | None = None
        self._settings: BurstSettings | None = None
        self._ready = False

    # --- registers -----------------------------------------------------------------------------

    def identify(self) -> T7Identity:
        """Check that a T7 answers, with words in the right order, and load its calibration.

        Raises
        ------
        Refused
            If it is another device.
        """
        if self.read("PRODUCT_ID") != 7 or self.read("TEST") != _TEST:
            raise Refused(
                f"Expected a LabJack T7 at {self.name}, got another device. Check the address."
            )
        return T7Identity(
            serial_number=int(self.read("SERIAL_NUMBER")),
            firmware=round(float(self.read("FIRMWARE_VERSION")), 4),
            hardware=round(float(self.read("HARDWARE_VERSION")), 4),
            pro=bool(int(self.read("HARDWARE_INSTALLED")) & 1),
            calibrated=self.calibration() is not labjack.NOMINAL,
        )

    def read(self, name: str) -> float | int | str:
        """Value of a register; repeated once if the answer is lost.

        Raises
        ------
        ValueError
            If there is no such register, or it cannot be read.
        ModbusException
            If the device refuses, as for an analog input while it streams.
        """
        entry = register(name)
        if "R" not in entry.access:
            raise ValueError(f"Expected a register to read, got {name}, write only. Leave it out.")
        return entry.value_from_bytes(
            self._read(lambda: self._link.read(entry.address, entry.size))
        )

    def write(self, name: str, value: float | str) -> None:
        """Write one register, once."""
        part = write(name, value)
        self._act(lambda: self._link.write(part.address, part.data))

    def write_many(self, values: Mapping[str, float]) -> None:
        """Write registers in their order in one frame, once."""
        self._act(lambda: self._link.feedback(writes(values)))

    def line(self, dio: str) -> bool:
        """Level of a digital line, which this makes an input; use `state` for an output's."""
        return bool(self.read(dio))

    def set_line(self, dio: str, high: bool) -> None:
        """Make a digital line an output at that level, and check it.

        Raises
        ------
        Refused
            If the terminal does not follow.
        """
        self.write(dio, int(high))
        if self.state(dio) != high:
            level = "high" if high else "low"
            raise Refused(
                f"Expected {dio} of {self.name} to go {level}, got the other level. "
                "Look for a short or another output on that line."
            )

    def state(self, dio: str) -> bool:
        """Level at the terminal of an FIO line, without changing its direction."""
        return bool(int(self.read("FIO_STATE")) >> int(dio.removeprefix("FIO")) & 1)

    def calibration(self) -> labjack.Calibration:
        """Constants of this device's converter, from its flash; read once.

        A blank flash gives nominal values and a warning: they are off by up to 1 % of the range.
        """
        if self._calibration is None:
            data = self._read(self._flash)
            if not data.strip(b"\xff") or not data.strip(b"\0"):
                warnings.warn(
                    f"Expected a calibration in the flash of {self.name}, got a blank one. "
                    "Nominal values are used; have the device calibrated.",
                    RuntimeWarning,
                    stacklevel=2,
                )
                self._calibration = labjack.NOMINAL
            else:
                self._calibration = labjack.parse_calibration(data)
        return self._calibration

    def _flash(self) -> bytes:
        read, pointer = register("INTERNAL_FLASH_READ"), "INTERNAL_FLASH_READ_POINTER"
        return b"".join(
            self._link.feedback([write(pointer, start), modbus.Read(read.address, count)])[0]
            for start, count in labjack.calibration_blocks()
        )

    # --- bursts --------------------------------------------------------------------------------

    def configure_burst(
        self,
        *,
        channel: int = 0,
        rate: float,
        scans: int,
        range: float = 10.0,
        pulse_line: str | None = None,
        scans_per_pulse: int = 20,
    ) -> BurstSettings:
        """Set up bursts of ``scans`` samples of one analog input; see `BurstSettings`.

        Returns
        -------
        BurstSettings
            What was set and read back.

        Raises
        ------
        ValueError
            If no T7 can do that.
        Refused
            If the device kept another value.
        """
        self._settings = BurstSettings(
            channel=channel,
            rate=rate,
            scans=scans,
            range=range,
            pulse_line=pulse_line,
            scans_per_pulse=scans_per_pulse,
        )
        self._prepare(self._settings)
        return self._settings

    def _prepare(self, settings: BurstSettings) -> None:
        self._ready = False
        self._act(self._stop)
        values = settings.stream_registers()
        # not read back: 0 stands for an automatic settling; the datasheet demands STREAM_DATATYPE 0
        # but no published map has it
        unchecked = {"STREAM_SETTLING_US": 0.0, "STREAM_DATATYPE": 0}
        parts = [*writes(values), *writes(unchecked)]
        self._act(lambda: self._link.feedback(parts))
        if pulses := settings.pulse_writes():
            self._act(lambda: self._link.feedback(pulses))
        self._check(values)
        self._stream.flush()
        self._ready = True

    def _check(self, values: Mapping[str, float]) -> None:
        entries = [register(name) for name in values]
        reads = [modbus.Read(entry.address, entry.size) for entry in entries]
        found = self._read(lambda: self._link.feedback(reads))
        for (name, wanted), entry, data in zip(values.items(), entries, found, strict=True):
            tolerance = 1e-3 * abs(wanted) if entry.kind == "FLOAT32" else 0.0
            value = float(entry.value_from_bytes(data))
            check_set(self.name, name, wanted, value, tolerance=tolerance, unit="")

    def burst(self, before: Mapping[str, float] | None = None) -> Burst:
        """Write registers and start a burst in one frame, and read its samples.

        Nothing is repeated here. After an error that `BadReply` or `InstrumentTimeout` names, the
        caller may call again with the same registers: the next call sets everything up anew.

        Parameters
        ----------
        before : mapping of str to float
            Registers by name, in their order, as the mirrors' of `Galvo.registers`.

        Raises
        ------
        BadReply
            If a packet was lost or the device skipped scans.
        InstrumentTimeout
            If samples are missing.
        ConnectionLost
            If a connection ended; the next call opens it anew.
        """
        settings = self._settings
        if settings is None:
            raise ValueError("Expected a burst to be set up, got none. Call configure_burst first.")
        if not self._ready:
            self._prepare(settings)
        self._ready = False
        timer = register("CORE_TIMER")
        start = [
            *writes(before or {}),
            write("STREAM_ENABLE", 1),
            modbus.Read(timer.address, timer.size),
        ]
        counts, ticks = self._act(lambda: self._take(start, settings))
        self._ready = True
        return Burst(counts, int(timer.value_from_bytes(ticks)))

    def _take(
        self, start: list[modbus.Read | modbus.Write], settings: BurstSettings
    ) -> tuple[NDArray[np.uint16], bytes]:
        self._stream.flush()
        (ticks,) = self._link.feedback(start)
        try:
            counts = read_burst(self._stream, settings, self._timeout)
        except BadReply:
            self._stop()
            raise
        self._stop()
        return counts, ticks

    def _stop(self) -> None:
        try:
            self._link.feedback([write("STREAM_ENABLE", 0)])
        except modbus.ModbusException as refusal:
            if refusal.detail != _NOT_RUNNING:
                raise

    def volts_from_counts(self, counts: ArrayLike, range: float) -> NDArray[np.float64]:
        """Volts of a burst's counts at an input range, V; same shape."""
        return self.calibration().volts_from_counts(counts, range)

    # --- safety --------------------------------------------------------------------------------

    def watchdog(self, seconds: float) -> None:
        """Let the device set its safe lines when no host speaks for ``seconds``; 0 ends that.

        The settings live in the device's flash and survive a power cycle, so they are written only
        where they differ. The LJTick-DAC (TDAC) is not covered: mirrors stay where they are.

        Parameters
        ----------
        seconds : float
            Whole seconds, 1 to 3600, or 0.

        Raises
        ------
        Refused
            If the device kept another value.
        """
        if seconds and not 1 <= seconds <= 3600:
            raise ValueError(f"Expected 0 or 1 to 3600 s, got {seconds}. Choose another time.")
        enabled = "WATCHDOG_ENABLE_DEFAULT"
        if not seconds:
            if self.read(enabled):
                self.write(enabled, 0)
            return
        wanted = {
            "WATCHDOG_TIMEOUT_S_DEFAULT": round(seconds),
            **_watchdog_masks(self._safe_lines),
        }
        changed = {key: value for key, value in wanted.items() if self.read(key) != value}
        if changed:
            self.write(enabled, 0)  # nothing else of it can be written while it runs
            self.write_many(changed)
        if changed or not self.read(enabled):
            self.write(enabled, 1)
        self._check({**wanted, enabled: 1})

    def safe_state(self) -> None:
        """Stop a running stream, and pull the pulse line low."""
        self._ready = False
        self._insist(self._stop)
        if self._settings is not None and self._settings.pulse_line is not None:
            line = self._settings.pulse_line
            self._insist(lambda: self.set_line(line, False))


def _watchdog_masks(lines: Mapping[str, bool]) -> dict[str, int]:
    """Masks over the 23 digital lines: which are set, to what, and which stay as they are."""
    numbers = {int(name.removeprefix("FIO")): high for name, high in lines.items()}
    used = sum(1 << number for number in numbers)
    masks = {
        "STATE": sum(1 << number for number, high in numbers.items() if high),
        "DIRECTION": used,
        "INHIBIT": 0x7FFFFF & ~used,
        "ENABLE": int(bool(numbers)),
    }
    return {f"WATCHDOG_DIO_{key}_DEFAULT": value for key, value in masks.items()}
