"""Kinds of furniture, rooms, sizes and materials from `presets.yml`."""

from functools import cache
from pathlib import Path

from cmtof.files import read_document
from cmtof.types import Fields


@cache
def presets() -> Fields:
    """Contents of `presets.yml`: ``kinds``, ``rooms``, ``sizes``, ``materials`` and others."""
    return read_document(Path(__file__).with_name("presets.yml"))
