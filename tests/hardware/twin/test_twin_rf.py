"""The simulated RF driver by lines whose checksums are computed here, bit by bit."""

import math
import time

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from twin_stand_in import StandInWorld, on_terminal, read_line, wait_until

from cmtof.hardware.twin.faults import Fault, Watch
from cmtof.hardware.twin.rf_server import RfServer
from cmtof.instrument.panel import Panel


def checksum(data: bytes) -> int:
    """CRC-16/CCITT-FALSE: polynomial 0x1021, start 0xFFFF."""
    value = 0xFFFF
    for byte in data:
        value ^= byte << 8
        for _ in range(8):
            value = (value << 1 ^ 0x1021 if value & 0x8000 else value << 1) & 0xFFFF
    return value


def line(body: str) -> bytes:
    return f"{body}*{checksum(body.encode()):04X}\n".encode()


class Driver:
    def __init__(self, folder):
        self.panel, self.world, self.watch = Panel(), StandInWorld(), Watch("rf_detection")
        self.knobs = self.panel.detection
        server = RfServer(self.panel, self.world, "detection", self.watch)
        self.context = on_terminal(server.serve, folder)
        self.line, self.client = self.context.__enter__()
        self.rest = b""

    def close(self):
        self.context.__exit__(None, None, None)

    def get(self, timeout=5.0):
        """Body of the next line; its checksum holds."""
        if b"\n" not in self.rest:
            self.rest += read_line(self.client, timeout)
        whole, _, self.rest = self.rest.partition(b"\n")
        body, _, check = whole.rpartition(b"*")
        assert int(check, 16) == checksum(body) and check.isupper() | check.isdigit()
        return body.decode()

    def ask(self, text):
        self.client.send(line(f">7 {text}"))
        reply = self.get()
        assert reply.startswith("<7 ")
        return reply.removeprefix("<7 ")


@pytest.fixture
def driver(tmp_path):
    made = Driver(tmp_path)
    yield made
    made.close()


def test_checksum_of_the_catalogue():
    assert checksum(b"123456789") == 0x29B1
    assert line(">7 PING") == b">7 PING*9555\n"


@pytest.mark.parametrize(
    ("request_", "reply"),
    [
        ("ID?", "OK CMTOF-RF,TWIN-DETECTION,1.0"),
        ("RF?", "OK OFF"),  # after power-on
        ("FREQ 7160000000", "OK 7160000000"),
        ("FREQ 7140000000", "OK 7140000000"),
        ("PHAS 65535", "OK 65535"),
        ("POWR 30.5", "OK 30.5"),
        ("POWR -30", "OK -30"),
        ("DEAD 0.1", "OK 0.1"),
        ("TRIG ON", "OK ON"),
        ("PING", "OK"),
        ("SAFE", "OK"),
        ("CLR", "OK"),
        ("ARM", "OK"),
        ("RF ON", "OK ON"),
        ("INDX?", "OK 0 0"),
        ("LOCK?", "OK 0 5000000 -12.50"),
        ("STAT?", "OK 0 0 0 0 0"),
        ("TABL?", "OK 0 FFFF"),
        ("TABL 2 0 32768", f"OK 2 {checksum(bytes([0, 0, 128, 0])):04X}"),
        ("FREQ 7139999999", "ERR RANGE expected 7140000000 to 7170000000"),
        ("FREQ 7.15e9", "ERR ARGS expected one whole number"),
        ("FREQ", "ERR ARGS expected one whole number"),
        ("FREQ -1", "ERR ARGS expected one whole number"),
        ("PHAS 65536", "ERR RANGE expected 0 to 65535"),
        ("POWR 99", "ERR RANGE expected -30.0 to 35.0"),
        ("POWR nan", "ERR ARGS expected one number"),
        ("DEAD 0", "ERR RANGE expected 0.1 to 60.0"),
        ("RF MAYBE", "ERR ARGS expected ON or OFF"),
        ("RF", "ERR ARGS expected ON or OFF"),
        ("TABL 3 0 1", "ERR ARGS expected 3 codes"),
        ("TABL 0", "ERR RANGE expected 1 to 64"),
        ("TABL 65" + " 0" * 65, "ERR RANGE expected 1 to 64"),
        ("ARM 1", "ERR ARGS expected none"),
        ("RF? now", "ERR ARGS a query has none"),
        ("BOOM", "ERR WORD not known"),
    ],
)
def test_words(driver, request_, reply):
    assert driver.ask(request_) == reply


@pytest.mark.parametrize("sequence", ["0", "9", "10", "99", "07"])
def test_sequence_is_echoed(driver, sequence):
    driver.client.send(line(f">{sequence} PING"))
    assert driver.get() == f"<{int(sequence)} OK"


@pytest.mark.parametrize(
    ("sent", "code"),
    [
        (b">7 PING*0000\n", "CHECKSUM"),
        (b">7 PING\n", "CHECKSUM"),
        (line(">0 PING").lower().replace(b"ping", b"PING"), "CHECKSUM"),  # upper-case
        (b">7 PONG*9555\n", "CHECKSUM"),
        (b"*IDN?\n", "CHECKSUM"),
        (b"\xff\xfe\n", "CHECKSUM"),
        (b"x" * 5000 + b"\n", "CHECKSUM"),
        (line("7 PING"), "FORM"),
        (line(">100 PING"), "FORM"),
        (line(">7 ping"), "FORM"),
        (line(">7  PING"), "FORM"),
        (line(">7"), "FORM"),
    ],
)
def test_bad_lines_are_answered_without_a_number(driver, sent, code):
    driver.client.send(sent)
    assert driver.get().startswith(f"<?? ERR {code} ")
    assert driver.ask("PING") == "OK"


def test_settings_turn_the_knobs(driver):
    for text in ("FREQ 7160000000", "PHAS 16384", "POWR 30", "TABL 3 0 16384 49152", "TRIG ON"):
        assert driver.ask(text).startswith("OK")
    knobs = driver.knobs
    assert (knobs.frequency, knobs.phase, knobs.power) == (7.16e9, math.pi / 2, 30.0)
    assert knobs.table == pytest.approx([0, math.pi / 2, 3 * math.pi / 2])
    assert knobs.trigger and not knobs.on
    assert driver.panel.emission.frequency == 7.15e9
    assert driver.ask("PHAS?") == "OK 16384"


def test_largest_table(driver):
    codes = list(range(0, 65536, 1024))
    driver.ask(f"TABL 64 {' '.join(map(str, codes))}")
    crc = checksum(np.array(codes, ">u2").tobytes())
    assert driver.ask("TABL?") == f"OK 64 {crc:04X}"


def test_arming_begins_anew(driver):
    driver.ask("TABL 2 0 1")
    driver.knobs.index, driver.knobs.edges = 1, 33
    assert driver.ask("INDX?") == "OK 1 33"
    driver.ask("ARM")
    assert driver.knobs.armed
    assert driver.ask("INDX?") == "OK 0 0"


def test_silence_turns_rf_off(driver):
    driver.ask("DEAD 0.1")
    driver.ask("RF ON")
    began = time.monotonic()
    assert driver.get() == "!TRIP DEADMAN"
    assert time.monotonic() - began > 0.09
    assert not driver.knobs.on
    assert driver.ask("STAT?") == "OK 0 0 0 0 1"
    assert driver.ask("RF ON") == "ERR TRIPPED CLR first"
    assert driver.ask("RF OFF") == "OK OFF"
    assert driver.ask("CLR") == "OK"
    assert driver.ask("RF ON") == "OK ON"


def test_any_request_feeds_the_timer_but_garbage_does_not(driver):
    driver.ask("DEAD 0.2")
    driver.ask("RF ON")
    for _ in range(8):
        time.sleep(0.04)
        assert driver.ask("PING") == "OK"
    assert driver.knobs.on  # 0.32 s
    while driver.knobs.on:
        driver.client.send(b">7 PING*0000\n")
        time.sleep(0.02)
    lines = []
    while not lines or not lines[-1].startswith("!TRIP"):
        lines.append(driver.get())
    assert lines[-1] == "!TRIP DEADMAN"


def test_timer_runs_only_while_rf_is_on(driver):
    driver.ask("DEAD 0.1")
    assert not driver.client.read(0.15)
    assert driver.ask("RF ON") == "OK ON"
    assert driver.ask("SAFE") == "OK"
    assert not driver.client.read(0.15)
    assert driver.ask("STAT?") == "OK 0 0 0 0 0"


def test_loss_of_the_lock_turns_rf_off(driver):
    assert driver.ask("RF ON") == "OK ON"
    assert driver.ask("LOCK?") == "OK 1 5000000 -12.50"
    driver.world.locks["detection"].locked = False
    driver.client.send(line(">8 PING"))
    assert [driver.get() for _ in range(3)] == ["!LOCK 0", "!TRIP LOCK", "<8 OK"]
    assert not driver.knobs.on
    assert driver.ask("RF ON").startswith("ERR TRIPPED")


def test_lock_that_never_was_is_not_lost(driver):
    driver.world.locks["detection"].locked = False
    assert driver.ask("RF ON") == "OK ON"
    assert driver.ask("LOCK?").startswith("OK 0 ")
    driver.world.locks["detection"].locked = True
    assert driver.ask("LOCK?").startswith("OK 1 ")
    driver.world.locks["detection"].locked = False  # while it looks for another resonance
    assert driver.ask("FREQ 7140000000") == "OK 7140000000"
    assert driver.knobs.on


def test_no_power_is_a_number_all_the_same(driver):
    driver.world.locks["detection"].reflected = -math.inf
    assert driver.ask("LOCK?") == "OK 0 5000000 -99.00"


def test_safe_is_always_accepted(driver):
    for text in ("RF ON", "TRIG ON"):
        driver.ask(text)
    driver.watch.add(Fault("rf_detection", "ignore", times=0))
    assert driver.ask("SAFE anything") == "OK"
    assert not driver.knobs.on and not driver.knobs.trigger
    assert driver.ask("RF OFF") == "OK OFF"


@pytest.mark.parametrize(
    ("kind", "request_", "reply"),
    [
        ("ignore", "FREQ 7160000000", "OK 7150000000"),
        ("ignore", "RF ON", "OK OFF"),
        ("ignore", "TABL 1 5", "OK 0 FFFF"),
        ("clamp", "FREQ 7160000000", "OK 7157000000"),
        ("clamp", "POWR 30", "OK 23.5"),
    ],
)
def test_setting_that_is_not_taken_is_echoed_as_it_is(driver, kind, request_, reply):
    driver.watch.add(Fault("rf_detection", kind))
    assert driver.ask("PING") == "OK"
    assert driver.ask(request_) == reply


def test_lock_is_lost_on_demand_once_rf_is_on(driver):
    driver.watch.add(Fault("rf_detection", "lost-lock"))
    assert driver.ask("FREQ?").startswith("OK")
    driver.client.send(line(">9 RF ON"))
    assert [driver.get() for _ in range(3)] == ["!LOCK 0", "!TRIP LOCK", "<9 OK ON"]
    assert driver.ask("CLR") == "OK"
    assert driver.ask("RF ON") == "OK ON"


def test_timer_runs_on_when_the_cable_is_pulled(driver):
    driver.ask("DEAD 0.1")
    driver.ask("RF ON")
    driver.watch.add(Fault("rf_detection", "drop-connection"))
    driver.client.send(line(">7 PING"))
    wait_until(lambda: not driver.knobs.on)


@given(garbage=st.binary(max_size=400))
@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_garbage_is_survived(driver, garbage):
    driver.client.send(garbage + b"\n")
    driver.client.send(line(">55 ID?"))
    while not (reply := driver.get()).startswith("<55 "):
        assert reply.startswith("<?? ERR ")
    assert reply.startswith("<55 OK CMTOF-RF")
