"""The book's own tools: figures, published numbers, notes and provenance; no physics."""

import sys
from pathlib import Path
from typing import Any

from cmtof.files import read_document

# jsonschema, by which notebooks are checked and numbers glued, would compile a grammar of
# internationalised URIs for seconds; it does without when there is none
sys.modules["rfc3987_syntax"] = None  # pyright: ignore[reportArgumentType]

ROOT = Path(__file__).resolve().parents[2]  # folder of the checkout

# Folder of what is computed once, for chapters to read
RESULTS = ROOT / "book/results"

# Variables that say how many threads numbers are computed on.
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")


def package_data(name: str) -> dict[str, Any]:
    """Names and values of a YAML file of this package."""
    return read_document(Path(__file__).with_name(f"{name}.yml"))
