"""Scans by the simulated instrument: the program of `cmtof.hardware`, without any device."""

import tempfile
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from cmtof.hardware.bench import Bench
from cmtof.hardware.connect import connected_bench
from cmtof.hardware.plan import BURST_INTERVAL, plan_scan
from cmtof.hardware.rig import Rig
from cmtof.hardware.scan import scan
from cmtof.measurement import Measurement
from cmtof.types import Pair, Shape
from cmtof.validation import checked_values
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
        settings = checked_values(TwinSettings, rig.twin, "twin")
    scene = settings.scene if scene is None else scene
    instrument = SimulatedInstrument(settings, scene, seed=seed)
    about = {
        "source": "simulated instrument",
        "seed": seed,
        "group_index": settings.group_index,
        "twin": settings.as_dict(),
    }
    if isinstance(scene, str | Path):
        about["scene"] = Path(scene).name
    return Bench(
        rig,
        simulated_devices(instrument, rig),
        patience=0.0,
        clock_of=lambda n: BURST_INTERVAL * n,
        **about,
    )


def rig_of(path: str, **changes: Any) -> Rig:
    """Rig of a RIG file, or for an empty path the default one, with some fields changed."""
    return replace(Rig.load(path) if path else Rig.default(), **changes)


def open_bench(
    path: str, rig: Rig, *simulated: Any, **options: Any
) -> AbstractContextManager[Bench]:
    """Bench of a RIG file's own devices, or for an empty path that of `simulated_bench`."""
    return connected_bench(rig) if path else simulated_bench(rig, *simulated, **options)


def scan_scene(
    settings: TwinSettings,
    target: Any,
    *,
    size: int | Shape,
    field_of_view: float | Pair,
    seed: int,
    path: str = "",
    **rigged: Any,
) -> Measurement:
    """Scan of a target by the simulated instrument, with its true depth; no file is left.

    With the ``path`` of a RIG file its own devices scan, before which such a target stands.

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
    rig = rig_of(path, field_of_view_deg=view, **rigged)
    plan = plan_scan(rig, size=size)
    bench = partial(open_bench, path, rig, target, settings, seed=seed)
    # every line of the journal waits for the disk: in memory there is nothing to wait for
    with tempfile.TemporaryDirectory(dir=MEMORY if MEMORY.is_dir() else None) as folder:
        data = scan(plan, bench, Path(folder, "m.nc")).dataset
    ranges = SimulatedInstrument(settings, target).ranges(plan.angles)
    data["depth"] = (("y", "x"), data.attrs["group_index"] * ranges, {"units": "m"})
    data["mask"] *= np.isfinite(ranges)
    return Measurement(data)
