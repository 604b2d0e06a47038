"""Driver of the read-out LabJack T7 over Modbus TCP: lines, bursts of samples, watchdog.

Registers are those of LabJack's ljm_constants.json, in t7.yml; function 76 (feedback), reads and
writes in their order in one frame, and the packets of the stream are LabJack's own (T-Series
Datasheet, 3.2.3 Stream-Out, 3.2.4 Low-Level Stream). A stream-out puts one value a scan into a
whole port, whose upper byte keeps the other lines from changing.
"""

import struct
from collections.abc import Iterator, Sequence
from functools import partial
from math import gcd
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from cmtof.files import read_document
from cmtof.hardware.device import (
    BadReply,
    ConnectionLost,
    Device,
    InstrumentTimeout,
    Refused,
    insist,
    one_error,
    question,
)
from cmtof.hardware.reduction import Gain
from cmtof.hardware.roles import Registers, Requests
from cmtof.types import Counts, Texts, Values

# Address and type of each register by LabJack's name.
REGISTERS = read_document(Path(__file__).with_name("t7.yml"))
VOLTS_RANGE = 10.0  # of the inputs, V
CALIBRATION = 0x3C4000  # of that range, in the flash
PACKET = 160  # samples at most: two or more packets a point, so that a lost one is seen at once
COMPLETE = 2944  # status of a burst's last packet; 2940 to 2943 stand for skipped scans


def write_request(values: Registers) -> bytes:
    """Bytes of a feedback frame that writes registers in order; an array fills consecutive ones."""
    frame = b""
    for register, value in values.items():
        address, kind = REGISTERS[register]
        data = np.array(value, f">{kind}").tobytes()
        frame += struct.pack(">BHB", 1, address, len(data) // 2) + data
    return frame


def read_request(register: str) -> bytes:
    """Bytes of the part of a feedback frame that reads a register."""
    address, kind = REGISTERS[register]
    return struct.pack(">BHB", 0, address, struct.calcsize(f">{kind}") // 2)


class LabJackT7(Device):
    """A T7: requests to a `modbus.Feedback`, packets from its ``stream`` (pyserial).

    In the safe state the ``safe_lines`` are low and the registers ``parked`` hold 0 V.
    """

    MODELS = ("T7",)
    # the rate of all addresses together
    LIMITS: ClassVar = {"rate": (1.0, 100e3), "pulse": (2, 250)}

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
        self.stream = stream
        self._safe_lines = safe_lines
        self._parked = dict.fromkeys(parked, 0.0)
        self.rate = 0.0  # actual sample rate of the last burst, Hz

    def close(self) -> None:
        """Close both connections."""
        self.stream.close()
        self._connection.close()

    def gain(self) -> Gain:
        """Calibration of the inputs, read from the device's flash."""
        self.write_many({"INTERNAL_FLASH_READ_POINTER": CALIBRATION})
        gain = Gain(*self._values("INTERNAL_FLASH_READ"))
        self._expect("slope", 3.158e-4, gain.positive_slope, 1e-4)
        return gain

    def line(self, dio: str) -> bool:
        """Level of a digital line, True if high; reading makes it an input."""
        return bool(self._values(dio)[0])

    def set_line(self, dio: str, high: bool) -> None:
        """Make a digital line an output, high or low, and read its level back."""
        self.write_many({dio: high})
        (state,) = self._values("FIO_STATE")
        self._expect(dio, high, int(state) >> int(dio[-1]) & 1)

    def write_many(self, values: Registers) -> None:
        """Write registers by name, in order, in one frame that is never repeated."""
        self._feedback(write_request(values))

    def configure_burst(
        self,
        *,
        channels: Sequence[str],
        rate: float,
        scans: int,
        pulse_line: str,
        pulse: int,
    ) -> None:
        """Set up bursts of inputs; a line is high in the first half of each ``pulse`` samples."""
        self._within(rate=rate * (1 + len(channels)), pulse=pulse)
        if scans % pulse:
            raise ValueError(
                f"Expected bursts of whole pulses of {pulse} samples, got {scans}. Change one."
            )
        bit = self._bits([pulse_line])
        inhibit = (0xFF & ~bit) << 8
        self._size = scans * len(channels)
        self.stream.timeout = scans / rate + 0.5
        self._settings = {
            "STREAM_SCANRATE_HZ": rate,
            "STREAM_NUM_ADDRESSES": 1 + len(channels),
            "STREAM_SETTLING_US": 0.0,  # automatic
            "STREAM_CLOCK_SOURCE": 0,  # its own
            "STREAM_EXTERNAL_CLOCK_DIVISOR": 0,
            "STREAM_TRIGGER_INDEX": 0,  # none
            "STREAM_AUTORECOVER_DISABLE": 0,
            "STREAM_SAMPLES_PER_PACKET": gcd(self._size, PACKET),
            "STREAM_RESOLUTION_INDEX": 1,
            "STREAM_BUFFER_SIZE_BYTES": 32768,
            "STREAM_AUTO_TARGET": 1,  # port 702
            "STREAM_NUM_SCANS": scans,
            # the pulse before the sample, so that an edge precedes it
            "STREAM_SCANLIST_ADDRESS0": 4800,  # STREAM_OUT0
        }
        for place, channel in enumerate(channels, 1):
            self._settings |= {
                f"{channel}_RANGE": VOLTS_RANGE,
                f"{channel}_NEGATIVE_CH": 199,  # single-ended
                f"STREAM_SCANLIST_ADDRESS{place}": 2 * int(channel[-1]),
            }
        self._waveform = {
            "STREAM_DATATYPE": 0,  # must be 0, and cannot be read back
            pulse_line: 0,  # also makes it an output
            "STREAM_OUT0_TARGET": REGISTERS["FIO_STATE"][0],
            "STREAM_OUT0_BUFFER_ALLOCATE_NUM_BYTES": 1024,
            "STREAM_OUT0_ENABLE": 1,
            "STREAM_OUT0_LOOP_NUM_VALUES": pulse,
            "STREAM_OUT0_BUFFER_U16": np.repeat(
                [inhibit | bit, inhibit], [pulse // 2, pulse - pulse // 2]
            ),
            "STREAM_OUT0_SET_LOOP": 1,
        }

    def bursts(self, requests: Requests) -> Iterator[Counts]:
        """Counts of one burst per request, whose registers are written in the starting frame."""
        self._stop()  # a waveform goes on where it stopped: one that broke off is set up again
        self._set(self._settings)
        self.write_many({"STREAM_OUT0_ENABLE": 0})
        self.write_many(self._waveform)
        for registers in requests:
            with one_error(self.name):
                self.stream.reset_input_buffer()
            self._start(registers)
            try:
                counts = self._samples()
            finally:
                self._stop()
            yield counts

    def _start(self, registers: Registers) -> None:
        """Write registers, start the stream and read its actual rate, in one frame."""
        frame = write_request({**registers, "STREAM_ENABLE": 1})
        frame += read_request("STREAM_SCANRATE_HZ_ACTUAL")
        (self.rate,) = struct.unpack(">f", self._feedback(frame, 4))
        wanted = self._settings["STREAM_SCANRATE_HZ"]
        self._expect("rate", wanted, self.rate, 1e-3 * wanted)

    def _samples(self) -> Counts:
        """Counts, 16-bit, of a running burst, read from the packets of the stream."""
        size = self._settings["STREAM_SAMPLES_PER_PACKET"]
        packet = np.dtype([("head", ">u2", 8), ("counts", ">u2", size)])
        wanted = self._size // size * packet.itemsize
        with one_error(self.name):
            data = self.stream.read(wanted)
        packets = np.frombuffer(data, packet, len(data) // packet.itemsize)
        number, _, length, function, kind, _, status, _ = packets["head"].T
        known = (function & 0xFF == 76) & (kind == 0x1000)
        known &= length == packet.itemsize - 6
        if (
            not (known & np.isin(status, (0, COMPLETE))).all()
            or (np.diff(number) != 1).any()
        ):
            self._fail(
                BadReply,
                "send every packet and scan",
                f"status {status.max()} or a gap",
                "Take it again.",
            )
        if len(data) < wanted:
            self._fail(InstrumentTimeout, "send all samples", "fewer", "Take it again.")
        return packets["counts"].ravel().astype(np.uint16)

    def _stop(self) -> None:
        """Stop the stream; no error if none runs."""
        try:
            self.write_many({"STREAM_ENABLE": 0})
        except Refused:
            self._expect("STREAM_ENABLE", 0, *self._values("STREAM_ENABLE"))
        except InstrumentTimeout:  # not even this is answered: no burst will be, either
            self._fail(ConnectionLost, "answer", "silence", "Check power and cable.")

    def watchdog(self, seconds: int) -> None:
        """Set the watchdog: safe lines go low when no request comes for so many seconds."""
        used = self._bits(self._safe_lines)
        wanted: Values = {
            "WATCHDOG_ADVANCED_DEFAULT": 0,
            "WATCHDOG_TIMEOUT_S_DEFAULT": seconds,
            "WATCHDOG_STARTUP_DELAY_S_DEFAULT": 0,
            "WATCHDOG_STRICT_ENABLE_DEFAULT": 0,  # any request feeds it
            "WATCHDOG_RESET_ENABLE_DEFAULT": 0,  # a reset would raise the lines
            "WATCHDOG_DIO_ENABLE_DEFAULT": 1,
            "WATCHDOG_DIO_STATE_DEFAULT": 0,
            "WATCHDOG_DIO_DIRECTION_DEFAULT": used,
            "WATCHDOG_DIO_INHIBIT_DEFAULT": 0x7FFFFF & ~used,
            "WATCHDOG_DAC0_ENABLE_DEFAULT": 0,
            "WATCHDOG_DAC1_ENABLE_DEFAULT": 0,
            "WATCHDOG_ENABLE_DEFAULT": 1,
        }
        # it is flash, which wears out
        if self._values(*wanted) != tuple(wanted.values()):
            # the others are locked while it runs
            self.write_many({"WATCHDOG_ENABLE_DEFAULT": 0})
            self._set(wanted)

    def save_power_up_state(self) -> None:
        """Store low outputs of the safe lines as the power-up state; once, as it wears the flash.

        From the factory all lines are inputs with 100 kOhm to 3.3 V then, which read as high.
        """
        self._lower_lines()
        self.write_many({"IO_CONFIG_SET_DEFAULT_TO_CURRENT": 1})

    def safe_state(self) -> None:
        """Pull the safe lines low, park the mirrors, and stop a running stream."""
        # parked twice: the mirrors cannot be read back, so nobody sees a write that was lost
        park_mirrors = partial(self.write_many, self._parked)
        insist(self._lower_lines, park_mirrors, park_mirrors, self._stop)

    def _lower_lines(self) -> None:
        """Make all safe lines low outputs in one frame, and read their levels back."""
        self.write_many(dict.fromkeys(self._safe_lines, 0))
        (state,) = self._values("FIO_STATE")
        self._expect("safe lines", 0, int(state) & self._bits(self._safe_lines))

    def _bits(self, lines: Sequence[str]) -> int:
        """Bit mask of digital lines such as FIO0."""
        return sum(1 << int(line[-1]) for line in lines)

    def _identity(self) -> Texts:
        product, firmware, serial = self._values(
            "PRODUCT_ID", "FIRMWARE_VERSION", "SERIAL_NUMBER"
        )
        return {
            "model": f"T{product:g}",
            "serial_number": str(serial),
            "firmware": f"{firmware:.4f}",
        }

    def _set(self, values: Values) -> None:
        """Write registers and read them back; `Refused` if one differs."""
        self.write_many(values)
        for (name, wanted), found in zip(
            values.items(), self._values(*values), strict=True
        ):
            tolerance = 1e-3 * wanted if REGISTERS[name][1] == "f" else 0.0
            self._expect(name, wanted, found, tolerance)

    @question
    def _values(self, *registers: str) -> tuple[float, ...]:
        """Values of registers, by name, read in one frame."""
        kinds = struct.Struct(">" + "".join(REGISTERS[name][1] for name in registers))
        return kinds.unpack(
            self._feedback(b"".join(map(read_request, registers)), kinds.size)
        )

    def _feedback(self, frame: bytes, size: int = 0) -> bytes:
        """Answer of ``size`` bytes to a feedback frame: the values that it reads."""
        with one_error(self.name):
            try:
                answer = self._connection.ask(frame)
            except Refused as refusal:
                detail = self._connection.ask(read_request("LAST_ERR_DETAIL"))
                code = int.from_bytes(detail, "big")
                raise Refused(f"{refusal} LabJack's error code is {code}.") from None
        if len(answer) != size:
            self._connection.close()
            self._fail(BadReply, f"send {size} bytes", f"{answer!r}", "Ask again.")
        return answer
