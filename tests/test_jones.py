"""Jones calculus: known actions of the elements. In test_modulator they conserve energy."""

from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from pytest import approx
from scipy.spatial.transform import Rotation

from cmtof import jones

angle = st.floats(-10, 10, allow_subnormal=False)
ratio = st.floats(1.5, 1e6)


def rotation(angle):
    return Rotation.from_euler("z", angle).as_matrix()[:2, :2]


@given(angle, angle)
def test_retarder_is_its_diagonal_form_turned_by_its_angle(retardance, axis):
    turned = rotation(axis) @ jones.eom(retardance) @ rotation(-axis)
    assert_allclose(jones.retarder(retardance, axis), turned, atol=1e-14)


@given(ratio, ratio)
def test_beam_splitter_has_the_extinction_ratios_asked_for(transmitted, reflected):
    settings = {
        "transmitted_extinction": transmitted,
        "reflected_extinction": reflected,
    }
    through = abs(jones.polarising_beam_splitter("transmitted", **settings)) ** 2
    aside = abs(jones.polarising_beam_splitter("reflected", **settings)) ** 2
    assert through[0, 0] / through[1, 1] == approx(transmitted, rel=1e-6)
    assert aside[1, 1] / aside[0, 0] == approx(reflected, rel=1e-6)
