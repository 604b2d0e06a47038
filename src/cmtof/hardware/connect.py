"""Connections to the real devices of a rig."""

from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from typing import Any, TextIO

from cmtof.hardware.bench import Bench
from cmtof.hardware.device import ConnectionLost, one_error
from cmtof.hardware.log import Logged
from cmtof.hardware.modbus import PORT, Feedback
from cmtof.hardware.rig import LIGHT, LINES, MIRRORS, DeviceSettings, Rig

DARK_FIRST = ("daq", "rf_emission", "rf_detection")
"""What may still send out light or RF after a scan that was killed; it is connected first."""


@contextmanager
def connected_bench(rig: Rig, log: TextIO | None = None) -> Iterator[Bench]:
    """Bench of a rig's real devices, which are closed again, also if one cannot be reached.

    Every device has to be the one that the rig names, and is in its safe state before the next one
    is connected. Requests and replies go into ``log``.
    """
    with ExitStack() as reached:
        devices: dict[str, Any] = {}
        for role in dict.fromkeys((*DARK_FIRST, *rig.devices)):
            device = connected_driver(role.replace("_", " "), rig.devices[role], log)
            devices[role] = reached.enter_context(closing(device))
            device.identify()
            device.safe_state()
        with Bench(rig, devices, source="instrument", group_index=rig.group_index) as bench:
            yield bench


def connected_driver(name: str, settings: DeviceSettings, log: TextIO | None = None) -> Any:
    """Driver of a device, connected; requests and replies go into ``log``."""
    from cmtof.hardware import apt, rf, scpi

    opened = {
        "labjack-t7": open_feedback,
        "rf-driver": rf.open_serial,
        "sdg2042x": scpi.open_visa,
        "pm100d": scpi.open_visa,
    }.get(settings.driver, apt.open_controller)(settings.address, settings.timeout)
    connection = Logged(opened, name, log) if log else opened
    match settings.driver:
        case "labjack-t7":
            return read_out(connection, name, settings)
        case "rf-driver":
            return rf.RfDriver(connection, name, settings.serial_number)
        case "sdg2042x":
            return scpi.SignalGenerator(connection, name, settings.serial_number)
        case "pm100d":
            return scpi.PowerMeter(connection, name, settings.serial_number)
    kind = apt.MOTORS[settings.driver]
    kind = kind._replace(scale=settings.counts_per_unit or kind.scale)
    return apt.Motor(connection, kind, name, settings.serial_number)


def open_feedback(address: str, timeout: float) -> Feedback:
    """Open the connection for commands of a T7, or raise `ConnectionLost`."""
    with one_error(f"a T7 at {address}", ConnectionLost):
        return Feedback(address, timeout)


def read_out(connection: Any, name: str, settings: DeviceSettings) -> Any:
    """Driver of a T7: ``HOST``, or ``HOST:PORT`` whose stream comes from the port 200 above."""
    from cmtof.hardware import rf, t7

    host, _, port = settings.address.partition(":")
    stream = rf.open_serial(f"socket://{host}:{int(port or PORT) + 200}", settings.timeout)
    lines = [LINES[part] for part in LIGHT]
    return t7.LabJackT7(
        connection, stream, name, settings.serial_number, safe_lines=lines, parked=MIRRORS
    )
