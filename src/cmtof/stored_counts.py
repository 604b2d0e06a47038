"""Counts kept on disk: a page shows those over all test frames and counts a few again.

A table costs minutes to hours, its counts a few kilobytes. They are stored with all that decides
them, the hashes of the weights included; a method that comes later is counted alone and joined.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cmtof import __version__
from cmtof.files import written_whole
from cmtof.tally import Contest, Record

TOLERABLE = 0.01
"""Share of a frame's pixels that another processor may count differently."""


def _digest(held: Mapping[str, Any]) -> str:
    rest = {key: value for key, value in held.items() if key != "sha256"}
    plain = json.dumps(rest, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(plain.encode()).hexdigest()


def write_counts(
    path: Path, contest: Contest, records: Sequence[Record], *, command: str
) -> dict[str, Any]:
    """Store counts with what decided them and a hash over all of it; return what was written.

    Parameters
    ----------
    path : Path
        JSON, one frame a line.
    contest : Contest
    records : list of dict
        One of each of the contest's frames, in order.
    command : str
        What makes the file anew.
    """
    held = {
        "command": command,
        "version": __version__,
        "settings": contest.settings(),
        "weights": contest.weights(),
        "frames": list(records),
    }
    held["sha256"] = _digest(held)
    lines = [f'"{key}": {_line(value)}' for key, value in held.items() if key != "frames"]
    frames = ",\n".join(_line(record) for record in records)
    with written_whole(path) as part:
        part.write_text("{" + ",\n".join([*lines, f'"frames": [\n{frames}\n]']) + "}\n", "utf-8")
    return held


def _line(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)


def read_counts(path: Path) -> dict[str, Any]:
    """Read stored counts.

    Raises
    ------
    ValueError
        If the file is no tally, or was changed after it was written.
    """
    try:
        held = json.loads(path.read_text(encoding="utf-8"))
        good = held["sha256"] == _digest(held)
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"Expected counts in {path}, got {error!r}. Make them anew.") from error
    if not good:
        raise ValueError(f"Expected counts as written in {path}, got edited ones. Make them anew.")
    return held


def outdated(held: Mapping[str, Any], contest: Contest) -> list[str]:
    """Labels of a contest that stored counts lack or hold of other weights."""
    counted, hashes = held["frames"][0]["methods"], contest.weights()
    return [
        label
        for label in contest.entries
        if label not in counted or held["weights"].get(label) != hashes.get(label)
    ]


def objection(held: Mapping[str, Any], contest: Contest) -> str:
    """Why stored counts do not belong to a contest; empty where they do."""
    if held["settings"] != contest.settings():
        return "they were made with other settings"
    if labels := outdated(held, contest):
        return f"they lack {', '.join(labels)}, or hold it with other weights"
    return ""


def joined(held: Mapping[str, Any], records: Sequence[Record], contest: Contest) -> list[Record]:
    """Stored counts with newer ones of some labels, in the order of the contest's entries.

    Raises
    ------
    ValueError
        If the two are not of the same frames and pixels.
    """
    whole = []
    for old, new in zip(held["frames"], records, strict=True):
        if any(old[key] != new[key] for key in ("frame", "pixels", "strata")):
            raise ValueError(
                f"Expected counts of {old['frame']} over {old['pixels']} pixels, got "
                f"{new['frame']} over {new['pixels']}. Count all methods anew."
            )
        methods = old["methods"] | new["methods"]
        whole.append(old | {"methods": {label: methods[label] for label in contest.entries}})
    return whole


class Kept(NamedTuple):
    """Counts that a page shows, and what it has to say of them."""

    records: Sequence[Record]
    """The stored ones if they belong to the contest, else those that the page counted itself."""
    whole: bool
    """Whether they are the stored ones, of all test frames."""
    state: str
    """A sentence or two, in markdown."""


def kept(path: Path, contest: Contest, own: Sequence[Record], own_contest: Contest) -> Kept:
    """Stored counts of a contest, held against those that a page made of a few of its frames.

    Parameters
    ----------
    path : Path
        Of the stored counts; they may not be there.
    contest : Contest
        Whose counts they should be.
    own : list of dict
        Counts made by the page.
    own_contest : Contest
        What they were made by, perhaps of smaller frames, which cannot be compared.
    """
    held = read_counts(path) if path.is_file() else None
    if why := objection(held, contest) if held else "there are none":
        if not own:
            return Kept(own, False, f"**The stored counts cannot be shown: {why}.**")
        sizes = f"{own_contest.rooms.height}×{own_contest.rooms.width}"
        return Kept(
            own,
            False,
            f"**The stored counts cannot be shown: {why}.** What follows comes from the {len(own)} "
            f"frames of {sizes} counted here, far too few for a table.",
        )
    assert held is not None
    source = (
        f"What follows comes from the stored counts over {len(held['frames'])} frames "
        f"(`{path.name}`, version {held['version']}, hash `{held['sha256'][:12]}`)"
    )
    if contest.settings() != own_contest.settings():
        rest = "; this run's own frames are of another size or noise, and only show that the "
        return Kept(held["frames"], True, f"{source}{rest}counting works.")
    off = disagreement(held, own)
    state = (
        f"{source}. {len(own)} frames counted again differ from them by at most "
        f"{100 * off:.2f} % of a frame's pixels."
    )
    if off > TOLERABLE:
        state += " **That is too much: the stored counts are out of date.**"
    return Kept(held["frames"], True, state)


def disagreement(held: Mapping[str, Any], records: Sequence[Record]) -> float:
    """Largest share of a frame's pixels by which counts made again differ from the stored ones.

    Rounding differs between processors, so a few pixels may. A frame that is not the same at all,
    or whose pixels are others, counts as 1.
    """
    stored = {record["frame"]: record for record in held["frames"]}
    worst = 0.0
    for record in records:
        other = stored.get(record["frame"])
        if other is None or other["pixels"] != record["pixels"]:
            return 1.0
        for label, ours in record["methods"].items():
            off = np.subtract(ours["below"], other["methods"][label]["below"])
            worst = max(worst, float(np.abs(off).max()) / record["pixels"])
    return worst
