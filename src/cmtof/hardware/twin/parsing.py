"""Settings out of plain mappings: strict keys, checked numbers, one pattern of error."""

from collections.abc import Iterable, Mapping
from dataclasses import MISSING, Field, field, fields, is_dataclass
from typing import Any, TypeVar

import numpy as np

Section = TypeVar("Section")


def number(default: float, low: float = -np.inf, high: float = np.inf) -> Any:
    """Field for a number from ``low`` to ``high``, both allowed."""
    return field(default=default, metadata={"low": low, "high": high})


def choice(default: str, options: Iterable[str]) -> Any:
    """Field for one of some words."""
    return field(default=default, metadata={"options": tuple(options)})


def section_from_mapping(kind: type[Section], raw: Mapping[str, Any] | None, path: str) -> Section:
    """Build a dataclass, and those within it, from a mapping with its field names as keys.

    Parameters
    ----------
    kind : type
        A dataclass whose fields all have defaults.
    raw : mapping or None
        What differs from the defaults.
    path : str
        Where the mapping stands, for the messages.

    Raises
    ------
    ValueError
        For unknown keys, values of another type, and numbers out of their limits.
    """
    raw = {} if raw is None else raw
    if not isinstance(raw, Mapping):
        raise ValueError(f"Expected {path} to be a mapping, got {raw!r}. Write key: value lines.")
    known = {entry.name: entry for entry in fields(kind)}  # type: ignore[arg-type]
    for key in raw:
        if key not in known:
            raise ValueError(
                f"Expected keys of {path} out of {', '.join(known)}, got {key!r}. "
                "Correct or remove it."
            )
    values = {key: _value(known[key], raw[key], f"{path}.{key}") for key in raw}
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


def _value(entry: Field, value: Any, path: str) -> Any:
    if entry.default_factory is not MISSING and is_dataclass(entry.default_factory):
        return section_from_mapping(entry.default_factory, value, path)  # type: ignore[arg-type]
    if "options" in entry.metadata:
        return value
    default = entry.default
    if isinstance(default, bool):
        if not isinstance(value, bool):
            raise ValueError(f"Expected {path} to be true or false, got {value!r}. Write one.")
        return value
    if isinstance(default, (int, float)):
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            # YAML 1.1 reads 7.15e9 as text: a sign is missing behind the e
            raise ValueError(
                f"Expected {path} to be a number, got {value!r}. "
                "Write a number; an exponent needs its sign, as in 7.15e+9."
            )
        return type(default)(value) if value == type(default)(value) else value
    return value
