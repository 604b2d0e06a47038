"""Screens, sound and small machines."""

import numpy as np
import pytest
from furnishing import assert_made_well, draw

from cmtof.scenes.rooms import devices, screens

CATALOGUE = devices.CATALOGUE
LIMITS = {
    "monitor": ((0.25, 0.72), (0.05, 0.28), (0.26, 0.8)),
    "television": ((0.4, 1.3), (0.2, 0.45), (0.32, 0.85)),
    "keyboard": ((0.29, 0.62), (0.11, 0.14), (0.01, 0.04)),
    "laptop": ((0.29, 0.37), (0.2, 0.4), (0.18, 0.28)),
    "loudspeaker": ((0.14, 0.24), (0.15, 0.34), (0.2, 1.15)),
    "radio": ((0.19, 0.34), (0.07, 0.17), (0.14, 0.42)),
    "alarm_clock": ((0.07, 0.21), (0.03, 0.08), (0.04, 0.2)),
    "telephone": ((0.24, 0.32), (0.2, 0.25), (0.1, 0.17)),
    "printer": ((0.4, 0.49), (0.38, 0.56), (0.13, 0.42)),
    "camera_on_tripod": ((0.4, 0.85), (0.4, 0.85), (1.0, 1.7)),
    "table_fan": ((0.24, 0.42), (0.2, 0.35), (0.28, 0.6)),
    "desk_fan": ((0.14, 0.25), (0.15, 0.27), (0.15, 0.36)),
    "microwave": ((0.42, 0.54), (0.33, 0.46), (0.25, 0.31)),
    "kettle": ((0.18, 0.28), (0.13, 0.22), (0.19, 0.27)),
    "toaster": ((0.26, 0.36), (0.14, 0.19), (0.16, 0.25)),
    "coffee_machine": ((0.17, 0.3), (0.23, 0.4), (0.27, 0.37)),
    "blender": ((0.19, 0.26), (0.15, 0.2), (0.37, 0.42)),
    "sewing_machine": ((0.38, 0.44), (0.15, 0.2), (0.3, 0.36)),
    "hair_dryer": ((0.2, 0.28), (0.2, 0.3), (0.06, 0.1)),
    "game_controller": ((0.15, 0.2), (0.09, 0.13), (0.03, 0.07)),
}
"""Least and greatest width, depth and height, m."""


def test_everything_has_limits():
    assert set(LIMITS) == set(CATALOGUE)


@pytest.mark.parametrize("name", CATALOGUE)
def test_it_is_made_well(name, check_thing):
    assert_made_well(name, CATALOGUE[name], LIMITS[name], check_thing, budget=5000)


@pytest.mark.parametrize("width", [0.7, 1.0, 1.3])
def test_a_television_is_as_wide_as_asked(width):
    low, high = draw(screens.television, 1, width=width).bounds
    assert (high - low)[0] == pytest.approx(width, abs=1e-3)


def test_some_screens_shine_and_some_are_off():
    shining = [
        max(p.material.emission for p in draw(screens.monitor, seed).parts) for seed in range(16)
    ]
    assert min(shining) == 0
    assert max(shining) > 0.2


def test_keys_lie_side_by_side():
    keys = screens._keys(0.3, 0.12, 6, 15, 0.016, 0.004).vertices.reshape(-1, 24, 3)
    low, high = keys.min(1), keys.max(1)
    assert 70 < len(keys) < 95
    for i in range(len(keys)):
        x = (low[:, 0] < high[i, 0]) & (high[:, 0] > low[i, 0])
        y = (low[:, 1] < high[i, 1]) & (high[:, 1] > low[i, 1])
        assert (x & y).sum() == 1


@pytest.mark.parametrize(("digit", "bars"), list(enumerate([6, 2, 5, 5, 4, 5, 6, 3, 7, 6])))
def test_a_digit_has_its_segments(digit, bars):
    assert len(devices._digit(digit, 0.0, 0.0, 0.02, 0.04)) == bars


def test_blades_turn_within_their_cage():
    for seed in range(6):
        thing = draw(devices.CATALOGUE["table_fan"], seed)
        cage, blades = (max(thing.parts, key=lambda p: len(p.mesh.faces)), thing.parts[-2])
        reach = np.ptp(cage.mesh.vertices[:, 0])
        assert np.ptp(blades.mesh.vertices[:, 0]) < reach
        low, high = cage.mesh.vertices.min(0), cage.mesh.vertices.max(0)
        assert blades.mesh.vertices[:, 1].min() > low[1]
        assert blades.mesh.vertices[:, 1].max() < high[1] + 0.005
