"""Which run made a result: its seed, profile and version, and the folder it writes to."""

import json
import math
import os
import platform
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cmtof import __version__
from cmtof.files import written_whole

OUTPUT_VARIABLE = "CMTOF_OUTPUT"
"""Environment variable that names the folder for figures and checks."""


@dataclass(frozen=True)
class Run:
    """What has to be known to draw a result again."""

    profile: str = "book"
    """Name of the size profile, a file of ``configs/``."""
    seed: int = 0
    """Seed of every random draw of the run."""
    version: str = __version__


_current = Run()


def begin(*, profile: str = "book", seed: int = 0) -> Run:
    """Set the run that everything stored from now on belongs to, and return it.

    Raises ValueError if the profile is empty or the seed is no whole number ≥ 0.
    """
    global _current
    if not profile:
        raise ValueError("Expected the name of a profile, got ''. Pass 'ci', 'book' or 'paper'.")
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise ValueError(f"Expected a whole seed ≥ 0, got {seed!r}. Pass an int.")
    _current = Run(profile=profile, seed=int(seed))
    return _current


def as_dict() -> dict[str, str | int]:
    """Profile, seed and version of the current run, to be stored beside a result."""
    return asdict(_current)


def output_folder() -> Path:
    """Folder of ``CMTOF_OUTPUT`` for figures and checks, or build/figures, made if need be."""
    folder = Path(os.environ.get(OUTPUT_VARIABLE) or Path("build", "figures"))
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def processor() -> str:
    """What the operating system calls the processor."""
    found = Path("/proc/cpuinfo")
    lines = found.read_text(encoding="utf-8").splitlines() if found.is_file() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def plain(value: Any) -> Any:
    """Numbers, arrays and containers of them as values that JSON holds exactly.

    Floats are rounded to ten significant digits, so that a file changes only when a result does.
    Raises ValueError if a number is not finite or a value is of another kind.
    """
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float) and math.isfinite(value):
        return float(f"{value:.10g}")
    raise ValueError(
        f"Expected finite numbers, strings or lists of them to store, got {value!r}. "
        "Convert it or leave it out."
    )


def write_json(path: str | Path, value: Any) -> None:
    """Write what `plain` accepts as JSON, whole or not at all, with the same bytes on every run."""
    text = json.dumps(plain(value), indent=2, ensure_ascii=False) + "\n"
    with written_whole(path) as part:
        part.write_text(text, encoding="utf-8")
