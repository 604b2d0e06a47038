"""Faults on demand: what may be asked for, when it happens, and what it looks like on the wire."""

import time

import pytest
from hypothesis import given
from hypothesis import strategies as st
from twin_stand_in import SocketClient, StandInWorld, ask, on_port, on_terminal, read_size

from cmtof.hardware.twin.faults import (
    KINDS,
    OF_REQUESTS,
    ROLES,
    Fault,
    Faults,
    Trouble,
    Watch,
    faults_from_settings,
)
from cmtof.hardware.twin.modbus_server import T7Server
from cmtof.hardware.twin.sdg_server import SdgServer
from cmtof.instrument.panel import Panel

IDENTITY = "Siglent Technologies,SDG2042X,"


def test_list_of_a_rig_file():
    found = faults_from_settings(
        [
            {"device": "daq", "kind": "lost-packets", "after": 100, "times": 2},
            {"device": "stage", "kind": "late", "delay": 0.3, "times": 0},
        ]
    )
    assert found == (
        Fault("daq", "lost-packets", 100, 2),
        Fault("stage", "late", times=0, delay=0.3),
    )
    assert faults_from_settings(found) == found
    assert faults_from_settings(None) == faults_from_settings(()) == ()


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ("silence", "a list of faults"),
        ({"device": "daq"}, "a list of faults"),
        (["silence"], "a fault as a mapping"),
        ([{"device": "daq"}], "`kind` in a fault"),
        ([{"kind": "late"}], "`device` in a fault"),
        ([{"device": "toaster", "kind": "late"}], "device in rf_emission"),
        ([{"device": "daq", "kind": "fire"}], "kind in silence"),
        ([{"device": "daq", "kind": "late", "when": 3}], "a fault's key in device"),
        ([{"device": "clock", "kind": "stall"}], "device for the fault stall"),
        ([{"device": "stage", "kind": "saturate"}], "device for the fault saturate"),
        ([{"device": "daq", "kind": "late", "after": -1}], "`after`"),
        ([{"device": "daq", "kind": "late", "times": 1.5}], "`times`"),
        ([{"device": "daq", "kind": "late", "times": True}], "`times`"),
        ([{"device": "daq", "kind": "late", "delay": "1"}], "`delay` in s"),
        ([{"device": "daq", "kind": "late", "delay": 1e9}], "0 to 60 s"),
    ],
)
def test_what_cannot_be_is_one_line(settings, message):
    with pytest.raises(ValueError, match=rf"Expected .*{message}.*, got .*\. .*\."):
        faults_from_settings(settings)


def test_every_kind_says_what_it_does():
    assert set(OF_REQUESTS) <= set(KINDS)
    for kind, (text, roles) in KINDS.items():
        assert text and set(roles) <= set(ROLES)
        Fault(roles[0], kind)


@given(after=st.integers(0, 5), times=st.integers(0, 4), requests=st.integers(0, 12))
def test_faults_of_requests_are_counted(after, times, requests):
    watch = Watch("clock")
    watch.add(Fault("clock", "silence", after, times))
    seen = ["silence" in watch.next() for _ in range(requests)]
    last = after + times if times else requests
    assert seen == [after <= n < last for n in range(requests)]


def test_faults_of_occasions_wait_for_them():
    watch = Watch("clock")
    watch.add(Fault("clock", "ignore", after=1, times=2))
    watch.next()
    assert not watch.takes("ignore")
    watch.next()
    watch.next()
    assert [watch.takes("ignore") for _ in range(3)] == [True, True, False]


def test_faults_are_of_one_device_and_can_be_cleared():
    faults = Faults([Fault("clock", "cut", times=0)])
    faults.add("daq", "late", delay=0.5)
    assert "cut" in faults.watch("clock").next()
    assert "late" not in faults.watch("stage").next()
    faults.clear()
    assert "cut" not in faults.watch("clock").next()
    with pytest.raises(ValueError, match="Expected device"):
        faults.watch("toaster")


@pytest.mark.parametrize(
    ("kind", "reply", "spoilt"),
    [
        ("cut", b"<7 OK 123*ABCD\n", b"<7 OK 1"),
        ("garble", b"<7 OK\n", b"<\xb7 OK\n"),
        ("garble", b"1\n", b"\xb1\n"),
        ("garble", b"", b""),
        ("late", b"1\n", b"1\n"),
    ],
)
def test_spoilt_replies(kind, reply, spoilt):
    assert Trouble({kind: 0.0}).spoil(reply) == spoilt


@pytest.mark.parametrize(
    ("kind", "frequency"),
    [
        ("silence", "1000HZ"),
        ("drop-connection", "1000HZ"),
        ("late", "5000HZ"),
        ("cut", "5000HZ"),
        ("garble", "5000HZ"),
        ("ignore", "1000HZ"),
        ("clamp", "1e-06HZ"),
    ],
)
def test_faults_on_the_wire(kind, frequency):
    """One fault at a line that sets and asks; then all is well again."""
    watch = Watch("clock")
    with on_port(SdgServer(Panel(), watch).serve) as (line, client):
        watch.add(Fault("clock", kind, delay=0.05))
        began = time.monotonic()
        client.send(b"C1:BSWV FRQ,5000;*IDN?\n")
        if kind == "silence":
            assert client.read(0.05) == b""
        elif kind == "drop-connection":
            assert client.read() == b""
            client = SocketClient(line.port)
        else:
            reply = client.read()
            assert (time.monotonic() - began >= 0.05) == (kind == "late")
            if kind == "cut":
                assert IDENTITY.startswith(reply.decode()) or reply.startswith(IDENTITY.encode())
                assert not reply.endswith(b"\n")
            elif kind == "garble":
                assert reply[1] == IDENTITY.encode()[1] ^ 0x80
            else:
                assert reply.startswith(IDENTITY.encode())
        assert f"FRQ,{frequency}" in ask(client, "C1:BSWV?")
        client.close()


@pytest.mark.parametrize("kind", ["silence", "late", "cut", "garble", "drop-connection"])
def test_faults_of_frames(kind):
    watch = Watch("daq")
    server = T7Server(Panel(), StandInWorld(), watch)
    frame, good = bytes.fromhex("0001 0000 0006 01 03 d73c 0002"), "0001000000070103" + "0400112233"
    with on_port(server.serve) as (line, client):
        watch.add(Fault("daq", kind, delay=0.02))
        client.send(frame)
        reply = client.read(5.0 if kind != "silence" else 0.03).hex()
        assert (
            reply
            == {
                "silence": "",
                "drop-connection": "",
                "late": good,
                "cut": good[:12],
                "garble": "0081" + good[4:],
            }[kind]
        )
        again = SocketClient(line.port)
        again.send(frame)
        assert read_size(again, 13).hex() == good
        again.close()


def test_late_reply_does_not_hold_up_the_end(tmp_path):
    watch = Watch("clock")
    watch.add(Fault("clock", "late", delay=60.0))
    with on_terminal(SdgServer(Panel(), watch).serve, tmp_path) as (_, client):
        client.send(b"*IDN?\n")
        while not watch.requests:
            time.sleep(0.001)
        began = time.monotonic()
    assert time.monotonic() - began < 5.0


def test_ignored_frames_change_nothing():
    watch, panel = Watch("daq"), Panel()
    server = T7Server(panel, StandInWorld(), watch)
    watch.add(Fault("daq", "ignore"))
    watch.next()
    server.write(2000, b"\0\1")
    assert not panel.laser_on
    server.write(2000, b"\0\1")
    assert panel.laser_on
