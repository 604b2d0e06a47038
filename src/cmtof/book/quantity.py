"""Numbers with their units, written for a reader."""

import math
from decimal import Decimal

_PREFIXES = {9: "G", 6: "M", 3: "k", 0: "", -3: "m", -6: "µ", -9: "n", -12: "p", -15: "f"}
_PREFIXED = {"m", "s", "Hz", "W"}


def quantity_text(value: float, unit: str) -> str:
    """Write a number with four digits and its unit.

    Parameters
    ----------
    value : float
        The number in ``unit``.
    unit : str
        SI symbol; ``fraction`` is written in percent, ``1`` as a plain number.

    Examples
    --------
    >>> quantity_text(0.516, "fraction"), quantity_text(3.35e-5, "m"), quantity_text(14.32e9, "Hz")
    ('51.6 %', '33.5 µm', '14.32 GHz')
    """
    if not math.isfinite(value):
        return "not finite"
    size, label = _scale(value, unit)
    return _digits(value / size) + label


def toleranced_text(value: float, tolerance: float, unit: str, joint: str = " ") -> str:
    """Write a number and its tolerance in one unit; a tolerance of zero is left out.

    Parameters
    ----------
    value, tolerance : float
        Both in ``unit`` and finite.
    unit : str
        As in :func:`quantity_text`.
    joint : str
        What stands between them.

    Examples
    --------
    >>> toleranced_text(1.2e-5, 5e-7, "m")
    '12 µm ± 0.5 µm'
    """
    size, label = _scale(value, unit)
    text = _digits(value / size) + label
    return f"{text}{joint}± {_digits(tolerance / size, 2)}{label}" if tolerance else text


def _scale(value: float, unit: str) -> tuple[float, str]:
    if unit == "fraction":
        return 0.01, " %"
    if unit not in _PREFIXED or value == 0:
        return 1.0, "" if unit == "1" else f" {unit}"
    # read from the decimal form: 999.96 Hz rounds to 1 kHz, and 1e-3 is no less than a milli
    exponent = int(f"{value:.3e}".partition("e")[2])
    power = min(max(3 * (exponent // 3), min(_PREFIXES)), max(_PREFIXES))
    return float(f"1e{power}"), f" {_PREFIXES[power]}{unit}"


def _digits(value: float, count: int = 4) -> str:
    text = f"{value:.{count}g}"
    # without an exponent where a reader would not write one
    return format(Decimal(text), "f") if 1e-6 < abs(value) < 1e7 else text
