"""Which run made a result: its seed, profile and version, and the folder it writes to."""

import json
import math
import os
import platform
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cmtof import __version__
from cmtof.files import written_whole

OUTPUT_VARIABLE = "CMTOF_OUTPUT"
"""Environment variable that names the folder for figures and checks."""

_run: dict[str, str | int] = {}


def begin(*, profile: str = "book", seed: int = 0) -> None:
    """Set the profile, a file of ``configs/``, and the seed of everything stored from now on."""
    _run.update(profile=profile, seed=seed, version=__version__)


begin()


def as_dict() -> dict[str, str | int]:
    """Profile, seed and version of the current run, to be stored beside a result."""
    return dict(_run)


def output_folder() -> Path:
    """Folder of ``CMTOF_OUTPUT`` for figures and checks, or build/figures, made if need be."""
    folder = Path(os.environ.get(OUTPUT_VARIABLE) or Path("build", "figures"))
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def processor() -> str:
    """What the operating system calls the processor."""
    found = Path("/proc/cpuinfo")
    text = found.read_text(encoding="utf-8") if found.is_file() else ""
    named = re.search(r"model name\s*: (.+)", text)
    return named[1] if named else platform.processor() or platform.machine()


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
    raise ValueError(f"Expected finite numbers or strings, got {value!r}. Convert or omit it.")


def write_json(path: str | Path, value: Any) -> None:
    """Write what `plain` accepts as JSON, whole or not at all, with the same bytes on every run."""
    text = json.dumps(plain(value), indent=2, ensure_ascii=False) + "\n"
    with written_whole(path) as part:
        part.write_text(text, encoding="utf-8")
