"""Arguments that cannot be, and the one line that says so: the table of calls in wrong.yml."""

from pkgutil import resolve_name

from pytest import mark
from refusals import WRONG, refused


@mark.parametrize("name, arguments, message", WRONG["calls"])
def test_impossible_arguments_are_refused(name, arguments, message):
    with refused(f"^Expected .*{message}"):
        resolve_name(name)(**arguments)
