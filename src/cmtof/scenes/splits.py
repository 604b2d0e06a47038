"""Which views train, validate and test."""

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Literal

from cmtof.scenes.hypersim_metadata import Listed

PARTITIONS = ("train", "val", "test")

Rule = Literal["scenes", "official", "authors"]
Split = dict[str, list[Listed]]

_OFFICIAL_NAME = re.compile(r"ai_\d{3}_\d{3}")


def is_authors_test(view: Listed) -> bool:
    """Whether a view is one of the paper's test frames: 0042 of camera 00 of an ai_VVV_001.

    Of the 49 such views 46 were published; 34 of them lie in the official training partition, 7 in
    its test and 5 in its validation partition.

    Examples
    --------
    >>> is_authors_test(Listed("ai_007_001", "cam_00", 42, "train"))
    True
    """
    first = re.fullmatch(r"ai_\d{3}_001", view.scene) is not None
    return first and view.camera == "cam_00" and view.frame == 42


def split_views(listed: Iterable[Listed], rule: Rule = "scenes") -> Split:
    """Part the published views into train, val and test.

    Parameters
    ----------
    listed : iterable of Listed
        Rows of the partition table.
    rule : {"scenes", "official", "authors"}
        ``scenes``, the default of this project: test are the paper's test frames
        (`is_authors_test`) or, in sets that were rendered here, the first view of each test scene.
        Train and val are the official partitions without any scene that holds a test frame, so
        that nothing is tested on a scene that was trained on.
        ``official``: the partitions as the table has them.
        ``authors``: the paper's test frames; everything else trains, neighbouring views of the
        tested scenes included. This rule and the official one exclude each other: 34 of the 46
        test frames lie in official training scenes.

    Returns
    -------
    dict
        Lists under train, val and test, sorted; no view stands in two of them.

    Raises
    ------
    ValueError
        If there is no such rule.

    Examples
    --------
    >>> views = [Listed("room_000_009", "cam_00", i, "test") for i in range(3)]
    >>> [view.frame for view in split_views(views)["test"]]
    [0]
    """
    rules: Mapping[str, Callable[[list[Listed]], Split]] = {
        "scenes": _by_scene,
        "official": _official,
        "authors": _by_authors,
    }
    if rule not in rules:
        raise ValueError(f"Expected a rule out of {', '.join(rules)}, got {rule}. Choose one.")
    return rules[rule](sorted(view for view in listed if view.partition in PARTITIONS))


def _official(views: list[Listed]) -> Split:
    return {name: [view for view in views if view.partition == name] for name in PARTITIONS}


def _by_authors(views: list[Listed]) -> Split:
    test = [view for view in views if is_authors_test(view)]
    return {"train": [v for v in views if not is_authors_test(v)], "val": [], "test": test}


def _by_scene(views: list[Listed]) -> Split:
    first: dict[str, Listed] = {}
    for view in views:
        if view.partition == "test" and not _OFFICIAL_NAME.fullmatch(view.scene):
            first.setdefault(view.scene, view)
    test = [view for view in views if is_authors_test(view) or first.get(view.scene) == view]
    tested = {view.scene for view in test}
    kept = _official([view for view in views if view.scene not in tested])
    return {"train": kept["train"], "val": kept["val"], "test": test}
