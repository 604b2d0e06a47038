"""The numbers of the ci profile are the stored ones, on any processor."""

from pytest import mark

from cmtof_book import reference

MOST = 250

needs_build = mark.skipif(not reference.RESULTS.is_dir(), reason="no ci build: make test makes one")


@needs_build
def test_numbers_agree_with_the_stored_ones():
    found = reference.found_numbers()
    assert not list(reference.differences(found, reference.stored_numbers()))


def test_few_numbers_are_compared():
    assert 100 < sum(number.size for number in reference.stored_numbers().values()) <= MOST
