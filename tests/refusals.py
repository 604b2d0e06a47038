"""Tables of what is refused and of how the house is built; what a refusal says."""

import re
from pathlib import Path

from pytest import raises

from cmtof.files import read_document

HERE = Path(__file__).parent
WRONG = read_document(HERE / "wrong.yml")
HOUSE = read_document(HERE / "house.yml")


def is_one_sentence(error):
    """Whether an error says «Expected X, got Y. Do Z.» in one line."""
    return bool(re.fullmatch("Expected .*, got .*", str(error)))


def refused(message, error=ValueError):
    """Expect an error whose one line holds a message."""
    return raises(error, match=message, check=is_one_sentence)
