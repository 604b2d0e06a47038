"""The rig: a RIG file, and the instruments that it names."""

import re
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, fields, replace
from importlib.resources import files
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import yaml

from cmtof.hardware.device import Device
from cmtof.hardware.drivers.apt_stage import Stage
from cmtof.hardware.drivers.galvo import Galvo
from cmtof.hardware.drivers.interlock import BLOCK_OUT, LASER_ON, SHUTTER_OPEN, Interlock
from cmtof.hardware.drivers.labjack_t7 import LabJackT7
from cmtof.hardware.drivers.power_meter import PowerMeter
from cmtof.hardware.drivers.rf_driver import RfDriver
from cmtof.hardware.drivers.signal_generator import SignalGenerator
from cmtof.hardware.drivers.stage_table import STAGES
from cmtof.hardware.rig_settings import DeviceSettings, RigSettings, settings_from_dict
from cmtof.hardware.safety import EmergencyStop, SafeDevice
from cmtof.hardware.transport import open_transport


@dataclass(frozen=True)
class Rig:
    """Settings of a rig, and the folder from which its relative addresses count.

    Examples
    --------
    >>> rig = Rig.default()
    >>> rig.settings.detection.scans, rig.settings.devices["daq"].driver
    (320, 'labjack-t7')
    """

    settings: RigSettings
    folder: Path = Path()

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a RIG file.

        Raises
        ------
        FileNotFoundError
            If there is none.
        ValueError
            If it is no YAML, or says what a RIG file cannot say.
        """
        path = Path(path)
        if not path.is_file():
            raise FileNotFoundError(f"Expected a RIG file, got no file {path}. Name another.")
        return cls(_settings_from_text(path.read_text(encoding="utf-8"), path.name), path.parent)

    @classmethod
    def default(cls) -> Self:
        """Return the rig that comes with the package; relative addresses count from here."""
        text = files("cmtof.hardware").joinpath("rig.yml").read_text(encoding="utf-8")
        return cls(_settings_from_text(text, "rig.yml"))

    def with_addresses(self, addresses: Mapping[str, Mapping[str, str]]) -> Self:
        """Return the same rig elsewhere.

        Parameters
        ----------
        addresses : mapping of str to mapping
            By role, ``address`` and, for the read-out, ``stream``.
        """
        devices = dict(self.settings.devices)
        for role, changes in addresses.items():
            devices[role] = replace(devices[role], **changes)
        return replace(self, settings=replace(self.settings, devices=devices))

    def address(self, role: str, which: str = "address") -> str:
        """Address of a device as `open_transport` takes it; `which` may be ``stream``."""
        found: str = getattr(self.settings.devices[role], which)
        kind, _, rest = found.partition(":")
        if kind != "serial":
            return found
        path, mark, options = rest.partition("?")
        return f"serial:{self.folder / path}{mark}{options}"

    def open(self) -> "Instruments":
        """Connect to every device of the file; use as a context manager.

        Raises
        ------
        InstrumentError
            If one cannot be reached; those that could are closed again.
        """
        with ExitStack() as opened:
            devices = {
                role: opened.enter_context(_Closing(self._device(role, settings)))
                for role, settings in self.settings.devices.items()
            }
            opened.pop_all()
        daq = devices.get("daq")
        return Instruments(
            **{role: closing.device for role, closing in devices.items()},
            galvo=None if daq is None else self._galvo(daq.device),
            interlock=None if daq is None else Interlock(daq.device, self.settings.lines),
        )

    def _device(self, role: str, settings: DeviceSettings) -> Any:
        transport = open_transport(self.address(role))
        name = role.replace("_", " ")
        try:
            if settings.driver == "labjack-t7":
                stream = open_transport(self.address(role, "stream"))
                return LabJackT7(transport, stream, name, safe_lines=self._safe_lines())
            if settings.driver in ("kdc101", "k10cr1"):
                kind = STAGES[settings.stage or settings.driver]
                if settings.counts_per_unit:
                    kind = kind.rescaled(settings.counts_per_unit)
                return Stage(transport, kind, name, serial_number=settings.serial_number)
            simple = {"rf-driver": RfDriver, "sdg2042x": SignalGenerator, "pm100d": PowerMeter}
            return simple[settings.driver](transport, name)
        except BaseException:
            transport.close()
            raise

    def _safe_lines(self) -> dict[str, bool]:
        lines = self.settings.lines
        return {
            lines.laser: not LASER_ON,
            lines.shutter: not SHUTTER_OPEN,
            lines.beam_block: not BLOCK_OUT,
        }

    def _galvo(self, daq: LabJackT7) -> Galvo:
        galvo = self.settings.galvo
        return Galvo(
            daq,
            (galvo.x, galvo.y),
            volts_per_radian=galvo.volts_per_radian,
            offset=(galvo.offset_x_volts, galvo.offset_y_volts),
            limit=galvo.limit_volts,
            settling=galvo.settling,
        )


@dataclass
class Instruments:
    """Connected instruments of a rig; None where the file has none.

    As a context manager it is an `EmergencyStop` over all of them, and closes them at the end.
    """

    rf_emission: RfDriver | None = None
    rf_detection: RfDriver | None = None
    clock: SignalGenerator | None = None
    daq: LabJackT7 | None = None
    galvo: Galvo | None = None
    interlock: Interlock | None = None
    plate_emission: Stage | None = None
    plate_detection: Stage | None = None
    stage: Stage | None = None
    power_meter: PowerMeter | None = None

    def __post_init__(self) -> None:
        self._stop = EmergencyStop(*self.in_order_of_stopping())

    def in_order_of_stopping(self) -> list[SafeDevice]:
        """Every instrument: first the light, then RF, then what moves."""
        order = (
            self.interlock,
            self.galvo,
            self.rf_emission,
            self.rf_detection,
            self.plate_emission,
            self.plate_detection,
            self.stage,
            self.daq,
            self.clock,
            self.power_meter,
        )
        return [device for device in order if device is not None]

    def _devices(self) -> Iterator[Device]:
        for one in fields(self):
            if isinstance(device := getattr(self, one.name), Device):
                yield device

    def safe_state(self) -> list[str]:
        """Bring every instrument to its safe state; return what failed, a line a device."""
        return self._stop.stop()

    def close(self) -> None:
        """Close every connection; may be called again."""
        for device in self._devices():
            device.close()

    def __enter__(self) -> Self:
        self._stop.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            self._stop.__exit__(kind, error, trace)
        finally:
            self.close()


class _Closing:
    """Closes a device unless it is passed on."""

    def __init__(self, device: Any) -> None:
        self.device = device

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.device.close()


class _StrictLoader(yaml.SafeLoader):
    """Plain values only, no key twice, and 7.15e9 a number as in YAML 1.2."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Values of a mapping; an error where a key would silently replace another."""
        keys = [key.value for key, _ in node.value]
        for key in keys:
            if keys.count(key) > 1:
                raise yaml.YAMLError(f"the key {key} twice in line {node.start_mark.line + 1} ff.")
        return super().construct_mapping(node, deep)


_StrictLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)[eE][-+]?[0-9]+"),
    list("-+.0123456789"),
)


def _settings_from_text(text: str, source: str) -> RigSettings:
    try:
        held = yaml.load(text, _StrictLoader)
    except yaml.YAMLError as error:
        reason = " ".join(str(error).split())
        raise ValueError(f"Expected YAML in {source}, got {reason}. Correct it.") from error
    return settings_from_dict(held, source=source)
