"""Benches of simulated devices."""

from pytest import raises

from cmtof.hardware.rig import Rig
from cmtof_lab.rehearsal import simulated_bench


def test_a_wrong_setting_below_twin_is_named(tmp_path):
    default = Rig.default()
    path = tmp_path / "rig.yml"
    devices = {role: {"driver": one.driver} for role, one in default.devices.items()}
    path.write_text(f"devices: {devices}\ntwin: {{laser_power: -1}}\n")
    rig = Rig.load(path)
    with raises(ValueError, match="Expected laser_power in twin to be .*, got -1"):
        simulated_bench(rig)
