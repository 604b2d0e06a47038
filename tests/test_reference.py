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
def test_numbers_are_within_their_tolerance():
    stored, left = reference.stored(), []
    for name, numbers in sorted(reference.found().items()):
        entries = stored[name]
        left += [f"{name}: {key}" for key in numbers.keys() ^ entries.keys()]
        left += [
            f"{name}.{key}: {value} instead of {entries[key]['value']} ({entries[key]['rtol']})"
            for key, value in numbers.items()
            if key in entries and not reference.agrees(value, entries[key])
        ]
    assert not left, "\n".join(left)


def test_nested_numbers_get_names():
    assert reference.flat({"a": [1, {"b": 2.5}], "c": "x"}) == {"a[0]": 1, "a[1].b": 2.5, "c": "x"}


def test_agreement_is_relative_with_a_floor():
    for value, entry, expected in (
        (1.0000005, {"value": 1.0, "rtol": 1e-6}, True),
        (1.000002, {"value": 1.0, "rtol": 1e-6}, False),
        (1e-13, {"value": 0.0, "rtol": 1e-6}, True),
        (0.2, {"value": 0.0, "rtol": 1e-6, "atol": 0.3}, True),
        ("a", {"value": "b", "rtol": 1.0}, False),
        (None, {"value": 1.0, "rtol": 1.0}, False),
        (True, {"value": True, "rtol": 0.0}, True),
    ):
        assert reference.agrees(value, entry) is expected
