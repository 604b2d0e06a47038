"""Settings of a rig, read from a RIG file, and the wiring of its parts."""

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import ConfigDict, Field, TypeAdapter
from pydantic.dataclasses import dataclass

from cmtof.air import group_index
from cmtof.constants import HALF_WAVE_PLATE_DOUBLED, HALF_WAVE_PLATE_SINGLE
from cmtof.files import AnyPath, read_document
from cmtof.types import Fields
from cmtof.validation import checked_values

# Names of the drivers that each role accepts.
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
# Digital lines of the read-out, unless a rig has others; the LJTick-DAC takes FIO2 and FIO3.
LINES = {
    "laser": "FIO0",
    "shutter": "FIO1",
    "trigger": "FIO4",
    "flip_mirror": "FIO5",
    "beam_block": "FIO6",
    "interlock": "FIO7",
}
# low is safe: laser off, shutter shut, block in
LIGHT = ("laser", "shutter", "beam_block")
MODES = {"single": 1, "doubled": 2}  # which harmonic of the drive modulates the light
# Angle of both half-wave plates in each mode, degrees.
PLATES = {"single": HALF_WAVE_PLATE_SINGLE, "doubled": HALF_WAVE_PLATE_DOUBLED}
SAMPLE_RATE = 24000.0  # Hz (Sec. 7.2): 16 phases of 20 samples take 13.3 ms

CHECKED = ConfigDict(extra="forbid")
Angle = Annotated[float, Field(gt=0, lt=80)]
Volts = Annotated[float, Field(ge=-10, le=10)]
Seconds = Annotated[float, Field(ge=0, le=10)]
Degrees = Annotated[float, Field(ge=-360, le=360)]
Decibels = Annotated[float, Field(ge=-30, le=35)]
Drive = Annotated[float, Field(ge=7.14e9, le=7.17e9)]
Line = Annotated[str, Field(pattern="^FIO[0-7]$")]
Output = Annotated[str, Field(pattern="^TDAC[0-7]$")]
Input = Annotated[str, Field(pattern="^AIN[0-9]$")]


@dataclass(frozen=True, config=CHECKED)
class DeviceSettings:
    """Driver, address and individual settings of a device."""

    driver: str
    # not stored with a measurement
    address: str = Field(default="", exclude=True)
    # if given, another device is refused
    serial_number: str = ""
    # of a motor, per m or rad
    counts_per_unit: float | None = Field(default=None, gt=0, le=1e12)
    # s that an answer may take
    timeout: float = Field(default=1.0, gt=0, le=10, exclude=True)


@dataclass(frozen=True, config=CHECKED)
class Rig:
    """Settings of a rig in m, s, Hz, V; degrees where a name ends in _deg."""

    devices: dict[str, DeviceSettings]
    # optical angles across and down
    field_of_view_deg: tuple[Angle, Angle] = (20.0, 20.0)
    # of both RF drives, and what the modulators stand
    power_dbm: Decibels = 30.0
    power_dbm_limit: Decibels = 30.0
    # of the beam that leaves, W, and that power over the metered power
    power_limit: float = Field(default=4e-3, gt=0, le=0.5)
    emitted_share: float = Field(default=0.41, gt=0, le=100)
    # those that differ from the guide's
    lines: dict[str, Line] = Field(default_factory=dict)
    shutter_settling: Seconds = 0.1
    # flippers take 0.3 to 2.8 s
    flip_mirror_settling: Seconds = 3.0
    # outputs that steer along x and y
    mirrors: tuple[Output, Output] = ("TDAC2", "TDAC3")
    # of a mirror; negative where it turns the other way
    mirror_volts_per_degree: tuple[Volts, Volts] = (0.5, 0.5)
    # straight ahead
    mirror_offset_volts: tuple[Volts, Volts] = (0.0, 0.0)
    # after steps of 0.4, 40 and 80 degrees
    mirror_settling: tuple[Seconds, Seconds, Seconds] = (4e-4, 7.7e-3, 0.02)
    detector_input: Input = "AIN0"
    # of the RF demodulator's I and Q
    iq_inputs: tuple[Input, Input] = ("AIN2", "AIN3")
    # where it sends the light
    flip_mirror: Literal["reference", "photodiode"] = "reference"
    # of the beam to the target, where the flip mirror leads to the photodiode instead
    reference_direction_deg: tuple[Degrees, Degrees] = (0.0, 0.0)
    # output that moves that of interferometry, and m per V, nearer
    reference_mirror: Literal["DAC0", "DAC1"] = "DAC0"
    reference_mirror_travel: float = Field(default=1e-6, gt=0, le=1e-3)
    # avalanche gain, set by hand
    detector_gain: float = Field(default=50.0, ge=1, le=1000)
    # of the drive in each mode
    frequency_single: Drive = 7.15e9
    frequency_doubled: Drive = 7.16e9
    clock_frequency: float = Field(default=10e6, ge=1e6, le=40e6)
    # V peak to peak into 50 Ohm
    clock_amplitude: float = Field(default=1.0, ge=0.01, le=10)
    # one, and a splitter: two drift apart
    clock_channels: tuple[Literal[1, 2], ...] = Field(default=(1,), min_length=1)
    # silence that switches the RF drivers off
    dead_man: float = Field(default=5.0, ge=2, le=60)
    # of the mounts at theta_h = 0
    plate_zero_emission_deg: Degrees = 0.0
    plate_zero_detection_deg: Degrees = 0.0
    rate: float = Field(default=SAMPLE_RATE, ge=1, le=50e3)
    phases: int = Field(default=16, ge=3, le=64)
    samples_per_phase: int = Field(default=20, ge=2, le=250)
    # first of a phase: the filter settles
    settle_samples: int = Field(default=4, ge=0, le=249)
    # above, the detector is nonlinear
    limit_volts: float = Field(default=4.0, ge=0.001, le=10)
    # of the air, K and Pa
    temperature: float = Field(default=293.15, ge=200, le=400)
    pressure: float = Field(default=101325.0, ge=0, le=2e5)
    # of the target along its ray, with its stage at its zero
    reference_distance: float = Field(default=0.60, ge=0.001, le=100)
    stage_zero: float = Field(default=0.025, ge=-1, le=1)
    # of the simulated instrument
    twin: Fields = Field(default_factory=dict, exclude=True)

    def __post_init__(self) -> None:
        for role in DRIVERS | self.devices:
            found = self.devices[role].driver if role in self.devices else "none"
            wanted = DRIVERS.get(role, ())
            if found not in wanted:
                names = " or ".join(wanted) or "no such role"
                raise ValueError(
                    f"Expected devices.{role}: {names}, got {found}. Correct it."
                )
        if self.power_dbm > self.power_dbm_limit:
            raise ValueError(
                f"Expected power_dbm up to power_dbm_limit, {self.power_dbm_limit:g}, "
                f"got {self.power_dbm:g}. Lower it."
            )
        used = [
            *(LINES | self.lines).values(),
            *(one.replace("TDAC", "FIO") for one in self.mirrors),
        ]
        if not len(set(used)) == len(used) == len(LINES) + 2:
            raise ValueError(
                f"Expected {' '.join(LINES)} and both mirrors on terminals of their own, "
                f"got {' '.join(sorted(used))}. Wire one elsewhere."
            )
        if self.scans > self.rate:
            raise ValueError(
                f"Expected bursts of at most 1 s, got {self.scans} samples at {self.rate:g} Hz. "
                "Raise the rate or take fewer."
            )
        if not all(self.mirror_volts_per_degree):
            raise ValueError(
                "Expected mirror_volts_per_degree other than 0, got 0. Measure it."
            )
        if self.settle_samples >= self.samples_per_phase:
            raise ValueError(
                "Expected settle_samples below samples_per_phase, "
                f"got {self.settle_samples}. Lower it."
            )

    @classmethod
    def load(cls, path: AnyPath) -> Self:
        """Rig of a RIG file; a ValueError names the first wrong setting.

        Its ``bench`` is a file of further keys, beside it: what was measured on a bench and is the
        same for all its rigs. Keys of the RIG file itself come first.
        """
        found = read_document(path)
        record = found.pop("bench", None)
        if record:
            found = read_document(Path(path).parent / str(record)) | found
        return checked_values(cls, found, Path(path).name)

    @classmethod
    def default(cls) -> Self:
        """Rig that comes with the package."""
        return cls.load(Path(__file__).with_name("rig.yml"))

    @property
    def scans(self) -> int:
        """Number of samples of a burst per input."""
        return self.samples_per_phase * self.phases

    @property
    def group_index(self) -> float:
        """Group index of the air."""
        return group_index(temperature=self.temperature, pressure=self.pressure)

    def line(self, part: str) -> str:
        """Name of the digital line of a part, such as FIO1 of the shutter."""
        return (LINES | self.lines)[part]

    def drive_frequency(self, mode: str) -> float:
        """Drive frequency of a mode, Hz."""
        return getattr(self, f"frequency_{mode}")

    def as_dict(self) -> Fields:
        """Settings as plain values for JSON, without addresses."""
        return TypeAdapter(type(self)).dump_python(self, mode="json", fallback=repr)
