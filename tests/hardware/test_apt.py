"""APT motors: bytes of the public protocol, and a controller that moves."""

from math import pi

import pytest
import thorlabs_apt_protocol as apt_bytes
from peers import ERROR, HOMED, Controller, Port

from cmtof.hardware.apt import MOTORS, Motor
from cmtof.hardware.device import InstrumentError, InstrumentTimeout, Refused


@pytest.fixture
def controller():
    return Controller()


@pytest.fixture
def motor(controller):
    return Motor(Port(controller), MOTORS["mts50-z8"], "stage", "27000001")


def test_bytes_are_those_of_the_public_protocol():
    counts = round(0.010 * MOTORS["mts50-z8"].scale)
    assert apt_bytes.mot_move_home(0x50, 0x01, 1).hex(" ") == "43 04 01 00 50 01"
    wanted = "53 04 06 00 d0 01 01 00 ce 45 05 00"
    assert apt_bytes.mot_move_absolute(0x50, 0x01, 1, counts).hex(" ") == wanted


def test_units_become_counts_and_counts_of_speed():
    for kind, position, speed in (
        ("mts50-z8", 34554960.0, 772981370.0),
        ("prm1-z8", 1919.6418578623391 * 180 / pi, 42941.66 * 180 / pi),
        ("k10cr1", 409600 * 120 / 360 * 180 / pi, 7329109 * 180 / pi),
    ):
        assert MOTORS[kind].scale == pytest.approx(position)
        assert MOTORS[kind].scale / MOTORS[kind].speed == pytest.approx(speed, rel=1e-5)


def test_a_motor_homes_and_moves_where_it_should(controller, motor):
    assert motor.identify()["serial_number"] == "27000001"
    controller.position = 1000
    motor.home()
    assert motor.position == 0
    assert motor.move_to(0.010) == pytest.approx(0.010, abs=2e-8)
    assert controller.moves == [0, 345550]


def test_a_move_needs_a_home(controller, motor):
    controller.status &= ~HOMED
    with pytest.raises(Refused, match="be homed before a move"):
        motor.move_to(0.01)
    assert not controller.moves


def test_a_motor_that_does_not_hear_is_refused(controller, motor):
    controller.deaf = True
    with pytest.raises(Refused, match="got it at rest at 0"):
        motor.move_to(0.01)
    assert len(controller.moves) == 1


def test_a_motor_that_does_not_arrive_is_stopped(controller, motor, monkeypatch):
    controller.looks = 10**6
    clock = iter(range(10**6))
    monkeypatch.setattr("cmtof.hardware.apt.time.monotonic", lambda: float(next(clock)))
    monkeypatch.setattr("cmtof.hardware.apt.time.sleep", lambda seconds: None)
    with pytest.raises(InstrumentTimeout, match="got it moving"):
        motor.move_to(0.01)
    assert controller.looks == 0


def test_a_motion_error_stops_the_motor(controller, motor):
    controller.status |= ERROR
    with pytest.raises(InstrumentError, match="got a motion error"):
        motor.move_to(0.01)


def test_another_serial_number_is_refused(controller, motor):
    controller.serial = 27000002
    with pytest.raises(Refused, match="27000001, got KDC101 27000002"):
        motor.identify()


def test_garbage_before_a_message_is_skipped(controller):
    motor = Motor(Port(lambda data: b"\xff\xfe\xfd" + controller(data)), MOTORS["prm1-z8"], "plate")
    assert motor.position == 0
