"""Every line that a driver sends and reads, against what makers and public programs have printed.

Rewrite the guide's table of them with ``python tests/hardware/test_transcripts.py``.
"""

import re
from contextlib import nullcontext

from kinds import DEVICES, called, dialogue
from pytest import mark, param
from refusals import refused
from registers import LISTED

from cmtof.hardware import device, t7
from cmtof_book import ROOT

GUIDE = ROOT / "book" / "hardware.md"
CASES = [
    param(one, case, id=f"{one.name}: {case['what']}")
    for one in DEVICES
    for case in one.file["dialogues"] + one.file.get("faults", [])
]


@mark.parametrize("one, case", CASES)
def test_a_driver_says_and_understands_what_is_written(one, case):
    pairs = [one.pair(**line) for line in case["lines"]]
    error, words = case.get("raises", (None, None))
    fails = refused(words, getattr(device, error)) if error else nullcontext()
    with dialogue(one.kind, *pairs) as port, fails:
        asked = {key: case[key] for key in ("call", "with", "options") if key in case}
        found = called(one.driver(port, name="device"), **asked)
        if "gives" in case:
            assert found == case["gives"]


def table():
    """Rows of the guide: what was compared with what."""
    return "".join(
        f"| {one.file['device']} | {case['what']} | {case['evidence']} | {case['source']} |\n"
        for one in DEVICES
        for case in one.file["dialogues"]
    )


def page(text):
    """The guide with the table of today."""
    head = re.escape(
        "| device | dialogue | evidence | source |\n| --- | --- | --- | --- |\n"
    )
    return re.sub(f"({head})(\\|.*\n)*", lambda found: found[1] + table(), text)


def test_the_guide_lists_what_was_compared():
    text = GUIDE.read_text("utf-8")
    assert table() in text
    assert page(text) == text


# --- registers of the T7 -------------------------------------------------------------------------


def test_every_register_has_its_makers_address_and_type():
    """That it is read and written as its maker allows the T7 of these tests sees to."""
    for name, (address, kind) in t7.REGISTERS.items():
        assert (address, f">{kind[0]}") == LISTED[name][:2], name


if __name__ == "__main__":
    GUIDE.write_text(page(GUIDE.read_text("utf-8")), "utf-8")
