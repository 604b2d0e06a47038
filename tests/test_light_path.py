"""Geometry of the Poincaré sphere as it is drawn."""

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest

from cmtof import jones, light_path
from cmtof.modulator import DOUBLED, SINGLE


@pytest.fixture
def axes():
    matplotlib.use("Agg")
    figure, ax = plt.subplots()
    yield ax
    plt.close(figure)


@pytest.mark.parametrize("azimuth", [0.0, 0.7, 2.2])
def test_states_lie_on_the_sphere(azimuth):
    fields = SINGLE.states(np.linspace(-2, 2, 30))["EOM back"]
    x, depth = light_path.sphere_points(fields, azimuth=azimuth)
    height = jones.stokes(fields)[:, 1]
    np.testing.assert_allclose(x**2 + depth**2 + height**2, 1, atol=1e-12)


def test_height_of_a_trace_is_the_transmitted_intensity(axes):
    voltages = np.linspace(-0.7, 0.7, 41)
    fields = DOUBLED.states(voltages)["HWP back"]
    light_path.draw_trace(axes, fields, azimuth=2.2, colour="black", width=1)
    near, far = (np.asarray(line.get_ydata(), float) for line in axes.lines)
    height = np.where(np.isnan(near), far, near)
    np.testing.assert_allclose((1 + height) / 2, DOUBLED.transmission(voltages), atol=1e-12)


def test_returning_light_is_linear_and_turned_by_the_voltage():
    """Behind the QWP at 45 degrees the crystal acts as a rotator: S3 vanishes."""
    voltages = np.linspace(-1, 1, 21)
    s = jones.stokes(DOUBLED.states(voltages)["HWP back"])
    np.testing.assert_allclose(s[:, 3], 0, atol=1e-14)
    np.testing.assert_allclose(np.arctan2(s[:, 2], -s[:, 1]), 2 * voltages, atol=1e-12)


def test_ellipses_stay_inside_their_circle(axes):
    states = SINGLE.states(np.array([-0.26, 0, 0.26]))["EOM"]
    light_path.draw_ellipses(axes, states, centre=(3, -2), radius=0.45)
    for line in axes.lines:
        x, y = np.asarray(line.get_data(), float)
        assert np.hypot(x - 3, y + 2).max() <= 0.45 + 1e-12
