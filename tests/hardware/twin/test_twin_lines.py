"""Lines of the twin: loopback only, links only where nothing else is, nothing left behind."""

import os
from pathlib import Path

import pytest
from twin_stand_in import (
    PtyClient,
    SocketClient,
    left_behind,
    listening,
    on_port,
    on_terminal,
    read_size,
    wait_until,
)

from cmtof.hardware.twin import lines
from cmtof.hardware.twin.lines import Channel, PtyLine, TcpLine

needs_proc = pytest.mark.skipif(not Path("/proc/self/net/tcp").exists(), reason="needs /proc")


def echo(channel: Channel) -> None:
    while data := channel.receive():
        if data == b"hang up":
            channel.drop()
        else:
            channel.send(data)


@pytest.mark.parametrize(
    "host", ["0.0.0.0", "", "::", "::1", "192.168.1.2", "127.0.0.2", "example.org"]
)
def test_only_the_loopback_interface_is_served(host):
    with pytest.raises(ValueError, match=r"Expected 127\.0\.0\.1"):
        TcpLine(host, 0, echo, "test")


@needs_proc
def test_kernel_lists_loopback_only():
    with on_port(echo):
        assert listening()
        assert all(local.startswith("0100007F:") for local in listening())
    assert not listening()


def test_port_in_use_is_one_line():
    with on_port(echo) as (line, _), pytest.raises(OSError, match=r"Expected port .* to be free"):
        TcpLine("127.0.0.1", line.port, echo, "clock")


def test_clients_are_served_side_by_side():
    with on_port(echo) as (line, first):
        second = SocketClient(line.port)
        for client, word in ((second, b"b"), (first, b"a"), (second, b"bb")):
            client.send(word)
            assert read_size(client, len(word)) == word
        second.close()
        first.send(b"still here")
        assert read_size(first, 10) == b"still here"


def test_dropped_client_may_come_back():
    with on_port(echo) as (line, client):
        client.send(b"hang up")
        assert client.read() == b""
        again = SocketClient(line.port)
        again.send(b"x")
        assert again.read() == b"x"
        again.close()


def test_broadcast_reaches_who_has_just_connected():
    line = TcpLine("127.0.0.1", 0, None, "test")
    try:
        for _ in range(50):
            client = SocketClient(line.port)
            line.broadcast(b"packet")
            assert read_size(client, 6) == b"packet"
            client.close()
    finally:
        line.stop()


def test_client_that_never_reads_is_dropped(monkeypatch):
    monkeypatch.setattr(lines, "_SEND_TIMEOUT", 0.05)
    line = TcpLine("127.0.0.1", 0, None, "test")
    deaf = SocketClient(line.port)
    try:
        line.broadcast(bytes(16_000_000))  # more than the kernel holds for it
        other = SocketClient(line.port)
        line.broadcast(b"!")
        assert other.read() == b"!"
        other.close()
    finally:
        deaf.close()
        line.stop()


@needs_proc
def test_nothing_is_left_after_stop(tmp_path):
    before = left_behind()
    port = TcpLine("127.0.0.1", 0, echo, "test")
    clients = [SocketClient(port.port) for _ in range(3)]
    terminal = PtyLine(tmp_path / "a" / "port", echo, "test")
    for client in clients:  # a connection that nobody accepted yet would be reset instead
        client.send(b"x")
        assert client.read() == b"x"
    for line in (port, terminal, port, terminal):  # again does nothing
        line.stop()
    for client in clients:
        assert client.read() == b""
        client.close()
    assert left_behind() == before
    with pytest.raises(OSError):
        SocketClient(port.port)
    assert not os.path.lexists(terminal.link)


def test_terminal_answers_through_its_link(tmp_path):
    with on_terminal(echo, tmp_path / "folder") as (line, client):
        assert line.address == f"serial:{tmp_path}/folder/port"
        everything = bytes(range(256))  # raw: nothing is translated or swallowed
        client.send(everything)
        assert read_size(client, 256) == everything


def test_terminal_survives_that_nobody_reads(tmp_path):
    with on_terminal(echo, tmp_path) as (_, client):
        for _ in range(20):
            client.send(bytes(2048))  # far beyond its buffer, echoed to nobody
            client.read(0)
        while client.read(0.05):
            pass
        client.send(b"hello")
        assert read_size(client, 5) == b"hello"


def test_unplugged_terminal_is_replaced(tmp_path):
    with on_terminal(echo, tmp_path) as (line, client):
        first = line.link.readlink()
        client.send(b"hang up")
        assert client.read() == b""  # the old one hangs up
        wait_until(lambda: line.link.readlink() != first)
        again = PtyClient(line.link)
        again.send(b"x")
        assert again.read() == b"x"
        again.close()


@pytest.mark.parametrize(
    "path", ["/dev/ttyUSB9", "/dev/serial/by-id/mine", "/dev/../dev/x", "/devices/../dev/pts/x"]
)
def test_no_link_under_dev(path):
    with pytest.raises(ValueError, match="outside /dev"):
        PtyLine(Path(path), echo, "test")


def test_no_link_under_dev_by_detour(tmp_path):
    (tmp_path / "detour").symlink_to("/dev")
    with pytest.raises(ValueError, match="outside /dev"):
        PtyLine(tmp_path / "detour" / "ttyUSB9", echo, "test")


def test_nothing_of_the_user_is_replaced(tmp_path):
    (tmp_path / "file").write_text("mine")
    (tmp_path / "folder").mkdir()
    (tmp_path / "real").symlink_to("/dev/ttyUSB9")  # as udev or a user makes them
    for name in ("file", "folder"):
        with pytest.raises(ValueError, match="not a link"):
            PtyLine(tmp_path / name, echo, "test")
    with pytest.raises(ValueError, match="pseudo-terminal"):
        PtyLine(tmp_path / "real", echo, "test")
    assert (tmp_path / "file").read_text() == "mine"
    assert str((tmp_path / "real").readlink()) == "/dev/ttyUSB9"


def test_link_of_a_killed_twin_is_replaced(tmp_path):
    (tmp_path / "port").symlink_to("/dev/pts/99999")
    with on_terminal(echo, tmp_path) as (_, client):
        client.send(b"x")
        assert client.read() == b"x"


def test_link_that_another_has_laid_stays(tmp_path):
    first = PtyLine(tmp_path / "port", echo, "test")
    second = PtyLine(tmp_path / "port", echo, "test")
    first.stop()
    assert (tmp_path / "port").is_symlink()
    second.stop()
    assert not (tmp_path / "port").is_symlink()
