"""A simulated Siglent SDG2042X: SCPI over raw TCP, with the habits of the real one.

Facts: SDG2000X Programming Guide (BSWV, OUTP, ROSC, MODE, EQPHASE, COUP) and public acceptance
notes of an SDG2122X. There is no error queue: what is out of range is clamped, what is not known is
dropped, and a query that is not known gets no answer at all. Amplitudes are with respect to the
load that is set; HLEV and LLEV follow AMP and OFST, PERI follows FRQ, and the other way round.
"""

from dataclasses import dataclass, field
from threading import Lock

from cmtof.hardware.twin.faults import Watch
from cmtof.hardware.twin.lines import Channel
from cmtof.hardware.twin.text import number_from_text, serve_lines
from cmtof.instrument.panel import Panel

FREQUENCY = (1e-6, 40e6)
"""Sine frequencies, Hz (SDG2042X data sheet)."""
SWING = 20.0
"""Largest peak-to-peak voltage into an open output, V; half of it into 50 ohm."""
LEAST_SWING = 2e-3
_OUTPUT_OHM = 50.0
_LOAD = (50.0, 1e5)
_IDENTITY = "Siglent Technologies,SDG2042X,SDG2XTWIN0001,2.01.01.39R7T2"
_SHAPES = ("SINE", "SQUARE", "RAMP", "PULSE", "NOISE", "ARB", "DC")


@dataclass
class _Output:
    """One channel; voltages are those of the open output (twice those into 50 ohm)."""

    shape: str = "SINE"
    frequency: float = 1000.0
    swing: float = 4.0
    offset: float = 0.0
    phase: float = 0.0
    on: bool = False
    load: float = field(default=float("inf"))
    polarity: str = "NOR"

    @property
    def share(self) -> float:
        """Part of the open output's voltage that the load sees."""
        return 1.0 if self.load == float("inf") else self.load / (self.load + _OUTPUT_OHM)


class SdgServer:
    """One function generator with two outputs; any number of clients share it.

    Parameters
    ----------
    panel : Panel
        Output 1 is the clock of the RF drivers.
    watch : Watch
        Faults of this device.
    hyphen : bool
        Whether MODE takes PHASE-LOCKED (SDG2000X) or PHASELOCKED (as noted of an SDG1032X); the
        other spelling is ignored in silence.
    """

    def __init__(self, panel: Panel, watch: Watch, *, hyphen: bool = True) -> None:
        self._panel, self._watch = panel, watch
        self._locked_word = "PHASE-LOCKED" if hyphen else "PHASELOCKED"
        self._lock = Lock()
        self._reset()

    def _reset(self) -> None:
        self._outputs = {"C1": _Output(), "C2": _Output()}
        self._reference = "INT"
        self._mode = "INDEPENDENT"
        self._coupling = {"PCOUP": "OFF", "PDEV": 0.0, "FCOUP": "OFF", "FDEV": 0.0}
        self._show()

    def serve(self, channel: Channel) -> None:
        """Talk to one client until it has gone."""
        serve_lines(channel, self._answer)

    def _answer(self, line: str, channel: Channel) -> None:
        trouble = self._watch.next()
        reply = b""
        if not trouble.unheard:
            with self._lock:
                replies = [self._obey(one.strip()) for one in line.split(";")]
            reply = "".join(f"{one}\n" for one in replies if one is not None).encode()
        trouble.deliver(channel, reply)

    def _obey(self, command: str) -> str | None:
        """Reply to one command, None where there is none."""
        head, _, tail = command.upper().partition(" ")
        output, colon, word = head.rpartition(":")
        if colon and output not in self._outputs:
            return None
        if word.endswith("?"):
            return self._query(output, word)
        if self._watch.takes("ignore"):
            return None
        arguments = [one.strip() for one in tail.split(",")] if tail.strip() else []
        if output:
            setting = {"BSWV": self._set_wave, "OUTP": self._set_output}.get(word)
            if setting is not None:
                setting(self._outputs[output], arguments)
        elif word == "*RST":
            self._reset()
        elif word == "ROSC" and arguments[:1] in (["INT"], ["EXT"]):
            self._reference = arguments[0]
        elif word == "MODE" and arguments[:1] in ([self._locked_word], ["INDEPENDENT"]):
            self._mode = arguments[0]
        elif word == "COUP":
            self._set_coupling(arguments)
        # EQPHASE aligns the phases and leaves nothing to be seen; all else is dropped
        self._show()
        return None

    def _query(self, output: str, word: str) -> str | None:
        if output:
            state = self._outputs[output]
            if word == "BSWV?":
                return f"{output}:BSWV {_wave(state)}"
            if word == "OUTP?":
                load = "HZ" if state.load == float("inf") else f"{state.load:g}"
                switch = "ON" if state.on else "OFF"
                return f"{output}:OUTP {switch},LOAD,{load},PLRT,{state.polarity}"
            return None
        pairs = (f"{key},{value if isinstance(value, str) else _number(value)}"
                 for key, value in self._coupling.items())  # fmt: skip
        return {
            "*IDN?": _IDENTITY,
            "*OPC?": "1",
            "ROSC?": f"ROSC {self._reference},10MOUT,OFF",
            "MODE?": f"MODE {self._mode}",
            "COUP?": f"COUP {','.join(pairs)}",
        }.get(word)

    def _set_wave(self, output: _Output, arguments: list[str]) -> None:
        for key, text in zip(arguments[::2], arguments[1::2], strict=False):
            if key == "WVTP":
                output.shape = text if text in _SHAPES else output.shape
            elif (value := _value(text)) is not None:
                self._set_value(output, key, value)

    def _set_value(self, output: _Output, key: str, value: float) -> None:
        """Set one number and all that is coupled to it, clamped without a word."""
        share = output.share
        high, low = output.offset + output.swing / 2, output.offset - output.swing / 2
        if key == "FRQ" or (key == "PERI" and value > 0):
            frequency = value if key == "FRQ" else 1 / value
            output.frequency = self._clamped(frequency, *FREQUENCY)
        elif key == "AMP":
            output.swing = self._clamped(value / share, LEAST_SWING, SWING)
        elif key == "OFST":
            output.offset = value / share
        elif key == "HLEV" and value / share > low:
            output.swing, output.offset = value / share - low, (value / share + low) / 2
        elif key == "LLEV" and value / share < high:
            output.swing, output.offset = high - value / share, (high + value / share) / 2
        elif key == "PHSE":
            output.phase = self._clamped(value, -360.0, 360.0)
        output.swing = min(max(output.swing, LEAST_SWING), SWING)
        room = (SWING - output.swing) / 2
        output.offset = min(max(output.offset, -room), room)

    def _clamped(self, value: float, low: float, high: float) -> float:
        return self._watch.pulled(min(max(value, low), high), low, high)

    def _set_output(self, output: _Output, arguments: list[str]) -> None:
        if arguments[:1] in (["ON"], ["OFF"]):
            output.on = arguments[0] == "ON"
            arguments = arguments[1:]
        for key, text in zip(arguments[::2], arguments[1::2], strict=False):
            value = number_from_text(text)
            if key == "LOAD" and text == "HZ":
                output.load = float("inf")
            elif key == "LOAD" and value is not None:
                output.load = min(max(value, _LOAD[0]), _LOAD[1])
            elif key == "PLRT" and text in ("NOR", "INVT"):
                output.polarity = text

    def _set_coupling(self, arguments: list[str]) -> None:
        for key, text in zip(arguments[::2], arguments[1::2], strict=False):
            if key in ("PCOUP", "FCOUP") and text in ("ON", "OFF"):
                self._coupling[key] = text
            elif key in ("PDEV", "FDEV") and (value := _value(text)) is not None:
                self._coupling[key] = value

    def _show(self) -> None:
        """Turn the knobs of the panel: output 1 clocks the RF drivers."""
        clock = self._outputs["C1"]
        with self._panel.lock:
            self._panel.clock_on, self._panel.clock_frequency = clock.on, clock.frequency


def _wave(output: _Output) -> str:
    """Everything of BSWV?, each value with its unit but the phase."""
    share = output.share
    high, low = output.offset + output.swing / 2, output.offset - output.swing / 2
    return (
        f"WVTP,{output.shape},FRQ,{_number(output.frequency)}HZ,"
        f"PERI,{_number(1 / output.frequency)}S,AMP,{_number(output.swing * share)}V,"
        f"OFST,{_number(output.offset * share)}V,HLEV,{_number(high * share)}V,"
        f"LLEV,{_number(low * share)}V,PHSE,{_number(output.phase)}"
    )


def _number(value: float) -> str:
    return f"{value:.10g}"


def _value(text: str) -> float | None:
    """Number with or without a unit: 1000HZ, 1KHZ, 4V, 0.001S."""
    for unit, factor in (("MHZ", 1e6), ("KHZ", 1e3), ("HZ", 1.0), ("MV", 1e-3), ("V", 1.0),
                         ("MS", 1e-3), ("US", 1e-6), ("S", 1.0)):  # fmt: skip
        if text.endswith(unit):
            number = number_from_text(text.removesuffix(unit))
            return None if number is None else number * factor
    return number_from_text(text)
