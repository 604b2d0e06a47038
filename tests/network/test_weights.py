"""Weights on disk: what is loaded is what was saved, or nothing is."""

import hashlib
import json
import pickle
from pathlib import Path

import pytest
import torch
from safetensors.torch import load_file

from cmtof.network.building import build_network
from cmtof.network.weights import (
    find_weights,
    halved,
    load_weights,
    read_card,
    save_weights,
    shipped,
    weights_path,
)

LIGHT = "fast-scnn-light"


def rewrite(path: Path, content: bytes) -> None:
    """Put other bytes in the place of weights, with a card that vouches for them."""
    path.write_bytes(content)
    card = read_card(path) | {"sha256": hashlib.sha256(content).hexdigest()}
    path.with_suffix(".json").write_text(json.dumps(card))


def change_card(path: Path, **changes) -> None:
    card = read_card(path) | changes
    kept = {key: value for key, value in card.items() if value is not None}
    path.with_suffix(".json").write_text(json.dumps(kept))


def test_the_card_tells_the_file(fresh):
    path = fresh(note="never trained")
    card = read_card(path)
    assert card["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
    assert card["bytes"] == path.stat().st_size
    assert (card["model"], card["classes"], card["first_wrap"]) == (LIGHT, 21, 36)
    assert card["note"] == "never trained"
    assert sorted(p.suffix for p in path.parent.iterdir()) == [".json", ".safetensors"]


def test_equal_weights_give_equal_bytes(fresh):
    path = fresh()
    once = path.read_bytes()
    assert fresh().read_bytes() == once


@pytest.mark.parametrize("name", [LIGHT, "fast-scnn", "fast-scnn-released"])
def test_half_precision_costs_little(fresh, name: str):
    """Half a part in 2048 of each weight: some hundredths of the logits' spread at most."""
    path = fresh(name)
    torch.manual_seed(0)
    network = build_network(name, 21).eval()
    trained = load_weights(path)
    assert not trained.network.training
    assert {p.dtype for p in trained.network.parameters()} == {torch.float32}
    image = torch.randn(1, network.inputs, 40, 40, generator=torch.Generator().manual_seed(2))
    with torch.inference_mode():
        expected, found = network(image), trained.network(image)
    assert not torch.equal(expected, found)
    assert (expected - found).std() < 0.03 * expected.std()


def test_saving_what_was_loaded_changes_nothing(fresh, tmp_path):
    path = fresh()
    again = tmp_path / "again" / path.name
    again.parent.mkdir()
    save_weights(again, load_weights(path).network, read_card(path))
    assert again.read_bytes() == path.read_bytes()


def test_norms_beyond_half_precision_stay_what_they_are(fresh):
    path = fresh()
    network = load_weights(path).network
    network.state_dict()["down.0.1.running_var"].fill_(1e6)
    save_weights(path, network, read_card(path))
    stored = load_file(path)
    assert stored["down.0.1.running_var"].dtype == torch.float32
    assert stored["down.0.0.weight"].dtype == torch.float16
    assert float(load_weights(path).network.state_dict()["down.0.1.running_var"][0]) == 1e6


def test_halving_keeps_counts_whole():
    state = build_network(LIGHT, 21).state_dict()
    kept = halved(state)
    assert kept.keys() == state.keys()
    counts = {kept[key].dtype for key in kept if "num_batches" in key}
    assert counts == {torch.int64}


# --- what is refused ---------------------------------------------------------------------------


def test_other_bytes_than_the_cards_are_refused(fresh):
    path = fresh()
    content = bytearray(path.read_bytes())
    content[-1] ^= 1
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"with the hash \w{12}… in .*, got \w{12}…\. Fetch them"):
        load_weights(path)


def test_weights_without_a_card_are_refused(fresh):
    path = fresh()
    path.with_suffix(".json").unlink()
    with pytest.raises(ValueError, match=r"the card of .* in .*\.json, got .*Keep both together"):
        load_weights(path)


@pytest.mark.parametrize("text", ["", "{", "[]", "3", "{}", '{"model": "fast-scnn"}'])
def test_what_is_no_card_is_refused(fresh, text: str):
    path = fresh()
    path.with_suffix(".json").write_text(text)
    with pytest.raises(ValueError, match="Keep both together"):
        load_weights(path)


def test_a_card_without_weights_is_refused(fresh):
    path = fresh()
    path.unlink()
    with pytest.raises(ValueError, match=r"Expected weights in .*, got none\. Fetch or train"):
        load_weights(path)


def test_weights_of_an_unknown_model_are_refused(fresh):
    path = fresh()
    change_card(path, model="v-net")
    with pytest.raises(ValueError, match=r"out of fast-scnn, .* got v-net .*version that trained"):
        load_weights(path)


@pytest.mark.parametrize("changes", [{"model": "fast-scnn"}, {"classes": 22}])
def test_weights_that_fit_another_network_are_refused(fresh, changes):
    path = fresh()
    change_card(path, **changes)
    with pytest.raises(ValueError, match=r"Expected weights of .* classes .*, got others .*Train"):
        load_weights(path)


class Trap:
    """Leaves a file where it is unpickled."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)


@pytest.mark.parametrize("kind", ["pickle", "torch"])
def test_a_pickle_is_refused_and_not_run(fresh, tmp_path, kind: str):
    path, sprung = fresh(), tmp_path / "sprung"
    if kind == "pickle":
        content = pickle.dumps(Trap(sprung))
    else:
        torch.save(Trap(sprung), tmp_path / "trap.pt")
        content = (tmp_path / "trap.pt").read_bytes()
    rewrite(path, content)
    with pytest.raises(ValueError, match="got others"):
        load_weights(path)
    assert not sprung.exists()
    pickle.loads(pickle.dumps(Trap(sprung)))
    assert sprung.exists()  # it would have


# --- which are found ---------------------------------------------------------------------------


def test_weights_are_listed_by_model_and_protocol(fresh, tmp_path):
    for model, protocol in ((LIGHT, "released"), (LIGHT, "full"), ("fast-scnn", "released")):
        fresh(model, protocol)
    assert set(shipped(tmp_path)) == {
        (LIGHT, "released"), (LIGHT, "full"), ("fast-scnn", "released"),
    }  # fmt: skip
    assert shipped(tmp_path / "none") == {}


def test_those_with_the_fewest_classes_are_found(fresh, tmp_path):
    small, large = fresh(), fresh(protocol="full")
    assert find_weights(LIGHT, 36, 56, tmp_path) == small
    assert find_weights(LIGHT, 40, 41, tmp_path) == small
    for first, last in ((35, 56), (36, 57), (0, 357), (100, 100)):
        assert find_weights(LIGHT, first, last, tmp_path) == large


def test_wraps_that_no_weights_know_are_refused(fresh, tmp_path):
    fresh()
    with pytest.raises(ValueError, match=r"for the wraps 30 to 40, got 36 to 56\. Narrow"):
        find_weights(LIGHT, 30, 40, tmp_path)
    with pytest.raises(ValueError, match=r"of fast-scnn for .*, got none\. .*cmtof train"):
        find_weights("fast-scnn", 36, 56, tmp_path)


def test_every_shipped_file_is_whole_and_all_are_small():
    found = shipped()
    for (model, protocol), path in found.items():
        trained = load_weights(path)
        assert (trained.card["model"], trained.card["protocol"]) == (model, protocol)
        assert path == weights_path(model, protocol)
    assert sum(path.stat().st_size for path in found.values()) < 40e6
