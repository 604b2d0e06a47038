"""The whole simulated instrument: every device of a rig as a server, before one physical model."""

import tempfile
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, Self
from urllib.parse import urlsplit

from cmtof.hardware.rig import Rig
from cmtof.hardware.rig_settings import DeviceSettings, LineSettings
from cmtof.hardware.twin.apt_server import AptServer
from cmtof.hardware.twin.faults import Faults, faults_from_settings
from cmtof.hardware.twin.lines import LOOPBACK, PtyLine, Serve, TcpLine
from cmtof.hardware.twin.modbus_server import T7Server
from cmtof.hardware.twin.pm100_server import PowerMeterServer
from cmtof.hardware.twin.rf_server import RfServer
from cmtof.hardware.twin.sdg_server import SdgServer
from cmtof.instrument.panel import Panel
from cmtof.instrument.settings import TwinSettings
from cmtof.instrument.world import World


class Server(Protocol):
    """A simulated device."""

    def serve(self, channel: Any) -> None:
        """Talk to one client until it has gone."""
        ...


class Twin:
    """Simulated instrument of a rig: servers in threads of this process, on loopback only.

    Parameters
    ----------
    rig : Rig
        Devices, addresses, wiring; what stands below ``twin:`` sets up the physics and the faults.
    scene : str, Path, Frame, mapping or None
        What stands before the instrument; None is the scene of the RIG file.
    seed : int
        Of noise, drift and speckle.
    world : World or None
        Another physical model.
    private : bool
        Free ports and pseudo-terminals in a folder of its own, in place of the rig's addresses.
    pace : float
        Wall-clock seconds for one virtual second of a motor's move.

    Attributes
    ----------
    rig : Rig
        The rig with the addresses that answer.
    panel : Panel
        Every knob.
    faults : Faults
        Faults on demand; may be added at any time.
    world : World

    Raises
    ------
    ValueError
        If the settings below ``twin:`` cannot be, or an address is not on this machine.
    OSError
        If an address is taken.

    Examples
    --------
    >>> with Twin.default(seed=0) as twin:
    ...     twin.rig.settings.devices["daq"].address.rpartition(":")[0]
    'tcp://127.0.0.1'
    """

    def __init__(
        self,
        rig: Rig,
        *,
        scene: Any = None,
        seed: int = 0,
        world: Any = None,
        private: bool = False,
        pace: float = 0.01,
    ) -> None:
        settings = TwinSettings.from_mapping(rig.settings.twin)
        self.rig = rig
        self.panel = Panel()
        self.faults = Faults(faults_from_settings(settings.faults))
        self.world = World(settings, scene, seed=seed) if world is None else world
        self._private, self._pace = private, pace
        self._running = ExitStack()

    @classmethod
    def default(cls, *, scene: Any = None, seed: int = 0, **options: Any) -> Self:
        """Build the twin of the default rig at private addresses; options as of the class."""
        return cls(Rig.default(), scene=scene, seed=seed, private=True, **options)

    def start(self) -> Self:
        """Start every server; `stop` ends them."""
        with ExitStack() as running:
            folder = None
            if self._private:
                made = tempfile.TemporaryDirectory(prefix="cmtof-twin-")
                folder = Path(running.enter_context(made))
            # the ports first: when another twin serves this rig they are taken, and its links stay
            devices = sorted(self.rig.settings.devices.items(), key=lambda one: _is_serial(one[1]))
            addresses = {
                role: self._serve(role, device, folder, running) for role, device in devices
            }
            if self._private:
                self.rig = self.rig.with_addresses(addresses)
            self._running = running.pop_all()
        return self

    def stop(self) -> None:
        """Stop every server and wait for it; may be called again."""
        self._running.close()

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    def _serve(
        self, role: str, device: DeviceSettings, folder: Path | None, running: ExitStack
    ) -> dict[str, str]:
        """Start one device; its live addresses."""
        server = self._server(role, device)
        if _is_serial(device):
            path = Path(self.rig.address(role).removeprefix("serial:").partition("?")[0])
            line = PtyLine(folder / role if folder else path, server.serve, f"twin-{role}")
            running.callback(line.stop)
            return {"address": line.address}
        if not isinstance(server, T7Server):
            return {"address": self._port(role, "address", server.serve, running).address}
        running.callback(server.stop)
        stream = self._port(role, "stream", None, running)
        server.stream.publish = stream.broadcast
        command = self._port(role, "address", server.serve, running)
        return {"address": command.address, "stream": stream.address}

    def _server(self, role: str, device: DeviceSettings) -> Server:
        watch = self.faults.watch(role)
        if device.driver == "rf-driver":
            which = "emission" if role == "rf_emission" else "detection"
            return RfServer(self.panel, self.world, which, watch)
        if device.driver == "sdg2042x":
            return SdgServer(self.panel, watch)
        if device.driver == "pm100d":
            return PowerMeterServer(self.panel, self.world, watch)
        if device.driver in ("k10cr1", "kdc101"):
            motor = device.stage or device.driver
            return AptServer(self.panel, motor, role, watch, pace=self._pace)
        galvo = self.rig.settings.galvo
        return T7Server(
            self.panel,
            self.world,
            watch,
            wiring=_wiring(self.rig.settings.lines),
            galvo=[int(name.removeprefix("TDAC")) for name in (galvo.x, galvo.y)],
        )

    def _port(self, role: str, which: str, serve: Serve | None, running: ExitStack) -> TcpLine:
        host, port = _host_and_port(self.rig.address(role, which), role)
        if self._private:
            port = 0
        line = TcpLine(host, port, serve, f"twin-{role}-{which}")
        running.callback(line.stop)
        return line


def _is_serial(device: DeviceSettings) -> bool:
    return device.address.startswith("serial:")


def _host_and_port(address: str, role: str) -> tuple[str, int]:
    try:
        parts = urlsplit(address)
        if parts.scheme == "tcp" and parts.port is not None:
            return parts.hostname or "", parts.port
    except ValueError:  # a port that is none
        pass
    raise ValueError(
        f"Expected tcp://{LOOPBACK}:PORT for the simulated {role}, got {address!r}. "
        "Change it in the RIG file."
    )


def _wiring(lines: LineSettings) -> dict[str, int]:
    """DIO numbers of the lines: FIO0 to FIO7 are DIO0 to DIO7."""
    roles = ("laser", "shutter", "trigger", "flip_mirror", "beam_block", "interlock")
    return {role: int(getattr(lines, role).removeprefix("FIO")) for role in roles}
