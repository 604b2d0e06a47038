"""Parallel planes through points, the height of a step, and R^2 in closed form."""

import numpy as np
import pytest

from cmtof.ranging.plane_fit import (
    depth_spread,
    fit_planes,
    noise_from_r_squared,
    r_squared_from_noise,
    step_height,
)


def cloud(rng, slopes=(0.3, -0.2), offsets=(1.0,), noise=0.0, count=400, extents=(0.2, 0.1)):
    x, y = (rng.uniform(-0.5, 0.5, (2, count)).T * extents).T
    group = np.arange(count) % len(offsets)
    z = slopes[0] * x + slopes[1] * y + np.take(offsets, group) + noise * rng.normal(size=count)
    return np.column_stack([x, y, z]), group


def test_exact_planes_are_found():
    points, group = cloud(np.random.default_rng(0), offsets=(1.0, 0.9995))
    fit = fit_planes(points, group)
    np.testing.assert_allclose(fit.slopes, [0.3, -0.2], atol=1e-12)
    np.testing.assert_allclose(fit.offsets, [1.0, 0.9995], atol=1e-12)
    np.testing.assert_allclose(fit.residual, 0, atol=1e-12)
    assert fit.r_squared == pytest.approx(1)
    height, error = step_height(fit)
    assert height == pytest.approx(5e-4 / np.sqrt(1 + 0.3**2 + 0.2**2))
    assert error < 1e-10


def test_the_height_does_not_change_when_the_blocks_are_turned():
    rng = np.random.default_rng(1)
    points, group = cloud(rng, slopes=(0.0, 0.0), offsets=(0.0, -5e-4), noise=1e-9)
    angle = 0.2
    turn = np.array([[np.cos(angle), 0, -np.sin(angle)], [0, 1, 0],
                     [np.sin(angle), 0, np.cos(angle)]])  # fmt: skip
    flat, turned = (step_height(fit_planes(p, group))[0] for p in (points, points @ turn.T))
    assert turned == pytest.approx(flat, rel=1e-5)


def test_the_standard_error_is_that_of_repeats():
    """400 repeats: a standard deviation is known to 3.5 %, one sigma; allowed are three."""
    rng = np.random.default_rng(2)
    points, _ = cloud(rng, count=60)
    group = (points[:, 0] > 0).astype(int)  # side by side, so that the slope matters
    fits = []
    for _ in range(400):
        noisy = points + 1e-5 * rng.normal(size=(60, 1)) * [0, 0, 1]
        fits.append(step_height(fit_planes(noisy, group)))
    heights, errors = np.array(fits).T
    assert heights.std(ddof=1) == pytest.approx(np.sqrt((errors**2).mean()), rel=0.11)


def test_r_squared_of_many_points_is_its_closed_form():
    rng = np.random.default_rng(3)
    slopes, extents, noise = (0.3, -0.2), (0.2, 0.1), 1e-3
    points, _ = cloud(rng, slopes, noise=noise, count=100_000, extents=extents)
    spread = depth_spread(slopes, extents)
    # 1 - R^2 is a ratio of variances of 1e5 points each: known to 0.6 %, one sigma
    expected = 1 - r_squared_from_noise(noise, spread)
    assert 1 - fit_planes(points).r_squared == pytest.approx(expected, rel=0.02)


def test_the_same_noise_gives_any_r_squared():
    spread = depth_spread(np.column_stack([[1e-4, 1e-2, 1.0], np.zeros(3)]), [0.2, 0.2])
    share = r_squared_from_noise(3e-5, spread)
    assert share[0] < 0.05
    assert share[2] > 0.999999
    np.testing.assert_allclose(noise_from_r_squared(share, spread), 3e-5, rtol=1e-9)
    # erratum 27: 0.9998 is the noise of Table 4 on 8 mm of depth, and 0.4 mm on 10 cm
    assert noise_from_r_squared(0.9998, 0.1 / np.sqrt(12)) == pytest.approx(4.08e-4, rel=1e-3)


@pytest.mark.parametrize(
    ("points", "group", "message"),
    [
        (np.zeros((4, 2)), None, r"Expected finite points \(N, 3\), got shape \(4, 2\)"),
        (np.full((5, 3), np.nan), None, "Expected finite points"),
        (np.zeros((3, 3)), None, "Expected more than 3 points that span"),
        (np.eye(5)[:, :3], [0, 0, 2, 2, 2], "Expected more than 5 points"),
        (np.empty((0, 3)), None, "Expected more than 3 points"),
    ],
)
def test_points_that_make_no_plane_are_refused(points, group, message):
    with pytest.raises(ValueError, match=message):
        fit_planes(points, group)


def test_a_step_needs_two_planes():
    with pytest.raises(ValueError, match="Expected two planes, got 1"):
        step_height(fit_planes(cloud(np.random.default_rng(4), noise=1e-6)[0]))


@pytest.mark.parametrize("share", [0.0, 1.1, np.nan])
def test_r_squared_out_of_range_is_refused(share):
    with pytest.raises(ValueError, match=r"Expected R\^2 above 0, at most 1"):
        noise_from_r_squared(share, 1.0)
