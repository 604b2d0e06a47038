"""APT motors: bytes of the public protocol, and a controller that moves."""

import itertools
import os
import struct
from unittest.mock import Mock

from peers import ERROR, HOMED, Controller, Port, simulated
from pytest import fixture, mark
from refusals import refused

from cmtof.hardware.apt import LONGEST, MOTORS, Motor, open_controller
from cmtof.hardware.device import (
    ConnectionLost,
    InstrumentError,
    InstrumentTimeout,
    Refused,
)


@fixture
def controller():
    return Controller(simulated("stage"), homed=True)


@fixture
def motor(controller):
    return Motor(Port(controller), MOTORS["mts50-z8"], "stage", "27000001")


def test_speeds_are_set_before_the_first_move(controller, motor):
    """A K10CR1 powers up with a home velocity at which it never arrives."""
    motor.home()
    assert 5 not in (*controller.home_parameters, *controller.velocities)


@mark.parametrize("kind", MOTORS.values(), ids=MOTORS)
def test_the_longest_way_home_takes_less_than_is_waited_for(kind):
    assert min(kind.travel[1] - kind.travel[0], 360) / kind.home_velocity < LONGEST


def test_a_controllers_port_is_woken_and_emptied(monkeypatch):
    heard = []

    class Recorder:
        def __setattr__(self, name, value):
            heard.append(value)

        def __getattr__(self, name):
            return lambda: heard.append(name)

    monkeypatch.setattr("cmtof.hardware.apt.open_serial", lambda *_, **how: Recorder())
    monkeypatch.setattr("cmtof.hardware.apt._POLL", 0.0)
    open_controller("/dev/ttyUSB0")
    empty = ["reset_input_buffer", "reset_output_buffer"]
    assert heard == [True, *empty, False, *empty]


def test_a_controller_that_talks_but_does_not_answer_is_given_up(monkeypatch):
    """It sends its status for ever, as after a request for updates."""
    monkeypatch.setattr("cmtof.hardware.apt.ANSWER", 0.05)
    status = struct.pack("<HHBB", 0x0491, 14, 0x81, 0x50) + bytes(14)
    endless = itertools.cycle(status)
    talker = Mock(read=lambda size: bytes(itertools.islice(endless, size)))
    with refused("answer mot_req_poscounter, got none", InstrumentTimeout):
        _ = Motor(talker, MOTORS["mts50-z8"], "stage").position


def test_a_port_is_opened_by_one_program_only():
    primary, secondary = os.openpty()
    port = open_controller(os.ttyname(secondary))
    with refused("Expected a serial port at", ConnectionLost):
        open_controller(os.ttyname(secondary))
    port.close()
    os.close(primary)
    os.close(secondary)


def test_a_move_needs_a_home(controller, motor):
    controller.status &= ~HOMED
    with refused("be homed before a move", Refused):
        motor.move_to(0.01)
    assert not controller.moves


@mark.parametrize("fault", ["deaf", "moving", "error"])
def test_a_motor_that_does_not_arrive_is_stopped(controller, motor, monkeypatch, fault):
    monkeypatch.setattr("cmtof.hardware.apt.LONGEST", 0.1)
    controller.deaf = fault == "deaf"
    controller.looks = 10**6 * (fault == "moving")
    controller.status |= ERROR * (fault == "error")
    with refused("Expected stage to arrive at 0.01, got it at", InstrumentError):
        motor.move_to(0.01)
    assert controller.looks == 0
    assert len(controller.moves) == 1
