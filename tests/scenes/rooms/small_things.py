"""What every small thing is held to."""

import numpy as np
from furnishing import assert_repeatable, closed_volumes, draw

from cmtof.scenes.rooms.thing import Thing

SEEDS = range(6)


def triangles(thing: Thing) -> int:
    """Of a thing and of all that it carries."""
    own = sum(len(part.mesh.faces) for part in thing.parts)
    return own + sum(triangles(child) for child, _ in thing.children)


def assert_makers(catalogue, limits, check_thing, *, budget: int = 6000) -> None:
    """Every maker stands, is as large as a real one, looks outwards and repeats itself.

    ``limits`` has, for each name, the least and the greatest width, depth and height, m.
    """
    assert set(limits) == set(catalogue)
    for name, maker in catalogue.items():
        for seed in SEEDS:
            thing = draw(maker, seed)
            check_thing(thing, triangles=budget)
            assert_sized(name, thing, limits[name])
            inward = [volume for volume in closed_volumes(thing) if volume < -1e-9]
            assert not inward, f"{name}, seed {seed}: a part is inside out"
        assert_repeatable(maker)


def assert_sized(name: str, thing: Thing, limits) -> None:
    """Width, depth and height lie within those of real ones, m."""
    low, high = thing.bounds
    size = high - low
    least, most = np.array(limits, float).T
    assert (size >= least).all(), f"{name} is too small: {size}"
    assert (size <= most).all(), f"{name} is too large: {size}"
