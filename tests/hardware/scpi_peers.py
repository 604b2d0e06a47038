"""Peers of the SCPI instruments: devices of pyvisa-sim, each before a simulated one."""

from functools import partial
from pathlib import Path

from pyvisa_sim.parser import get_devices

VISA = Path(__file__).with_name("visa")


class Scpi:
    """A device of pyvisa-sim that has the outputs or the power of a simulated one."""

    def __init__(self, file, device, clock=None):
        self.device = device
        found = get_devices(VISA / file, bundled=False)
        (resource,) = found.list_resources()
        self._talker = found[resource]

    def __call__(self, line):
        request = line.strip()
        head, _, value = request.decode().partition(" ")
        if head == "MEAS:POW?":
            return f"{self.device.power!r}\n".encode()
        if value in ("ON", "OFF"):
            self.device.output(int(head[1]), value == "ON")
        self._talker.write(request + b"\n")
        return b"".join(iter(lambda: self._talker.read()[0], b""))


Generator = partial(Scpi, "sdg2042x.yaml")
Meter = partial(Scpi, "pm100d.yaml")
