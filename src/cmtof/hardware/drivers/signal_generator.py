"""Siglent SDG2042X: the clock of both RF drivers.

The device has no error queue: what it does not like it drops or clamps without a word (SDG
Programming Guide; acceptance of an SDG2122X, firmware 2.01.01.39R7T2). So every setting is read
back. The amplitude is that into the set load, so the load comes first.
"""

import functools
import math
from typing import Literal

from cmtof.hardware.codecs import scpi
from cmtof.hardware.device import check_set
from cmtof.hardware.drivers.scpi_link import ScpiDevice
from cmtof.hardware.errors import Refused
from cmtof.hardware.transport import Transport

CHANNELS = (1, 2)
_SPELLINGS = ("PHASE-LOCKED", "PHASELOCKED")  # firmware takes one and ignores the other


class SignalGenerator(ScpiDevice):
    """The generator; parameters as of `ScpiDevice`.

    It makes up to 40 MHz and no GHz tone: the RF drivers multiply its clock.
    """

    def __init__(self, transport: Transport, name: str = "clock", **options: float) -> None:
        super().__init__(transport, name, **options)
        self._loads: set[int] = set()

    def identify(self) -> scpi.Identity:
        """Check that an SDG2000X answers.

        Raises
        ------
        Refused
            If it is another device.
        """
        found = self._identity()
        if "siglent" not in found.maker.lower() or not found.model.upper().startswith("SDG2"):
            raise Refused(
                f"Expected a Siglent SDG2042X at {self.name}, got {found.maker} {found.model}. "
                "Check the address."
            )
        return found

    def set_load(self, channel: int, ohm: float | Literal["HZ"]) -> None:
        """Tell a channel what it drives: Ohm, or "HZ" for high impedance."""
        self._check_channel(channel)
        text = "HZ" if ohm == "HZ" else f"{ohm:.10g}"
        self._send(f"C{channel}:OUTP LOAD,{text}")
        found, wanted = self._output(channel).load, math.inf if ohm == "HZ" else float(ohm)
        if found != wanted:
            check_set(self.name, "load", wanted, found, tolerance=0.5, unit="Ohm")
        self._loads.add(channel)

    def set_sine(
        self,
        channel: int,
        *,
        frequency: float,
        amplitude: float,
        offset: float = 0.0,
        phase: float = 0.0,
    ) -> scpi.Wave:
        """Set a sine; the output stays as it is. Its load must have been set.

        Parameters
        ----------
        channel : int
            1 or 2.
        frequency : float
            Hz.
        amplitude, offset : float
            V peak to peak and V, into the load.
        phase : float
            rad.

        Returns
        -------
        Wave
            As read back.

        Raises
        ------
        Refused
            If the device kept or clamped a value.
        """
        if channel not in self._loads:
            raise ValueError(
                f"Expected the load of channel {channel} before its amplitude, which the device "
                "takes by it, got none. Call set_load first."
            )
        degrees = math.degrees(phase) % 360
        self._send(
            f"C{channel}:BSWV WVTP,SINE,FRQ,{frequency:.10g},AMP,{amplitude:.6g},"
            f"OFST,{offset:.6g},PHSE,{degrees:.6g}"
        )
        wave = self._query(f"C{channel}:BSWV?", lambda line: scpi.parse_wave(line, channel))
        if wave.kind != "SINE":
            raise Refused(f"Expected {self.name} to make a SINE, got {wave.kind}. Set it by hand.")
        for quantity, wanted, found, tolerance, unit in (
            ("frequency", frequency, wave.frequency, 1e-6 + 1e-9 * frequency, "Hz"),
            ("amplitude", amplitude, wave.amplitude, 1e-3 + 1e-3 * amplitude, "V"),
            ("offset", offset, wave.offset, 1e-3 + 1e-3 * abs(offset), "V"),
        ):
            found = math.nan if found is None else found
            check_set(self.name, quantity, wanted, found, tolerance=tolerance, unit=unit)
        turned = math.nan if wave.phase is None else math.degrees(wave.phase) - degrees
        check_set(
            self.name, "phase", 0.0, (turned + 180) % 360 - 180, tolerance=0.06, unit="degrees off"
        )
        return wave

    def output(self, channel: int, on: bool) -> None:
        """Switch a channel's output, and check it."""
        self._check_channel(channel)
        wanted = "ON" if on else "OFF"
        self._send(f"C{channel}:OUTP {wanted}")
        if self._output(channel).on != on:
            raise Refused(
                f"Expected output {channel} of {self.name} {wanted}, got the contrary. "
                "Look for an overload."
            )

    def reference(self, source: Literal["INT", "EXT"]) -> None:
        """Take the 10 MHz reference from inside or from the rear connector."""
        if source not in ("INT", "EXT"):
            raise ValueError(f"Expected INT or EXT, got {source!r}. Choose one.")
        self._send(f"ROSC {source}")
        found = self._query("ROSC?", scpi.parse_reference)
        if found != source:
            raise Refused(
                f"Expected {self.name} on the {source} reference, got {found}. "
                "Check the cable of the reference."
            )

    def phase_locked(self) -> None:
        """Lock the phases of both channels to one another.

        Firmware versions know one of two spellings and ignore the other without a word; both are
        tried.

        Raises
        ------
        Refused
            If neither is taken.
        """
        for spelling in _SPELLINGS:
            self._send(f"MODE {spelling}")
            if self._query("MODE?", scpi.parse_mode):
                return
        raise Refused(
            f"Expected {self.name} to lock its channels, got INDEPENDENT with both spellings. "
            "Set it at the front panel."
        )

    def align_phases(self) -> None:
        """Align both channels; do so again after each change of frequency. Not to be read back."""
        self._send("EQPHASE")

    def safe_state(self) -> None:
        """Switch both outputs off; the second even if the first does not follow.

        Raises
        ------
        Refused
            If an output is still on, or does not answer; the message names both.
        """
        failed = []
        for channel in CHANNELS:
            try:
                self._insist(functools.partial(self.output, channel, False))
            except OSError as failure:
                failed.append(str(failure))
        if failed:
            raise Refused(" ".join(failed))

    def _output(self, channel: int) -> scpi.Output:
        return self._query(f"C{channel}:OUTP?", lambda line: scpi.parse_output(line, channel))

    def _check_channel(self, channel: int) -> None:
        if channel not in CHANNELS:
            raise ValueError(f"Expected channel 1 or 2, got {channel}. Choose one.")
