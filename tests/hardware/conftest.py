"""A world of devices on wires."""

from types import SimpleNamespace

from pytest import fixture
from wire import RIG, WALL, World


@fixture
def world_of(monkeypatch, own_folder):
    """Maker of the peers of a rig before a scene; what the host waits for passes on their clock."""
    made = []

    def make(rig, **before):
        world = World(rig, **before)
        made.append(world)
        host = SimpleNamespace(monotonic=world.now, sleep=world.sleep, time=world.date)
        for module in ("apt", "rf", "scpi"):
            monkeypatch.setattr(f"cmtof.hardware.{module}.time", host)
        for name in vars(host):
            monkeypatch.setattr(f"cmtof.hardware.bench.{name}", getattr(host, name))
        return world

    yield make
    for world in made:
        world.close()


@fixture
def world(world_of):
    """Peers of a rig before a wall."""
    return world_of(RIG, scene=WALL, seed=4)
