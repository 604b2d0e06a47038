"""Floors, walls and ceilings: which material a room is finished with."""

from dataclasses import dataclass

import numpy as np

from cmtof.scenes.rooms.materials import Colour, Material, Style, darker, hue, wood

WET = ("bathroom", "kitchen")


@dataclass(frozen=True)
class Finish:
    """Materials of one room; ``grain`` as in `cmtof.scenes.rooms.thing.Part`."""

    floor: Material
    floor_grain: int
    wall: Material
    wall_grain: int
    accent_wall: Material
    accent_grain: int
    ceiling: Material
    trim: Material
    lining: Material | None
    """Tiles or boards on the lower part of the walls."""
    lining_height: float
    lining_grain: int


def finish(rng: np.random.Generator, style: Style, kind: str) -> Finish:
    """Draw the materials of a room of that kind."""
    floor = floor_material(rng, style, kind)
    wall, wall_grain = wall_material(rng, style, kind)
    accent, accent_grain = wall, wall_grain
    if rng.uniform() < 0.35:
        accent, accent_grain = accent_material(rng, style)
    lining, height, lining_grain = _lining(rng, style, kind)
    grey = float(rng.uniform(0.78, 0.88))
    ceiling = Material((grey, grey, 0.98 * grey), specular=0.0)
    if rng.uniform() < (0.5 if kind == "attic" else 0.1):
        ceiling = _boards(style.wood, float(rng.uniform(0.09, 0.16)))
    trim = style.trim
    return Finish(
        floor,
        int(rng.integers(2)),
        wall,
        wall_grain,
        accent,
        accent_grain,
        ceiling,
        trim,
        lining,
        height,
        lining_grain,
    )


def floor_material(rng: np.random.Generator, style: Style, kind: str) -> Material:
    """Planks, herringbone, tiles, carpet, concrete, stone or terrazzo."""
    dry = ["planks", "planks", "planks", "herringbone", "carpet", "tiles", "stone"]
    choice = str(rng.choice(dry))
    if kind in WET or kind == "hallway":
        choice = str(rng.choice(["tiles", "tiles", "chequered", "stone", "terrazzo", "planks"]))
    elif kind == "workshop":
        choice = str(rng.choice(["concrete", "concrete", "planks", "tiles"]))
    elif kind == "office":
        choice = str(rng.choice(["planks", "carpet", "carpet", "concrete", "tiles"]))
    if choice == "planks":
        return _boards(_timber(rng, style), float(rng.uniform(0.08, 0.20)))
    if choice == "herringbone":
        return _boards(_timber(rng, style), float(rng.uniform(0.06, 0.12)), "herringbone")
    if choice == "carpet":
        return _carpet(rng)
    return _mineral(rng, choice)


def _timber(rng: np.random.Generator, style: Style) -> Material:
    return style.second_wood if rng.uniform() < 0.5 else wood(rng)


def _boards(timber: Material, width: float, pattern: str = "planks") -> Material:
    """Boards of a timber, ``width`` m wide."""
    return Material(
        timber.colour, timber.second, pattern, width, timber.specular, timber.gloss, bump=0.2
    )


def _carpet(rng: np.random.Generator) -> Material:
    value = float(rng.choice([0.06, 0.15, 0.3, 0.5]))
    colour = hue(float(rng.uniform()), float(rng.uniform(0, 0.25)), value)
    pattern = str(rng.choice(["noise", "weave", "weave"]))
    scale = float(rng.uniform(0.008, 0.02))
    return Material(colour, darker(colour, 0.7), pattern, scale, specular=0.0, bump=0.5)


def _mineral(rng: np.random.Generator, choice: str) -> Material:
    """Tiles, slabs, terrazzo or poured concrete, warm or cold, from white to black."""
    value = float(rng.choice([0.05, 0.12, 0.25, 0.45, 0.65, 0.78]))
    colour = hue(float(rng.uniform(0.05, 0.15)), float(rng.uniform(0, 0.35)), value)
    grout: Colour = darker(colour, float(rng.choice([0.5, 0.6, 1.5])))
    shine = float(rng.choice([0.03, 0.08, 0.15]))
    gloss = float(rng.uniform(30, 200))
    if choice == "chequered":
        dark = (0.04, 0.04, 0.04) if value > 0.2 else (0.75, 0.74, 0.7)
        return Material(colour, dark, "checks", float(rng.choice([0.15, 0.2, 0.3])), shine, gloss)
    if choice == "terrazzo":
        return Material(colour, darker(colour, 0.4), "terrazzo", 0.025, shine, gloss)
    if choice == "concrete":
        grey = float(rng.uniform(0.2, 0.45))
        base = (grey, grey, 0.97 * grey)
        return Material(base, darker(base, 0.75), "noise", 0.35, specular=0.05, gloss=30.0)
    if choice == "stone":
        return Material(colour, darker(colour, 0.65), "marble", 0.4, shine, gloss)
    size = float(rng.choice([0.1, 0.2, 0.3, 0.4, 0.6]))
    return Material(colour, grout, "tiles", size, shine, gloss, bump=0.15)


def plaster(rng: np.random.Generator) -> Material:
    """Emulsion: mostly white, sometimes tinted, now and then dark."""
    value = float(
        rng.choice(
            [0.85, 0.8, 0.72, 0.6, 0.4, 0.18, 0.07], p=[0.28, 0.22, 0.18, 0.14, 0.1, 0.05, 0.03]
        )
    )
    tint = float(rng.uniform(0, 0.05) if rng.uniform() < 0.65 else rng.uniform(0.05, 0.2))
    warm = float(rng.uniform(0.04, 0.16) if rng.uniform() < 0.55 else rng.uniform())
    return Material(hue(warm, tint, value), specular=0.0)


def wall_material(rng: np.random.Generator, style: Style, kind: str) -> tuple[Material, int]:
    """Paint in most rooms; wallpaper, bricks, tiles, boards or concrete in the others."""
    roll = float(rng.uniform())
    if kind == "bathroom" and roll < 0.5:
        return _wall_tiles(rng), 0
    if kind == "workshop" and roll < 0.5:
        return (bricks(rng), 0) if roll < 0.25 else (_mineral(rng, "concrete"), 0)
    if roll < 0.68:
        return plaster(rng), 0
    if roll < 0.9 and kind not in WET:
        return wallpaper(rng), 2
    if roll < 0.93:
        return bricks(rng), 0
    return (_mineral(rng, "concrete"), 0) if roll < 0.96 else (plaster(rng), 0)


def accent_material(rng: np.random.Generator, style: Style) -> tuple[Material, int]:
    """What one wall of a room may have that the others have not."""
    choice = int(rng.integers(5))
    if choice == 0:
        value = float(rng.choice([0.05, 0.15, 0.35]))
        return Material(
            hue(float(rng.uniform()), float(rng.uniform(0.1, 0.45)), value), specular=0.0
        ), 0
    if choice == 1:
        return wallpaper(rng), 2
    if choice == 2:
        return bricks(rng), 0
    if choice == 3:
        return _boards(style.wood, float(rng.uniform(0.08, 0.2))), int(rng.choice([0, 2]))
    return _mineral(rng, "concrete"), 0


def wallpaper(rng: np.random.Generator) -> Material:
    """Stripes, dots or a mottled print."""
    value = float(rng.choice([0.2, 0.45, 0.65, 0.78]))
    colour = hue(float(rng.uniform()), float(rng.uniform(0.02, 0.18)), value)
    pattern = str(rng.choice(["stripes", "dots", "noise", "rug"]))
    factor = float(rng.choice([0.6, 0.8, 1.25]))
    return Material(colour, darker(colour, factor), pattern, float(rng.uniform(0.05, 0.2)), 0.0)


def bricks(rng: np.random.Generator) -> Material:
    """Facing bricks 21 cm by 6.5 cm and a joint: red, yellow, whitewashed or dark."""
    tones: tuple[Colour, ...] = (
        (0.38, 0.13, 0.07),
        (0.5, 0.36, 0.2),
        (0.75, 0.73, 0.7),
        (0.08, 0.07, 0.07),
    )
    tone = tones[int(rng.integers(len(tones)))]
    joint = float(rng.uniform(0.3, 0.6))
    return Material(tone, (joint, joint, 0.95 * joint), "bricks", 0.22, 0.0, bump=0.6)


def _wall_tiles(rng: np.random.Generator) -> Material:
    value = float(rng.choice([0.1, 0.45, 0.7, 0.82]))
    colour = hue(float(rng.uniform()), float(rng.uniform(0, 0.2)), value)
    pattern = str(rng.choice(["tiles", "tiles", "bricks"]))
    size = float(rng.choice([0.1, 0.15, 0.2, 0.3]))
    return Material(colour, darker(colour, 0.55), pattern, size, 0.1, 120.0, bump=0.15)


def _lining(
    rng: np.random.Generator, style: Style, kind: str
) -> tuple[Material | None, float, int]:
    """Lower part of the walls: material, height, grain."""
    roll, height = float(rng.uniform()), float(rng.uniform(0.85, 1.35))
    if kind in WET:
        tall = float(rng.uniform(1.4, 2.05)) if rng.uniform() < 0.5 else height
        return (_wall_tiles(rng), tall, 0) if roll < 0.6 else (None, 0.0, 0)
    if roll < 0.07:
        return _boards(style.wood, float(rng.uniform(0.08, 0.12))), height, 2
    if roll < 0.17:
        return style.trim, height, 0
    return None, 0.0, 0


def facade(rng: np.random.Generator) -> Material:
    """What houses look like from outside."""
    if rng.uniform() < 0.5:
        return bricks(rng)
    value = float(rng.choice([0.3, 0.5, 0.7]))
    base = hue(float(rng.uniform(0.02, 0.18)), float(rng.uniform(0, 0.4)), value)
    return Material(base, darker(base, 0.85), "noise", 0.3, 0.0)
