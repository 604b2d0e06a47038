"""Which run made a result, the folder that it writes to, and JSON of the same bytes each time."""

import json
import os
import platform
import re
from base64 import b64encode
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from cmtof import __version__
from cmtof.files import atomic_output
from cmtof.types import Fields
from cmtof_book.compared import Compared

# environment variable that names the folder for results
OUTPUT_VARIABLE = "CMTOF_OUTPUT"
# stored beside every result; the profile is a file of configs/
RUN: Fields = {"profile": "book", "seed": 0, "version": __version__}


def output_folder() -> Path:
    """Folder of ``CMTOF_OUTPUT`` for figures and checks, or build/figures, made if need be."""
    folder = Path(os.environ.get(OUTPUT_VARIABLE) or "build/figures")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def processor() -> str:
    """Name of the processor by the operating system."""
    about = Path("/proc/cpuinfo")
    named = about.is_file() and re.search(
        r"model name\s*: (.+)", about.read_text("utf-8")
    )
    return named[1] if named else platform.processor()


def letters(content: bytes | NDArray) -> str:
    """Bytes as base64 text, as pages hold them."""
    return b64encode(bytes(content)).decode()


def _plain(value: Any) -> Any:
    """A number with its kind, or an array, as JSON has it."""
    return value.record() if isinstance(value, Compared) else value.tolist()


def read_json(path: Path) -> Any:
    """Values of a JSON file, {} where there is none."""
    return json.loads(path.read_text("utf-8")) if path.is_file() else {}


def write_json(path: Path, value: Any) -> None:
    """Write numbers, texts, arrays and containers of them as JSON, whole or not at all.

    Floats are rounded to ten significant digits, so that a file changes only when a result does.
    Raises ValueError if a number is not finite or a value is of another kind.
    """
    try:
        exact = json.dumps(value, default=_plain, allow_nan=False)
    except (AttributeError, TypeError, ValueError) as error:
        raise ValueError(
            f"Expected finite numbers or strings, got {value!r}. Convert or omit it."
        ) from error
    rounded = json.loads(
        exact, parse_float=lambda digits: float(f"{float(digits):.10g}")
    )
    with atomic_output(path) as part:
        part.write_text(
            json.dumps(rounded, indent=2, ensure_ascii=False) + "\n", "utf-8"
        )
