"""Modbus TCP: frames of public documents, an independent codec (pymodbus), and garbage."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymodbus.framer import FramerSocket
from pymodbus.pdu import DecodePDU
from pymodbus.pdu.register_message import (
    ReadHoldingRegistersRequest,
    ReadHoldingRegistersResponse,
    WriteMultipleRegistersRequest,
    WriteMultipleRegistersResponse,
)

from cmtof.hardware.codecs import modbus
from cmtof.hardware.codecs.modbus import ModbusException, Read, Write
from cmtof.hardware.codecs.registers import REGISTERS, register
from cmtof.hardware.errors import BadReply, InstrumentError, Refused

U16 = st.integers(0, 0xFFFF)
# Modbus Application Protocol V1.1b3, section 6.3 (read 3 registers at 107) and 6.12 (write 10 and
# 258 at 1), behind an MBAP header of the Messaging Implementation Guide V1.0b, 3.1.3.
READ_107 = bytes.fromhex("15010000000601 03 006b 0003")
READ_107_REPLY = bytes.fromhex("15010000000901 03 06 022b 0000 0064")
WRITE_1 = bytes.fromhex("15020000000b01 10 0001 0002 04 000a 0102")
WRITE_1_REPLY = bytes.fromhex("15020000000601 10 0001 0002")


def float_bytes(value):
    return struct.pack(">f", value)


@pytest.mark.parametrize(
    ("frame", "expected"),
    [
        (modbus.read_request(0x1501, 107, 3), READ_107),
        (modbus.write_request(0x1502, 1, bytes.fromhex("000a0102")), WRITE_1),
        # AIN0 to AIN3 of a T7: addresses of ljm_constants.json
        (modbus.read_request(7, 0, 8), bytes.fromhex("000700000006 01 03 0000 0008")),
        # async_labjack examples/modbus_feedback: 6 registers from AIN0 in one feedback frame
        (
            modbus.feedback_request(1, [Read(0, 6)]),
            bytes.fromhex("000100000006 01 4c 00 0000 06"),
        ),
        # the same example: 5.4321 to TEST_FLOAT32 (55124), -314 to TEST_INT32 (55122)
        (
            modbus.feedback_request(
                2,
                [
                    Write(55124, bytes.fromhex("40add3c3")),
                    Write(55122, bytes.fromhex("fffffec6")),
                ],
            ),
            bytes.fromhex("000200000012 01 4c 01 d754 02 40add3c3 01 d752 02 fffffec6"),
        ),
    ],
    ids=["read", "write", "T7 AIN0-3", "feedback read", "feedback write"],
)
def test_frames_of_public_documents(frame, expected):
    assert frame == expected


def test_replies_of_public_documents():
    assert modbus.parse_read(READ_107_REPLY, 0x1501, 3) == bytes.fromhex("022b00000064")
    modbus.parse_write(WRITE_1_REPLY, 0x1502, 1, 2)
    # bytes that async_labjack's example gives for 5.4321 and -314
    assert register("TEST_FLOAT32").bytes_from_value(5.4321).hex() == "40add3c3"
    assert register("TEST_INT32").bytes_from_value(-314).hex() == "fffffec6"


def test_feedback_answers_reads_in_their_order():
    parts = [Read(0, 2), Write(46100, bytes(4)), Read(55110, 1)]
    frame = bytes.fromhex("000900000008 01 4c c61c3c00 0011")
    assert modbus.parse_feedback(frame, 9, parts) == [b"\xc6\x1c\x3c\x00", b"\x00\x11"]
    with pytest.raises(BadReply, match="Expected 6 bytes of reads, got 0"):
        modbus.parse_feedback(bytes.fromhex("000900000002014c"), 9, parts)


def test_feedback_of_writes_alone_has_an_empty_answer():
    # async_labjack: debug_assert_eq!(words.len(), 0) behind the function code of a write
    answer = bytes.fromhex("000100000002 01 4c")
    assert modbus.bytes_to_come(answer[:7]) == 1
    assert modbus.parse_feedback(answer, 1, [Write(4990, bytes(4))]) == []


def server(decode_requests=True):
    return FramerSocket(DecodePDU(decode_requests))


@given(U16, U16, st.integers(1, 125), st.integers(0, 255))
def test_pymodbus_reads_our_requests(transaction, address, count, unit):
    if address + count > 0x10000:
        return
    frame = modbus.read_request(transaction, address, count, unit=unit)
    used, found = server().handleFrame(frame, unit, transaction)
    assert used == len(frame)
    assert isinstance(found, ReadHoldingRegistersRequest)
    assert (found.address, found.count, found.dev_id) == (address, count, unit)


@given(U16, st.integers(0, 60000), st.lists(U16, min_size=1, max_size=123))
def test_pymodbus_reads_our_writes_and_we_its_answers(transaction, address, values):
    frame = modbus.write_request(transaction, address, struct.pack(f">{len(values)}H", *values))
    _, found = server().handleFrame(frame, 1, transaction)
    assert isinstance(found, WriteMultipleRegistersRequest)
    assert (found.address, list(found.registers)) == (address, values)
    answer = WriteMultipleRegistersResponse(
        dev_id=1, transaction_id=transaction, address=address, count=len(values)
    )
    modbus.parse_write(server().buildFrame(answer), transaction, address, len(values))


@given(U16, st.lists(U16, min_size=1, max_size=125))
def test_we_read_pymodbus_answers(transaction, values):
    answer = ReadHoldingRegistersResponse(dev_id=1, transaction_id=transaction, registers=values)
    frame = server().buildFrame(answer)
    assert modbus.bytes_to_come(frame[:7]) == len(frame) - 7
    data = modbus.parse_read(frame, transaction, len(values))
    assert list(struct.unpack(f">{len(values)}H", data)) == values


@pytest.mark.parametrize("code", [1, 2, 3, 4, 6, 11, 200])
def test_exceptions(code):
    frame = struct.pack(">HHHBBB", 5, 0, 3, 1, 0x83, code)
    with pytest.raises(Refused, match=rf"function 3, got exception {code} \(") as caught:
        modbus.parse_read(frame, 5, 1)
    assert isinstance(caught.value, ModbusException)
    assert (caught.value.function, caught.value.code, caught.value.detail) == (3, code, None)


def test_exception_with_labjack_detail():
    error = ModbusException(76, 4).with_detail(2605)
    assert str(error) == (
        "Expected the device to accept Modbus function 76, got exception 4 (device failure, "
        "LabJack 2605 STREAM_IS_ACTIVE). Check address and value."
    )
    assert error.detail == 2605
    assert "LabJack 9999 unknown" in str(ModbusException(3, 99).with_detail(9999))


@pytest.mark.parametrize(
    ("frame", "problem"),
    [
        (b"", "Expected 7 bytes of header, got 0"),
        (READ_107_REPLY[:6], "Expected 7 bytes of header, got 6"),
        (READ_107_REPLY[:-1], "Expected a frame of 15 bytes, got 14"),
        (READ_107_REPLY + b"!", "Expected a frame of 15 bytes, got 16"),
        (bytes.fromhex("150100010009010306022b00000064"), "protocol 1, length 9"),
        (bytes.fromhex("150100000001 01"), "length 2 to 1034), got protocol 0, length 1"),
        (bytes.fromhex("150100000002 01 03"), "Expected 6 bytes of registers, got ''"),
        (bytes.fromhex("15010000ffff010306022b00000064"), "protocol 0, length 65535"),
        (bytes.fromhex("150000000009010306022b00000064"), "request 5377, got one to 5376"),
        (bytes.fromhex("150100000009011006022b00000064"), "Modbus function 3, got 16"),
        (
            bytes.fromhex("150100000009010305022b00000064"),
            "Expected 6 bytes of registers, got '05022b",
        ),
        (
            bytes.fromhex("15010000000701030402 2b0000"),
            "Expected 6 bytes of registers, got '04022b",
        ),
    ],
)
def test_bad_replies_by_their_message(frame, problem):
    with pytest.raises(BadReply) as caught:
        modbus.parse_read(frame, 0x1501, 3)
    assert problem in str(caught.value)


def test_write_that_was_not_all_done():
    with pytest.raises(BadReply, match="Expected 2 registers written at 1, got 00010001"):
        modbus.parse_write(bytes.fromhex("150200000006011000010001"), 0x1502, 1, 2)


@pytest.mark.parametrize(
    ("build", "problem"),
    [
        (lambda: modbus.read_request(0, 0, 0), "Expected 1 to 125 registers within 0-65535, got 0"),
        (lambda: modbus.read_request(0, 0, 126), "got 126 at 0"),
        (lambda: modbus.read_request(0, -1, 2), "got 2 at -1"),
        (lambda: modbus.read_request(0, 65535, 2), "got 2 at 65535"),
        (lambda: modbus.write_request(0, 0, bytes(248)), "Expected 1 to 123 registers"),
        (lambda: modbus.write_request(0, 0, b"abc"), "two bytes a register, got 3 bytes"),
        (lambda: modbus.write_request(0, 0, b""), "got 0 at 0"),
        (lambda: modbus.feedback_request(0, []), "got 0 parts"),
        (lambda: modbus.feedback_request(0, [Read(0, 256)]), "Expected 1 to 255 registers"),
        (lambda: modbus.feedback_request(0, [Read(0, 255)] * 3), "to 1040 bytes, got 3 parts"),
        (
            lambda: modbus.feedback_request(0, [Write(4420, bytes(400))] * 3),
            "3 parts and 1220 bytes",
        ),
    ],
)
def test_bad_requests_by_their_message(build, problem):
    with pytest.raises(ValueError, match=r"Expected .*got") as caught:
        build()
    assert problem in str(caught.value)


GARBAGE = st.one_of(
    st.binary(max_size=64),
    st.binary(max_size=1100).map(lambda d: struct.pack(">HHH", 1, 0, len(d) & 0xFFFF) + d),
    st.binary(max_size=20).map(lambda d: struct.pack(">HHHBB", 1, 0, len(d) + 2, 1, 3) + d),
    st.binary(max_size=20).map(lambda d: struct.pack(">HHHBB", 1, 0, len(d) + 2, 1, 76) + d),
    st.binary(max_size=20).map(lambda d: struct.pack(">HHHBB", 1, 0, len(d) + 2, 1, 0x83) + d),
)


@given(GARBAGE)
def test_garbage_is_a_bad_reply_or_a_refusal(frame):
    parts = [Read(0, 2), Read(40, 1)]
    for parse in (
        lambda: modbus.bytes_to_come(frame),
        lambda: modbus.parse_frame(frame),
        lambda: modbus.parse_read(frame, 1, 2),
        lambda: modbus.parse_write(frame, 1, 0, 2),
        lambda: modbus.parse_feedback(frame, 1, parts),
    ):
        try:
            parse()
        except (BadReply, ModbusException) as error:
            assert isinstance(error, InstrumentError)
            assert str(error).startswith("Expected ")


# Excerpt of ljm_constants.json 2019.02.08.A (labjack/ljm_constants), names expanded by LabJack's
# rule: a member of NAME#(0:n) lies one value of its type behind the one before.
PUBLISHED = {
    "AIN0": (0, "FLOAT32", "R"),
    "AIN3": (6, "FLOAT32", "R"),
    "AIN0_RANGE": (40000, "FLOAT32", "RW"),
    "AIN13_RANGE": (40026, "FLOAT32", "RW"),
    "AIN1_NEGATIVE_CH": (41001, "UINT16", "RW"),
    "AIN2_RESOLUTION_INDEX": (41502, "UINT16", "RW"),
    "AIN3_SETTLING_US": (42006, "FLOAT32", "RW"),
    "AIN_ALL_NEGATIVE_CH": (43902, "UINT16", "RW"),
    "AIN1_BINARY": (50002, "UINT32", "R"),
    "DAC1": (1002, "FLOAT32", "RW"),
    "TDAC2": (30004, "FLOAT32", "W"),
    "TDAC3": (30006, "FLOAT32", "W"),
    "TDAC_SERIAL_NUMBER": (55200, "UINT32", "R"),
    "FIO0": (2000, "UINT16", "RW"),
    "FIO7": (2007, "UINT16", "RW"),
    "EIO0": (2008, "UINT16", "RW"),
    "CIO3": (2019, "UINT16", "RW"),
    "MIO2": (2022, "UINT16", "RW"),
    "DIO22": (2022, "UINT16", "RW"),
    "FIO_STATE": (2500, "UINT16", "RW"),
    "MIO_STATE": (2503, "UINT16", "RW"),
    "FIO_DIRECTION": (2600, "UINT16", "RW"),
    "DIO_STATE": (2800, "UINT32", "RW"),
    "DIO_DIRECTION": (2850, "UINT32", "RW"),
    "DIO_INHIBIT": (2900, "UINT32", "RW"),
    "STREAM_SCANRATE_HZ": (4002, "FLOAT32", "RW"),
    "STREAM_NUM_ADDRESSES": (4004, "UINT32", "RW"),
    "STREAM_SAMPLES_PER_PACKET": (4006, "UINT32", "RW"),
    "STREAM_SETTLING_US": (4008, "FLOAT32", "RW"),
    "STREAM_RESOLUTION_INDEX": (4010, "UINT32", "RW"),
    "STREAM_BUFFER_SIZE_BYTES": (4012, "UINT32", "RW"),
    "STREAM_AUTO_TARGET": (4016, "UINT32", "RW"),
    "STREAM_TRIGGER_INDEX": (4024, "UINT32", "RW"),
    # not in ljm_constants: stream.c of LabJack's C example, "Address = 4018 (STREAM_DATATYPE)"
    "STREAM_DATATYPE": (4018, "UINT32", "RW"),
    "STREAM_NUM_SCANS": (4020, "UINT32", "RW"),
    "STREAM_OUT0": (4800, "UINT16", "R"),
    "STREAM_OUT3": (4803, "UINT16", "R"),
    "STREAM_OUT0_TARGET": (4040, "UINT32", "RW"),
    "STREAM_OUT1_BUFFER_ALLOCATE_NUM_BYTES": (4052, "UINT32", "RW"),
    "STREAM_OUT0_LOOP_NUM_VALUES": (4060, "UINT32", "RW"),
    "STREAM_OUT0_SET_LOOP": (4070, "UINT32", "W"),
    "STREAM_OUT0_BUFFER_STATUS": (4080, "UINT32", "R"),
    "STREAM_OUT3_ENABLE": (4096, "UINT32", "RW"),
    "STREAM_OUT0_BUFFER_F32": (4400, "FLOAT32", "W"),
    "STREAM_OUT0_BUFFER_U16": (4420, "UINT16", "W"),
    "STREAM_SCANLIST_ADDRESS0": (4100, "UINT32", "RW"),
    "STREAM_SCANLIST_ADDRESS127": (4354, "UINT32", "RW"),
    "STREAM_DATA_CAPTURE_16": (4899, "UINT16", "R"),
    "STREAM_ENABLE": (4990, "UINT32", "RW"),
    "CORE_TIMER": (61520, "UINT32", "R"),
    "USER_RAM0_U32": (46100, "UINT32", "RW"),
    "USER_RAM0_F32": (46000, "FLOAT32", "RW"),
    "TEST": (55100, "UINT32", "R"),
    "TEST_FLOAT32": (55124, "FLOAT32", "RW"),
    "PRODUCT_ID": (60000, "FLOAT32", "R"),
    "SERIAL_NUMBER": (60028, "UINT32", "R"),
    "DEVICE_NAME_DEFAULT": (60500, "STRING", "RW"),
    "IO_CONFIG_SET_CURRENT_TO_FACTORY": (61990, "UINT16", "W"),
    "WATCHDOG_ENABLE_DEFAULT": (61600, "UINT32", "RW"),
    "WATCHDOG_TIMEOUT_S_DEFAULT": (61604, "UINT32", "RW"),
    "WATCHDOG_DIO_STATE_DEFAULT": (61632, "UINT32", "RW"),
    "WATCHDOG_DAC1_DEFAULT": (61652, "FLOAT32", "RW"),
    "INTERNAL_FLASH_READ_POINTER": (61810, "UINT32", "RW"),
    "INTERNAL_FLASH_READ": (61812, "UINT32", "R"),
}


@pytest.mark.parametrize("name", PUBLISHED)
def test_registers_are_the_published_ones(name):
    entry = register(name)
    assert (entry.address, entry.kind, entry.access) == PUBLISHED[name]
    assert entry.verified


def test_registers_do_not_overlap_but_for_their_aliases():
    owner = {}
    for name, entry in REGISTERS.items():
        if name.startswith("DIO") and name[3:].isdigit():
            continue  # the published second name of FIO, EIO, CIO and MIO
        for address in range(entry.address, entry.address + entry.size):
            # the test register may be read by halves
            assert owner.setdefault(address, name) == name
    assert all(register(f"DIO{n}").address == 2000 + n for n in range(23))


def test_registers_that_could_not_be_verified_are_marked():
    assert {name for name, entry in REGISTERS.items() if not entry.verified} == {
        "LAST_ERR_DETAIL",
        "STREAM_AUTORECOVER_DISABLE",
        "STREAM_SCANRATE_HZ_ACTUAL",
        "STREAM_START_TIME_STAMP",
        "TDAC_SPEED_THROTTLE",
    }


@pytest.mark.parametrize(
    ("name", "value", "data"),
    [
        # defaults that ljm_constants.json states with their bytes
        ("TEST", 0x00112233, "00112233"),
        ("TEST_UINT16", 17, "0011"),
        ("TEST_INT32", -2003195205, "8899aabb"),
        ("TEST_FLOAT32", -9999.0, "c61c3c00"),
    ],
)
def test_values_of_the_test_registers(name, value, data):
    entry = register(name)
    assert entry.bytes_from_value(value).hex() == data
    assert entry.value_from_bytes(bytes.fromhex(data)) == value


@given(st.sampled_from(sorted(REGISTERS)), st.data())
def test_registers_round_trip(name, data):
    entry = register(name)
    values = {
        "UINT16": U16,
        "UINT32": st.integers(0, 2**32 - 1),
        "INT32": st.integers(-(2**31), 2**31 - 1),
        "FLOAT32": st.floats(width=32, allow_nan=False),
        "STRING": st.text("abcXYZ 019-_", max_size=49),
    }
    value = data.draw(values[entry.kind])
    sent = entry.bytes_from_value(value)
    assert len(sent) == 2 * entry.size
    assert entry.value_from_bytes(sent) == value


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("FIO0", 65536),
        ("FIO0", -1),
        ("FIO0", 0.5),
        ("STREAM_ENABLE", "on"),
        ("STREAM_NUM_SCANS", math.inf),
        ("TEST_INT32", 2**31),
        ("TDAC2", 1e39),
        ("TDAC2", None),
    ],
)
def test_values_out_of_range_by_their_message(name, value):
    with pytest.raises(ValueError, match=r"Expected a (UINT|INT|FLOAT).* for register \d+, got"):
        register(name).bytes_from_value(value)


def test_other_register_errors():
    with pytest.raises(ValueError, match="Expected the name of a T7 register, got 'AIN99'"):
        register("AIN99")
    with pytest.raises(ValueError, match="Expected 4 bytes of register 0, got 2"):
        register("AIN0").value_from_bytes(b"ab")
