"""A burst of the LabJack T7's stream: the registers that set it up, the packets that it brings.

Sources: T-Series Datasheet 3.2.3 Stream-Out and 3.2.4 Low-Level Stream; ljm_constants.json. What
they say, and what shapes this module:

- A stream-out puts one value a scan into its target; targets are whole ports (FIO_STATE), whose
  upper byte keeps the other lines from changing. No single line can be a target.
- Its waveform goes on where it stopped when the stream starts again, so a burst holds whole pulses,
  and the stream-out is set up anew after a burst that broke off.
- Packets come unasked on a connection of their own; a missing transaction number is a lost packet.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cmtof.hardware.codecs import labjack, modbus
from cmtof.hardware.codecs.registers import register
from cmtof.hardware.errors import BadReply, InstrumentTimeout
from cmtof.hardware.transport import Transport

_PACKET = 160
"""Samples of a packet at most: two or more packets a point, so that a lost one is seen at once."""

MAX_SAMPLE_RATE = 100e3
"""Samples per second of one address, T-Series Datasheet 3.2."""

_BREAKS = {
    labjack.StreamStatus.AUTO_RECOVER_ACTIVE: "a full buffer (status 2940)",
    labjack.StreamStatus.AUTO_RECOVER_END: "{extra} skipped scans (status 2941)",
    labjack.StreamStatus.SCAN_OVERLAP: "overlapping scans (status 2942)",
    labjack.StreamStatus.AUTO_RECOVER_END_OVERFLOW: "65535 or more skipped scans (status 2943)",
}


@dataclass(frozen=True, eq=False)
class Burst:
    """Samples of one burst.

    Attributes
    ----------
    counts : ndarray of uint16, shape (scans,)
        Raw, uncalibrated; `LabJackT7.volts_from_counts` makes volts of them.
    timestamp : int
        CORE_TIMER at the start, ticks of 25 ns, wraps in 107 s.
    """

    counts: NDArray[np.uint16]
    timestamp: int


@dataclass(frozen=True, kw_only=True)
class BurstSettings:
    """How a burst is taken.

    Attributes
    ----------
    channel : int
        Analog input, single-ended.
    rate : float
        Scans per second, Hz.
    scans : int
        Samples of a burst; whole pulses.
    range : float
        Input range, +- V: 10, 1, 0.1 or 0.01.
    pulse_line : str or None
        FIO line that pulses; it is high for the first half of every ``scans_per_pulse`` scans.
    scans_per_pulse : int
        Scans from one rising edge to the next.
    """

    channel: int = 0
    rate: float
    scans: int
    range: float = 10.0
    pulse_line: str | None = None
    scans_per_pulse: int = 20

    def __post_init__(self) -> None:
        labjack.gain_index(self.range)
        if not 0 <= self.channel <= 13:
            raise ValueError(f"Expected AIN0 to AIN13, got {self.channel}. Choose another.")
        top = MAX_SAMPLE_RATE / len(self.scan_list)
        if not 0 < self.rate <= top:
            raise ValueError(f"Expected up to {top:g} scans/s, got {self.rate:g}. Scan slower.")
        if self.scans < 1:
            raise ValueError(f"Expected 1 scan or more, got {self.scans}. Take more.")
        if self.pulse_line is None:
            return
        if self.pulse_line not in [f"FIO{n}" for n in range(8)]:
            raise ValueError(f"Expected FIO0 to FIO7, got {self.pulse_line!r}. Choose another.")
        if self.scans_per_pulse < 2 or self.scans % self.scans_per_pulse:
            raise ValueError(
                f"Expected whole pulses of 2 scans or more, got {self.scans} scans of "
                f"{self.scans_per_pulse} a pulse. Choose a multiple."
            )

    @property
    def scan_list(self) -> list[int]:
        """Addresses of a scan: the pulse before the sample, so that an edge precedes it."""
        first = [] if self.pulse_line is None else [register("STREAM_OUT0").address]
        return [*first, register(f"AIN{self.channel}").address]

    @property
    def samples_per_packet(self) -> int:
        """Largest divisor of the scans up to 160: no packet is cut short at the end of a burst."""
        return max(n for n in range(1, min(_PACKET, self.scans) + 1) if self.scans % n == 0)

    @property
    def duration(self) -> float:
        """Duration of a burst, s."""
        return self.scans / self.rate

    def stream_registers(self) -> dict[str, float]:
        """Values of the registers that are read back, by name."""
        values: dict[str, float] = {
            f"AIN{self.channel}_RANGE": self.range,
            f"AIN{self.channel}_NEGATIVE_CH": 199,  # single-ended
            "STREAM_SCANRATE_HZ": self.rate,
            "STREAM_NUM_ADDRESSES": len(self.scan_list),
            "STREAM_SAMPLES_PER_PACKET": self.samples_per_packet,
            "STREAM_RESOLUTION_INDEX": 1,  # what 0 stands for
            "STREAM_BUFFER_SIZE_BYTES": min(32768, _power_of_2(4 * self.scans)),
            "STREAM_CLOCK_SOURCE": 0,
            "STREAM_AUTO_TARGET": 1,  # port 702
            "STREAM_NUM_SCANS": self.scans,
            "STREAM_TRIGGER_INDEX": 0,
        }
        for index, address in enumerate(self.scan_list):
            values[f"STREAM_SCANLIST_ADDRESS{index}"] = address
        return values

    def pulse_writes(self) -> list[modbus.Write]:
        """Writes that set up the pulses from their first scan on; none without a line."""
        if self.pulse_line is None:
            return []
        high, low = port_states(int(self.pulse_line[-1]))
        half = self.scans_per_pulse // 2
        states = [high] * half + [low] * (self.scans_per_pulse - half)
        loop = b"".join(state.to_bytes(2, "big") for state in states)
        buffer = register("STREAM_OUT0_BUFFER_U16").address
        return [
            write(self.pulse_line, 0),  # also makes it an output
            write("STREAM_OUT0_ENABLE", 0),
            write("STREAM_OUT0_TARGET", register("FIO_STATE").address),
            write("STREAM_OUT0_BUFFER_ALLOCATE_NUM_BYTES", _power_of_2(2 * len(loop))),
            write("STREAM_OUT0_ENABLE", 1),
            write("STREAM_OUT0_LOOP_NUM_VALUES", self.scans_per_pulse),
            modbus.Write(buffer, loop),
            write("STREAM_OUT0_SET_LOOP", 1),
        ]


def write(name: str, value: float | str) -> modbus.Write:
    """Part of a request that writes a register by name."""
    entry = register(name)
    return modbus.Write(entry.address, entry.bytes_from_value(value))


def writes(values: Mapping[str, float]) -> list[modbus.Write]:
    """Parts that write registers by name, in their order."""
    return [write(name, value) for name, value in values.items()]


def port_states(line: int) -> tuple[int, int]:
    """FIO_STATE values that make one line high and low and leave the other seven alone.

    Examples
    --------
    >>> [hex(state) for state in port_states(4)]
    ['0xef10', '0xef00']
    """
    inhibit = (0xFF & ~(1 << line)) << 8
    return inhibit | 1 << line, inhibit


def _power_of_2(least: int) -> int:
    return 1 << (max(least, 64) - 1).bit_length()


def read_burst(stream: Transport, settings: BurstSettings, timeout: float) -> NDArray[np.uint16]:
    """Counts (scans,) of a burst that has been started.

    Parameters
    ----------
    stream : Transport
        To port 702.
    settings : BurstSettings
    timeout : float
        For the whole burst beyond its duration, s.

    Raises
    ------
    BadReply
        If a packet is missing, or the device says that scans are.
    InstrumentTimeout
        If samples are missing at the end.
    """
    deadline = time.monotonic() + settings.duration + timeout
    parts: list[NDArray[np.uint16]] = []
    last: labjack.StreamPacket | None = None
    found = 0
    while found < settings.scans:
        try:
            packet = _read_packet(stream, deadline)
        except InstrumentTimeout:
            raise InstrumentTimeout(
                f"Expected {settings.scans} samples within {settings.duration + timeout:.2f} s, "
                f"got {found}. Take the burst again."
            ) from None
        if last is None and not packet.counts.size:
            continue  # the end of an earlier burst, sent as a packet of its own
        _check_packet(last, packet)
        parts.append(packet.counts)
        found += packet.counts.size
        last = packet
        if packet.status == labjack.StreamStatus.BURST_COMPLETE and found < settings.scans:
            raise BadReply(
                f"Expected {settings.scans} samples, got the end after {found}. "
                "Take the burst again."
            )
    if found > settings.scans:
        raise BadReply(f"Expected {settings.scans} samples, got {found}. Set the burst up again.")
    return np.concatenate(parts)


def _read_packet(stream: Transport, deadline: float) -> labjack.StreamPacket:
    header = stream.read_exact(modbus.HEADER_SIZE, max(deadline - time.monotonic(), 0.0))
    rest = modbus.bytes_to_come(header)
    return labjack.parse_stream_packet(
        header + stream.read_exact(rest, max(deadline - time.monotonic(), 0.0))
    )


def _check_packet(last: labjack.StreamPacket | None, packet: labjack.StreamPacket) -> None:
    if last is not None and (lost := labjack.lost_packets(last, packet)):
        raise BadReply(f"Expected unbroken packets, got {lost} missing. Take the burst again.")
    broken = _BREAKS.get(packet.status)  # type: ignore[call-overload]
    if broken is not None:
        raise BadReply(
            f"Expected an unbroken burst, got {broken.format(extra=packet.extra)}. "
            "Take the burst again, or scan slower."
        )
    if packet.status not in (labjack.StreamStatus.OK, labjack.StreamStatus.BURST_COMPLETE):
        raise BadReply(f"Expected a known stream status, got {packet.status}. Set it up again.")
