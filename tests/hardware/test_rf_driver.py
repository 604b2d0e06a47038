"""The RF driver against written dialogues of its line protocol."""

import math
from binascii import crc_hqx

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cmtof.hardware.drivers.rf_driver import RfDriver, RfIdentity, RfLock, RfStatus
from cmtof.hardware.errors import (
    BadReply,
    ConnectionLost,
    InstrumentError,
    InstrumentTimeout,
    Refused,
    Unsafe,
)
from cmtof.hardware.transport import ReplayTransport


def line(text):
    return f"{text}*{crc_hqx(text.encode(), 0xFFFF):04X}\n".encode()


def dialogue(*steps):
    """Request and answers as text; None is silence, an error is raised at the read."""
    made = []
    for request, *answers in steps:
        answer = (
            answers[0]
            if answers and isinstance(answers[0], InstrumentError | bytes)
            else b"".join(line(one) for one in answers)
        )
        made.append((line(request), answer))
    return ReplayTransport(made)


def driver(*steps):
    transport = dialogue(*steps)
    return RfDriver(transport, "rf", timeout=0.01), transport


# request, reply, call, result
EXCHANGES = [
    (">0 ID?", "<0 OK CMTOF-RF,A7,1.2", "identify", (), RfIdentity("CMTOF-RF", "A7", "1.2")),
    (">0 FREQ 7150000000", "<0 OK 7150000000", "set_frequency", (7.15e9,), 7.15e9),
    (">0 PHAS 16384", "<0 OK 16384", "set_phase", (math.pi / 2,), math.pi / 2),
    (">0 PHAS 49152", "<0 OK 49152", "set_phase", (-math.pi / 2,), 1.5 * math.pi),
    (">0 POWR 30.0", "<0 OK 30", "set_power", (30,), 30.0),
    (">0 DEAD 5.0", "<0 OK 5", "set_dead_man", (5,), 5.0),
    (">0 LOCK?", "<0 OK 1 -1200 -14.50", "lock", (), RfLock(True, -1200.0, -14.5)),
    (">0 TRIG ON", "<0 OK ON", "trigger", (True,), None),
    (">0 RF OFF", "<0 OK OFF", "output", (False,), None),
    (">0 ARM", "<0 OK", "arm", (), None),
    (">0 INDX?", "<0 OK 15 320", "index", (), (15, 320)),
    (">0 STAT?", "<0 OK 1 1 3 48 0", "status", (), RfStatus(True, True, 3, 48, False)),
    (">0 STAT?", "<0 OK 0 0 3 48 1", "status", (), RfStatus(False, False, 3, 48, True)),
    (">0 CLR", "<0 OK", "clear_trip", (), None),
    (">0 PING", "<0 OK", "ping", (), None),
]


@pytest.mark.parametrize(("request_", "reply", "call", "arguments", "result"), EXCHANGES)
def test_dialogue(request_, reply, call, arguments, result):
    rf, transport = driver((request_, reply))
    found = getattr(rf, call)(*arguments)
    assert found == pytest.approx(result) if isinstance(result, float) else found == result
    transport.finish()


def test_a_table_is_read_back():
    codes = " ".join(str(4096 * k) for k in range(16))
    check = crc_hqx(b"".join((4096 * k).to_bytes(2, "big") for k in range(16)), 0xFFFF)
    rf, transport = driver(
        (f">0 TABL 16 {codes}", f"<0 OK 16 {check:04X}"), (">1 TABL?", f"<1 OK 16 {check:04X}")
    )
    rf.load_table([2 * math.pi * k / 16 for k in range(16)])
    transport.finish()


@pytest.mark.parametrize("held", ["16 0000", "15 1234", "0 FFFF"])
def test_another_table_is_refused(held):
    rf, _ = driver((">0 TABL 1 0", "<0 OK 1 1D0F"), (">1 TABL?", f"<1 OK {held}"))
    with pytest.raises(Refused, match="hold the table of 1 phases"):
        rf.load_table([0.0])


@given(st.lists(st.floats(-100, 100), min_size=1, max_size=64))
def test_phases_of_a_table_are_whole_codes_of_a_turn(phases):
    sent = []

    class Ear:
        def write(self, data):
            sent.append(data)
            raise InstrumentTimeout("enough heard")

    with pytest.raises(InstrumentTimeout):
        RfDriver(Ear()).load_table(phases)
    words = sent[0].split(b"*")[0].split()
    assert (words[1], int(words[2])) == (b"TABL", len(phases))
    for phase, code in zip(phases, map(int, words[3:]), strict=True):
        assert 0 <= code < 65536
        error = (code / 65536 - phase / (2 * math.pi)) % 1
        assert min(error, 1 - error) <= 0.5 / 65536 + 1e-12


READ, SET = ("lock", ()), ("set_power", (30,))
GOOD_LOCK = "<1 OK 1 0 -14"

# what goes wrong; the dialogue; the call; the error and its words, or None for recovery
FAULTS = {
    "a read that is not answered is repeated": (
        [(">0 LOCK?",), (">1 LOCK?", GOOD_LOCK)],
        READ,
        None,
        "",
    ),
    "a read that is never answered": (
        [(">0 LOCK?",), (">1 LOCK?",)],
        READ,
        InstrumentTimeout,
        "ends in",
    ),
    "a cut reply is read again": (
        [(">0 LOCK?", b"<0 OK 1 0"), (">1 LOCK?", GOOD_LOCK)],
        READ,
        None,
        "",
    ),
    "a garbled reply is read again": (
        [(">0 LOCK?", b"<0 OK 1 0 -99*0000\n"), (">1 LOCK?", GOOD_LOCK)],
        READ,
        None,
        "",
    ),
    "a late reply is passed over": (
        [(">0 LOCK?",), (">1 LOCK?", "<0 OK 0 7 7", GOOD_LOCK)],
        READ,
        None,
        "",
    ),
    "a garbled request is sent again": (
        [(">0 LOCK?", "<?? ERR CHECKSUM again"), (">1 LOCK?", GOOD_LOCK)],
        READ,
        None,
        "",
    ),
    "a lost connection is opened for a read": (
        [(">0 LOCK?", ConnectionLost("gone")), (">1 LOCK?", GOOD_LOCK)],
        READ,
        None,
        "",
    ),
    "a setting that is not answered is not repeated": (
        [(">0 POWR 30.0",)],
        SET,
        InstrumentTimeout,
        "ends in",
    ),
    "a setting with a garbled answer is not repeated": (
        [(">0 POWR 30.0", b"<0 OK 30*0000\n")],
        SET,
        BadReply,
        "checksum",
    ),
    "a setting that is clamped": (
        [(">0 POWR 30.0", "<0 OK 27")],
        SET,
        Refused,
        "power to 30 dBm, got 27 dBm",
    ),
    "a setting that is ignored": (
        [(">0 FREQ 7160000000", "<0 OK 7150000000")],
        ("set_frequency", (7.16e9,)),
        Refused,
        "frequency to 7.16e.09 Hz, got 7.15e.09 Hz",
    ),
    "a setting out of range": (
        [(">0 FREQ 1", "<0 ERR RANGE 7140000000 to 7170000000")],
        ("set_frequency", (1,)),
        Refused,
        "ERR RANGE 7140000000",
    ),
    "a switch that stays": (
        [(">0 TRIG ON", "<0 OK OFF")],
        ("trigger", (True,)),
        Refused,
        "answer TRIG ON, got OFF",
    ),
    "another device": (
        [(">0 ID?", "<0 OK OTHER,1,2")],
        ("identify", ()),
        Refused,
        "Expected a CMTOF-RF",
    ),
    "too few values": (
        [(">0 STAT?", "<0 OK 1 1")],
        ("status", ()),
        BadReply,
        "5 values of STAT",
    ),
    "a trip since the last word": (
        [(">0 PING", "!LOCK 0", "!TRIP LOCK", "<0 OK")],
        ("ping", ()),
        Unsafe,
        r"got a trip \(LOCK\)",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_fault(fault):
    steps, (call, arguments), error, words = FAULTS[fault]
    rf, transport = driver(*steps)
    if error is None:
        assert getattr(rf, call)(*arguments) == RfLock(True, 0.0, -14.0)
    else:
        with pytest.raises(error, match=words):
            getattr(rf, call)(*arguments)
    transport.finish()


def test_a_lost_connection_is_opened_anew_before_the_next_setting_and_nothing_is_resent():
    rf, transport = driver((">0 POWR 30.0", ConnectionLost("gone")), (">1 POWR 20.0", "<1 OK 20"))
    with pytest.raises(ConnectionLost):
        rf.set_power(30)
    assert transport.reconnects == 0
    assert rf.set_power(20) == 20
    assert transport.reconnects == 1
    transport.finish()


def test_notices_are_kept():
    rf, _ = driver((">0 LOCK?", "!LOCK 0", "<0 OK 0 5 -3", "!TRIP LOCK"), (">1 LOCK?", GOOD_LOCK))
    rf.lock()
    rf.lock()
    assert [(one.word, one.arguments) for one in rf.notices] == [
        ("LOCK", ("0",)),
        ("TRIP", ("LOCK",)),
    ]


def test_rf_is_not_switched_on_without_a_dead_man():
    rf, transport = driver()
    with pytest.raises(Unsafe, match="Call set_dead_man first"):
        rf.output(True)
    transport.finish()


def test_rf_waits_for_its_lock():
    rf, transport = driver(
        (">0 DEAD 2.0", "<0 OK 2"),
        (">1 RF ON", "<1 OK ON"),
        (">2 LOCK?", "<2 OK 0 900000 -2"),
        (">3 LOCK?", "<3 OK 1 10 -15"),
    )
    rf.set_dead_man(2)
    rf.output(True)
    transport.finish()


@pytest.mark.parametrize(
    ("answers", "words"),
    [
        (["<2 OK 0 900000 -2"], r"lock within 0 s, got none \(900000 Hz off"),
        (["!TRIP LOCK", "<2 OK 0 900000 -2"], r"got a trip \(LOCK\)"),
    ],
)
def test_rf_goes_off_again_without_a_lock(answers, words):
    rf, transport = driver(
        (">0 DEAD 2.0", "<0 OK 2"),
        (">1 RF ON", "<1 OK ON"),
        (">2 LOCK?", *answers),
        (">3 SAFE", "<3 OK"),
        (">4 STAT?", "<4 OK 0 0 0 0 1"),
    )
    rf.set_dead_man(2)
    with pytest.raises(Unsafe, match=words):
        rf.output(True, lock_timeout=0)
    transport.finish()


def test_a_tripped_driver_says_so_and_is_cleared():
    rf, transport = driver(
        (">0 DEAD 2.0", "<0 OK 2"),
        (">1 RF ON", "!TRIP DEADMAN", "<1 ERR TRIPPED CLR first"),
        (">2 CLR", "<2 OK"),
        (">3 PING", "<3 OK"),
    )
    rf.set_dead_man(2)
    with pytest.raises(Unsafe, match="ERR TRIPPED CLR first"):
        rf.output(True)
    rf.clear_trip()
    rf.ping()
    transport.finish()


@pytest.mark.parametrize("seconds", [0, 0.05, 61, math.nan])
def test_a_dead_man_needs_a_time(seconds):
    with pytest.raises(ValueError, match=r"0\.1 to 60 s"):
        RfDriver(ReplayTransport([])).set_dead_man(seconds)


@pytest.mark.parametrize("count", [0, 65])
def test_a_table_has_1_to_64_phases(count):
    with pytest.raises(ValueError, match="Expected 1 to 64 phases"):
        RfDriver(ReplayTransport([])).load_table([0.0] * count)


def test_the_safe_state_is_asked_for_until_it_is_heard():
    rf, transport = driver(
        (">0 SAFE",),
        (">1 SAFE", b"<1 O*0000\n"),
        (">2 SAFE", "<2 OK"),
        (">3 STAT?", "<3 OK 0 0 0 0 0"),
    )
    rf.safe_state()
    transport.finish()


def test_an_unsafe_end_is_reported():
    rf, _ = driver((">0 SAFE", "<0 OK"), (">1 STAT?", "<1 OK 1 1 0 0 0"))
    with pytest.raises(Unsafe, match="Expected RF off at rf, got on"):
        rf.safe_state()


def test_leaving_the_context_reaches_the_safe_state_and_closes():
    rf, transport = driver((">0 SAFE", "<0 OK"), (">1 STAT?", "<1 OK 0 0 0 0 0"))
    with pytest.raises(RuntimeError, match="inside"), rf:
        raise RuntimeError("inside")
    transport.finish()


def test_a_failed_safe_state_does_not_hide_what_happened():
    rf, _ = driver(*[(f">{n} SAFE",) for n in range(3)])
    with pytest.raises(RuntimeError, match="inside") as caught, rf:
        raise RuntimeError("inside")
    assert "Expected rf in its safe state" in caught.value.__notes__[0]
    rf, _ = driver(*[(f">{n} SAFE",) for n in range(3)])
    with pytest.raises(InstrumentError, match="Switch it off by hand"), rf:
        pass
