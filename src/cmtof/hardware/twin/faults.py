"""Faults on demand: what goes wrong, at which device, at which of its requests.

In a RIG file::

    twin:
      faults:
        - {device: clock, kind: silence}                       # the first request, once
        - {device: daq, kind: lost-packets, after: 100, times: 2}
        - {device: stage, kind: late, delay: 0.3, times: 0}    # every request from now on

From Python: ``twin.faults.add("stage", "stall")``; ``after`` then counts from that moment. A
request is a Modbus frame, an APT message, or a line of text.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from threading import Lock
from typing import Any

from cmtof.hardware.twin.lines import Channel

ROLES = (
    "rf_emission",
    "rf_detection",
    "clock",
    "daq",
    "plate_emission",
    "plate_detection",
    "stage",
    "power_meter",
)
"""Devices by their role in the RIG file."""
_RF = ("rf_emission", "rf_detection")
_MOTORS = ("plate_emission", "plate_detection", "stage")

KINDS: dict[str, tuple[str, tuple[str, ...]]] = {
    "silence": ("the request is lost: not done, not answered", ROLES),
    "late": ("done, but answered `delay` seconds later", ROLES),
    "cut": ("done, but only the first half of the answer comes", ROLES),
    "garble": ("done, but the answer's second byte has its top bit flipped", ROLES),
    "drop-connection": ("not done; the connection is closed", ROLES),
    "clamp": ("a number that is set lands a tenth of its range lower, a voltage nearer 0", ROLES),
    "ignore": ("a setting is taken without complaint, and nothing changes", ROLES),
    "lost-lock": ("the driver loses the resonance, and RF goes off", _RF),
    "stall": ("a move stops half-way and is never reported as completed", _MOTORS),
    "saturate": ("every sample of a burst is at the end of the converter", ("daq",)),
    "lost-packets": ("a stream packet is not sent, its number is skipped", ("daq",)),
    "overlap": ("a stream packet reports that a scan began before the last was done", ("daq",)),
    "interlock-open": ("the interlock line is low and the laser is off", ("daq",)),
}
"""What each kind does, and which devices it can happen to."""

OF_REQUESTS = ("silence", "late", "cut", "garble", "drop-connection", "interlock-open")
"""Kinds that happen to any request; the others wait for the next setting, move or burst."""


@dataclass(frozen=True)
class Fault:
    """One fault on demand.

    Attributes
    ----------
    device : str
        Role in the RIG file.
    kind : str
        One of `KINDS`.
    after : int
        Requests of the device that pass before it may happen.
    times : int
        How often it happens: to requests in a row, or, for a kind that is not in `OF_REQUESTS`, to
        settings, moves or bursts; 0 for all that follow.
    delay : float
        Lateness of the kind ``late``, s.

    Raises
    ------
    ValueError
        If a value is not allowed, or the kind cannot happen to the device.
    """

    device: str
    kind: str
    after: int = 0
    times: int = 1
    delay: float = 0.1

    def __post_init__(self) -> None:
        _choose("device", self.device, ROLES)
        _choose("kind", self.kind, tuple(KINDS))
        _choose(f"device for the fault {self.kind}", self.device, KINDS[self.kind][1])
        for name, value in (("after", self.after), ("times", self.times)):
            if type(value) is not int or value < 0:
                raise ValueError(
                    f"Expected a count for `{name}` of a fault, got {value!r}. Give 0 or more."
                )
        if isinstance(self.delay, bool) or not isinstance(self.delay, int | float):
            raise ValueError(f"Expected a fault's `delay` in s, got {self.delay!r}. Give a number.")
        if not 0 <= self.delay <= 60:
            raise ValueError(
                f"Expected a fault's `delay` of 0 to 60 s, got {self.delay}. Wait less."
            )


def _choose(what: str, value: object, options: tuple[str, ...]) -> None:
    if value not in options:
        raise ValueError(f"Expected {what} in {', '.join(options)}, got {value!r}. Choose one.")


def faults_from_settings(settings: object) -> tuple[Fault, ...]:
    """Faults of the list under ``twin: faults:`` of a RIG file.

    Raises
    ------
    ValueError
        If it is not a list of mappings with the fields of `Fault`.

    Examples
    --------
    >>> faults_from_settings([{"device": "clock", "kind": "ignore", "after": 3}])
    (Fault(device='clock', kind='ignore', after=3, times=1, delay=0.1),)
    """
    if settings is None:
        return ()
    if not isinstance(settings, list | tuple):
        raise ValueError(f"Expected a list of faults, got {settings!r}. Begin each with a dash.")
    return tuple(_fault_from_settings(one) for one in settings)


def _fault_from_settings(settings: Any) -> Fault:
    if isinstance(settings, Fault):
        return settings
    names = tuple(field.name for field in fields(Fault))
    if not isinstance(settings, Mapping):
        raise ValueError(f"Expected a fault as a mapping, got {settings!r}. Give device and kind.")
    for name in settings:
        _choose("a fault's key", name, names)
    for name in ("device", "kind"):
        if name not in settings:
            raise ValueError(f"Expected `{name}` in a fault, got {dict(settings)!r}. Add it.")
    return Fault(**settings)


class Trouble:
    """What goes wrong with one request: kinds, and the delay of each, s.

    Examples
    --------
    >>> trouble = Trouble({"cut": 0.0})
    >>> "cut" in trouble, trouble.spoil(b"<7 OK*1234")
    (True, b'<7 OK')
    """

    def __init__(self, kinds: Mapping[str, float] | None = None) -> None:
        self._kinds = dict(kinds or {})

    def __contains__(self, kind: str) -> bool:
        return kind in self._kinds

    @property
    def unheard(self) -> bool:
        """Whether the request must not be carried out."""
        return "silence" in self or "drop-connection" in self

    def spoil(self, reply: bytes) -> bytes:
        """Reply as it leaves the device."""
        if "cut" in self:
            reply = reply[: len(reply) // 2]
        if "garble" in self and reply:
            place = 1 if len(reply) > 2 else 0
            reply = reply[:place] + bytes([reply[place] ^ 0x80]) + reply[place + 1 :]
        return reply

    def deliver(self, channel: Channel, reply: bytes) -> None:
        """Send the reply as the fault has it: late, spoilt, not at all, or hang up."""
        if not self._kinds:
            channel.send(reply)
        elif "drop-connection" in self:
            channel.drop()
        elif "silence" not in self:
            if reply and "late" in self:
                channel.pause(self._kinds["late"])
            channel.send(self.spoil(reply))


FINE = Trouble()
"""Nothing goes wrong."""


class Watch:
    """Counts the requests of one device and says what goes wrong, and when.

    Examples
    --------
    >>> watch = Watch("stage")
    >>> watch.add(Fault("stage", "stall", after=1))
    >>> _ = watch.next()
    >>> watch.takes("stall")  # not yet
    False
    >>> _ = watch.next()
    >>> watch.takes("stall"), watch.takes("stall")  # once
    (True, False)
    """

    def __init__(self, device: str) -> None:
        self.device = device
        self.requests = 0
        self._lock = Lock()
        self._pending: list[_Pending] = []

    def add(self, fault: Fault) -> None:
        """Let a fault happen, counted from now."""
        with self._lock:
            self._pending.append(
                _Pending(self.requests + fault.after, fault.times or math.inf, fault)
            )

    def clear(self) -> None:
        """Nothing goes wrong any more."""
        with self._lock:
            self._pending.clear()

    def next(self) -> Trouble:
        """Count one request; what goes wrong with it."""
        with self._lock:
            self.requests += 1
            if not self._pending:
                return FINE
            return Trouble(
                {
                    one.fault.kind: one.fault.delay
                    for one in self._due()
                    if one.fault.kind in OF_REQUESTS and one.use()
                }
            )

    def takes(self, kind: str) -> bool:
        """Whether a fault happens on this occasion: a setting, a move, a burst."""
        if not self._pending:
            return False
        with self._lock:
            return sum(one.use() for one in self._due() if one.fault.kind == kind) > 0

    def pulled(self, value: float, low: float, high: float) -> float:
        """Number that is really set: a tenth of the range lower under ``clamp``, but not below."""
        return max(low, value - 0.1 * (high - low)) if self.takes("clamp") else value

    def _due(self) -> "list[_Pending]":
        self._pending = [one for one in self._pending if one.left > 0]
        return [one for one in self._pending if one.first < self.requests]


@dataclass
class _Pending:
    """A fault with the first request it may happen at, and how often it still will."""

    first: int
    left: float
    fault: Fault

    def use(self) -> bool:
        self.left -= 1
        return True


class Faults:
    """Faults of all devices of a twin; may be added while it runs."""

    def __init__(self, faults: Iterable[Fault] = ()) -> None:
        self._watches = {role: Watch(role) for role in ROLES}
        for fault in faults:
            self._watches[fault.device].add(fault)

    def watch(self, device: str) -> Watch:
        """Counter of the requests of one device.

        Raises
        ------
        ValueError
            If there is no such role.
        """
        _choose("device", device, ROLES)
        return self._watches[device]

    def add(
        self, device: str, kind: str, *, after: int = 0, times: int = 1, delay: float = 0.1
    ) -> None:
        """Let a fault happen, counted from now; see `Fault`.

        Raises
        ------
        ValueError
            See `Fault`.
        """
        fault = Fault(device, kind, after, times, delay)
        self._watches[fault.device].add(fault)

    def clear(self) -> None:
        """Nothing goes wrong any more."""
        for watch in self._watches.values():
            watch.clear()
