"""Read-out LabJack T7 over Modbus TCP (pymodbus): digital lines, bursts of samples, watchdog.

Registers are those of LabJack's ljm_constants.json. Function 76 (feedback), which does reads and
writes in their order in one frame, and the packets of the stream are LabJack's own (T-Series
Datasheet, 3.2.3 Stream-Out, 3.2.4 Low-Level Stream); they stand here:

- A stream-out puts one value a scan into its target; targets are whole ports (FIO_STATE), whose
  upper byte keeps the other lines from changing.
- Its waveform goes on where it stopped when the stream starts again, so a burst holds whole pulses,
  and the stream-out is set up again after a burst that broke off.
- Packets come unasked on a connection of their own; a missing transaction number is a lost packet.
"""

import logging
import struct
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from cmtof.hardware.device import (
    BadReply,
    ConnectionLost,
    Device,
    InstrumentTimeout,
    Refused,
    insist,
)
from cmtof.hardware.reduction import RANGES, Gain
from cmtof.hardware.rf import port_errors

T = TypeVar("T")
REGISTERS = {
    "STREAM_SCANRATE_HZ": (4002, "f"),
    "STREAM_NUM_ADDRESSES": (4004, "I"),
    "STREAM_SAMPLES_PER_PACKET": (4006, "I"),
    "STREAM_SETTLING_US": (4008, "f"),
    "STREAM_RESOLUTION_INDEX": (4010, "I"),
    "STREAM_BUFFER_SIZE_BYTES": (4012, "I"),
    "STREAM_CLOCK_SOURCE": (4014, "I"),
    "STREAM_AUTO_TARGET": (4016, "I"),
    "STREAM_DATATYPE": (4018, "I"),
    "STREAM_NUM_SCANS": (4020, "I"),
    "STREAM_TRIGGER_INDEX": (4024, "I"),
    "STREAM_OUT0_TARGET": (4040, "I"),
    "STREAM_OUT0_BUFFER_ALLOCATE_NUM_BYTES": (4050, "I"),
    "STREAM_OUT0_LOOP_NUM_VALUES": (4060, "I"),
    "STREAM_OUT0_SET_LOOP": (4070, "I"),
    "STREAM_OUT0_ENABLE": (4090, "I"),
    "STREAM_SCANLIST_ADDRESS0": (4100, "I"),
    "STREAM_SCANLIST_ADDRESS1": (4102, "I"),
    "STREAM_OUT0_BUFFER_U16": (4420, "H"),
    "STREAM_OUT0": (4800, "H"),
    "STREAM_ENABLE": (4990, "I"),
    "FIO_STATE": (2500, "H"),
    "USER_RAM0_U32": (46100, "I"),
    "LAST_ERR_DETAIL": (55000, "H"),
    "TEST": (55100, "I"),
    "PRODUCT_ID": (60000, "f"),
    "HARDWARE_VERSION": (60002, "f"),
    "FIRMWARE_VERSION": (60004, "f"),
    "SERIAL_NUMBER": (60028, "I"),
    "WATCHDOG_ENABLE_DEFAULT": (61600, "I"),
    "WATCHDOG_TIMEOUT_S_DEFAULT": (61604, "I"),
    "WATCHDOG_DIO_ENABLE_DEFAULT": (61630, "I"),
    "WATCHDOG_DIO_STATE_DEFAULT": (61632, "I"),
    "WATCHDOG_DIO_DIRECTION_DEFAULT": (61634, "I"),
    "WATCHDOG_DIO_INHIBIT_DEFAULT": (61636, "I"),
    "INTERNAL_FLASH_READ_POINTER": (61810, "I"),
    "INTERNAL_FLASH_READ": (61812, "I"),
    **{f"FIO{n}": (2000 + n, "H") for n in range(8)},
    **{f"TDAC{n}": (30000 + 2 * n, "f") for n in range(8)},
    **{f"AIN{n}": (2 * n, "f") for n in range(14)},
    **{f"AIN{n}_RANGE": (40000 + 2 * n, "f") for n in range(14)},
    **{f"AIN{n}_NEGATIVE_CH": (41000 + n, "H") for n in range(14)},
}
"""Address and format of each register in use."""

CALIBRATION_POINTER = 0x3C4000
"""Where the calibration begins in the flash: four floats for each input range."""
PACKET = 160
"""Samples of a packet at most: two or more packets a point, so that a lost one is seen at once."""
LARGEST_LOOP = 250
"""Values of the pulse's loop at most, which travel in one frame."""
COMPLETE = 2944
"""Status of the last packet of a burst."""
_BREAKS = {
    2940: "a full buffer",
    2941: "skipped scans",
    2942: "overlapping scans",
    2943: "65535 or more skipped scans",
}
_NOT_RUNNING = 2620  # STREAM_NOT_RUNNING: stopping a stream that has ended by itself


class DeviceRefusal(Refused):
    """The T7 answered with an exception; ``detail`` is LabJack's own code."""

    detail = 0


def write(name: str, value: float) -> bytes:
    """Part of a feedback frame that writes a register.

    Examples
    --------
    >>> write("TDAC2", 2.5).hex()
    '0175340240200000'
    """
    address, kind = REGISTERS[name]
    data = struct.pack(f">{kind}", value if kind == "f" else int(value))
    return struct.pack(">BHB", 1, address, len(data) // 2) + data


@cache
def feedback_class() -> Any:
    """Request and answer of function 76 for pymodbus; ``data`` is what follows the function."""
    from pymodbus.pdu import ModbusPDU

    class Feedback(ModbusPDU):  # type: ignore[misc]
        function_code = 76

        def __init__(self, data: bytes = b"", dev_id: int = 1, transaction_id: int = 0) -> None:
            super().__init__(dev_id=dev_id, transaction_id=transaction_id)
            self.data = data

        def encode(self) -> bytes:
            return self.data

        def decode(self, data: bytes) -> None:
            self.data = bytes(data)

    return Feedback


def open_modbus(address: str, timeout: float = 1.0) -> Any:
    """Open a Modbus TCP client to ``HOST`` or ``HOST:PORT`` that asks once and waits a second.

    Raises
    ------
    ConnectionLost
        If nothing answers there.
    """
    from pymodbus.client import ModbusTcpClient

    logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # our errors say it once
    host, _, port = address.partition(":")
    client = ModbusTcpClient(host, port=int(port or 502), timeout=timeout, retries=0)
    client.register(feedback_class())
    if not client.connect():
        raise ConnectionLost(f"Expected a T7 at {address}, got none. Check address and cable.")
    return client


class LabJackT7(Device):
    """A T7 with its two connections.

    Parameters
    ----------
    client
        From `open_modbus`.
    stream
        pyserial port ``socket://HOST:702``, on which stream packets come unasked.
    name : str
    safe_levels : mapping of str to bool
        FIO lines and the levels that the device's own watchdog gives them.
    """

    def __init__(
        self, client: Any, stream: Any, name: str = "daq", safe_levels: Mapping[str, bool] = {}
    ) -> None:
        super().__init__(name)
        self._client, self._stream = client, stream
        self._safe_levels = dict(safe_levels)
        self._burst: dict[str, Any] | None = None
        self._ready = False

    def close(self) -> None:
        """Close both connections."""
        self._stream.close()
        self._client.close()

    def identify(self) -> dict[str, Any]:
        """Serial number and versions; `Refused` if it is no T7, or its words are swapped."""
        if self._value("PRODUCT_ID") != 7 or self._value("TEST") != 0x00112233:
            raise Refused(
                f"Expected a LabJack T7 at {self.name}, got another device. Check the address."
            )
        return {
            "serial_number": int(self._value("SERIAL_NUMBER")),
            "firmware": round(self._value("FIRMWARE_VERSION"), 4),
            "hardware": round(self._value("HARDWARE_VERSION"), 4),
        }

    def gain(self, volts_range: float) -> Gain:
        """Calibration of an input range, V, of the converter that streams, from the flash."""
        pointer = CALIBRATION_POINTER + 16 * RANGES.index(volts_range)
        ask = write("INTERNAL_FLASH_READ_POINTER", pointer)
        ask += struct.pack(">BHB", 0, REGISTERS["INTERNAL_FLASH_READ"][0], 8)
        gain = Gain(*struct.unpack(">3f", self._read(lambda: self._feedback(ask, 16))[:12]))
        nominal = (3.158e-5 * volts_range, -3.158e-5 * volts_range, 33523.0)
        if not all(abs(a / b - 1) < 0.1 for a, b in zip(gain, nominal, strict=True)):
            raise BadReply(
                f"Expected a calibration in the flash of {self.name}, got {gain}. "
                "Have the device calibrated."
            )
        return gain

    def line(self, dio: str) -> bool:
        """Level of a digital line, which this makes an input."""
        return bool(self._value(dio))

    def set_line(self, dio: str, high: bool) -> None:
        """Make a digital line an output at that level, and check it at the terminal."""
        self._feedback(write(dio, high))
        found = bool(int(self._value("FIO_STATE")) >> int(dio[-1]) & 1)
        if found != high:
            raise Refused(
                f"Expected {dio} of {self.name} to go {'high' if high else 'low'}, got the other "
                "level. Look for a short or another output on that line."
            )

    def write_many(self, values: Mapping[str, float]) -> None:
        """Write registers in their order in one frame, once."""
        self._feedback(b"".join(write(name, value) for name, value in values.items()))

    # --- bursts --------------------------------------------------------------------------------

    def configure_burst(
        self, *, channel: str, rate: float, scans: int, range: float, pulse_line: str, pulse: int
    ) -> None:
        """Set up bursts of ``scans`` samples of an input, with a trigger pulse.

        ``pulse_line`` is high for the first half of every ``pulse`` samples; ``rate`` is in Hz and
        the input's ``range`` in V.
        """
        if pulse > LARGEST_LOOP or scans % pulse or not 0 < rate <= 50e3:
            raise ValueError(
                f"Expected whole pulses to {LARGEST_LOOP} samples at up to 50000 scans/s, got "
                f"{scans} samples of {pulse} at {rate:g}. Change `detection`."
            )
        self._burst = {
            "scans": scans,
            "duration": scans / rate,
            "line": pulse_line,
            "pulse": pulse,
            "registers": {
                f"{channel}_RANGE": range,
                f"{channel}_NEGATIVE_CH": 199,  # single-ended
                "STREAM_SCANRATE_HZ": rate,
                "STREAM_NUM_ADDRESSES": 2,
                "STREAM_SAMPLES_PER_PACKET": max(n for n in _upto(PACKET) if scans % n == 0),
                "STREAM_RESOLUTION_INDEX": 1,
                "STREAM_BUFFER_SIZE_BYTES": min(32768, _power_of_2(4 * scans)),
                "STREAM_CLOCK_SOURCE": 0,
                "STREAM_AUTO_TARGET": 1,  # port 702
                "STREAM_NUM_SCANS": scans,
                "STREAM_TRIGGER_INDEX": 0,
                # the pulse before the sample, so that an edge precedes it
                "STREAM_SCANLIST_ADDRESS0": REGISTERS["STREAM_OUT0"][0],
                "STREAM_SCANLIST_ADDRESS1": REGISTERS[channel][0],
            },
        }
        self._prepare(self._burst)

    def _prepare(self, burst: Mapping[str, Any]) -> None:
        """Write everything that a burst depends on, and read it back."""
        self._ready = False
        self._stop()
        values = burst["registers"]
        # not read back: 0 stands for an automatic settling; the datasheet demands STREAM_DATATYPE 0
        self.write_many(values | {"STREAM_SETTLING_US": 0.0, "STREAM_DATATYPE": 0})
        number, pulse = int(burst["line"][-1]), burst["pulse"]
        inhibit = (0xFF & ~(1 << number)) << 8
        states = [inhibit | 1 << number] * (pulse // 2) + [inhibit] * (pulse - pulse // 2)
        loop = struct.pack(">BHB", 1, REGISTERS["STREAM_OUT0_BUFFER_U16"][0], pulse)
        parts = [
            write(burst["line"], 0),  # also makes it an output
            write("STREAM_OUT0_ENABLE", 0),
            write("STREAM_OUT0_TARGET", REGISTERS["FIO_STATE"][0]),
            write("STREAM_OUT0_BUFFER_ALLOCATE_NUM_BYTES", _power_of_2(4 * pulse)),
            write("STREAM_OUT0_ENABLE", 1),
            write("STREAM_OUT0_LOOP_NUM_VALUES", pulse),
            loop + struct.pack(f">{pulse}H", *states),
            write("STREAM_OUT0_SET_LOOP", 1),
        ]
        self._feedback(b"".join(parts))
        for name, wanted in values.items():
            self._expect(name, wanted, self._value(name), 1e-3 * abs(wanted))
        self._ready = True

    def bursts(self, requests: Iterable[Mapping[str, float]]) -> Iterator[NDArray[np.uint16]]:
        """Counts (scans,) of a burst for each request, in their order; nothing is repeated here.

        Raises
        ------
        BadReply
            If a packet was lost or the device skipped scans.
        InstrumentTimeout
            If samples are missing.
        ConnectionLost
            If a connection ended.
        """
        for registers in requests:
            yield self._one_burst(registers)

    def _one_burst(self, registers: Mapping[str, float]) -> NDArray[np.uint16]:
        """Write registers and start a burst in one frame, and read its samples."""
        burst = self._burst
        if burst is None:
            raise ValueError("Expected a burst to be set up, got none. Call configure_burst first.")
        if not self._ready:
            self._prepare(burst)
        self._ready = False
        port_errors(self.name, self._stream.reset_input_buffer)
        self._stream.timeout = burst["duration"] + 1.0
        self.write_many({**registers, "STREAM_ENABLE": 1})
        try:
            counts = port_errors(self.name, lambda: self._samples(burst["scans"]))
        finally:
            self._stop()
        self._ready = True
        return counts

    def _samples(self, scans: int) -> NDArray[np.uint16]:
        """Counts (scans,) of the packets of a burst that has been started."""
        parts: list[NDArray[np.uint16]] = []
        found, last, status = 0, -1, 0
        while found < scans and status != COMPLETE:
            number, status, counts = parse_packet(self._stream.read)
            if not parts and not counts.size:
                status = 0  # the end of an earlier burst, sent as a packet of its own
                continue
            if parts and number != (last + 1) % 0x10000:
                raise BadReply("Expected unbroken packets, got some missing. Take it again.")
            parts.append(counts)
            found, last = found + counts.size, number
        if found != scans:
            raise BadReply(f"Expected {scans} samples, got {found}. Take the burst again.")
        return np.concatenate(parts)

    def _stop(self) -> None:
        try:
            self.write_many({"STREAM_ENABLE": 0})
        except DeviceRefusal as refusal:
            if refusal.detail != _NOT_RUNNING:
                raise

    # --- safety --------------------------------------------------------------------------------

    def watchdog(self, seconds: int) -> None:
        """Let the device set its safe lines when no host speaks for so many seconds; 0 ends that.

        The settings live in the device's flash, so they are written only where they differ. The
        LJTick-DAC (TDAC) is not covered: mirrors stay where they are.
        """
        numbers = {int(name[-1]): high for name, high in self._safe_levels.items()}
        used = sum(1 << number for number in numbers)
        enable = "WATCHDOG_ENABLE_DEFAULT"
        wanted = {
            "WATCHDOG_TIMEOUT_S_DEFAULT": int(seconds),
            "WATCHDOG_DIO_STATE_DEFAULT": sum(high << number for number, high in numbers.items()),
            "WATCHDOG_DIO_DIRECTION_DEFAULT": used,
            "WATCHDOG_DIO_INHIBIT_DEFAULT": 0x7FFFFF & ~used,
            "WATCHDOG_DIO_ENABLE_DEFAULT": int(bool(numbers)),
        }
        changed = {name: value for name, value in wanted.items() if self._value(name) != value}
        if changed and seconds:
            # nothing else of it can be written while it runs
            self.write_many({enable: 0, **changed})
        if self._value(enable) != bool(seconds):
            self.write_many({enable: bool(seconds)})
        for name, value in ({**wanted, enable: 1} if seconds else {enable: 0}).items():
            self._expect(name, value, self._value(name))

    def safe_state(self) -> None:
        """Stop a running stream, and pull the pulse line low."""
        self._ready = False
        insist(self._stop)
        if self._burst is not None:
            insist(lambda: self.set_line(self._burst["line"], False))  # type: ignore[index]

    # --- dialogue ------------------------------------------------------------------------------

    def _value(self, name: str) -> float:
        """Value of a register (function 3); asked once more after a lost answer."""
        address, kind = REGISTERS[name]
        count = struct.calcsize(kind) // 2

        def ask() -> bytes:
            client = self._client
            found = self._exchange(
                lambda: client.read_holding_registers(address, count=count, device_id=1)
            ).registers
            if len(found) != count:
                raise BadReply(f"Expected {count} registers of {self.name}, got {len(found)}.")
            return struct.pack(f">{count}H", *found)

        return struct.unpack(f">{kind}", self._read(ask))[0]

    def _feedback(self, parts: bytes, size: int = 0) -> bytes:
        """Bytes of the reads of a feedback frame."""
        data = self._exchange(lambda: self._client.execute(False, feedback_class()(parts))).data
        if len(data) != size:
            raise BadReply(f"Expected {size} bytes of {self.name}, got {len(data)}. Ask again.")
        return data

    def _exchange(self, act: Callable[[], Any]) -> Any:
        """Answer to a request; the T7's exceptions are raised with LabJack's own code."""
        answer = self._talk(act)
        if not answer.isError():
            return answer
        address = REGISTERS["LAST_ERR_DETAIL"][0]
        more = self._talk(lambda: self._client.read_holding_registers(address, device_id=1))
        refusal = DeviceRefusal(
            f"Expected {self.name} to accept a request, got exception {answer.exception_code}, "
            f"LabJack {more.registers or 'unknown'}. Check address and value."
        )
        refusal.detail = more.registers[0] if more.registers else 0
        raise refusal

    def _talk(self, act: Callable[[], T]) -> T:
        """Do something with the client; errors of pymodbus become ours."""
        from pymodbus.exceptions import ConnectionException, ModbusException, ModbusIOException

        try:
            return act()
        except ConnectionException as error:
            raise ConnectionLost(
                f"Expected {self.name} to be there, got {error}. Check the cable."
            ) from None
        except ModbusIOException:
            raise InstrumentTimeout(
                f"Expected an answer of {self.name} in time, got none. Check it, try again."
            ) from None
        except (ModbusException, struct.error, ValueError, IndexError, AttributeError) as error:
            raise BadReply(f"Expected Modbus of {self.name}, got {error}. Ask again.") from None

    def _resynchronise(self) -> None:
        self._client.close()  # the next request connects again


def parse_packet(read: Callable[[int], bytes]) -> tuple[int, int, NDArray[np.uint16]]:
    """Transaction number, status and raw samples of the next stream packet.

    Raises
    ------
    BadReply
        If it is no stream packet, or reports that the burst is broken.
    InstrumentTimeout
        If it does not come whole.
    """
    late = InstrumentTimeout("Expected all samples of a burst in time, got fewer. Take it again.")
    header = read(16)
    if len(header) < 16:
        raise late
    number, protocol, length, function, kind, status = struct.unpack(">HHHxBBx2xH2x", header)
    if protocol or function != 76 or kind != 16 or length % 2 or not 10 <= length <= 1034:
        raise BadReply(f"Expected a stream packet, got {header.hex()}. Set the burst up again.")
    samples = np.frombuffer(data := read(length - 10), ">u2", len(data) // 2).astype(np.uint16)
    if len(data) < length - 10:
        raise late
    if status not in (0, COMPLETE):
        reason = _BREAKS.get(status, "status")
        raise BadReply(f"Expected an unbroken burst, got {reason} ({status}). Take it again.")
    return number, status, samples


def _upto(most: int) -> range:
    return range(1, most + 1)


def _power_of_2(least: int) -> int:
    """Power of 2 from ``least`` on, 64 or more."""
    return 1 << (max(least, 64) - 1).bit_length()
