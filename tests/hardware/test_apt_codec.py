"""Thorlabs APT: published frames, an independent codec (thorlabs_apt_protocol), and garbage."""

import struct

import pytest
import thorlabs_apt_protocol as reference
from hypothesis import given
from hypothesis import strategies as st

from cmtof.hardware.codecs import apt
from cmtof.hardware.codecs.apt import Message, MessageId, Motion, Status, Unpacker
from cmtof.hardware.errors import BadReply

I32 = st.integers(-(2**31), 2**31 - 1)
U32 = st.integers(0, 2**32 - 1)
BAY = 0x22  # second bay of a rack: the protocol document's examples are for a BSC203


def frame(text):
    return bytes.fromhex(text)


@pytest.mark.parametrize(
    ("built", "expected"),
    [
        # thorlabs-apt-protocol README: home and move to 2048
        (apt.move_home(), frame("43 04 01 00 50 01")),
        (apt.move_absolute(2048), frame("53 04 06 00 d0 01 01 00 00 08 00 00")),
        # 10 mm at the 34554.96 counts per mm of the protocol document of 28 Nov 2022
        (apt.move_absolute(round(10 * 34554.96)), frame("5304 0600 d0 01 0100 ce450500")),
        # Thorlabs, APT Communications Protocol, examples of MOT_MOVE_ABSOLUTE and
        # MOT_SET_POSCOUNTER (200000 counts, bay), as quoted in pnpq's tests
        (
            Message(0x0453, data=struct.pack("<Hi", 1, 200000), destination=BAY).to_bytes(),
            frame("5304 0600 A2 01 0100 400D0300"),
        ),
        (
            Message(0x0410, data=struct.pack("<Hi", 1, 200000), destination=BAY).to_bytes(),
            frame("1004 0600 A2 01 0100 400D0300"),
        ),
        # pnpq, test_protocol.py
        (apt.enable(False), frame("10 02 01 02 50 01")),
        (apt.request_enabled(), frame("11 02 01 00 50 01")),
        (apt.identify(), frame("23 02 01 00 50 01")),
        (apt.request_position(), frame("11 04 01 00 50 01")),
        (apt.request_status(), frame("90 04 01 00 50 01")),
        (apt.request_status(stepper=True), frame("80 04 01 00 50 01")),
        (apt.acknowledge(), frame("92 04 00 00 50 01")),
    ],
)
def test_frames_of_public_documents(built, expected):
    assert built == expected


TO = {"dest": 0x50, "source": 1}


@pytest.mark.parametrize(
    ("built", "expected"),
    [
        (apt.request_info(), reference.hw_req_info(**TO)),
        (apt.no_flash_programming(), reference.hw_no_flash_programming(**TO)),
        (apt.start_updates(), reference.hw_start_updatemsgs(**TO)),
        (apt.stop_updates(), reference.hw_stop_updatemsgs(**TO)),
        (apt.identify(2), reference.mod_identify(**TO, chan_ident=2)),
        (apt.enable(True), reference.mod_set_chanenablestate(**TO, chan_ident=1, enable_state=1)),
        (apt.request_enabled(), reference.mod_req_chanenablestate(**TO, chan_ident=1)),
        (apt.request_position(), reference.mot_req_poscounter(**TO, chan_ident=1)),
        (apt.request_velocity(), reference.mot_req_velparams(**TO, chan_ident=1)),
        (apt.request_homing(), reference.mot_req_homeparams(**TO, chan_ident=1)),
        (apt.move_home(), reference.mot_move_home(**TO, chan_ident=1)),
        (apt.stop(), reference.mot_move_stop(**TO, chan_ident=1, stop_mode=1)),
        (apt.stop(profiled=True), reference.mot_move_stop(**TO, chan_ident=1, stop_mode=2)),
        (apt.request_status(), reference.mot_req_dcstatusupdate(**TO, chan_ident=1)),
        (apt.request_status(stepper=True), reference.mot_req_statusupdate(**TO, chan_ident=1)),
        (apt.acknowledge(), reference.mot_ack_dcstatusupdate(**TO)),
    ],
)
def test_short_messages_equal_the_independent_codec(built, expected):
    assert built == expected


@given(I32, I32)
def test_long_messages_equal_the_independent_codec(first, second):
    to = TO | {"chan_ident": 1}
    assert apt.move_absolute(first) == reference.mot_move_absolute(**to, position=first)
    assert apt.move_relative(first) == reference.mot_move_relative(**to, distance=first)
    assert apt.set_position(first) == reference.mot_set_poscounter(**to, position=first)
    assert apt.set_velocity(first, second) == reference.mot_set_velparams(
        **to, min_velocity=0, acceleration=first, max_velocity=second
    )
    assert apt.set_homing(apt.Homing(1, 2, 1, first, second)) == reference.mot_set_homeparams(
        **to, home_dir=2, limit_switch=1, home_velocity=first, offset_distance=second
    )


@pytest.mark.parametrize("counts", [2**31, -(2**31) - 1])
def test_moves_beyond_32_bits_are_refused(counts):
    with pytest.raises(ValueError, match="Expected MOT_MOVE_ABSOLUTE within 32 bits, got"):
        apt.move_absolute(counts)


# From a unit to the host. Messages with a citation are theirs, the others follow the layouts of
# the APT Communications Protocol.
INFO = struct.pack("<I8sHBBBB58sHHHH", 55000001, b"K10CR1\0\0", 16, 3, 2, 1, 0, b"", 8, 1, 0, 1)
REPLIES = [
    # pnpq test_protocol.py: "from testing with a real K10CR1 waveplate"
    (
        "6404 0e00 81 50 0100 68aaa001 0000 0000 30000080",
        Motion(
            MessageId.MOT_MOVE_COMPLETED,
            1,
            0x01A0AA68,
            Status.MOVING_CW | Status.MOVING_CCW | Status.ENABLED,
            0,
        ),
    ),
    # the same file: a short MOVE_COMPLETED, a status update of a stepper and one of a DC motor
    ("6404 0100 01 22", Motion(MessageId.MOT_MOVE_COMPLETED, 1)),
    (
        "8104 0e00 81 22 0100 01000000 00000000 07000000",
        Motion(MessageId.MOT_GET_STATUSUPDATE, 1, 1, Status(7), 0),
    ),
    (
        "9104 0e00 81 22 0100 00000001 0001 FFFF 07000000",
        Motion(MessageId.MOT_GET_DCSTATUSUPDATE, 1, 16777216, Status(7), 256),
    ),
    (
        "9104 0e00 81 50 0100 ffffffff feff 0000 10040080",
        Motion(
            MessageId.MOT_GET_DCSTATUSUPDATE,
            1,
            -1,
            Status.MOVING_CW | Status.HOMED | Status.ENABLED,
            -2,
        ),
    ),
    ("4404 0102 01 50", apt.Homed(1)),
    ("6604 0100 01 50", Motion(MessageId.MOT_MOVE_STOPPED, 1)),
    ("1202 0101 01 50", apt.ChannelEnabled(1, True)),
    ("1202 0102 01 50", apt.ChannelEnabled(1, False)),
    ("1204 0600 81 50 0100 400D0300", apt.Position(1, 200000)),
    (
        "1504 0e00 81 50 0100 00000000 b1020000 00f00a00",
        apt.Velocity(1, 0, 689, 716800),
    ),
    (
        "4204 0e00 81 50 0100 0200 0100 00f00a00 30750000",
        apt.Homing(1, 2, 1, 716800, 30000),
    ),
    ("2a04 0600 81 50 0100 00040080", apt.StatusBits(1, Status.HOMED | Status.ENABLED)),
    ("8000 0000 01 50", apt.Fault()),
    (
        "8100 4400 81 50 5304 0700" + b"out of range".hex() + "00" * 52,
        apt.Fault(0x453, 7, "out of range"),
    ),
    (
        "0600 5400 81 50" + INFO.hex(),
        apt.HardwareInfo(55000001, "K10CR1", "1.2.3", 8, 1),
    ),
]


@pytest.mark.parametrize(("text", "expected"), REPLIES, ids=[text[:9] for text, _ in REPLIES])
def test_replies(text, expected):
    (message,) = Unpacker().feed(frame(text))
    assert apt.parse_message(message) == expected
    assert message.to_bytes() == frame(text)


@given(I32, st.integers(-(2**15), 2**15 - 1), U32)
def test_status_agrees_with_the_independent_codec(position, velocity, bits):
    data = struct.pack("<HihHI", 1, position, velocity, 0, bits)
    sent = Message(MessageId.MOT_GET_DCSTATUSUPDATE, data=data, destination=1, source=0x50)
    theirs = reference.Unpacker()
    theirs.feed(sent.to_bytes())
    (other,) = list(theirs)
    ours = apt.parse_message(Unpacker().feed(sent.to_bytes())[0])
    assert isinstance(ours, Motion)
    status = ours.status
    assert status is not None
    assert (ours.counts, ours.velocity) == (other.position, other.velocity)
    assert bool(status & Status.HOMED) == other.homed
    assert bool(status & Status.HOMING) == other.homing
    assert bool(status & Status.SETTLED) == other.settled
    assert bool(status & Status.TRACKING) == other.tracking
    assert bool(status & Status.MOTION_ERROR) == other.motion_error
    assert bool(status & Status.CURRENT_LIMIT) == other.motor_current_limit_reached
    assert bool(status & Status.ENABLED) == other.channel_enabled
    assert status.moving == any(
        (
            other.moving_forward,
            other.moving_reverse,
            other.jogging_forward,
            other.jogging_reverse,
            other.homing,
        )
    )


def test_hardware_info_agrees_with_the_independent_codec():
    theirs = reference.Unpacker()
    theirs.feed(frame(REPLIES[-1][0]))
    (other,) = list(theirs)
    ours = REPLIES[-1][1]
    assert (other.serial_number, other.nchs) == (ours.serial, ours.channels)
    assert other.model_number.rstrip(b"\0").decode() == ours.model


@pytest.mark.parametrize(
    ("message", "problem"),
    [
        (Message(0x0443, (1, 0)), "Expected a message of an APT unit, got id 0x0443 with no data"),
        (Message(0x9999, (1, 0)), "id 0x9999"),
        (Message(0x0412, (1, 0)), "id 0x0412 with no data"),
        (Message(0x0412, data=b"1234567"), "id 0x0412 with 7 bytes"),
        (Message(0x0444, data=b""), "id 0x0444 with 0 bytes"),
    ],
)
def test_bad_messages_by_their_message(message, problem):
    with pytest.raises(BadReply) as caught:
        apt.parse_message(message)
    assert problem in str(caught.value)


WHOLE = [frame(text) for text, _ in REPLIES]


@given(st.lists(st.sampled_from(WHOLE), max_size=6), st.lists(st.integers(1, 40), max_size=40))
def test_pieces_of_any_size_make_the_same_messages(messages, sizes):
    stream, unpacker, found = b"".join(messages), Unpacker(), []
    for size in [*sizes, len(stream)]:
        found += unpacker.feed(stream[:size])
        stream = stream[size:]
    found += unpacker.feed(stream)
    assert [message.to_bytes() for message in found] == messages
    assert unpacker.skipped == 0
    assert unpacker.reset() == b""


# bytes that can begin no message: no identifier of a unit has them as its low byte
HARMLESS = st.binary(max_size=12).map(lambda d: bytes(b | 0xA0 if b < 0xA0 else b for b in d))


@given(st.lists(st.tuples(HARMLESS, st.sampled_from(WHOLE)), min_size=1, max_size=4))
def test_messages_survive_garbage_between_them(pairs):
    unpacker = Unpacker()
    found = unpacker.feed(b"".join(garbage + message for garbage, message in pairs))
    assert [message.to_bytes() for message in found] == [message for _, message in pairs]
    assert unpacker.skipped == sum(len(garbage) for garbage, _ in pairs)


@given(st.binary(max_size=300), st.sampled_from(WHOLE))
def test_any_garbage_is_skipped_and_what_is_found_can_be_parsed(garbage, message):
    unpacker = Unpacker()
    found = unpacker.feed(garbage)
    # at most one message (90 bytes) can be kept waiting by what looked like a beginning
    found += unpacker.feed(bytes(100) + message)
    for one in found:
        assert apt.parse_message(one) is not None
    assert found[-1].to_bytes() == message
    assert len(unpacker.reset()) < 90


@pytest.mark.parametrize(
    "text",
    [
        "4404 0100 02 50",  # for somebody else
        "4404 0100 01 99",  # from nobody
        "4404 0100 81 50",  # a short message that claims data
        "1204 0600 01 50",  # a long one that claims none
        "1204 ff00 81 50",  # of the wrong size
        "5304 0600 81 50",  # that only a host sends
    ],
)
def test_headers_that_no_unit_sends_are_skipped(text):
    unpacker = Unpacker()
    assert [m.id for m in unpacker.feed(frame(text) + frame("6604 0100 01 50"))] == [0x0466]
    assert unpacker.skipped == 6


def test_cut_message_waits_and_can_be_dropped():
    unpacker = Unpacker()
    assert unpacker.feed(frame("1204 0600 81 50 0100")) == []
    assert unpacker.reset() == frame("1204 0600 81 50 0100")
    assert len(unpacker.feed(frame("1204 0600 81 50 0100 400D0300"))) == 1
