"""Published captures of a later 7.15 GHz instrument by some of the paper's authors (GHz-FMCW).

Pan et al., Opt. Express 32(16), 2024, published the phase maps (``phase/scene_*_phase.csv``, rad)
of raster scans beside a reference depth (``depth/scene_*_depth.csv``, mm), not copied here. It is
coarser than a wrap on the objects, so it cannot serve as ground truth.
"""

import os
import warnings
from pathlib import Path

import numpy as np

from cmtof.correlation import wrapped
from cmtof.files import AnyPath, reading
from cmtof.types import Array


def data_root() -> Path | None:
    """Folder with ``captures``: ``CMTOF_DATA`` if set, else by or in the checkout; or None."""
    checkout = Path(__file__).parents[2]
    named = os.environ.get("CMTOF_DATA")
    places = (
        [Path(named)]
        if named
        else [checkout.parent / "shared" / "data", checkout / "data"]
    )
    return next((place for place in places if (place / "captures").is_dir()), None)


def published_captures() -> dict[str, Path]:
    """Phase files of the captures on this machine, by name; empty where there are none."""
    root = data_root()
    files = sorted(root.glob("captures/phase/scene_*_phase.csv")) if root else []
    return {
        file.stem.removeprefix("scene_").removesuffix("_phase"): file for file in files
    }


def read_capture(path: AnyPath) -> tuple[Array, Array | None]:
    """Wrapped phase (H, W), rad, and the reference depth, m, or None where it has no file."""
    path = Path(path).resolve()
    phase = _read_map(path)
    depth = None
    least = phase.min()
    most = phase.max()
    if least < -np.pi - 1e-5 or most > min(least, 0.0) + 2 * np.pi + 1e-5:
        raise ValueError(
            "Expected wrapped phases over one turn of 2 pi rad, "
            f"got {least:.4g} to {most:.4g} in {path}. Is it a depth map?"
        )
    other = path.parent.parent / "depth" / path.name.replace("_phase", "_depth")
    if other.is_file():
        depth = _read_map(other) / 1000
        if depth.shape != phase.shape:
            raise ValueError(
                f"Expected a reference depth of shape {phase.shape}, got {depth.shape} in {other}. "
                "Use the file of the same scene."
            )
    return wrapped(phase), depth


def _read_map(path: Path) -> Array:
    """Finite numbers (H, W) of a CSV file; a ValueError if there are others."""
    with reading("rows of finite numbers separated by commas", path):
        with warnings.catch_warnings(
            action="ignore"
        ):  # NumPy warns of an empty file: the error below names it
            table = np.loadtxt(path, delimiter=",", ndmin=2)
        if table.size == 0 or not np.isfinite(table).all():
            raise ValueError("NaN or inf" if table.size else "none")
    return table
