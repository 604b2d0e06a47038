"""A hundred hostile inputs; `make fuzz` runs five thousand."""

import fuzz
from pytest import mark


# HDF5 steps over the free space of a heap by its size, in 3001 zero, and never comes to the end
@mark.parametrize("case", [*range(100), 3001])
def test_a_hostile_input_ends_in_one_line(case):
    assert not fuzz.run(case)
