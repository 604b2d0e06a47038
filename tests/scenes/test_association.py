"""Time stamps of the TUM benchmark."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cmtof.scenes.folders import associate, read_pairs, read_stamps

times = st.lists(st.integers(0, 400).map(lambda k: k / 1000), max_size=25)
within = st.sampled_from([0.0, 0.005, 0.02, 1.0])


@given(times, times, within)
def test_pairs_are_near_and_nobody_is_paired_twice(first, second, within):
    pairs = associate(first, second, within)
    assert all(abs(first[i] - second[j]) <= within for i, j in pairs)
    assert len({i for i, _ in pairs}) == len({j for _, j in pairs}) == len(pairs)
    assert pairs == sorted(pairs)


@given(times, times, within)
def test_nobody_is_left_alone_beside_a_free_partner(first, second, within):
    pairs = associate(first, second, within)
    alone = set(range(len(first))) - {i for i, _ in pairs}
    free = set(range(len(second))) - {j for _, j in pairs}
    assert not any(abs(first[i] - second[j]) <= within for i in alone for j in free)


@given(times)
def test_equal_times_pair_with_themselves(stamps):
    distinct = sorted(set(stamps))
    assert associate(distinct, distinct) == [(i, i) for i in range(len(distinct))]


@given(times.map(lambda t: sorted(set(t))), times.map(lambda t: sorted(set(t))), within)
def test_pairing_is_as_many_either_way_round(first, second, within):
    assert len(associate(first, second, within)) == len(associate(second, first, within))


def test_nearest_pair_first():
    assert associate([0.0, 0.010], [0.009]) == [(1, 0)]


name = st.from_regex(r"[a-z0-9_./-]{1,20}", fullmatch=True)
stamp = st.floats(0, 2e9).map(lambda t: round(t, 6))


@given(st.lists(st.tuples(stamp, name)), st.sampled_from([" ", "\t", "   ", ","]))
def test_lists_of_stamps_are_read_back(tmp_path_factory, rows, gap):
    path = tmp_path_factory.mktemp("lists") / "rgb.txt"
    lines = ["# color images", "# timestamp filename", ""]
    lines += [f"{t:.6f}{gap}{n}" for t, n in rows]
    path.write_text("\n".join(lines) + "\n")
    assert read_stamps(path) == [(float(f"{t:.6f}"), n) for t, n in rows]


@given(st.lists(st.tuples(stamp, name, stamp, name, st.booleans())))
def test_lists_of_pairs_are_read_whichever_stands_first(tmp_path_factory, rows):
    path = tmp_path_factory.mktemp("lists") / "associations.txt"
    lines = []
    for t, n, u, m, swap in rows:
        both = [f"{t} depth/{n}", f"{u} rgb/{m.replace('depth', '')}x"]
        lines.append(" ".join(both[::-1] if swap else both))
    path.write_text("\n".join(lines))
    assert [depth for depth, _ in read_pairs(path)] == [f"depth/{row[1]}" for row in rows]
    assert all(colour.startswith("rgb/") for _, colour in read_pairs(path))


@pytest.mark.parametrize("line", ["1.5", "one rgb/a.png", "nan rgb/a.png", "inf rgb/a.png"])
def test_lines_that_are_none_are_named(tmp_path, line):
    (tmp_path / "rgb.txt").write_text(f"# head\n1.0 rgb/0.png\n{line}\n")
    with pytest.raises(ValueError, match=r"line 3 of .*rgb\.txt.*Write the list anew"):
        read_stamps(tmp_path / "rgb.txt")


@pytest.mark.parametrize("line", ["1 rgb/a.png 1 rgb/b.png", "1 depth/a.png 1 depth/b.png"])
def test_pairs_without_one_depth_file_are_refused(tmp_path, line):
    (tmp_path / "associations.txt").write_text(line)
    with pytest.raises(ValueError, match="one file of each pair in a folder depth"):
        read_pairs(tmp_path / "associations.txt")


def test_bytes_that_are_no_text_are_refused(tmp_path):
    (tmp_path / "rgb.txt").write_bytes(np.arange(256, dtype=np.uint8).tobytes())
    with pytest.raises(ValueError, match="Write the list anew"):
        read_stamps(tmp_path / "rgb.txt")
