"""Motorised stages: exact bytes, a controller with faults, and a published APT package as peer."""

import math
import os
import select
import struct
import threading

import pytest
from apt_peer import (
    CURRENT_LIMIT,
    ENABLED,
    HOMED,
    LIMIT,
    MOTION_ERROR,
    MOVING,
    Motor,
    MotorLine,
    long,
    short,
)
from hypothesis import given
from hypothesis import strategies as st

from cmtof.hardware.codecs.apt import Status
from cmtof.hardware.drivers import apt_stage
from cmtof.hardware.drivers.apt_stage import Stage
from cmtof.hardware.drivers.stage_table import STAGES
from cmtof.hardware.errors import (
    ConnectionLost,
    InstrumentError,
    InstrumentTimeout,
    Refused,
)
from cmtof.hardware.transport import ReplayTransport, SerialTransport

MTS50 = STAGES["mts50-z8"]


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(apt_stage, "_POLL", 0.002)


def stage(motor=None, kind=MTS50, **options):
    motor = motor or Motor()
    line = MotorLine(motor)
    return Stage(line, kind, timeout=0.02, **{"margin": 0.05, **options}), motor, line


# --- exact bytes -------------------------------------------------------------------------------

PREPARE = [
    ("18 00 00 00 50 01  12 00 00 00 50 01  10 02 01 01 50 01", ""),
    ("11 02 01 00 50 01", "12 02 01 01 01 50"),
]
STATUS = "29 04 01 00 50 01"
HOMED_AT_REST = "2a 04 06 00 81 50 01 00 00 04 00 80"


def replay(*steps):
    return ReplayTransport([(bytes.fromhex(q), bytes.fromhex(r)) for q, r in steps])


def test_the_bytes_of_a_move():
    """53 04 06 00 d0 01 01 00 ce 45 05 00 is the published frame of 10 mm at 34554.96 counts/mm."""
    transport = replay(
        *PREPARE,
        (STATUS, HOMED_AT_REST),
        ("11 04 01 00 50 01", "12 04 06 00 81 50 01 00 00 00 00 00"),
        ("14 04 01 00 50 01", "15 04 0e 00 81 50 01 00 00 00 00 00 e8 03 00 00 20 4e 1c 00"),
        (
            "53 04 06 00 d0 01 01 00 ce 45 05 00",
            "64 04 0e 00 81 50 01 00 ce 45 05 00 00 00 00 00 00 04 00 80",
        ),
        (STATUS, HOMED_AT_REST),
        ("11 04 01 00 50 01", "12 04 06 00 81 50 01 00 ce 45 05 00"),
    )
    assert Stage(transport, MTS50).move_to(0.010) == pytest.approx(0.010, abs=2e-8)
    transport.finish()


def test_the_bytes_of_homing():
    transport = replay(
        *PREPARE,
        ("43 04 01 00 50 01", "44 04 01 00 01 50"),
        (STATUS, HOMED_AT_REST),
        (STATUS, HOMED_AT_REST),
    )
    Stage(transport, MTS50).home()
    transport.finish()


def test_the_bytes_of_the_safe_state():
    transport = replay(("65 04 01 01 50 01", "66 04 01 00 01 50"), (STATUS, HOMED_AT_REST))
    Stage(transport, MTS50).safe_state()
    transport.finish()


# --- scales ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "position", "counts"),
    [
        ("mts50-z8", 0.010, 345550),
        ("mts50-z8", 0.050, 1727748),
        ("prm1-z8", math.radians(11.25), 21596),
        ("k10cr1", math.radians(22.5), 3072000),
        ("k10cr1", math.radians(360), 409600 * 120),
    ],
)
def test_scales(name, position, counts):
    assert STAGES[name].counts(position) == counts


@pytest.mark.parametrize(
    ("name", "factor"), [("mts50-z8", 22.3696), ("prm1-z8", 22.3696), ("k10cr1", 53.68)]
)
def test_speeds_follow_from_positions(name, factor):
    """2048 / 6 MHz * 65536 = 22.3696 for the DC motors; 53.68 for the stepper."""
    kind = STAGES[name]
    assert kind.velocity_scale / kind.scale == pytest.approx(factor, rel=1e-4)


def test_an_own_scale():
    kind = MTS50.rescaled(34304e3)
    assert kind.counts(0.010) == 343040
    assert kind.velocity_scale == pytest.approx(767367.49e3, rel=1e-6)
    with pytest.raises(ValueError, match=r"about 3.4555e\+07 counts per m for MTS50-Z8"):
        MTS50.rescaled(34304.0)  # counts per mm


@given(st.floats(0, 0.05))
def test_positions_come_back_within_a_count(position):
    assert abs(MTS50.counts(position) / MTS50.scale - position) <= 0.5 / MTS50.scale + 1e-15


# --- moves -------------------------------------------------------------------------------------


@pytest.mark.parametrize("looks", [0, 1, 3])
@pytest.mark.parametrize("speaks", [True, False])
def test_a_move_ends_with_its_message_or_without(looks, speaks):
    target, motor, _ = stage()
    motor.looks, motor.speaks = looks, speaks
    assert target.move_to(0.012) == pytest.approx(0.012, abs=1e-7)
    assert motor.heard.count(0x0453) == 1


@pytest.mark.parametrize("speaks", [True, False])
def test_homing(speaks):
    target, motor, _ = stage()
    motor.bits, motor.position, motor.speaks = 0, 5000, speaks
    assert not target.status() & Status.HOMED
    target.home(timeout=1.0)
    assert target.status() & Status.HOMED
    assert target.position() == 0


def test_a_stage_that_is_not_homed_does_not_move():
    target, motor, _ = stage()
    motor.bits = 0
    with pytest.raises(Refused, match="homed before it moves"):
        target.move_to(0.01)
    assert 0x0453 not in motor.heard


@pytest.mark.parametrize("position", [-0.001, 0.0501, math.nan])
def test_nothing_goes_beyond_the_travel(position):
    target, motor, _ = stage()
    with pytest.raises(ValueError, match=r"Expected 0 to 0\.05 m for stage"):
        target.move_to(position)
    assert motor.heard == []


def test_a_wave_plate_turns_without_end():
    plate, _, _ = stage(Motor(model=b"K10CR1", stage=0), STAGES["k10cr1"])
    assert plate.identify().model == "K10CR1"
    assert plate.move_to(math.radians(-370)) == pytest.approx(math.radians(-370), abs=1e-6)


def test_an_older_end_of_a_move_does_not_end_this_one():
    target, motor, line = stage()
    target.identify()
    motor.looks = 3
    line.before = motor.status(0x0464)
    assert target.move_to(0.02) == pytest.approx(0.02, abs=1e-7)


def test_what_comes_unasked_does_not_pass_for_a_reply():
    target, motor, line = stage()
    motor.position = 34555
    line.before = motor.status(0x0491) + short(0x0444, 1) + long(0x0464, "<HihHI", 1, 7, 0, 0, 0)
    assert target.position() == pytest.approx(0.001, rel=1e-4)


MOVE, READ = ("move_to", (0.02,)), ("position", ())

# what is wrong; what is done to motor and line; the call; the error and its words
FAULTS = {
    "stalled": (
        {"stalls": True, "velocity": 2_000_000_000},
        {},
        MOVE,
        InstrumentTimeout,
        "arrive within .* Free the stage",
    ),
    "clamped": ({"clamp": 345550}, {}, MOVE, Refused, "at 0.02 m, got 0.01"),
    "clamped at a limit switch": (
        {"clamp": 345550, "bits": HOMED | LIMIT},
        {},
        MOVE,
        Refused,
        "got 0.01 at a limit switch",
    ),
    "motion error": ({"error": MOTION_ERROR}, {}, MOVE, InstrumentError, "a motion error"),
    "current limit": ({"error": CURRENT_LIMIT}, {}, MOVE, InstrumentError, "current limit"),
    "both": (
        {"error": CURRENT_LIMIT | MOTION_ERROR},
        {},
        MOVE,
        InstrumentError,
        "too large. and the motor's current limit",
    ),
    "does not enable": ({"enables": False}, {}, MOVE, Refused, "enable its motor"),
    "no speed": ({"velocity": 0}, {}, MOVE, Refused, "a speed above 0"),
    "not homed at the end": ({"error": LIMIT}, {}, ("home", (1.0,)), InstrumentError, "be homed"),
    "homing without end": (
        {"stalls": True},
        {},
        ("home", (0.02,)),
        InstrumentTimeout,
        "arrive within 0.0 s",
    ),
    "silent for ever": ({}, {"silences": 9}, READ, InstrumentTimeout, "within 0.02 s|bytes"),
    "lost and silent": ({}, {"lost": True, "silences": 9}, READ, InstrumentTimeout, "bytes"),
    "a complaint": (
        {},
        {"before": long(0x0081, "<HH64s", 0x0453, 5, b"no power")},
        READ,
        Refused,
        "fault 5 about message 0x0453 no power",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_fault(fault):
    on_motor, on_line, (call, arguments), error, words = FAULTS[fault]
    target, motor, line = stage()
    for name, value in on_motor.items():
        setattr(motor, name, value)
    for name, value in on_line.items():
        setattr(line, name, value)
    with pytest.raises(error, match=words):
        getattr(target, call)(*arguments)
    moves = [id_ for id_ in motor.heard if id_ in (0x0453, 0x0443)]
    assert len(moves) <= 1  # a move is never sent again
    if error is InstrumentTimeout and moves:
        assert 0x0465 in motor.heard  # and is stopped
        assert not motor.bits & MOVING


RECOVERIES = {
    "a reply that is lost": {"silences": 1},
    "a reply that is cut": {"cut": 1},
    "a connection that is lost": {"lost": True},
    "garbage before the reply": {"before": b"\xff\x00garbage"},
}


@pytest.mark.parametrize("fault", RECOVERIES)
def test_reads_recover(fault):
    target, motor, line = stage()
    motor.position = 345550
    for name, value in RECOVERIES[fault].items():
        setattr(line, name, value)
    assert target.position() == pytest.approx(0.010, abs=1e-7)


def test_a_lost_connection_is_prepared_anew_and_the_move_is_not_repeated():
    target, motor, line = stage()
    target.identify()
    plain = line.write

    def once(data):
        line.lost = data.startswith(b"\x53\x04")
        line.write = plain
        return plain(data)

    def until_move(data):
        return once(data) if data.startswith(b"\x53\x04") else plain(data)

    line.write = until_move
    with pytest.raises(ConnectionLost):
        target.move_to(0.01)
    assert 0x0453 not in motor.heard
    assert target.move_to(0.01) == pytest.approx(0.01, abs=1e-7)
    assert line.reconnects == 1
    assert motor.heard.count(0x0018) == 2


def test_the_safe_state_comes_through_a_lost_connection():
    target, motor, line = stage()
    motor.bits |= MOVING
    line.lost = True
    target.safe_state()
    assert 0x0465 in motor.heard
    assert not motor.bits & MOVING


# --- identity ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("motor", "options", "words"),
    [
        ({"model": b"K10CR1"}, {}, "Expected a KDC101 or .* got K10CR1"),
        ({"stage": 6}, {}, r"Expected an MTS50-Z8 \(stage 8\) at stage, got stage 6"),
        ({}, {"serial_number": "27999999"}, "serial number 27999999 at stage, got 27000001"),
    ],
)
def test_another_controller_or_stage(motor, options, words):
    target, _, _ = stage(Motor(**motor), **options)
    with pytest.raises(Refused, match=words):
        target.identify()


def test_the_right_controller():
    target, motor, _ = stage(serial_number="27000001")
    assert target.identify().stage_id == 8
    assert motor.bits & ENABLED


# --- a published package on the other side of a pseudo-terminal --------------------------------


class PackagePeer(threading.Thread):
    """What the host writes must be what thorlabs_apt_protocol writes; what it gets, it parses."""

    def __init__(self, motor, master):
        super().__init__(daemon=True)
        import thorlabs_apt_protocol as package

        unit, host = 0x50, 0x01
        self.unpacker = package.Unpacker(on_error="raise")
        self.motor, self.master = motor, master
        self.woken, self.wake = os.pipe()
        self.parsed, self.strange = [], []
        self.known = {
            bytes_[:2]: bytes_
            for bytes_ in (
                package.hw_no_flash_programming(unit, host),
                package.hw_stop_updatemsgs(unit, host),
                package.mod_set_chanenablestate(unit, host, 1, 1),
                package.mod_req_chanenablestate(unit, host, 1),
                package.hw_req_info(unit, host),
                package.mot_req_poscounter(unit, host, 1),
                package.mot_req_velparams(unit, host, 1),
                package.mot_move_home(unit, host, 1),
                package.mot_move_absolute(unit, host, 1, 345550),
                package.mot_move_stop(unit, host, 1, 1),
            )
        }
        # the package has no function for this request of the protocol document
        self.known[b"\x29\x04"] = bytes.fromhex("29 04 01 00 50 01")

    def run(self):
        data = b""
        while self.woken not in select.select([self.master, self.woken], [], [])[0]:
            try:
                data += os.read(self.master, 4096)
            except OSError:  # the host has closed the line
                return
            while len(data) >= 6:
                expected = self.known.get(data[:2], b"?")
                if len(data) < len(expected) and expected.startswith(data):
                    break  # the rest is on its way
                if not data.startswith(expected):
                    self.strange.append(data.hex(" "))
                    return
                data = data[len(expected) :]
                self.answer(self.motor.feed(expected))

    def answer(self, reply):
        self.unpacker.feed(reply)
        self.parsed += [message.msg for message in self.unpacker]
        os.write(self.master, reply)

    def stop(self):
        os.write(self.wake, b"!")
        self.join(5)
        for handle in (self.woken, self.wake, self.master):
            os.close(handle)


def test_against_a_published_package():
    pytest.importorskip("thorlabs_apt_protocol")
    master, slave = os.openpty()
    line = SerialTransport(os.ttyname(slave), rtscts=True)
    os.close(slave)
    motor = Motor()
    motor.bits = 0
    peer = PackagePeer(motor, master)
    peer.start()
    try:
        with Stage(line, MTS50, timeout=2.0) as target:
            assert target.identify().serial == 27000001
            target.home(timeout=5.0)
            assert target.move_to(0.010) == pytest.approx(0.010, abs=1e-7)
    finally:
        peer.stop()
    assert peer.strange == []
    assert struct.pack("<i", motor.position) == bytes.fromhex("ce450500")
    assert {"hw_get_info", "mot_move_homed", "mot_move_completed", "mot_get_statusbits"} <= set(
        peer.parsed
    )
