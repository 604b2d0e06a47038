"""What a training is made of: read, checked, refused in words."""

import pytest
import yaml

from cmtof.network.configuration import (
    MODELS,
    Config,
    Rooms,
    config_from_dict,
    configurations,
    read_config,
    wraps_of,
)
from cmtof.network.features import FEATURE_SETS

SHIPPED = ("common", "cpu", "gpu", "paper", "smoke")


def test_the_shipped_configurations_are_listed_with_their_first_lines():
    found = configurations()
    assert set(SHIPPED) <= set(found)
    assert all(line and not line.startswith("#") for line in found.values())


@pytest.mark.parametrize("name", SHIPPED)
def test_every_shipped_configuration_reads(name: str):
    config = read_config(name)
    assert config.name == name
    assert config.model in MODELS and config.protocol in ("released", "full")
    assert config.rooms.scenes >= 10  # of ten, one validates and one tests
    assert config_from_dict(config.as_dict()) == config
    assert yaml.safe_load(yaml.safe_dump(config.as_dict())) == config.as_dict()


def test_the_papers_configuration_is_what_the_paper_states():
    config = read_config("paper")
    assert (config.epochs, config.crops, config.batch, config.crop) == (1000, 500, 12, 512)
    assert (config.noise, config.noise_jitter, config.learning_rate) == (1200, 0.25, 1e-3)
    assert MODELS[config.model].depth_weight == 0.1
    assert config.warm_up == 0.05 and config.weight_decay == 5e-5


def test_rows_of_table_1_differ_by_what_their_names_say():
    rows = {name: model for name, model in MODELS.items() if model.network == "fast-scnn"}
    rows.pop("fast-scnn-released")
    assert MODELS["fast-scnn-ce"].depth_weight == 0
    assert {n for n, m in rows.items() if m.depth_weight == 0.1} == set(rows) - {"fast-scnn-ce"}
    assert MODELS["fast-scnn-ce"].features == MODELS["fast-scnn"].features == "proposed"
    for name in ("fourier", "phase"):
        assert MODELS[f"fast-scnn-{name}"].features == name
    for name in ("fast-scnn", "fast-scnn-ce", "fast-scnn-fourier", "fast-scnn-phase"):
        assert not MODELS[name].architecture
    assert {model.features for model in MODELS.values()} <= FEATURE_SETS.keys()


@pytest.mark.parametrize(
    ("epochs", "crops", "batch", "steps"),
    [(1, 1, 1, 1), (3, 8, 4, 6), (3, 9, 4, 9), (1000, 500, 12, 42_000), (2, 3, 12, 2)],
)
def test_steps_count_the_last_smaller_batch(epochs: int, crops: int, batch: int, steps: int):
    assert Config(epochs=epochs, crops=crops, batch=batch).steps == steps


def test_wraps_of_both_protocols():
    assert wraps_of("released") == (36, 21)
    assert wraps_of("full") == (0, 358)
    with pytest.raises(ValueError, match=r"'released' or 'full', got 'half'\. Choose one"):
        wraps_of("half")


def test_changes_stand_in_place_of_the_files_and_none_changes_nothing():
    config = read_config("smoke", model="fast-scnn-ce", protocol=None, seed=7)
    assert (config.model, config.protocol, config.seed) == ("fast-scnn-ce", "released", 7)
    assert read_config("smoke", model=None, seed=None) == read_config("smoke")


def test_ones_own_file_is_named_after_itself(tmp_path):
    path = tmp_path / "mine.yml"
    path.write_text("rooms: {height: 64, width: 96}\ncrop: 48\nlearning_rate: 2\n")
    config = read_config(path)
    assert (config.name, config.crop, config.rooms) == ("mine", 48, Rooms(height=64, width=96))
    path.write_text("name: other\n")
    assert read_config(str(path)).name == "other"
    path.write_text("")
    assert read_config(path) == Config(name="mine")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("crosp: 3", r"settings out of batch, .*, got crosp\. Correct the name"),
        ("rooms: {seeds: 3}", "unexpected keyword argument 'seeds'"),
        ("rooms: 3", "got .* must be a mapping, not int"),
        ("model: v-net", r"a model out of fast-scnn, .*, got v-net\. Choose one"),
        ("protocol: half", "'released' or 'full', got 'half'"),
        ("crop: 513", r"crops within frames of 512x512, got 513\. Take smaller"),
        ("epochs: 0", r"epochs >= 1, got 0\. Raise it"),
        ("batch: 0", "batch >= 1"),
        ("crops: -1", "crops >= 1"),
        ("crop: 0", "crop >= 1"),
        ("{epochs: 2, validate_every: 3}", "validate_every <= epochs, got 3 and 2"),
        ("epochs: many", "numbers in a configuration"),
        ("epochs: 2.5", "epochs such as 1000, got 2.5"),
        ("learning_rate: 2e-3", "learning_rate such as 0.001, got '2e-3'.*takes 2.0e-3"),
        ("flips: 1", "flips such as True, got 1"),
        ("rooms: {seed: a}", "seed such as 1, got 'a'"),
        ("- 1\n- 2", r"names and values in .*, got \[1, 2\]"),
        ("a: [", "YAML in"),
    ],
)
def test_what_no_training_is_made_of_is_refused(tmp_path, text: str, message: str):
    path = tmp_path / "mine.yml"
    path.write_text(text)
    with pytest.raises(ValueError, match=f"(?s)Expected .*{message}"):
        read_config(path)


def test_an_unknown_configuration_is_refused_with_those_that_there_are():
    with pytest.raises(FileNotFoundError, match=r"common, cpu, .*smoke, or a YAML file, got big"):
        read_config("big")
