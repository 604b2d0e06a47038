"""Books in rows and stacks; paper."""

from itertools import pairwise

import numpy as np
import pytest
from furnishing import assert_made_well, draw

from cmtof.scenes.rooms import books

CATALOGUE = books.CATALOGUE
LIMITS = {
    "book": ((0.1, 0.36), (0.15, 0.38), (0.01, 0.055)),
    "book_stack": ((0.12, 0.36), (0.15, 0.4), (0.02, 0.42)),
    "book_row": ((0.02, 0.91), (0.1, 0.24), (0.1, 0.31)),
    "open_book": ((0.26, 0.45), (0.19, 0.32), (0.01, 0.2)),
    "magazine_pile": ((0.19, 0.42), (0.25, 0.45), (0.005, 0.12)),
    "paper_sheets": ((0.2, 0.5), (0.28, 0.55), (0.004, 0.06)),
    "folder_row": ((0.08, 0.65), (0.27, 0.31), (0.31, 0.34)),
    "box_file": ((0.07, 0.36), (0.24, 0.26), (0.3, 0.32)),
}
"""Least and greatest width, depth and height, m."""


def test_everything_has_limits():
    assert set(LIMITS) == set(CATALOGUE)


@pytest.mark.parametrize("name", CATALOGUE)
def test_it_is_made_well(name, check_thing):
    assert_made_well(name, CATALOGUE[name], LIMITS[name], check_thing, budget=4000)


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize(
    ("length", "height", "depth"), [(0.08, 0.2, 0.15), (0.4, 0.26, 0.2), (1.2, 0.3, 0.24)]
)
def test_a_row_stays_within_its_shelf(seed, length, height, depth):
    low, high = draw(books.book_row, seed, length=length, height=height, depth=depth).bounds
    size = high - low
    assert size[0] <= length + 1e-3
    assert size[1] <= depth + 1e-3
    assert size[2] <= height * 1.03


def test_a_row_has_no_more_than_forty_books_of_thirty_triangles():
    for seed in range(6):
        thing = draw(books.book_row, seed, length=1.2)
        assert sum(len(p.mesh.faces) for p in thing.parts) <= 40 * 36


def test_books_of_a_row_do_not_stand_in_each_other():
    for seed in range(12):
        rng = np.random.default_rng(seed)
        w, h = rng.uniform(0.01, 0.05, 40), rng.uniform(0.15, 0.3, 40)
        angle, start, used = books._arranged(rng, w, h, 0.9)
        corners = []
        for k in range(used):
            c, s = np.cos(angle[k]), np.sin(angle[k])
            box = np.array([(0, 0), (w[k], 0), (w[k], h[k]), (0, h[k])])
            corners.append(np.stack([c * box[:, 0] + s * box[:, 1] + start[k],
                                     c * box[:, 1] - s * box[:, 0]], -1))  # fmt: skip
        for a, b in pairwise(corners):
            assert not _crossing(a, b)


def _crossing(a, b) -> bool:
    """Whether two convex outlines overlap (separating axes)."""
    for polygon in (a, b):
        edges = np.roll(polygon, -1, axis=0) - polygon
        for normal in edges[:, ::-1] * [1, -1]:
            normal = normal / np.linalg.norm(normal)
            one, two = a @ normal, b @ normal
            if one.max() <= two.min() + 5e-4 or two.max() <= one.min() + 5e-4:
                return False
    return True


def test_some_books_lean():
    found = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        angle, _, used = books._arranged(rng, np.full(40, 0.02), np.full(40, 0.25), 0.9)
        found.append((angle[:used] < -0.05).sum())
    assert max(found) >= 2
    assert min(found) < 5


@pytest.mark.parametrize("count", [2, 5, 9])
def test_a_stack_has_as_many_books_as_asked(count):
    thing = draw(books.book_stack, 3, count=count)
    blocks = [p for p in thing.parts if p.material is books.PAGES]
    assert len(blocks) == count
    tops = [float(p.mesh.vertices[:, 2].max()) for p in blocks]
    assert tops == sorted(tops)
