"""How far a number may move follows from its kind."""

import numpy as np
from pytest import mark, raises

from cmtof_book.compared import (
    Compared,
    closed_form,
    decision,
    share_of_pixels,
    sum_over_draws,
)
from cmtof_book.reference import differences


@mark.parametrize(
    ("stored", "inside", "outside"),
    [
        (closed_form(2.0), 2 + 1e-9, 2 + 4e-9),
        (closed_form([1.0, 1e9]), [1.0, 1e9 + 0.5], [1 + 1e-8, 1e9]),
        (sum_over_draws(1.0, error=0.1), 1.49, 1.51),
        (share_of_pixels(0.5, pixels=1000), 0.519, 0.521),
        (share_of_pixels(0.5, pixels=1000, error=0.01), 0.549, 0.551),
        (decision(0.9, at_least=0.7), 0.71, 0.69),
        (decision([0.9, 0.8], at_least=[0.7, 0.6]), [1.0, 0.6], [1.0, 0.5]),
    ],
)
def test_each_kind_has_its_tolerance(stored, inside, outside):
    assert stored.accepts(inside)
    assert not stored.accepts(outside)
    assert not stored.accepts(np.full_like(np.asarray(inside), np.nan))


def test_two_draws_may_be_five_errors_of_their_difference_apart():
    assert sum_over_draws(1.0, error=0.3).accepts(3.4, error=0.4)
    assert not sum_over_draws(1.0, error=0.3).accepts(3.6, error=0.4)


def test_numbers_of_another_shape_or_kind_never_agree():
    one = closed_form(1.0)
    stored = {"a": closed_form([1.0, 2.0]), "b": one, "c": one}
    found = {"a": one, "b": sum_over_draws(1.0, error=1.0), "d": one}
    assert {line[0] for line in differences(found, stored)} == {*"abcd"}
    with raises(ValueError, match="'closed form', 'sum over draws'"):
        Compared(value=1.0, kind="guess")
