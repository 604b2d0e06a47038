"""Kinds of furniture, rooms, sizes and materials from `presets.yml`."""

from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml


@lru_cache(maxsize=1)
def presets() -> dict[str, Any]:
    """Contents of `presets.yml`: ``kinds``, ``rooms``, ``sizes``, ``materials`` and others."""
    text = Path(__file__).with_name("presets.yml").read_text(encoding="utf-8")
    return yaml.safe_load(text)
