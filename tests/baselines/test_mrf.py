"""Semi-global matching of wraps: one row is a Viterbi chain, planes are exact, nothing is odd."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import cmtof
from cmtof import metrics
from cmtof.baselines import find_method, mrf
from cmtof.baselines.mrf_kernels import coherent_sum
from cmtof.constants import FREQUENCIES
from cmtof.correlation import TAU, phase_from_depth, wrap_length
from cmtof.measurement import Measurement
from cmtof.scenes.frame import Frame
from cmtof.simulation import simulate

RELEASED = {"range_min": 36 * float(wrap_length(7.15e9)), "range_max": 1.195}


def exact(depth, frequencies=FREQUENCIES, **attributes):
    """Phases of known depths, without noise."""
    depth = np.atleast_2d(np.asarray(depth, float))
    phase = np.stack([phase_from_depth(depth, f) for f in frequencies])
    return Measurement.from_phase(phase, frequencies, depth=depth, **attributes)


def plane(height, width, start=0.8, across=0.2, along=0.1):
    y, x = np.mgrid[:height, :width]
    return start + across * x / max(width, 1) + along * y / max(height, 1)


def random_field(rng, height, width, labels):
    return mrf.Field(
        rng.uniform(0, TAU, (height, width)).astype(np.float32),
        rng.normal(size=(height, width, 2)).astype(np.float32),
        np.linspace(0, 2.5, labels),
        0,
    )


def unary(field):
    """Cost of every label (H, W, N)."""
    cosine, sine = np.cos(field.angles), np.sin(field.angles)
    return -(field.beat[..., :1] * cosine + field.beat[..., 1:] * sine).astype(float)


def viterbi(cost, step, jump, most):
    """Least cost of a chain through each label at each of its pixels (W, N), pair by pair."""
    n = np.arange(cost.shape[1])
    ends = []
    for order in (1, -1):
        total = [cost[::order][0]]
        signed = step if order == 1 else -step[::-1]
        for own, d in zip(cost[::order][1:], signed, strict=True):
            pair = np.minimum(jump * np.abs(n[None, :] - n[:, None] - d), most)
            total.append(own + (total[-1][:, None] + pair).min(axis=0))
        ends.append(np.array(total)[::order])
    return ends[0] + ends[1] - cost


@pytest.mark.parametrize(("jump", "most"), [(0.3, 0.3), (0.3, 1.0), (0.1, 2.0), (5.0, 6.0)])
@pytest.mark.parametrize("shape", [(1, 40), (40, 1)])
def test_one_row_is_the_best_chain(rng, shape, jump, most):
    for labels in (1, 2, 7, 21):
        field = random_field(rng, *shape, labels)
        phase = field.phase.ravel()
        step = np.rint((phase[:-1] - phase[1:]) / TAU)
        cost = viterbi(unary(field).reshape(40, labels), step, jump, most)
        found, odds = mrf.semi_global_matching(field, jump=jump, most=most)
        chosen = np.take_along_axis(cost, found.reshape(40, 1), 1)[:, 0]
        np.testing.assert_allclose(chosen, cost.min(axis=1), atol=1e-4)
        share = np.exp(-(cost - cost.min(axis=1, keepdims=True)) / mrf.TEMPERATURE).sum(axis=1)
        np.testing.assert_allclose(odds.ravel(), 1 / share, rtol=0.2)


def test_a_large_prior_makes_one_surface_and_the_smallest_none(rng):
    field = random_field(rng, 9, 11, 21)
    field = field._replace(phase=np.zeros_like(field.phase))
    row = mrf.Field(field.phase[:1], field.beat[:1], field.angles, 0)
    found, _ = mrf.semi_global_matching(row, jump=1e3, most=1e4)
    assert np.ptp(found) == 0
    assert found[0, 0] == unary(row).sum(axis=(0, 1)).argmin()
    found, _ = mrf.semi_global_matching(field, jump=1e-9, most=1e-9)
    np.testing.assert_array_equal(found, unary(field).argmin(axis=2))


@pytest.mark.parametrize("transform", [np.transpose, np.flipud, np.fliplr, np.rot90])
def test_turning_the_image_turns_the_labels(rng, transform):
    field = random_field(rng, 12, 17, 15)
    beat = np.stack([transform(field.beat[..., i]) for i in (0, 1)], axis=-1)
    turned = mrf.Field(
        np.ascontiguousarray(transform(field.phase)), np.ascontiguousarray(beat), field.angles, 0
    )
    found, odds = mrf.semi_global_matching(field, jump=0.3, most=1.0)
    again, odds_again = mrf.semi_global_matching(turned, jump=0.3, most=1.0)
    np.testing.assert_array_equal(transform(found), again)
    np.testing.assert_allclose(transform(odds), odds_again, rtol=1e-2)


def test_strips_and_threads_change_nothing(measured):
    whole = mrf.mrf(measured)
    for rows in (1, 7, 48, 500):
        strips = mrf.mrf(measured, rows=rows)
        np.testing.assert_array_equal(strips.depth, whole.depth)
        np.testing.assert_array_equal(strips.confidence, whole.confidence)
    with ThreadPoolExecutor(2) as pool:
        for other in pool.map(mrf.mrf, [measured] * 2):
            np.testing.assert_array_equal(other.depth, whole.depth)


@pytest.mark.parametrize("method", ["mrf", "mrf-graphcut"])
@pytest.mark.parametrize("pair", [FREQUENCIES, (7.16e9, 14.30e9), (7.15e9, 7.16e9)])
def test_planes_without_noise_are_exact(method, pair):
    m = exact(plane(40, 50), pair, **RELEASED)
    result = cmtof.unwrap(m, method=method)
    assert np.abs(result.depth - m.depth).max() < 1e-6


@pytest.mark.parametrize("method", ["mrf", "mrf-graphcut"])
def test_a_steep_plane_over_the_full_range(method):
    m = simulate(
        Frame(plane(40, 50, 2.0, 0.3, 0.2), np.ones((40, 50))), protocol="full", noise_free=True
    )
    result = cmtof.unwrap(m, method=method)
    assert metrics.score(metrics.scored_pixels(result, m))["consistent_lt_1"] > 0.99


def test_it_beats_the_plain_average_on_a_tilted_wall():
    m = simulate(Frame(plane(100, 120), np.full((100, 120), 0.8)), seed=2)
    rates = [
        metrics.score(metrics.scored_pixels(cmtof.unwrap(m, method=name), m))["consistent_lt_1"]
        for name in ("crt", "beat", "mrf")
    ]
    assert rates[0] < 0.1 < rates[2]
    assert rates[2] > rates[1] - 0.05


def test_noise_is_read_off_the_smoothing():
    m = simulate(Frame(plane(100, 120), np.ones((100, 120))), seed=2)
    phasors = mrf._phasors(m)
    smooth = coherent_sum(phasors, mrf._slope(phasors[0], 3), ratio=2.0, radius=1)
    noise = mrf._noise(phasors[0], smooth[0])
    # four samples of 1200 counts and the photons' own
    assert noise == pytest.approx(np.sqrt((1200**2 + 1e4) / 2), rel=0.1)


@pytest.mark.parametrize("method", ["mrf", "mrf-graphcut"])
@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (6, 5)])
@pytest.mark.parametrize("full", [False, True])
def test_any_size_and_content_gives_numbers(rng, method, shape, full):
    limits = {} if full else RELEASED
    phase = rng.uniform(0, TAU, (2, *shape))
    amplitude = rng.uniform(0, 1000, (2, *shape))
    holes = rng.uniform(size=shape) < 0.4
    none = np.zeros(shape, bool)
    cases = [
        Measurement.from_phase(phase, FREQUENCIES, amplitude=amplitude, **limits),
        Measurement.from_phase(phase, FREQUENCIES, amplitude=0 * amplitude, **limits),
        Measurement.from_phase(np.ones_like(phase), FREQUENCIES, **limits),
        Measurement.from_phase(phase, FREQUENCIES, mask=none, **limits),
        Measurement.from_phase(np.where(holes, np.nan, phase), FREQUENCIES, mask=~holes, **limits),
        Measurement.from_phase(np.full_like(phase, np.nan), FREQUENCIES, mask=none, **limits),
    ]
    for m in cases:
        depth, confidence = find_method(method)(m)
        assert np.isfinite(depth).all()
        assert ((confidence >= 0) & (confidence <= 1)).all()


@pytest.mark.parametrize("method", ["mrf", "mrf-graphcut"])
def test_one_wrap_is_certain(method):
    wrap = float(wrap_length(7.15e9))
    m = exact(np.full((4, 5), 40.5 * wrap), range_min=40 * wrap, range_max=41 * wrap)
    result = cmtof.unwrap(m, method=method)
    assert (result.wrap_count == 40).all()
    np.testing.assert_allclose(result.confidence, 1.0)


@pytest.mark.parametrize("method", ["mrf", "mrf-graphcut"])
def test_holes_are_crossed(method):
    depth = plane(30, 30)
    m = exact(depth, **RELEASED)
    phase = m.phase.copy()
    phase[:, 10:13, 5:25] = np.nan
    mask = np.isfinite(phase[0])
    holed = Measurement.from_phase(phase, FREQUENCIES, depth=depth, mask=mask, **RELEASED)
    error = find_method(method)(holed).depth - depth
    assert np.abs(error[mask]).max() < 1e-6


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"jump": 0.0}, "0 < jump <= most"),
        ({"jump": 2.0, "most": 1.0}, "0 < jump <= most"),
        ({"radius": -1}, "widths of 0 px or more"),
        ({"pooling": -1.0}, "widths of 0 px or more"),
        ({"rows": 0}, "strips of 1 row or more"),
    ],
)
def test_bad_options_are_refused(measured, options, message):
    with pytest.raises(ValueError, match=message):
        cmtof.unwrap(measured, method="mrf", **options)


def test_frequencies_without_a_beat_are_refused():
    m = Measurement.from_phase(np.ones((2, 3, 3)), (7e9, 14e9))
    with pytest.raises(ValueError, match="no multiples"):
        cmtof.unwrap(m, method="mrf")
