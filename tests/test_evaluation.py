"""Counting: rates as the tables have them, the same noise for all, stored counts."""

import numpy as np
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from pytest import approx, mark, raises, skip
from refusals import refused
from scores import scores
from walls import WRAP

import cmtof
from cmtof.evaluation import (
    Evaluation,
    Tally,
    measure_frame,
    rates,
    read_counts,
    score,
    scored_pixels,
)
from cmtof.frame import held_out_frames
from cmtof.measurement import Measurement
from cmtof.methods import METHODS
from cmtof.scenes import load_frame
from cmtof.simulation import simulate
from cmtof_book import RESULTS


def pixels(found, truth, error=0.0):
    found = np.asarray(found)
    return {
        "wrap_count": found,
        "true_count": truth,
        "consistent": found,
        "true_consistent": truth,
        "depth_error": np.broadcast_to(error, found.shape),
        "confidence": np.full(found.shape, 0.5),
    }


def test_rates_count_as_the_tables_do():
    found = score(pixels([10, 11, 12, 13, 20, 9], [10] * 6))
    names = ["delta_lt_1", "delta_lt_2", "delta_lt_3", "delta_ge_3", "delta_ge_10"]
    assert [6 * found[name] for name in names] == approx([1, 3, 4, 2, 1])
    assert 6 * found["consistent_lt_1"] == approx(1)


def test_pooled_frames_are_one_large_frame(rng):
    """Counts and the histogram of errors add up; the median is known to 0.12 %."""
    whole = pixels(*rng.integers(0, 9, (2, 5101)), rng.normal(0, 0.02, 5101))
    cuts = [slice(100), slice(100, 101), slice(101, None)]
    many = score(*({key: whole[key][cut] for key in whole} for cut in cuts))
    assert score(whole) == approx(many)
    errors = abs(whole["depth_error"])
    assert many["depth_median_error_m"] == approx(np.median(errors), rel=2e-3)
    assert many["depth_rmse_m"] == approx(np.sqrt((errors**2).mean()))


def test_scores_need_a_truth_and_a_pixel(measured):
    result = cmtof.unwrap(measured, method="middle")
    with refused("true depth"):
        scored_pixels(result, Measurement(measured.dataset.drop_vars("depth")))
    nothing = xr.zeros_like(measured.dataset["mask"])
    with refused("at least one scored pixel"):
        scored_pixels(result, Measurement(measured.dataset.assign(mask=nothing)))


def test_every_method_sees_the_same_noise(tilted_wall):
    frames = [tilted_wall, tilted_wall]
    both = Evaluation(["crt", "crt-ml"], seed=4).add_all(frames)
    report = both.report()
    assert report | {"protocol": "released", "noise": 1200.0, "seed": 4} == report
    crt, fused = report["methods"].values()
    assert crt["delta_lt_3"] == approx(fused["delta_lt_3"], abs=0.01)
    alone = Evaluation(["crt"], seed=4).add_all(frames)
    first, second = (
        [frame["methods"]["crt"] for frame in one.counts()] for one in (alone, both)
    )
    assert first == second
    assert first[0] != first[1]  # each frame has noise of its own


def test_a_method_that_fails_takes_no_other_with_it(tilted_wall, monkeypatch):
    monkeypatch.setitem(METHODS["middle"].__dict__, "run", lambda m: m.failed)
    evaluation = Evaluation(["crt", "middle"]).add_all([tilted_wall])
    before = evaluation.report()
    assert "middle" not in before["methods"]
    monkeypatch.setitem(METHODS["crt"].__dict__, "run", lambda m: m.failed)
    with raises(AttributeError):  # where all fail the frame counts for none
        evaluation.add_all([tilted_wall])
    assert evaluation.report() == before


def test_other_frequencies_are_scored_over_the_same_pixels(tilted_wall):
    given = measure_frame(tilted_wall, ["beat", "phasor", "crt"])
    assert given["beat"] is given["crt"]
    assert given["phasor"].frequencies.tolist() == [7.15e9, 7.16e9]
    assert_array_equal(given["phasor"].mask, given["beat"].mask)


def test_counts_give_rates_with_intervals(tilted_wall):
    counts = Evaluation(["crt", "middle"]).add_all([tilted_wall] * 4).counts()
    found = rates(counts, "crt", draws=200)
    pooled = [frame["methods"]["crt"] for frame in counts]
    right = sum(frame["below"][0] for frame in pooled)
    assert found.value[0] == approx(right / sum(frame["pixels"] for frame in pooled))
    apart = rates(counts, "crt", against="middle", draws=200)
    assert_allclose(apart.value, found.value - rates(counts, "middle", draws=50).value)


def test_sets_of_wraps_are_counted_within_the_range(exact):
    """Three wraps from 40 on; the estimate is the first, the truth the second."""
    m = exact(np.full((1, 2), 41.5 * WRAP), range_min=40 * WRAP, range_max=43 * WRAP)
    result = cmtof.unwrap(m)
    result["wrap_count"][:] = 40
    result["within_90"][:] = [0, 9]
    found = scored_pixels(result, m)
    assert found["covered_90"].tolist() == [False, True]
    assert found["wraps_in_90"].tolist() == [1, 3]
    assert score(found)["covered_90"] == 0.5


def test_true_depth_read_against_the_measured_phase_loses_the_boundaries():
    """9 % of the pixels: noise carries a phase across the end of its wrap."""
    found = scores(
        simulate(load_frame("still_life"), protocol="full"), method="reference-depth"
    )
    assert found["consistent_lt_1"] == 1.0
    assert 0.85 < found["delta_lt_1"] < 0.98


@mark.slow
@mark.parametrize(
    "protocol, window, percent",
    [("released", 41, (26.6, 54.2, 69.1, 6.0)), ("full", 1, (0.9, 2.8, 4.7, 82.7))],
)
def test_beats_of_path_traced_rooms_score_as_an_independent_simulation(
    shared_data, protocol, window, percent
):
    paths = sorted(shared_data.glob("frames/*.npz"))
    if not paths:
        skip("no path-traced frames on this machine")
    tally = Tally()
    for number, path in enumerate(paths):
        m = simulate(load_frame(path), protocol=protocol, frame_number=number)
        found = scored_pixels(cmtof.unwrap(m, method="beat", window=window), m)
        tally.add(found | {"wrap_count": found["consistent"]})
    found = [
        100 * tally.score()[f"delta_{key}"] for key in ("lt_1", "lt_2", "lt_3", "ge_10")
    ]
    assert_allclose(found, percent, atol=5.0)


@mark.slow
def test_stored_counts_are_those_of_the_shipped_frames():
    """Two frames counted again; another processor may differ in 1 % of a frame's pixels."""
    held = read_counts(RESULTS / "table2_released_1200.json")[:2]
    again = Evaluation(["crt", "beat", "middle"]).add_all(held_out_frames()[:2])
    for stored, new in zip(held, again.counts(), strict=True):
        assert stored["frame"] == new["frame"]
        for name, counts in new["methods"].items():
            assert_allclose(
                counts["below"],
                stored["methods"][name]["below"],
                rtol=0,
                atol=0.01 * counts["pixels"],
            )
