"""The T7's driver: exact frames, a peer in memory with faults, and a public Modbus server."""

import asyncio
import struct
import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from t7_peer import Memory, T7Peer, packet, whole_burst

from cmtof.hardware.codecs import labjack
from cmtof.hardware.codecs.modbus import ModbusException
from cmtof.hardware.drivers.labjack_t7 import BurstSettings, LabJackT7
from cmtof.hardware.drivers.stream_burst import port_states, read_burst
from cmtof.hardware.errors import (
    BadReply,
    ConnectionLost,
    InstrumentError,
    InstrumentTimeout,
    Refused,
)
from cmtof.hardware.transport import ReplayTransport, TcpTransport

BURST = {"rate": 24000.0, "scans": 320, "range": 10.0, "pulse_line": "FIO4"}


def t7(peer=None):
    peer = peer or T7Peer()
    return LabJackT7(peer.command, peer.stream, timeout=0.01), peer


def u32(*values):
    return struct.pack(f">{len(values)}I", *values)


def f32(value):
    return struct.pack(">f", value)


# --- exact frames ------------------------------------------------------------------------------

FRAMES = [
    ("000100000006 01 03 0000 0002", "0001000000070103 04 3fc00000", "read", ("AIN0",), 1.5),
    (
        "00010000000b 01 10 7534 0002 04 40200000",
        "000100000006 0110 7534 0002",
        "write",
        ("TDAC2", 2.5),
        None,
    ),
    (
        "000100000012 01 4c 01 7534 02 40200000 01 7536 02 bf800000",
        "000100000002 014c",
        "write_many",
        ({"TDAC2": 2.5, "TDAC3": -1.0},),
        None,
    ),
    ("000100000006 01 03 07d7 0001", "0001000000050103 02 0001", "line", ("FIO7",), True),
    ("000100000006 01 03 09c4 0001", "0001000000050103 02 0010", "state", ("FIO4",), True),
]


@pytest.mark.parametrize(("sent", "answer", "call", "arguments", "result"), FRAMES)
def test_frames(sent, answer, call, arguments, result):
    command = ReplayTransport([(bytes.fromhex(sent), bytes.fromhex(answer))])
    daq = LabJackT7(command, Memory())
    assert getattr(daq, call)(*arguments) == result
    command.finish()


def test_a_burst_starts_in_one_frame_with_what_goes_before():
    daq, peer = t7()
    daq.configure_burst(**BURST)
    sent = []
    plain = peer.command.write
    peer.command.write = lambda data: (sent.append(data), plain(data))
    burst = daq.burst({"USER_RAM0_U32": 7, "TDAC2": 2.5, "TDAC3": -1.0})
    start = bytes.fromhex(
        "01 b414 02 00000007"  # USER_RAM0_U32, 46100
        "01 7534 02 40200000 01 7536 02 bf800000"  # TDAC2, TDAC3
        "01 137e 02 00000001"  # STREAM_ENABLE
        "00 f050 02"  # CORE_TIMER
    )
    assert sent[0][6:] == bytes.fromhex("01 4c") + start
    assert sent[1][6:] == bytes.fromhex("01 4c 01 137e 02 00000000")
    assert len(sent) == 2
    assert burst.counts.dtype == np.uint16
    assert burst.counts.tolist() == [40000 + s for s in range(320)]


def test_the_set_up_of_a_burst():
    """Addresses as published in ljm_constants.json."""
    daq, peer = t7()
    settings = daq.configure_burst(**BURST)
    high, low = 0xEF10, 0xEF00  # FIO4 alone, the others inhibited
    assert peer.log == [
        (4990, u32(0)),
        (40000, f32(10.0)),
        (41000, (199).to_bytes(2, "big")),
        (4002, f32(24000.0)),
        (4004, u32(2)),
        (4006, u32(160)),
        (4010, u32(1)),
        (4012, u32(2048)),
        (4014, u32(0)),
        (4016, u32(1)),
        (4020, u32(320)),
        (4024, u32(0)),
        (4100, u32(4800)),
        (4102, u32(0)),
        (4008, f32(0.0)),
        (4018, u32(0)),
        (2004, bytes(2)),
        (4090, u32(0)),
        (4040, u32(2500)),
        (4050, u32(128)),
        (4090, u32(1)),
        (4060, u32(20)),
        (4420, struct.pack(">20H", *[high] * 10, *[low] * 10)),
        (4070, u32(1)),
    ]
    assert (settings.samples_per_packet, settings.duration) == (160, pytest.approx(320 / 24e3))


def test_without_a_pulse_line_no_stream_out_is_set_up():
    daq, peer = t7()
    daq.configure_burst(rate=1000.0, scans=7, channel=3)
    assert not peer.written(4040)
    assert peer.written(4100) == [u32(6)]
    assert peer.written(4006) == [u32(7)]


@given(st.integers(0, 7))
def test_a_pulse_changes_one_line(line):
    high, low = port_states(line)
    for before in (0x00, 0xFF, 0xA5):
        for value, level in ((high, 1), (low, 0)):
            free = ~(value >> 8) & 0xFF
            after = before & ~free | value & free
            assert after == (before & ~(1 << line) | level << line)


@given(st.integers(1, 3000), st.integers(2, 60))
def test_packets_divide_a_burst(scans, per_pulse):
    settings = BurstSettings(
        rate=1000.0, scans=scans * per_pulse, pulse_line="FIO0", scans_per_pulse=per_pulse
    )
    size = settings.samples_per_packet
    assert 1 <= size <= 160
    assert settings.scans % size == 0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"rate": 60e3}, "up to 50000 scans/s, got 60000"),
        ({"rate": 0.0}, "scans/s, got 0"),
        ({"rate": float("nan")}, "scans/s, got nan"),
        ({"scans": 0}, "1 scan or more"),
        ({"scans": 330}, "whole pulses of 2 scans or more, got 330"),
        ({"range": 5.0}, "input range of 10.0, 1.0, 0.1, 0.01 V"),
        ({"pulse_line": "EIO1"}, "FIO0 to FIO7, got 'EIO1'"),
        ({"channel": 14}, "AIN0 to AIN13"),
        ({"scans_per_pulse": 1}, "whole pulses"),
    ],
)
def test_bursts_that_no_t7_can_take(changes, words):
    with pytest.raises(ValueError, match=words):
        t7()[0].configure_burst(**BURST | changes)


@pytest.mark.parametrize(
    ("address", "kept", "words"),
    [
        (4002, f32(20000.0), "STREAM_SCANRATE_HZ to 24000 , got 20000"),
        (4020, u32(0), "STREAM_NUM_SCANS to 320 , got 0"),
        (40000, f32(1.0), "AIN0_RANGE to 10 , got 1"),
    ],
)
def test_a_register_that_keeps_its_value_is_found(address, kept, words):
    daq, peer = t7()
    peer.kept[address] = kept
    with pytest.raises(Refused, match=words):
        daq.configure_burst(**BURST)


def test_a_burst_wants_a_set_up():
    with pytest.raises(ValueError, match="Call configure_burst first"):
        t7()[0].burst()


# --- broken bursts -----------------------------------------------------------------------------

A, B = whole_burst(320)
BROKEN = {
    "nothing comes": ([], InstrumentTimeout, "320 samples within 0.02 s, got 0"),
    "the end is missing": ([A], InstrumentTimeout, "got 160"),
    "a packet is missing": ([packet(0, [1] * 160), packet(2, [1] * 160)], BadReply, "1 missing"),
    "the numbers wrap": ([packet(65535, [1] * 160), packet(0, [1] * 160)], None, ""),
    "another missing at the wrap": (
        [packet(65535, [1] * 160), packet(1, [1] * 160)],
        BadReply,
        "1 missing",
    ),
    "a full buffer": ([A, packet(1, [1] * 160, status=2940)], BadReply, "a full buffer"),
    "skipped scans": (
        [A, packet(1, [1] * 160, status=2941, extra=12)],
        BadReply,
        "12 skipped scans",
    ),
    "overlap": ([packet(0, [1] * 160, status=2942)], BadReply, "overlapping scans"),
    "many skipped scans": ([packet(0, [1] * 160, status=2943)], BadReply, "65535 or more"),
    "an early end": ([packet(0, [1] * 100, status=2944)], BadReply, "the end after 100"),
    "too many": ([A, packet(1, [1] * 200)], BadReply, "got 360"),
    "an unknown status": ([packet(0, [1] * 160, status=77)], BadReply, "stream status, got 77"),
    "garbage": ([b"\x00" * 40], BadReply, "Modbus TCP header"),
    "a cut packet": ([A[:100]], InstrumentTimeout, "got 0"),
    "an old end first": ([packet(9, [], status=2944), A, B], None, ""),
    "one byte at a time": ([bytes([byte]) for byte in A + B], None, ""),
}


@pytest.mark.parametrize("fault", BROKEN)
def test_broken_bursts_are_found_and_may_be_taken_again(fault):
    packets, error, words = BROKEN[fault]
    script = [packets, whole_burst(320)]
    daq, peer = t7(T7Peer(lambda peer: script.pop(0)))
    daq.configure_burst(**BURST)
    settings = len(peer.written(4070))
    if error is None:
        assert daq.burst().counts.shape == (320,)
        return
    with pytest.raises(error, match=words):
        daq.burst({"TDAC2": 1.0})
    assert len(peer.written(30004)) == 1  # nothing was repeated
    burst = daq.burst({"TDAC2": 1.0})
    assert burst.counts.tolist() == [40000 + s for s in range(320)]
    assert len(peer.written(4070)) == settings + 1  # the pulses begin anew
    assert peer.written(4990)[-1] == u32(0)


@given(st.data())
def test_garbage_on_the_stream_never_passes_for_samples(data):
    stream = Memory()
    stream.waiting = [data.draw(st.binary(min_size=1, max_size=80)) for _ in range(4)]
    settings = BurstSettings(rate=24000.0, scans=320)
    with pytest.raises(InstrumentError):
        read_burst(stream, settings, 0.0)


@pytest.mark.parametrize("which", ["command", "stream"])
def test_a_lost_connection_ends_the_burst_and_the_next_one_opens_it(which):
    daq, peer = t7()
    daq.configure_burst(**BURST)
    getattr(peer, which).lost = True
    with pytest.raises(ConnectionLost):
        daq.burst()
    assert daq.burst().counts.shape == (320,)
    assert (peer.command.reconnects, peer.stream.reconnects) == (1, 1)


# --- registers ---------------------------------------------------------------------------------


def test_a_read_is_repeated_once_and_a_write_never():
    daq, peer = t7()
    peer.put_float(0, 2.5)
    peer.command.silences = 1
    assert daq.read("AIN0") == 2.5
    peer.command.silences = 2
    with pytest.raises(InstrumentTimeout):
        daq.read("AIN0")
    peer.command.silences = 1
    with pytest.raises(InstrumentTimeout):
        daq.write("TDAC2", 1.0)
    assert not peer.written(30004)


def test_late_answers_are_passed_over():
    first = bytes.fromhex("0001 0000 0007 0103 04 40200000")
    second = bytes.fromhex("0002 0000 0007 0103 04 3fc00000")
    request = "0000 0006 0103 0000 0002"
    command = ReplayTransport(
        [
            (bytes.fromhex("0001" + request), b""),
            (bytes.fromhex("0002" + request), first + second),
        ]
    )
    assert LabJackT7(command, Memory(), timeout=0.01).read("AIN0") == 1.5
    command.finish()


def test_a_refusal_names_the_code_of_the_device():
    daq, peer = t7()
    peer.command.refusals[30004] = (4, 2763)
    with pytest.raises(ModbusException, match="device failure, LabJack 2763 TDAC_CAL_READ_FAILURE"):
        daq.write("TDAC2", 1.0)


def test_stopping_a_stream_that_has_ended_is_no_error():
    daq, peer = t7()
    daq.configure_burst(**BURST)
    peer.command.refusals[4990] = (4, 2620)
    daq.safe_state()
    peer.command.refusals[4990] = (4, 2605)
    with pytest.raises(ModbusException, match="STREAM_IS_ACTIVE"):
        daq.safe_state()


def test_the_safe_state_stops_the_stream_and_pulls_the_pulse_line_low():
    daq, peer = t7()
    daq.configure_burst(**BURST)
    peer.log.clear()
    peer.command.lost = True
    daq.safe_state()
    assert peer.log == [(4990, u32(0)), (2004, bytes(2))]


@pytest.mark.parametrize("name", ["TDAC2", "STREAM_OUT0_SET_LOOP"])
def test_what_cannot_be_read(name):
    with pytest.raises(ValueError, match="write only"):
        t7()[0].read(name)


def test_a_line_that_does_not_follow_is_found():
    daq, peer = t7()
    daq.set_line("FIO1", True)
    assert peer.memory[2500] == 2
    peer.memory[2500] = 0
    peer.write = lambda address, data: None
    with pytest.raises(Refused, match="FIO1 of daq to go high, got the other level"):
        daq.set_line("FIO1", True)


def test_identity_and_calibration():
    daq, _ = t7()
    found = daq.identify()
    assert (found.serial_number, found.firmware, found.pro) == (470012345, 1.0301, False)
    assert found.calibrated
    volts = daq.volts_from_counts(np.array([33500, 33501, 33499], np.uint16), 10.0)
    assert volts == pytest.approx([0.0, 3.16e-4, -3.157e-4])


@pytest.mark.parametrize("blank", [b"\xff", b"\x00"])
def test_a_blank_flash_gives_nominal_values_and_a_warning(blank):
    daq, peer = t7()
    peer.flash[0x3C4000] = 164 * blank
    with pytest.warns(RuntimeWarning, match="got a blank one"):
        assert not daq.identify().calibrated
    assert daq.calibration() is labjack.NOMINAL


def test_a_calibration_that_cannot_be_true_is_refused():
    daq, peer = t7()
    peer.flash[0x3C4000] = peer.flash[0x3C4000][2:] + b"\0\0"  # words swapped
    with pytest.raises(BadReply, match="Expected calibration near"):
        daq.calibration()


@pytest.mark.parametrize(("address", "data"), [(60000, f32(4.0)), (55100, u32(0x22330011))])
def test_another_device_or_word_order(address, data):
    daq, peer = t7()
    peer.put(address, data)
    with pytest.raises(Refused, match="Expected a LabJack T7"):
        daq.identify()


# --- watchdog ----------------------------------------------------------------------------------


def test_the_watchdog_sets_the_safe_lines_and_spares_the_flash():
    peer = T7Peer()
    daq = LabJackT7(
        peer.command, peer.stream, safe_lines={"FIO0": False, "FIO1": False, "FIO6": True}
    )
    daq.watchdog(30)
    assert peer.log == [
        (61600, u32(0)),
        (61604, u32(30)),
        (61632, u32(0x40)),
        (61634, u32(0x43)),
        (61636, u32(0x7FFFBC)),
        (61630, u32(1)),
        (61600, u32(1)),
    ]
    peer.log.clear()
    daq.watchdog(30)  # the settings live in flash: nothing is written twice
    assert peer.log == []
    daq.watchdog(0)
    daq.watchdog(0)
    assert peer.log == [(61600, u32(0))]


def test_a_watchdog_that_is_not_taken():
    daq, peer = t7()
    peer.kept[61604] = u32(3600)
    with pytest.raises(Refused, match="WATCHDOG_TIMEOUT_S_DEFAULT to 30 , got 3600"):
        daq.watchdog(30)
    with pytest.raises(ValueError, match="0 or 1 to 3600 s"):
        daq.watchdog(0.5)


# --- a public Modbus server --------------------------------------------------------------------


@pytest.fixture
def modbus_server():
    """A pymodbus server that holds a piece of the T7's published map and knows function 76."""
    pytest.importorskip("pymodbus")
    from pymodbus.server import ModbusTcpServer
    from pymodbus.simulator import DataType, SimData, SimDevice

    real, long, word = DataType.FLOAT32, DataType.UINT32, DataType.UINT16
    device = SimDevice(
        1,
        simdata=[
            SimData(0, values=[1.25, -2.5], datatype=real),
            SimData(1000, values=[0.0, 0.0], datatype=real),
            SimData(2000, values=[0] * 8, datatype=word),
            SimData(46100, values=0, datatype=long),
            SimData(55000, values=2605, datatype=word),
            SimData(55100, values=0x00112233, datatype=long),
            SimData(60000, values=7.0, datatype=real),
            SimData(60028, values=470012345, datatype=long),
        ],
    )
    loop = asyncio.new_event_loop()
    started = threading.Event()
    found = {}

    async def serve():
        server = ModbusTcpServer(device, address=("127.0.0.1", 0), custom_pdu=[_feedback_pdu()])
        await server.serve_forever(background=True)
        found["server"] = server
        found["port"] = server.transport.sockets[0].getsockname()[1]
        started.set()
        await server.serving

    thread = threading.Thread(target=loop.run_until_complete, args=(serve(),))
    thread.start()
    assert started.wait(5)
    yield found["port"]
    asyncio.run_coroutine_threadsafe(found["server"].shutdown(), loop).result(5)
    thread.join(5)
    loop.close()


def _feedback_pdu():
    """Modbus Feedback, function 76, as LabJack describes it, on pymodbus' data store."""
    from pymodbus.pdu import ModbusPDU

    class Feedback(ModbusPDU):
        function_code = 76
        body = b""

        def decode(self, data):
            self.body = data

        def encode(self):
            return self.body

        async def datastore_update(self, context, device_id):
            answer, data = b"", self.body
            while data:
                kind, address, count = struct.unpack_from(">BHB", data)
                data = data[4:]
                if kind == 0:
                    values = await context.async_getValues(device_id, 3, address, count)
                    answer += struct.pack(f">{count}H", *values)
                else:
                    values = list(struct.unpack_from(f">{count}H", data))
                    await context.async_setValues(device_id, 16, address, values)
                    data = data[2 * count :]
            reply = Feedback(dev_id=device_id, transaction_id=self.transaction_id)
            reply.body = answer
            return reply

    return Feedback


def test_against_a_public_modbus_server(modbus_server):
    line = TcpTransport("127.0.0.1", modbus_server)
    daq = LabJackT7(line, Memory(), timeout=2.0)
    try:
        assert [daq.read("AIN0"), daq.read("AIN1")] == [1.25, -2.5]
        assert daq.read("TEST") == 0x00112233
        assert daq.read("PRODUCT_ID") == 7.0
        assert daq.read("SERIAL_NUMBER") == 470012345
        daq.write("DAC1", 2.5)
        assert daq.read("DAC1") == 2.5
        daq.write("FIO4", 1)
        assert daq.line("FIO4")
        daq.write_many({"DAC0": 1.5, "USER_RAM0_U32": 0x01020304})
        assert (daq.read("DAC0"), daq.read("USER_RAM0_U32")) == (1.5, 0x01020304)
        with pytest.raises(ModbusException, match="illegal data address, LabJack 2605"):
            daq.read("CORE_TIMER")  # not in this server's map
    finally:
        daq.close()
