"""A hundred hostile inputs; `make fuzz` runs five thousand."""

import fuzz
import pytest


@pytest.fixture(scope="module", autouse=True)
def _loaded():
    fuzz.loaded()


@pytest.mark.parametrize("first", range(0, 100, 10))
def test_hostile_inputs_end_in_one_line(first):
    assert not [line for case in range(first, first + 10) for line in fuzz.run(case)[0]]
