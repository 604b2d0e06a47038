"""Training: configurations, the same bits after a kill, learning, fine-tuning."""

import json
from copy import deepcopy
from pathlib import Path

import numpy as np
import torch
from numpy.testing import assert_allclose
from pytest import approx, fixture, mark, skip
from refusals import WRONG, refused

import cmtof
from cmtof.constants import FREQUENCY_SINGLE
from cmtof.correlation import TAU, wrap_count_from_depth
from cmtof.files import exclusive_lock
from cmtof.measurement import Measurement
from cmtof.network import training, tuning
from cmtof.network.data import batch_at, open_rooms
from cmtof.network.losses import IGNORED
from cmtof.network.recipe import PRESETS, read_config
from cmtof.network.training import Unwrapping, loss_of, train
from cmtof.network.tuning import fine_tune
from cmtof.network.weights import load_weights, read_card

CPU = {"accelerator": "cpu", "devices": 1, "quiet": True}


def unwrapping(config, init=None):
    return Unwrapping(config, open_rooms(config), Path(), init)


@mark.parametrize("name", PRESETS)
def test_presets_are_configurations(name):
    config = read_config(name, model="rapid", seed=4)
    assert (config.name, config.model, config.seed) == (name, "rapid", 4)
    assert config.stage_at(config.steps - 1)[0] is config.stages[-1]
    rates = [
        config.rate_at(step) for step in range(0, config.steps + 1, config.steps // 10)
    ]
    assert min(rates) > 0
    assert rates[-1] < 0.1 * max(rates)


@mark.slow
def test_the_miniature_beats_a_constant_answer(tmp_path):
    assert read_card(train(read_config("miniature"), tmp_path, **CPU)).gain[1] > 0


def test_stages_follow_each_other(config):
    assert [config.stage_at(step)[0].name for step in range(5)] == list("aaabb")
    assert config.rate_at(0) == approx(1e-3)  # half of the way up
    assert config.rate_at(1) == approx(2e-3 - 1e-3 / 3)


@mark.parametrize("changes, stage, message", WRONG["configurations"])
def test_bad_configurations_are_refused_in_one_line(
    tmp_path, config, changes, stage, message
):
    usual = config.stages[0].model_dump()
    path = tmp_path / "own.yml"
    path.write_text(json.dumps({"stages": [usual | stage]} | changes))
    with refused(message):
        read_config(path)
    with refused("out of miniature, cpu, table1", FileNotFoundError):
        read_config("nowhere")


def test_two_trainings_do_not_share_a_folder(tmp_path, config):
    with exclusive_lock(tmp_path), refused("Expected .* to be free"):
        train(config, tmp_path, **CPU)
    assert not list(tmp_path.iterdir())


@mark.parametrize(
    "changes",
    [{}, {"optimizer": "muon"}, {"model": "fast-scnn-public"}],
    ids=["adamw", "muon", "dropout"],
)
def test_killed_and_resumed_run_ends_with_the_same_weights(tmp_path, config, changes):
    config = config.model_copy(update=changes)
    whole = train(config, tmp_path / "whole", **CPU)
    parts = tmp_path / "parts"
    assert train(config, parts, minutes=0, **CPU) is None
    assert train(config, parts, minutes=0, resume=True, **CPU) is None
    second = train(config, parts, resume=True, **CPU)
    assert whole.read_bytes() == second.read_bytes()
    card = read_card(whole)
    assert (card.steps, card.crops, card.views) == (5, 10, 3)
    assert [found["step"] for found in card.curve] == [4]
    assert card.curve == read_card(second).curve
    with refused("Expected a new folder"):
        train(config, parts, **CPU)
    with refused("Expected the configuration of"):
        train(config.model_copy(update={"seed": 9}), parts, resume=True, **CPU)


def test_training_goes_on_from_given_weights(config, stored):
    path = stored()
    begun = unwrapping(config, path).network.state_dict()
    torch.testing.assert_close(
        begun, load_weights(path).network.state_dict(), rtol=0, atol=0
    )
    with refused("Expected weights of fast-scnn-light for full"):
        unwrapping(config.model_copy(update={"protocol": "full"}), path)


def test_weight_of_the_depth_is_that_of_the_configuration(config):
    assert unwrapping(config).network.model.depth_weight == 0.1
    changed = unwrapping(config.model_copy(update={"depth_weight": 0.0}))
    for network in (changed.network, changed.average):
        assert network.model.depth_weight == 0.0


def test_rooms_that_nothing_finds_are_refused():
    with refused("Expected a way to find the rooms"):
        open_rooms(read_config("cpu"))


@mark.parametrize("precision, flags", WRONG["devices"])
def test_what_this_machine_lacks_is_refused(tmp_path, config, precision, flags):
    if torch.cuda.is_available():
        skip("there is a GPU")
    with refused("Expected accelerator, devices, strategy and precision"):
        changed = config.model_copy(update={"precision": precision})
        train(changed, tmp_path, quiet=True, **flags)


@mark.parametrize("fast, wanted", [(True, "bf16-mixed"), (False, "32-true")])
def test_a_slow_processor_is_spared_bfloat16(monkeypatch, fast, wanted):
    monkeypatch.setattr(torch.cpu, "get_capabilities", lambda: {"avx512_bf16": fast})
    trainer = training._trainer(
        read_config("cpu"), precision="bf16-mixed", accelerator="cpu"
    )
    assert trainer.precision == wanted


@mark.parametrize("name", ["fast-scnn", "deep-tof", "rapid"])
def test_every_model_learns_a_batch_by_heart(config, name):
    """Ten steps on one batch bring its loss down."""
    module = unwrapping(config.model_copy(update={"model": name}))
    sample = module.sample_from_batch(batch_at(0, module.config, None))
    optimizer = torch.optim.Adam(module.network.parameters(), 3e-3)
    losses = []
    for _ in range(10):
        loss = loss_of(module.network.train(), sample)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        losses.append(float(loss.detach()))
    assert losses[-1] < 0.9 * losses[0]


def test_validation_scores_a_network_that_answers_with_the_middle(config):
    module = unwrapping(config)
    middle = torch.eye(21)[10].view(1, 21, 1, 1)
    module.average.forward = lambda x: middle.expand(1, 21, *x.shape[-2:])
    found = module.validate_average()
    assert found["validation"] == found["trivial"]["middle"]
    assert found["gain"][1] <= 0
    assert found["trivial"]["mode"].delta_lt_1 >= found["validation"].delta_lt_1


@fixture
def trained(stored):
    return load_weights(stored())


@fixture
def example(measurement):
    wraps = wrap_count_from_depth(measurement.depth, FREQUENCY_SINGLE)
    return measurement, np.where(measurement.mask, wraps, -1), measurement.depth


def test_fine_tuning_lowers_the_loss_and_leaves_the_rest(trained, example):
    before = deepcopy(trained.network.state_dict())
    how = {"steps": 12, "learning_rate": 2e-3, "crop": 32, "seed": 1}
    tuned, losses = fine_tune(trained, [example], **how)
    assert np.mean(losses[-3:]) < np.mean(losses[:3])
    after = tuned.network.state_dict()
    for name, tensor in trained.network.state_dict().items():
        assert torch.equal(tensor, before[name])
        assert "running" not in name or torch.equal(tensor, after[name])
    assert tuned.card.fine_tuned["steps"] == 12
    _, again = fine_tune(trained, [example], **how)
    assert again == losses


def test_crops_of_fine_tuning_move_over_the_classes(trained, stepped_wall, rng):
    """Without noise, wraps, phase and depth of a moved crop still belong together."""
    exact = cmtof.simulate(stepped_wall, noise_free=True)
    wraps = wrap_count_from_depth(exact.depth, FREQUENCY_SINGLE)
    view = tuning._view(trained, exact, wraps, exact.depth)
    pieces = [tuning._augmented_crop(view, trained.network, 24, rng) for _ in range(30)]
    _, label, phase, turns = map(np.stack, zip(*pieces, strict=True))
    known = label != IGNORED
    assert_allclose(np.exp(1j * (TAU * turns - phase))[known], 1, atol=1e-3)
    assert (label == np.floor(turns))[known].mean() > 0.99  # or on an edge
    assert len({int(np.median(one)) for one in label}) > 5


def test_unlabelled_pixels_teach_nothing(trained, example):
    measurement, wraps, depth = example
    half = np.where(np.arange(56) < 28, wraps, -1)
    moved = depth + (half < 0)
    first, second = (
        fine_tune(trained, [(measurement, half, z)], steps=2)[1] for z in (depth, moved)
    )
    assert first == second


def test_a_scan_that_is_mostly_masked_teaches_too(trained, example):
    """Its amplitudes are scaled by what is valid, as where a network answers."""
    measurement, *labels = example
    scan = measurement.dataset.assign_attrs(source="scan")
    scan["mask"][2:] = 0
    _, losses = fine_tune(trained, [(Measurement(scan), *labels)], steps=2)
    assert np.isfinite(losses).all()


@mark.parametrize("count", [0, 1])
def test_fine_tuning_refuses_what_has_no_labels(trained, example, count):
    measurement, wraps, depth = example
    blank = (measurement, np.full_like(wraps, -1), depth)
    with refused(f"got none in {count} measurements"):
        fine_tune(trained, [blank] * count)
