"""The embedded frames: three views of formula-made rooms, from a table top to a hallway.

They travel with the package as ``frames/*.npz`` so that everything runs with nothing downloaded.
``python -m cmtof.scenes.catalogue`` traces them anew.
"""

from collections.abc import Callable

import numpy as np

from cmtof.scenes.analytic import (
    Solid,
    box,
    capsule,
    checked,
    grained,
    plain,
    plane,
    revolved,
    sphere,
    striped,
    view,
)
from cmtof.scenes.frame import EMBEDDED, Frame

SHAPE = (240, 320)

VASE = [(0.035, 0.0), (0.075, 0.07), (0.07, 0.12), (0.025, 0.19), (0.022, 0.22), (0.04, 0.245)]
MUG = [(0.04, 0.0), (0.042, 0.09)]
BUST = [(0.07, 0.0), (0.06, 0.02), (0.035, 0.05), (0.055, 0.1), (0.062, 0.14), (0.04, 0.19)]


def still_life(shape: tuple[int, int] = SHAPE) -> Frame:
    """A table top at 0.8 to 1.6 m: vase, bust, books, fruit, a mug, a wall behind."""
    books = [
        Solid(box((0.23, 0.02, 0.02), (0.2, 0.04, 0.14), turn=0.3, rounding=0.003), plain(0.3)),
        Solid(
            box((0.235, 0.056, 0.025), (0.17, 0.032, 0.12), turn=-0.1, rounding=0.003),
            striped(0.2, 0.8, (1, 0, 0), 0.05),
        ),
    ]
    fruit = [
        Solid(sphere((-0.03, 0.038, -0.2), 0.038), plain(0.75)),
        Solid(sphere((0.05, 0.034, -0.17), 0.034), plain(0.5)),
        Solid(sphere((0.215, 0.106, 0.015), 0.034), plain(0.9)),
    ]
    solids = [
        Solid(plane((0, 1, 0), 0.0), grained(0.55, 0.25, 0.03)),
        Solid(plane((0, 0, -1), -0.42), striped(0.62, 0.8, (1, 0.0, 0), 0.16)),
        Solid(revolved((-0.22, 0, 0.08), VASE), striped(0.35, 0.95, (0, 1, 0), 0.06)),
        Solid(revolved((0.02, 0, 0.12), BUST), plain(0.85)),
        Solid(sphere((0.02, 0.235, 0.12), 0.062), plain(0.85)),
        Solid(revolved((-0.2, 0, -0.16), MUG), plain(0.6)),
        Solid(capsule((-0.265, 0.03, -0.16), (-0.265, 0.065, -0.16), 0.008), plain(0.6)),
        Solid(capsule((-0.4, 0.006, -0.05), (-0.28, 0.006, -0.27), 0.006), plain(0.15)),
        *books,
        *fruit,
    ]
    return view(
        solids,
        eye=(0.1, 0.52, -0.95),
        target=(-0.005, 0.09, 0.06),
        shape=shape,
        focal=1.15 * shape[1],
        lamp=(-0.7, 1.3, -0.8),
        exposure=1.25,
        name="still_life",
    )


def room(shape: tuple[int, int] = SHAPE) -> Frame:
    """A corner of a room at 1.5 to 4.5 m: table, chair, shelf with books, lamp, a picture."""
    legs = [
        Solid(capsule((x, 0.0, z), (x, 0.7, z), 0.022), plain(0.35))
        for x in (-0.75, 0.35)
        for z in (0.25, 0.85)
    ]
    shelf = [
        Solid(box((1.45, y, 1.9), (0.8, 0.025, 0.26)), grained(0.6, 0.2, 0.05))
        for y in (0.4, 0.8, 1.2, 1.6)
    ]
    sides = [Solid(box((x, 0.85, 1.9), (0.025, 1.6, 0.26)), plain(0.5)) for x in (1.05, 1.85)]
    rng = np.random.default_rng(7)
    books = [
        Solid(
            box((1.12 + 0.055 * k, y + 0.11, 1.9), (0.045, rng.uniform(0.16, 0.24), 0.18)),
            plain(rng.uniform(0.08, 0.9)),
        )
        for y in (0.41, 0.81, 1.21)
        for k in rng.permutation(12)[: rng.integers(6, 11)]
    ]
    chair = [
        Solid(box((-0.15, 0.45, -0.1), (0.42, 0.04, 0.42), turn=0.4, rounding=0.01), plain(0.7)),
        *(
            Solid(capsule((x, 0, z), (x, 0.44, z), 0.016), plain(0.3))
            for x, z in ((-0.4, -0.18), (-0.07, -0.34), (-0.23, 0.14), (0.1, -0.02))
        ),
        *(
            Solid(capsule((x, 0.45, z), (x, 0.92, z), 0.013), plain(0.3))
            for x, z in ((-0.4, -0.18), (-0.29, -0.235), (-0.18, -0.285), (-0.07, -0.34))
        ),
        Solid(capsule((-0.4, 0.92, -0.18), (-0.07, 0.92, -0.34), 0.025), plain(0.5)),
    ]
    solids = [
        Solid(plane((0, 1, 0), 0.0), checked(0.3, 0.6, 0.4)),
        Solid(plane((0, 0, -1), -2.1), plain(0.78)),
        Solid(plane((-1, 0, 0), -2.1), plain(0.6)),
        Solid(plane((0, -1, 0), -2.5), plain(0.9)),
        Solid(box((-0.2, 0.72, 0.55), (1.3, 0.04, 0.8), rounding=0.01), grained(0.65, 0.3, 0.06)),
        Solid(revolved((-0.5, 0.74, 0.6), VASE), striped(0.2, 0.9, (0, 1, 0), 0.05)),
        Solid(sphere((0.1, 0.8, 0.5), 0.06), plain(0.95)),
        Solid(box((-0.6, 1.5, 2.08), (0.8, 0.6, 0.05)), striped(0.1, 0.85, (1, 1, 0), 0.25)),
        Solid(capsule((-1.25, 0, 1.5), (-1.25, 1.45, 1.5), 0.018), plain(0.1)),
        Solid(revolved((-1.25, 1.4, 1.5), [(0.2, 0.0), (0.12, 0.28)]), plain(1.0)),
        *legs,
        *shelf,
        *sides,
        *books,
        *chair,
    ]
    return view(
        solids,
        eye=(0.75, 1.45, -2.1),
        target=(0.1, 0.85, 0.9),
        shape=shape,
        focal=0.9 * shape[1],
        lamp=(-0.9, 2.3, -1.2),
        ambient=0.35,
        exposure=1.4,
        name="room",
    )


def stairs(shape: tuple[int, int] = SHAPE) -> Frame:
    """A hallway at 1 to 7 m: stairs with a banister, a door frame, a tiled floor."""
    steps = [
        Solid(
            box((-0.65, 0.09 + 0.18 * k, 2.0 + 0.28 * k), (1.1, 0.18, 0.3)),
            grained(0.55, 0.25, 0.07),
        )
        for k in range(10)
    ]
    bars = [
        Solid(
            capsule(
                (-0.12, 0.18 * k, 2.0 + 0.28 * k), (-0.12, 0.18 * k + 0.95, 2.0 + 0.28 * k), 0.012
            ),
            plain(0.15),
        )
        for k in range(1, 10)
    ]
    rail = Solid(capsule((-0.12, 1.1, 2.2), (-0.12, 2.6, 4.52), 0.03), grained(0.4, 0.3, 0.05))
    frame = [Solid(box((x, 1.05, 3.1), (0.1, 2.1, 0.14)), plain(0.85)) for x in (0.25, 1.15)]
    solids = [
        Solid(plane((0, 1, 0), 0.0), checked(0.25, 0.7, 0.3)),
        Solid(plane((1, 0, 0), -1.2), striped(0.6, 0.75, (0, 0, 1), 0.3)),
        Solid(plane((-1, 0, 0), -1.25), plain(0.7)),
        Solid(plane((0, 0, -1), -6.2), plain(0.65)),
        Solid(plane((0, -1, 0), -2.9), plain(0.85)),
        Solid(box((0.7, 2.15, 3.1), (1.0, 0.1, 0.14)), plain(0.85)),
        Solid(box((0.95, 0.35, 1.4), (0.4, 0.7, 0.5), rounding=0.02), grained(0.5, 0.3, 0.09)),
        Solid(revolved((0.95, 0.7, 1.35), BUST), plain(0.8)),
        Solid(sphere((0.95, 0.935, 1.35), 0.062), plain(0.8)),
        rail,
        *steps,
        *bars,
        *frame,
    ]
    return view(
        solids,
        eye=(0.35, 1.5, -0.6),
        target=(0.0, 0.95, 2.5),
        shape=shape,
        focal=0.85 * shape[1],
        lamp=(0.4, 2.7, 0.6),
        ambient=0.4,
        exposure=1.6,
        name="stairs",
    )


CATALOGUE: dict[str, Callable[..., Frame]] = {
    scene.__name__: scene for scene in (still_life, room, stairs)
}


def main() -> None:
    """Trace every scene and store it in the package."""
    EMBEDDED.mkdir(exist_ok=True)
    for name, scene in CATALOGUE.items():
        scene().save(EMBEDDED / f"{name}.npz")


if __name__ == "__main__":
    main()
