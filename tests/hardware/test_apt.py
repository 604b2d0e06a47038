"""APT motors: bytes of the public protocol, and a controller that moves."""

import pytest
import thorlabs_apt_protocol as apt_bytes
from peers import ERROR, HOMED, Controller, Port

from cmtof.hardware.apt import MOTORS, Motor
from cmtof.hardware.device import InstrumentError, Refused


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


def test_a_motor_homes_and_moves_where_it_should(controller, motor):
    assert motor.identify()["serial_number"] == "27000001"
    controller.position = 1000
    motor.home()
    assert motor.position == 0
    assert motor.move_to(0.010) == pytest.approx(0.010, abs=2e-8)
    assert controller.moves == [0, 345550]


def test_timers_of_others_are_fed_while_a_motor_moves(controller, motor):
    fed = []
    controller.looks = 3
    motor.home(waiting=lambda: fed.append("home"))
    controller.looks = 2
    motor.move_to(0.01, waiting=lambda: fed.append("move"))
    assert fed.count("home") >= 2
    assert fed.count("move") >= 1


def test_a_move_needs_a_home(controller, motor):
    controller.status &= ~HOMED
    with pytest.raises(Refused, match="be homed before a move"):
        motor.move_to(0.01)
    assert not controller.moves


@pytest.mark.parametrize("fault", ["deaf", "moving", "error"])
def test_a_motor_that_does_not_arrive_is_stopped(controller, motor, monkeypatch, fault):
    monkeypatch.setattr("cmtof.hardware.apt.LONGEST", 0.1)
    controller.deaf = fault == "deaf"
    controller.looks = 10**6 * (fault == "moving")
    controller.status |= ERROR * (fault == "error")
    with pytest.raises(InstrumentError, match="Expected stage to arrive at 0.01, got it at"):
        motor.move_to(0.01)
    assert controller.looks == 0
    assert len(controller.moves) == 1


def test_another_serial_number_is_refused(controller, motor):
    controller.serial = 27000002
    with pytest.raises(Refused, match="27000001, got KDC101 27000002"):
        motor.identify()
