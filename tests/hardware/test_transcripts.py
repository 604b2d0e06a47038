"""Every line that a driver sends and reads, against what makers and public programs have printed.

Rewrite the guide's table of them with ``python tests/hardware/test_transcripts.py``.
"""

import re
from contextlib import nullcontext
from pathlib import Path

import pytest
from peers import DEVICES, LISTED, T7, called, dialogue, modbus, simulated

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
    pairs = [one.pair(**line) for line in case["lines"]]
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

KINDS = {"UINT16": "H", "UINT32": "I", "FLOAT32": "f"}
BURST = {"channel": "AIN0", "rate": 24000.0, "scans": 320, "range": 10.0}
BURST |= {"pulse_line": "FIO4", "pulse": 20}
KNOWN = dict(LISTED.values())


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
    daq = DEVICES["t7"].driver(modbus(peer), name="daq", stream=peer.stream)
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
        one = KNOWN[address]
        assert direction in one["access"], address
        assert set(kind) == {KINDS[one.get("holds", one["type"])]}, address


if __name__ == "__main__":
    GUIDE.write_text(page(GUIDE.read_text("utf-8")), "utf-8")
