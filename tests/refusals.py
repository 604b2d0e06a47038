"""What is refused, and what a refusal says: one line of one pattern."""

import re
from pathlib import Path

from pytest import raises

from cmtof.files import read_document

WRONG = read_document(Path(__file__).with_name("wrong.yml"))


def is_one_sentence(error):
    """Whether an error says «Expected X, got Y. Do Z.» in one line."""
    return bool(re.fullmatch("Expected .*, got .*", str(error)))


def refused(message, error=ValueError):
    """Expect an error whose one line holds a message."""
    return raises(error, match=message, check=is_one_sentence)
