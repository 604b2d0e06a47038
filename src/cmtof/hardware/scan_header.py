"""What the result of a scan depends on: the header of its journal."""

import json
from dataclasses import asdict
from typing import Any

from cmtof import __version__
from cmtof.hardware.bench import Bench
from cmtof.hardware.codecs.labjack import gain_index
from cmtof.hardware.plan import Plan
from cmtof.hardware.rig_settings import RigSettings
from cmtof.instrument.optics import group_index


def header_of(
    bench: Bench, plan: Plan, *, seed: int | None = None, scene: str | None = None
) -> dict[str, Any]:
    """Everything that the result depends on, as JSON has it; no address, no clock."""
    settings, sampling = bench.settings, bench.sampling
    gain = bench.instruments.daq.calibration().high_speed[gain_index(settings.detection.range)]
    instruments = bench.identities()
    drive = settings.drive
    return {
        "version": __version__,
        "source": "simulated instrument" if "TWIN" in json.dumps(instruments) else "instrument",
        "seed": seed,
        "scene": scene,
        "plan": plan.as_dict(),
        "sampling": asdict(sampling),
        "gain": asdict(gain),
        "group_index": group_index(),
        "frequencies": {
            mode: drive.frequency(mode) * (2 if mode == "doubled" else 1) for mode in plan.modes
        },
        "settings": settings_as_dict(settings),
        "instruments": instruments,
    }


def settings_as_dict(settings: RigSettings) -> dict[str, Any]:
    """Settings as plain values, without addresses, which say nothing of the measurement."""
    sections = ("lines", "galvo", "drive", "plates", "detection", "reference", "scan")
    kept = {name: asdict(getattr(settings, name)) for name in sections}
    devices = {
        role: {k: v for k, v in asdict(device).items() if k not in ("address", "stream")}
        for role, device in settings.devices.items()
    }
    whole = {"name": settings.name, "devices": devices, **kept, "twin": dict(settings.twin)}
    return json.loads(json.dumps(whole))
