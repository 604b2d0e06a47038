"""Relations between a measurement and a changed one that hold whatever the scene is."""

from functools import cache
from itertools import product

import numpy as np
import xarray as xr
from pytest import fixture, mark
from scores import scores

import cmtof
from cmtof.correlation import TAU
from cmtof.evaluation import measure_frame
from cmtof.measurement import Measurement

FAST = [
    "beat",
    "crt",
    "crt-closed-form",
    "crt-ml",
    "kde",
    "middle",
    "mrf",
    "phasor",
    "region",
    "spatial",
    "fast-scnn-light",
    "surfaces",
]
EDGE = 6  # px of junk around an image
# Share of wraps that stay under a change which a method knows of: a network was trained on images
# that stand upright, in the counts of the simulation; windows end otherwise where junk begins, and
# surfaces grow from cells that begin elsewhere.
LEAST = {"fast-scnn-light": 0.75, "surfaces": 0.8, "beat": 0.85}


@fixture(scope="module")
def scene():
    """Measurement of a part of the room with little noise, for any method."""
    frame = cmtof.load_frame("room").middle(96, 112)

    @cache
    def of(name, noise_free=False):
        return measure_frame(frame, [name], noise=300.0, noise_free=noise_free)[name]

    return of


def junk_around(data, fill):
    """The measurement amid masked junk, and its camera moved with it."""
    inside = xr.ones_like(data.depth, bool).pad(y=EDGE, x=EDGE, constant_values=False)
    found = data.pad({"y": EDGE, "x": EDGE}, constant_values=0)
    found["camera"] = found["camera"] + [0, 0, EDGE, EDGE]
    return found.assign(correlation=found.correlation.where(inside, fill))


COUNTS = {  # other counts of the same light
    "ambient light": lambda c: c + 1000,
    "float64": lambda c: c.astype(float),
    "uint16": lambda c: c.round().clip(0).astype("uint16"),
    "int32": lambda c: c.round().astype("int32"),
    "differences of two buckets": lambda c: (c - 9e3).astype("int16"),
    "counts x 1e-20": lambda c: 1e-20 * c,
    "counts x 1e+12": lambda c: 1e12 * c,
}
TOLD = {  # the same counts, told otherwise
    "steps in another order": lambda d: d.isel(step=[2, 0, 3, 1]),
    "psi a turn further": lambda d: d.assign_coords(
        psi=d.psi + TAU * np.array([1, -3, 0, 7])
    ),
    "truth removed": lambda d: d.drop_vars("depth"),
}


def wraps_of(name, *measurements):
    return [cmtof.unwrap(m, method=name)["wrap_count"] for m in measurements]


@mark.parametrize("relation", [*COUNTS, *TOLD])
@mark.parametrize("name", FAST)
def test_what_changes_no_information_changes_no_wrap(scene, name, relation):
    m = scene(name)
    if relation in COUNTS:
        counts = COUNTS[relation](m.dataset.correlation)
        changed = m.dataset.assign(correlation=counts)
    else:
        changed = TOLD[relation](m.dataset)
    usual, found = (cmtof.unwrap(one, method=name) for one in (m, Measurement(changed)))
    least = LEAST.get(name, 1) if relation.startswith("counts") else 0.98
    assert (usual.wrap_count == found.wrap_count).mean() > least - 0.02
    assert abs(usual.confidence.mean() - found.confidence.mean()) < 0.01


@mark.parametrize("fill", [0, np.nan, 9.97e36, 65535])
@mark.parametrize("name", sorted(set(FAST) - {"spatial"}))
def test_masked_junk_decides_nothing(scene, name, fill):
    m = scene(name)
    whole, amid = wraps_of(name, m, Measurement(junk_around(m.dataset, fill)))
    assert (whole == amid[EDGE:-EDGE, EDGE:-EDGE]).mean() > LEAST.get(name, 0.9)


@mark.parametrize("share", [0.01, 0.1])
@mark.parametrize("name", FAST)
def test_masked_holes_take_nothing_from_their_neighbours(scene, rng, name, share):
    m = scene(name)
    left = m.dataset.depth.copy(data=rng.uniform(size=m.shape) >= share)
    images = m.dataset.correlation.where(left, 0)
    holed = Measurement(m.dataset.assign(correlation=images, mask=m.mask & left))
    whole, found = (scores(one, method=name)["delta_lt_1"] for one in (m, holed))
    assert found > whole - 0.05


FLIPS = {  # each undoes itself
    "left and right": lambda d: d.isel(x=slice(None, None, -1)),
    "up and down": lambda d: d.isel(y=slice(None, None, -1)),
    "transposed": lambda d: d.rename(y="x", x="y").transpose(..., "y", "x"),
}


@mark.parametrize(
    "name, flip",
    [
        *product(FAST, FLIPS),
        ("fast-scnn-mirrored", "left and right"),
        ("fast-scnn-mirrored", "up and down"),
    ],
)
def test_a_mirrored_image_has_mirrored_wraps(scene, name, flip):
    m = Measurement(scene(name).dataset.drop_vars("camera"))
    whole, found = wraps_of(name, m, Measurement(FLIPS[flip](m.dataset)))
    assert (whole == FLIPS[flip](found)).mean() > LEAST.get(name, 0.98)


@mark.parametrize("by", [1e-4, 1e-3, 1e-2])
@mark.parametrize("name", sorted(set(FAST) - {"fast-scnn-light", "crt-closed-form"}))
def test_a_slightly_moved_range_moves_few_wraps(scene, name, by):
    """Of a network the weights end at a wrap; what lies outside ends there in the closed form."""
    # noise alone moves single pixels to the ends of the range
    pointwise = ["crt", "crt-ml", "crt-closed-form", "phasor", "middle"]
    m = scene(name, noise_free=name in pointwise)
    whole, found = wraps_of(name, m, m.between(*(end + by for end in m.range)))
    assert (whole == found).mean() > 0.95
