"""The guided average of the beat: exact where nothing varies, and it stops at edges."""

import numpy as np
import pytest

import cmtof
from cmtof.baselines.beat import beat, beat_phasor
from cmtof.baselines.beat_guided import beat_guided, box, guided_filter, guides
from cmtof.constants import FREQUENCIES
from cmtof.correlation import phase_from_depth
from cmtof.measurement import Measurement


def exact(depth, amplitude=1.0, **attributes):
    """Phases of known depths without noise."""
    depth = np.atleast_2d(np.asarray(depth, float))
    phase = np.stack([phase_from_depth(depth, f) for f in FREQUENCIES])
    size = np.broadcast_to(amplitude, phase.shape)
    return Measurement.from_phase(phase, FREQUENCIES, amplitude=size, depth=depth, **attributes)


def test_wall_of_one_depth_is_exact():
    m = exact(np.full((30, 40), 3.21), amplitude=500.0)
    estimate = beat_guided(m, window=9)
    assert np.abs(estimate.depth - 3.21).max() < 1e-9
    assert estimate.confidence.min() > 0.999


@pytest.mark.parametrize(("smoothing", "share"), [(0.02, 0.6), (1e-5, 0.2)])
def test_step_of_depth_with_a_step_of_amplitude_leaks_less(smoothing, share):
    """The plain average leaks over half a window; the fit the less, the less it is smoothed."""
    left = np.arange(60) < 30
    depth = np.broadcast_to(np.where(left, 2.0, 4.0), (60, 60))
    m = exact(depth, amplitude=np.where(left, 1000.0, 6000.0))
    beside = (np.abs(np.arange(60) - 29.5) > 3) & (np.abs(np.arange(60) - 29.5) < 10)
    plain = np.abs(beat(m, window=21).depth - depth)[:, beside].mean()
    guided = np.abs(beat_guided(m, window=21, smoothing=smoothing).depth - depth)[:, beside].mean()
    assert plain > 0.5
    assert guided < share * plain


def test_steps_of_slope_guide_although_phases_wrap():
    """A slope of many wraps is one value of the guide: no step where the phase wraps."""
    x = np.arange(80)
    m = exact(np.broadcast_to(1 + 0.002 * x, (40, 80)), amplitude=100.0)
    right = guides(m)[4:]
    assert np.ptp(right, axis=(1, 2)).max() < 1e-9
    turn = phase_from_depth(0.002, FREQUENCIES[0])
    np.testing.assert_allclose(right[:, 0, 0], [np.cos(turn), np.sin(turn)], atol=1e-9)


def test_much_smoothing_is_the_mean_of_means(measured):
    m, window = measured, 7
    phasor = beat_phasor(m).astype(complex)
    weight = np.abs(phasor)
    unit = phasor / weight
    total = box(weight, window)
    plain = box(weight * (box(phasor, window) / total), window) / total
    found = guided_filter(unit, guides(m), weight, window, 1e12)
    np.testing.assert_allclose(found, plain, atol=1e-9)


def test_linear_function_of_the_guides_passes_unchanged(rng):
    guide = rng.normal(size=(2, 30, 30))
    values = (0.3 + 0.2j) * guide[0] - 0.7j * guide[1] + 0.1
    found = guided_filter(values, guide, rng.uniform(0.5, 2, (30, 30)), 9, 1e-9)
    np.testing.assert_allclose(found, values, atol=1e-6)


def test_brightness_of_the_whole_image_does_not_matter(measured):
    twice = Measurement.from_phase(
        measured.phase,
        FREQUENCIES,
        amplitude=2 * measured.amplitude,
        range_min=measured.range[0],
        range_max=measured.range[1],
    )
    np.testing.assert_allclose(
        beat_guided(twice).depth, beat_guided(measured).depth, atol=1e-6, rtol=0
    )


@pytest.mark.parametrize("method", [beat, beat_guided])
@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (7, 1), (2, 3)])
@pytest.mark.parametrize("amplitude", [0.0, 1.0])
def test_any_size_and_darkness(method, shape, amplitude):
    m = exact(np.full(shape, 1.0), amplitude=amplitude, mask=np.zeros(shape))
    estimate = method(m)
    assert estimate.depth.shape == estimate.confidence.shape == shape
    assert np.isfinite(estimate.depth).all()
    assert ((estimate.confidence >= 0) & (estimate.confidence <= 1)).all()
    if amplitude:
        assert np.abs(estimate.depth - 1.0).max() < 1e-9


@pytest.mark.parametrize("method", [beat, beat_guided])
def test_masked_pixels_that_are_not_finite_tell_nothing(method):
    depth, mask = np.full((30, 30), 2.5), np.ones((30, 30), bool)
    mask[10:14, 5:9] = False
    phase = np.stack([phase_from_depth(depth, f) for f in FREQUENCIES])
    phase[:, ~mask] = np.nan
    m = Measurement.from_phase(phase, FREQUENCIES, mask=mask)
    estimate = method(m, window=7)
    assert np.isfinite(estimate.depth).all()
    assert np.abs(estimate.depth - 2.5)[mask].max() < 1e-9


def test_one_wrap_in_range_is_told(measured):
    low, high = 42 * 0.0209645, 43 * 0.0209645
    result = cmtof.unwrap(measured, method="beat-guided", range=(low, high))
    assert (result.depth.to_numpy()[measured.mask] >= low - 1e-6).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"window": 4}, "odd window"),
        ({"window": 0}, "odd window"),
        ({"smoothing": 0.0}, "smoothing > 0"),
    ],
)
def test_bad_options_are_refused(measured, options, message):
    with pytest.raises(ValueError, match=message):
        beat_guided(measured, **options)
