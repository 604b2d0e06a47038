"""What every small thing is held to."""

import numpy as np
from furnishing import assert_repeatable, closed_volumes, draw

from cmtof.scenes.rooms.thing import Thing

SEEDS = range(8)


def assert_made_well(name, maker, limits, check_thing, *, budget=6000, standing="floor") -> None:
    """It stands, is as large as a real one, looks outwards and repeats itself.

    ``limits`` are the least and the greatest width, depth and height, m.
    """
    for seed in SEEDS:
        thing = draw(maker, seed)
        check_thing(thing, standing, triangles=budget)
        assert_sized(name, thing, limits)
        inward = [volume for volume in closed_volumes(thing) if volume < -1e-9]
        assert not inward, f"{name}, seed {seed}: a part is inside out"
    assert_repeatable(maker)


def assert_sized(name: str, thing: Thing, limits) -> None:
    """Width, depth and height lie within those of real ones, m."""
    low, high = thing.bounds
    least, most = np.array(limits, float).T
    assert (high - low >= least).all(), f"{name} is too small: {high - low}"
    assert (high - low <= most).all(), f"{name} is too large: {high - low}"


def distinct(maker, count: int = 12) -> int:
    """How many different shapes so many draws have, told by their numbers of triangles."""
    return len({sum(len(p.mesh.faces) for p in draw(maker, seed).parts) for seed in range(count)})
