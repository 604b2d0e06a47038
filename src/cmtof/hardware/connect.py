"""Connections to the real devices of a rig."""

from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from functools import partial
from pathlib import Path
from typing import Any, TextIO

from cmtof.hardware.bench import Bench
from cmtof.hardware.device import ConnectionLost, Device, Refused, insist
from cmtof.hardware.log import Logged
from cmtof.hardware.modbus import Feedback
from cmtof.hardware.rig import LIGHT, Rig
from cmtof.hardware.safety import EmergencyStop

# Devices that may still emit light or RF after a killed scan; they are connected first, each also
# if another one cannot be reached.
DARK_FIRST = ("daq", "rf_emission", "rf_detection")


@contextmanager
def connected_bench(rig: Rig, log: Path | None = None) -> Iterator[Bench]:
    """Bench of a rig's real devices, which are closed again, also if one cannot be reached.

    Every device has to be the one that the rig names, and is in its safe state before the next one
    is connected. Requests and replies are added to a file ``log``.
    """
    with ExitStack() as reached:
        devices = {}
        text = reached.enter_context(log.open("a", encoding="utf-8")) if log else None

        def reach(role: str) -> None:
            device = connected_driver(rig, role, text)
            devices[role] = reached.enter_context(closing(device))
            if role in DARK_FIRST:
                make_safe(device)
            else:
                device.identify()
                device.safe_state()

        insist(*(partial(reach, role) for role in DARK_FIRST), tries=1)
        for role in rig.devices:
            if role not in devices:
                reach(role)
        with Bench(
            rig, devices, source="instrument", group_index=rig.group_index
        ) as bench:
            yield bench


def make_safe(device: Device) -> None:
    """Bring a device into its safe state, unless it says that it is another one.

    What tells no name may yet be lit, and hear more than it can say.
    """
    stopped = [device]
    with EmergencyStop(stopped):
        try:
            device.identify()
        except Refused:  # somebody else's
            stopped.clear()
            raise


def connected_driver(rig: Rig, role: str, log: TextIO | None = None) -> Any:
    """Connected driver of a rig's device; requests and replies go into ``log``."""
    from cmtof.hardware import apt, rf, scpi

    settings = rig.devices[role]
    name = role.replace("_", " ")
    kinds = {
        "labjack-t7": (Feedback, partial(read_out, rig)),
        "rf-driver": (rf.open_serial, rf.RfDriver),
        "sdg2042x": (scpi.open_visa, scpi.SignalGenerator),
        "pm100d": (scpi.open_visa, scpi.PowerMeter),
    }
    for driver, kind in apt.MOTORS.items():
        kinds[driver] = (
            apt.open_controller,
            partial(apt.Motor, kind=kind, scale=settings.counts_per_unit or 0.0),
        )
    opened, make = kinds[settings.driver]
    connection = opened(settings.address, settings.timeout)
    if log:
        connection = Logged(connection, name, log)
    return make(connection, name=name, serial_number=settings.serial_number)


def read_out(rig: Rig, connection: Any, **named: str) -> Any:
    """Driver of a T7 at the rig's ``HOST`` or ``HOST:PORT``; its stream is at PORT + 200.

    Without a stream the T7 is brought into its safe state.
    """
    from cmtof.hardware import rf, t7

    daq = t7.LabJackT7(
        connection,
        None,
        safe_lines=[rig.line(part) for part in LIGHT],
        parked=rig.mirrors,
        **named,
    )
    host, port = connection.address
    stream = f"socket://{host}:{port + 200}"
    try:
        daq.stream = rf.open_serial(stream, rig.devices["daq"].timeout)
    except ConnectionLost:
        with closing(connection):
            make_safe(daq)
        raise
    return daq
