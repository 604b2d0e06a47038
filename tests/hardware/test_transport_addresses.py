"""Addresses that name no line, and dialogues that are replayed in place of one."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cmtof.hardware.errors import ConnectionLost, InstrumentTimeout
from cmtof.hardware.transport import ReplayTransport, open_transport

SOON = 0.02  # s, for what must not come


@pytest.mark.parametrize(
    ("address", "problem"),
    [
        ("", "got ''. Correct the address"),
        ("localhost", "got 'localhost'. Correct"),
        ("udp://127.0.0.1:1", "got 'udp://127.0.0.1:1'. Correct"),
        ("http://127.0.0.1:80", "Expected tcp://HOST:PORT, serial:PATH"),
        ("tcp:127.0.0.1:5025", "needs a host and a port, nothing else"),
        ("tcp://127.0.0.1", "needs a host and a port"),
        ("tcp://127.0.0.1:", "needs a host and a port"),
        ("tcp://127.0.0.1:0", "needs a host and a port"),
        ("tcp://:5025", "needs a host and a port"),
        ("tcp://127.0.0.1:5025/path", "nothing else"),
        ("tcp://127.0.0.1:5025?timeout=1", "nothing else"),
        ("tcp://127.0.0.1:99999", "port is a number to 65535"),
        ("tcp://127.0.0.1:scpi", "port is a number to 65535"),
        ("tcp://[::1:5025", "port is a number"),
        ("serial:", "the path is missing"),
        ("serial:?baud=9600", "the path is missing"),
        ("serial:/dev/ttyUSB0?baud=fast", "baud is 50 to 4000000"),
        ("serial:/dev/ttyUSB0?baud=0", "baud is 50 to 4000000"),
        ("serial:/dev/ttyUSB0?baud=٩٦٠٠", "baud is 50 to 4000000"),
        ("serial:/dev/ttyUSB0?rtscts=yes", "rtscts is 0 or 1"),
        ("serial:/dev/ttyUSB0?parity=E", "options are baud, rtscts, each once"),
        ("serial:/dev/ttyUSB0?baud=9600&baud=115200", "each once"),
        ("serial:/dev/ttyUSB0?9600", "options are NAME=VALUE"),
        ("visa:", "the resource is missing"),
        ("visa:ASRL1::INSTR?timeout=3", "options are backend"),
    ],
)
def test_bad_address(address, problem):
    with pytest.raises(ValueError, match=r"Expected tcp://HOST:PORT.*Correct") as caught:
        open_transport(address)
    assert problem in str(caught.value)


@given(st.text(max_size=40))
def test_any_text_for_an_address_is_refused_clearly(text):
    with pytest.raises(ValueError, match="Expected tcp://HOST:PORT"):
        open_transport("x" + text)


def test_replay_is_strict():
    line = ReplayTransport([(b"", b"hello\n"), (b"A\n", b"a\nb\n"), (b"B\n", b""), (b"", b"!x\n")])
    assert line.read_until(b"\n", SOON) == b"hello\n"
    with pytest.raises(AssertionError, match=r"Expected b'A\\n' to be written, got b'B\\n'"):
        line.write(b"B\n")
    line.write(b"A\n")
    assert line.read_until(b"\n", SOON) == b"a\n"
    with pytest.raises(AssertionError, match=r"1 steps not written|2 steps not written"):
        line.finish()
    assert line.flush() == b"b\n"
    with pytest.raises(InstrumentTimeout):
        line.read_exact(1, 60.0)  # at once: nothing can come
    line.write(b"B\n")
    with pytest.raises(AssertionError, match="not read"):
        line.finish()
    assert line.read_exact(3, SOON) == b"!x\n"
    line.finish()
    with pytest.raises(AssertionError, match=r"Expected b'' to be written"):
        line.write(b"C\n")


def test_replay_raises_recorded_faults_and_counts_reconnects():
    line = ReplayTransport([(b"?\n", ConnectionLost("gone")), (b"?\n", b"1\n")])
    line.write(b"?\n")
    with pytest.raises(ConnectionLost, match="gone"):
        line.read_until(b"\n", SOON)
    line.reconnect()
    line.write(b"?\n")
    assert line.read_until(b"\n", SOON) == b"1\n"
    assert line.reconnects == 1
    line.finish()
    line.close()
