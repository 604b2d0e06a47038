"""Unwrapping with a network through the one door, trained or not."""

import numpy as np
import pytest
import torch

import cmtof
from cmtof.baselines import wraps_in_range
from cmtof.correlation import wrap_length
from cmtof.measurement import Measurement
from cmtof.network.configuration import MODELS
from cmtof.network.features import features
from cmtof.network.inference import classify, unwrap_with_network
from cmtof.network.weights import load_weights
from cmtof.scenes.frame import Frame

STEP = float(wrap_length(7.15e9))


def test_classes_are_told_apart_within_the_range_alone(fresh, measured):
    trained = load_weights(fresh())
    inputs = features(measured.phase, measured.amplitude, "beat").astype(np.float32)
    with torch.inference_mode():
        weights = trained.network(torch.from_numpy(inputs)[None])[0]
    for start, stop in ((0, 21), (3, 9), (20, 21)):
        likeliest, odds = classify(trained, inputs, start, stop)
        share = torch.softmax(weights[start:stop], 0)
        np.testing.assert_allclose(odds, share.max(0).values.numpy(), atol=1e-5)
        taken = np.take_along_axis(share.numpy(), likeliest[None], 0)[0]
        np.testing.assert_allclose(taken, odds, atol=1e-5)
        assert odds.min() >= 1 / (stop - start) - 1e-6 and odds.max() <= 1
    assert (likeliest == 0).all() and (odds == 1).all()  # a single class is certain


@pytest.mark.parametrize("limits", [None, (0.9, 1.0), (0.76, 0.8), (0.94, 0.97)])
def test_unwrapping_obeys_the_range(fresh, measured, limits):
    result = cmtof.unwrap(measured, method="fast-scnn-light", weights=fresh(), range=limits)
    low, high = limits or measured.range
    mask = measured.mask
    depth = result.depth.to_numpy()
    assert (depth[mask] >= low - 1e-6).all() and (depth[mask] < high).all()
    assert np.isnan(depth[~mask]).all()
    assert (result.wrap_count.to_numpy()[~mask] == -1).all()
    count = result.wrap_count.to_numpy()[mask]
    assert count.min() >= np.floor(low / STEP) and count.max() <= np.floor(high / STEP)
    confidence = result.confidence.to_numpy()
    assert (confidence[mask] > 0).all() and confidence.max() <= 1
    assert result.attrs["method"] == "fast-scnn-light"


def test_depth_is_that_of_the_measured_phase(fresh, measured):
    estimate = unwrap_with_network(measured, weights=fresh())
    turns = estimate.depth / STEP - measured.phase[0] / (2 * np.pi)
    np.testing.assert_allclose(turns, np.rint(turns), atol=1e-4)


def test_the_weights_choose_the_network_and_its_features(fresh, measured):
    for name in MODELS:
        depth = unwrap_with_network(measured, weights=fresh(name)).depth
        assert depth.shape == measured.shape and np.isfinite(depth).all()


@pytest.mark.parametrize("shape", [(9, 9), (17, 40), (65, 66)])
def test_any_frame_size_and_both_protocols(fresh, shape):
    frame = Frame(np.full(shape, 1.1), np.full(shape, 0.5))
    for protocol in ("released", "full"):
        measured = cmtof.simulate(frame, protocol=protocol)
        path = fresh(protocol=protocol)
        assert unwrap_with_network(measured, weights=path).depth.shape == shape


def test_more_classes_than_the_range_asks_for_are_not_considered(fresh, measured):
    first, last = wraps_in_range(measured)
    depth = unwrap_with_network(measured, weights=str(fresh(protocol="full"))).depth
    assert depth.min() >= first * STEP and depth.max() < (last + 1) * STEP


def test_replaced_weights_are_read_anew(fresh, measured):
    path = fresh()
    before = unwrap_with_network(measured, weights=path)
    network = load_weights(path).network
    with torch.no_grad():
        network.output[1].bias[7] += 1e3  # type: ignore[index,operator]
    from cmtof.network.weights import read_card, save_weights

    save_weights(path, network, read_card(path))
    after = unwrap_with_network(measured, weights=path)
    assert (np.floor(after.depth / STEP + 1e-9) == 36 + 7).all()
    assert (after.depth != before.depth).any()


def test_masked_pixels_that_are_not_numbers_reach_no_other(fresh, measured):
    """A valid measurement may hold anything where it is masked; a network must not spread it."""
    broken = measured.dataset.copy(deep=True)
    mask = broken["mask"].to_numpy().copy()
    mask[:, :3] = 0
    broken["mask"] = (("y", "x"), mask)
    values = broken["correlation"].to_numpy().copy()
    values[..., :3] = np.nan
    broken["correlation"] = (("frequency", "step", "y", "x"), values)
    result = cmtof.unwrap(Measurement(broken), method="fast-scnn-light", weights=fresh())
    kept = mask.astype(bool)
    assert np.isfinite(result.depth.to_numpy()[kept]).all()
    assert np.isfinite(result.confidence.to_numpy()[kept]).all()


# --- what is refused ---------------------------------------------------------------------------


@pytest.mark.parametrize("limits", [(0.0, 1.195), (0.8, 2.0)])
def test_wraps_that_the_weights_do_not_know_are_refused(fresh, tilted_wall, limits):
    measured = cmtof.simulate(tilted_wall, protocol="full").between(*limits)
    with pytest.raises(ValueError, match=r"wraps within 36 to 56, which .*, got .*Narrow the"):
        unwrap_with_network(measured, weights=fresh())


@pytest.mark.parametrize("tones", [(7.15e9, 7.16e9), (7.0e9, 14.32e9), (7.15e9,)])
def test_other_frequencies_are_refused(fresh, tilted_wall, tones):
    measured = cmtof.simulate(tilted_wall, frequencies=tones)
    with pytest.raises(ValueError, match=r"7\.15 and 14\.32 GHz, .*trained at, got .*method beat"):
        unwrap_with_network(measured, weights=fresh())


def test_a_third_frequency_does_no_harm(fresh, tilted_wall):
    measured = cmtof.simulate(tilted_wall, frequencies=(7.15e9, 14.32e9, 21.5e9))
    assert np.isfinite(unwrap_with_network(measured, weights=fresh()).depth).all()


def test_missing_weights_are_named(measured, tmp_path):
    with pytest.raises(ValueError, match=r"the card of none\.safetensors"):
        cmtof.unwrap(measured, method="fast-scnn", weights=tmp_path / "none.safetensors")
