"""What surfaces are made of: two colours, a pattern between them, and how they shine.

Patterns are evaluated in the part's own space (`cmtof.scenes.rooms.patterns`), so that marks on a
surface know nothing of its edges, and edges nothing of the marks.
"""

import colorsys
from dataclasses import dataclass, replace

import numpy as np

Colour = tuple[float, float, float]
"""Linear reflectance in red, green, blue, 0 to 1."""

PATTERNS = (
    "plain",
    "wood",
    "planks",
    "herringbone",
    "tiles",
    "bricks",
    "stripes",
    "checks",
    "noise",
    "weave",
    "marble",
    "terrazzo",
    "marks",
    "picture",
    "rug",
    "leaf",
    "dots",
)
"""Names of the patterns; a material's number is the position in this tuple."""


@dataclass(frozen=True)
class Material:
    """One surface.

    Attributes
    ----------
    colour, second : Colour
        The two ends between which the pattern mixes.
    pattern : str
        One of `PATTERNS`.
    scale : float
        Size of the pattern's repeat, m.
    specular : float
        Share of light that is mirrored instead of scattered, 0 to 1; at 0.9 only a faint diffuse
        part is left, as on chrome.
    gloss : float
        Phong exponent of the mirrored lobe: 10 satin, 80 lacquer, 1000 mirror.
    emission : float
        Radiance of a lamp's shade or a screen, in units of a white surface at irradiance 1.
    bump : float
        Depth of the relief that shading (never the range) shows, 0 to 1.
    """

    colour: Colour
    second: Colour = (0.5, 0.5, 0.5)
    pattern: str = "plain"
    scale: float = 0.1
    specular: float = 0.03
    gloss: float = 20.0
    emission: float = 0.0
    bump: float = 0.0

    def __post_init__(self) -> None:
        if self.pattern not in PATTERNS:
            raise ValueError(
                f"Expected a pattern out of {', '.join(PATTERNS)}, got {self.pattern!r}. "
                "Choose one."
            )


def hue(h: float, s: float, v: float) -> Colour:
    """Linear colour of hue, saturation and value, each 0 to 1 (value already linear)."""
    r, g, b = colorsys.hsv_to_rgb(h % 1.0, s, 1.0)
    return (r**2.2 * v, g**2.2 * v, b**2.2 * v)


def darker(colour: Colour, factor: float) -> Colour:
    """A colour times a factor, kept below 0.95."""
    return tuple(float(min(max(c * factor, 0.0), 0.95)) for c in colour)  # type: ignore[return-value]


@dataclass(frozen=True)
class Style:
    """What a household bought together: one wood, one metal, a few fabrics, an accent.

    Furniture takes its materials from here, so that a room looks chosen and not drawn by lot.
    """

    wood: Material
    second_wood: Material
    metal: Material
    fabric: Material
    second_fabric: Material
    leather: Material
    paint: Material
    """Lacquer of cupboards and doors."""
    accent: Material
    """A strong plain colour for small things."""
    trim: Material
    """Skirting boards, frames of doors and windows."""
    modern: float
    """0 for turned legs and panels, 1 for plain boards and steel."""


WOODS: tuple[tuple[Colour, Colour], ...] = (
    ((0.52, 0.36, 0.20), (0.36, 0.22, 0.11)),  # oak
    ((0.22, 0.11, 0.055), (0.12, 0.055, 0.028)),  # walnut
    ((0.62, 0.47, 0.30), (0.52, 0.37, 0.21)),  # pine
    ((0.68, 0.57, 0.43), (0.58, 0.46, 0.32)),  # birch
    ((0.055, 0.038, 0.028), (0.030, 0.021, 0.016)),  # wenge
    ((0.33, 0.13, 0.06), (0.20, 0.07, 0.03)),  # mahogany
    ((0.45, 0.42, 0.38), (0.33, 0.30, 0.27)),  # weathered grey
)
"""Early and late wood of seven timbers, linear."""


def wood(rng: np.random.Generator) -> Material:
    """A timber, oiled or lacquered."""
    light, dark = WOODS[int(rng.integers(len(WOODS)))]
    shade = float(rng.uniform(0.85, 1.15))
    return Material(
        darker(light, shade),
        darker(dark, shade),
        "wood",
        scale=float(rng.uniform(0.02, 0.06)),
        specular=float(rng.uniform(0.03, 0.12)),
        gloss=float(rng.uniform(15, 80)),
    )


def fabric(rng: np.random.Generator) -> Material:
    """A woven cover: plain, striped, checked or mottled."""
    value = float(rng.choice([0.05, 0.2, 0.45, 0.7]))
    base = hue(float(rng.uniform()), float(rng.uniform(0, 0.5)), value)
    pattern = str(rng.choice(["weave", "weave", "noise", "stripes", "checks", "dots"]))
    other = darker(base, float(rng.choice([0.6, 0.75, 1.35, 1.8])))
    scale = float(rng.uniform(0.004, 0.012) if pattern == "weave" else rng.uniform(0.03, 0.12))
    return Material(base, other, pattern, scale=scale, specular=0.0, bump=0.3)


def metal(rng: np.random.Generator) -> Material:
    """Chrome, brushed steel, brass, black powder coat or white lacquer."""
    kinds = (
        Material((0.60, 0.60, 0.62), specular=0.85, gloss=400.0),
        Material((0.42, 0.42, 0.43), specular=0.55, gloss=40.0),
        Material((0.62, 0.45, 0.18), specular=0.65, gloss=120.0),
        Material((0.02, 0.02, 0.02), specular=0.06, gloss=25.0),
        Material((0.78, 0.78, 0.76), specular=0.06, gloss=60.0),
    )
    return kinds[int(rng.integers(len(kinds)))]


def leather(rng: np.random.Generator) -> Material:
    """Black, brown, tan or off-white hide."""
    shades: tuple[Colour, ...] = (
        (0.02, 0.02, 0.02),
        (0.12, 0.055, 0.03),
        (0.36, 0.2, 0.1),
        (0.65, 0.6, 0.52),
    )
    colour = shades[int(rng.integers(len(shades)))]
    return Material(colour, darker(colour, 0.7), "noise", 0.015, specular=0.1, gloss=30.0, bump=0.4)


def paint(rng: np.random.Generator) -> Material:
    """White to grey lacquer, now and then a colour."""
    if rng.uniform() < 0.6:
        grey = float(rng.choice([0.82, 0.75, 0.5, 0.2, 0.05]))
        return Material((grey, grey, 0.97 * grey), specular=0.06, gloss=60.0)
    colour = hue(float(rng.uniform()), float(rng.uniform(0.2, 0.6)), float(rng.uniform(0.1, 0.6)))
    return Material(colour, specular=0.06, gloss=60.0)


def accent(rng: np.random.Generator) -> Material:
    """A strong plain colour: glazed, lacquered or matt."""
    colour = hue(float(rng.uniform()), float(rng.uniform(0.5, 0.95)), float(rng.uniform(0.05, 0.7)))
    shine = float(rng.choice([0.02, 0.08, 0.2]))
    return Material(colour, specular=shine, gloss=float(rng.uniform(20, 200)))


def ceramic(rng: np.random.Generator) -> Material:
    """Glazed ware: white to black, plain, dotted or banded."""
    grey = float(rng.choice([0.85, 0.7, 0.35, 0.06]))
    base = hue(float(rng.uniform()), float(rng.choice([0.0, 0.1, 0.5])), grey)
    pattern = str(rng.choice(["plain", "plain", "dots", "stripes", "marble"]))
    other = hue(float(rng.uniform()), 0.6, float(rng.uniform(0.05, 0.5)))
    scale = float(rng.uniform(0.02, 0.06))
    return Material(base, other, pattern, scale, specular=0.1, gloss=float(rng.uniform(60, 300)))


def style(rng: np.random.Generator) -> Style:
    """Draw what one household bought."""
    first = wood(rng)
    trim = Material((0.8, 0.8, 0.78), specular=0.05, gloss=50.0)
    if rng.uniform() < 0.3:
        trim = replace(first, specular=0.05)
    return Style(
        wood=first,
        second_wood=wood(rng),
        metal=metal(rng),
        fabric=fabric(rng),
        second_fabric=fabric(rng),
        leather=leather(rng),
        paint=paint(rng),
        accent=accent(rng),
        trim=trim,
        modern=float(rng.uniform()),
    )
