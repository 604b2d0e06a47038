"""Connections to the real devices of a rig."""

from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from typing import Any

from cmtof.hardware.bench import Bench
from cmtof.hardware.rig import LIGHT, LINES, MIRRORS, DeviceSettings, Rig

DARK_FIRST = ("daq", "rf_emission", "rf_detection")
"""What may still send out light or RF after a scan that was killed; it is connected first."""


@contextmanager
def connected_bench(rig: Rig) -> Iterator[Bench]:
    """Bench of a rig's real devices, which are closed again, also if one cannot be reached.

    Every device has to be the one that the rig names, and is in its safe state before the next one
    is connected.
    """
    with ExitStack() as reached:
        devices: dict[str, Any] = {}
        for role in dict.fromkeys((*DARK_FIRST, *rig.devices)):
            device = connected_driver(role.replace("_", " "), rig.devices[role])
            devices[role] = reached.enter_context(closing(device))
            device.identify()
            device.safe_state()
        with Bench(rig, devices, source="instrument", group_index=rig.group_index) as bench:
            yield bench


def connected_driver(name: str, settings: DeviceSettings) -> Any:
    """Driver of a device, connected."""
    from cmtof.hardware import apt, rf, scpi

    address = settings.address
    serial_number = settings.serial_number
    match settings.driver:
        case "labjack-t7":
            return connected_read_out(name, settings)
        case "rf-driver":
            return rf.RfDriver(rf.open_serial(address), name, serial_number)
        case "sdg2042x":
            return scpi.SignalGenerator(scpi.open_visa(address), name, serial_number)
        case "pm100d":
            return scpi.PowerMeter(scpi.open_visa(address), name, serial_number)
    kind = apt.MOTORS[settings.driver]
    kind = kind._replace(scale=settings.counts_per_unit or kind.scale)
    return apt.Motor(apt.open_controller(address), kind, name, serial_number)


def connected_read_out(name: str, settings: DeviceSettings) -> Any:
    """Driver of a T7: ``HOST``, or ``HOST:PORT`` whose stream comes from the port 200 above."""
    from cmtof.hardware import rf, t7
    from cmtof.hardware.device import ConnectionLost, one_error
    from cmtof.hardware.modbus import PORT, Feedback

    host, _, port = settings.address.partition(":")
    with one_error(f"a T7 at {settings.address}", ConnectionLost):
        client = Feedback(settings.address)
    stream = rf.open_serial(f"socket://{host}:{int(port or PORT) + 200}")
    lines = [LINES[part] for part in LIGHT]
    return t7.LabJackT7(
        client, stream, name, settings.serial_number, safe_lines=lines, parked=MIRRORS
    )
