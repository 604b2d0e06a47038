"""Small networks and measurements that the tests of the learned unwrapping share."""

import torch
import yaml
from pytest import fixture

import cmtof
from cmtof.network.features import CLASSES
from cmtof.network.models import build_network
from cmtof.network.recipe import Config
from cmtof.network.training import norms
from cmtof.network.weights import read_card, save_weights, weights_path


@fixture(autouse=True)
def one_thread():
    """Keep torch to one thread, and its random state as it was."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    with torch.random.fork_rng():
        yield
    torch.set_num_threads(threads)


@fixture
def measurement(stepped_wall):
    return cmtof.simulate(stepped_wall, noise=300.0)


RECIPE = """
model: fast-scnn-light
rooms: null
seed: 3
save_every: 2
validate_every: 2
validation_views: 3
stages:
  - {name: a, crops: 6, crop: 32, batch: 2, noise: [30, 60], rate: [2.0e-3, 1.0e-3], warm: 2}
  - {name: b, crops: 4, crop: 48, batch: 2, noise: [60, 60], rate: [1.0e-3, 1.0e-4], warm: 1}
"""


@fixture
def config():
    """Two stages of a few steps, without rooms."""
    return Config.model_validate(yaml.safe_load(RECIPE))


def card(model="fast-scnn-light", protocol="released", **changes):
    """Card of weights that have been trained, as if of another model."""
    first, classes = CLASSES[protocol]
    held = read_card(weights_path("fast-scnn-light", "released"))
    told = {
        "model": model,
        "protocol": protocol,
        "first_wrap": first,
        "classes": classes,
    }
    return held.model_copy(update=told | changes)


def worn(network):
    """The network, ready, with norms that have seen something."""
    for norm in norms(network):
        norm.running_mean.uniform_(-1, 1)
        norm.running_var.uniform_(0.5, 2)
        torch.nn.init.uniform_(norm.weight, 0.5, 2)
    return network.eval()


@fixture
def stored(tmp_path):
    """Maker of stored weights: a model with fresh weights and a card."""

    def store(model="fast-scnn-light", protocol="released", **changes):
        torch.manual_seed(0)
        path = weights_path(model, protocol, tmp_path)
        save_weights(
            path, build_network(model, protocol), card(model, protocol, **changes)
        )
        return path

    return store
