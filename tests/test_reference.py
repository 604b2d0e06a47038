"""The numbers of the ci profile are the stored ones."""

import pytest

import reference

needs_build = pytest.mark.skipif(
    not reference.RESULTS.is_dir(), reason="no ci build: make test makes one"
)


@needs_build
def test_every_result_has_a_reference_and_every_reference_a_result():
    found, stored = set(reference.found()), set(reference.stored())
    assert found <= stored
    # numbers of measured captures are missing where there are none, and the other way round
    assert {name for name in stored - found if ".measured." not in name} <= {
        name for name in stored if ".simulated." in name
    }


@needs_build
@pytest.mark.parametrize("name", sorted(reference.found()))
def test_numbers_are_within_their_tolerance(name: str):
    numbers, entries = reference.found()[name], reference.stored()[name]
    assert numbers.keys() == entries.keys()
    left = {
        key: f"{value} instead of {entries[key]['value']} (rtol {entries[key]['rtol']})"
        for key, value in numbers.items()
        if not reference.agrees(value, entries[key])
    }
    assert not left


def test_nested_numbers_get_names():
    assert reference.flat({"a": [1, {"b": 2.5}], "c": "x"}) == {"a[0]": 1, "a[1].b": 2.5, "c": "x"}


@pytest.mark.parametrize(
    ("value", "entry", "expected"),
    [
        (1.0000005, {"value": 1.0, "rtol": 1e-6}, True),
        (1.000002, {"value": 1.0, "rtol": 1e-6}, False),
        (1e-13, {"value": 0.0, "rtol": 1e-6}, True),
        (0.2, {"value": 0.0, "rtol": 1e-6, "atol": 0.3}, True),
        ("a", {"value": "b", "rtol": 1.0}, False),
        (None, {"value": 1.0, "rtol": 1.0}, False),
        (True, {"value": True, "rtol": 0.0}, True),
    ],
)
def test_agreement_is_relative_with_a_floor(value, entry, expected):
    assert reference.agrees(value, entry) is expected
