"""The read-out before a model of the T7, in process and on TCP."""

import io
import socket
import struct

from peers import T7, Wire, modbus, simulated
from pymodbus.framer import FramerSocket
from pymodbus.pdu import DecodePDU
from pytest import approx, fixture, mark, raises
from refusals import refused
from wire import Network, with_device

from cmtof.hardware.connect import connected_driver
from cmtof.hardware.device import BadReply, ConnectionLost, InstrumentTimeout, Refused
from cmtof.hardware.modbus import Feedback
from cmtof.hardware.rig import Rig
from cmtof.hardware.t7 import LabJackT7

BURST = {
    "channels": ["AIN0"],
    "rate": 24000.0,
    "scans": 320,
    "pulse_line": "FIO4",
    "pulse": 20,
}
TWO = BURST | {"channels": ["AIN2", "AIN3"]}
LABEL = [{"USER_RAM0_U32": 1}]


@fixture
def peer():
    return T7(simulated("daq"))


@fixture
def daq(peer):
    return LabJackT7(modbus(peer), peer.stream, "daq")


def test_bursts_carry_mirrors_and_label_in_one_frame_and_inherit_nothing(peer, daq):
    inherited = (4008, 4014, 4018, 4022, 4024, 4028)
    for address in inherited:
        peer.set(address, "I", 1)
    daq.configure_burst(**BURST)
    list(daq.bursts([{"USER_RAM0_U32": 7, "TDAC2": 2.5}]))
    # the other lines are left alone
    assert (4420, b"\xef\x10" * 10 + b"\xef\x00" * 10) in peer.written
    start = peer.written.index((46100, b"\0\0\0\7"))
    assert peer.written[start + 1] == (30004, struct.pack(">f", 2.5))
    assert [address for address, _ in peer.written[start + 2 :]] == [4990, 4990]
    assert not any(map(peer.get, [4990, *inherited]))


def test_two_inputs_come_in_turn(peer, daq):
    peer.device.panel.photodiode_lit = True
    daq.configure_burst(**TWO)
    (counts,) = daq.bursts(LABEL)
    assert (peer.get(4102), peer.get(4104)) == (4, 6)  # where the inputs are read
    assert counts.shape == (640,)
    assert abs(counts[::2].mean() - counts[1::2].mean()) > 100 > 10 * counts[::2].std()
    with refused("Expected rate of daq from 1 to 100000, got 120000"):
        daq.configure_burst(**TWO | {"rate": 40e3})


def test_the_rate_that_the_converter_makes_is_kept_or_refused(peer, daq):
    daq.configure_burst(**BURST)
    works = peer.send_burst

    def burst_at(rate):
        peer.send_burst = lambda: peer.set(4494, "f", rate) or works()
        next(daq.bursts(LABEL))

    burst_at(23980.8)  # in steps of 100 ns
    assert daq.rate == approx(23980.8)
    with refused("its rate to 24000, got 23000", Refused):
        burst_at(23000.0)


@mark.parametrize(
    "fault, error, text",
    [
        ("lost", BadReply, "status 2944 or a gap"),
        ("skipped", BadReply, "status 2941"),
        ("short", InstrumentTimeout, "all samples"),
    ],
)
def test_a_broken_burst_is_an_error_and_the_next_one_is_whole(
    peer, daq, fault, error, text
):
    daq.configure_burst(**BURST)
    peer.fault = fault
    with refused(text, error):
        list(daq.bursts(LABEL))
    assert peer.get(4990) == 0
    (counts,) = daq.bursts([{"USER_RAM0_U32": 2}])
    assert counts.shape == (320,)


def test_a_t7_that_does_not_even_stop_is_lost_and_no_burst_is_tried_again(peer):
    wire = Wire(peer)
    wire.fail(b"\x13\x7e", TimeoutError())  # STREAM_ENABLE
    daq = LabJackT7(modbus(wire), peer.stream, "daq")
    daq.configure_burst(**BURST)
    with refused("Expected daq to answer, got silence", ConnectionLost):
        next(daq.bursts(LABEL))
    assert len(wire.sent) == 1


# --- on TCP --------------------------------------------------------------------------------------


@fixture
def network(peer):
    server = Network(peer)
    yield server
    server.close()


@fixture
def rig(network):
    """A rig whose T7 is on a network."""
    return with_device(Rig.default(), "daq", address=network.address)


def test_a_refusal_tells_the_makers_code(rig):
    far = connected_driver(rig, "daq")
    with refused("got exception 6.*LabJack's error code is 2501", Refused):
        far.write_many({"SERIAL_NUMBER": 1})
    far.close()


def test_an_answer_to_another_request_is_not_taken(network, rig):
    works = network.wire.answer
    network.wire.answer = lambda frame: b"\0\x63" + works(frame)[2:]
    far = connected_driver(rig, "daq")
    with refused("Expected answer 2, got 99", BadReply):  # it has been asked twice
        far.line("FIO7")
    far.close()


def test_a_log_has_every_request_and_reply(network, rig):
    with io.StringIO() as log:
        driver = connected_driver(with_device(rig, "daq", timeout=0.05), "daq", log)
        driver.line("FIO7")
        network.wire.fail(b"", b"")
        with raises(InstrumentTimeout):
            driver.line("FIO7")
        driver.close()
        lines = log.getvalue().splitlines()
    asked = "daq > 00 07 d7 01"
    told = [asked, "daq < 00 01", *[asked, "daq ! timed out"] * 2]
    assert [line.partition(" ")[2] for line in lines] == told


def test_frames_are_those_of_modbus_tcp():
    """By pymodbus, whose framing knows nothing of function 76."""
    listener = socket.create_server(("127.0.0.1", 0))
    client = Feedback("{}:{}".format(*listener.getsockname()), timeout=0.05)
    with raises(TimeoutError):
        client.ask(b"\x00\xea\x60\x02")
    with listener, listener.accept()[0] as far_end:
        used, unit, number, body = FramerSocket(DecodePDU(True)).decode(
            far_end.recv(100)
        )
    assert (used, unit, number, body) == (12, 1, 1, b"\x4c\x00\xea\x60\x02")
