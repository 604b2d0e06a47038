"""Kinds of devices: connection and driver in process, model, and transcripts."""

from contextlib import contextmanager
from functools import partial
from typing import NamedTuple

from peers import T7, Controller, Firmware, Port, Visa, modbus
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


class Device(NamedTuple):
    """A kind of device in the tests."""

    name: str
    kind: object  # of its connection in process
    driver: object
    model: object
    role: str
    pair: object = in_bytes(str.encode)  # of what is written in its transcripts

    @property
    def file(self):
        """Its transcripts."""
        return read_document(HERE / "transcripts" / f"{self.name}.yml")


def called(driver, call, options=None, **written):
    """What a driver does or tells, as it is written in the transcripts."""
    found = getattr(driver, call)
    if callable(found):
        found = found(*written.get("with", ()), **(options or {}))
    return list(found) if isinstance(found, tuple) else found


MOTOR = partial(Motor, kind=MOTORS["mts50-z8"])
READ_OUT = partial(
    LabJackT7, stream=Port(), safe_lines=["FIO0", "FIO1"], parked=["TDAC2"]
)
DEVICES = [
    Device("apt", Port, MOTOR, Controller, "stage", in_bytes(bytes.fromhex)),
    Device("pm100d", Visa, PowerMeter, Meter, "power_meter"),
    Device("rf", Port, RfDriver, Firmware, "rf_emission"),
    Device("sdg2042x", Visa, SignalGenerator, Generator, "clock"),
    Device("t7", modbus, READ_OUT, T7, "daq", feedback),
]
