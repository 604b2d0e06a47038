"""Thorlabs PM100D with an S140C integrating sphere: the laser power behind the emission module.

Commands: PM100D manual, SCPI commands. The zeroing commands stand in the PM400's manual only, so
on a PM100D they are not verified.
"""

import time

from cmtof.hardware.codecs import scpi
from cmtof.hardware.device import check_set
from cmtof.hardware.drivers.scpi_link import ScpiDevice
from cmtof.hardware.errors import InstrumentTimeout, Refused
from cmtof.hardware.transport import Transport

_SAMPLE = 3e-3  # s, one reading before averaging
_POLL = 0.05  # s, between questions for the end of zeroing


class PowerMeter(ScpiDevice):
    """The meter; parameters as of `ScpiDevice`. It emits nothing, so any state is safe."""

    def __init__(self, transport: Transport, name: str = "power meter", **options: float) -> None:
        super().__init__(transport, name, **options)
        self._averages = 1

    def identify(self) -> tuple[scpi.Identity, scpi.Sensor]:
        """Check that a PM100D answers and carries a head for power; both identities.

        Raises
        ------
        Refused
            If it is another device, or a head without power or wavelength.
        """
        found = self._identity()
        if "thorlabs" not in found.maker.lower() or not found.model.upper().startswith("PM100"):
            raise Refused(
                f"Expected a Thorlabs PM100D at {self.name}, got {found.maker} {found.model}. "
                "Check the address."
            )
        sensor = self._query("SYST:SENS:IDN?", scpi.parse_sensor)
        if scpi.SensorFlags.POWER not in sensor.flags:
            raise Refused(
                f"Expected a head that measures power at {self.name}, got {sensor.name}. "
                "Plug in the S140C."
            )
        return found, sensor

    def set_wavelength(self, metres: float) -> float:
        """Set the wavelength that the head is corrected for, m; return what was set.

        Raises
        ------
        ValueError
            If the head does not reach it.
        Refused
            If the meter kept another.
        """
        wanted = metres * 1e9
        low = self._query("SENS:CORR:WAV? MIN", scpi.parse_number)
        high = self._query("SENS:CORR:WAV? MAX", scpi.parse_number)
        if not low <= wanted <= high:
            raise ValueError(
                f"Expected {low:g} to {high:g} nm for the head of {self.name}, got {wanted:g}. "
                "Choose another wavelength or head."
            )
        self._send(f"SENS:CORR:WAV {wanted:.6g}")
        found = self._query("SENS:CORR:WAV?", scpi.parse_number)
        return 1e-9 * check_set(self.name, "wavelength", wanted, found, tolerance=0.5, unit="nm")

    def set_averaging(self, count: int) -> int:
        """Average so many readings of 3 ms each."""
        if not 1 <= count <= 10000:
            raise ValueError(f"Expected 1 to 10000 readings, got {count}. Choose another.")
        self._send(f"SENS:AVER:COUN {count}")
        found = self._query("SENS:AVER:COUN?", scpi.parse_number)
        self._averages = int(
            check_set(self.name, "averaging", count, found, tolerance=0.0, unit="readings")
        )
        return self._averages

    def zero(self, timeout: float = 30.0) -> float:
        """Take what the head sees now as dark; cover it first. Return that power, W.

        Raises
        ------
        InstrumentTimeout
            If the meter does not finish.
        """
        self._send("SENS:CORR:COLL:ZERO:INIT")
        deadline = time.monotonic() + timeout
        while self._query("SENS:CORR:COLL:ZERO:STAT?", scpi.parse_number):
            if time.monotonic() >= deadline:
                raise InstrumentTimeout(
                    f"Expected {self.name} to be zeroed within {timeout:g} s, got no end. "
                    "Cover the head and try again."
                )
            time.sleep(_POLL)
        return self._query("SENS:CORR:COLL:ZERO:MAGN?", scpi.parse_number)

    def power(self) -> float:
        """Power, W.

        Raises
        ------
        BadReply
            If the reading is beyond the range.
        """
        timeout = self._timeout + 2 * _SAMPLE * self._averages
        return self._query("MEAS:POW?", scpi.parse_number, timeout=timeout)
