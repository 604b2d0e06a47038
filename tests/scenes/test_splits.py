"""Partitions: what they hold, and that nothing trained on is tested."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cmtof.scenes.hypersim import PARTITIONS, Listed, is_authors_test, read_split, split_views

RULES = ("scenes", "official", "authors")


def scenes_of(views):
    return {view.scene for view in views}


tables = st.builds(
    lambda partitions, views: [Listed(s, *v, p) for s, p in partitions.items() for v in views],
    st.dictionaries(
        st.sampled_from([f"ai_00{i}_00{j}" for i in range(3) for j in range(1, 4)])
        | st.sampled_from([f"room_000_00{i}" for i in range(5)]),
        st.sampled_from(["train", "val", "test", ""]),
        max_size=12,
    ),
    st.lists(
        st.tuples(st.sampled_from(["cam_00", "cam_01"]), st.sampled_from([0, 7, 42])), unique=True
    ),
)


@pytest.mark.parametrize("rule", RULES)
@given(listed=tables)
def test_no_view_stands_in_two_partitions(rule, listed):
    split = split_views(listed, rule)
    assert list(split) == list(PARTITIONS)
    views = [view for part in split.values() for view in part]
    assert len(views) == len(set(views))
    assert set(views) <= {view for view in listed if view.partition}


@given(tables)
def test_by_default_no_scene_is_trained_on_and_tested(listed):
    split = split_views(listed)
    train, val, test = (scenes_of(split[name]) for name in PARTITIONS)
    assert not train & test and not val & test and not train & val


@given(tables)
def test_each_rendered_test_scene_is_tested_on_its_first_view(listed):
    test = [view for view in split_views(listed)["test"] if view.scene.startswith("room")]
    tested = {v.scene for v in listed if v.partition == "test" and v.scene.startswith("room")}
    assert [view.scene for view in test] == sorted(tested)
    for view in test:
        assert view == min(other for other in listed if other.scene == view.scene)


@given(tables, st.randoms())
def test_order_of_the_table_does_not_matter(listed, random):
    shuffled = random.sample(listed, len(listed))
    assert split_views(listed) == split_views(shuffled)


def test_unknown_rules_are_refused():
    with pytest.raises(ValueError, match="Expected a rule out of scenes, official, authors"):
        split_views([], "volumes")  # type: ignore[arg-type]


def test_the_papers_frame_rule_and_the_official_split_exclude_each_other(official_tables):
    """49 frames fit the rule, 46 were published, 34 of those in official training scenes."""
    listed = read_split(official_tables / "metadata_images_split_scene_v1.csv")
    fitting = [view for view in listed if is_authors_test(view)]
    test = split_views(listed, "authors")["test"]
    count = {name: sum(view.partition == name for view in test) for name in PARTITIONS}
    assert (len(fitting), len(test)) == (49, 46)
    assert count == {"train": 34, "val": 5, "test": 7}


def test_official_partitions_part_scenes(official_tables):
    listed = read_split(official_tables / "metadata_images_split_scene_v1.csv")
    official = split_views(listed, "official")
    assert {name: len(views) for name, views in official.items()} == {
        "train": 59543, "val": 7386, "test": 7690,
    }  # fmt: skip
    scenes = [scenes_of(official[name]) for name in PARTITIONS]
    assert len(set.union(*scenes)) == sum(map(len, scenes))


def test_default_split_tests_the_papers_frames_on_scenes_nobody_trained_on(official_tables):
    listed = read_split(official_tables / "metadata_images_split_scene_v1.csv")
    split, official = split_views(listed), split_views(listed, "official")
    assert split["test"] == split_views(listed, "authors")["test"]
    assert not scenes_of(split["train"]) & scenes_of(split["test"])
    lost = scenes_of(official["train"]) - scenes_of(split["train"])
    assert len(lost) == 34 and all(scene.endswith("_001") for scene in lost)
