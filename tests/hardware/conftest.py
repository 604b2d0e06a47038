"""A world of devices on wires."""

from types import SimpleNamespace

import pytest
from wire import RIG, WALL, World


@pytest.fixture
def world(monkeypatch):
    """Peers of a rig before a wall; what the host waits for passes on their clock."""
    made = World(RIG, WALL, seed=4)
    host = SimpleNamespace(monotonic=made.now, sleep=made.sleep)
    for module in ("apt", "rf", "scpi"):
        monkeypatch.setattr(f"cmtof.hardware.{module}.time", host)
    for name in vars(host):
        monkeypatch.setattr(f"cmtof.hardware.bench.{name}", getattr(host, name))
    yield made
    made.close()
