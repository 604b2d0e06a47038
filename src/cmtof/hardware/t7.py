"""Read-out LabJack T7 over Modbus TCP: digital lines, bursts of samples, watchdog.

Registers are those of LabJack's ljm_constants.json; function 76 (feedback), reads and writes in
their order in one frame, and the packets of the stream are LabJack's own (T-Series Datasheet, 3.2.3
Stream-Out, 3.2.4 Low-Level Stream). A stream-out puts one value a scan into a whole port, whose
upper byte keeps the other lines from changing.
"""

import struct
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from math import gcd
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.hardware import device
from cmtof.hardware.device import one_error, question
from cmtof.hardware.reduction import RANGES, Gain

Register = tuple[int, str]
REGISTERS: dict[str, Register] = {
    "FIO_STATE": (2500, "H"),
    "STREAM_ENABLE": (4990, "I"),
    "USER_RAM0_U32": (46100, "I"),
    "WATCHDOG_ENABLE_DEFAULT": (61600, "I"),
    **{f"FIO{n}": (2000 + n, "H") for n in range(8)},
    **{f"TDAC{n}": (30000 + 2 * n, "f") for n in range(8)},
}
"""Address and format of the registers that are used more than once; the others stand in place."""
CALIBRATION = 0x3C4000  # in the flash: four floats for each input range
PACKET = 160  # samples at most: two or more packets a point, so that a lost one is seen at once
COMPLETE = 2944  # status of a burst's last packet; 2940 to 2943 stand for skipped scans


def write(register: str | Register, value: ArrayLike) -> bytes:
    """Part of a feedback frame that writes a register, or values one after another."""
    address, kind = REGISTERS.get(register, register)  # type: ignore[arg-type]
    data = np.atleast_1d(value).astype(f">{np.dtype(kind).str[1:]}").tobytes()
    return struct.pack(">BHB", 1, address, len(data) // 2) + data


def read(register: Register) -> bytes:
    """Part of a feedback frame that reads a register."""
    address, kind = register
    return struct.pack(">BHB", 0, address, struct.calcsize(f">{kind}") // 2)


class LabJackT7(device.Device):
    """A T7: requests to a `modbus.Feedback`, packets from a ``stream`` (pyserial).

    In the safe state the ``safe_lines`` are low and the registers ``parked`` hold 0 V.
    """

    MODELS = ("T7",)
    LIMITS: ClassVar = {"rate": (1.0, 50e3), "pulse": (2, 250)}

    def __init__(
        self,
        client: Any,
        stream: Any,
        name: str,
        serial_number: str = "",
        *,
        safe_lines: Sequence[str] = (),
        parked: Sequence[str] = (),
    ) -> None:
        super().__init__(client, name, serial_number)
        self._stream = stream
        self._safe_lines = list(safe_lines)
        self._parked = dict.fromkeys(parked, 0.0)
        self._settings: dict[Register, float] = {}
        self._waveform: dict[str | Register, ArrayLike] = {}
        self._scans = 0
        self.rate = 0.0  # of the last burst, as the converter made it, Hz

    def close(self) -> None:
        """Close both connections."""
        self._stream.close()
        self._connection.close()

    def gain(self, volts_range: float) -> Gain:
        """Calibration of an input range, V, of the converter that streams."""
        place = CALIBRATION + 16 * RANGES.index(volts_range)
        self.write_many({(61810, "I"): place})  # INTERNAL_FLASH_READ_POINTER
        gain = Gain(*self._values((61812, "fff")))  # INTERNAL_FLASH_READ
        self._expect("slope", 3.158e-5 * volts_range, gain.positive_slope, 1e-5 * volts_range)
        return gain

    def line(self, dio: str) -> bool:
        """Level of a digital line, which this makes an input."""
        return bool(self._values(dio)[0])

    def set_line(self, dio: str, high: bool) -> None:
        """Make a digital line an output at that level, and check it at the terminal."""
        self.write_many({dio: high})
        (state,) = self._values("FIO_STATE")
        self._expect(dio, high, int(state) >> int(dio[-1]) & 1)

    def write_many(self, values: Mapping[Any, ArrayLike]) -> None:
        """Write registers in their order in one frame, once."""
        self._feedback(b"".join(write(name, value) for name, value in values.items()))

    def configure_burst(
        self, *, channel: str, rate: float, scans: int, range: float, pulse_line: str, pulse: int
    ) -> None:
        """Set up bursts at a rate, Hz; a line is high for the first half of each ``pulse``."""
        self._within(rate=rate, pulse=pulse)
        if scans % pulse:
            raise ValueError(f"Expected pulses of {pulse} samples, got {scans}. Change one.")
        number = int(channel.removeprefix("AIN"))
        bit = 1 << int(pulse_line[-1])
        inhibit = (0xFF & ~bit) << 8
        self._scans = scans
        self._stream.timeout = scans / rate + 0.5
        self._settings = {
            (40000 + 2 * number, "f"): range,  # AIN_RANGE
            (41000 + number, "H"): 199,  # AIN_NEGATIVE_CH: single-ended
            (4002, "f"): rate,  # STREAM_SCANRATE_HZ
            (4004, "I"): 2,  # STREAM_NUM_ADDRESSES
            (4008, "f"): 0.0,  # STREAM_SETTLING_US: automatic
            (4014, "I"): 0,  # STREAM_CLOCK_SOURCE: its own
            (4022, "I"): 0,  # STREAM_EXTERNAL_CLOCK_DIVISOR
            (4024, "I"): 0,  # STREAM_TRIGGER_INDEX: none
            (4028, "I"): 0,  # STREAM_AUTORECOVER_DISABLE
            (4006, "I"): gcd(scans, PACKET),  # STREAM_SAMPLES_PER_PACKET
            (4010, "I"): 1,  # STREAM_RESOLUTION_INDEX
            (4012, "I"): 32768,  # STREAM_BUFFER_SIZE_BYTES
            (4016, "I"): 1,  # STREAM_AUTO_TARGET: port 702
            (4020, "I"): scans,  # STREAM_NUM_SCANS
            # the pulse before the sample, so that an edge precedes it
            (4100, "I"): 4800,  # STREAM_SCANLIST_ADDRESS0: STREAM_OUT0
            (4102, "I"): 2 * number,  # STREAM_SCANLIST_ADDRESS1: AIN
        }
        self._waveform = {
            (4018, "I"): 0,  # STREAM_DATATYPE: must be 0, and cannot be read back
            pulse_line: 0,  # also makes it an output
            (4040, "I"): REGISTERS["FIO_STATE"][0],  # STREAM_OUT0_TARGET
            (4050, "I"): 1024,  # STREAM_OUT0_BUFFER_ALLOCATE_NUM_BYTES
            (4090, "I"): 1,  # STREAM_OUT0_ENABLE
            (4060, "I"): pulse,  # STREAM_OUT0_LOOP_NUM_VALUES
            (4420, "H"): np.repeat([inhibit | bit, inhibit], [pulse // 2, pulse - pulse // 2]),
            (4070, "I"): 1,  # STREAM_OUT0_SET_LOOP
        }

    def bursts(self, requests: Iterable[Mapping[str, float]]) -> Iterator[NDArray[np.uint16]]:
        """Counts (scans,) of a burst for each request, whose registers go into its first frame."""
        self._stop()  # a waveform goes on where it stopped: one that broke off is set up again
        self._set(self._settings)
        self.write_many({(4090, "I"): 0})  # STREAM_OUT0_ENABLE
        self.write_many(self._waveform)
        for registers in requests:
            with one_error(self.name):
                self._stream.reset_input_buffer()
            self._start(registers)
            try:
                counts = self._samples()
            finally:
                self._stop()
            yield counts

    def _start(self, registers: Mapping[str, float]) -> None:
        """Write registers, start the stream and read its actual rate, in one frame."""
        values = {**registers, "STREAM_ENABLE": 1}
        frame = b"".join(write(name, value) for name, value in values.items())
        frame += read((4002, "f"))  # STREAM_SCANRATE_HZ, which reads as the actual rate
        (self.rate,) = struct.unpack(">f", self._feedback(frame, 4))
        wanted = self._settings[4002, "f"]
        self._expect("rate", wanted, self.rate, 1e-3 * wanted)

    def _samples(self) -> NDArray[np.uint16]:
        """Counts (scans,) of the packets of a burst that has been started."""
        width = 8 + gcd(self._scans, PACKET)  # words of a packet, 8 of them its head
        wanted = self._scans // (width - 8) * 2 * width
        with one_error(self.name):
            data = self._stream.read(wanted)
        words = np.frombuffer(data, ">u2", len(data) // (2 * width) * width).reshape(-1, width)
        number, _, length, function, kind, _, status, _ = words[:, :8].T
        known = (function & 0xFF == 76) & (kind == 0x1000) & (length == 2 * width - 6)
        if not (known & np.isin(status, (0, COMPLETE))).all() or (np.diff(number) != 1).any():
            self._fail(
                device.BadReply,
                "send every packet and scan",
                f"status {status.max()} or a gap",
                "Take it again.",
            )
        if len(data) < wanted:
            self._fail(device.InstrumentTimeout, "send all samples", "fewer", "Take it again.")
        return words[:, 8:].ravel().astype(np.uint16)

    def _stop(self) -> None:
        """Stop a stream; the T7 refuses that where none runs."""
        try:
            self.write_many({"STREAM_ENABLE": 0})
        except device.Refused:
            self._expect("STREAM_ENABLE", 0, *self._values("STREAM_ENABLE"))
        except device.InstrumentTimeout:  # not even this is answered: no burst will be, either
            self._fail(device.ConnectionLost, "answer", "silence", "Check power and cable.")

    def watchdog(self, seconds: int) -> None:
        """Let the device pull its safe lines low when no host speaks for so many seconds."""
        used = self._bits(self._safe_lines)
        wanted = {
            (61602, "I"): 0,  # WATCHDOG_ADVANCED_DEFAULT
            (61604, "I"): int(seconds),  # WATCHDOG_TIMEOUT_S_DEFAULT
            (61606, "I"): 0,  # WATCHDOG_STARTUP_DELAY_S_DEFAULT
            (61610, "I"): 0,  # WATCHDOG_STRICT_ENABLE_DEFAULT: any request feeds it
            (61620, "I"): 0,  # WATCHDOG_RESET_ENABLE_DEFAULT: a reset would raise the lines
            (61630, "I"): 1,  # WATCHDOG_DIO_ENABLE_DEFAULT
            (61632, "I"): 0,  # WATCHDOG_DIO_STATE_DEFAULT
            (61634, "I"): used,  # WATCHDOG_DIO_DIRECTION_DEFAULT
            (61636, "I"): 0x7FFFFF & ~used,  # WATCHDOG_DIO_INHIBIT_DEFAULT
            (61640, "I"): 0,  # WATCHDOG_DAC0_ENABLE_DEFAULT
            (61650, "I"): 0,  # WATCHDOG_DAC1_ENABLE_DEFAULT
            "WATCHDOG_ENABLE_DEFAULT": 1,
        }
        if self._values(*wanted) != tuple(wanted.values()):  # it is flash, which wears out
            self.write_many({"WATCHDOG_ENABLE_DEFAULT": 0})  # the others are locked while it runs
            self._set(wanted)

    def save_power_up_state(self) -> None:
        """Make low outputs of the safe lines what they are after power-up, too; in flash, once.

        From the factory all lines are inputs with 100 kOhm to 3.3 V then, which read as high.
        """
        self._lower_lines()
        self.write_many({(49002, "I"): 1})  # IO_CONFIG_SET_DEFAULT_TO_CURRENT

    def safe_state(self) -> None:
        """Pull the safe lines low, park the mirrors, and stop a running stream."""
        # parked twice: the mirrors cannot be read back, so nobody sees a write that was lost
        park = partial(self.write_many, self._parked)
        device.insist(self._lower_lines, park, park, self._stop)

    def _lower_lines(self) -> None:
        """Make all safe lines low outputs in one frame, and check them at the terminals."""
        self.write_many(dict.fromkeys(self._safe_lines, 0))
        (state,) = self._values("FIO_STATE")
        self._expect("safe lines", 0, int(state) & self._bits(self._safe_lines))

    def _bits(self, lines: Sequence[str]) -> int:
        """Mask of digital lines."""
        return sum(1 << int(line[-1]) for line in lines)

    def _identity(self) -> dict[str, str]:
        # PRODUCT_ID, FIRMWARE_VERSION, SERIAL_NUMBER
        product, firmware, serial = self._values((60000, "f"), (60004, "f"), (60028, "I"))
        return {
            "model": f"T{product:g}",
            "serial_number": str(serial),
            "firmware": f"{firmware:.4f}",
        }

    def _set(self, values: Mapping[Any, float]) -> None:
        """Write registers, and compare what the device holds then."""
        self.write_many(values)
        for (register, wanted), found in zip(values.items(), self._values(*values), strict=True):
            address, kind = REGISTERS.get(register) or register
            tolerance = 1e-3 * wanted if kind == "f" else 0.0
            self._expect(f"register {address}", wanted, found, tolerance)

    @question
    def _values(self, *registers: str | Register) -> tuple[float, ...]:
        """Values of registers, read in one frame."""
        frame = b""
        kinds = ">"
        for address, kind in (REGISTERS.get(one, one) for one in registers):  # type: ignore[misc]
            frame += read((address, kind))
            kinds += kind
        return struct.unpack(kinds, self._feedback(frame, struct.calcsize(kinds)))

    def _feedback(self, frame: bytes, size: int = 0) -> bytes:
        """Bytes of the reads in a feedback frame."""
        with one_error(self.name):
            try:
                answer = self._connection.ask(frame)
            except device.Refused as refusal:
                detail = self._connection.ask(read((55000, "H")))  # LAST_ERR_DETAIL
                code = int.from_bytes(detail, "big")
                raise device.Refused(f"{refusal} LabJack's error code is {code}.") from None
        if len(answer) != size:
            self._connection.close()
            self._fail(device.BadReply, f"send {size} bytes", f"{answer!r}", "Ask again.")
        return answer
