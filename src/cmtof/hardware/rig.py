"""The rig: a RIG file, strict about every key and value, and the instruments that it names."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass as plain_dataclass
from dataclasses import fields, replace
from importlib.resources import files
from math import pi
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeVar

import numpy as np
import yaml
from pydantic import ConfigDict, Field, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from cmtof.hardware.beam import SAFE_LEVELS, Galvo, Interlock
from cmtof.hardware.plan import MODES
from cmtof.hardware.safety import EmergencyStop
from cmtof.instrument.settings import TwinSettings, number

T = TypeVar("T")
STRICT = ConfigDict(extra="forbid", strict=True)
Fio = Annotated[str, Field(pattern=r"^FIO[0-7]$")]
Tdac = Annotated[str, Field(pattern=r"^TDAC[0-7]$")]
Mode = Literal["single", "doubled"]
LARGEST_FILE = 65536
"""Bytes of a RIG file at most."""
DEEPEST = 8
"""Mappings and lists within one another at most."""

DRIVERS = {
    "rf_emission": ("rf-driver",),
    "rf_detection": ("rf-driver",),
    "clock": ("sdg2042x",),
    "daq": ("labjack-t7",),
    "plate_emission": ("k10cr1", "kdc101"),
    "plate_detection": ("k10cr1", "kdc101"),
    "stage": ("kdc101",),
    "power_meter": ("pm100d",),
}
"""Drivers that each role takes."""


@dataclass(frozen=True, config=STRICT)
class DeviceSettings:
    """Driver and address of a device; what a KDC101 moves; the serial number it must have."""

    driver: str
    address: str
    stream: str = ""
    stage: Literal["", "mts50-z8", "prm1-z8"] = ""
    serial_number: str = ""
    counts_per_unit: float = number(0.0, 0, 1e12)


@dataclass(frozen=True, config=STRICT)
class LineSettings:
    """Digital lines of the read-out."""

    laser: Fio = "FIO0"
    shutter: Fio = "FIO1"
    trigger: Fio = "FIO4"
    flip_mirror: Fio = "FIO5"
    beam_block: Fio = "FIO6"
    interlock: Fio = "FIO7"


@dataclass(frozen=True, config=STRICT)
class GalvoSettings:
    """Scan mirrors: channels of the LJTick-DAC, scale, limit (V) and settling (s)."""

    x: Tdac = "TDAC2"
    y: Tdac = "TDAC3"
    volts_per_degree_mechanical: float = number(0.5, 0.1, 2)
    offset_x_volts: float = number(0.0, -10, 10)
    offset_y_volts: float = number(0.0, -10, 10)
    limit_volts: float = number(10.0, 0, 10)
    settling: float = number(4.0e-4, 0, 1)

    @property
    def volts_per_radian(self) -> float:
        """Volts per radian of optical angle, which is twice the mechanical one."""
        return self.volts_per_degree_mechanical * 180 / pi / 2


@dataclass(frozen=True, config=STRICT)
class DriveSettings:
    """RF drive: power (dBm), drive frequencies of the modes (Hz), dead man's time (s)."""

    power_dbm: float = number(30.0, -50, 50)
    frequency_single: float = number(7.15e9, 7.14e9, 7.17e9)
    frequency_doubled: float = number(7.16e9, 7.14e9, 7.17e9)
    dead_man: float = number(5.0, 0.1, 60)

    def frequency(self, mode: str) -> float:
        """Drive frequency of a mode, Hz."""
        return self.frequency_doubled if mode == "doubled" else self.frequency_single


@dataclass(frozen=True, config=STRICT)
class PlateSettings:
    """Half-wave plates, degrees: theta_h of the modes and the mount angles where theta_h is 0."""

    single_deg: float = number(11.25, -360, 360)
    doubled_deg: float = number(22.5, -360, 360)
    zero_emission_deg: float = number(0.0, -360, 360)
    zero_detection_deg: float = number(0.0, -360, 360)

    def mount_angles(self, mode: str) -> tuple[float, float]:
        """Mount angles of emission and detection in a mode, rad."""
        angle = self.doubled_deg if mode == "doubled" else self.single_deg
        zeros = np.array([self.zero_emission_deg, self.zero_detection_deg])
        emission, detection = np.deg2rad(angle + zeros)
        return float(emission), float(detection)


@dataclass(frozen=True, config=STRICT)
class DetectionSettings:
    """Read-out of a burst: channel, range (V), rate (Hz), what a point is made of.

    ``limit_volts`` is the greatest output at which the detector is still linear.
    """

    channel: Annotated[str, Field(pattern=r"^AIN([0-9]|1[0-3])$")] = "AIN0"
    range: Literal[10.0, 1.0, 0.1, 0.01] = 10.0
    rate: float = number(24000.0, 1, 50e3)
    samples_per_phase: int = number(20, 2, 250)
    settle_samples: int = number(4, 0, 249)
    phases: int = number(16, 3, 64)
    limit_volts: float = number(4.0, 0.001, 10)

    def __post_init__(self) -> None:
        if self.settle_samples >= self.samples_per_phase:
            raise ValueError(
                f"Expected detection.settle_samples below samples_per_phase, got "
                f"{self.settle_samples}. Lower it."
            )

    @property
    def scans(self) -> int:
        """Samples of a burst."""
        return self.samples_per_phase * self.phases

    @property
    def duration(self) -> float:
        """Duration of a burst, s."""
        return self.scans / self.rate


@dataclass(frozen=True, config=STRICT)
class ReferenceSettings:
    """Target behind the flip mirror: distance along the ray (m) with the stage at its zero (m)."""

    distance: float = number(0.60, 0.001, 100)
    stage_zero: float = number(0.025, -1, 1)


@dataclass(frozen=True, config=STRICT)
class ScanSettings:
    """What a scan covers: full optical angles across and down, and the modes in their order."""

    field_of_view_deg: tuple[float, float] = (20.0, 20.0)
    modes: Annotated[tuple[Mode, ...], Field(min_length=1)] = MODES

    def __post_init__(self) -> None:
        if not all(0 < angle < 80 for angle in self.field_of_view_deg):
            raise ValueError(
                f"Expected scan.field_of_view_deg from 0 to 80, got {self.field_of_view_deg}. "
                "Change it."
            )
        if len(set(self.modes)) < len(self.modes):
            raise ValueError(f"Expected scan.modes each once, got {self.modes}. Drop one.")

    @property
    def field_of_view(self) -> tuple[float, float]:
        """Full optical angles across and down, rad."""
        across, down = np.deg2rad(self.field_of_view_deg)
        return float(across), float(down)


@dataclass(frozen=True, config=STRICT)
class Rig:
    """Settings of a rig: a whole RIG file."""

    devices: dict[str, DeviceSettings] = Field(default_factory=dict)
    name: str = "rig"
    lines: LineSettings = LineSettings()
    galvo: GalvoSettings = GalvoSettings()
    drive: DriveSettings = DriveSettings()
    plates: PlateSettings = PlateSettings()
    detection: DetectionSettings = DetectionSettings()
    reference: ReferenceSettings = ReferenceSettings()
    scan: ScanSettings = ScanSettings()
    twin: TwinSettings = TwinSettings()

    def __post_init__(self) -> None:
        for role, device in self.devices.items():
            if device.driver not in DRIVERS.get(role, ()):
                raise ValueError(
                    f"Expected devices out of {', '.join(DRIVERS)} with their drivers, got "
                    f"{role}: {device.driver}. Correct it."
                )
            if device.driver == "kdc101" and not device.stage:
                raise ValueError(f"Expected devices.{role}.stage mts50-z8 or prm1-z8, got none.")
        # an LJTick-DAC sits on an even line and the one above it, whichever output is used
        used = [getattr(self.lines, one.name) for one in fields(self.lines)]
        first = {int(name[-1]) // 2 * 2 for name in (self.galvo.x, self.galvo.y)}
        used += [f"FIO{line + step}" for line in first for step in (0, 1)]
        if len(set(used)) < len(used) or self.galvo.x == self.galvo.y:
            raise ValueError(
                f"Expected each line of the read-out used once, the mirrors' included, got {used}. "
                "Correct `lines` and `galvo`."
            )

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a RIG file.

        Raises
        ------
        FileNotFoundError
            If there is none.
        ValueError
            If it is no YAML, or holds what a RIG file cannot hold.
        """
        path = Path(path)
        if not path.is_file():
            raise FileNotFoundError(f"Expected a RIG file, got no file {path}. Name another.")
        if path.stat().st_size > LARGEST_FILE:
            raise ValueError(f"Expected a RIG file to {LARGEST_FILE} bytes, got more in {path}.")
        return cls._from_text(path.read_bytes(), path.name)

    @classmethod
    def default(cls) -> Self:
        """Return the rig that comes with the package.

        Examples
        --------
        >>> rig = Rig.default()
        >>> rig.detection.scans, rig.devices["daq"].driver
        (320, 'labjack-t7')
        """
        return cls._from_text(files("cmtof.hardware").joinpath("rig.yml").read_bytes(), "rig.yml")

    @classmethod
    def _from_text(cls, text: bytes, source: str) -> Self:
        try:
            held = yaml.load(text.decode("utf-8"), _StrictLoader)
        except (yaml.YAMLError, RecursionError, UnicodeDecodeError, ValueError) as error:
            reason = " ".join(str(error).split())[:200]
            raise ValueError(f"Expected YAML in {source}, got {reason}. Correct it.") from None
        return checked(cls, held if held is not None else {}, source)

    def as_dict(self) -> dict[str, Any]:
        """Plain values, without addresses, which say nothing of the measurement."""
        held = TypeAdapter(type(self)).dump_python(self, mode="json", fallback=repr)
        for device in held["devices"].values():
            del device["address"], device["stream"]
        return held


def checked(kind: type[T], values: Any, path: str) -> T:
    """Object of a checked dataclass from plain values, or a ValueError of one line.

    Examples
    --------
    >>> checked(Rig, {"drive": {"dead": 1}}, "rig.yml")
    Traceback (most recent call last):
        ...
    ValueError: Expected rig.yml: drive.dead to be a known key, got 1. Correct it.
    """
    try:
        # as JSON a mapping may stand for a section, and a list for a tuple, and nothing else
        return TypeAdapter(kind).validate_json(json.dumps(values, default=str))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        rule = first["msg"].removeprefix("Value error, ").removeprefix("Input should ")
        if first["type"] == "value_error":
            raise ValueError(f"{rule} ({path})") from None
        place, found = ".".join(str(part) for part in first["loc"]), repr(first["input"])
        words = {"unexpected_keyword_argument": "to be a known key", "missing": "to be there"}
        raise ValueError(
            f"Expected {path}: {place} {words.get(first['type'], f'to {rule}')}, got "
            f"{found if len(found) <= 60 else found[:57] + '...'}. Correct it."
        ) from None


class _StrictLoader(yaml.SafeLoader):
    """Plain values only: no alias, no key twice, no depth, and 7.15e9 a number as in YAML 1.2."""

    depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Next node; an error for an alias, or one that lies too deep."""
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("an alias, which a RIG file does not need")
        self.depth += 1
        if self.depth > DEEPEST:
            raise yaml.YAMLError(f"more than {DEEPEST} levels")
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Values of a mapping; an error where a key would silently replace another."""
        keys = [key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode)]
        if len(set(keys)) < len(node.value):
            line = node.start_mark.line + 1
            raise yaml.YAMLError(f"a key twice, or one that is no text, in line {line} ff.")
        return super().construct_mapping(node, deep)


_StrictLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)[eE][-+]?[0-9]+"),
    list("-+.0123456789"),
)


@plain_dataclass
class Instruments:
    """Connected instruments of a rig, real or simulated; None where the file has none.

    As a context manager it is an `EmergencyStop` over all of them, and closes them at the end.
    """

    galvo: Any
    interlock: Any
    rf_emission: Any = None
    rf_detection: Any = None
    clock: Any = None
    daq: Any = None
    plate_emission: Any = None
    plate_detection: Any = None
    stage: Any = None
    power_meter: Any = None

    def __post_init__(self) -> None:
        self._stop = EmergencyStop(self.in_order_of_stopping())

    def in_order_of_stopping(self) -> list[Any]:
        """Every instrument: first the light, then RF, then what moves."""
        names = "interlock galvo rf_emission rf_detection plate_emission plate_detection stage"
        order = [getattr(self, name) for name in (names + " daq clock power_meter").split()]
        return [device for device in order if device is not None]

    def close(self) -> None:
        """Close every connection."""
        for device in self.in_order_of_stopping():
            if hasattr(device, "close"):
                device.close()

    def __enter__(self) -> Self:
        self._stop.__enter__()
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        try:
            self._stop.__exit__(kind, error, trace)
        finally:
            self.close()


def open_instruments(settings: Rig) -> Instruments:
    """Connect to every device of a rig; use the result as a context manager.

    Raises
    ------
    ValueError
        If the rig lacks an instrument that a scan needs.
    InstrumentError
        If one cannot be reached; those that could are closed again.
    """
    missing = [role for role in DRIVERS if role not in {*settings.devices, "stage", "power_meter"}]
    if missing:
        raise ValueError(
            f"Expected a rig with {', '.join(DRIVERS)}, got none of {', '.join(missing)}. "
            "Add them to `devices`."
        )
    devices: dict[str, Any] = {}
    try:
        for role, device in settings.devices.items():
            devices[role] = _opened(role.replace("_", " "), device, settings.lines)
    except BaseException:
        for device in devices.values():
            device.close()
        raise
    return wired(settings, devices)


def wired(settings: Rig, devices: Mapping[str, Any]) -> Instruments:
    """Instruments of devices by role, with what hangs on the read-out's lines."""
    daq = devices["daq"]
    return Instruments(Galvo(daq, settings.galvo), Interlock(daq, settings.lines), **devices)


def simulated(settings: Rig, scene: Any = None, *, seed: int = 0) -> Instruments:
    """Simulated instruments of a rig, in process, before a scene; ``daq.world`` is their light."""
    from cmtof.instrument.devices import simulated_devices
    from cmtof.instrument.world import World

    lines = {getattr(settings.lines, one.name): one.name for one in fields(settings.lines)}
    world = World(settings.twin, scene, seed=seed)
    devices = simulated_devices(world, lines, (settings.galvo.x, settings.galvo.y))
    patient = replace(settings, galvo=replace(settings.galvo, settling=0.0))
    return wired(patient, {role: devices[role] for role in settings.devices})


def _opened(name: str, settings: DeviceSettings, lines: LineSettings) -> Any:
    """Driver of a device, connected."""
    from cmtof.hardware import apt, rf, scpi, t7

    address, driver = settings.address, settings.driver
    if driver == "labjack-t7":
        safe = {getattr(lines, role): level for role, level in SAFE_LEVELS.items()}
        client, host = t7.open_modbus(address), address.partition(":")[0]
        stream = rf.open_serial(f"socket://{settings.stream or host + ':702'}")
        return t7.LabJackT7(client, stream, name, safe)
    if driver in ("kdc101", "k10cr1"):
        kind = apt.MOTORS[settings.stage or driver]
        if scale := settings.counts_per_unit:
            kind = kind._replace(scale=scale)
        port = rf.open_serial(address, rtscts="://" not in address)
        return apt.Motor(port, kind, name, settings.serial_number)
    if driver == "rf-driver":
        return rf.RfDriver(rf.open_serial(address), name)
    kind = {"sdg2042x": scpi.SignalGenerator, "pm100d": scpi.PowerMeter}[driver]
    return kind(scpi.open_visa(address), name)
