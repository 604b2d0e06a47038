"""Small networks and measurements that the tests of the learned unwrapping share."""

import torch
from pytest import fixture

import cmtof
from cmtof.network.features import CLASSES
from cmtof.network.models import build_network
from cmtof.network.recipe import Config, Stage
from cmtof.network.weights import Card, Rates, save_weights, weights_path


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


@fixture
def config():
    """Two stages of a few steps, without rooms."""
    first = Stage(
        name="a", crops=6, crop=32, batch=2, noise=(30, 60), rate=(2e-3, 1e-3), warm=2
    )
    last = Stage(
        name="b", crops=4, crop=48, batch=2, noise=(60, 60), rate=(1e-3, 1e-4), warm=1
    )
    return Config(
        model="fast-scnn-light", stages=(first, last), rooms=None, save_every=2, validate_every=2,
        validation_views=3, seed=3,
    )  # fmt: skip


def card(
    model="fast-scnn-light", protocol="released", gain=(0.1, 0.05, 0.15), **changes
):
    """Card of made-up weights."""
    first, classes = CLASSES[protocol]
    rates = Rates(delta_lt_1=0.3, delta_lt_2=0.6, delta_lt_3=0.7, delta_ge_10=0.05)
    held = Card(
        model=model, protocol=protocol, classes=classes, first_wrap=first, parameters=1,
        configuration={}, data="none", crops=1, steps=1, minutes=0.1, hardware="none", versions={},
        curve=[], views=3, validation=rates, trivial={"middle": rates}, gain=gain,
    )  # fmt: skip
    return held.model_copy(update=changes)


@fixture
def stored(tmp_path):
    """Maker of stored weights: a model with fresh weights and a made-up card, or another one."""

    def store(model="fast-scnn-light", protocol="released", **changes):
        torch.manual_seed(0)
        path = weights_path(model, protocol, tmp_path)
        save_weights(
            path, build_network(model, protocol), card(model, protocol, **changes)
        )
        return path

    return store
