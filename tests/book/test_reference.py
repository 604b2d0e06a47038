"""The numbers of the ci profile are the stored ones, on any processor."""

import numpy as np
from pytest import mark

from cmtof_book import reference


@mark.skipif(not reference.RESULTS.is_dir(), reason="no ci build: make test makes one")
def test_numbers_agree_with_the_stored_ones():
    assert not list(
        reference.differences(reference.found_numbers(), reference.stored_numbers())
    )


def test_few_numbers_are_compared():
    assert (
        100
        < sum(np.size(one.value) for one in reference.stored_numbers().values())
        <= 250
    )
