"""A hundred hostile inputs; `make fuzz` runs five thousand."""

import fuzz
import pytest


@pytest.fixture(scope="module", autouse=True)
def _loaded():
    fuzz.loaded()


@pytest.mark.parametrize("case", range(100))
def test_a_hostile_input_ends_in_one_line(case):
    assert not fuzz.run(case)
