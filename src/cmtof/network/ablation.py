"""The rows of Table 1: which trained networks may stand beside each other.

Rows are compared only if they were trained alike: one configuration, as long, on the same frames.
"""

import json
from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from cmtof.network.configuration import MODELS
from cmtof.network.features import FEATURE_SETS
from cmtof.network.weights import FOLDER, read_card

ROWS = {
    "proposed": "fast-scnn",
    "ce_only": "fast-scnn-ce",
    "fourier": "fast-scnn-fourier",
    "phase_only": "fast-scnn-phase",
}
"""Models of the rows, best first, by their names in ``paper.yml``."""

TITLES = {
    "proposed": "proposed",
    "ce_only": "cross-entropy only",
    "fourier": "Fourier features",
    "phase_only": "phase only",
}

SHORT = ("cpu", "smoke")
"""Configurations that are far too short to learn the task; they show that everything runs."""

_WORDS = {
    "phase": "phases",
    "fourier": "Fourier features",
    "edges": "phase edges",
    "amplitude": "log amplitudes",
    "beat": "the beat",
    "correlation": "raw correlations",
}


class Row(NamedTuple):
    """One trained network."""

    key: str
    """Out of `ROWS`."""
    path: Path
    """Of its weights."""
    card: dict[str, Any]

    @property
    def label(self) -> str:
        """Name of the weights, such as ``fast-scnn.released``."""
        return self.path.name.removesuffix(".safetensors")

    @property
    def configuration(self) -> str:
        """Name of the configuration that it was trained by."""
        return str(self.card.get("configuration", {}).get("name", "unknown"))

    @property
    def short(self) -> bool:
        """Whether the training was only a rehearsal."""
        return self.configuration in SHORT


def found_rows(protocol: str = "released", folder: Path = FOLDER) -> list[Row]:
    """Trained networks of the rows that are there, of any configuration, in the order of `ROWS`."""
    keys = {model: key for key, model in ROWS.items()}
    cards = [(path, read_card(path)) for path in sorted(folder.glob("*.safetensors"))]
    rows = [
        Row(keys[card["model"]], path, card)
        for path, card in cards
        if card["model"] in keys and card["protocol"] == protocol
    ]
    return sorted(rows, key=lambda row: list(ROWS).index(row.key))


def budget(card: Mapping[str, Any]) -> str:
    """All of a training's configuration but the model, as one line of text."""
    rest = {k: v for k, v in card.get("configuration", {}).items() if k != "model"}
    return json.dumps(rest | {"steps": card.get("steps")}, sort_keys=True)


def comparable(rows: Iterable[Row]) -> dict[str, Row]:
    """The most rows that were trained alike, by key; of equally many, those of the most steps."""
    groups: dict[str, dict[str, Row]] = defaultdict(dict)
    for row in rows:
        groups[budget(row.card)].setdefault(row.key, row)

    def worth(group: dict[str, Row]) -> tuple[int, int]:
        return len(group), max(row.card.get("steps") or 0 for row in group.values())

    return max(groups.values(), key=worth, default={})


def reads(model: str) -> str:
    """What a model is given, in words.

    Examples
    --------
    >>> reads("fast-scnn-phase")
    'phases, log amplitudes'
    """
    return ", ".join(_WORDS[kind] for kind in FEATURE_SETS[MODELS[model].features])


def trained_for(model: str) -> str:
    """What a model's loss is made of, in words.

    Examples
    --------
    >>> trained_for("fast-scnn-ce")
    'wrap'
    """
    weight = MODELS[model].depth_weight
    return f"wrap and depth (w = {weight:g})" if weight else "wrap"


def last_gain(card: Mapping[str, Any], what: str = "delta_lt_1", share: float = 0.25) -> float:
    """Change of a validation figure over the last share of a training.

    Parameters
    ----------
    card : dict
    what : str
        ``delta_lt_1``, a fraction of all pixels, or ``validation_loss``.
    share : float
        Of all steps.

    Raises
    ------
    ValueError
        If the card holds no validation.
    """
    curve = card.get("validation") or []
    if not curve:
        raise ValueError("Expected a card with its validation curve, got none. Train the row anew.")
    last = curve[-1]
    before = [one for one in curve if one["step"] <= (1 - share) * last["step"]] or curve[:1]
    return float(last[what] - before[-1][what])
