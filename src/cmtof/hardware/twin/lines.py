"""Where a simulated device is reached: a loopback TCP port, or a pseudo-terminal behind a link.

Nothing of the twin is reachable from another machine, and no link is laid where a real device or a
file of the user's could be meant. Every connection has a thread that sleeps in the kernel until
something arrives, until a deadline of the device, or until the line is stopped.
"""

import os
import select
import socket
import tempfile
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Protocol

LOOPBACK = "127.0.0.1"
_CHUNK = 65536
_SEND_TIMEOUT = 1.0
"""How long a client may leave its replies unread before it is dropped, s."""


class Channel(Protocol):
    """One connection of a client."""

    def receive(self, timeout: float | None = None) -> bytes | None:
        """What has arrived; b"" at the end of the connection, None when ``timeout`` (s) ran out."""
        ...

    def send(self, data: bytes) -> None:
        """Send; a client that has gone or does not listen loses it."""
        ...

    def pause(self, seconds: float) -> None:
        """Sleep, or less when the line is stopped."""
        ...

    def drop(self) -> None:
        """Hang up."""
        ...


Serve = Callable[[Channel], None]
"""Talks to one client until `Channel.receive` says b""."""


class _Wake:
    """A pipe that ends every wait in `select` once the line stops."""

    def __init__(self) -> None:
        self.event = threading.Event()
        self.reader, self._writer = os.pipe()

    def set(self) -> None:
        if not self.event.is_set():
            self.event.set()
            os.write(self._writer, b"!")

    def close(self) -> None:
        os.close(self.reader)
        os.close(self._writer)


class TcpChannel:
    """A connected socket; Nagle's algorithm is off, replies are short and awaited."""

    def __init__(self, connection: socket.socket, stopped: threading.Event) -> None:
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket = connection
        self._stopped = stopped
        self.closed = False

    def receive(self, timeout: float | None = None) -> bytes | None:
        """What has arrived; b"" at the end, None when the time ran out."""
        try:
            if not select.select([self._socket], [], [], timeout)[0]:
                return None
            return self._socket.recv(_CHUNK)
        except (OSError, ValueError):  # reset, or closed by another thread
            return b""

    def send(self, data: bytes) -> None:
        """Send all of it; a client that does not read for a second is dropped."""
        view = memoryview(data)
        try:
            while view:
                if not select.select([], [self._socket], [], _SEND_TIMEOUT)[1]:
                    self.drop()
                    return
                view = view[self._socket.send(view) :]
        except (OSError, ValueError):
            self.drop()

    def pause(self, seconds: float) -> None:
        """Sleep, or less when the line is stopped."""
        self._stopped.wait(seconds)

    def drop(self) -> None:
        """Hang up; the thread that reads sees the end."""
        self.closed = True
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Hang up and free the socket."""
        self.drop()
        self._socket.close()


class TcpLine:
    """A TCP port on the loopback interface that any number of clients may connect to.

    Parameters
    ----------
    host, port : str, int
        "127.0.0.1" or "localhost"; port 0 takes a free one.
    serve : callable
        Talks to one client, in a thread of its own. None: the port only sends, see `broadcast`.
    name : str
        Name of the threads.

    Raises
    ------
    ValueError
        If the host is not the loopback interface.
    OSError
        If the port is taken.
    """

    def __init__(self, host: str, port: int, serve: Serve | None, name: str) -> None:
        if host not in (LOOPBACK, "localhost"):
            raise ValueError(
                f"Expected {LOOPBACK} for a simulated device, got {host!r}. "
                "The twin is not for the network."
            )
        self._serve, self._name = serve, name
        self._wake = _Wake()
        self._lock = threading.Lock()
        self._channels: list[TcpChannel] = []
        self._threads: list[threading.Thread] = []
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        try:
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._socket.bind((LOOPBACK, port))
            self._socket.listen()
            self._socket.setblocking(False)
        except OSError as error:
            self._socket.close()
            self._wake.close()
            reason = error.strerror or error
            raise OSError(
                f"Expected port {port} to be free for {name}, got «{reason}». "
                "Stop what holds it or choose another in the RIG file."
            ) from None
        self.port: int = self._socket.getsockname()[1]
        self._acceptor = threading.Thread(target=self._accept_all, name=name, daemon=True)
        self._acceptor.start()

    @property
    def address(self) -> str:
        """Address for a client, ``tcp://127.0.0.1:port``."""
        return f"tcp://{LOOPBACK}:{self.port}"

    def _accept_all(self) -> None:
        while not self._wake.event.is_set():
            select.select([self._socket, self._wake.reader], [], [])
            if not self._wake.event.is_set():
                self._accept_waiting()

    def _accept_waiting(self) -> None:
        """Take the clients that have connected; also called before a broadcast.

        `connect` returns on the other side before the thread here has seen the connection, and
        what is sent at that moment must not miss it.
        """
        with self._lock:
            while not self._wake.event.is_set():
                try:
                    connection, _ = self._socket.accept()
                except OSError:
                    return
                channel = TcpChannel(connection, self._wake.event)
                self._channels.append(channel)
                thread = threading.Thread(
                    target=self._converse, args=(channel,), name=self._name, daemon=True
                )
                self._threads = [one for one in self._threads if one.is_alive()] + [thread]
                thread.start()

    def _converse(self, channel: TcpChannel) -> None:
        try:
            if self._serve is not None:
                self._serve(channel)
            else:
                while channel.receive():
                    pass
        finally:
            with self._lock:
                channel.close()
                self._channels.remove(channel)

    def broadcast(self, data: bytes) -> None:
        """Send to every client that is connected at this moment."""
        self._accept_waiting()
        with self._lock:
            listeners = [channel for channel in self._channels if not channel.closed]
        for channel in listeners:
            channel.send(data)

    def drop(self) -> None:
        """Hang up on every client; new ones may connect."""
        self._accept_waiting()
        with self._lock:
            for channel in self._channels:
                channel.drop()

    def stop(self) -> None:
        """Hang up, close the port and wait for the threads. Idempotent."""
        if self._wake.event.is_set():
            return
        self._wake.set()
        self._acceptor.join()
        with self._lock:
            self._socket.close()
            for channel in self._channels:
                channel.drop()
            threads = list(self._threads)
        for thread in threads:
            thread.join()
        self._wake.close()


class PtyChannel:
    """The device's end of a pseudo-terminal."""

    def __init__(self, master: int, wake: _Wake) -> None:
        self._master, self._wake = master, wake
        self.dropped = False

    def receive(self, timeout: float | None = None) -> bytes | None:
        """What has arrived; b"" once the line is stopped or dropped, None when time ran out."""
        if self.dropped or self._wake.event.is_set():
            return b""
        ready, _, _ = select.select([self._master, self._wake.reader], [], [], timeout)
        if self._wake.reader in ready:
            return b""
        if not ready:
            return None
        try:
            return os.read(self._master, _CHUNK)
        except OSError:
            return b""

    def send(self, data: bytes) -> None:
        """Send; what does not fit into the terminal's buffer is lost, as on a wire."""
        with suppress(OSError):
            os.write(self._master, data)

    def pause(self, seconds: float) -> None:
        """Sleep, or less when the line is stopped."""
        self._wake.event.wait(seconds)

    def drop(self) -> None:
        """Unplug: the client sees a hang-up, the link soon leads to a fresh terminal."""
        self.dropped = True


def check_link(link: Path) -> None:
    """Refuse to lay a link where something else is or could be meant.

    Raises
    ------
    ValueError
        If the path is under /dev, or anything but a link to a pseudo-terminal is there.
    """
    device_folder = Path("/dev")
    if any(device_folder in (path, *path.parents) for path in (link.absolute(), _resolved(link))):
        raise ValueError(
            f"Expected a path outside /dev for a simulated serial port, got {link}. "
            "Choose a folder of your own."
        )
    if link.is_symlink():
        if not str(link.readlink()).startswith(("/dev/pts/", "/dev/ttys")):
            raise ValueError(
                f"Expected to replace a link to a pseudo-terminal, got one to {link.readlink()} "
                f"at {link}. Remove it or choose another path."
            )
    elif link.exists():
        raise ValueError(
            f"Expected nothing at {link}, got something that is not a link. "
            "Remove it or choose another path."
        )


def _resolved(link: Path) -> Path:
    """Path with the folder's links followed, but not the last one."""
    return link.parent.resolve() / link.name


class PtyLine:
    """A pseudo-terminal that serves one client at a time, behind a link at a fixed path.

    Parameters
    ----------
    link : Path
        Where the link is laid; its folder is made if need be. A link left by a twin that was
        killed is replaced.
    serve : callable
        Talks to the client, in a thread of its own.
    name : str
        Name of the thread.

    Raises
    ------
    ValueError
        If the path is under /dev or something else is there.
    """

    def __init__(self, link: Path, serve: Serve, name: str) -> None:
        check_link(link)
        link.parent.mkdir(parents=True, exist_ok=True)
        self.link = link.absolute()
        self._serve = serve
        self._wake = _Wake()
        self._master, self._slave = _open_terminal()
        self._lay_link()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    @property
    def address(self) -> str:
        """Address for a client, ``serial:path``."""
        return f"serial:{self.link}"

    def _run(self) -> None:
        while not self._wake.event.is_set():
            self._serve(PtyChannel(self._master, self._wake))
            if not self._wake.event.is_set():
                self._replug()

    def _replug(self) -> None:
        """Fresh terminal; the old one hangs up only once the link leads to the new one."""
        old = self._master, self._slave
        self._master, self._slave = _open_terminal()
        self._lay_link()
        for descriptor in old:
            os.close(descriptor)

    def _lay_link(self) -> None:
        """Point the link at the terminal in one step."""
        with tempfile.TemporaryDirectory(dir=self.link.parent, prefix=".link-") as folder:
            fresh = Path(folder) / "link"
            fresh.symlink_to(os.ttyname(self._slave))
            fresh.replace(self.link)

    def stop(self) -> None:
        """Hang up, remove the link if it is still ours, wait for the thread. Idempotent."""
        if self._wake.event.is_set():
            return
        self._wake.set()
        self._thread.join()
        with suppress(OSError):
            if str(self.link.readlink()) == os.ttyname(self._slave):
                self.link.unlink()
        os.close(self._master)
        os.close(self._slave)
        self._wake.close()


def _open_terminal() -> tuple[int, int]:
    """Device's and client's end of a raw pseudo-terminal.

    Both stay open here: a read of the device's end fails while no client has the other open.
    """
    import pty  # not on every system
    import tty

    master, slave = pty.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    return master, slave
