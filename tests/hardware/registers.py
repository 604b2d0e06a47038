"""Registers of a T7 as their maker lists them, and frames of function 76 in their names."""

import re
import struct
from pathlib import Path

from cmtof.files import read_document


def listed():
    """Address, kind and entry of every register by its name, from the maker's list."""
    found = {}
    for one in read_document(HERE / "registers.yml")["registers"]:
        for n in range(one.get("count", 1)):
            address = one["address"] + n * struct.calcsize(WORDS[one["type"]]) // 2
            kind = WORDS[one.get("holds", one["type"])]
            found[re.sub(r"#\(.*?\)", str(n), one["name"])] = address, kind, one
    return found


HERE = Path(__file__).parent
WORDS = {"UINT16": ">H", "UINT32": ">I", "FLOAT32": ">f"}
LISTED = listed()
ACCESS = {address: one["access"] for address, _, one in LISTED.values()}


def feedback(sent, received=""):
    """Frame and answer of function 76: ``NAME=value`` is a write, ``NAME?`` a read."""
    frame = b""
    answer = b""
    values = iter(str(received).split())
    for part in sent.split():
        name, _, value = part.rstrip("?").partition("=")
        address, kind, one = LISTED[name]
        words = one.get("words", struct.calcsize(kind) // 2)
        frame += struct.pack(">BHB", bool(value), address, words)
        number = float if kind == ">f" else int
        if value:
            frame += struct.pack(kind, number(value))
        else:
            for _ in range(words * 2 // struct.calcsize(kind)):
                answer += struct.pack(kind, number(next(values)))
    return frame, answer


def in_bytes(coded):
    """Pairs of bytes of what is sent and received."""
    return lambda sent, received="": (coded(sent), coded(received))
