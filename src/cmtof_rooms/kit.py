"""What makers of furniture work with: random numbers, materials, and what they yield.

A maker fills a `Box` that stands on z = 0 about the z axis, its front towards -y. It yields the
solids of a piece of furniture, boxes of free space on it where other things can stand, and the
light of a lamp.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike

from cmtof.types import Fields, Pair
from cmtof_rooms.boxes import Box
from cmtof_rooms.materials import Material
from cmtof_rooms.presets import presets
from cmtof_rooms.solids import join
from cmtof_rooms.things import Light, Part, Solid, meshes_of

# Solids of one material, or of one drawn for a role, which become a part.
Solids = tuple[Material | str, *tuple[Solid, ...]]

Piece = Iterator[Solids | Box | Light]  # A piece of furniture as its maker yields it


@dataclass(frozen=True)
class Kit:
    """Random numbers and the materials of a household.

    Attributes
    ----------
    rng : Generator
    palette : dict
        Materials to choose from, by role: wood, fabric, metal, ...
    """

    rng: Generator
    palette: dict[str, list[Material]]

    def material(self, role: str) -> Material:
        """Draw one of the household's materials of a role."""
        return self.pick(self.palette[role])

    def part(self, material: Material | str, *solids: Solid) -> Part:
        """Join solids to a part of one material, which is given or drawn for a role."""
        if isinstance(material, str):
            material = self.material(material)
        return Part(material, join(meshes_of(solids)))

    def pick(self, items: Sequence) -> Any:
        """Draw one of several items."""
        return items[int(self.rng.integers(len(items)))]

    def between(self, low: float, high: float) -> float:
        """Draw a number evenly between two limits."""
        return self.rng.uniform(low, high)

    def draw(self, name: str) -> list[float]:
        """Draw all ``sizes`` that `presets.yml` has for a name, evenly."""
        return self.each(presets()["sizes"][name].values())

    def each(self, limits: Iterable[Pair]) -> list[float]:
        """Draw a number evenly between each of several pairs of limits."""
        return [self.between(*pair) for pair in limits]

    def count(self, limits: Sequence[int]) -> int:
        """Draw a whole number evenly from the lowest to the highest."""
        low, high = limits
        return int(self.rng.integers(low, high, endpoint=True))

    def chance(self, share: float) -> bool:
        """Draw whether something happens that does so in a share of cases."""
        return self.rng.uniform() < share


def household(rng: Generator) -> Kit:
    """Draw the materials of everything in a room, as a `Kit`."""
    return Kit(
        rng,
        {
            role: [_material(rng, drawn) for _ in range(drawn["count"])]
            for role, drawn in presets()["materials"].items()
        },
    )


def _material(rng: Generator, drawn: Fields) -> Material:
    """Draw one material of a role: two of its colours, a pattern and its scale."""
    colours = np.array(drawn["colours"])
    pair = colours[rng.integers(len(colours), size=2)]
    first, second = np.clip(pair * rng.uniform(0.75, 1.2, (2, 1)), 0.01, 0.92)
    mix = rng.uniform(0.15, 0.7) * (second - first) * rng.uniform(0.5, 1.0)
    second = 0.8 * (first + mix)
    patterns = drawn["patterns"]
    pattern = weighted_choice(rng, list(patterns), list(patterns.values()))
    return Material(
        tuple(first),
        tuple(second),
        pattern,
        rng.uniform(*drawn["scale"]),
    )


def weighted_choice(rng: Generator, items: Sequence, weights: ArrayLike) -> Any:
    """Draw one of several items by its weight."""
    return items[rng.choice(len(items), p=np.divide(weights, np.sum(weights)))]
