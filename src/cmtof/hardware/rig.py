"""Settings of a rig, as a RIG file has them: devices, lines, drives, read-out and mirrors."""

from dataclasses import asdict
from math import pi
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import ConfigDict, Field, TypeAdapter
from pydantic.dataclasses import dataclass

from cmtof.files import read_document
from cmtof.instrument.settings import TwinSettings
from cmtof.validation import checked

CHECKED = ConfigDict(extra="forbid")
Fio = Annotated[str, Field(pattern=r"^FIO[0-7]$")]
Tdac = Annotated[str, Field(pattern=r"^TDAC[0-7]$")]
Angle = Annotated[float, Field(gt=0, lt=80)]

DRIVERS = {
    "rf_emission": ("rf-driver",),
    "rf_detection": ("rf-driver",),
    "plate_emission": ("k10cr1", "prm1-z8"),
    "plate_detection": ("k10cr1", "prm1-z8"),
    "stage": ("mts50-z8",),
    "daq": ("labjack-t7",),
    "clock": ("sdg2042x",),
    "power_meter": ("pm100d",),
}
"""Drivers that each role takes, in the order in which the devices are stopped."""
PLATE_DEGREES = {"single": 11.25, "doubled": 22.5}
"""theta_h of both half-wave plates in the modes (Sec. 6.2)."""


@dataclass(frozen=True, config=CHECKED)
class DeviceSettings:
    """Driver and address of a device, the serial number it must have, its own scale."""

    driver: str
    address: str = Field(default="", exclude=True)  # it says nothing of the measurement
    serial_number: str = ""
    counts_per_unit: float | None = Field(default=None, gt=0, le=1e12)


@dataclass(frozen=True, config=CHECKED)
class LineSettings:
    """Digital lines of the read-out."""

    laser: Fio = "FIO0"
    shutter: Fio = "FIO1"
    trigger: Fio = "FIO4"
    flip_mirror: Fio = "FIO5"
    beam_block: Fio = "FIO6"
    interlock: Fio = "FIO7"


@dataclass(frozen=True, config=CHECKED)
class GalvoSettings:
    """Scan mirrors GVS012: channels of the LJTick-DAC, scale, limit, settling (s), field of view.

    The driver boards take 0.5 V a degree of *mechanical* angle (User Guide); the beam turns by
    twice that. The field of view is optical, across and down.
    """

    x: Tdac = "TDAC2"
    y: Tdac = "TDAC3"
    volts_per_degree_mechanical: float = Field(default=0.5, ge=0.1, le=2)
    limit_volts: float = Field(default=10.0, ge=0, le=10)
    settling: float = Field(default=4.0e-4, ge=0, le=1)
    field_of_view_deg: tuple[Angle, Angle] = (20.0, 20.0)

    @property
    def volts_per_radian(self) -> float:
        """Volts per radian of optical angle."""
        return self.volts_per_degree_mechanical * 180 / pi / 2

    def volts(self, angles: ArrayLike) -> NDArray[np.float64]:
        """Volts of optical angles, rad, same shape; a ValueError beyond the limit."""
        volts = np.round(self.volts_per_radian * np.asarray(angles, float), 6)
        if not np.abs(volts).max() <= self.limit_volts:  # a comparison that NaN fails
            raise ValueError(
                f"Expected the mirrors within {self.limit_volts:g} V, got "
                f"{np.abs(volts).max():.4g} V. Reduce the field of view."
            )
        return volts


@dataclass(frozen=True, config=CHECKED)
class DriveSettings:
    """RF drive: power (dBm), frequencies of the modes (Hz), dead man's time (s)."""

    power_dbm: float = Field(default=30.0, ge=-50, le=50)
    frequency_single: float = Field(default=7.15e9, ge=7.14e9, le=7.17e9)
    frequency_doubled: float = Field(default=7.16e9, ge=7.14e9, le=7.17e9)
    dead_man: float = Field(default=5.0, ge=0.1, le=60)

    def frequency(self, mode: str) -> float:
        """Drive frequency of a mode, Hz."""
        return self.frequency_doubled if mode == "doubled" else self.frequency_single


@dataclass(frozen=True, config=CHECKED)
class PlateSettings:
    """Mount angles of the half-wave plates where theta_h is 0, degrees."""

    zero_emission_deg: float = Field(default=0.0, ge=-360, le=360)
    zero_detection_deg: float = Field(default=0.0, ge=-360, le=360)


@dataclass(frozen=True, config=CHECKED)
class DetectionSettings:
    """Read-out of a burst: channel, range (V), rate (Hz), what a point is made of.

    ``limit_volts`` is the greatest output at which the detector is still linear.
    """

    channel: Annotated[str, Field(pattern=r"^AIN([0-9]|1[0-3])$")] = "AIN0"
    range: Literal[10.0, 1.0, 0.1, 0.01] = 10.0
    rate: float = Field(default=24000.0, ge=1, le=50e3)
    samples_per_phase: int = Field(default=20, ge=2, le=250)
    settle_samples: int = Field(default=4, ge=0, le=249)
    phases: int = Field(default=16, ge=3, le=64)
    limit_volts: float = Field(default=4.0, ge=0.001, le=10)

    @property
    def scans(self) -> int:
        """Samples of a burst."""
        return self.samples_per_phase * self.phases

    @property
    def duration(self) -> float:
        """Duration of a burst, s."""
        return self.scans / self.rate


@dataclass(frozen=True, config=CHECKED)
class ReferenceSettings:
    """Target behind the flip mirror: distance along the ray (m) with the stage at its zero (m)."""

    distance: float = Field(default=0.60, ge=0.001, le=100)
    stage_zero: float = Field(default=0.025, ge=-1, le=1)


@dataclass(frozen=True, config=CHECKED)
class Rig:
    """Settings of a rig: a whole RIG file.

    Examples
    --------
    >>> rig = Rig.default()
    >>> rig.detection.scans, rig.devices["daq"].driver
    (320, 'labjack-t7')
    """

    devices: dict[str, DeviceSettings] = Field(default_factory=dict)
    lines: LineSettings = LineSettings()
    galvo: GalvoSettings = GalvoSettings()
    drive: DriveSettings = DriveSettings()
    plates: PlateSettings = PlateSettings()
    detection: DetectionSettings = DetectionSettings()
    reference: ReferenceSettings = ReferenceSettings()
    twin: TwinSettings = TwinSettings()

    def __post_init__(self) -> None:
        for role, device in self.devices.items():
            if device.driver not in DRIVERS.get(role, ()):
                raise ValueError(
                    f"Expected devices out of {', '.join(DRIVERS)} with their drivers, got "
                    f"{role}: {device.driver}. Correct it."
                )
        dac = {name.replace("TDAC", "FIO") for name in (self.galvo.x, self.galvo.y)}
        lines = set(asdict(self.lines).values())
        if len(dac) + len(lines) < 8 or dac & lines:
            raise ValueError(
                "Expected each line of the read-out used once, TDAC2 standing for FIO2, got one "
                "used twice. Correct `lines` and `galvo`."
            )
        if self.detection.settle_samples >= self.detection.samples_per_phase:
            raise ValueError(
                f"Expected detection.settle_samples below samples_per_phase, got "
                f"{self.detection.settle_samples}. Lower it."
            )

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a RIG file; a ValueError names the first thing in it that cannot be."""
        return checked(cls, read_document(path), Path(path).name)

    @classmethod
    def default(cls) -> Self:
        """Return the rig that comes with the package."""
        return cls.load(Path(__file__).with_name("rig.yml"))

    def as_dict(self) -> dict[str, Any]:
        """Plain values, without addresses."""
        return TypeAdapter(type(self)).dump_python(self, mode="json", fallback=repr)
