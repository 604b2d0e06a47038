"""A trained network goes on learning from labels that do not cover every pixel."""

import numpy as np
import pytest
import torch

import cmtof
from cmtof.constants import FREQUENCIES
from cmtof.correlation import wrap_count_from_depth
from cmtof.measurement import Measurement
from cmtof.network.building import build_network
from cmtof.network.configuration import wraps_of
from cmtof.network.finetuning import Labelled, fine_tune
from cmtof.network.weights import Trained, load_weights, save_weights
from cmtof.scenes.frame import Frame


def network(model="fast-scnn-light", protocol="released") -> Trained:
    first, classes = wraps_of(protocol)
    torch.manual_seed(0)
    card = {"model": model, "protocol": protocol, "classes": classes, "first_wrap": first}
    return Trained(build_network(model, classes).eval(), card)


def example(seed=0, share=0.5, side=32) -> Labelled:
    """A tilted wall of the released range; the right part has no labels."""
    x, y = np.meshgrid(np.linspace(0, 1, side), np.linspace(0, 1, side))
    depth = 0.8 + 0.25 * x + 0.1 * y
    measurement = cmtof.simulate(Frame(depth, 0.3 + 0.6 * y, name="wall"), seed=seed)
    truth = np.asarray(measurement.depth, float)
    return Labelled(measurement, wrap_count_from_depth(truth, FREQUENCIES[0]), x < share, truth)


def weights(trained: Trained) -> torch.Tensor:
    return torch.cat([p.detach().flatten() for p in trained.network.parameters()])


def test_the_loss_falls_and_what_went_in_stays():
    before = network()
    kept = weights(before).clone()
    found = fine_tune(before, [example()], steps=6, learning_rate=1e-2, crop=32, batch=1)
    assert len(found.losses) == 6
    assert min(found.losses[-2:]) < 0.9 * found.losses[0]
    assert torch.equal(weights(before), kept)
    assert not torch.equal(weights(found.trained), kept)
    assert not found.trained.network.training


def test_what_is_masked_teaches_nothing():
    right = example()
    wrong = right._replace(
        wraps=np.where(right.mask, right.wraps, 40), depth=np.where(right.mask, right.depth, np.nan)
    )
    one, two = (fine_tune(network(), [e], steps=1, crop=32, batch=1) for e in (right, wrong))
    assert one.losses == two.losses
    assert torch.equal(weights(one.trained), weights(two.trained))


def test_labels_decide():
    right = example()
    moved = right._replace(wraps=right.wraps + 1, depth=right.depth + 0.021)
    one, two = (fine_tune(network(), [e], steps=1, crop=32, batch=1) for e in (right, moved))
    assert one.losses != two.losses


def test_running_means_stay_as_they_were():
    before = network()
    kept = {k: v.clone() for k, v in before.network.state_dict().items() if "running" in k}
    found = fine_tune(before, [example()], steps=1, crop=16)
    state = found.trained.network.state_dict()
    assert kept and all(torch.equal(state[k], v) for k, v in kept.items())


def test_the_seed_decides_and_the_world_is_left_alone():
    torch.manual_seed(4)
    wanted = torch.rand(1)
    trained = network()
    torch.manual_seed(4)
    one, two, other = (
        fine_tune(trained, [example()], steps=1, crop=16, batch=1, seed=s) for s in (1, 1, 2)
    )
    assert torch.equal(torch.rand(1), wanted)
    assert one.losses == two.losses != other.losses


def test_a_regression_is_tuned_too():
    found = fine_tune(network("one-step"), [example()], steps=1, crop=32, batch=1)
    assert np.isfinite(found.losses).all()


def test_the_card_tells_and_can_be_stored(tmp_path):
    found = fine_tune(network(), [example()], steps=1, crop=32, batch=1)
    note = found.trained.card["fine_tuned"]
    assert note["labelled_pixels"] == 32 * 16 and note["examples"] == 1
    path = tmp_path / "tuned.released.safetensors"
    save_weights(path, found.trained.network, found.trained.card)
    assert load_weights(path).card["fine_tuned"] == note


def test_bad_input_is_refused():
    good = example()
    with pytest.raises(ValueError, match="Expected examples, steps"):
        fine_tune(network(), [])
    with pytest.raises(ValueError, match="Expected mask of the measurement's shape"):
        fine_tune(network(), [good._replace(mask=good.mask[:5])])
    with pytest.raises(ValueError, match="Expected labels among the wraps 36 to 56, got none"):
        fine_tune(network(), [good._replace(wraps=good.wraps + 100)])
    phases = Measurement.from_phase(good.measurement.phase, FREQUENCIES, range_min=0.5)
    with pytest.raises(ValueError, match="raw correlations"):
        fine_tune(network("deep-tof"), [good._replace(measurement=phases)])
