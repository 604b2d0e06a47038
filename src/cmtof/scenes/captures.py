"""Real captures of the all-optical 7.15 GHz prototype line, as published with GHz-FMCW.

Pan et al., Opt. Express 32(16), 2024, published the phase maps (``phase/scene_*_phase.csv``, rad)
of raster scans beside a coarse reference depth (``depth/scene_*_depth.csv``, mm). The captures are
not part of this project; where a copy lies on the machine it is found by `data_root`.
"""

import os
import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cmtof.constants import FREQUENCY_SINGLE
from cmtof.measurement import Measurement


def data_root() -> Path | None:
    """Folder with ``captures/`` and ``frames/``, or None where this machine has none.

    Looked for in the environment variable ``CMTOF_DATA``, then in ``shared/data`` beside the
    checkout, then in ``data`` within it.
    """
    checkout = Path(__file__).parents[3]
    named = os.environ.get("CMTOF_DATA")
    places = [Path(named)] if named else [checkout.parent / "shared" / "data", checkout / "data"]
    return next((place for place in places if (place / "captures").is_dir()), None)


def published_captures() -> dict[str, Path]:
    """Names and phase files of the captures on this machine; empty where there are none."""
    root = data_root()
    files = sorted(root.glob("captures/phase/scene_*_phase.csv")) if root else []
    return {file.stem.removeprefix("scene_").removesuffix("_phase"): file for file in files}


def open_capture(path: str | Path) -> Measurement:
    """Open ``phase/scene_NAME_phase.csv``; ``depth/scene_NAME_depth.csv`` comes with it if there.

    Returns
    -------
    Measurement
        One frequency, 7.15 GHz, phases only. The reference depth, m, stands as the variable
        ``reference_depth``: it is coarser than a wrap on the objects and no truth for them.

    Raises
    ------
    ValueError
        If the file is empty, ragged, not numeric, or holds no wrapped phases.
    """
    path = Path(path)
    phase = read_csv_map(path)
    if not (phase.min() >= -1e-6 and phase.max() <= 2 * np.pi + 1e-6):
        raise ValueError(
            f"Expected wrapped phases from 0 to 2 pi rad in {path}, got {phase.min():.4g} to "
            f"{phase.max():.4g}. Is it a depth map?"
        )
    measurement = Measurement.from_phase(
        phase[None],
        [FREQUENCY_SINGLE],
        range_max=1.0,
        source=f"GHz-FMCW capture {path.name}",
        protocol="measured",
    )
    depth_path = path.parents[1] / "depth" / path.name.replace("_phase", "_depth")
    if depth_path.is_file():
        depth = read_csv_map(depth_path) / 1000
        if depth.shape != phase.shape:
            raise ValueError(
                f"Expected a reference depth of shape {phase.shape}, got {depth.shape} in "
                f"{depth_path}. Take the one of the same scene."
            )
        measurement.dataset["reference_depth"] = (("y", "x"), depth, {"units": "m"})
    return measurement


def read_csv_map(path: Path) -> NDArray[np.float64]:
    """Read a rectangular table of finite numbers, (H, W)."""
    try:
        with warnings.catch_warnings(action="ignore"):  # of no data: the error below says it
            table = np.loadtxt(path, delimiter=",", ndmin=2)
    except (OSError, ValueError) as error:
        reason = str(error).splitlines()[0]
        raise ValueError(
            f"Expected rows of numbers parted by commas in {path}, got {reason}. Check the file."
        ) from error
    if table.size == 0 or not np.isfinite(table).all():
        raise ValueError(
            f"Expected finite numbers in {path}, got {'none' if not table.size else 'NaN or inf'}. "
            "Check the file."
        )
    return table


def write_capture(phase: NDArray[np.floating], depth: NDArray[np.floating], folder: Path) -> Path:
    """Write a phase map, rad, and depth, m, in the published layout; return the phase file.

    For rehearsals with simulated maps where the captures are not at hand.
    """
    for kind, table in (("phase", phase), ("depth", depth * 1000)):
        (folder / kind).mkdir(parents=True, exist_ok=True)
        np.savetxt(folder / kind / f"scene_simulated_{kind}.csv", table, delimiter=",")
    return folder / "phase" / "scene_simulated_phase.csv"
