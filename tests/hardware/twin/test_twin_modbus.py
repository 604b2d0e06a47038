"""The simulated T7 by raw frames, by a published Modbus client, and under garbage."""

import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymodbus.client import ModbusTcpClient
from twin_stand_in import CENTRE, SocketClient, StandInWorld, on_port, read_size

from cmtof.hardware.codecs.registers import register
from cmtof.hardware.twin.faults import Fault, Watch
from cmtof.hardware.twin.lines import TcpLine
from cmtof.hardware.twin.modbus_server import TDAC_STEP, T7Server
from cmtof.instrument.panel import Panel


class Bench:
    """A T7 on two ports and clients of both."""

    def __init__(self) -> None:
        self.panel, self.world, self.watch = Panel(), StandInWorld(), Watch("daq")
        self.server = T7Server(self.panel, self.world, self.watch)
        self.stream_line = TcpLine("127.0.0.1", 0, None, "stream")
        self.server.stream.publish = self.stream_line.broadcast
        self.line = TcpLine("127.0.0.1", 0, self.server.serve, "command")
        self.client = SocketClient(self.line.port)
        self.stream = SocketClient(self.stream_line.port)

    def close(self) -> None:
        self.client.close()
        self.stream.close()
        self.server.stop()
        self.line.stop()
        self.stream_line.stop()

    def ask(self, frame: str) -> str:
        """Hexadecimal frame and reply."""
        self.client.send(bytes.fromhex(frame))
        return self.reply().hex()

    def reply(self) -> bytes:
        head = read_size(self.client, 6)
        return head + read_size(self.client, int.from_bytes(head[4:], "big"))

    def call(self, function: int, body: bytes) -> bytes:
        """Body of the reply to a function; an exception has its code."""
        self.client.send(struct.pack(">HHHBB", 7, 0, len(body) + 2, 1, function) + body)
        reply = self.reply()
        assert reply[:4] == b"\0\7\0\0"
        assert reply[7] in (function, function | 0x80)
        return reply[8:] if reply[7] == function else b"exception %d" % reply[8]

    def write(self, **values: float) -> bytes:
        """Write registers by name, in one function 76."""
        body = b""
        for name, value in values.items():
            entry = register(name)
            data = entry.bytes_from_value(value)
            body += struct.pack(">BHB", 1, entry.address, len(data) // 2) + data
        return self.call(76, body)

    def read(self, name: str) -> float | int | str:
        entry = register(name)
        reply = self.call(3, struct.pack(">HH", entry.address, entry.size))
        assert reply[0] == 2 * entry.size
        return entry.value_from_bytes(reply[1:])

    def packet(self) -> tuple[tuple[int, ...], np.ndarray]:
        """Header as in `test_burst_is_one_frame_and_one_packet`, and samples."""
        head = read_size(self.stream, 6)
        transaction, protocol, length = struct.unpack(">HHH", head)
        data = read_size(self.stream, length)
        assert len(data) == length, "more than one packet: read them one at a time"
        fields = struct.unpack_from(">BBBBHHH", data)
        return (transaction, protocol, *fields), np.frombuffer(data[10:], ">u2")


@pytest.fixture
def bench():
    made = Bench()
    yield made
    made.close()


BURST = {
    "AIN0_RANGE": 10.0,
    "STREAM_SCANRATE_HZ": 24000.0,
    "STREAM_NUM_ADDRESSES": 1,
    "STREAM_SAMPLES_PER_PACKET": 320,
    "STREAM_AUTO_TARGET": 1,
    "STREAM_DATATYPE": 0,
    "STREAM_NUM_SCANS": 320,
    "STREAM_SCANLIST_ADDRESS0": 0,
}


def pulses_on_fio4(bench: Bench, states: list[int], loop: int) -> None:
    size = 1 << max(5, (4 * len(states)).bit_length())
    for values in (
        {"FIO4": 0, "STREAM_OUT0_ENABLE": 0, "STREAM_OUT0_TARGET": 2500},
        {"STREAM_OUT0_BUFFER_ALLOCATE_NUM_BYTES": size, "STREAM_OUT0_ENABLE": 1},
        {"STREAM_OUT0_LOOP_NUM_VALUES": loop},
    ):
        assert bench.write(**values) == b""
    data = struct.pack(f">{len(states)}H", *states)
    assert bench.call(76, struct.pack(">BHB", 1, 4420, len(states)) + data) == b""
    assert bench.write(STREAM_OUT0_SET_LOOP=1) == b""
    assert bench.write(STREAM_NUM_ADDRESSES=2, STREAM_SCANLIST_ADDRESS1=4800) == b""


# --- frames ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("request_", "reply"),
    [
        # reading AIN0-3, LabJack «Protocol Details»: four FLOAT32 in one function 3
        ("0007 0000 0006 01 03 0000 0008",
         "0007 0000 0013 01 03 10 3fa00000 c0200000 00000000 41200000"),
        # TEST registers, ljm_constants.json: 0x00112233 tells a word swap, also word by word
        ("0001 0000 0006 01 03 d73c 0002", "0001 0000 0007 01 03 04 00112233"),
        ("0001 0000 0006 01 03 d73d 0001", "0001 0000 0005 01 03 02 2233"),
        ("0001 0000 0006 01 03 d754 0002", "0001 0000 0007 01 03 04 c61c3c00"),
        ("0001 0000 0006 01 04 d750 0004", "0001 0000 000b 01 04 08 00112233 8899aabb"),
        ("0001 0000 0006 01 03 ea60 0002", "0001 0000 0007 01 03 04 40e00000"),  # PRODUCT_ID 7
        # functions 6 and 16: TEST_UINT16, TEST_UINT32
        ("0002 0000 0006 01 06 d746 1234", "0002 0000 0006 01 06 d746 1234"),
        ("0002 0000 000b 01 10 d750 0002 04 01020304", "0002 0000 0006 01 10 d750 0002"),
        # function 76: write TEST_UINT16, read it and TEST in the order of the frames
        ("0003 0000 0010 05 4c 01 d746 01 beef 00 d746 01 00 d73c 02",
         "0003 0000 0008 05 4c beef 00112233"),
        # exceptions: function, address, access, half a value, count, size
        ("0004 0000 0003 01 2b 0e", "0004 0000 0003 01 ab 01"),
        ("0004 0000 0006 01 03 1f40 0001", "0004 0000 0003 01 83 02"),
        ("0004 0000 0006 01 06 0000 0001", "0004 0000 0003 01 86 02"),
        ("0004 0000 0006 01 03 7534 0002", "0004 0000 0003 01 83 02"),  # TDAC2 is write-only
        ("0004 0000 0006 01 03 0000 0001", "0004 0000 0003 01 83 02"),
        ("0004 0000 0006 01 03 0000 0000", "0004 0000 0003 01 83 03"),
        ("0004 0000 0009 01 10 d750 0002 02 0102", "0004 0000 0003 01 90 03"),
        ("0004 0000 0006 01 4c 01 d746 01", "0004 0000 0003 01 cc 03"),
        ("0004 0000 0002 01 03", "0004 0000 0003 01 83 03"),
    ],
)  # fmt: skip
def test_frames_of_the_public_documents(bench, request_, reply):
    assert bench.ask(request_) == reply.replace(" ", "")


def test_feedback_does_what_stands_before_an_error(bench):
    frame = "0003 0000 000c 01 4c 01 d746 01 0042 00 1f40 01"
    assert bench.ask(frame) == "000300000003" + "01cc02"
    assert bench.read("TEST_UINT16") == 0x42


def test_frames_may_come_in_pieces_and_in_bundles(bench):
    frame = bytes.fromhex("0001 0000 0006 01 03 d73c 0002")
    bench.client.send(frame[:5])
    bench.client.send(frame[5:] + frame + frame)
    for _ in range(3):
        assert bench.reply().hex() == "0001000000070103" + "0400112233"


def test_published_client_reads_and_writes(bench):
    with ModbusTcpClient("127.0.0.1", port=bench.line.port, timeout=5) as client:
        read = client.read_holding_registers(0, count=8)
        kind = client.DATATYPE.FLOAT32
        values = client.convert_from_registers(read.registers, kind)
        assert values == [1.25, -2.5, 0.0, 10.0]
        words = client.convert_to_registers(3.5, kind)
        assert not client.write_registers(30004, words).isError()  # TDAC2
        assert bench.panel.galvo_volts[0] == pytest.approx(3.5, abs=TDAC_STEP)
        assert client.read_holding_registers(8000, count=1).exception_code == 2


@given(garbage=st.binary(min_size=1, max_size=200))
@settings(max_examples=60, deadline=None)
def test_garbage_is_survived(garbage):
    server = T7Server(Panel(), StandInWorld(), Watch("daq"))
    with on_port(server.serve) as (line, client):
        client.send(garbage)
        good = SocketClient(line.port)
        good.send(bytes.fromhex("0001 0000 0006 01 03 d73c 0002"))
        assert read_size(good, 13).hex().endswith("00112233")
        good.close()
    server.stop()


def test_garbage_does_not_stick_to_its_connection(bench, monkeypatch):
    good = "0001 0000 0006 01 03 d73c 0002"
    bench.client.send(b"GET / HTTP/1.0\r\n\r\n")
    bench.client.read(0.05)
    assert bench.ask(good).endswith("00112233")
    monkeypatch.setattr("cmtof.hardware.twin.modbus_server._PARTIAL_TIMEOUT", 0.01)
    bench.client.send(bytes.fromhex("0001 0000 0100 01 4c"))  # 251 bytes never come
    bench.client.read(0.05)
    assert bench.ask(good).endswith("00112233")


@given(
    frames=st.lists(st.tuples(st.sampled_from([3, 6, 16, 76]), st.binary(max_size=40)), max_size=20)
)
@settings(max_examples=60, deadline=None)
def test_any_body_is_answered(frames):
    bench = Bench()
    for function, body in frames:
        bench.call(function, body)
    assert bench.read("TEST") == 0x00112233
    bench.close()


# --- analog and digital ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "volts", "axis", "set_"),
    [("TDAC2", 1.0, 0, 1.0), ("TDAC3", -3.3333, 1, -3.3333), ("TDAC2", 99.0, 0, 10.0)],
)
def test_tdac_moves_the_mirrors(bench, name, volts, axis, set_):
    assert bench.write(**{name: volts}) == b""
    got = bench.panel.galvo_volts[axis]
    assert got == pytest.approx(set_, abs=TDAC_STEP)
    assert got / TDAC_STEP == round(got / TDAC_STEP)  # 14 bit


def test_clamped_mirror_falls_short_but_can_be_parked(bench):
    for volts, got in ((5.0, 4.0), (-5.0, -4.0), (0.0, 0.0)):
        bench.watch.add(Fault("daq", "clamp"))
        bench.write(TDAC2=volts)
        assert bench.panel.galvo_volts[0] == pytest.approx(got, abs=TDAC_STEP)


def test_tdac_without_a_tick_dac_is_an_error(bench):
    assert bench.write(TDAC8=1.0) == b"exception 4"
    assert bench.read("LAST_ERR_DETAIL") == 2763
    assert bench.write(TDAC2=float("nan")) == b"exception 3"


def test_lines_turn_the_panel_and_low_is_safe(bench):
    panel = bench.panel
    names = ("laser_on", "shutter_open", "flip_mirror_in", "beam_block_in")
    assert [getattr(panel, name) for name in names] == [False, False, False, True]
    bench.write(FIO0=1, FIO1=1, FIO5=1, FIO6=1)
    assert [getattr(panel, name) for name in names] == [True, True, True, False]
    bench.write(IO_CONFIG_SET_CURRENT_TO_FACTORY=1)
    assert [getattr(panel, name) for name in names] == [False, False, False, True]


def test_reading_a_line_makes_it_an_input(bench):
    bench.write(FIO0=1)
    assert bench.read("FIO_STATE") & 1  # reads without changing it
    assert bench.panel.laser_on
    assert bench.read("FIO0") == 0  # pulled down once nobody drives it
    assert not bench.panel.laser_on
    assert bench.read("FIO_DIRECTION") == 0


def test_port_writes_obey_inhibits(bench):
    bench.write(FIO_DIRECTION=0x0003)
    bench.write(FIO_STATE=0x0003)
    assert bench.panel.laser_on and bench.panel.shutter_open
    bench.write(FIO_STATE=0xFE00)  # only FIO0 may change
    assert (bench.panel.laser_on, bench.panel.shutter_open) == (False, True)
    bench.write(DIO_INHIBIT=0b10, DIO_STATE=0b01)
    assert (bench.panel.laser_on, bench.panel.shutter_open) == (True, True)
    bench.write(DIO_DIRECTION=0b01)
    assert (bench.panel.laser_on, bench.panel.shutter_open) == (True, True)  # FIO1 inhibited
    bench.write(DIO_INHIBIT=0, DIO_DIRECTION=0b01)
    assert (bench.panel.laser_on, bench.panel.shutter_open) == (True, False)


def test_interlock_is_an_input(bench):
    assert bench.read("FIO7") == 1
    bench.panel.interlock_closed = False
    assert bench.read("FIO7") == 0


def test_trigger_line_steps_both_tables(bench):
    for knobs in (bench.panel.emission, bench.panel.detection):
        knobs.table, knobs.armed, knobs.trigger = np.zeros(3), True, True
    bench.panel.emission.trigger = False
    seen = []
    for level in (1, 1, 0, 1, 0, 1, 0, 1):
        bench.write(FIO4=level)
        seen.append((bench.panel.detection.index, bench.panel.detection.edges))
    assert seen == [(0, 1), (0, 1), (0, 1), (1, 2), (1, 2), (2, 3), (2, 3), (0, 4)]
    assert bench.panel.emission.edges == 0


def test_user_ram_is_memory_and_the_label(bench):
    bench.write(USER_RAM0_U32=123456, USER_RAM3_F32=0.5)
    assert bench.read("USER_RAM0_U32") == 123456
    assert bench.read("USER_RAM3_F32") == 0.5
    assert bench.panel.label == 123456


def test_settings_for_all_channels(bench):
    assert bench.read("AIN_ALL_RANGE") == 0
    bench.write(AIN3_RANGE=1.0)
    assert bench.read("AIN_ALL_RANGE") == -9999
    bench.write(AIN_ALL_RANGE=0.1, AIN_ALL_RESOLUTION_INDEX=8)
    assert [bench.read(f"AIN{n}_RANGE") for n in (0, 13)] == [np.float32(0.1)] * 2
    assert bench.read("AIN5_RESOLUTION_INDEX") == 8
    assert bench.write(AIN0_RANGE=5.0) == b"exception 3"
    assert bench.read("AIN0") == pytest.approx(0.106)  # 1.25 V is beyond the range


def test_binary_readings(bench):
    raw = bench.read("AIN1_BINARY")
    assert (raw / 256 - 33523) * 3.15805780e-4 == pytest.approx(-2.5, abs=2e-4)


def test_calibration_comes_out_of_the_flash(bench):
    values = b""
    for start, count in ((0, 13), (13, 13), (26, 13), (39, 2)):
        bench.write(INTERNAL_FLASH_READ_POINTER=0x3C4000 + 4 * start)
        values += bench.call(3, struct.pack(">HH", 61812, 2 * count))[1:]
    found = struct.unpack(">41f", values)
    assert found[:3] == pytest.approx((3.15805780e-4, -3.15805800e-4, 33523.0))
    assert found[28:30] == pytest.approx((3.1580578e-7, -3.15805800e-7))
    assert bench.call(3, struct.pack(">HH", 61812, 2))[1:] == b"\xff" * 4  # erased beyond


def test_watchdog_is_set_only_while_it_is_off(bench):
    assert bench.write(WATCHDOG_TIMEOUT_S_DEFAULT=10, WATCHDOG_ENABLE_DEFAULT=1) == b""
    assert bench.write(WATCHDOG_TIMEOUT_S_DEFAULT=20) == b"exception 4"
    assert bench.read("LAST_ERR_DETAIL") == 2671
    assert bench.read("WATCHDOG_TIMEOUT_S_DEFAULT") == 10
    bench.write(WATCHDOG_ENABLE_DEFAULT=0, WATCHDOG_TIMEOUT_S_DEFAULT=20)
    assert bench.read("WATCHDOG_TIMEOUT_S_DEFAULT") == 20


# --- stream ---------------------------------------------------------------------------------------


def test_burst_is_one_frame_and_one_packet(bench):
    assert bench.write(**BURST) == b""
    pulses_on_fio4(bench, [0xEF10] * 10 + [0xEF00] * 10, loop=20)
    bench.panel.detection.table, bench.panel.detection.trigger = np.zeros(16), True
    bench.panel.detection.armed = True
    for label in (1, 7):
        assert bench.write(TDAC2=0.5, USER_RAM0_U32=label, STREAM_ENABLE=1) == b""
        head, samples = bench.packet()
        # transaction, protocol, unit, function, type, reserved, backlog, status, extra
        assert head == (0, 0, 1, 76, 16, 0, 0, 2944, 0)
        assert samples.tolist() == (CENTRE + np.arange(320) // 20).tolist()
        assert bench.read("STREAM_START_TIME_STAMP") == round(label * 0.02 * 40e6)
        assert bench.write(STREAM_ENABLE=0) == b""
    assert [one["armed"] for one in bench.world.asked] == [True, False]
    assert [one["label"] for one in bench.world.asked] == [1, 7]
    assert (bench.panel.detection.index, bench.panel.detection.edges) == (15, 32)
    assert bench.panel.galvo_volts[0] == pytest.approx(0.5, abs=TDAC_STEP)


def test_packets_are_numbered_and_say_what_is_left(bench):
    bench.write(**(BURST | {"STREAM_SAMPLES_PER_PACKET": 150, "STREAM_ENABLE": 1}))
    heads = [bench.packet() for _ in range(3)]
    assert [len(samples) for _, samples in heads] == [150, 150, 20]
    assert [(head[0], head[6], head[7]) for head, _ in heads] == [
        (0, 340, 0),
        (1, 40, 0),
        (2, 0, 2944),
    ]


def test_line_that_is_high_already_gives_no_edge(bench):
    bench.write(**BURST)
    pulses_on_fio4(bench, [0xEF10] * 5 + [0xEF00] * 5, loop=0)  # then it stays low
    bench.write(FIO4=1, STREAM_ENABLE=1)
    bench.packet()
    assert set(bench.world.asked[0]["pulses"]) == {-1}


@pytest.mark.parametrize(("loop", "edges"), [(0, 2), (4, 2 + 78), (10, 64)])
def test_end_of_the_data_is_repeated(bench, loop, edges):
    bench.write(**BURST)
    pattern = [0xEF10, 0xEF00, 0xEF00, 0xEF00, 0xEF00, 0xEF00, 0xEF10, 0xEF00, 0xEF00, 0xEF00]
    pulses_on_fio4(bench, pattern, loop=loop)
    bench.write(STREAM_ENABLE=1)
    bench.packet()
    assert bench.world.asked[0]["pulses"][-1] + 1 == edges


def test_careless_pattern_turns_the_laser_off(bench):
    bench.write(**BURST)
    bench.write(FIO0=1, FIO1=1)
    pulses_on_fio4(bench, [0x0010, 0x0000], loop=2)  # no inhibits: all eight lines
    bench.write(STREAM_ENABLE=1)
    bench.packet()
    assert not bench.world.asked[0]["laser"]
    assert not bench.panel.laser_on and not bench.panel.shutter_open


def test_stream_out_goes_on_where_it_stopped(bench):
    bench.write(**(BURST | {"STREAM_NUM_SCANS": 5}))
    pulses_on_fio4(bench, [0xEF10, 0xEF00, 0xEF00, 0xEF00, 0xEF00, 0xEF00, 0xEF00], loop=7)
    first = []
    for _ in range(7):
        bench.write(STREAM_ENABLE=1)
        bench.packet()
        first.append(int(np.argmax(bench.world.asked[-1]["pulses"] >= 0)))
        bench.write(STREAM_ENABLE=0)
    assert first == [0, 2, 4, 0, 1, 3, 0]  # scans 0, 7, 14, none, 21, 28 of 35


def test_several_inputs_are_interleaved(bench):
    bench.write(**(BURST | {"STREAM_NUM_ADDRESSES": 3, "STREAM_NUM_SCANS": 4}))
    bench.write(STREAM_SCANLIST_ADDRESS1=6, STREAM_SCANLIST_ADDRESS2=2500, STREAM_ENABLE=1)
    _, samples = bench.packet()
    table = samples.reshape(4, 3)
    assert (table[:, 0] == CENTRE - 1).all()
    assert (table[:, 1] - 33523.0) * 3.15805780e-4 == pytest.approx(10.0, abs=1e-3)
    assert (table[:, 2] == 0b10001100).all()  # FIO2, FIO3, FIO7 float high


@pytest.mark.parametrize(
    ("changes", "detail"),
    [
        ({"STREAM_NUM_ADDRESSES": 0}, 2600),
        ({"STREAM_NUM_ADDRESSES": 129}, 2600),
        ({"STREAM_SCANLIST_ADDRESS0": 1}, 2607),
        ({"STREAM_SCANLIST_ADDRESS0": 55100}, 2607),
        ({"STREAM_SCANLIST_ADDRESS0": 4801}, 2610),
        ({"STREAM_SCANRATE_HZ": 0.0}, 2608),
        ({"STREAM_SCANRATE_HZ": 100001.0}, 2608),
        ({"STREAM_SAMPLES_PER_PACKET": 513}, 2618),
        ({"STREAM_RESOLUTION_INDEX": 9}, 2606),
        ({"STREAM_AUTO_TARGET": 2}, 2612),
        ({"STREAM_BUFFER_SIZE_BYTES": 1000}, 2615),
        ({"STREAM_SETTLING_US": 5000.0}, 2621),
        ({"STREAM_DATATYPE": 1}, 2611),
    ],
)
def test_set_up_that_cannot_be_is_refused(bench, changes, detail):
    bench.write(**(BURST | changes))
    assert bench.write(**changes, STREAM_ENABLE=1) == b"exception 4"
    assert bench.read("LAST_ERR_DETAIL") == detail
    assert bench.read("STREAM_ENABLE") == 0


def test_datatype_must_have_been_written(bench):
    without = {name: value for name, value in BURST.items() if name != "STREAM_DATATYPE"}
    assert bench.write(**without, STREAM_ENABLE=1) == b"exception 4"
    assert bench.write(STREAM_DATATYPE=0, STREAM_ENABLE=1) == b""


@pytest.mark.parametrize(
    ("name", "value", "detail"),
    [
        ("STREAM_OUT0_TARGET", 2004, 2614),  # a single line is not streamable
        ("STREAM_OUT0_BUFFER_ALLOCATE_NUM_BYTES", 100, 2615),
        ("STREAM_OUT0_BUFFER_ALLOCATE_NUM_BYTES", 32768, 2615),
        ("STREAM_OUT0_BUFFER_U16", 1, 2617),
    ],
)
def test_stream_out_that_cannot_be_is_refused(bench, name, value, detail):
    assert bench.write(**{name: value}) == b"exception 4"
    assert bench.read("LAST_ERR_DETAIL") == detail


def test_stream_out_buffer_overflows(bench):
    bench.write(STREAM_OUT0_TARGET=2500, STREAM_OUT0_BUFFER_ALLOCATE_NUM_BYTES=4)
    assert bench.read("STREAM_OUT0_BUFFER_STATUS") == 2
    assert bench.call(16, struct.pack(">HHB3H", 4420, 3, 6, 1, 2, 3)) == b"exception 4"
    assert bench.read("LAST_ERR_DETAIL") == 2613


def test_one_stream_at_a_time(bench):
    assert bench.write(STREAM_ENABLE=0) == b"exception 4"
    assert bench.read("LAST_ERR_DETAIL") == 2620
    bench.write(**(BURST | {"STREAM_ENABLE": 1}))
    bench.packet()
    assert bench.read("STREAM_ENABLE") == 1  # until it is switched off
    assert bench.write(STREAM_ENABLE=1) == b"exception 4"
    assert bench.read("LAST_ERR_DETAIL") == 2605
    assert bench.call(3, struct.pack(">HH", 0, 2)) == b"exception 4"  # no AIN by command
    assert bench.write(STREAM_ENABLE=0) == b""
    assert bench.read("AIN0") == 1.25


def test_unending_stream_ends(bench):
    bench.write(
        **(BURST | {"STREAM_NUM_SCANS": 0, "STREAM_SCANRATE_HZ": 100000.0, "STREAM_ENABLE": 1})
    )
    assert [bench.packet()[0][0] for _ in range(3)] == [0, 1, 2]
    bench.write(STREAM_ENABLE=0)
    bench.server.stop()
    taken = len(bench.world.asked)
    bench.read("CORE_TIMER")
    assert len(bench.world.asked) == taken


def test_core_timer_follows_the_virtual_clock(bench):
    bench.panel.time = 150.0
    assert bench.read("CORE_TIMER") == round(150 * 40e6) % 2**32


@pytest.mark.parametrize(
    ("kind", "status", "numbers", "counts"),
    [
        ("saturate", 0, [0, 1], 65535),
        ("overlap", 2942, [0, 1], CENTRE - 1),
        ("lost-packets", 2944, [1], CENTRE - 1),
    ],
)
def test_faults_of_bursts(bench, kind, status, numbers, counts):
    bench.write(**(BURST | {"STREAM_SAMPLES_PER_PACKET": 160}))
    bench.watch.add(Fault("daq", kind))
    for faulty in (True, False):  # once, at the next burst
        bench.write(STREAM_ENABLE=1)
        packets = [bench.packet() for _ in (numbers if faulty else [0, 1])]
        bench.write(STREAM_ENABLE=0)
        assert (packets[0][0][7] == status) == (faulty or status == 0)
        assert [head[0] for head, _ in packets] == (numbers if faulty else [0, 1])
        assert (packets[0][1] == (counts if faulty else CENTRE - 1)).all()


def test_interlock_opens_for_a_request(bench):
    bench.watch.add(Fault("daq", "interlock-open", after=1, times=2))
    assert [bench.read("FIO7") for _ in range(4)] == [1, 0, 0, 1]
    bench.panel.interlock_closed = False  # opened by hand: stays open
    assert bench.read("FIO7") == 0
