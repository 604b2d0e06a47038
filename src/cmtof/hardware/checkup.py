"""Reports of a bench's devices before anything moves."""

from collections.abc import Callable, Iterator

from cmtof.hardware.bench import Bench
from cmtof.hardware.roles import RfStatus


def states_of(bench: Bench) -> Iterator[tuple[str, str]]:
    """Name of each device and its report, or its error if it fails."""
    for role, device in bench.devices.items():
        yield (
            device.name,
            _reply(lambda one=device: " ".join(one.identify().values())),
        )
        if role.startswith("rf"):
            yield "", _reply(lambda one=device: _rf_text(one.status()))
        if role in ("plate_emission", "plate_detection", "stage"):
            yield (
                "",
                _reply(
                    lambda one=device: (
                        f"at {one.position:.6g}, homed" if one.homed else "not homed"
                    )
                ),
            )
    for channel in bench.rig.clock_channels:
        yield (
            f"clock channel {channel}",
            _reply(
                lambda one=channel: "on" if bench.clock.output_is_on(one) else "off"
            ),
        )
    yield (
        "power",
        _reply(lambda: f"{1e3 * bench.power_meter.power:.4g} mW at the meter"),
    )
    yield (
        "interlock",
        _reply(
            lambda: (
                "closed"
                if bench.daq.line(bench.rig.line("interlock"))
                else "Expected it closed, got it open. Close doors and covers."
            )
        ),
    )


def _rf_text(status: RfStatus) -> str:
    words = ["RF on" if status.on else "RF off"]
    words += ["locked"] * status.locked + ["tripped"] * status.tripped
    return ", ".join(words)


def _reply(ask: Callable[[], str]) -> str:
    """Text that ``ask`` returns, or the message of its error."""
    try:
        return ask()
    except OSError as error:
        return str(error)
