"""Fittings of the house: on their wall, of real size, alike for the same seed."""

from pickle import dumps

import numpy as np
import pytest

from cmtof.scenes.rooms.fittings import CATALOGUE, fireplace, radiator

STANDING = {"smoke_detector": "ceiling", "fireplace": "floor"}
LIMITS = {
    "radiator": (0.4, 1.8, 0.4, 0.9),
    "fireplace": (1.1, 1.8, 0.9, 1.4),
    "light_switch": (0.07, 0.1, 0.07, 0.25),
    "socket": (0.07, 0.35, 0.07, 0.35),
    "vent": (0.14, 0.36, 0.1, 0.26),
    "thermostat": (0.06, 0.13, 0.06, 0.1),
    "boiler": (0.38, 0.5, 0.9, 1.6),
    "pipes": (0.01, 0.6, 2.3, 2.5),
    "cable_duct": (0.9, 3.1, 0.029, 0.11),
    "skirting_heater": (0.7, 2.1, 0.15, 0.2),
    "smoke_detector": (0.07, 0.13, 0.02, 0.05),
}


@pytest.mark.parametrize("name", CATALOGUE)
@pytest.mark.parametrize("seed", range(4))
def test_fittings_hang_where_they_should_and_have_real_sizes(name, seed, style, check_thing):
    thing = CATALOGUE[name](np.random.default_rng(seed), style)
    if name == "fireplace":  # it stands against a wall with its slab before it
        assert thing.bounds[0, 2] == pytest.approx(0, abs=2e-3)
        assert thing.bounds[1, 1] == pytest.approx(0, abs=5e-3)
        check_thing(thing, standing="wall", triangles=3000)
    else:
        check_thing(thing, standing=STANDING.get(name, "wall"), triangles=3000)
    low, high = thing.bounds
    narrow, wide, short, tall = LIMITS[name]
    assert narrow <= high[0] - low[0] <= wide
    assert short <= high[2] - low[2] <= tall


@pytest.mark.parametrize("name", CATALOGUE)
def test_the_same_seed_makes_the_same_fitting(name, style):
    one, two = (dumps(CATALOGUE[name](np.random.default_rng(3), style)) for _ in range(2))
    assert one == two


@pytest.mark.parametrize("name", ["radiator", "fireplace", "socket", "pipes", "vent"])
def test_fittings_differ(name, style):
    made = [dumps(CATALOGUE[name](np.random.default_rng(seed), style)) for seed in range(8)]
    assert len(set(made)) > 5


@pytest.mark.parametrize("design", ["ribs", "panel", "ladder"])
def test_a_radiator_keeps_the_size_that_is_asked_for(design, style):
    rng = np.random.default_rng(0)
    made = radiator(rng, style, width=1.0, height=0.55, design=design)
    body = made.parts[0].mesh.vertices
    assert np.ptp(body[:, 0]) == pytest.approx(1.0, abs=0.05)
    assert np.ptp(body[:, 2]) == pytest.approx(0.55, abs=0.01)


def test_the_mantel_carries_things(style):
    made = fireplace(np.random.default_rng(1), style, width=1.3)
    (shelf,) = made.supports
    assert shelf.z == pytest.approx(made.bounds[1, 2], abs=1e-6)
    assert shelf.x1 - shelf.x0 > 1.2
