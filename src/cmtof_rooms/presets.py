"""Kinds of furniture, rooms and materials from `presets.yml`."""

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.random import Generator

from cmtof_rooms.kit import Kit
from cmtof_rooms.materials import Material


@lru_cache(maxsize=1)
def presets() -> dict[str, Any]:
    """Contents of `presets.yml`: ``kinds``, ``rooms``, ``sizes``, ``materials`` and others."""
    text = Path(__file__).with_name("presets.yml").read_text(encoding="utf-8")
    return yaml.safe_load(text)


def household(rng: Generator) -> Kit:
    """Draw the materials that everything in a room is made of."""
    palette = {
        role: [_material(rng, drawn) for _ in range(drawn["count"])]
        for role, drawn in presets()["materials"].items()
    }
    return Kit(rng, palette, presets()["profiles"], presets()["sizes"])


def _material(rng: Generator, drawn: dict[str, Any]) -> Material:
    """Draw one material of a role: two of its colours, a pattern and its scale."""
    start = np.array(drawn["colours"])[rng.integers(len(drawn["colours"]), size=2)]
    first, second = np.clip(start * rng.uniform(0.75, 1.2, (2, 1)), 0.01, 0.92)
    mix = rng.uniform(0.15, 0.7)
    second = first + mix * (second - first) * rng.uniform(0.5, 1.0)
    pattern = weighted_choice(rng, drawn["patterns"])
    return Material(tuple(first), tuple(second * 0.8), pattern, rng.uniform(*drawn["scale"]))


def weighted_choice(rng: Generator, weights: dict[str, float]) -> str:
    """Draw a name by its weight."""
    odds = np.array(list(weights.values()), float)
    return str(rng.choice(list(weights), p=odds / odds.sum()))
