"""A simulated RF driver: the line protocol, the lock to the resonance, and the dead man's timer.

The protocol is ours and stands in the book's hardware guide; a lab's own driver has to speak it.
Requests ``>SEQ WORD arg...*CCCC``, replies ``<SEQ OK value...*CCCC`` or ``<SEQ ERR CODE
text*CCCC``, unsolicited ``!WORD arg...*CCCC``. Power-on state: RF off. The dead man's timer is the
one thing of the twin that runs on the wall clock, as it guards against a host that has died.
"""

import re
import time
from collections.abc import Callable
from typing import Any, Literal

import numpy as np

from cmtof.hardware.codecs.crc import crc16
from cmtof.hardware.twin.faults import Watch
from cmtof.hardware.twin.lines import Channel
from cmtof.hardware.twin.text import LineBuffer, number_from_text
from cmtof.instrument.panel import Panel, RfKnobs

BAND = (7_140_000_000, 7_170_000_000)
"""Frequencies that the driver accepts, Hz."""
POWER = (-30.0, 35.0)
"""Powers that the driver accepts, dBm."""
DEAD_MAN = (0.1, 60.0)
"""Times that the dead man's timer accepts, s."""
CODES = 65536
"""Phase codes of one turn."""
TABLE_SIZE = 64
_LINE_LIMIT = 1024
_NO_POWER = -99.0  # dBm that stand for nothing at all


class _Refusal(Exception):
    """ERR with a code and a text."""


class RfServer:
    """One RF driver.

    Parameters
    ----------
    panel : Panel
    world : World
        Asked for the state of the lock.
    which : {"emission", "detection"}
        Whose knobs it turns.
    watch : Watch
        Faults of this device.
    """

    def __init__(
        self, panel: Panel, world: Any, which: Literal["emission", "detection"], watch: Watch
    ) -> None:
        self._panel, self._world, self._which, self._watch = panel, world, which, watch
        self._knobs: RfKnobs = getattr(panel, which)
        self._dead_man = 5.0
        self._fed = time.monotonic()
        self._tripped = False
        self._was_locked = False
        self._words: dict[str, Callable[[list[str]], str]] = {
            "ID?": self._identity,
            "FREQ": self._set_frequency,
            "FREQ?": lambda a: f"{self._knobs.frequency:.0f}",
            "PHAS": self._set_phase,
            "PHAS?": lambda a: str(_code(self._knobs.phase)),
            "POWR": self._set_power,
            "POWR?": lambda a: f"{self._knobs.power:g}",
            "RF": self._set_output,
            "RF?": lambda a: _switch(self._knobs.on),
            "LOCK?": self._lock,
            "TABL": self._set_table,
            "TABL?": self._table,
            "TRIG": self._set_trigger,
            "TRIG?": lambda a: _switch(self._knobs.trigger),
            "INDX?": lambda a: f"{self._knobs.index} {self._knobs.edges}",
            "ARM": self._arm,
            "DEAD": self._set_dead_man,
            "DEAD?": lambda a: f"{self._dead_man:g}",
            "PING": lambda a: "",
            "SAFE": self._safe,
            "CLR": self._clear,
            "STAT?": self._status,
        }

    def serve(self, channel: Channel) -> None:
        """Talk to one client until it has gone."""
        lines = LineBuffer(_LINE_LIMIT)
        while (data := channel.receive(self._patience())) != b"":
            self._watch_timer(channel)
            for line in lines.feed(data or b""):
                if line.strip():
                    self._answer(line, channel)

    def _patience(self) -> float | None:
        """Time until the dead man's timer runs out, s; None while RF is off."""
        if not self._knobs.on:
            return None
        return max(0.0, self._fed + self._dead_man - time.monotonic())

    def _watch_timer(self, channel: Channel) -> None:
        if self._knobs.on and time.monotonic() >= self._fed + self._dead_man:
            self._trip(channel, "DEADMAN")

    def _trip(self, channel: Channel, reason: str) -> None:
        with self._panel.lock:
            self._knobs.on = False
        self._tripped, self._was_locked = True, False
        channel.send(_line(f"!TRIP {reason}"))

    def _answer(self, line: bytes, channel: Channel) -> None:
        trouble = self._watch.next()
        reply = b"" if trouble.unheard else self._reply(line)
        self._watch_lock(channel)
        trouble.deliver(channel, reply)

    def _reply(self, line: bytes) -> bytes:
        body, star, check = line.rpartition(b"*")
        match = re.fullmatch(rb">(\d{1,2}) ([A-Z?]+)((?: [!-)+-~]+)*)", body)
        if not star or check != b"%04X" % crc16(body):
            return _line("<?? ERR CHECKSUM send it again")
        if not match:
            return _line("<?? ERR FORM expected >SEQ WORD arguments")
        sequence, word = int(match[1]), match[2].decode()
        self._fed = time.monotonic()
        try:
            if word not in self._words:
                raise _Refusal("WORD", "not known")
            arguments = match[3].decode().split()
            if word.endswith("?") and arguments:
                raise _Refusal("ARGS", "a query has none")
            with self._panel.lock:
                values = self._words[word](arguments)
        except _Refusal as refusal:
            return _line(f"<{sequence} ERR {' '.join(refusal.args)}")
        return _line(f"<{sequence} OK {values}".rstrip())

    def _watch_lock(self, channel: Channel) -> None:
        """Turn RF off when a lock that was there is gone."""
        if not self._knobs.on:
            return
        with self._panel.lock:
            locked = self._world.lock(self._panel, self._which).locked
        if self._watch.takes("lost-lock") or (self._was_locked and not locked):
            channel.send(_line("!LOCK 0"))
            self._trip(channel, "LOCK")
        else:
            self._was_locked = locked

    def _identity(self, arguments: list[str]) -> str:
        return f"CMTOF-RF,TWIN-{self._which.upper()},1.0"

    def _set_frequency(self, arguments: list[str]) -> str:
        value = _integer(arguments, *BAND)
        if self._obeys():
            self._knobs.frequency = float(round(self._watch.pulled(value, *BAND)))
            self._was_locked = False  # looks for the resonance anew
        return f"{self._knobs.frequency:.0f}"

    def _set_phase(self, arguments: list[str]) -> str:
        value = _integer(arguments, 0, CODES - 1)
        if self._obeys():
            self._knobs.phase = _phase(round(self._watch.pulled(value, 0, CODES - 1)))
        return str(_code(self._knobs.phase))

    def _set_power(self, arguments: list[str]) -> str:
        value = _number(arguments, *POWER)
        if self._obeys():
            self._knobs.power = round(self._watch.pulled(value, *POWER), 2)
            self._was_locked = False
        return f"{self._knobs.power:g}"

    def _set_output(self, arguments: list[str]) -> str:
        on = _on_or_off(arguments)
        if on and self._tripped:
            raise _Refusal("TRIPPED", "CLR first")
        if not on or self._obeys():  # whatever is wrong with the driver, off is off
            self._knobs.on = on
            self._was_locked = False
        return _switch(self._knobs.on)

    def _lock(self, arguments: list[str]) -> str:
        state = self._world.lock(self._panel, self._which)
        locked = state.locked and self._knobs.on
        reflected = max(_NO_POWER, state.reflected)
        return f"{int(locked)} {state.detuning:.0f} {reflected:.2f}"

    def _set_table(self, arguments: list[str]) -> str:
        count = _integer(arguments[:1], 1, TABLE_SIZE)
        if len(arguments) != count + 1:
            raise _Refusal("ARGS", f"expected {count} codes")
        codes = [_integer([one], 0, CODES - 1) for one in arguments[1:]]
        if self._obeys():
            self._knobs.table = np.array([_phase(code) for code in codes])
            self._knobs.index = 0
        return self._table([])

    def _table(self, arguments: list[str]) -> str:
        codes = [_code(phase) for phase in self._knobs.table]
        check = crc16(b"".join(code.to_bytes(2, "big") for code in codes))
        return f"{len(codes)} {check:04X}"

    def _set_trigger(self, arguments: list[str]) -> str:
        on = _on_or_off(arguments)
        if self._obeys():
            self._knobs.trigger = on
        return _switch(self._knobs.trigger)

    def _arm(self, arguments: list[str]) -> str:
        _none(arguments)
        if self._obeys():
            self._knobs.index, self._knobs.edges, self._knobs.armed = 0, 0, True
        return ""

    def _set_dead_man(self, arguments: list[str]) -> str:
        value = _number(arguments, *DEAD_MAN)
        if self._obeys():
            self._dead_man = self._watch.pulled(value, *DEAD_MAN)
        return f"{self._dead_man:g}"

    def _safe(self, arguments: list[str]) -> str:
        self._knobs.on = self._knobs.trigger = self._was_locked = False
        return ""

    def _clear(self, arguments: list[str]) -> str:
        _none(arguments)
        if self._obeys():
            self._tripped = False
        return ""

    def _status(self, arguments: list[str]) -> str:
        locked = self._lock([]).split()[0]
        knobs = self._knobs
        return f"{int(knobs.on)} {locked} {knobs.index} {knobs.edges} {int(self._tripped)}"

    def _obeys(self) -> bool:
        return not self._watch.takes("ignore")


def _line(body: str) -> bytes:
    return b"%s*%04X\n" % (body.encode(), crc16(body.encode()))


def _switch(on: bool) -> str:
    return "ON" if on else "OFF"


def _code(phase: float) -> int:
    return round(phase / (2 * np.pi) * CODES) % CODES


def _phase(code: int) -> float:
    return 2 * np.pi * code / CODES


def _none(arguments: list[str]) -> None:
    if arguments:
        raise _Refusal("ARGS", "expected none")


def _on_or_off(arguments: list[str]) -> bool:
    if arguments not in (["ON"], ["OFF"]):
        raise _Refusal("ARGS", "expected ON or OFF")
    return arguments == ["ON"]


def _integer(arguments: list[str], low: int, high: int) -> int:
    if len(arguments) != 1 or not re.fullmatch(r"\d{1,12}", arguments[0], re.ASCII):
        raise _Refusal("ARGS", "expected one whole number")
    if not low <= (value := int(arguments[0])) <= high:
        raise _Refusal("RANGE", f"expected {low} to {high}")
    return value


def _number(arguments: list[str], low: float, high: float) -> float:
    value = number_from_text(arguments[0]) if len(arguments) == 1 else None
    if value is None:
        raise _Refusal("ARGS", "expected one number")
    if not low <= value <= high:
        raise _Refusal("RANGE", f"expected {low} to {high}")
    return value
