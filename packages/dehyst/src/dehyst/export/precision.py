"""Double or float: rounding, constants in C, and which units can be exported in float."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any, Protocol, TypeAlias, TypeVar, cast

import numpy as np
import numpy.typing as npt

from dehyst.errors import ParameterError

Floats = tuple[float, ...]
Tables: TypeAlias = Iterable[tuple[str, Floats]]

BYTES = {"double": 8, "float": 4}
INPUT_LIMIT = {
    "double": 1e100,
    "float": 1e15,
}  # DEHYST_INPUT_LIMIT of packages/dehyst/core/dehyst.h
FLOAT_LIMIT = float(np.float32(INPUT_LIMIT["float"]))
SMALLEST = float(
    np.finfo(np.float32).tiny
)  # below it floats lose their digits, and some machines take them as 0
FADE = float(np.float32(1e-6))  # the share of a switching that still adds up in float
KEPT = {"slope", "gain", "half_range", "parameter"}  # that must not vanish
_CURE = (
    "Scale the signals to a unit of their size and identify again, or export with --real double."
)
T = TypeVar("T")


def rounded(value: float, real: str) -> float:
    """Return the nearest number of the precision, as a double."""
    if real == "double":
        return float(value)
    with np.errstate(over="ignore"):  # infinity is refused where all of a unit is looked at
        return float(np.float32(value))


def in_real(value: T, real: str) -> T:
    """Return a record, table or number with every real number in the precision; its values stay doubles."""
    if real == "double":
        return value
    made: Any = value
    if isinstance(value, tuple):
        made = tuple(in_real(part, real) for part in value)
    elif isinstance(value, Mapping):
        made = {name: in_real(part, real) for name, part in value.items()}
    elif isinstance(value, float):
        made = rounded(value, real)
    elif is_dataclass(value) and not isinstance(value, type):
        parts = {}
        for entry in fields(value):
            parts[entry.name] = in_real(getattr(value, entry.name), real)
        made = replace(value, **parts)
    return cast(T, made)


def inward(low: float, high: float, real: str) -> tuple[float, float]:
    """Return a range of numbers of the precision within low .. high: rounding never exceeds a limit."""
    below, above = rounded(low, real), rounded(high, real)
    if below < low:
        below = _next(below, math.inf)
    if above > high:
        above = _next(above, -math.inf)
    return below, above


def outward(low: float, high: float, real: str) -> tuple[float, float]:
    """Return a range of numbers of the precision that holds low .. high."""
    below, above = rounded(low, real), rounded(high, real)
    if below > low:
        below = _next(below, -math.inf)
    if above < high:
        above = _next(above, math.inf)
    return below, above


def _next(value: float, towards: float) -> float:
    return float(np.nextafter(np.float32(value), np.float32(towards)))


# Constants in C


def literal(value: float, real: str) -> str:
    """Return the C constant of a number, to the bit.

    Examples
    --------
    >>> literal(3.0, "double"), literal(0.1, "float"), literal(-0.0, "double")
    ('0x1.8p+1', '0x1.99999ap-4f', '-0x0p+0')
    """
    digits, _, exponent = rounded(value, real).hex().partition("p")
    # Zeros behind the last digit say nothing, and tables are long.
    if "." in digits:
        digits = digits.rstrip("0").rstrip(".")
    if real == "float":
        exponent += "f"
    return f"{digits}p{exponent}"


def decimal(value: float, real: str) -> str:
    """Return the shortest decimal constant of a number, to the bit: for languages without hexadecimal ones.

    Examples
    --------
    >>> decimal(3.0, "double"), decimal(0.1, "float"), decimal(1e-300, "double")
    ('3.0', '0.1', '1.0e-300')
    """
    word = repr(float(value))
    if real == "float":
        word = str(np.float32(value))
    # Ada has no real constant without a point.
    if "." not in word:
        word = word.replace("e", ".0e")
    return word


def precision_table(
    values: Sequence[float] | npt.NDArray[np.float64], real: str, columns: int = 4
) -> str:
    """Return rows of C constants, for the braces of an array."""
    words = [literal(float(value), real) for value in values]
    rows = []
    for k in range(0, len(words), columns):
        rows.append("    " + ", ".join(words[k : k + columns]))
    return ",\n".join(rows)


def pattern(value: float, real: str = "double") -> str:
    """Return the pattern of bits of a number in its precision as a C constant."""
    with np.errstate(over="ignore"):
        word = (
            np.float64(value).view(np.uint64)
            if real == "double"
            else np.float32(value).view(np.uint32)
        )
    return f"0x{int(word):0{2 * BYTES[real]}x}u"


# What float can hold: numbers that were good doubles are looked at again as they are exported


class Rising(Protocol):
    """A record of numbers, some of them in tables of which neighbours differ."""

    @property
    def rising(self) -> Tables:
        """Name and numbers of each such table."""
        ...


def check_fade(fade: float, ramp: int) -> None:
    """Refuse a switching whose share a sample does not add up in float."""
    if fade < FADE:
        raise ParameterError(
            f"--ramp {ramp} is too long for --real float: a millionth of a switching is the smallest share that still "
            f"adds up in single precision. Pass --ramp 1000000 or less, or --real double.",
            ramp=ramp,
        )


def check_float(exact: Rising, single: Rising) -> None:
    """Refuse numbers that float cannot hold, or of which it cannot tell neighbours apart."""
    _check_leaves(exact, single)
    for (name, doubles), (_, values) in zip(exact.rising, single.rising, strict=True):
        # A table may fall as well, but no two neighbours may become equal.
        step = np.diff(values)
        if not (np.all(step > 0) or np.all(step < 0)):
            k = int(np.argmin(np.abs(step)))
            raise ParameterError(
                f"this unit cannot be exported with --real float: two of its {name} become the same number in single "
                f"precision, number {k + 1} ({doubles[k]:.9g}) and number {k + 2} ({doubles[k + 1]:.9g}), and nothing "
                f"is left of that range. Identify with fewer operators (--n 50) or with a signal whose mean was taken "
                f"off, widen the range, or export with --real double.",
                first=k,
            )


def check_values(values: Mapping[str, Any]) -> None:
    """Refuse parameters of a joint controller that float cannot hold."""
    exact = {"parameter": values}
    _check_leaves(exact, in_real(exact, "float"))


def _check_leaves(exact: object, single: object) -> None:
    for (name, before), (_, after) in zip(_leaves(exact), _leaves(single), strict=True):
        if (
            not abs(after) <= FLOAT_LIMIT and abs(before) < INPUT_LIMIT["double"]
        ):  # from there on it means: none
            raise ParameterError(
                f"this unit cannot be exported with --real float: its {name} {before:.3g} lies beyond "
                f"{FLOAT_LIMIT:.0e}, the largest number that the core takes in single precision. {_CURE}",
                value=before,
            )
        if before != 0 and abs(after) < SMALLEST and KEPT & set(name.split()):
            raise ParameterError(
                f"this unit cannot be exported with --real float: its {name}, {before:.3g}, is too small for single "
                f"precision and would become zero. {_CURE}",
                value=before,
            )


def _leaves(value: object, path: str = "") -> Iterator[tuple[str, float]]:
    """Real numbers of a record by the names that lead to them."""
    if isinstance(value, float):
        yield path, value
    elif isinstance(value, list | tuple):
        for k, part in enumerate(value):
            yield from _leaves(part, f"{path} {k + 1}")
    elif isinstance(value, Mapping):
        for name, part in value.items():
            yield from _leaves(part, f"{path} {name}".strip())
    elif is_dataclass(value):
        for entry in fields(value):
            yield from _leaves(getattr(value, entry.name), f"{path} {entry.name}".strip())
