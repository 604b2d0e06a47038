"""Every line that a driver sends and reads, against what makers and public programs have printed.

Rewrite the guide's table of them with ``python tests/hardware/test_transcripts.py``.
"""

import re
from contextlib import nullcontext
from pathlib import Path

import pytest
from peers import DEVICES, T7, called, dialogue, modbus, simulated

from cmtof.files import read_document
from cmtof.hardware import device, t7

HERE = Path(__file__).parent
GUIDE = HERE.parents[1] / "book" / "hardware.md"
CASES = [
    pytest.param(one, case, id=f"{name}: {case['what']}")
    for name, one in DEVICES.items()
    for case in one.file["dialogues"] + one.file.get("faults", [])
]


@pytest.mark.parametrize(("one", "case"), CASES)
def test_a_driver_says_and_understands_what_is_written(one, case):
    pairs = [(one.coded(x["sent"]), one.coded(x.get("received", ""))) for x in case["lines"]]
    error, words = case.get("raises", (None, None))
    fails = pytest.raises(getattr(device, error), match=words) if error else nullcontext()
    with dialogue(one.kind, *pairs) as port, fails:
        asked = {key: case[key] for key in ("call", "with", "options") if key in case}
        found = called(one.driver(port, name="device"), **asked)
        if "gives" in case:
            assert (list(found) if isinstance(found, tuple) else found) == case["gives"]


def table():
    """Rows of the guide: what was compared with what."""
    return "".join(
        f"| {one.file['device']} | {case['what']} | {case['evidence']} | {case['source']} |\n"
        for one in DEVICES.values()
        for case in one.file["dialogues"]
    )


def page(text):
    """The guide with the table of today."""
    head = re.escape("| device | dialogue | evidence | source |\n| --- | --- | --- | --- |\n")
    return re.sub(f"({head})(\\|.*\n)*", lambda found: found[1] + table(), text)


def test_the_guide_lists_what_was_compared():
    text = GUIDE.read_text("utf-8")
    assert table() in text
    assert page(text) == text


# --- registers of the T7 -------------------------------------------------------------------------

REGISTERS = read_document(HERE / "registers.yml")["registers"]
KINDS = {"UINT16": "H", "UINT32": "I", "FLOAT32": "f"}
BURST = {"channel": "AIN0", "rate": 24000.0, "scans": 320, "range": 10.0}
BURST |= {"pulse_line": "FIO4", "pulse": 20}


def published(address):
    """Entry of the maker's list for an address, or nothing."""
    for one in REGISTERS:
        words = 1 if one["type"] == "UINT16" else 2
        if address in range(one["address"], one["address"] + words * one.get("count", 1), words):
            return one
    return {"access": "", "type": ""}


def test_every_register_is_read_and_written_as_its_maker_says(monkeypatch):
    """Address, type and direction, in everything that the driver does."""
    used = set()

    def noted(direction, works):
        def part(register, *values):
            used.add((direction, *t7.REGISTERS[register]))
            return works(register, *values)

        return part

    for name in ("read", "write"):
        monkeypatch.setattr(t7, name, noted(name[0].upper(), getattr(t7, name)))
    peer = T7(simulated("daq"))
    parts = {"safe_lines": ["FIO0"], "parked": ["TDAC2"]}
    daq = t7.LabJackT7(modbus(peer), peer.stream, "daq", **parts)
    daq.identify()
    daq.gain(10.0)
    daq.line("FIO7")
    daq.watchdog(5)
    daq.save_power_up_state()
    daq.configure_burst(**BURST)
    list(daq.bursts([{"USER_RAM0_U32": 1.0}]))
    daq.safe_state()
    assert len(used) > 60
    for direction, address, kind in used:
        known = published(address)
        assert direction in known["access"], address
        assert set(kind) == {KINDS[known.get("holds", known["type"])]}, address


if __name__ == "__main__":
    GUIDE.write_text(page(GUIDE.read_text("utf-8")), "utf-8")
