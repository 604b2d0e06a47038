"""The paper's learned baselines: sizes, targets, inputs, and what is done to wraps afterwards."""

import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor, nn
from typer.testing import CliRunner

import cmtof
from cmtof.methods import METHODS
from cmtof.cli import app
from cmtof.constants import FREQUENCIES
from cmtof.correlation import wrap_length
from cmtof.network import deep_tof, one_step, rapid, u_net
from cmtof.network.bands import Banded
from cmtof.network.building import build, build_network
from cmtof.network.configuration import MODELS, Config, wraps_of
from cmtof.network.inference import regress, unwrap_with_network
from cmtof.network.losses import IGNORED, regression_loss
from cmtof.network.measuring import Batch
from cmtof.network.module import Unwrapping
from cmtof.network.parts import Residual, padded
from cmtof.network.training import train
from cmtof.network.weights import Trained, load_weights, read_card

NAMES = ("u-net", "one-step", "deep-tof", "rapid")
REGRESSIONS = ("one-step", "deep-tof")
STEP = float(wrap_length(FREQUENCIES[0]))

SMALL: dict[str, Callable[..., Banded]] = {
    "u-net": lambda n=9, t="wraps": u_net.UNet(u_net.Architecture((6, 8, 10)), 4, n, t),
    "one-step": lambda n=9, t="depth": one_step.OneStep(
        one_step.Architecture((6, 8, 10)), 4, n, t
    ),
    "deep-tof": lambda n=9, t="depth": deep_tof.DeepToF(
        deep_tof.Architecture((6, 8, 10), blocks=2), 4, n, t
    ),
    "rapid": lambda n=9, t="wraps": rapid.Rapid(
        rapid.Architecture((6, 8, 10, 12), blocks=1, rates=(1, 2), pyramid=8, skip=4, decoder=8),
        4, n, t,
    ),
}  # fmt: skip


def used(network: Banded) -> Banded:
    """Eval mode, the norms as training might have left them."""
    generator = torch.Generator().manual_seed(1)
    for module in network.modules():
        if isinstance(module, nn.BatchNorm2d):
            module.running_mean.normal_(0, 0.3, generator=generator)  # type: ignore[union-attr]
            module.running_var.uniform_(0.5, 2, generator=generator)  # type: ignore[union-attr]
    return network.eval()


def image(*shape: int, seed: int = 0) -> Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed))


def count(network: nn.Module) -> int:
    return sum(weight.numel() for weight in network.parameters())


# --- networks ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("size", [(1, 1), (1, 40), (33, 1), (16, 16), (17, 31)])
@pytest.mark.parametrize("target", ["wraps", "depth"])
@torch.inference_mode()
def test_any_size_and_either_target(name: str, size: tuple[int, int], target: str):
    found = SMALL[name](9, target).eval()(image(2, 4, *size))
    assert found.shape == (2, 9 if target == "wraps" else 1, *size)
    assert torch.isfinite(found).all()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("size", [(1, 1), (40, 33)])
def test_gradients_reach_all_parameters_of_a_single_crop(name: str, size: tuple[int, int]):
    """In training mode, where a batch norm of one pixel would fail."""
    network = build_network(name, 5).train()
    network(image(1, network.inputs, *size)).square().mean().backward()
    assert all(p.grad is not None and torch.isfinite(p.grad).all() for p in network.parameters())
    reached = [n for n, p in network.named_parameters() if bool(p.grad.any())]
    if size != (1, 1):  # one pixel repeated has no spread: its norms are zero
        assert len(reached) == len(list(network.parameters()))


@pytest.mark.parametrize(
    ("name", "narrowed", "published"),
    [
        ("u-net", 1_161_573, 31_039_509),
        ("one-step", 1_116_609, 62_458_113),
        ("deep-tof", 1_123_889, 11_679_553),
        ("rapid", 1_112_981, 16_455_925),
    ],
)
def test_parameters_are_about_those_of_the_papers_network(name, narrowed: int, published: int):
    assert count(build_network(name, 21)) == narrowed
    assert narrowed == pytest.approx(1_167_621, rel=0.05)
    assert count(build_network(name, 358)) < 2e6
    home: Any = {"u-net": u_net, "one-step": one_step, "deep-tof": deep_tof, "rapid": rapid}[name]
    chosen = replace(MODELS[name], architecture=vars(home.PUBLISHED))
    with torch.device("meta"):
        assert count(build(chosen, 21)) == published


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("rows", [1, 2, 7, 29, 64])
@torch.inference_mode()
def test_bands_give_what_the_whole_gives(name: str, rows: int):
    network, x = used(SMALL[name]()), image(2, 4, 29, 22)
    found = network.in_bands(x, lambda weights: weights, rows)
    torch.testing.assert_close(found, network(x), atol=1e-5, rtol=1e-5)


@pytest.mark.parametrize("name", ["u-net", "rapid"])
@torch.inference_mode()
def test_the_head_alone_makes_classes(name: str):
    """So a frame of 358 classes is never held: the trunk does not know their number."""
    few, many = SMALL[name](3).eval(), SMALL[name](358).eval()
    x = image(1, 4, 20, 24)
    assert few.trunk(x).shape == many.trunk(x).shape
    assert few.trunk(x).shape[1] <= 10 and many.head(few.trunk(x)).shape[1] == 358


@torch.inference_mode()
def test_resized_features_give_the_resized_classes():
    """What `rapid` rests on: its last layer is linear, and so is the resize."""
    network = used(SMALL["rapid"]())
    coarse = image(1, 8, 6, 7)
    like = torch.zeros(1, 1, 24, 28)
    torch.testing.assert_close(
        network.output(rapid.resized(coarse, like)), rapid.resized(network.output(coarse), like),
        atol=1e-5, rtol=1e-5,
    )  # fmt: skip


@pytest.mark.parametrize("size", [(1, 1), (15, 16), (17, 33), (64, 48)])
def test_padding_repeats_the_border_alone(size: tuple[int, int]):
    x = image(1, 2, *size)
    found = padded(x, 16)
    height, width = size
    assert torch.equal(found[..., :height, :width], x)
    assert all(side % 16 == 0 and side >= 32 for side in found.shape[-2:])
    assert torch.equal(
        found[..., :height, width:], x[..., -1:].expand_as(found[..., :height, width:])
    )
    if min(size) > 32:
        assert found is x


@torch.inference_mode()
def test_a_residual_block_of_no_weights_is_a_relu():
    block = Residual(3, 3).eval()
    block.body[1].weight.zero_()  # type: ignore[operator,union-attr]
    x = image(1, 3, 5, 6)
    assert torch.equal(block(x), x.relu())
    assert Residual(3, 7, stride=2).eval()(x).shape == (1, 7, 3, 3)


@torch.inference_mode()
@pytest.mark.parametrize("name", REGRESSIONS)
def test_a_regression_starts_in_the_middle_and_counts_in_wraps(name: str):
    network = SMALL[name](358).eval()
    network.output.weight.zero_()  # type: ignore[union-attr,operator]
    network.output.bias.fill_(0.25)  # type: ignore[union-attr,operator]
    found = network(image(1, 4, 8, 9))
    torch.testing.assert_close(found, torch.full_like(found, 0.75 * 358))


@pytest.mark.parametrize("name", REGRESSIONS)
def test_mixed_precision_does_not_round_turns(name: str):
    """bfloat16 would know 358 wraps by steps of one or two."""
    network = SMALL[name](358).eval()
    with torch.inference_mode(), torch.autocast("cpu", dtype=torch.bfloat16):
        found = network(image(1, 4, 16, 16))
    assert found.dtype == torch.float32
    assert not torch.equal(found, found.bfloat16().float())


MEMORY = """
import sys, torch
from pathlib import Path
from cmtof.network.building import build_network
from cmtof.network.inference import classify, regress
from cmtof.network.weights import Trained
torch.set_num_threads(1)
network = build_network(sys.argv[1], 358).eval()
inputs = torch.randn(network.inputs, 768, 1024).numpy()
trained = Trained(network, {})
found = (regress if network.target == "depth" else classify)(trained, inputs)
# the peak of this process; ru_maxrss would begin with that of the one that started it
status = Path("/proc/self/status").read_text()
print(status.partition("VmHWM:")[2].split()[0])
"""


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_full_frame_of_358_classes_stays_below_two_gigabytes(name: str):
    found = subprocess.run([sys.executable, "-c", MEMORY, name], capture_output=True, text=True)
    assert found.returncode == 0, found.stderr
    assert 1024 * int(found.stdout) < 2e9


# --- models ------------------------------------------------------------------------------------


def test_models_say_what_each_is_given_and_asked():
    assert {name: MODELS[name].target for name in NAMES} == {
        "u-net": "wraps", "rapid": "wraps", "one-step": "depth", "deep-tof": "depth",
    }  # fmt: skip
    assert {n for n, m in MODELS.items() if m.mended} == {"rapid"}
    assert {n for n, m in MODELS.items() if m.features == "correlation"} == {"deep-tof"}
    for name in NAMES:
        assert METHODS[name].kind == "learned" and MODELS[name].network == name
        assert build_network(name, 21).target == MODELS[name].target
    assert MODELS["u-net"].depth_weight == MODELS["rapid"].depth_weight == 0


# --- the loss of a regression ------------------------------------------------------------------


def turns_and_label(seed: int = 3) -> tuple[Tensor, Tensor]:
    turns = 21 * torch.rand(2, 6, 7, generator=torch.Generator().manual_seed(seed))
    label = turns.floor().long()
    label[0, 2:4, 1:5] = IGNORED
    turns[0, 2, 2] = float("nan")
    return turns, label


def test_the_truth_costs_nothing_and_a_constant_error_its_share_of_the_range():
    turns, label = turns_and_label()
    for off in (0.0, 2.1, -4.2):
        found = (turns.nan_to_num() + off)[:, None]
        loss = regression_loss(found, label, turns, classes=21)
        assert float(loss.total) == pytest.approx(abs(off) / 21, abs=1e-6)
        assert loss.cross_entropy == 0 and loss.depth == loss.total


def test_the_gradient_counts_between_valid_pixels_alone():
    rows = torch.arange(6.0).view(1, 1, 6, 1).expand(1, 1, 6, 7).clone()
    label = torch.zeros(1, 6, 7).long()
    label[0, 5] = IGNORED
    rows[0, 0, 5] = 1e6
    flat = regression_loss(rows, label, rows[:, 0], classes=10)
    rough = regression_loss(rows, label, rows[:, 0], classes=10, smoothness=0.5)
    # one wrap a row, none a column
    assert float(flat.total) == 0 and float(rough.total) == pytest.approx(0.5 * 1 / 10)


def test_what_is_masked_reaches_no_gradient():
    turns, label = turns_and_label()
    found = image(2, 1, 6, 7).requires_grad_()
    regression_loss(found, label, turns, classes=21, smoothness=1e-3).total.backward()
    assert found.grad is not None and torch.isfinite(found.grad).all()
    assert not found.grad[:, 0][label == IGNORED].any()
    nothing = regression_loss(found, torch.full_like(label, IGNORED), turns, classes=21)
    nothing.total.backward()
    assert float(nothing.total.detach()) == 0


# --- regression at the end ---------------------------------------------------------------------


class Exact(nn.Module):
    """Says of each pixel what stands in its first channel."""

    def in_bands(self, x: Tensor, reduce: Callable[[Tensor], Tensor]) -> Tensor:
        return reduce(x[:, :1])


def test_an_exact_regression_gives_the_true_depth(measured, monkeypatch):
    """Turns to metres and back: wrap counts, depth and the range's ends."""
    truth = measured.depth.astype(float)
    turns = (truth / STEP - 36).astype(np.float32)
    card = {"model": "one-step", "classes": 21, "first_wrap": 36}
    card["validation_in_half_precision"] = {"delta_lt_1": 0.125}
    exact = Trained(Exact(), card)
    assert np.allclose(regress(exact, turns[None]), turns, equal_nan=True)
    monkeypatch.setattr("cmtof.network.inference._loaded", lambda *_: exact)
    monkeypatch.setattr("cmtof.network.inference.features", lambda *_: turns[None])
    result = cmtof.unwrap(measured, method="one-step", weights="any.safetensors")
    mask = measured.mask
    away = mask & (np.abs(truth / STEP - np.rint(truth / STEP)) > 1e-4)
    assert (result.wrap_count.to_numpy()[away] == np.floor(truth / STEP)[away]).all()
    assert np.abs(result.depth.to_numpy() - truth)[mask].max() < STEP / 2
    assert (result.confidence.to_numpy()[mask] == np.float32(0.125)).all()


@pytest.mark.parametrize("name", REGRESSIONS)
def test_a_regression_stays_in_range_and_its_confidence_is_one_number(fresh, measured, name: str):
    path = fresh(name)
    for limits in (measured.range, (0.9, 0.95)):
        estimate = unwrap_with_network(measured.between(*limits), weights=path)
        assert (estimate.depth >= limits[0]).all() and (estimate.depth < limits[1]).all()
        # a card without validation promises no more than a guess
        assert (estimate.confidence == 1 / 21).all()


@pytest.mark.parametrize("protocol", ["released", "full"])
def test_validation_counts_whole_turns(protocol):
    module = Unwrapping(Config(model="one-step", protocol=protocol))
    classes = wraps_of(protocol)[1]
    turns = torch.tensor([-3.0, 0.0, 0.99, 1.0, classes - 0.01, classes + 7.0]).view(1, 1, 1, 6)
    expected = [0, 0, 0, 1, classes - 1, classes - 1]
    assert module._wraps(turns).flatten().tolist() == expected


# --- training ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_the_loss_of_one_batch_falls(name: str):
    """A tilted wall without much noise, thirty steps."""
    x = torch.linspace(0, 1, 20)
    depth = (0.8 + 0.2 * x + 0.1 * x[:, None])[None].repeat(2, 1, 1)
    batch = Batch(depth, torch.full_like(depth, 0.7), torch.tensor([50.0, 50.0]))
    module = Unwrapping(Config(model=name))
    sample = module._measured(batch, image(4, 2, 2, 20, 20))
    optimizer = torch.optim.Adam(module.parameters(), 2e-3)
    losses = []
    for _ in range(30):
        loss = module._loss(sample)[0].total
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        losses.append(float(loss.detach()))
    assert losses[-1] < 0.4 * losses[0]


CPU = {"quiet": True, "accelerator": "cpu", "devices": 1}

lightning = pytest.mark.filterwarnings(
    "ignore:The '.*_dataloader' does not have many workers",
    "ignore:.*isinstance.treespec, LeafSpec.* is deprecated",
)


@lightning
@pytest.mark.parametrize("name", ["deep-tof", "u-net"])
def test_each_kind_trains_in_mixed_precision(tiny, tiny_tree, tmp_path, name: str):
    config = replace(tiny, epochs=1, crops=2, model=name, precision="bf16-mixed", protocol="full")
    path = train(config, tmp_path, tree=tiny_tree, **CPU)
    assert path is not None
    trained = load_weights(path)
    assert all(torch.isfinite(weight).all() for weight in trained.network.parameters())
    assert (trained.card["model"], trained.card["classes"]) == (name, 358)


@lightning
@pytest.mark.slow
@pytest.mark.parametrize("name", ["one-step", "rapid"])
def test_the_command_line_trains_and_unwraps(tiny_tree, measured, tmp_path: Path, name: str):
    """On the small frames: card, weights, a result."""
    source = tmp_path / "tiny.yml"
    source.write_text(
        "crop: 32\nepochs: 2\ncrops: 8\nbatch: 4\nlearning_rate: 3.0e-3\n"
        "rooms: {seed: 1, scenes: 10, views: 2, height: 64, width: 64}\n"
    )
    arguments = ["train", str(source), "--model", name, "-o", str(tmp_path / "run")]
    arguments += ["--data", str(tiny_tree), "--accelerator", "cpu"]
    ended = CliRunner().invoke(app, arguments)
    assert ended.exit_code == 0, ended.output
    path = tmp_path / "run" / f"{name}.released.safetensors"
    card = read_card(path)
    assert card["model"] == name and card["parameters"] == count(build_network(name, 21))
    assert len(card["validation"]) == 2
    file, out = tmp_path / "m.nc", tmp_path / "out.nc"
    measured.save(file)
    again = CliRunner().invoke(
        app, ["unwrap", str(file), "-o", str(out), "--method", name, "--weights", str(path)]
    )
    assert again.exit_code == 0, again.output
    result = cmtof.unwrap(measured, method=name, weights=path)
    confidence = result.confidence.to_numpy()[measured.mask]
    assert (confidence <= 1).all()
    if MODELS[name].target == "depth":
        rate = card["validation_in_half_precision"]["delta_lt_1"]
        assert np.allclose(confidence, rate)
