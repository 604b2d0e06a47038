"""Weights: cards, hashes, states; unwrapping whole images and bands alike, bad input refused."""

import json

import numpy as np
import torch
from numpy.testing import assert_allclose
from pytest import approx, mark, warns
from refusals import WRONG, refused
from tests.network.conftest import card
from walls import lit

import cmtof
from cmtof import methods
from cmtof.correlation import TAU, centred, phase_from_depth
from cmtof.measurement import tiles
from cmtof.network import inference, weights
from cmtof.network.features import FULL_AMPLITUDE
from cmtof.network.models import build_network


def test_weights_come_back_in_half_precision_with_their_card(stored):
    trained = weights.load_weights(path := stored())
    torch.manual_seed(0)
    fresh = build_network("fast-scnn-light").state_dict()
    torch.testing.assert_close(
        trained.network.state_dict(), fresh, rtol=1e-3, atol=1e-4
    )
    assert trained.card == weights.read_card(path) and not trained.network.training


def test_state_is_computed_from_the_gain_and_untrained_weights_warn(
    stored, measurement
):
    for low, expected in ((0.05, "trained"), (-0.01, "untrained")):
        path = stored(gain=(0.1, low, 0.2))
        assert weights.state("fast-scnn-light", "released", path.parent) == expected
    assert weights.state("fast-scnn-light", "full", path.parent) == "no weights"
    with warns(UserWarning, match="fast-scnn-light.released is untrained"):
        cmtof.unwrap(measurement, method="fast-scnn-light", weights=path)


def test_weights_with_the_fewest_classes_are_found(stored):
    narrow, wide = stored(), stored(protocol="full")
    assert weights.find_weights("fast-scnn-light", 40, 50, narrow.parent) == narrow
    assert weights.find_weights("fast-scnn-light", 3, 50, narrow.parent) == wide


@mark.parametrize("changes, message", WRONG["cards"])
def test_cards_that_do_not_fit_are_refused(stored, changes, message):
    path = stored()
    held = json.loads(path.with_suffix(".json").read_text())
    path.with_suffix(".json").write_text(json.dumps(held | changes))
    for load in (weights.load_weights, inference.load_network):
        with refused(message):
            load(path)


def test_weights_that_are_not_numbers_or_not_there_are_refused(tmp_path):
    path = weights.weights_path("fast-scnn-light", "released", tmp_path)
    network = build_network("fast-scnn-light")
    network.output.bias.data[3] = torch.nan
    weights.save_weights(path, network, card())
    with refused("NaN or infinity"):
        weights.load_weights(path)
    path.unlink()
    with refused("no file", OSError):
        weights.load_weights(path)


@mark.parametrize("name", ["fast-scnn-light", "one-step", "rapid"])
def test_classes_agree_with_the_measured_phase(stored, measurement, name):
    depth, sure = inference.unwrap_with_network(measurement, weights=stored(name))
    assert (sure == card().validation.delta_lt_1).all() == (name == "one-step")
    if name == "one-step":
        return  # classes agree with the measured phase, a regression need not
    off = phase_from_depth(depth, measurement.frequencies[0]) - measurement.phase[0]
    assert abs(centred(off)).max() < 1e-4


@mark.parametrize("name", ["fast-scnn", "kde", "mrf"])
def test_what_would_take_too_much_memory_goes_in_tiles_like_the_whole(
    stored, monkeypatch, name
):
    wall = lit(np.full((640, 24), 0.93), 0.5)
    measurement, how = cmtof.simulate(wall, noise=500.0), {"method": name}
    if name == "fast-scnn":
        how["weights"] = stored(name)
    whole, seen = cmtof.unwrap(measurement, **how).wrap_count, []
    monkeypatch.setattr(methods, "MOST_MEMORY", 2**22)
    monkeypatch.setattr(
        methods, "tiles", lambda *given: seen.extend(tiles(*given)) or seen
    )
    found = cmtof.unwrap(measurement, **how).wrap_count
    assert len(seen) == 5
    assert (found == whole).mean() > 0.99  # noise is estimated in each tile


def test_amplitudes_in_volts_are_scaled_to_a_white_surface(measurement):
    def amplitude(scale):
        scaled = measurement.dataset.assign(
            correlation=scale * measurement.dataset.correlation
        )
        return inference.network_images(cmtof.Measurement(scaled), "proposed")[1]

    assert_allclose(amplitude(1.0), measurement.amplitude, rtol=1e-5)
    assert_allclose(amplitude(1e-6), amplitude(1e-4), rtol=1e-4)
    assert np.quantile(amplitude(1e-6), 0.9, axis=(1, 2)) == approx(FULL_AMPLITUDE)


def test_range_and_frequencies_that_do_not_fit_are_refused(
    stored, stepped_wall, measurement
):
    with refused("Expected wraps within 36 to 56"):
        inference.unwrap_with_network(measurement.between(0.6, 1.1), weights=stored())
    other = cmtof.simulate(stepped_wall, frequencies=(7.15e9, 7.16e9))
    with refused(r"Expected 7.15 and 14.32 GHz, .* got 7.15, 7.16 GHz"):
        inference.unwrap_with_network(other, weights=stored())


def test_raw_correlations_are_taken_by_their_psi(stored, stepped_wall):
    path = stored("deep-tof")
    depths = []
    for order in ([0, 1, 2, 3], [0, 3, 1, 2]):
        psi = np.multiply(order, TAU / 4)
        m = cmtof.simulate(stepped_wall, noise_free=True, psi=psi)
        depths.append(inference.unwrap_with_network(m, weights=path)[0])
    assert_allclose(*depths, atol=1e-5)
    skewed = cmtof.simulate(stepped_wall, psi=np.arange(4) * TAU / 4 + 0.1)
    with refused(r"Expected correlations at psi = 0, 1/2"):
        inference.unwrap_with_network(skewed, weights=path)
