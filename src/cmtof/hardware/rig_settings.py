"""What a RIG file may say: one frozen dataclass a section, strict about every key and value."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from math import pi
from types import MappingProxyType
from typing import Any

import numpy as np

from cmtof.instrument.parsing import check_keys, mapping, number, section_from_mapping

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

MODES = ("single", "doubled")
"""Modulation modes."""

BAND = (7.14e9, 7.17e9)
"""Frequencies that the RF drivers take, Hz."""


@dataclass(frozen=True)
class DeviceSettings:
    """Where a device is and how to speak to it.

    Attributes
    ----------
    driver : str
        Out of `DRIVERS`.
    address : str
        As `cmtof.hardware.transport.open_transport` takes it.
    stream : str
        Address of the read-out's second connection (driver labjack-t7).
    stage : str
        What a KDC101 moves: mts50-z8 or prm1-z8.
    serial_number : str
        Refuse another device than this one; empty takes any.
    counts_per_unit : float
        Own scale, counts per m or rad, in place of the table's; 0 takes the table's.
    """

    driver: str
    address: str
    stream: str = ""
    stage: str = ""
    serial_number: str = ""
    counts_per_unit: float = number(0.0, 0, 1e12)


@dataclass(frozen=True)
class LineSettings:
    """Digital lines of the read-out."""

    laser: str = "FIO0"
    shutter: str = "FIO1"
    trigger: str = "FIO4"
    flip_mirror: str = "FIO5"
    beam_block: str = "FIO6"
    interlock: str = "FIO7"


@dataclass(frozen=True)
class GalvoSettings:
    """Scan mirrors: channels of the LJTick-DAC, scale, limit (V) and settling (s)."""

    x: str = "TDAC2"
    y: str = "TDAC3"
    volts_per_degree_mechanical: float = number(0.5, 0.1, 2)
    offset_x_volts: float = 0.0
    offset_y_volts: float = 0.0
    limit_volts: float = number(10.0, 0, 10)
    settling: float = number(4.0e-4, 0, 1)

    @property
    def volts_per_radian(self) -> float:
        """Volts per radian of optical angle, which is twice the mechanical one."""
        return self.volts_per_degree_mechanical * 180 / pi / 2


@dataclass(frozen=True)
class DriveSettings:
    """RF drive: power (dBm), drive frequencies of the modes (Hz), dead man's time (s)."""

    power_dbm: float = 30.0
    frequency_single: float = number(7.15e9, *BAND)
    frequency_doubled: float = number(7.16e9, *BAND)
    dead_man: float = number(5.0, 0.1, 60)

    def frequency(self, mode: str) -> float:
        """Drive frequency of a mode, Hz."""
        return self.frequency_doubled if mode == "doubled" else self.frequency_single


@dataclass(frozen=True)
class PlateSettings:
    """Half-wave plates, degrees: theta_h of the modes and the mount angles where theta_h is 0."""

    single_deg: float = 11.25
    doubled_deg: float = 22.5
    zero_emission_deg: float = 0.0
    zero_detection_deg: float = 0.0

    def mount_angles(self, mode: str) -> tuple[float, float]:
        """Mount angles of emission and detection in a mode, rad."""
        angle = self.doubled_deg if mode == "doubled" else self.single_deg
        emission, detection = np.deg2rad(
            [angle + self.zero_emission_deg, angle + self.zero_detection_deg]
        )
        return float(emission), float(detection)


@dataclass(frozen=True)
class DetectionSettings:
    """Read-out of a burst: channel, range (V), rate (Hz), and what a point is made of."""

    channel: str = "AIN0"
    range: float = 10.0
    rate: float = number(24000.0, 1, 50e3)
    samples_per_phase: int = number(20, 2, 1000)
    settle_samples: int = 4
    phases: int = number(16, 3, 64)

    @property
    def scans(self) -> int:
        """Samples of a burst."""
        return self.samples_per_phase * self.phases

    @property
    def duration(self) -> float:
        """Duration of a burst, s."""
        return self.scans / self.rate

    @property
    def channel_number(self) -> int:
        """Number of the analog input."""
        return int(self.channel.removeprefix("AIN"))


@dataclass(frozen=True)
class ReferenceSettings:
    """Target behind the flip mirror: distance along the ray (m) with the stage at its zero (m)."""

    distance: float = 0.60
    stage_zero: float = 0.025


@dataclass(frozen=True)
class ScanSettings:
    """What a scan covers: full optical angles across and down, and the modes in their order."""

    field_of_view_deg: tuple[float, float] = (20.0, 20.0)
    modes: tuple[str, ...] = MODES

    @property
    def field_of_view(self) -> tuple[float, float]:
        """Full optical angles across and down, rad."""
        across, down = np.deg2rad(self.field_of_view_deg)
        return float(across), float(down)


@dataclass(frozen=True)
class RigSettings:
    """A whole RIG file; ``twin`` stays as it stands there, for the simulation alone."""

    devices: Mapping[str, DeviceSettings]
    name: str = "rig"
    lines: LineSettings = field(default_factory=LineSettings)
    galvo: GalvoSettings = field(default_factory=GalvoSettings)
    drive: DriveSettings = field(default_factory=DriveSettings)
    plates: PlateSettings = field(default_factory=PlateSettings)
    detection: DetectionSettings = field(default_factory=DetectionSettings)
    reference: ReferenceSettings = field(default_factory=ReferenceSettings)
    scan: ScanSettings = field(default_factory=ScanSettings)
    twin: Mapping[str, Any] = field(default_factory=dict)


SECTIONS: Mapping[str, type] = MappingProxyType(
    {
        "lines": LineSettings,
        "galvo": GalvoSettings,
        "drive": DriveSettings,
        "plates": PlateSettings,
        "detection": DetectionSettings,
        "reference": ReferenceSettings,
        "scan": ScanSettings,
    }
)
"""Sections of plain values."""


def settings_from_dict(held: Any, *, source: str = "the RIG file") -> RigSettings:
    """Settings of what YAML read.

    Raises
    ------
    ValueError
        For a key that is not known, a value of another kind or out of bounds: one line that names
        section and key.
    """
    top = mapping(held, source)
    check_keys(top, ["name", "devices", *SECTIONS, "twin"], source)
    listed = mapping(top.get("devices", {}), "devices")
    check_keys(listed, list(DRIVERS), "devices")
    devices = {
        role: section_from_mapping(DeviceSettings, entry, f"devices.{role}")
        for role, entry in listed.items()
    }
    sections = {
        name: section_from_mapping(kind, top[name], name)
        for name, kind in SECTIONS.items()
        if name in top
    }
    settings = RigSettings(
        devices=devices,
        name=str(top.get("name", "rig")),
        twin=mapping(top.get("twin") or {}, "twin"),
        **sections,
    )
    for problem in _problems(settings):
        raise ValueError(f"{problem} Correct {source}.")
    return settings


def _problems(settings: RigSettings) -> Iterator[str]:
    """Every value that no rig can have."""
    yield from _device_problems(settings)
    yield from _line_problems(settings)
    detection = settings.detection
    if detection.range not in (10.0, 1.0, 0.1, 0.01):
        yield f"Expected detection.range of 10, 1, 0.1 or 0.01 V, got {detection.range:g}."
    if not 0 <= detection.settle_samples < detection.samples_per_phase:
        yield (
            f"Expected detection.settle_samples below samples_per_phase, got "
            f"{detection.settle_samples}."
        )
    view = settings.scan.field_of_view_deg
    if len(view) != 2 or not all(0 < angle < 80 for angle in view):
        yield f"Expected scan.field_of_view_deg of two angles from 0 to 80, got {list(view)}."
    modes = settings.scan.modes
    if not modes or not set(modes) <= set(MODES) or len(set(modes)) < len(modes):
        yield f"Expected scan.modes out of {', '.join(MODES)}, each once, got {list(modes)}."


def _device_problems(settings: RigSettings) -> Iterator[str]:
    for role, device in settings.devices.items():
        if device.driver not in DRIVERS[role]:
            known = " or ".join(DRIVERS[role])
            yield f"Expected devices.{role}.driver {known}, got {device.driver}."
        if device.driver == "labjack-t7" and not device.stream:
            yield f"Expected devices.{role}.stream, the address of port 702, got none."
        if device.driver == "kdc101" and device.stage not in ("mts50-z8", "prm1-z8"):
            yield f"Expected devices.{role}.stage mts50-z8 or prm1-z8, got {device.stage!r}."


def _line_problems(settings: RigSettings) -> Iterator[str]:
    galvo, channel = settings.galvo, settings.detection.channel
    used = {f"lines.{one.name}": getattr(settings.lines, one.name) for one in fields(LineSettings)}
    known = [f"FIO{n}" for n in range(8)]
    for what, line in used.items():
        if line not in known:
            yield f"Expected {what} of FIO0 to FIO7, got {line!r}."
    for what, tdac in (("galvo.x", galvo.x), ("galvo.y", galvo.y)):
        if tdac not in [f"TDAC{n}" for n in range(8)]:
            yield f"Expected {what} of TDAC0 to TDAC7, got {tdac!r}."
        # an LJTick-DAC sits on an even line and the one above it, whichever output is used
        pair = int(tdac[-1]) // 2 * 2 if tdac[-1:].isdigit() else -2
        used[f"{what} (clock)"], used[f"{what} (data)"] = f"FIO{pair}", f"FIO{pair + 1}"
    if channel not in [f"AIN{n}" for n in range(14)]:
        yield f"Expected detection.channel of AIN0 to AIN13, got {channel!r}."
    yield from _shared_lines(used)


def _shared_lines(used: Mapping[str, str]) -> Iterator[str]:
    seen: dict[str, str] = {}
    for what, line in used.items():
        other = seen.setdefault(line, what)
        if other != what and not (what.startswith("galvo") and other.startswith("galvo")):
            yield f"Expected {what} on a line of its own, got {line}, which {other} uses."
