"""Numbers with units, short names, lists and tables as text for pages."""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Mapping, Sequence
from typing import Any

from dehyst.shell import visible_lines

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
ELLIPSIS = "…"
NARROW_SPACE = "\u202f"
YES_NO = ("no", "yes")  # by whether it is so
# Values of a list that are shown; a longer one is cut, and its length told.
MOST_VALUES = 12


def short(text: object, length: int = 42) -> str:
    """Return text on one line, its middle left out if it is longer than `length`.

    Examples
    --------
    >>> short("a_very_long_column_name [bar]", 16)
    'a_very_…e [bar]'
    """
    line = " ".join(visible_lines(text).split())
    if width(line) <= length:
        return line
    head, tail = "", ""
    while width(head) + width(tail) < length - 2:
        if width(head) < width(tail):
            head += line[len(head)]
        else:
            tail = line[len(line) - len(tail) - 1] + tail
    return head + ELLIPSIS + tail


def width(text: str) -> int:
    """Return how many letters wide a text is; Chinese, Japanese and Korean letters count twice.

    Examples
    --------
    >>> width("bar"), width("圧力")
    (3, 4)
    """
    letters = 0
    for character in text:
        # Wide and full-width letters of East Asia take two places.
        letters += 2 if unicodedata.east_asian_width(character) in "WF" else 1
    return letters


def number(value: float | None, digits: int = 3) -> str:
    """Return a number with `digits` significant digits, a real minus and powers of ten.

    Examples
    --------
    >>> number(0.123456), number(-1234.5), number(3.2e-16), number(None)
    ('0.123', '−1230', '3.2 × 10⁻¹⁶', '–')
    """
    if value is None:
        return "–"
    value = float(value)
    if math.isnan(value):
        return "not a number"
    if math.isinf(value):
        if value < 0.0:
            return "−∞"
        return "∞"
    if value == 0.0:
        return "0"
    # The exponent of the rounded number: 9.996 is 10.0.
    exponent = int(f"{value:.{digits - 1}e}".partition("e")[2])
    if -4 <= exponent <= 6:
        decimals = digits - 1 - exponent
        # Four digits are read at a glance; more of them need groups.
        separator = ""
        if exponent >= 4:
            separator = NARROW_SPACE
        text = f"{round(value, decimals):,.{max(0, decimals)}f}"
        return text.replace(",", separator).replace("-", "−")
    mantissa = f"{value / 10.0**exponent:.{digits - 1}f}".rstrip("0").rstrip(".")
    return f"{mantissa} × {power_of_ten(exponent)}".replace("-", "−")


def power_of_ten(exponent: int) -> str:
    """Return a power of ten.

    Examples
    --------
    >>> power_of_ten(-4)
    '10⁻⁴'
    """
    return f"10{str(exponent).translate(_SUPERSCRIPT)}"


def with_unit(value: float | None, unit: str, digits: int = 3) -> str:
    """Return a number and its unit, separated by a space that does not break.

    Examples
    --------
    >>> with_unit(1.5, "bar").replace("\\xa0", " "), with_unit(2.0, "")
    ('1.50 bar', '2.00')
    """
    text = number(value, digits)
    if unit and value is not None:
        text += f"\u00a0{unit}"
    return text


def bracketed(unit: str) -> str:
    """Return a unit as it follows a name, " [bar]", or ""."""
    if not unit:
        return ""
    return f" [{unit}]"


def plain(value: Any) -> str:
    """Return a setting or provenance value in words.

    Examples
    --------
    >>> plain(True), plain(None), plain([1, 2.5]), plain({"n": 3})
    ('yes', '–', '1, 2.5', 'n: 3')
    """
    if value is None:
        return "–"
    if isinstance(value, bool):
        return YES_NO[value]
    if isinstance(value, float):
        return f"{value:.6g}".replace("-", "−")
    if isinstance(value, dict):
        return ", ".join(f"{key}: {plain(item)}" for key, item in value.items())
    if isinstance(value, (list, tuple)):
        shown = ", ".join(map(plain, value[:MOST_VALUES]))
        if len(value) > MOST_VALUES:
            return f"{shown}, {ELLIPSIS} ({len(value)} values)"
        return shown or "none"
    return str(value)


def flattened(table: Mapping[Any, Any], joint: str = ".", before: str = "") -> dict[str, Any]:
    """Return nested tables with joined names.

    Examples
    --------
    >>> flattened({"joint": {"1": {"radius_m": 0.05}}, "name": "arm"})
    {'joint.1.radius_m': 0.05, 'name': 'arm'}
    """
    content: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping):
            content |= flattened(value, joint, f"{before}{key}{joint}")
        else:
            content[f"{before}{key}"] = value
    return content


def listed(names: Sequence[object]) -> str:
    """Return names as they are listed in a sentence.

    Examples
    --------
    >>> listed([1]), listed([1, 2]), listed([1, 2, 4])
    ('1', '1 and 2', '1, 2 and 4')
    """
    *before, last = map(str, names)
    if not before:
        return last
    return f"{', '.join(before)} and {last}"


def between(low: float, high: float) -> str:
    """Return an interval, or the number that both ends are printed as.

    Examples
    --------
    >>> between(26.0, 33.4), between(-1.0, 2.0), between(3.0, 3.0)
    ('26.0–33.4', '−1.00 to 2.00', '3.00')
    """
    first, last = number(low), number(high)
    if first == last:
        return first
    # Before a minus a dash would be read as another one.
    dash = " to "
    if low >= 0.0:
        dash = "–"
    return f"{first}{dash}{last}"


def count(n: int, noun: str) -> str:
    """Return a number of things.

    Examples
    --------
    >>> count(1, "loop"), count(3, "loop")
    ('1 loop', '3 loops')
    """
    if n == 1:
        return f"1 {noun}"
    return f"{n} {noun}s"
