"""APT motors: bytes of the public protocol, and a controller that moves."""

import struct

import pytest
import thorlabs_apt_protocol as apt_bytes
from peers import Port

from cmtof.hardware.apt import MOTORS, Motor
from cmtof.hardware.device import BadReply, InstrumentError, InstrumentTimeout, Refused

HOMED, MOVING, ERROR = 1 << 10, 1 << 4, 1 << 14


class Controller:
    """A KDC101: position, status bits, and messages that come unasked."""

    def __init__(self, model=b"KDC101", serial=27000001):
        self.position, self.status, self.looks = 0, HOMED | 1 << 31, 0
        self.model, self.serial, self.deaf, self.moves = model, serial, False, []

    def __call__(self, data):
        (number,) = struct.unpack_from("<H", data)
        reply = {
            0x0005: lambda: self._long(
                0x0006, struct.pack("<l8sH4B60sHHH", self.serial, self.model, 16, *(4 * [1]),
                                    b"", 1, 1, 1)),
            0x0211: lambda: struct.pack("<HBBBB", 0x0212, 1, 1, 0x01, 0x50),
            0x0411: lambda: self._long(0x0412, struct.pack("<Hl", 1, self.position)),
            0x0414: lambda: self._long(0x0415, struct.pack("<H3l", 1, 0, 100, 10**8)),
            0x0490: self._bits,
            0x0443: lambda: self._move(0),
            0x0453: lambda: self._move(struct.unpack_from("<Hl", data, 6)[1]),
            0x0465: self._stop,
        }.get(number)  # fmt: skip
        return reply() if reply else b""

    @staticmethod
    def _long(number, payload):
        return struct.pack("<HHBB", number, len(payload), 0x81, 0x50) + payload

    def _bits(self):
        status = self.status
        if self.looks:
            self.looks -= 1
            status |= MOVING
        return self._long(0x0491, struct.pack("<HlhHL", 1, self.position, 0, 0, status))

    def _move(self, position):
        self.moves.append(position)
        if not self.deaf:
            self.position, self.looks = position, max(self.looks, 1)
        # MOVE_COMPLETED comes unasked
        return struct.pack("<HBBBB", 0x0464, 1, 0, 0x01, 0x50)

    def _stop(self):
        self.looks = 0
        return struct.pack("<HBBBB", 0x0466, 1, 0, 0x01, 0x50)


@pytest.fixture
def controller():
    return Controller()


@pytest.fixture
def motor(controller):
    return Motor(Port(controller), MOTORS["mts50-z8"], "stage")


def test_bytes_are_those_of_the_public_protocol():
    counts = round(0.010 * MOTORS["mts50-z8"].scale)
    assert apt_bytes.mot_move_home(0x50, 0x01, 1).hex(" ") == "43 04 01 00 50 01"
    wanted = "53 04 06 00 d0 01 01 00 ce 45 05 00"
    assert apt_bytes.mot_move_absolute(0x50, 0x01, 1, counts).hex(" ") == wanted


def test_a_move_ends_where_it_should(controller, motor):
    assert motor.identify()["serial_number"] == "27000001"
    assert motor.homed
    assert motor.move_to(0.010) == pytest.approx(0.010, abs=2e-8)
    assert controller.moves == [345550]


def test_homing(controller, motor):
    controller.position, controller.status = 1000, HOMED
    motor.home()
    assert motor.position == 0


@pytest.mark.parametrize(
    ("kind", "turns"), [("k10cr1", 409600 * 120 / 360), ("prm1-z8", 1919.6418578623391)]
)
def test_degrees_become_counts(kind, turns):
    assert MOTORS[kind].scale * 3.141592653589793 / 180 == pytest.approx(turns)


def test_a_move_beyond_the_travel_is_not_sent(controller, motor):
    with pytest.raises(ValueError, match=r"Expected 0 to 0\.05 m"):
        motor.move_to(0.06)
    controller.status = 0
    with pytest.raises(Refused, match="homed before a move"):
        motor.move_to(0.01)
    assert not controller.moves


def test_a_motor_that_does_not_hear_is_refused(controller, motor):
    controller.deaf = True
    with pytest.raises(Refused, match="got it at rest at 0 m"):
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


@pytest.mark.parametrize(("model", "number"), [(b"TDC999", 27000001), (b"KDC101", 27000002)])
def test_another_controller_is_refused(model, number):
    other = Motor(Port(Controller(model, number)), MOTORS["mts50-z8"], "stage", "27000001")
    with pytest.raises(Refused, match="Check the address"):
        other.identify()


def test_garbage_before_a_message_is_skipped(controller):
    answer = Controller()
    motor = Motor(Port(lambda data: b"\xff\xfe\xfd" + answer(data)), MOTORS["k10cr1"], "plate")
    assert motor.position == 0
    with pytest.raises((BadReply, InstrumentTimeout)):
        _ = Motor(Port(lambda data: b"\xff" * 12), MOTORS["k10cr1"], "plate").position
