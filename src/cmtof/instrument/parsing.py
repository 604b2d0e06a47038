"""Settings out of plain mappings: strict keys, checked values, one pattern of error.

A section is a dataclass; the kind of each default is the kind of its value. The RIG file is read
this way, and what it says to the simulated instrument.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import MISSING, Field, field, fields, is_dataclass
from math import inf, isfinite, isnan
from typing import Any, TypeVar

Section = TypeVar("Section")


def number(default: float, low: float = -inf, high: float = inf) -> Any:
    """Field for a number from ``low`` to ``high``, both allowed."""
    return field(default=default, metadata={"low": low, "high": high})


def choice(default: str, options: Iterable[str]) -> Any:
    """Field for one of some words."""
    return field(default=default, metadata={"options": tuple(options)})


def mapping(raw: Any, path: str) -> Mapping[str, Any]:
    """What should be names and values; raise a ValueError for anything else."""
    if not isinstance(raw, Mapping):
        raise ValueError(f"Expected {path} to be a mapping, got {raw!r}. Write key: value lines.")
    return raw


def check_keys(raw: Mapping[str, Any], known: Sequence[str], path: str) -> None:
    """Raise a ValueError for a key that is not known."""
    for key in raw:
        if key not in known:
            raise ValueError(
                f"Expected keys of {path} out of {', '.join(known)}, got {key!r}. "
                "Correct or remove it."
            )


def section_from_mapping(kind: type[Section], raw: Any, path: str) -> Section:
    """Build a dataclass, and those within it, from a mapping with its field names as keys.

    Parameters
    ----------
    kind : type
        A dataclass. A field without a default takes text and must be there.
    raw : mapping
        What differs from the defaults.
    path : str
        Where the mapping stands, for the messages.

    Raises
    ------
    ValueError
        For unknown or missing keys, values of another type, and numbers out of their limits.
    """
    held = mapping(raw, path)
    known = {entry.name: entry for entry in fields(kind)}  # type: ignore[arg-type]
    check_keys(held, list(known), path)
    for name, entry in known.items():
        if entry.default is MISSING and entry.default_factory is MISSING and name not in held:
            raise ValueError(f"Expected {path}.{name}, got none. Add it.")
    values = {key: _value(known[key], held[key], f"{path}.{key}") for key in held}
    check_fields(kind, values, path)
    return kind(**values)


def check_fields(kind: type, values: Mapping[str, Any], path: str) -> None:
    """Raise a ValueError unless values keep to the limits that their fields were declared with."""
    for entry in fields(kind):
        if entry.name not in values:
            continue
        value, data = values[entry.name], entry.metadata
        if "options" in data and value not in data["options"]:
            raise ValueError(
                f"Expected {path}.{entry.name} out of {', '.join(data['options'])}, "
                f"got {value!r}. Choose one."
            )
        if "low" in data and not data["low"] <= value <= data["high"]:
            raise ValueError(
                f"Expected {path}.{entry.name} from {data['low']:g} to {data['high']:g}, "
                f"got {value:g}. Keep to SI units."
            )
        if type(entry.default) is int and not isinstance(value, int):
            raise ValueError(
                f"Expected {path}.{entry.name} to be a whole number, got {value!r}. Round it."
            )


def _value(entry: "Field[Any]", value: Any, path: str) -> Any:
    """Value of the kind that the default has."""
    if entry.default_factory is not MISSING and is_dataclass(entry.default_factory):
        return section_from_mapping(entry.default_factory, value, path)  # type: ignore[arg-type]
    default = "" if entry.default is MISSING else entry.default
    if isinstance(default, tuple) and default:
        if not isinstance(value, list):
            raise ValueError(
                f"Expected {path} to be a list such as {list(default)}, got {value!r}. Write one."
            )
        return tuple(_plain(default[0], one, path) for one in value)
    return _plain(default, value, path, endless="high" in entry.metadata)


def _plain(default: Any, value: Any, path: str, *, endless: bool = False) -> Any:
    """One value; infinity only where declared limits decide about it."""
    if isinstance(default, bool):
        if not isinstance(value, bool):
            raise ValueError(f"Expected {path} to be true or false, got {value!r}. Write one.")
        return value
    if isinstance(default, int | float):
        good = isinstance(value, int | float) and not isinstance(value, bool)
        if not good or isnan(value) or not (endless or isfinite(value)):
            # plain YAML 1.1 reads 7e9 as text: a sign is missing behind the e
            raise ValueError(
                f"Expected {path} to be a number, got {value!r}. "
                "Write a number; an exponent needs its sign, as in 7.15e+9."
            )
        return float(value) if isinstance(default, float) else value
    if isinstance(default, str) and not isinstance(value, str):
        raise ValueError(f"Expected {path} to be text, got {value!r}. Put it in quotes.")
    return value
