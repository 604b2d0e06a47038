"""What a refusal says: one line of one pattern."""

import re

from pytest import raises


def is_one_sentence(error):
    """Whether an error says «Expected X, got Y. Do Z.» in one line."""
    return bool(re.fullmatch("Expected .*, got .*", str(error)))


def refused(message, error=ValueError):
    """Expect an error whose one line holds a message."""
    return raises(error, match=message, check=is_one_sentence)
