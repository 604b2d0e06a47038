"""The whole twin: at a rig's addresses or private ones, alone on loopback, and gone after stop."""

import socket
import threading
from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from twin_stand_in import PtyClient, SocketClient, StandInWorld, ask, left_behind, listening

from cmtof.hardware.rig import Rig
from cmtof.hardware.twin.run import Twin


def port(address: str) -> int:
    return int(address.rpartition(":")[2])


def path(address: str) -> Path:
    return Path(address.removeprefix("serial:"))


def free_ports(count: int) -> list[int]:
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


def clock(twin: Twin) -> SocketClient:
    return SocketClient(port(twin.rig.settings.devices["clock"].address))


def test_default_twin_answers_at_private_addresses():
    with Twin.default(world=StandInWorld()) as twin:
        devices = twin.rig.settings.devices
        assert set(devices) == set(Rig.default().settings.devices)
        links = [path(one.address) for one in devices.values() if "serial:" in one.address]
        assert len(links) == 6 and all(link.is_symlink() for link in links)
        assert links[0].parent.stat().st_mode & 0o077 == 0  # nobody else's business
        client = clock(twin)
        assert ask(client, "*IDN?").startswith("Siglent")
        client.close()
        meter = PtyClient(path(devices["power_meter"].address))
        assert ask(meter, "*IDN?").startswith("THORLABS")
        meter.close()
    assert not links[0].parent.exists()


def test_every_driver_recognises_its_device():
    with Twin.default(world=StandInWorld()) as twin, twin.rig.open() as instruments:
        known = {
            "rf_emission": "CMTOF-RF",
            "clock": "SDG2042X",
            "daq": "470012345",
            "plate_emission": "K10CR1",
            "stage": "KDC101",
            "power_meter": "S140C",
        }
        for role, name in known.items():
            assert name in repr(getattr(instruments, role).identify())
    assert not twin.panel.laser_on and not twin.panel.emission.on


@pytest.mark.skipif(not Path("/proc/self/net/tcp").exists(), reason="needs /proc")
def test_nothing_listens_beyond_loopback_and_nothing_is_left():
    before = left_behind()
    twin = Twin.default(world=StandInWorld())
    assert not listening()  # not before it is started
    with twin:
        assert len(listening()) == 3  # clock, commands, stream
        assert all(local.startswith("0100007F:") for local in listening())
        client = clock(twin)
        assert ask(client, "MODE?") == "MODE INDEPENDENT"
    assert client.read() == b""
    client.close()
    twin.stop()
    assert not listening()
    assert left_behind() == before


def test_twins_side_by_side():
    with Twin.default(world=StandInWorld()) as one, Twin.default(world=StandInWorld()) as other:
        first, second = clock(one), clock(other)
        ask(first, "C1:BSWV FRQ,5000;MODE?")
        assert "FRQ,5000HZ" in ask(first, "C1:BSWV?")
        assert "FRQ,1000HZ" in ask(second, "C1:BSWV?")
        assert one.panel.clock_frequency == 5000 and other.panel.clock_frequency == 1000
        first.close()
        second.close()


@pytest.fixture
def rig_file(tmp_path):
    """RIG file on free ports, with a fault, in a folder of its own."""
    text = Path(__file__).parents[3] / "src/cmtof/hardware/rig.yml"
    held = yaml.safe_load(text.read_text())
    for section, ports in (("clock", free_ports(1)), ("daq", free_ports(2))):
        held["devices"][section]["address"] = f"tcp://127.0.0.1:{ports[0]}"
        if len(ports) > 1:
            held["devices"][section]["stream"] = f"tcp://127.0.0.1:{ports[1]}"
    held["twin"] = {"faults": [{"device": "clock", "kind": "cut", "after": 1}]}
    file = tmp_path / "rig.yml"
    file.write_text(yaml.safe_dump(held))
    return file


def test_rig_file_is_served_where_it_says(rig_file):
    rig = Rig.load(rig_file)
    for _ in range(2):  # and again after a stop
        with Twin(rig, world=StandInWorld()) as twin:
            assert twin.rig is rig
            meter = PtyClient(rig_file.parent / "twin" / "power-meter")
            assert ask(meter, "*IDN?").startswith("THORLABS")
            meter.close()
            client = clock(twin)
            assert ask(client, "MODE?") == "MODE INDEPENDENT"
            client.send(b"MODE?\n")
            assert client.read() == b"MODE IND"  # the fault of the file
            client.close()
        assert not list((rig_file.parent / "twin").iterdir())


def test_second_twin_of_a_rig_leaves_the_first_alone(rig_file):
    rig = Rig.load(rig_file)
    with Twin(rig, world=StandInWorld()) as twin:
        with pytest.raises(OSError, match=r"Expected port .* to be free"):
            Twin(rig, world=StandInWorld()).start()
        client = clock(twin)
        assert ask(client, "MODE?") == "MODE INDEPENDENT"
        client.close()
        meter = PtyClient(rig_file.parent / "twin" / "power-meter")
        assert ask(meter, "*IDN?").startswith("THORLABS")
        meter.close()


@pytest.mark.parametrize(
    ("role", "change", "message"),
    [
        ("clock", {"address": "tcp://192.168.1.7:5025"}, "not for the network"),
        ("clock", {"address": "tcp://0.0.0.0:5025"}, "not for the network"),
        ("clock", {"address": "visa:TCPIP0::SDG::INSTR"}, "PORT for the simulated clock"),
        ("clock", {"address": "tcp://127.0.0.1:99999"}, "PORT for the simulated clock"),
        ("daq", {"stream": "tcp://10.0.0.1:702"}, "not for the network"),
        ("stage", {"address": "serial:/dev/ttyUSB0?rtscts=1"}, "outside /dev"),
    ],
)
def test_real_addresses_are_refused(tmp_path, role, change, message):
    before = set(threading.enumerate())
    settings = Rig.default().with_addresses({role: change}).settings
    devices = {one: settings.devices[one] for one in ("power_meter", role)}
    rig = Rig(replace(settings, devices=devices), tmp_path)
    if role == "daq" or "tcp" in change.get("address", ""):
        rig = rig.with_addresses({"power_meter": {"address": "serial:meter"}})
    with pytest.raises(ValueError, match=message):
        Twin(rig, world=StandInWorld()).start()
    assert set(threading.enumerate()) == before
    assert not [one for one in tmp_path.rglob("*") if not one.is_dir()]


@pytest.mark.parametrize(
    ("twin", "message"),
    [
        ({"faults": [{"device": "daq", "kind": "fire"}]}, "Expected kind in"),
        ({"lazer": {}}, "lazer"),
    ],
)
def test_settings_below_twin_are_checked(twin, message):
    rig = Rig.default()
    with pytest.raises(ValueError, match=message):
        Twin(Rig(replace(rig.settings, twin=twin)))


def test_rig_with_few_devices():
    rig = Rig.default()
    devices = {"stage": rig.settings.devices["stage"]}
    with Twin(
        Rig(replace(rig.settings, devices=devices)), world=StandInWorld(), private=True
    ) as it:
        assert list(it.rig.settings.devices) == ["stage"]


def test_faults_can_be_added_while_it_runs():
    with Twin.default(world=StandInWorld()) as twin:
        client = clock(twin)
        assert ask(client, "MODE?") == "MODE INDEPENDENT"
        twin.faults.add("clock", "drop-connection")
        client.send(b"MODE?\n")
        assert client.read() == b""
        client.close()
        client = clock(twin)
        assert ask(client, "MODE?") == "MODE INDEPENDENT"
        client.close()


def test_burst_through_the_drivers_with_the_real_world():
    """Two phases of a table, seen through every layer; the same again at the same seed."""
    counts = []
    for _ in range(2):
        with Twin.default(seed=3) as twin, twin.rig.open() as instruments:
            assert instruments.daq is not None
            instruments.daq.configure_burst(
                channel=0, rate=24000.0, scans=40, pulse_line="FIO4", scans_per_pulse=20
            )
            burst = instruments.daq.burst({"USER_RAM0_U32": 5, "TDAC2": 0.25})
            counts.append(burst.counts.tolist())
            assert twin.panel.label == 5
            assert twin.panel.time == pytest.approx(5 * 0.02 + 40 / 24000)
    assert counts[0] == counts[1]
