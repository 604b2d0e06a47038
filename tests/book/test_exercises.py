"""The solutions of the exercises run."""

import doctest
from pathlib import Path

import pytest

EXERCISES = sorted((Path(__file__).parents[2] / "book" / "exercises").glob("*.md"))


@pytest.mark.parametrize("page", EXERCISES, ids=lambda page: page.stem)
def test_solutions_run(page):
    done = doctest.testfile(str(page), module_relative=False, encoding="utf-8")
    assert done.attempted > 2 and not done.failed
