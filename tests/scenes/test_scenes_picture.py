"""Renderings of objects: brightness follows reflectance, lamps cast shadows, gloss shines."""

import numpy as np
import pytest

from cmtof.instrument.targets import MeshTarget, assembled
from cmtof.scenes.objects.picture import LAMP, picture


def wall(reflectance=0.5, z=1.0, half=2.0, **options):
    x, y = half * np.array([-1.0, 1, 1, -1]), half * np.array([-1.0, -1, 1, 1])
    corners = np.stack([x, y, np.full(4, z)], -1)
    return MeshTarget(corners, np.array([[0, 1, 2], [0, 2, 3]]), reflectance, **options)


def test_it_is_an_image_and_bright_where_the_lamp_is_near():
    seen = picture(assembled([wall()]), size=32, field_of_view=0.6)
    assert seen.shape == (32, 32)
    assert seen.min() > 0 and seen.max() <= 1
    assert seen[0, 0] > seen[-1, -1]  # the lamp is above, to the left


def test_dark_stays_dark():
    pale = np.where(np.arange(4) % 3 == 0, 0.8, 0.1)  # left and right
    seen = picture(assembled([wall(pale)]), size=16, field_of_view=0.6)
    assert seen[8, 0] > 1.1 * seen[8, -1]


def test_a_screen_casts_a_shadow():
    screen = wall(z=0.8, half=0.05)
    both = assembled([wall(), screen])
    alone, shaded = (picture(t, size=64, field_of_view=0.6) for t in (assembled([wall()]), both))
    # from the lamp through the screen's middle to the wall
    lamp, middle = np.array(LAMP), np.array([0.0, 0.0, 0.8])
    place = lamp + (middle - lamp) * (1.0 - lamp[2]) / (0.8 - lamp[2])
    focal = 32 / np.tan(0.3)
    column, row = (int(32 + focal * place[i]) for i in (0, 1))
    assert shaded[row, column] < 0.8 * alone[row, column]


def test_hidden_by_what_stands_between():
    both = assembled([wall(), wall(z=0.5, half=0.1)])
    points = np.array([[[0.0, 0.0, 1.0], [0.9, 0.0, 1.0]]])
    assert both.hidden(points, (0.0, 0.0, 0.0)).tolist() == [[True, False]]


@pytest.mark.parametrize("mirrored", [0.0, 1.0])
def test_polished_walls_have_a_highlight(mirrored):
    seen = picture(assembled([wall(material="mixed", mirrored=mirrored)]), size=64,
                   field_of_view=1.6)  # fmt: skip
    assert (np.ptp(seen) > 0.6) == bool(mirrored)
