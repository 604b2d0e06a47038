"""Connections to the real devices of a rig."""

from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from typing import Any

from cmtof.air import group_index
from cmtof.hardware.bench import LIGHT, Bench
from cmtof.hardware.rig import LINES, DeviceSettings, Rig


@contextmanager
def connected_bench(rig: Rig) -> Iterator[Bench]:
    """Bench of a rig's real devices, which are closed again, also if one cannot be reached."""
    with ExitStack() as reached:
        devices = {}
        for role, settings in rig.devices.items():
            driver = connected_driver(role.replace("_", " "), settings)
            devices[role] = reached.enter_context(closing(driver))
        with Bench(rig, devices, source="instrument", group_index=group_index()) as bench:
            yield bench


def connected_driver(name: str, settings: DeviceSettings) -> Any:
    """Driver of a device, connected."""
    from cmtof.hardware import apt, rf, scpi, t7

    address = settings.address
    match settings.driver:
        case "labjack-t7":
            stream = rf.open_serial(f"socket://{address.partition(':')[0]}:702")
            safe = [LINES[part] for part in LIGHT]
            return t7.LabJackT7(t7.open_modbus(address), stream, name, safe)
        case "rf-driver":
            return rf.RfDriver(rf.open_serial(address), name)
        case "sdg2042x":
            return scpi.SignalGenerator(scpi.open_visa(address), name)
        case "pm100d":
            return scpi.PowerMeter(scpi.open_visa(address), name)
    kind = apt.MOTORS[settings.driver]
    kind = kind._replace(scale=settings.counts_per_unit or kind.scale)
    port = rf.open_serial(address, rtscts="://" not in address)
    return apt.Motor(port, kind, name, settings.serial_number)
