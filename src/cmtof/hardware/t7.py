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
from collections.abc import Iterable, Iterator, Mapping
from math import gcd
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pymodbus.client import ModbusTcpClient
from pymodbus.pdu import ModbusPDU

from cmtof.hardware import device
from cmtof.hardware.device import one_error
from cmtof.hardware.reduction import RANGES, Gain

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
    "PRODUCT_ID": (60000, "f"),
    "FIRMWARE_VERSION": (60004, "f"),
    "SERIAL_NUMBER": (60028, "I"),
    "WATCHDOG_ENABLE_DEFAULT": (61600, "I"),
    "WATCHDOG_TIMEOUT_S_DEFAULT": (61604, "I"),
    "WATCHDOG_DIO_ENABLE_DEFAULT": (61630, "I"),
    "WATCHDOG_DIO_STATE_DEFAULT": (61632, "I"),
    "WATCHDOG_DIO_DIRECTION_DEFAULT": (61634, "I"),
    "WATCHDOG_DIO_INHIBIT_DEFAULT": (61636, "I"),
    "INTERNAL_FLASH_READ_POINTER": (61810, "I"),
    "INTERNAL_FLASH_READ": (61812, "fff"),
    **{f"FIO{n}": (2000 + n, "H") for n in range(8)},
    **{f"TDAC{n}": (30000 + 2 * n, "f") for n in range(8)},
    **{f"AIN{n}": (2 * n, "f") for n in range(14)},
    **{f"AIN{n}_RANGE": (40000 + 2 * n, "f") for n in range(14)},
    **{f"AIN{n}_NEGATIVE_CH": (41000 + n, "H") for n in range(14)},
}
"""Address and format of each register in use."""

CALIBRATION = 0x3C4000
"""Where the calibration begins in the flash: four floats for each input range."""
PACKET = 160
"""Samples of a packet at most: two or more packets a point, so that a lost one is seen at once."""
COMPLETE = 2944
"""Status of the last packet of a burst; 2940 to 2943 stand for scans that were skipped."""


def write(name: str, value: ArrayLike) -> bytes:
    """Part of a feedback frame that writes a register, or values one after another.

    Examples
    --------
    >>> write("TDAC2", 2.5).hex()
    '0175340240200000'
    """
    address, kind = REGISTERS[name]
    data = np.atleast_1d(value).astype(f">{np.dtype(kind).str[1:]}").tobytes()
    return struct.pack(">BHB", 1, address, len(data) // 2) + data


class Feedback(ModbusPDU):
    """Request and answer of function 76; ``data`` is what follows the function."""

    function_code, data = 76, b""

    def encode(self) -> bytes:
        """Bytes that are sent."""
        return self.data

    def decode(self, data: bytes) -> None:
        """Take the bytes that have come."""
        self.data = bytes(data)


def open_modbus(address: str, timeout: float = 1.0) -> Any:
    """Open a client to ``HOST`` or ``HOST:PORT`` that asks once, or raise `ConnectionLost`."""
    logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # our errors say it once
    host, _, port = address.partition(":")
    client = ModbusTcpClient(host, port=int(port or 502), timeout=timeout, retries=0)
    client.register(Feedback)
    if not client.connect():
        raise device.ConnectionLost(f"Expected a T7 at {address}, got none. Check the address.")
    return client


class LabJackT7(device.Device):
    """A T7 with its two connections.

    ``client`` is from `open_modbus`; stream packets come unasked on ``stream``, a pyserial port
    ``socket://HOST:702``. ``safe_levels`` of FIO lines are set by the device's own watchdog.
    """

    MODELS = ("T7",)
    LIMITS: ClassVar = {"rate": (1.0, 50e3), "pulse": (2, 250)}

    def __init__(
        self, client: Any, stream: Any, name: str = "daq", safe_levels: Mapping[str, bool] = {}
    ) -> None:
        super().__init__(client, name)
        self._stream, self._safe_levels = stream, dict(safe_levels)
        self._settings: dict[str, float] = {}
        self._waveform: dict[str, ArrayLike] = {}
        self._line, self._scans, self._ready = "", 0, False

    def close(self) -> None:
        """Close both connections."""
        self._stream.close()
        self._connection.close()

    def gain(self, volts_range: float) -> Gain:
        """Calibration of an input range, V, of the converter that streams, from the flash."""
        place = CALIBRATION + 16 * RANGES.index(volts_range)
        self.write_many({"INTERNAL_FLASH_READ_POINTER": place})
        gain = Gain(*self._values("INTERNAL_FLASH_READ"))
        nominal = (3.158e-5 * volts_range, -3.158e-5 * volts_range, 33523.0)
        if not np.allclose(gain, nominal, rtol=0.1, atol=0.0):
            self._fail(device.BadReply, "hold its calibration", str(gain), "Have it calibrated.")
        return gain

    def line(self, dio: str) -> bool:
        """Level of a digital line, which this makes an input."""
        return bool(self._values(dio)[0])

    def set_line(self, dio: str, high: bool) -> None:
        """Make a digital line an output at that level, and check it at the terminal."""
        self.write_many({dio: high})
        (state,) = self._values("FIO_STATE")
        self._expect(dio, high, int(state) >> int(dio[-1]) & 1)

    def write_many(self, values: Mapping[str, ArrayLike]) -> None:
        """Write registers in their order in one frame, once."""
        self._feedback(b"".join(write(name, value) for name, value in values.items()))

    def configure_burst(
        self, *, channel: str, rate: float, scans: int, range: float, pulse_line: str, pulse: int
    ) -> None:
        """Set up bursts of ``scans`` samples of an input, with a trigger pulse.

        ``pulse_line`` is high for the first half of every ``pulse`` samples; ``rate`` is in Hz and
        the input's ``range`` in V.
        """
        self._within("rate", rate)
        self._within("pulse", pulse)
        if scans % pulse:
            raise ValueError(f"Expected pulses of {pulse} samples, got {scans}. Change one.")
        bit = 1 << int(pulse_line[-1])
        inhibit = (0xFF & ~bit) << 8
        self._line, self._scans = pulse_line, scans
        self._stream.timeout = scans / rate + 1.0
        self._settings = {
            f"{channel}_RANGE": range,
            f"{channel}_NEGATIVE_CH": 199,  # single-ended
            "STREAM_SCANRATE_HZ": rate,
            "STREAM_NUM_ADDRESSES": 2,
            "STREAM_SAMPLES_PER_PACKET": gcd(scans, PACKET),
            "STREAM_RESOLUTION_INDEX": 1,
            "STREAM_BUFFER_SIZE_BYTES": 32768,
            "STREAM_CLOCK_SOURCE": 0,
            "STREAM_AUTO_TARGET": 1,  # port 702
            "STREAM_NUM_SCANS": scans,
            "STREAM_TRIGGER_INDEX": 0,
            # the pulse before the sample, so that an edge precedes it
            "STREAM_SCANLIST_ADDRESS0": REGISTERS["STREAM_OUT0"][0],
            "STREAM_SCANLIST_ADDRESS1": REGISTERS[channel][0],
        }
        self._waveform = {
            pulse_line: 0,  # also makes it an output
            "STREAM_OUT0_TARGET": REGISTERS["FIO_STATE"][0],
            "STREAM_OUT0_BUFFER_ALLOCATE_NUM_BYTES": 1024,
            "STREAM_OUT0_ENABLE": 1,
            "STREAM_OUT0_LOOP_NUM_VALUES": pulse,
            "STREAM_OUT0_BUFFER_U16": [inhibit | bit] * (pulse // 2)
            + [inhibit] * (pulse - pulse // 2),
            "STREAM_OUT0_SET_LOOP": 1,
        }
        self._prepare()

    def _prepare(self) -> None:
        """Write everything that a burst depends on, and read back what can be."""
        self._ready = False
        self._stop()
        self._set(self._settings)
        # an automatic settling, and what the datasheet demands without a register map
        self.write_many({"STREAM_SETTLING_US": 0, "STREAM_DATATYPE": 0, "STREAM_OUT0_ENABLE": 0})
        self.write_many(self._waveform)
        self._ready = True

    def bursts(self, requests: Iterable[Mapping[str, float]]) -> Iterator[NDArray[np.uint16]]:
        """Counts (scans,) of a burst for each request, in their order; nothing is repeated here.

        A request's registers are written in the frame that starts its burst. `BadReply` stands for
        lost packets and skipped scans, `InstrumentTimeout` for missing samples.
        """
        for registers in requests:
            if not self._ready:
                self._prepare()
            self._ready = False
            with one_error(self.name):
                self._stream.reset_input_buffer()
            self.write_many({**registers, "STREAM_ENABLE": 1})
            try:
                counts = self._samples()
            finally:
                self._stop()
            self._ready = True
            yield counts

    def _samples(self) -> NDArray[np.uint16]:
        """Counts (scans,) of the packets of a burst that has been started."""
        parts: list[NDArray[np.uint16]] = []
        found, last = 0, -1
        while found < self._scans:
            number, counts = self._packet()
            if not parts and not counts.size:
                continue  # the end of an earlier burst, sent as a packet of its own
            found += counts.size
            if (parts and number != (last + 1) % 0x10000) or found > self._scans:
                self._fail(device.BadReply, "send every packet", "some missing", "Take it again.")
            parts.append(counts)
            last = number
        return np.concatenate(parts)

    def _packet(self) -> tuple[int, NDArray[np.uint16]]:
        """Transaction number and raw samples of the next stream packet."""
        header = self._received(16)
        number, protocol, length, function, kind, status = struct.unpack(">HHHxBBx2xH2x", header)
        if (protocol, function, kind) != (0, 76, 16) or not 10 <= length <= 1034:
            self._fail(device.BadReply, "send a stream packet", header.hex(), "Take it again.")
        if status not in (0, COMPLETE):
            self._fail(device.BadReply, "skip no scan", f"status {status}", "Take it again.")
        return number, np.frombuffer(self._received(length - 10), ">u2").astype(np.uint16)

    def _received(self, size: int) -> bytes:
        with one_error(self.name):
            data = self._stream.read(size)
        if len(data) < size:
            self._fail(device.InstrumentTimeout, "send all samples", "fewer", "Take it again.")
        return data

    def _stop(self) -> None:
        """Stop a stream; the T7 refuses that where none runs."""
        try:
            self.write_many({"STREAM_ENABLE": 0})
        except device.Refused:
            self._expect("STREAM_ENABLE", 0, *self._values("STREAM_ENABLE"))

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
            "WATCHDOG_DIO_STATE_DEFAULT": sum(high << n for n, high in numbers.items()),
            "WATCHDOG_DIO_DIRECTION_DEFAULT": used,
            "WATCHDOG_DIO_INHIBIT_DEFAULT": 0x7FFFFF & ~used,
            "WATCHDOG_DIO_ENABLE_DEFAULT": 1,
            enable: 1,
        }
        wanted = wanted if seconds else {enable: 0}
        if self._values(*wanted) != tuple(wanted.values()):
            self.write_many({enable: 0})  # nothing else of it can be written while it runs
            self._set(wanted)

    def safe_state(self) -> None:
        """Stop a running stream, and pull the pulse line low."""
        self._ready = False
        device.insist(self._stop, lambda: self._line and self.set_line(self._line, False))

    def _identity(self) -> dict[str, str]:
        product, serial, firmware = self._values("PRODUCT_ID", "SERIAL_NUMBER", "FIRMWARE_VERSION")
        words = {"model": f"T{product:g}", "serial_number": str(serial)}
        return words | {"firmware": f"{firmware:.4f}"}

    def _set(self, values: Mapping[str, float]) -> None:
        """Write registers, and compare what the device holds then."""
        self.write_many(values)
        for (name, wanted), found in zip(values.items(), self._values(*values), strict=True):
            self._expect(name, wanted, found, 1e-3 * wanted if isinstance(wanted, float) else 0)

    def _values(self, *names: str) -> tuple[float, ...]:
        """Values of registers, read in one frame, asked once more after a lost answer."""
        frame, kinds = b"", ">"
        for address, kind in map(REGISTERS.__getitem__, names):
            frame += struct.pack(">BHB", 0, address, struct.calcsize(f">{kind}") // 2)
            kinds += kind
        size = struct.calcsize(kinds)
        return struct.unpack(kinds, self._read(lambda: self._feedback(frame, size)))

    def _feedback(self, frame: bytes, size: int = 0) -> bytes:
        """Bytes of the reads in a feedback frame."""
        request = Feedback(dev_id=1)
        request.data = frame
        try:
            with one_error(self.name):
                answer = self._connection.execute(False, request)
            if answer.isError():
                got = f"Modbus exception {answer.exception_code}"
                self._fail(device.Refused, "accept a request", got, "Check address and value.")
            if len(answer.data) != size:
                self._fail(device.BadReply, f"send {size} bytes", f"{answer.data!r}", "Ask again.")
        except (device.InstrumentTimeout, device.BadReply):
            self._connection.close()  # and connect again: a late answer would be the next one's
            raise
        return answer.data
