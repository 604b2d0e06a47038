"""Bluesky's RunEngine before the devices of a bench."""

import threading

import pytest
from numpy.testing import assert_allclose

from cmtof.hardware.bluesky import adapters
from cmtof.hardware.device import Unsafe
from cmtof.hardware.rig import Rig
from cmtof_lab.rehearsal import simulated_bench

bluesky = pytest.importorskip("bluesky", exc_type=ImportError)
plans = pytest.importorskip("bluesky.plans")


@pytest.fixture
def parts():
    bench = simulated_bench(Rig.default())
    bench.set_up()
    return adapters(bench)


def test_a_plan_moves_the_stage_and_reads_the_meter(parts):
    heard = []
    plan = plans.scan([parts["power_meter"]], parts["stage"], 0.020, 0.030, 3)
    bluesky.RunEngine()(plan, lambda name, document: heard.append((name, document)))
    events = [document["data"] for name, document in heard if name == "event"]
    assert_allclose([one["stage"] for one in events], [0.020, 0.025, 0.030])
    assert {one["power_meter"] for one in events} == {0.0}  # the shutter is closed
    told = dict(heard)["descriptor"]["data_keys"]
    assert (told["stage"]["units"], told["power_meter"]["units"]) == ("m", "W")


def test_a_stop_ends_a_move_and_a_failure_reaches_the_plan(parts):
    stage = parts["stage"]
    begun = threading.Event()

    def endless(position, *, waiting):
        begun.set()
        while True:
            waiting()

    stage._device.move_to = endless
    status = stage.set(0.03)
    begun.wait()
    assert not status.done
    stage.stop()
    assert not status.success
    assert isinstance(status.exception(10), Unsafe)
    stage._device.move_to = lambda position, waiting: 1 / 0
    ended = []
    status = stage.set(0.03)
    status.add_callback(ended.append)
    assert isinstance(status.exception(10), ZeroDivisionError)
    assert ended == [status]
