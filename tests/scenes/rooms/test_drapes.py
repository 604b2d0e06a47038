"""Curtains and blinds: hung from their rod, folded, within their drop."""

from pickle import dumps

import numpy as np
import pytest

from cmtof.scenes.rooms.drapes import CATALOGUE, curtains, venetian_blind


@pytest.mark.parametrize("name", CATALOGUE)
@pytest.mark.parametrize("seed", range(5))
def test_drapes_hang_before_the_wall(name, seed, style, check_thing):
    thing = CATALOGUE[name](np.random.default_rng(seed), style)
    check_thing(thing, standing="free", triangles=6000)
    low, high = thing.bounds
    assert -0.005 <= -high[1] < 0.03
    assert low[1] > -0.2
    assert high[2] < 0.06
    assert low[2] < -0.25


@pytest.mark.parametrize("name", CATALOGUE)
def test_the_same_seed_hangs_the_same_cloth(name, style):
    one, two = (dumps(CATALOGUE[name](np.random.default_rng(3), style)) for _ in range(2))
    assert one == two
    assert one != dumps(CATALOGUE[name](np.random.default_rng(4), style))


@pytest.mark.parametrize("name", CATALOGUE)
def test_drapes_are_as_wide_and_long_as_asked(name, style):
    made = CATALOGUE[name](np.random.default_rng(1), style, width=1.2, drop=1.0)
    low, high = made.bounds
    assert high[0] - low[0] == pytest.approx(1.2, abs=0.16)
    assert low[2] == pytest.approx(-1.0, abs=0.08)


def test_a_curtain_has_folds_that_grow_downwards(style):
    made = curtains(np.random.default_rng(6), style, width=2.0, drop=2.2, drawn=0.45)
    cloth = made.parts[0].mesh.vertices
    depth = [np.ptp(cloth[np.abs(cloth[:, 2] - z) < 0.15, 1]) for z in (-0.1, -2.0)]
    assert 0.01 < depth[0] < depth[1] < 0.15


def test_a_venetian_blind_has_at_most_40_slats(style):
    for seed in range(10):
        made = venetian_blind(np.random.default_rng(seed), style, drop=2.4)
        heights = np.unique(made.parts[0].mesh.vertices[:, 2].round(3))
        assert len(made.parts[0].mesh.faces) <= 40 * 16
        assert len(heights) > 20
