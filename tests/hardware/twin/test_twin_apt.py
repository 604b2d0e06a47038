"""Simulated motors by raw APT messages, by a published APT codec, and under garbage."""

import math
import struct
import time

import pytest
import thorlabs_apt_protocol as apt
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from twin_stand_in import PtyClient, on_terminal, read_size, wait_until

from cmtof.hardware.twin.apt_server import AptServer
from cmtof.hardware.twin.faults import Fault, Watch
from cmtof.instrument.panel import Panel

HOST, UNIT = 0x01, 0x50
REQUEST_POSITION = bytes.fromhex("11 04 01 00 50 01")
STOP = bytes.fromhex("65 04 01 01 50 01")

pytestmark = pytest.mark.filterwarnings("ignore:.*:DeprecationWarning")


class Motor:
    """A motor behind a terminal, a client, and the published decoder."""

    def __init__(self, folder, motor="mts50-z8", place="stage", pace=0.001):
        self.panel, self.watch = Panel(), Watch(place)
        self.context = on_terminal(
            AptServer(self.panel, motor, place, self.watch, pace=pace).serve, folder
        )
        self.line, self.client = self.context.__enter__()
        self.unpacker = apt.Unpacker(on_error="raise")

    def close(self):
        self.context.__exit__(None, None, None)

    def send(self, message):
        self.client.send(bytes.fromhex(message) if isinstance(message, str) else message)

    def get(self, name, timeout=5.0):
        """Next message of that name; others that come before it are given, too."""
        others = []
        while True:
            for message in self.unpacker:
                if message.msg == name:
                    return message
                others.append(message)
            data = self.client.read(timeout)
            assert data, f"no {name}, but {others}"
            self.unpacker.feed(data)

    def position(self):
        self.send(REQUEST_POSITION)
        return self.get("mot_get_poscounter").position

    def status(self):
        self.send(apt.mot_req_dcstatusupdate(UNIT, HOST, 1))
        return self.get("mot_get_dcstatusupdate")


@pytest.fixture
def motor(tmp_path):
    made = Motor(tmp_path)
    yield made
    made.close()


@pytest.fixture
def slow(tmp_path):
    """A stage whose moves take longer than any test."""
    made = Motor(tmp_path, pace=100.0)
    yield made
    made.close()


def test_home_and_move_by_the_bytes_of_the_documents(motor):
    motor.panel.stage_position = 0.013  # unknown to the counter
    motor.send("43 04 01 00 50 01")
    assert read_size(motor.client, 6) == bytes.fromhex("44 04 01 00 01 50")
    assert motor.panel.stage_position == 0
    motor.send("53 04 06 00 d0 01 01 00 ce 45 05 00")  # 10 mm at 34554.96 counts/mm
    message = read_size(motor.client, 20)
    assert message[:6] == bytes.fromhex("64 04 0e 00 81 50")
    channel, position, velocity, _, bits = struct.unpack("<HihHI", message[6:])
    assert (channel, position, velocity) == (1, 345550, 0)
    assert bits & 0x2400 == 0x2400 and not bits & 0x4270  # homed, settled; no move, no error
    assert motor.panel.stage_position == pytest.approx(0.010, abs=2e-8)  # half a count
    assert motor.panel.time == pytest.approx(10 / 2.4 + 2.4 / 4.5, rel=1e-4)


@pytest.mark.parametrize(
    ("kind", "place", "model", "serial", "stage"),
    [
        ("mts50-z8", "stage", b"KDC101", 27, 8),
        ("prm1-z8", "plate_emission", b"KDC101", 27, 6),
        ("k10cr1", "plate_detection", b"K10CR1", 55, 0),
    ],
)
def test_information(tmp_path, kind, place, model, serial, stage):
    motor = Motor(tmp_path, kind, place)
    motor.send(apt.hw_req_info(UNIT, HOST))
    raw = read_size(motor.client, 90)
    assert raw[:6] == bytes.fromhex("06 00 54 00 81 50")
    assert struct.unpack_from("<H", raw, 6 + 76) == (stage,)
    motor.unpacker.feed(raw)
    info = motor.get("hw_get_info")
    assert info.model_number.rstrip(b"\0") == model
    assert str(info.serial_number).startswith(str(serial))
    assert info.nchs == 1
    motor.close()


@pytest.mark.parametrize(
    ("kind", "place", "counts", "degrees"),
    [
        ("k10cr1", "plate_emission", 1536000, 11.25),  # 409600 * 120 / 360 a degree
        ("k10cr1", "plate_detection", -3072000, -22.5),
        ("prm1-z8", "plate_emission", 21596, 11.25),  # 1919.64186 a degree
        ("prm1-z8", "plate_detection", 1382142, 720.0),  # turns without end
    ],
)
def test_plates_turn(tmp_path, kind, place, counts, degrees):
    motor = Motor(tmp_path, kind, place)
    motor.send(apt.mot_move_absolute(UNIT, HOST, 1, counts))
    assert motor.get("mot_move_completed").position == counts
    index = int(place == "plate_detection")
    assert math.degrees(motor.panel.plate_angle[index]) == pytest.approx(degrees, abs=1e-3)
    assert motor.panel.plate_angle[1 - index] == 0
    motor.close()


def test_relative_moves_and_stored_parameters(motor):
    motor.send(apt.mot_move_absolute(UNIT, HOST, 1, 34555))
    motor.get("mot_move_completed")
    motor.send(apt.mot_move_relative(UNIT, HOST, 1, -555))
    assert motor.get("mot_move_completed").position == 34000
    motor.send(apt.mot_set_moverelparams(UNIT, HOST, 1, 1000))
    motor.send(apt.mot_move_relative(UNIT, HOST, 1))  # short form: the stored distance
    assert motor.get("mot_move_completed").position == 35000
    motor.send(apt.mot_req_moverelparams(UNIT, HOST, 1))
    assert motor.get("mot_get_moverelparams").relative_distance == 1000


@pytest.mark.parametrize(
    ("target", "end", "upper", "lower"),
    [(2_000_000, 1727748, True, False), (-500, 0, False, True), (100, 100, False, False)],
)
def test_travel_has_ends(motor, target, end, upper, lower):
    motor.send(apt.mot_move_absolute(UNIT, HOST, 1, target))
    done = motor.get("mot_move_completed")
    assert (done.position, done.forward_limit_switch, done.reverse_limit_switch) == (
        end,
        upper,
        lower,
    )


def test_velocity_is_clamped_without_a_word(motor):
    motor.send(apt.mot_req_velparams(UNIT, HOST, 1))
    full = motor.get("mot_get_velparams")
    assert full.max_velocity == round(2.4 * 772981.37)
    assert full.acceleration == round(4.5 * 263.844)
    for asked, got in ((10 * full.max_velocity, full.max_velocity), (772981, 772981), (0, 772981)):
        motor.send(apt.mot_set_velparams(UNIT, HOST, 1, 0, full.acceleration, asked))
        motor.send(apt.mot_req_velparams(UNIT, HOST, 1))
        assert motor.get("mot_get_velparams").max_velocity == got
    motor.send(apt.mot_move_absolute(UNIT, HOST, 1, 345550))  # 10 mm at 1 mm/s
    motor.get("mot_move_completed")
    assert motor.panel.time == pytest.approx(10 + 1 / 4.5, rel=1e-3)


def test_move_can_be_watched_and_stopped(slow):
    slow.send(apt.mot_move_absolute(UNIT, HOST, 1, 1_000_000))
    moving = slow.status()
    assert moving.moving_forward and not moving.settled and moving.velocity > 0
    slow.send(apt.mot_move_absolute(UNIT, HOST, 1, -10))  # the other way: gives way at once
    slow.send(apt.mot_move_home(UNIT, HOST, 1))
    assert slow.status().homing
    slow.send(STOP)
    stopped = slow.get("mot_move_stopped")
    assert not (stopped.moving_forward or stopped.moving_reverse or stopped.homing)
    assert 0 <= stopped.position < 1_000_000
    assert slow.position() == stopped.position
    assert slow.panel.stage_position == pytest.approx(stopped.position / 34554960)


def test_status_messages_come_until_they_are_stopped(motor, monkeypatch):
    monkeypatch.setattr("cmtof.hardware.twin.apt_server._UPDATE_PERIOD", 0.005)
    motor.send(apt.hw_start_updatemsgs(UNIT, HOST))
    for _ in range(3):
        motor.get("mot_get_dcstatusupdate")
    motor.send(apt.hw_stop_updatemsgs(UNIT, HOST))
    assert motor.position() == 0
    while motor.client.read(0):
        pass
    assert not motor.client.read(0.03)


def test_status_messages_want_to_be_acknowledged(motor, monkeypatch):
    monkeypatch.setattr("cmtof.hardware.twin.apt_server._UPDATE_PERIOD", 0.001)
    monkeypatch.setattr("cmtof.hardware.twin.apt_server._UNACKNOWLEDGED", 3)
    motor.send(apt.hw_start_updatemsgs(UNIT, HOST))
    for _ in range(3):
        motor.get("mot_get_dcstatusupdate")
    assert not motor.client.read(0.03)
    motor.send(apt.mot_ack_dcstatusupdate(UNIT, HOST))
    motor.get("mot_get_dcstatusupdate")


def test_reports_can_be_suspended(motor):
    motor.send(apt.mot_suspend_endofmovemsges(UNIT, HOST))
    motor.send(apt.mot_move_absolute(UNIT, HOST, 1, 100))
    wait_until(lambda: motor.position() == 100)
    motor.send(apt.mot_resume_endofmovemsges(UNIT, HOST))
    motor.send(apt.mot_move_absolute(UNIT, HOST, 1, 200))
    motor.get("mot_move_completed")


def test_disabled_channel_does_not_move(motor):
    motor.send(apt.mod_set_chanenablestate(UNIT, HOST, 1, 2))
    motor.send(apt.mod_req_chanenablestate(UNIT, HOST, 1))
    assert read_size(motor.client, 6) == bytes.fromhex("12 02 01 02 01 50")  # 2 is off
    motor.send(apt.mot_move_absolute(UNIT, HOST, 1, 100))
    assert motor.position() == 0
    assert not motor.status().channel_enabled


def test_counter_can_be_set(motor):
    motor.send(apt.mot_set_poscounter(UNIT, HOST, 1, 345550))
    assert motor.position() == 345550
    motor.send(apt.mot_move_absolute(UNIT, HOST, 1, 345550 + 34555))
    motor.get("mot_move_completed")
    assert motor.panel.stage_position == pytest.approx(0.001, abs=1e-7)  # where it really is


def test_other_messages_of_a_session(motor):
    motor.send(apt.hw_no_flash_programming(UNIT, HOST))
    motor.send(apt.mod_identify(UNIT, HOST, 1))
    motor.send("29 04 01 00 50 01")
    assert motor.get("mot_get_statusbits").settled
    motor.send(apt.mot_req_statusupdate(UNIT, HOST, 1))
    assert motor.get("mot_get_statusupdate").position == 0
    motor.send(apt.mot_set_homeparams(UNIT, HOST, 1, 1, 4, 12345, 678))
    motor.send(apt.mot_req_homeparams(UNIT, HOST, 1))
    assert motor.get("mot_get_homeparams").home_velocity == 12345
    motor.send("11 04 02 00 50 01")  # there is no channel 2
    motor.send("11 04 01 00 22 01")  # nor a bay 2
    assert not motor.client.read(0.02)
    assert motor.position() == 0


def test_stall_is_never_reported_as_completed(motor):
    motor.watch.add(Fault("stage", "stall"))
    assert motor.position() == 0  # waits for a move
    motor.send(apt.mot_move_absolute(UNIT, HOST, 1, 10000))
    wait_until(lambda: motor.status().motion_error)
    status = motor.status()
    assert status.position == 5000
    assert status.motor_current_limit_reached and not status.moving_forward
    assert not motor.client.read(0.02)
    motor.send(apt.mot_move_absolute(UNIT, HOST, 1, 10000))
    assert not motor.get("mot_move_completed").motion_error


@pytest.mark.parametrize(("kind", "counts"), [("clamp", 345550 - 172775), ("ignore", 0)])
def test_move_lands_elsewhere(motor, kind, counts):
    motor.watch.add(Fault("stage", kind))
    motor.send(apt.mot_move_absolute(UNIT, HOST, 1, 345550))
    wait_until(lambda: not motor.status().moving_forward)
    assert motor.position() == counts


@given(garbage=st.lists(st.binary(max_size=60), max_size=8))
@settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_garbage_is_survived(motor, garbage, monkeypatch):
    monkeypatch.setattr("cmtof.hardware.twin.apt_server._PARTIAL_TIMEOUT", 0.002)
    for part in garbage:
        motor.send(part)
    time.sleep(0.005)  # longer than a message may stay incomplete
    while motor.client.read(0):
        pass
    motor.send(REQUEST_POSITION)
    assert read_size(motor.client, 12)[:6] == bytes.fromhex("12 04 06 00 81 50")


def test_head_of_a_message_that_never_comes(motor):
    motor.send("53 04 06 00 d0 01")  # six more bytes should follow
    assert not motor.client.read(0.1)
    assert motor.position() == 0


def test_moves_go_on_when_the_cable_is_pulled(tmp_path):
    motor = Motor(tmp_path, pace=0.002)
    motor.watch.add(Fault("stage", "drop-connection", after=1))
    motor.send(apt.mot_move_absolute(UNIT, HOST, 1, 345550))
    first = motor.line.link.readlink()
    motor.send(REQUEST_POSITION)
    wait_until(lambda: motor.line.link.readlink() != first)
    again = PtyClient(motor.line.link)
    assert read_size(again, 20)[:2] == b"\x64\x04"
    again.close()
    motor.close()
    assert motor.panel.stage_position == pytest.approx(0.010, abs=1e-7)
