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
        self._talker = found[found.list_resources()[0]]

    def __call__(self, line):
        request = line.strip()
        head, _, value = request.decode().partition(" ")
        if head == "MEAS:POW?":  # -30 while it is left in dBm
            return b"%r\n" % (
                -30.0 if b"DBM" in self(b"SENS:POW:UNIT?") else self.device.power
            )
        if value in ("ON", "OFF"):
            self.device.output(int(head[1]), value == "ON")
        self._talker.write(request + b"\n")
        return b"".join(iter(lambda: self._talker.read()[0], b""))


Generator = partial(Scpi, "sdg2042x.yaml")
Meter = partial(Scpi, "pm100d.yaml")
