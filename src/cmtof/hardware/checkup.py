"""What a bench reports of itself before anything moves."""

from collections.abc import Callable, Iterator

from cmtof.hardware.bench import Bench
from cmtof.hardware.roles import RfStatus


def states_of(bench: Bench) -> Iterator[tuple[str, str]]:
    """Each device and what it reports; a device that fails says so instead."""
    for role, device in bench.devices.items():
        yield device.name, _told(lambda one=device: " ".join(one.identify().values()))
        if role.startswith("rf"):
            yield "", _told(lambda one=device: _rf_state(one.status()))
        if role in ("plate_emission", "plate_detection", "stage"):
            yield "", _told(lambda one=device: _position(one.homed, one.position))
    for channel in bench.rig.clock_channels:
        yield (
            f"clock channel {channel}",
            _told(lambda one=channel: "on" if bench.clock.output_is_on(one) else "off"),
        )
    yield "power", _told(lambda: f"{1e3 * bench.power_meter.power:.4g} mW at the meter")
    yield (
        "interlock",
        _told(lambda: _interlock(bench.daq.line(bench.rig.line("interlock")))),
    )


def _interlock(closed: bool) -> str:
    return (
        "closed"
        if closed
        else "Expected it closed, got it open. Close doors and covers."
    )


def _rf_state(status: RfStatus) -> str:
    words = ["RF on" if status.on else "RF off"]
    words += ["locked"] * status.locked + ["tripped"] * status.tripped
    return ", ".join(words)


def _position(homed: bool, position: float) -> str:
    return f"at {position:.6g}, homed" if homed else "not homed"


def _told(ask: Callable[[], str]) -> str:
    """Answer to a question, or the error."""
    try:
        return ask()
    except OSError as error:
        return str(error)
