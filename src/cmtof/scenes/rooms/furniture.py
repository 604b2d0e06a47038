"""All furniture by name, and what belongs to no room: ladders, racks, boards, fish tanks, m."""

import numpy as np

from cmtof.scenes.rooms import (
    bathroom,
    beds,
    hobbies,
    kitchen,
    seats,
    stands,
    storage,
    tables,
    worktables,
)
from cmtof.scenes.rooms.bicycles import wheel
from cmtof.scenes.rooms.cabinetry import BLACK, STEEL, Maker, add_fronts, carcass, look, timber
from cmtof.scenes.rooms.joinery import (
    beams,
    bent,
    boards,
    centred,
    copies,
    corners,
    frame,
    placed,
    plank,
    raised,
    rods,
)  # fmt: skip
from cmtof.scenes.rooms.materials import Material, Style, hue
from cmtof.scenes.rooms.solids import blob, joined, revolve, tube
from cmtof.scenes.rooms.thing import Mesh, Support, Thing
from cmtof.scenes.rooms.upholstery import cloth, covering, loft


def stepladder(rng: np.random.Generator, style: Style) -> Thing:
    """A folding ladder of three to seven treads, of wood or aluminium, standing open."""
    count = int(rng.integers(3, 8))
    rise = float(rng.uniform(0.22, 0.25))
    h, spread = rise * count, 0.13 * count + 0.1
    wooden = rng.uniform() < 0.4
    material = timber(rng, style) if wooden else STEEL
    low, top = 0.2 + 0.022 * count, 0.16
    stile = (0.022, 0.06)
    sides = beams(
        [(s * low, -spread, 0) for s in (-1, 1)], [(s * top, -0.06, h) for s in (-1, 1)], *stile
    )
    back = beams([(s * low, spread, 0) for s in (-1, 1)], [(s * (top - 0.01), 0.08,
        h - 0.03) for s in (-1, 1)],
                 0.02, 0.04)  # fmt: skip
    thing = Thing("stepladder").add(joined([sides, back]), material, 2)
    rows, bars = [], []
    for k in range(1, count + 1):
        z, f = rise * k, k / count
        half = low + (top - low) * f - 0.008
        y = -spread + (spread - 0.06) * f
        deep = 0.045 if k < count else 0.14
        rows.append(
            (-half, half, y - 0.04, y - 0.04 + 2 * deep, z - 0.022, z - 0.001 * (k < count))
        )
        if k < count and k % 2:
            yb = spread - (spread - 0.08) * f
            bars.append((-half, half, yb - 0.012, yb + 0.012, z - 0.025, z))
    rows[-1] = (rows[-1][0] - 0.03, rows[-1][1] + 0.03, -0.12, 0.14, h - 0.02, h + 0.004)
    treads = style.accent if not wooden and rng.uniform() < 0.3 else material
    thing.add(boards([*rows, *bars], 0.004), treads)
    mid = 0.45
    y0, y1 = -spread + (spread - 0.06) * mid, spread - (spread - 0.08) * mid
    half = low + (top - low) * mid
    thing.add(rods([(s * half, y0, mid * h) for s in (-1, 1)], [(s * half, y1,
        mid * h) for s in (-1, 1)], 0.005),
              STEEL)  # fmt: skip
    thing.supports.append(Support(-0.12, 0.12, -0.1, 0.12, h + 0.004, 0.6))
    return centred(thing)


def ironing_board(rng: np.random.Generator, style: Style) -> Thing:
    """A padded board, pointed at one end, on crossed tubes, with a rest for the iron."""
    length, w, h = (
        float(rng.uniform(1.1, 1.3)),
        float(rng.uniform(0.33, 0.42)),
        float(rng.uniform(0.78, 0.92)),
    )
    s = np.linspace(-1, 1, 25)
    half = (
        w / 2 * np.where(s < 0.2, 1.0, np.sqrt(np.clip(1 - ((s - 0.2) / 0.82) ** 2 * 0.94, 0, 1)))
    )
    half *= np.where(s < -0.9, np.sqrt(np.clip(1 - ((-0.9 - s) / 0.12) ** 2 * 0.7, 0.2, 1)), 1.0)
    u = np.linspace(-1, 1, 9)[:, None]
    top = np.empty((25, 9, 3))
    top[..., 0] = (s * length / 2)[:, None]
    top[..., 1] = half[:, None] * u.T
    top[..., 2] = h - 0.012 * np.abs(u.T) ** 6
    thing = Thing("ironing board").add(cloth(top, 0.028), style.fabric)
    x, tube_ = 0.36 * length, 0.011
    legs = rods([(-x, -0.03, 0.012), (x, 0.04, 0.012)], [(0.62 * x, -0.03, h - 0.03), (-0.7 * x,
        0.04, h - 0.03)],
                tube_)  # fmt: skip
    second = rods([(-x, -0.1, 0.012), (x, 0.11, 0.012)], [(0.62 * x, -0.1, h - 0.03), (-0.7 * x,
        0.11, h - 0.03)],
                  tube_)  # fmt: skip
    feet = rods([(-x, -0.2, 0.012), (x, -0.2, 0.012)], [(-x, 0.2, 0.012), (x, 0.2, 0.012)], 0.012)
    end = -length / 2
    rest = bent([(end + 0.05, -0.12, h - 0.03), (end - 0.2, -0.12, h - 0.03), (end - 0.2, 0.12,
        h - 0.03),
                 (end + 0.05, 0.12, h - 0.03)], 0.03)  # fmt: skip
    bars = rods([(end - q, -0.12, h - 0.03) for q in (0.05, 0.1, 0.15)], [(end - q, 0.12,
        h - 0.03) for q in
                (0.05, 0.1, 0.15)], 0.004, sides=6)  # fmt: skip
    metal = style.metal if rng.uniform() < 0.5 else STEEL
    thing.add(joined([legs, second, feet, tube(rest, 0.006, 6), bars]), metal)
    thing.supports.append(Support(-0.35 * length, 0.1 * length, -0.3 * w, 0.3 * w, h, 0.5))
    return centred(thing)


def wine_rack(rng: np.random.Generator, style: Style) -> Thing:
    """Scalloped rails on posts with bottles lying in some places."""
    nx, nz = int(rng.integers(4, 7)), int(rng.integers(3, 7))
    step, rise, d = 0.105, 0.13, 0.24
    w, h = nx * step + 0.03, nz * rise + 0.03
    x, material = w / 2, timber(rng, style)
    place = corners(x - 0.012, d / 2 - 0.012)
    thing = Thing("wine rack").add(beams(place, raised(place, h), 0.022, 0.022), material, 2)
    at = (np.arange(nx) - (nx - 1) / 2) * step
    z = 0.05 + rise * np.arange(nz)
    s = np.linspace(-x + 0.02, x - 0.02, 6 * nx + 1)
    dip = -0.018 * np.cos(2 * np.pi * (s - at[0]) / step)
    rail = plank(np.stack([s, 0 * s, dip], -1), (0, 0.018, 0), 0.02)
    spots = [(0, y, float(q)) for q in z for y in (-d / 2 + 0.012, d / 2 - 0.012)]
    thing.add(copies(rail, spots), material)
    sides = [(t * (x - 0.012) - 0.008, t * (x - 0.012) + 0.008, -d / 2 + 0.02, d / 2 - 0.02,
        q - 0.01, q + 0.01)
             for t in (-1, 1) for q in (z[0], z[-1] + 0.06)]  # fmt: skip
    thing.add(boards(sides), material)
    taken = [(a, q) for q in z for a in at if rng.uniform() < 0.4]
    if taken:
        _bottles(thing, rng, np.array(taken))
    return thing


def _bottles(thing: Thing, rng: np.random.Generator, places: np.ndarray) -> None:
    """Bottles lying with their necks forwards at (x, z), in green or brown glass, with foils."""
    body = revolve([(0, 0.004), (0.03, 0), (0.0375, 0.006), (0.0375, 0.19), (0.03, 0.22), (0.014,
        0.25),
                    (0.0135, 0.25)], 10)  # fmt: skip
    foil = revolve([(0.0142, 0.245), (0.0145, 0.3), (0, 0.301)], 8)
    lift = 0.0375 - 0.006
    at = np.column_stack([places[:, 0], np.full(len(places), 0.11), places[:, 1] + lift])
    tone = (0.02, 0.05, 0.02) if rng.uniform() < 0.6 else (0.04, 0.02, 0.01)
    glass = Material(tone, specular=0.25, gloss=300.0)
    thing.add(copies(placed(body, lean=np.pi / 2), at), glass)
    colour = hue(float(rng.uniform()), 0.7, float(rng.uniform(0.1, 0.4)))
    thing.add(copies(placed(foil, lean=np.pi / 2), at), Material(colour, specular=0.3, gloss=60.0))


def fish_tank(rng: np.random.Generator, style: Style) -> Thing:
    """An aquarium on a cabinet: frame and hood, gravel, stones and plants; its glass left out."""
    w, d = float(rng.uniform(0.6, 1.1)), float(rng.uniform(0.34, 0.45))
    base, tall = float(rng.uniform(0.6, 0.75)), float(rng.uniform(0.36, 0.5))
    x, y = (-w / 2, w / 2), (-d / 2 + 0.02, d / 2)
    material = timber(rng, style)
    thing = Thing("fish tank").add(carcass(x, y, (0.05, base)), material)
    plinth = (x[0] + 0.01, x[1] - 0.01, y[0] + 0.03, y[1] - 0.01, 0, 0.051)
    thing.add(boards([plinth], 0), BLACK)
    fronts = [
        ("left", (x[0], 0.0), (0.052, base - 0.019)),
        ("right", (0.0, x[1]), (0.052, base - 0.019)),
    ]
    add_fronts(thing, fronts, y[0], look(rng, style, material))
    t, top = 0.016, base + tall
    posts = [(sx - t * (sx > 0), sx + t * (sx < 0), sy - t * (sy > 0), sy + t * (sy < 0), base, top)
             for sx in (x[0] + 0.005, x[1] - 0.005) for sy in (y[0] + 0.005,
                 y[1] - 0.005)]  # fmt: skip
    edge = [(x[0] + 0.003, x[1] - 0.003, *e, z, z + 0.03) for z in (base + 0.0006, top - 0.03)
            for e in ((y[0] + 0.003, y[0] + 0.018), (y[1] - 0.018, y[1] - 0.003))]  # fmt: skip
    hood = (x[0], x[1], y[0], y[1], top - 0.001, top + 0.055)
    thing.add(boards([*posts, *edge], 0), BLACK).add(boards([hood], 0.008), BLACK)
    u, v = np.meshgrid(np.linspace(x[0] + 0.02, x[1] - 0.02, 25), np.linspace(y[0] + 0.02,
        y[1] - 0.02, 13),
                       indexing="ij")  # fmt: skip
    bumps = 0.012 * np.sin(9 * u + 4 * v) + 0.01 * np.sin(17 * u - 11 * v + 1)
    ground = base + 0.05 + 0.08 * (v - y[0]) / d * 0.6 + bumps
    gravel = Material((0.4, 0.33, 0.24), (0.12, 0.1, 0.08), "terrazzo", 0.008, 0.0)
    thing.add(cloth(np.stack([u, v, ground], -1), 0.02), gravel)
    back = (x[0] + 0.018, x[1] - 0.018, y[1] - 0.012, y[1] - 0.008, base + 0.03, top - 0.03)
    thing.add(
        boards([back], 0), Material(hue(0.6, 0.6, 0.12), hue(0.45, 0.6, 0.1), "noise", 0.2, 0.0)
    )
    _underwater(thing, rng, w, d, base + 0.06, tall)
    thing.supports.append(
        Support(x[0] + 0.05, x[1] - 0.05, y[0] + 0.04, y[1] - 0.04, top + 0.055, 0.3)
    )
    return thing


def _underwater(
    thing: Thing, rng: np.random.Generator, w: float, d: float, z: float, tall: float
) -> None:
    """Stones, ribbons of weed, a few fish."""
    stones = [placed(blob(rng, rng.uniform(0.06, 0.13, 3), roughness=0.25, subdivisions=2),
              (float(rng.uniform(-0.38, 0.38)) * w, float(rng.uniform(-0.2, 0.25)) * d, z - 0.01))
              for _ in range(3)]  # fmt: skip
    thing.add(joined(stones), Material((0.2, 0.19, 0.18), (0.1, 0.1, 0.1), "noise", 0.03, 0.02))
    blades, count = [], int(rng.integers(8, 16))
    t = np.linspace(0, 1, 6)
    for _ in range(count):
        px, py = float(rng.uniform(-0.42, 0.42)) * w, float(rng.uniform(-0.05, 0.35)) * d
        high, bow = float(rng.uniform(0.35, 0.8)) * (tall - 0.12), rng.normal(0, 0.03, 2)
        sway = 0.012 * np.sin(5 * t + rng.uniform(0, 6))
        path = np.stack([px + bow[0] * t**2 + sway, py + bow[1] * t**2, z - 0.01 + high * t], -1)
        blades.append(plank(path, (0.014 * float(rng.uniform(0.6, 1.3)), 0.004, 0), 0.0012))
    thing.add(joined(blades), Material((0.08, 0.22, 0.05), (0.04, 0.12, 0.02), "leaf", 0.03, 0.05))
    fish = revolve([(0, -0.028), (0.006, -0.02), (0.011, 0.0), (0.008, 0.018), (0, 0.03)], 10)
    tail = prism_fin()
    school = [placed(joined([fish, tail]), (float(rng.uniform(-0.4, 0.4)) * w,
        float(rng.uniform(-0.3, 0.0)) * d,
              z + float(rng.uniform(0.3, 0.8)) * (tall - 0.12)),
                  tilt=np.pi / 2 * float(rng.choice([-1, 1])),
              turn=float(rng.normal(0, 0.4))) for _ in range(int(rng.integers(3, 8)))]  # fmt: skip
    thing.add(joined(school), Material((0.7, 0.22, 0.03), specular=0.1, gloss=60.0))


def prism_fin() -> Mesh:
    """Tail of a small fish that swims up the z axis."""
    return plank([(0, 0, -0.024), (0, 0, -0.034), (0, 0, -0.046)], [(0.004, 0, 0), (0.014, 0, 0),
        (0.024, 0, 0)],
                 0.0015)  # fmt: skip


def pram(rng: np.random.Generator, style: Style) -> Thing:
    """A carriage for a baby: a tub with a folding hood on four wheels, a handle, a blanket."""
    low, rim = 0.46, 0.68
    rows = [(0.19, low), (0.05, low), (0.0, low + 0.08), (0.0, rim - 0.004), (0.006, rim),
            (0.016, rim - 0.004), (0.02, low + 0.1), (0.06, low + 0.04), (0.19,
                low + 0.035)]  # fmt: skip
    cover = style.accent if rng.uniform() < 0.5 else style.second_fabric
    thing = Thing("pram").add(loft(0.38, 0.8, 0.15, rows, corner=7), cover)
    turn = np.linspace(0.05, np.pi - 0.05, 13)
    folds = np.linspace(0.0, 0.46 * np.pi, 9)
    hood = np.empty((9, 13, 3))
    bulge = 1 - 0.05 * (np.arange(9) % 2)
    reach = np.cos(folds)[:, None] * bulge[:, None] * np.sin(turn)
    rise = np.sin(folds)[:, None] * bulge[:, None] * np.sin(turn)
    hood[..., 0] = 0.195 * np.cos(turn)
    hood[..., 1], hood[..., 2] = 0.12 + 0.29 * reach, rim + 0.005 + 0.3 * rise
    thing.add(cloth(hood[:, ::-1], 0.006), cover)
    spots = np.array([(s * 0.25, t * 0.3) for s in (-1, 1) for t in (-1, 1)])
    radius = float(rng.choice([0.12, 0.16]))
    tyre, spokes = wheel(radius, 12)
    places = np.column_stack([spots, np.full(4, radius)])
    axles = rods([(-0.25, y, radius) for y in (-0.3, 0.3)], [(0.25, y, radius) for y in (-0.3,
        0.3)],
                 0.008)  # fmt: skip
    struts = [((s * 0.2, -t * 0.3, radius), (s * 0.19, t * 0.2, low + 0.04))
              for s in (-1, 1) for t in (-1, 1)]  # fmt: skip
    ends = np.array(struts)
    bar = [(-0.2, 0.1, 0.42), (-0.2, -0.45, 0.98), (0.2, -0.45, 0.98), (0.2, 0.1, 0.42)]
    frame_ = joined([axles, rods(ends[:, 0], ends[:, 1], 0.01), tube(bent(bar, 0.06), 0.011, 8),
                     copies(spokes, places)])  # fmt: skip
    thing.add(copies(tyre, places), BLACK).add(frame_, style.metal)
    blanket = covering(rng, (-0.15, 0.15), (-0.34, 0.08), rim - 0.06, (0, 0, 0, 0), thickness=0.02,
                       puff=0.03)  # fmt: skip
    return centred(thing.add(blanket, style.fabric))


def pinboard(rng: np.random.Generator, style: Style) -> Thing:
    """Cork or felt in a frame on the wall, with notes, cards and pins."""
    w, h = float(rng.uniform(0.5, 1.2)), float(rng.uniform(0.4, 0.8))
    t = float(rng.uniform(0.015, 0.035))
    rim = (timber(rng, style), style.metal)[int(rng.integers(2))]
    cork = Material((0.42, 0.27, 0.14), (0.2, 0.11, 0.05), "terrazzo", 0.006, 0.0)
    ground = cork if rng.uniform() < 0.7 else style.second_fabric
    thing = Thing("pinboard").add(frame((-w / 2, w / 2), (-0.02, 0), (-h / 2, h / 2), t), rim)
    x, z = w / 2 - t, h / 2 - t
    thing.add(boards([(-x - 0.002, x + 0.002, -0.012, -0.003, -z - 0.002, z + 0.002)], 0), ground)
    pins = []
    for k in range(int(rng.integers(3, 12))):
        pw, ph = sorted(rng.uniform(0.06, 0.2, 2))
        if rng.uniform() < 0.4:
            pw, ph = ph, pw
        pw, ph = min(pw, x), min(ph, z)
        at = (float(rng.uniform(-x + pw / 2, x - pw / 2)), -0.0135 - 0.0008 * k,
              float(rng.uniform(-z + ph, z)))  # fmt: skip
        curl = np.linspace(0, 1, 5)
        path = np.stack([0 * curl, -0.012 * curl**2 * rng.uniform(0.2, 1), -ph * curl], -1)
        tone = hue(float(rng.uniform()), float(rng.choice([0.03, 0.03, 0.5])), 0.75)
        pattern = str(rng.choice(["marks", "marks", "picture", "plain"]))
        paper = Material(tone, (0.04, 0.04, 0.07), pattern, float(rng.uniform(0.006, 0.03)), 0.0)
        note = plank(path, (-pw, 0, 0), 0.0006)
        thing.add(placed(note, at, tilt=float(rng.normal(0, 0.08))), paper)
        pins.append((at[0], at[1] - 0.0003, at[2] - 0.012))
    pin = revolve([(0, 0), (0.004, 0), (0.003, 0.006), (0.0055, 0.009), (0, 0.011)], 10)
    thing.add(copies(placed(pin, lean=np.pi / 2), pins), style.accent)
    return thing


CATALOGUE: dict[str, Maker] = {
    **tables.CATALOGUE,
    **worktables.CATALOGUE,
    **seats.CATALOGUE,
    **storage.CATALOGUE,
    **stands.CATALOGUE,
    **beds.CATALOGUE,
    **kitchen.CATALOGUE,
    **bathroom.CATALOGUE,
    **hobbies.CATALOGUE,
    "stepladder": stepladder,
    "ironing_board": ironing_board,
    "wine_rack": wine_rack,
    "fish_tank": fish_tank,
    "pinboard": pinboard,
    "pram": pram,
}
