"""LabJack T7: spontaneous stream packets, calibration constants, counts to volts.

Stream packets are those of LabJack's C example for low-level streaming (t7_modbus_tcp_stream,
stream.c) and of the T-Series Datasheet, 3.2.4; calibration is that of the T-Series Datasheet,
20.0.1 T7 Calibration Constants.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cmtof.hardware.codecs import modbus
from cmtof.hardware.errors import BadReply

STREAM_HEADER_SIZE = 16
"""Bytes of a stream packet before its first sample."""
MAX_SAMPLES = 512
"""Samples of a packet over Ethernet (STREAM_MAX_SAMPLES_PER_PACKET_TCP in LabJack's example)."""
_STREAM_TYPE = 16

CALIBRATION_ADDRESS = 0x3C4000
"""Where the calibration begins in the internal flash."""
CALIBRATION_FLOATS = 41
_BLOCK = 13  # floats a read, as in LabJack's example: fits the packets of every connection

RANGES = (10.0, 1.0, 0.1, 0.01)
"""Input ranges, +- V, in the order of the gains x1, x10, x100, x1000."""


class StreamStatus(IntEnum):
    """Status of a stream packet."""

    OK = 0
    AUTO_RECOVER_ACTIVE = 2940
    """The buffer overflowed; older samples are still being sent."""
    AUTO_RECOVER_END = 2941
    """Samples flow again; the extra field is the number of scans skipped."""
    SCAN_OVERLAP = 2942
    """A scan was due before the last one was done."""
    AUTO_RECOVER_END_OVERFLOW = 2943
    """As 2941, with more skipped scans than 16 bits can count."""
    BURST_COMPLETE = 2944
    """The last packet of a burst."""


@dataclass(frozen=True)
class StreamPacket:
    """One spontaneous packet.

    Attributes
    ----------
    transaction : int
        Grows by one a packet, modulo 65536.
    backlog : int
        Bytes that wait in the device.
    status : int
        0 or one of `StreamStatus`.
    extra : int
        Scans skipped, with status 2941.
    counts : ndarray of uint16 (samples,)
        Raw samples, not calibrated.
    """

    transaction: int
    backlog: int
    status: int
    extra: int
    counts: NDArray[np.uint16]


def parse_stream_packet(frame: bytes) -> StreamPacket:
    """Packet of a whole frame from the stream port.

    Raises
    ------
    BadReply
        If it is no stream packet.
    """
    reply = modbus.parse_frame(frame)
    if len(frame) < STREAM_HEADER_SIZE or len(frame) % 2:
        raise BadReply(
            f"Expected a stream packet of {STREAM_HEADER_SIZE} bytes and whole samples, "
            f"got {len(frame)} bytes. Stop the stream and start again."
        )
    if reply.function != modbus.FEEDBACK or reply.data[0] != _STREAM_TYPE:
        raise BadReply(
            f"Expected a stream packet (function {modbus.FEEDBACK}, type {_STREAM_TYPE}), got "
            f"function {reply.function}, type {reply.data[0]}. Read the stream port only."
        )
    backlog, status, extra = struct.unpack_from(">HHH", reply.data, 2)
    counts = np.frombuffer(reply.data, ">u2", offset=8).astype(np.uint16)
    return StreamPacket(reply.transaction, backlog, status, extra, counts)


def lost_packets(before: StreamPacket, after: StreamPacket) -> int:
    """Packets that are missing between two that were received one after the other."""
    return (after.transaction - before.transaction - 1) % 0x10000


@dataclass(frozen=True)
class Gain:
    """Calibration of one input range: slopes in V per count, centre and offset."""

    positive_slope: float
    negative_slope: float
    centre: float
    offset: float

    def volts_from_counts(self, counts: ArrayLike) -> NDArray[np.float64]:
        """Volts of 16-bit stream counts, same shape.

        Below the centre ``(centre - counts) * negative slope``, else ``(counts - centre) *
        positive slope`` (LabJack's example compares an uninitialised value here; the sense is
        that of async_labjack's ``t7_ain_binary_to_volts``). The negative slope is negative.

        Examples
        --------
        >>> NOMINAL.high_speed[0].volts_from_counts([33523, 65187, 1859]).round(3).tolist()
        [0.0, 10.0, -10.0]
        """
        raw = np.asarray(counts, float)
        return np.where(
            raw < self.centre,
            (self.centre - raw) * self.negative_slope,
            (raw - self.centre) * self.positive_slope,
        )


@dataclass(frozen=True)
class Calibration:
    """Factory constants of a T7.

    Attributes
    ----------
    high_speed : tuple of Gain
        Of the converter that streams, for each of `RANGES`.
    high_resolution : tuple of Gain
        Of the T7-Pro's second converter; a T7 may hold anything there.
    dac : tuple of (slope, offset)
        Of DAC0 and DAC1, counts per V and counts.
    temperature : (slope, offset)
        Of the internal sensor, K per V and K.
    current_sources : (float, float)
        A, of the 10 uA and the 200 uA source.
    bias_current : float
        A, of the analog inputs.
    """

    high_speed: tuple[Gain, ...]
    high_resolution: tuple[Gain, ...]
    dac: tuple[tuple[float, float], tuple[float, float]]
    temperature: tuple[float, float]
    current_sources: tuple[float, float]
    bias_current: float

    def volts_from_counts(self, counts: ArrayLike, volts_range: float) -> NDArray[np.float64]:
        """Volts of stream counts taken at an input range, V; same shape."""
        return self.high_speed[gain_index(volts_range)].volts_from_counts(counts)


def _nominal(factor: float) -> Gain:
    return Gain(
        0.000315805780 * factor, -0.000315805800 * factor, 33523.0, -10.58695652200 * factor
    )


NOMINAL = Calibration(
    high_speed=tuple(_nominal(10.0**-power) for power in range(4)),
    high_resolution=tuple(_nominal(10.0**-power) for power in range(4)),
    dac=((13200.0, 0.0), (13200.0, 0.0)),
    temperature=(-92.379, 465.129),
    current_sources=(10e-6, 200e-6),
    bias_current=15e-9,
)
"""Nominal values (T-Series Datasheet, 20.0.1, and calibration.c of LabJack's example)."""


def gain_index(volts_range: float) -> int:
    """Index of an input range in `RANGES`; 0 V is the default of 10 V.

    Raises
    ------
    ValueError
        If the T7 has no such range.
    """
    for index, known in enumerate(RANGES):
        if abs((volts_range or RANGES[0]) - known) < 1e-3 * known:
            return index
    raise ValueError(
        f"Expected an input range of {', '.join(map(str, RANGES))} V, got {volts_range}. "
        "Choose one."
    )


def calibration_blocks() -> list[tuple[int, int]]:
    """Flash pointer and number of registers of each read that fetches the calibration."""
    starts = range(0, CALIBRATION_FLOATS, _BLOCK)
    return [
        (CALIBRATION_ADDRESS + 4 * start, 2 * min(_BLOCK, CALIBRATION_FLOATS - start))
        for start in starts
    ]


def parse_calibration(data: bytes) -> Calibration:
    """Calibration of the 164 bytes that the flash holds.

    Raises
    ------
    BadReply
        If the size is wrong or the streaming converter's constants cannot be true.
    """
    if len(data) != 4 * CALIBRATION_FLOATS:
        raise BadReply(
            f"Expected {4 * CALIBRATION_FLOATS} bytes of calibration, got {len(data)}. Read again."
        )
    values = struct.unpack(f">{CALIBRATION_FLOATS}f", data)
    gains = [Gain(*values[start : start + 4]) for start in range(0, 32, 4)]
    _check_gains(gains[:4])
    return Calibration(
        high_speed=tuple(gains[:4]),
        high_resolution=tuple(gains[4:]),
        dac=((values[32], values[33]), (values[34], values[35])),
        temperature=(values[36], values[37]),
        current_sources=(values[38], values[39]),
        bias_current=values[40],
    )


def _check_gains(gains: Sequence[Gain]) -> None:
    """Words that are swapped or erased (all ones) give NaN, zero or huge values."""
    for gain, nominal in zip(gains, NOMINAL.high_speed, strict=True):
        good = (
            0.5 < gain.positive_slope / nominal.positive_slope < 2
            and 0.5 < gain.negative_slope / nominal.negative_slope < 2
            and 0 < gain.centre < 0xFFFF
        )
        if not good:
            raise BadReply(
                f"Expected calibration near {nominal}, got {gain}. "
                "Read again, or restore the device's calibration."
            )
