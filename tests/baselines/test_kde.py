"""Kernel density: the bins against the sum as written, its limits and its symmetries."""

import numpy as np
import pytest

import cmtof
from cmtof.baselines.kde import hypotheses_of, kde, kde_by_double_loop, tuned
from cmtof.baselines.kde_kernels import binned_density, direct_density, gaussian_window
from cmtof.baselines.noise import phase_noise
from cmtof.constants import FREQUENCIES
from cmtof.correlation import consistent_wrap_count, phase_from_depth, wrap_length
from cmtof.measurement import Measurement
from cmtof.scenes.frame import Frame
from cmtof.simulation import simulate

WRAP = float(wrap_length(FREQUENCIES[0]))


def slope(height, width, seed=1, **options):
    """A noisy slope of patchy brightness."""
    y, x = np.indices((height, width))
    bright = np.random.default_rng(0).uniform(0.1, 1, (height, width))
    return simulate(Frame(0.9 + 0.004 * x + 0.002 * y, bright), seed=seed, **options)


def hypotheses(m):
    return hypotheses_of(m, m.phase[:2].astype(float), phase_noise(m))


def wraps(estimate, m):
    return consistent_wrap_count(estimate.depth, m.phase[0].astype(float), FREQUENCIES[0])


def from_phases(depth, **more):
    phase = np.stack([phase_from_depth(depth, f) for f in FREQUENCIES])
    return Measurement.from_phase(phase, FREQUENCIES, **more)


def part(m, rows, columns):
    return Measurement(m.dataset.isel(y=rows, x=columns))


@pytest.mark.parametrize("radius", [0, 1, 5, 9])
@pytest.mark.parametrize("kernel", [0.05, 0.25, 0.3, 0.5, 1.0, 2.0])
def test_bins_equal_the_double_loop(kernel, radius):
    h = hypotheses(slope(11, 14))
    direct = direct_density(h, kernel=kernel, radius=radius)
    part = {"rows": slice(0, 11), "labels": slice(0, 21)}
    binned = binned_density(h, kernel=kernel, radius=radius, **part)
    np.testing.assert_allclose(binned, direct, atol=0.006 * direct.max())
    # where two wraps are no tie within the tolerance both choose the same
    ranked = np.sort(direct, axis=2)
    clear = ranked[..., -1] - ranked[..., -2] > 0.012 * direct.max()
    assert (binned.argmax(2) == direct.argmax(2))[clear].all()


def test_both_ways_give_the_same_answer():
    m = slope(14, 15)
    fast, slow = kde(m, kernel=0.5), kde_by_double_loop(m, kernel=0.5)
    assert np.mean(wraps(fast, m) == wraps(slow, m)) > 0.97  # ties within the tolerance
    np.testing.assert_allclose(fast.confidence, slow.confidence, rtol=0.01)


def test_double_loop_is_the_formula(rng):
    """One pixel and one neighbour, written out."""
    h = hypotheses(slope(1, 2))
    left = h.start[0, :, None] - h.shifts
    left -= np.rint(left)
    weights = h.reliability[0, :, None] * np.exp(-h.precision[0, :, None] * left**2)
    depth = h.turns[0, :, None] + np.arange(21)
    apart = depth[0, :, None, None] - depth[None]
    near = gaussian_window(1)[1:]
    expected = np.einsum("y,yj,iyj->i", near, weights, np.exp(-(apart**2) / (2 * 0.5**2)))
    np.testing.assert_allclose(direct_density(h, kernel=0.5, radius=1)[0, 0], expected, rtol=1e-5)


def test_any_part_is_the_same_to_the_last_bit():
    h = hypotheses(slope(23, 9, protocol="full"))
    size = h.shifts.size
    whole = binned_density(h, kernel=0.5, radius=3, rows=slice(0, 23), labels=slice(0, size))
    some = binned_density(h, kernel=0.5, radius=3, rows=slice(5, 12), labels=slice(30, 77))
    np.testing.assert_array_equal(whole[5:12, :, 30:77], some)


@pytest.mark.parametrize("protocol", ["released", "full"])
def test_strips_change_no_result(protocol):
    m = slope(40, 17, protocol=protocol)
    whole = kde(m, rows=1000)
    for rows in (1, 7, 16):
        strips = kde(m, rows=rows)
        np.testing.assert_array_equal(strips.depth, whole.depth)
        np.testing.assert_array_equal(strips.confidence, whole.confidence)


def test_without_window_and_with_a_thin_kernel_it_is_the_search():
    m = slope(40, 60)
    alone = kde(m, kernel=0.05, radius=0)
    np.testing.assert_array_equal(wraps(alone, m), wraps(cmtof.baselines.METHODS["crt"](m), m))


@pytest.mark.parametrize("method", [kde, tuned])
@pytest.mark.parametrize("protocol", ["released", "full"])
def test_a_plane_without_noise_is_exact(method, protocol):
    m = simulate(Frame(np.full((30, 31), 1.01), np.ones((30, 31))), protocol=protocol,
                 noise_free=True)  # fmt: skip
    estimate = method(m)
    np.testing.assert_allclose(estimate.depth, 1.01, atol=1e-6)


def test_phases_alone_suffice_for_a_plane():
    np.testing.assert_allclose(kde(from_phases(np.full((9, 9), 3.21))).depth, 3.21, atol=1e-9)


def test_neighbours_help():
    wall = Frame(np.full((60, 60), 0.97), np.ones((60, 60)))
    m = simulate(wall, seed=1)
    wrong = [
        np.abs(kde(m, radius=r, kernel=0.5).depth - 0.97).mean() / WRAP for r in (0, 5, 11, 20)
    ]
    assert wrong == sorted(wrong, reverse=True)
    assert wrong[-1] < 1 < wrong[0]


@pytest.mark.parametrize("axes", [(1, 0), "up", "mirror"])
def test_turning_the_image_turns_the_density(axes):
    m = slope(12, 17)
    h = hypotheses(m)

    def turn(image):
        if axes == "up":
            return image[::-1]
        return image[:, ::-1] if axes == "mirror" else np.swapaxes(image, 0, 1)

    turned = type(h)(*(np.ascontiguousarray(turn(field)) for field in h[:-1]), h.shifts)
    options = {"kernel": 0.5, "radius": 4, "labels": slice(0, 21)}
    straight = binned_density(h, rows=slice(0, 12), **options)
    other = binned_density(turned, rows=slice(0, turned.turns.shape[0]), **options)
    np.testing.assert_allclose(other, turn(straight), atol=1e-5 * straight.max())


def test_one_bright_pixel_tells_its_dark_neighbours():
    """A pixel of no amplitude has no say; its own phase only shifts where it is asked."""
    amplitude = np.zeros((2, 5, 5))
    amplitude[:, 2, 2] = 1
    m = from_phases(np.full((5, 5), 0.99), amplitude=amplitude, range_min=0.5, range_max=1.5)
    np.testing.assert_allclose(kde(m).depth, 0.99, atol=1e-9)


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (2, 3)])
@pytest.mark.parametrize("protocol", ["released", "full"])
def test_any_shape(shape, protocol):
    m = slope(*shape, protocol=protocol)
    estimate = kde(m)
    assert estimate.depth.shape == estimate.confidence.shape == shape
    assert (estimate.depth >= m.range[0]).all()
    assert (estimate.depth < m.range[1]).all()
    assert ((estimate.confidence >= 0) & (estimate.confidence <= 1)).all()


def test_darkness_and_nothing_known():
    depth = np.full((6, 7), 0.99)
    dark = from_phases(depth, amplitude=np.zeros((2, 6, 7)), range_max=2.0)
    estimate = kde(dark)
    np.testing.assert_allclose(estimate.depth, 0.99, atol=1e-9)  # each by its own misfit
    np.testing.assert_allclose(estimate.confidence, 1 / 96)
    phase = np.full((2, 6, 7), np.nan)
    nothing = Measurement.from_phase(phase, FREQUENCIES, mask=np.zeros((6, 7)), range_max=2.0)
    assert np.isfinite(kde(nothing).depth).all()


def test_unknown_pixels_have_no_say(rng):
    """NaN behind the mask: the neighbours are as if it had no amplitude."""
    phase = rng.uniform(0, 2 * np.pi, (2, 12, 13))
    amplitude = np.ones_like(phase)
    mask = np.ones((12, 13), bool)
    mask[4:6, 5:9] = False
    holed = np.where(mask, phase, np.nan)
    more = {"range_min": 0.75, "range_max": 1.2}
    nan = kde(Measurement.from_phase(holed, FREQUENCIES, mask=mask, **more))
    dark = kde(Measurement.from_phase(phase, FREQUENCIES, amplitude=amplitude * mask, **more))
    np.testing.assert_array_equal(nan.depth[mask], dark.depth[mask])
    np.testing.assert_array_equal(nan.confidence[mask], dark.confidence[mask])
    assert np.isfinite(nan.depth).all()
    assert np.isfinite(nan.confidence).all()
    images = slope(12, 13).dataset
    correlation = images["correlation"].where(mask)
    assert np.isfinite(kde(Measurement(images.assign(correlation=correlation,
                           mask=(("y", "x"), mask)))).confidence).all()  # fmt: skip


def test_a_single_wrap_is_certain():
    m = slope(8, 9).between(40.01 * WRAP, 40.99 * WRAP)
    estimate = kde(m)
    assert (np.floor(estimate.depth / WRAP) == 40).all()
    np.testing.assert_allclose(estimate.confidence, 1)


@pytest.mark.parametrize("pair", [(7.15e9, 7.16e9), (7.16e9, 14.30e9), (3e9, 7e9)])
def test_other_frequencies(pair):
    m = simulate(Frame(np.full((9, 9), 0.123), np.ones((9, 9))), protocol="full",
                 frequencies=pair, noise_free=True).between(0.05, 0.19)  # fmt: skip
    np.testing.assert_allclose(kde(m).depth, 0.123, atol=1e-5)


@pytest.mark.parametrize("options", [{"kernel": 0}, {"kernel": np.nan}, {"radius": -1},
                                     {"rows": 0}])  # fmt: skip
def test_bad_options_are_refused(options):
    with pytest.raises(ValueError, match="Expected a kernel of"):
        kde(slope(3, 3), **options)
