"""The numbers of the ci profile are the stored ones, whatever the processor."""

import json
import os
import platform
from unittest import mock

import pytest

from cmtof_book import graph, reference

CHAPTERS = ["02_precision", "03_wraps", "09_limits", "10_methods", "11_surfaces"]
OLD_PROCESSOR = {  # every library computes as on one of 2009, on two threads
    "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR",
    "OPENBLAS_CORETYPE": "Nehalem",
    "NUMBA_CPU_NAME": "x86-64-v2",
    "NUMBA_CPU_FEATURES": "",
    "ATEN_CPU_CAPABILITY": "default",
    "ONEDNN_MAX_CPU_ISA": "SSE41",
    **dict.fromkeys(["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"], "2"),
}

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


def differences(found):
    """What numbers differ by, a line for each."""
    stored = reference.stored()
    for name, numbers in sorted(found.items()):
        entries = stored[name]
        yield from (f"{name}: {key}" for key in numbers.keys() ^ entries.keys())
        for key in numbers.keys() & entries.keys():
            if not reference.agrees(numbers[key], entries[key]):
                yield f"{name}.{key}: {numbers[key]} instead of {entries[key]}"


@needs_build
def test_numbers_are_within_their_tolerance():
    assert not list(differences(reference.found()))


@pytest.mark.slow
@pytest.mark.skipif(platform.machine() != "x86_64", reason="names of other processors")
def test_another_processor_finds_the_same_numbers(tmp_path, monkeypatch):
    from cmtof_book import execute  # takes a grammar from jsonschema, in this process too

    usual, book = execute.environment, graph.Book(reference.ROOT)
    monkeypatch.setattr(execute, "environment", lambda work: usual(work) | OLD_PROCESSOR)
    with mock.patch.dict(os.environ):
        for stem in CHAPTERS:
            parameters = json.dumps(book.parameters(stem, "ci"))
            targets = tmp_path / "notebooks" / f"{stem}.ipynb", tmp_path / "results" / stem
            command = [book.script(stem), parameters, *targets]
            assert execute.main([str(argument) for argument in command]) == 0
    assert not list(differences(reference.found(tmp_path / "results")))


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
