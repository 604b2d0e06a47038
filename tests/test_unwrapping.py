"""Unwrapping: exact without noise, as good as theory and the reference table with it."""

import numpy as np
import pytest

import cmtof
from cmtof import bounds, metrics
from cmtof.baselines import crt
from cmtof.baselines.beat import beat_depth, beat_phasor, synthetic_frequency
from cmtof.baselines.spatial import unwrapped_phase
from cmtof.conditions import Conditions, Measured
from cmtof.constants import FREQUENCIES
from cmtof.correlation import centred, phase_from_depth, wrap_length
from cmtof.evaluation import Evaluation, ready_methods
from cmtof.kernels import nearest_wrap
from cmtof.measurement import Measurement
from cmtof.scenes import load_frame
from cmtof.scenes.frame import Frame
from cmtof.simulation import simulate


def exact(depth, **attributes):
    """Phases of known depths, in double precision and without noise."""
    depth = np.atleast_2d(np.asarray(depth, float))
    phase = np.stack([phase_from_depth(depth, f) for f in FREQUENCIES])
    return Measurement.from_phase(phase, FREQUENCIES, depth=depth, **attributes)


@pytest.mark.parametrize("method", ["crt", "crt-ml", "crt-closed-form"])
def test_exact_phases_are_unwrapped_exactly(rng, method):
    m = exact(rng.uniform(0.01, 7.4, (30, 40)))
    result = cmtof.unwrap(m, method=method)
    assert np.abs(result.depth - m.depth).max() < 1e-6
    assert metrics.score(metrics.scored_pixels(result, m))["consistent_lt_1"] == 1.0


def test_beat_of_one_pixel_is_exact_without_noise(rng):
    m = exact(rng.uniform(0.01, 7.4, (30, 40)))
    assert np.abs(cmtof.unwrap(m, method="beat", window=1).depth - m.depth).max() < 1e-6


def test_beat_average_of_a_wall_of_one_depth_is_exact():
    m = exact(np.full((20, 20), 3.21))
    assert np.abs(cmtof.unwrap(m, method="beat", window=5).depth - 3.21).max() < 1e-6


@pytest.mark.parametrize("method", ["crt", "crt-ml"])
def test_simulated_frame_without_noise(method):
    m = simulate(load_frame("still_life"), protocol="full", noise_free=True)
    result = cmtof.unwrap(m, method=method)
    error = np.abs(result.depth - m.depth).to_numpy()[m.mask]
    assert np.mean(error < 1e-4) > 0.999  # float32 phases err by a tenth of a wrap of beat


def test_crt_search_equals_the_nearest_beat(measured):
    """At these frequencies a remainder of the CRT is the beat's distance from the wrap's."""
    wraps, residual = nearest_wrap(
        measured.phase[0],
        measured.phase[1],
        ratio=FREQUENCIES[1] / FREQUENCIES[0],
        first=36,
        last=56,
    )
    depth = (measured.phase[0] / (2 * np.pi) + wraps) * wrap_length(FREQUENCIES[0])
    left = centred(np.angle(beat_phasor(measured)) - phase_from_depth(depth, 20e6))
    np.testing.assert_allclose(residual, left, atol=2e-5)


@pytest.mark.parametrize("offset", [0.4, 0.49, 0.51, 0.6])
def test_closed_form_survives_errors_up_to_its_guarantee(rng, offset):
    """An error of less than M/4 in each remainder, of opposite signs, is forgiven; more is not."""
    depth = rng.uniform(0.05, 7.0, (20, 20))
    unit = wrap_length(FREQUENCIES[0]) / 1432
    shift = np.stack(
        [
            phase_from_depth(s * offset * unit / 2, f)
            for s, f in zip((1, -1), FREQUENCIES, strict=True)
        ]
    )
    inner = np.stack([phase_from_depth(depth, f) % (2 * np.pi) for f in FREQUENCIES])
    keep = np.all((inner > 0.01) & (inner < 2 * np.pi - 0.01), axis=0)
    m = Measurement.from_phase(inner + shift[:, None, None], FREQUENCIES)
    error = np.abs(crt.closed_form(m).depth - depth)[keep]
    assert (error.max() < 1e-4) == (offset < 0.5)
    assert crt.guarantee(FREQUENCIES) == pytest.approx(phase_from_depth(unit / 4, 7.15e9))


def test_single_pixels_are_right_as_often_as_theory_says():
    wall = Frame(np.full((700, 700), 4.0), np.ones((700, 700)))
    m = simulate(wall, protocol="full", seed=11)
    rate = metrics.score(metrics.scored_pixels(cmtof.unwrap(m, method="crt"), m))["consistent_lt_1"]
    noise = float(bounds.linear_phase_noise(20_000 / np.pi, 10_000 + 1200**2, 4))
    theory = float(bounds.wrap_probability(noise, noise, frequencies=FREQUENCIES))
    assert rate == pytest.approx(theory, rel=0.05)


@pytest.mark.parametrize("name", sorted(ready_methods()))
def test_results_obey_range_mask_and_scale(tilted_wall, name):
    low, high = 0.85, 1.05
    given = Measured(Conditions(seed=3), tilted_wall).by(name)
    mask = given.mask.copy()
    mask[:5] = False
    m = Measurement(given.dataset.assign(mask=(("y", "x"), mask.astype(np.int8))))
    result = cmtof.unwrap(m, method=name, range=(low, high))
    depth = result.depth.to_numpy()
    assert (result.wrap_count.to_numpy()[~mask] == -1).all()
    assert np.isnan(depth[~mask]).all()
    assert (depth[mask] >= low - 1e-6).all()
    assert (depth[mask] < high + 1e-6).all()
    assert (result.wrap_count.to_numpy()[mask] >= int(low / wrap_length(7.15e9))).all()
    assert ((result.confidence >= 0) & (result.confidence <= 1)).all()


@pytest.mark.parametrize("name", sorted(set(ready_methods()) - {"mode", "oracle-offset"}))
def test_masked_pixels_may_be_no_numbers(tilted_wall, name):
    given = Measured(Conditions(seed=3), tilted_wall).by(name)
    phase = given.dataset["correlation"].to_numpy().copy()
    phase[:, :, 7:9, 3] = np.nan
    mask = given.mask.copy()
    mask[7:9, 3] = False
    images = (given.dataset["correlation"].dims, phase)
    holed = Measurement(given.dataset.assign(correlation=images, mask=(("y", "x"), mask)))
    result = cmtof.unwrap(holed, method=name)
    assert (result.wrap_count.to_numpy()[7:9, 3] == -1).all()
    assert np.isnan(result.depth.to_numpy()[7:9, 3]).all()
    assert (result.wrap_count.to_numpy() >= 0).sum() == given.mask.sum() - 2


def test_crt_confidence_is_the_share_of_right_wraps(rng):
    """Of wraps that were all as likely beforehand, as many are right as the posterior says."""
    depth = rng.uniform(0.755, 1.194, (500, 500))
    m = simulate(Frame(depth, np.ones_like(depth)), seed=1)
    result = cmtof.unwrap(m, method="crt")
    right = metrics.score(metrics.scored_pixels(result, m))["consistent_lt_1"]
    assert float(result.confidence.mean()) == pytest.approx(right, rel=0.2)


def test_larger_windows_help_on_a_wall_of_one_depth():
    wall = Frame(np.full((120, 120), 1.0), np.full((120, 120), 0.8))
    m = simulate(wall, seed=2)
    rates = [
        metrics.score(metrics.scored_pixels(cmtof.unwrap(m, method="beat", window=w), m))[
            "delta_lt_1"
        ]
        for w in (1, 11, 41)
    ]
    assert rates[0] < rates[1] < rates[2]
    # 41 x 41 pixels divide the noise by 41
    noise = float(bounds.linear_phase_noise(16_000 / np.pi, 8_000 + 1200**2, 4)) / 41
    odds = float(bounds.wrap_probability(noise, noise, frequencies=FREQUENCIES))
    assert rates[2] == pytest.approx(odds, abs=0.1)


def test_beat_depth_stays_in_range_whatever_the_phase():
    m = exact(np.full((1, 1), 1.0), range_min=0.755, range_max=1.195)
    depth = beat_depth(np.linspace(-10, 10, 500)[None], m)
    assert depth.min() >= 0.755
    assert depth.max() < 1.195


def test_synthetic_frequency_of_other_pairs():
    assert synthetic_frequency(7.15e9, 7.16e9) == (1, 10e6, 1)
    assert synthetic_frequency(7.16e9, 14.30e9) == (2, 20e6, -1)
    with pytest.raises(ValueError, match="no multiples"):
        synthetic_frequency(7e9, 14e9)


def test_beat_below_the_multiple_unwraps_as_well(rng):
    pair = (7.16e9, 14.30e9)
    depth = rng.uniform(0.1, 7.0, (9, 9))
    m = Measurement.from_phase(np.stack([phase_from_depth(depth, f) for f in pair]), pair)
    assert np.abs(cmtof.unwrap(m, method="beat", window=1).depth - depth).max() < 1e-6


def test_spatial_unwrapping_follows_a_slope_over_many_wraps():
    x = np.linspace(0, 1, 80)
    m = exact(0.9 + 0.2 * x[None, :] + 0.05 * x[:60, None], range_min=0.8, range_max=1.2)
    relative = unwrapped_phase(m) - phase_from_depth(m.depth, 7.15e9)
    assert np.ptp(relative) < 1e-9
    error = cmtof.unwrap(m, method="spatial").depth.to_numpy() - m.depth
    assert np.ptp(error) < 1e-6
    assert abs(error[0, 0]) < 0.1


def test_spatial_unwrapping_needs_one_frequency_and_the_others_two():
    m = Measurement.from_phase(np.ones((1, 8, 9)), [7.15e9], range_max=1.0)
    assert cmtof.unwrap(m, method="spatial").wrap_count.shape == (8, 9)
    with pytest.raises(ValueError, match="Expected 2 frequencies for method crt, got 1"):
        cmtof.unwrap(m, method="crt")
    empty = Measurement.from_phase(
        np.ones((1, 8, 9)), [7.15e9], mask=np.zeros((8, 9)), range_max=1.0
    )
    with pytest.raises(ValueError, match="at least one valid pixel"):
        cmtof.unwrap(empty, method="spatial")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"method": "magic"}, "Expected a method out of crt, crt-closed-form"),
        ({"range": (5.0, 6.0)}, "that meets the data's"),
        ({"range": (1.1, 0.9)}, "MIN < MAX"),
        ({"range": (-1.0, 0.9)}, "MIN < MAX"),
        ({"method": "beat", "window": 4}, "odd window"),
        ({"method": "beat", "window": 0}, "odd window"),
    ],
)
def test_bad_requests_are_refused(measured, options, message):
    with pytest.raises(ValueError, match=message):
        cmtof.unwrap(measured, **options)


def test_closed_form_refuses_frequencies_without_a_divisor():
    m = Measurement.from_phase(np.ones((2, 3, 3)), (7_150_000_001.0, 14_320_000_003.0))
    with pytest.raises(ValueError, match="common divisor"):
        cmtof.unwrap(m, method="crt-closed-form")


# --- scores --------------------------------------------------------------------------------------


def test_delta_rates_count_as_the_tables_do():
    rates = metrics.delta_rates([10, 11, 12, 13, 20, 9], [10] * 6)
    assert rates["delta_lt_1"] == pytest.approx(1 / 6)
    assert rates["delta_lt_2"] == pytest.approx(3 / 6)
    assert rates["delta_lt_3"] == pytest.approx(4 / 6)
    assert rates["delta_ge_3"] == pytest.approx(2 / 6)
    assert rates["delta_ge_10"] == pytest.approx(1 / 6)
    with pytest.raises(ValueError, match="at least one scored pixel"):
        metrics.delta_rates([], [])


def test_true_depth_read_against_the_measured_phase_loses_the_boundaries():
    m = simulate(load_frame("still_life"), protocol="full", seed=0)
    truth = cmtof.unwrap(m, method="crt").assign(depth=(("y", "x"), m.depth))
    scores = metrics.score(metrics.scored_pixels(truth, m))
    assert scores["consistent_lt_1"] == 1.0
    pixels = metrics.scored_pixels(truth, m)
    mixed = metrics.delta_rates(pixels["consistent"], pixels["true_count"])
    assert 0.85 < mixed["delta_lt_1"] < 0.98


def test_scores_need_a_truth(measured):
    m = Measurement(measured.dataset.drop_vars("depth"))
    with pytest.raises(ValueError, match="true depth"):
        metrics.scored_pixels(cmtof.unwrap(m), m)


def test_evaluation_gives_every_method_the_same_noise(tilted_wall):
    evaluation = Evaluation(["crt", "beat"], seed=4, options={"beat": {"window": 1}})
    report = evaluation.add_all([tilted_wall, tilted_wall]).report()
    assert report["frames"] == ["wall", "wall"]
    crt_scores, beat_scores = report["methods"]["crt"], report["methods"]["beat"]
    assert crt_scores["consistent_lt_1"] == pytest.approx(beat_scores["consistent_lt_1"], abs=0.01)
    alone = (
        Evaluation(["crt"], seed=4).add_all([tilted_wall, tilted_wall]).report()["methods"]["crt"]
    )
    assert {k: v for k, v in alone.items() if k != "seconds_per_frame"} == {
        k: v for k, v in crt_scores.items() if k != "seconds_per_frame"
    }
    with pytest.raises(ValueError, match="at least one frame"):
        Evaluation(["crt"]).report()


# --- path-traced interiors that nobody here made -------------------------------------------------

REFERENCE = {
    ("released", 1): (4.1, 10.1, 16.4, 45.5),
    ("released", 41): (26.6, 54.2, 69.1, 6.0),
    ("full", 1): (0.9, 2.8, 4.7, 82.7),
    ("full", 41): (21.4, 47.5, 60.9, 15.7),
}


@pytest.mark.slow
@pytest.mark.parametrize("protocol", ["released", "full"])
def test_beat_scores_within_five_points_of_the_reference_table(shared_data, protocol):
    paths = sorted(shared_data.glob("frames/*.npz"))
    if not paths:
        pytest.skip("no path-traced frames on this machine")
    measured = [
        simulate(load_frame(p), protocol=protocol, frame_number=i) for i, p in enumerate(paths)
    ]
    for window in (1, 41):
        pixels = [
            metrics.scored_pixels(cmtof.unwrap(m, method="beat", window=window), m)
            for m in measured
        ]
        pooled = {key: np.concatenate([p[key] for p in pixels]) for key in pixels[0]}
        rates = metrics.delta_rates(pooled["consistent"], pooled["true_count"])
        ours = [100 * rates[k] for k in ("delta_lt_1", "delta_lt_2", "delta_lt_3", "delta_ge_10")]
        np.testing.assert_allclose(ours, REFERENCE[protocol, window], atol=5.0)
