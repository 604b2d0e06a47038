"""Benches of simulated devices."""

from dataclasses import replace

from refusals import refused

from cmtof.hardware.rig import Rig
from cmtof_lab.rehearsal import simulated_bench


def test_a_wrong_setting_below_twin_is_named():
    rig = replace(Rig.default(), twin={"laser_power": -1})
    with refused("Expected laser_power in twin to be .*, got -1"):
        simulated_bench(rig)
