"""Scans by the simulated instrument: the program of `cmtof.hardware`, without any device."""

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cmtof.hardware.bench import Bench
from cmtof.hardware.plan import BURST_INTERVAL, planned
from cmtof.hardware.rig import Rig
from cmtof.hardware.scan import scan
from cmtof.measurement import Measurement
from cmtof.validation import checked
from cmtof_lab.devices import simulated_devices
from cmtof_lab.instrument import SimulatedInstrument
from cmtof_lab.settings import TwinSettings

MEMORY = Path("/dev/shm")  # file system in memory, where the system has one


def simulated_bench(
    rig: Rig, scene: Any = None, settings: TwinSettings | None = None, *, seed: int = 0
) -> Bench:
    """Bench of simulated devices before a scene; ``daq.instrument`` is what they belong to.

    ``settings`` are by default those below ``twin`` in the RIG file, ``scene`` that of the
    settings. A ValueError names the first setting in the file that cannot be.
    """
    if settings is None:
        settings = checked(TwinSettings, rig.twin, "twin")
    scene = settings.scene if scene is None else scene
    instrument = SimulatedInstrument(settings, scene, seed=seed)
    about = {
        "source": "simulated instrument",
        "seed": seed,
        "group_index": instrument.group_index,
        "twin": settings.as_dict(),
    }
    if isinstance(scene, str | Path):
        about["scene"] = Path(scene).name
    devices = simulated_devices(instrument, rig)
    return Bench(rig, devices, patience=0.0, clock_of=lambda n: BURST_INTERVAL * n, **about)


def scan_scene(
    settings: TwinSettings,
    target: Any,
    *,
    size: int | tuple[int, int],
    field_of_view: float | tuple[float, float],
    seed: int,
    **rigged: Any,
) -> Measurement:
    """Scan of a target by the simulated instrument, with its true depth; no file is left.

    Ranges are optical, ``n_g z`` with the attribute ``group_index``, as in every scan: divide what
    comes out of the measurement, its true ``depth`` included, to have metres along the ray. The
    target is one of `cmtof_lab.targets.scene_from`; ``size`` is height and width, px,
    ``field_of_view`` the full optical angles across and down, rad; ``rigged`` are other fields of
    the rig, such as ``frequency_single``, Hz.

    >>> wall = {"kind": "plane", "distance": 1.0}
    >>> scan_scene(TwinSettings(), wall, size=2, field_of_view=0.1, seed=0)
    <Measurement 2x2 px at 7.15, 14.32 GHz, 0.000-7.495 m>
    """
    view = tuple(np.rad2deg(np.broadcast_to(field_of_view, 2)).tolist())
    rig = replace(Rig.default(), field_of_view_deg=view, **rigged)
    plan = planned(rig, size=size)
    bench = simulated_bench(rig, target, settings, seed=seed)
    # every line of the journal waits for the disk: in memory there is nothing to wait for
    with tempfile.TemporaryDirectory(dir=MEMORY if MEMORY.is_dir() else None) as folder:
        data = scan(plan, lambda: bench, Path(folder, "m.nc")).dataset
    instrument = bench.devices["daq"].instrument
    ranges = instrument.ranges(plan.angles).reshape(plan.angles.shape[:2])
    data["depth"] = (("y", "x"), data.attrs["group_index"] * ranges, {"units": "m"})
    data["mask"] = data["mask"] * np.isfinite(ranges).astype(np.int8)
    return Measurement(data)
