"""Arithmetic of the types: LREAL is IEEE double, REAL single, integers have a range and leave it with an error."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterator

from dehyst.errors import DehystError
from dehyst.export.iec.tree import INTEGERS, Literal

MOST_ROUNDS = 1_000_000


class RunError(DehystError):
    """The text did something that a PLC stops at: an index outside its array, an integer outside its range, no end."""


def single(value: float) -> float:
    """Round a double to single precision: after one operation on singles that is the single result.

    A double has more than twice the digits of a single and two, so that rounding twice rounds as once.
    """
    return ctypes.c_float(value).value


def divide(a: float, b: float) -> float:
    """Divide as IEEE says, by zero too."""
    if b != 0.0:
        return a / b
    if a == 0.0 or math.isnan(a) or math.isnan(b):
        return math.nan
    return math.copysign(math.inf, a) * math.copysign(1.0, b)


def whole(value: int, type_: str, line: int) -> int:
    """Return an integer result, or stop if it is beyond its type."""
    low, high = INTEGERS[type_]
    if not low <= value <= high:
        raise RunError(f"line {line}: {value} is beyond {type_}", line=line)
    return value


def whole_divide(a: int, b: int, line: int) -> int:
    """Divide integers towards zero."""
    if b == 0:
        raise RunError(f"line {line}: integer division by zero", line=line)
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


def place(index: int, low: int, high: int, line: int) -> int:
    """Return the place of an element, or stop if the index is outside the array."""
    if not low <= index <= high:
        raise RunError(f"line {line}: index {index} is outside {low}..{high}", line=line)
    return index - low


class Budget:
    """Rounds of loops that are left in a call, all loops and blocks together: a text that does not end is stopped."""

    def __init__(self) -> None:
        self.left = MOST_ROUNDS

    def refill(self) -> None:
        """Begin a call."""
        self.left = MOST_ROUNDS

    def count(self, values: range, line: int) -> range:
        """Return the values of a FOR, or stop if they are too many."""
        self.left -= max(0, (values.stop - values.start) * values.step)
        if self.left < 0:
            raise RunError(f"line {line}: more than {MOST_ROUNDS} rounds of loops in a call, and no end", line=line)
        return values

    def rounds(self, line: int) -> Iterator[None]:
        """Count the rounds of a WHILE and stop one that does not end."""
        while True:
            self.count(range(1), line)
            yield None


def value_of(literal: Literal, type_: str) -> float | int | bool:
    """Return the value of a constant: the nearest number of its type.

    A constant of type REAL is read as double first; with at most nine digits both roundings agree.
    """
    if type_ == "BOOL":
        return literal.text == "TRUE"
    if type_ in INTEGERS:
        return int(literal.text)
    value = float(literal.text)
    return value if type_ == "LREAL" else single(value)
