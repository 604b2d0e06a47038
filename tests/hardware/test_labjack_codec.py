"""The T7's stream packets and calibration, against LabJack's published layout and constants."""

import math
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cmtof.hardware.codecs import labjack, modbus
from cmtof.hardware.codecs.labjack import NOMINAL, Calibration, Gain, StreamPacket, StreamStatus
from cmtof.hardware.errors import BadReply, InstrumentError

U16 = st.integers(0, 0xFFFF)


def packet(counts, *, transaction=1, backlog=0, status=0, extra=0):
    """Field by field as in LabJack's stream.c and the BLAST telescope's public flight code."""
    body = struct.pack(">BBBBHHH", 1, 76, 16, 0, backlog, status, extra)
    body += struct.pack(f">{len(counts)}H", *counts)
    return struct.pack(">HHH", transaction, 0, len(body)) + body


# Written out by hand from that layout: a packet of 3 samples, 2 scans skipped.
BY_HAND = bytes.fromhex("002a 0000 0010 01 4c 10 00 0100 0b7d 0002 82f3 0000 ffff")


def test_packet_of_the_published_layout():
    found = labjack.parse_stream_packet(BY_HAND)
    assert (found.transaction, found.backlog, found.extra) == (42, 256, 2)
    assert found.status == StreamStatus.AUTO_RECOVER_END == 2941
    assert found.counts.dtype == np.uint16
    assert found.counts.tolist() == [0x82F3, 0, 0xFFFF]
    size = labjack.STREAM_HEADER_SIZE + 2 * found.counts.size
    assert modbus.bytes_to_come(BY_HAND[:7]) == size - 7


@given(
    arrays(np.uint16, st.integers(0, labjack.MAX_SAMPLES)),
    U16,
    U16,
    U16,
    U16,
)
def test_packets_round_trip(counts, transaction, backlog, status, extra):
    frame = packet(
        counts.tolist(), transaction=transaction, backlog=backlog, status=status, extra=extra
    )
    assert len(frame) <= modbus.MAX_FRAME
    found = labjack.parse_stream_packet(frame)
    assert (found.transaction, found.backlog) == (transaction, backlog)
    assert (found.status, found.extra) == (status, extra)
    np.testing.assert_array_equal(found.counts, counts)


@pytest.mark.parametrize(
    ("before", "after", "lost"),
    [(1, 2, 0), (1, 4, 2), (0xFFFF, 0, 0), (0xFFFE, 1, 2), (5, 5, 65535)],
)
def test_lost_packets_are_counted(before, after, lost):
    pair = [labjack.parse_stream_packet(packet([], transaction=t)) for t in (before, after)]
    assert labjack.lost_packets(*pair) == lost


@pytest.mark.parametrize(
    ("frame", "problem"),
    [
        (b"", "Expected 7 bytes of header"),
        (BY_HAND[:-1], "Expected a frame of 22 bytes, got 21"),
        (bytes.fromhex("002a0000000401 4c 10 00"), "stream packet of 16 bytes and whole samples"),
        (bytes.fromhex("002a0000000b014c10000100000000 0001"), "got 17 bytes"),
        (BY_HAND.replace(b"\x4c\x10", b"\x03\x10"), "got function 3, type 16"),
        (BY_HAND.replace(b"\x4c\x10", b"\x4c\x11"), "got function 76, type 17"),
        (BY_HAND.replace(b"\x00\x10\x01", b"\xff\xff\x01"), "length 65535"),
    ],
)
def test_bad_packets_by_their_message(frame, problem):
    with pytest.raises(BadReply) as caught:
        labjack.parse_stream_packet(frame)
    assert problem in str(caught.value)


@given(
    st.one_of(
        st.binary(max_size=80),
        st.binary(max_size=80).map(
            lambda d: struct.pack(">HHHBBB", 1, 0, len(d) + 3, 1, 76, 16) + d
        ),
    )
)
def test_garbage_is_a_bad_reply(frame):
    try:
        found = labjack.parse_stream_packet(frame)
    except BadReply as error:
        assert isinstance(error, InstrumentError)
        assert str(error).startswith("Expected ")
    else:
        assert isinstance(found, StreamPacket)
        assert len(frame) == labjack.STREAM_HEADER_SIZE + 2 * found.counts.size


def test_calibration_is_read_as_in_labjacks_example():
    # calibration.c: four reads of 13, 13, 13 and 2 floats from 0x3C4000, two registers each
    assert labjack.calibration_blocks() == [
        (0x3C4000, 26),
        (0x3C4000 + 52, 26),
        (0x3C4000 + 104, 26),
        (0x3C4000 + 156, 4),
    ]
    assert 2 * sum(count for _, count in labjack.calibration_blocks()) == 164


def flash(high_speed=NOMINAL.high_speed, high_resolution=NOMINAL.high_resolution):
    """The 41 floats in the order of the datasheet's Device_Calibration (20.0.1)."""
    gains = [
        value
        for gain in (*high_speed, *high_resolution)
        for value in (gain.positive_slope, gain.negative_slope, gain.centre, gain.offset)
    ]
    others = [13200.0, 0.0, 13200.0, 0.0, -92.379, 465.129, 10e-6, 200e-6, 15e-9]
    return struct.pack(">41f", *gains, *others)


def test_calibration_of_the_flash():
    found = labjack.parse_calibration(flash())
    assert isinstance(found, Calibration)
    for gain, nominal in zip(found.high_speed, NOMINAL.high_speed, strict=True):
        assert gain.positive_slope == pytest.approx(nominal.positive_slope, rel=1e-7)
        assert gain.offset == pytest.approx(nominal.offset, rel=1e-7)
    assert found.dac == ((13200.0, 0.0), (13200.0, 0.0))
    assert found.temperature == pytest.approx((-92.379, 465.129))
    assert found.current_sources == pytest.approx((10e-6, 200e-6))
    assert found.bias_current == pytest.approx(15e-9)


def test_second_converter_of_a_t7_may_hold_anything():
    erased = tuple(Gain(math.nan, math.nan, math.nan, math.nan) for _ in range(4))
    found = labjack.parse_calibration(flash(high_resolution=erased))
    assert found.volts_from_counts(33523, 10.0) == 0.0


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"", "Expected 164 bytes of calibration, got 0"),
        (flash()[:-4], "got 160"),
        (bytes(164), "Expected calibration near"),
        (b"\xff" * 164, "Expected calibration near"),  # erased flash: NaN
        (b"".join(flash()[n + 2 : n + 4] + flash()[n : n + 2] for n in range(0, 164, 4)), "near"),
        (flash(high_speed=(Gain(1.0, -1.0, 33523.0, 0.0), *NOMINAL.high_speed[1:])), "near"),
        (flash(high_speed=(Gain(3e-4, -3e-4, 70000.0, 0.0), *NOMINAL.high_speed[1:])), "near"),
    ],
    ids=["none", "cut", "zeros", "erased", "words swapped", "slope", "centre"],
)
def test_bad_calibration_by_its_message(data, problem):
    with pytest.raises(BadReply) as caught:
        labjack.parse_calibration(data)
    assert problem in str(caught.value)


@given(st.binary(min_size=150, max_size=170))
def test_garbage_calibration_is_a_bad_reply(data):
    with pytest.raises(BadReply):
        labjack.parse_calibration(data)


@pytest.mark.parametrize("index", range(4))
def test_counts_to_volts_agree_with_the_published_offset(index):
    # 20.0.1 states slope, centre and the voltage at zero counts; they agree to 0.2 mV on +-10 V
    gain = NOMINAL.high_speed[index]
    assert gain.volts_from_counts(0) == pytest.approx(gain.offset, rel=2e-5)


@given(arrays(np.uint16, st.integers(1, 50)), st.sampled_from(labjack.RANGES))
def test_counts_to_volts_grow_and_follow_the_range(counts, volts_range):
    # async_labjack calibrations.rs, t7_ain_binary_to_volts, written as a loop
    gain = NOMINAL.high_speed[labjack.gain_index(volts_range)]
    expected = [
        (gain.centre - c) * gain.negative_slope
        if c < gain.centre
        else (c - gain.centre) * gain.positive_slope
        for c in counts.tolist()
    ]
    volts = NOMINAL.volts_from_counts(counts, volts_range)
    np.testing.assert_allclose(volts, expected, rtol=1e-12)
    order = np.argsort(counts)
    assert np.all(np.diff(volts[order]) >= 0)
    assert np.all(np.abs(volts) < 1.06 * volts_range)


def test_zero_is_the_default_range_and_others_are_refused():
    assert labjack.gain_index(0.0) == labjack.gain_index(10.0) == 0
    assert labjack.gain_index(float(np.float32(0.01))) == 3
    with pytest.raises(ValueError, match=r"Expected an input range of 10\.0, .* V, got 5\.0"):
        labjack.gain_index(5.0)
