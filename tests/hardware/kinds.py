"""Kinds of devices: connection and driver in process, model, and transcripts."""

from contextlib import contextmanager
from functools import partial

from peers import (
    T7,
    Controller,
    Firmware,
    Port,
    Visa,
    modbus,
    simulated,
)
from registers import HERE, feedback, in_bytes
from scpi_peers import Generator, Meter

from cmtof.files import read_document
from cmtof.hardware.apt import MOTORS, Motor
from cmtof.hardware.rf import RfDriver
from cmtof.hardware.scpi import PowerMeter, SignalGenerator
from cmtof.hardware.t7 import LabJackT7


@contextmanager
def dialogue(kind, *pairs):
    """Port or resource that holds one dialogue of (sent, reply), and no other."""
    heard = []
    replies = [reply for _, reply in pairs]

    def answer(request):
        heard.append(request)
        return replies.pop(0) if replies else b""

    yield kind(answer)
    assert heard == [sent for sent, _ in pairs]


class Device:
    """A kind of device in the tests: connection and driver in process, model, and transcripts."""

    def __init__(self, name, kind, driver, model):
        self.kind = kind
        self.driver = driver
        self.model = model
        self.file = read_document(HERE / "transcripts" / f"{name}.yml")
        coded = in_bytes(bytes.fromhex if name == "apt" else str.encode)
        self.pair = feedback if name == "t7" else coded


def called(driver, call, options=None, **written):
    """What a driver does or tells, as it is written in the transcripts."""
    found = getattr(driver, call)
    found = (
        found(*written.get("with", ()), **(options or {})) if callable(found) else found
    )
    return list(found) if isinstance(found, tuple) else found


DEVICES = {
    name: Device(name, *parts)
    for name, *parts in (
        (
            "apt",
            Port,
            partial(Motor, kind=MOTORS["mts50-z8"]),
            lambda: Controller(simulated("stage")),
        ),
        ("pm100d", Visa, PowerMeter, lambda: Meter(simulated("power_meter"))),
        ("rf", Port, RfDriver, lambda: Firmware(simulated("rf_emission"))),
        ("sdg2042x", Visa, SignalGenerator, lambda: Generator(simulated("clock"))),
        (
            "t7",
            modbus,
            partial(
                LabJackT7, stream=Port(), safe_lines=["FIO0", "FIO1"], parked=["TDAC2"]
            ),
            lambda: T7(simulated("daq")),
        ),
    )
}
