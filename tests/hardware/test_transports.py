"""Lines of bytes: real loopback sockets, a real pseudo-terminal, and VISA."""

import os
import socket
import struct
import sys
import threading
from contextlib import closing

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cmtof.hardware.errors import BadReply, ConnectionLost, InstrumentError, InstrumentTimeout
from cmtof.hardware.transport import (
    SerialTransport,
    TcpTransport,
    VisaTransport,
    open_transport,
)

SOON = 0.02  # s, for what must not come
LATER = 5.0  # s, for what must come


class TcpPeer:
    """The device's end of a loopback connection."""

    def __init__(self):
        self.server = socket.create_server(("127.0.0.1", 0))
        self.port = self.server.getsockname()[1]
        self.line = TcpTransport("127.0.0.1", self.port, timeout=LATER)
        self.device = self.server.accept()[0]

    def accept(self):
        self.device.close()
        self.device = self.server.accept()[0]

    def send(self, data):
        self.device.sendall(data)

    def receive(self, size):
        return self.device.recv(size, socket.MSG_WAITALL)

    def hang_up(self):
        self.device.close()

    def close(self):
        for part in (self.line, self.device, self.server):
            part.close()


class PtyPeer:
    """The device's end of a pseudo-terminal."""

    def __init__(self, **settings):
        self.master, self.slave = os.openpty()
        self.path = os.ttyname(self.slave)
        self.line = SerialTransport(self.path, **settings)

    def accept(self):
        pass

    def send(self, data):
        os.write(self.master, data)

    def receive(self, size):
        data = b""
        while len(data) < size:
            data += os.read(self.master, size - len(data))
        return data

    def hang_up(self):
        for end in (self.master, self.slave):
            os.close(end)
        self.master = self.slave = -1

    def close(self):
        self.line.close()
        for end in {self.master, self.slave} - {-1}:
            os.close(end)


@pytest.fixture(params=[TcpPeer, PtyPeer], ids=["tcp", "pty"])
def peer(request):
    with closing(request.param()) as made:
        yield made


def test_every_byte_passes_both_ways(peer):
    every = bytes(range(256))
    peer.line.write(every)
    assert peer.receive(256) == every
    peer.send(every)
    assert peer.line.read_exact(256, LATER) == every


def test_what_came_too_early_is_kept(peer):
    peer.send(b"first\nsecond\nthird")
    assert peer.line.read_until(b"\n", LATER) == b"first\n"
    assert peer.line.read_exact(3, LATER) == b"sec"
    assert peer.line.read_until(b"\n", LATER) == b"ond\n"
    assert peer.line.read_exact(5, LATER) == b"third"


def test_end_of_two_bytes_may_be_split(peer):
    peer.send(b"a\r")
    assert peer.line.read_exact(1, LATER) == b"a"
    with pytest.raises(InstrumentTimeout):
        peer.line.read_until(b"\r\n", SOON)
    peer.send(b"\nb")
    assert peer.line.read_until(b"\r\n", LATER) == b"\r\n"


def test_time_out_says_what_came_and_keeps_it(peer):
    peer.send(b"abc")
    assert peer.line.read_exact(1, LATER) == b"a"
    message = r"Expected 5 bytes from .* within 0\.02 s, got 2 bytes\. Check power"
    with pytest.raises(InstrumentTimeout, match=message):
        peer.line.read_exact(5, SOON)
    peer.send(b"def")
    assert peer.line.read_exact(5, LATER) == b"bcdef"


def test_silence_is_a_time_out(peer):
    with pytest.raises(InstrumentTimeout, match=r"a reply that ends in b'\\n'.*got 0 bytes"):
        peer.line.read_until(b"\n", SOON)


def test_no_time_still_looks_once(peer):
    peer.send(b"ab\n")
    assert peer.line.read_exact(1, LATER) == b"a"
    assert peer.line.read_until(b"\n", 0.0) == b"b\n"


def test_endless_reply_is_given_up(peer):
    peer.send(b"x" * 100)
    with pytest.raises(BadReply, match=r"Expected b'\\n' within 50 bytes from .*Flush"):
        peer.line.read_until(b"\n", LATER, limit=50)


def test_flush_drops_what_came(peer):
    peer.send(b"late reply\nmore")
    assert peer.line.read_exact(4, LATER) == b"late"
    assert peer.line.flush() == b" reply\nmore"
    assert peer.line.flush() == b""


def test_cut_reply_is_a_lost_connection(peer):
    peer.send(b"half a rep")
    assert peer.line.read_exact(4, LATER) == b"half"
    peer.hang_up()
    with pytest.raises(ConnectionLost, match=r"Expected an open line to .*reconnect"):
        peer.line.read_until(b"\n", LATER)
    with pytest.raises(ConnectionLost):
        peer.line.write(b"again")
    with pytest.raises(ConnectionLost):
        peer.line.flush()


def test_reconnect_drops_the_old_and_works(peer):
    peer.send(b"old")
    assert peer.line.read_exact(1, LATER) == b"o"
    peer.line.reconnect()
    peer.accept()
    peer.send(b"new")
    assert peer.line.read_exact(3, LATER) == b"new"


def test_close_is_idempotent_and_final(peer):
    peer.line.close()
    peer.line.close()
    with pytest.raises(ConnectionLost, match="«closed»"):
        peer.line.write(b"x")
    with pytest.raises(ConnectionLost, match="«closed»"):
        peer.line.read_exact(1, SOON)


def test_reset_by_the_device_is_a_lost_connection():
    with closing(TcpPeer()) as peer:
        linger = struct.pack("ii", 1, 0)  # closing sends a reset
        peer.device.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
        peer.hang_up()
        with pytest.raises(ConnectionLost):
            peer.line.read_exact(1, LATER)


def test_device_that_does_not_read_is_a_time_out():
    with closing(TcpPeer()) as peer, closing(TcpTransport("127.0.0.1", peer.port)) as line:
        line._timeout = SOON
        with pytest.raises(InstrumentTimeout, match=r"to take 33554432 bytes .*got no room"):
            line.write(bytes(1 << 25))
        with pytest.raises(ConnectionLost):  # the rest would be misread
            line.write(b"x")


def test_nobody_listens():
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    with pytest.raises(ConnectionLost, match=rf"tcp://127.0.0.1:{port}, got «Connection refused»"):
        TcpTransport("127.0.0.1", port)


def test_reconnect_fails_clearly_and_can_be_tried_again():
    with closing(TcpPeer()) as peer:
        peer.server.close()
        with pytest.raises(ConnectionLost):
            peer.line.reconnect()
        peer.server = socket.create_server(("127.0.0.1", peer.port))
        peer.line.reconnect()
        peer.hang_up()
        peer.accept()
        peer.send(b"!")
        assert peer.line.read_exact(1, LATER) == b"!"


def test_slow_device_is_waited_for():
    with closing(TcpPeer()) as peer:
        timer = threading.Timer(0.03, peer.send, [b"late\n"])
        timer.start()
        assert peer.line.read_until(b"\n", LATER) == b"late\n"
        timer.join()


def test_any_bytes_in_any_pieces_arrive_in_order():
    with closing(TcpPeer()) as peer:

        @given(st.lists(st.binary(max_size=30), max_size=8), st.integers(0, 240))
        def check(pieces, first):
            for piece in pieces:
                peer.send(piece)
            whole = b"".join(pieces)
            first = min(first, len(whole))
            assert peer.line.read_exact(first, LATER) == whole[:first]
            assert peer.line.read_exact(len(whole) - first, LATER) == whole[first:]
            assert peer.line.flush() == b""

        check()


def test_serial_flow_control_on_a_pseudo_terminal():
    with closing(PtyPeer(rtscts=True, baud=57600)) as peer:
        peer.line.write(b"\x43\x04\x01\x00\x50\x01")
        assert peer.receive(6) == b"\x43\x04\x01\x00\x50\x01"


def test_serial_port_has_one_host():
    message = r"Expected an open line to serial:/dev/.*exclusively"
    with closing(PtyPeer()) as peer, pytest.raises(ConnectionLost, match=message):
        SerialTransport(peer.path)


def test_serial_port_is_missing(tmp_path):
    with pytest.raises(ConnectionLost, match=r"serial:.*nowhere, got «.*No such file"):
        SerialTransport(str(tmp_path / "nowhere"))


@pytest.mark.parametrize(
    ("module", "address", "hint"),
    [
        ("serial", "serial:/dev/null", r"package pyserial .* pip install cmtof\[hardware\]"),
        ("pyvisa", "visa:ASRL1::INSTR", r"package pyvisa .* pip install pyvisa"),
    ],
)
def test_missing_package_is_named(monkeypatch, module, address, hint):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(InstrumentError, match=hint):
        open_transport(address)


SIMULATION = """
spec: "1.0"
devices:
  meter:
    eom: {TCPIP INSTR: {q: "\\n", r: "\\n"}}
    error: ERROR
    dialogues:
      - {q: "*IDN?", r: "THORLABS,PM100D,P0000001,2.6.0"}
      - {q: "SENS:CORR:WAV 532"}
resources:
  TCPIP0::localhost::inst0::INSTR: {device: meter}
"""


@pytest.fixture
def visa(tmp_path):
    """A VISA line to pyvisa-sim, an independent peer."""
    pytest.importorskip("pyvisa_sim")
    (tmp_path / "meter.yaml").write_text(SIMULATION)
    address = f"visa:TCPIP0::localhost::inst0::INSTR?backend={tmp_path}/meter.yaml@sim"
    with closing(open_transport(address)) as line:
        yield line


def test_visa_dialogue(visa):
    assert isinstance(visa, VisaTransport)
    visa.write(b"*IDN?\n")
    assert visa.read_until(b"\n", LATER) == b"THORLABS,PM100D,P0000001,2.6.0\n"
    visa.write(b"SENS:CORR:WAV 532\n")
    with pytest.raises(InstrumentTimeout, match="got 0 bytes"):
        visa.read_until(b"\n", SOON)
    visa.reconnect()
    visa.write(b"*IDN?\n")
    assert visa.read_exact(8, LATER) == b"THORLABS"
    assert visa.flush() == b",PM100D,P0000001,2.6.0\n"
    visa.close()
    visa.close()
    with pytest.raises(ConnectionLost):
        visa.write(b"*IDN?\n")


def test_visa_library_is_missing():
    pytest.importorskip("pyvisa")
    with pytest.raises(ConnectionLost, match=r"line to visa:ASRL1::INSTR.*Wrapper not found"):
        VisaTransport("ASRL1::INSTR", backend="@nowhere")


def test_addresses_open_lines():
    with closing(TcpPeer()) as peer:
        line = open_transport(f"tcp://127.0.0.1:{peer.port}")
        with closing(line):
            assert isinstance(line, TcpTransport)
    with closing(PtyPeer()) as peer:
        peer.line.close()
        line = open_transport(f"serial:{peer.path}?baud=9600&rtscts=1")
        with closing(line):
            assert isinstance(line, SerialTransport)
            assert line._port.baudrate == 9600
            assert line._port.rtscts
