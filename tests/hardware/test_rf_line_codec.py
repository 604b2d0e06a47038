"""The RF drivers' line protocol: its checksum, its lines, its values, and garbage."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cmtof.hardware.codecs import rf_line
from cmtof.hardware.codecs.crc import crc16
from cmtof.hardware.codecs.rf_line import Notice, Reply, line_from_text, parse_line
from cmtof.hardware.errors import BadReply, InstrumentError, Refused

WORDS = st.text(
    st.characters(min_codepoint=33, max_codepoint=126, exclude_characters="*"),
    min_size=1,
    max_size=8,
)


def bitwise_crc(data):
    """Shift register of CRC-16/CCITT-FALSE, bit by bit (Williams, A Painless Guide to CRC)."""
    register = 0xFFFF
    for byte in data:
        register ^= byte << 8
        for _ in range(8):
            register = (register << 1) ^ (0x1021 if register & 0x8000 else 0)
        register &= 0xFFFF
    return register


def test_checksum_has_the_catalogues_check_value():
    # Cook, Catalogue of parametrised CRC algorithms: CRC-16/IBM-3740, alias CCITT-FALSE
    assert crc16(b"123456789") == 0x29B1
    assert crc16(b"") == 0xFFFF


@given(st.binary(max_size=100))
def test_checksum_equals_the_shift_register(data):
    assert crc16(data) == bitwise_crc(data)


@given(st.binary(min_size=1, max_size=60), st.data())
def test_checksum_sees_every_burst_of_16_bits(data, draw):
    start = draw.draw(st.integers(0, 8 * len(data) - 1))
    error = draw.draw(st.integers(1, 0xFFFF)) << start
    flipped = int.from_bytes(data, "little") ^ error
    if flipped < 1 << 8 * len(data):
        assert crc16(flipped.to_bytes(len(data), "little")) != crc16(data)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (rf_line.request(7, "PING"), b">7 PING*9555\n"),
        (rf_line.request(0, "FREQ", 7_150_000_000), b">0 FREQ 7150000000*"),
        (rf_line.request(99, "POWR", 30.0), b">99 POWR 30.0*"),
        (rf_line.request(5, "RF", "ON"), b">5 RF ON*"),
        (rf_line.request(6, "TABL", 3, 0, 4096, 65535), b">6 TABL 3 0 4096 65535*"),
        (rf_line.request(8, "POWR", np.float64(-1.5)), b">8 POWR -1.5*"),
        (rf_line.request(9, "PHAS", *np.array([5])), b">9 PHAS 5*"),
    ],
)
def test_requests(line, expected):
    body = line[: line.index(b"*")]
    assert line.startswith(expected)
    assert line == b"%s*%04X\n" % (body, bitwise_crc(body))


def test_the_longest_table_fits():
    assert len(rf_line.request(99, "TABL", 64, *[65535] * 64)) < rf_line.LIMIT / 2


@pytest.mark.parametrize(
    ("build", "problem"),
    [
        (lambda: rf_line.request(100, "PING"), "Expected a sequence number 0 to 99, got 100"),
        (lambda: rf_line.request(-1, "PING"), "got -1"),
        (lambda: rf_line.request(0, ""), "Expected a printable word without * or space, got ''"),
        (lambda: rf_line.request(0, "PING\n>1 RF ON"), "printable word"),
        (lambda: rf_line.request(0, "RF", "O N"), "printable word"),
        (lambda: rf_line.request(0, "RF", "ON*0000"), "printable word"),
        (lambda: rf_line.request(0, "RF", "Ω"), "printable word"),
        (lambda: rf_line.request(0, "TABL", *[65535] * 300), "Expected a line to 1024 bytes"),
        (lambda: rf_line.code_from_phase(math.nan), "Expected a finite phase, got nan"),
    ],
)
def test_bad_requests_by_their_message(build, problem):
    with pytest.raises(ValueError, match="Expected ") as caught:
        build()
    assert problem in str(caught.value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("<7 OK", Reply(7, ())),
        ("<12 OK CMTOF-RF,1,2.0", Reply(12, ("CMTOF-RF,1,2.0",))),
        ("<3 OK 1 -1200 -18.25", Reply(3, ("1", "-1200", "-18.25"))),
        ("<3 ERR TRIPPED clear first", Reply(3, ("clear", "first"), "TRIPPED")),
        ("<?? ERR CHECKSUM send it again", Reply(None, ("send", "it", "again"), "CHECKSUM")),
        ("!TRIP DEADMAN", Notice("TRIP", ("DEADMAN",))),
        ("!LOCK 0", Notice("LOCK", ("0",))),
    ],
)
def test_lines(text, expected):
    assert parse_line(line_from_text(text)) == expected
    assert parse_line(line_from_text(text)[:-1] + b"\r\n") == expected
    assert parse_line(line_from_text(text)[:-1]) == expected


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        (b"", "Expected a line with a true checksum"),
        (b"\n", "true checksum"),
        (b"<7 OK\n", "true checksum"),
        (b"<7 OK*0000\n", "true checksum"),
        (line_from_text("<7 OK").lower(), "true checksum"),
        (line_from_text("<7 OK 1").replace(b"1*", b"2*"), "true checksum"),
        (line_from_text("<7 OK")[2:], "true checksum"),
        (line_from_text("<7 OK " + 1100 * "1"), "true checksum"),
        (line_from_text(">7 PING"), "Expected a reply or a notice"),
        (line_from_text("7 OK"), "Expected a reply or a notice"),
        (line_from_text("!"), "Expected a reply or a notice"),
        (line_from_text("<7  OK"), "Expected a reply or a notice"),
        (line_from_text("<7 OK "), "Expected a reply or a notice"),
        (line_from_text("<7 OK\t1"), "Expected a reply or a notice"),
        (line_from_text(""), "Expected a reply or a notice"),
        (line_from_text("<7"), "Expected OK or ERR"),
        (line_from_text("<7 ERR"), "Expected OK or ERR"),
        (line_from_text("<7 YES"), "Expected OK or ERR"),
        (line_from_text("<100 OK"), "Expected OK or ERR"),
        (line_from_text("<-1 OK"), "Expected OK or ERR"),
        (line_from_text("<?? OK"), "Expected OK or ERR"),
        (line_from_text("< OK"), "Expected OK or ERR"),
        (b"<7 OK \xff*%04X\n" % crc16(b"<7 OK \xff"), "Expected ASCII"),
    ],
)
def test_bad_lines_by_their_message(line, problem):
    with pytest.raises(BadReply) as caught:
        parse_line(line)
    assert problem in str(caught.value)


def test_values_of_a_reply():
    assert rf_line.values_from_reply(Reply(4, ("1", "2")), 4) == ("1", "2")
    with pytest.raises(BadReply, match="Expected the reply to 4, got one to 3"):
        rf_line.values_from_reply(Reply(3, ()), 4)
    with pytest.raises(Refused, match="got ERR TRIPPED clear first"):
        rf_line.values_from_reply(Reply(4, ("clear", "first"), "TRIPPED"), 4)
    with pytest.raises(BadReply, match=r"ERR CHECKSUM\. Send it again"):
        rf_line.values_from_reply(Reply(None, (), "CHECKSUM"), 4)


@pytest.mark.parametrize(
    ("take", "expected"),
    [
        (lambda: rf_line.integers(("3", "-5"), 2), (3, -5)),
        (lambda: rf_line.numbers(("3", "-5.5", "1e-3", ".5"), 4), (3.0, -5.5, 1e-3, 0.5)),
        (lambda: rf_line.integers((), 0), ()),
        (lambda: [rf_line.switch(v) for v in ("ON", "OFF", "1", "0")], [True, False, True, False]),
    ],
)
def test_typed_values(take, expected):
    assert take() == expected


@pytest.mark.parametrize(
    ("take", "problem"),
    [
        (lambda: rf_line.integers(("3",), 2), "Expected 2 whole numbers, got '3'"),
        (lambda: rf_line.integers(("3.0",), 1), "whole numbers"),
        (lambda: rf_line.integers(("1_0",), 1), "whole numbers"),
        (lambda: rf_line.integers(("٣",), 1), "whole numbers"),
        (lambda: rf_line.integers(("9" * 5000,), 1), "whole numbers"),
        (lambda: rf_line.numbers(("nan",), 1), "Expected 1 numbers, got 'nan'"),
        (lambda: rf_line.numbers(("inf",), 1), "numbers"),
        (lambda: rf_line.numbers(("1e999",), 1), "Expected 1 finite numbers"),
        (lambda: rf_line.numbers(("0x10",), 1), "numbers"),
        (lambda: rf_line.switch("on"), "Expected ON, OFF, 1 or 0, got 'on'"),
    ],
)
def test_bad_values_by_their_message(take, problem):
    with pytest.raises(BadReply) as caught:
        take()
    assert problem in str(caught.value)


@given(st.integers(0, 99), st.lists(WORDS, max_size=6))
def test_replies_round_trip(sequence, values):
    reply = parse_line(line_from_text(" ".join([f"<{sequence} OK", *values])))
    assert isinstance(reply, Reply)
    assert reply == Reply(sequence, tuple(values))
    assert rf_line.values_from_reply(reply, sequence) == tuple(values)


@given(WORDS, st.lists(WORDS, max_size=4))
def test_notices_round_trip(word, arguments):
    line = line_from_text(" ".join(["!" + word, *arguments]))
    assert parse_line(line) == Notice(word, tuple(arguments))


@given(
    st.one_of(
        st.binary(max_size=60),
        st.binary(max_size=60).map(lambda body: b"%s*%04X\n" % (body, crc16(body))),
        st.text(" <!>OKERR?*0123456789", max_size=30).map(line_from_text),
    )
)
def test_garbage_is_a_bad_reply(line):
    try:
        found = parse_line(line)
    except BadReply as error:
        assert isinstance(error, InstrumentError)
        assert str(error).startswith("Expected ")
    else:
        assert isinstance(found, Reply | Notice)


@given(st.integers(0, 65535))
def test_phase_codes_round_trip(code):
    phase = rf_line.phase_from_code(code)
    assert 0 <= phase < 2 * math.pi
    assert rf_line.code_from_phase(phase) == code
    assert rf_line.code_from_phase(phase - 2 * math.pi) == code


@given(st.floats(-100, 100))
def test_phase_codes_are_the_nearest(phase):
    code = rf_line.code_from_phase(phase)
    assert 0 <= code < 65536
    error = math.remainder(rf_line.phase_from_code(code) - phase, 2 * math.pi)
    assert abs(error) <= math.pi / 65536 * (1 + 1e-9)


def test_table_checksum_is_of_the_words_in_order():
    assert rf_line.table_crc([0x3132, 0x3334, 0x3536, 0x3738]) == crc16(b"12345678")
    assert rf_line.table_crc([1, 2]) != rf_line.table_crc([2, 1])
    assert rf_line.table_crc([]) == 0xFFFF
