"""Numbers of a block or a joint controller as the core's structures hold them, in double or float, and as C text."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.control.reach import EPS_FLOAT, Operator

Floats = tuple[float, ...]
Map = tuple[Floats, Floats]

INPUT_LIMIT = {"double": 1e100, "float": 1e15}  # DEHYST_INPUT_LIMIT of core/dehyst.h
FLOAT_LIMIT = float(np.float32(INPUT_LIMIT["float"]))
_LIMITS = ("input", "output", "reach")


@dataclass(frozen=True)
class ModelNumbers:
    """``dehyst_model`` with its start states.

    Attributes
    ----------
    threshold, slope, loading, start
        r_i, S_i, phi_i and play states, (n,).
    center, offset
        Subtracted from the input, added to the output.
    before, after
        Breakpoints (u, v) of the maps, or None.
    """

    threshold: Floats
    slope: Floats
    loading: Floats
    start: Floats
    center: float
    offset: float
    before: Map | None = None
    after: Map | None = None

    @property
    def operators(self) -> int:
        """Return n."""
        return len(self.threshold)

    @property
    def points(self) -> tuple[int, int]:
        """Breakpoints of the maps before and after."""
        return (len(self.before[0]) if self.before else 0, len(self.after[0]) if self.after else 0)


@dataclass(frozen=True)
class BlockNumbers:
    """``dehyst_block``, fields named as there."""

    model: ModelNumbers
    input_low: float
    input_high: float
    output_low: float
    output_high: float
    reach_low: float
    reach_high: float
    line_slope: float
    line_offset: float
    fade: float
    fingerprint: int

    @property
    def holds_back(self) -> bool:
        """Whether there is an output in front of the last map at which the input is held back: not so forward."""
        return self.reach_high < FLOAT_LIMIT


@dataclass(frozen=True)
class DirectNumbers:
    """``dehyst_direct``, fields named as there.

    Attributes
    ----------
    coefficients
        Of each polynomial.
    groups
        Number of groups of terms.
    known
        Whether nothing is remembered at a reset.
    radius, length, gain
        r of the stops, x of the path lags, 1 - exp(-T/tau) of the creep lags.
    weight
        (sets, terms) in rows: polynomial, stops, paths, creeps, rate.
    group
        Of each term behind the polynomial.
    source, low, high
        Of the schedules.
    center
        Subtracted from y in front of the polynomial.
    input_low, input_high, output_low, output_high
        Ranges.
    """

    coefficients: int
    groups: int
    known: bool
    radius: Floats
    length: Floats
    gain: Floats
    weight: Floats
    group: tuple[int, ...]
    source: tuple[int, ...]
    low: Floats
    high: Floats
    center: float
    input_low: float
    input_high: float
    output_low: float
    output_high: float

    @property
    def sets(self) -> int:
        """Number of sets of weights."""
        return max(1, 2 * len(self.source))

    @property
    def terms(self) -> int:
        """Weights of a set."""
        return self.coefficients + self.lags

    @property
    def lags(self) -> int:
        """Terms behind the polynomial: stops, paths, creeps and rate."""
        return len(self.radius) + len(self.length) + len(self.gain) + 1

    @property
    def memory(self) -> int:
        """Reals that a state remembers."""
        return 2 * (self.lags - 1)


@dataclass(frozen=True)
class DirectBlockNumbers:
    """``dehyst_direct_block``, fields named as there; `given` are C names of its scheduling variables from outside."""

    direct: DirectNumbers
    line_slope: float
    line_offset: float
    fade: float
    given: tuple[str, ...] = ()


@dataclass(frozen=True)
class JointNumbers:
    """``dehyst_joint``: its numbers by the names of the core's fields, and the tables of its compensator.

    Attributes
    ----------
    values
        Of the parameters.
    compensator
        Model of the angle -> pressure difference, or None.
    fingerprint
        Of all of it: images of another one are refused.
    direct
        Direct inverse, angle -> torque, or None.
    adaptation
        How it learns, by the names of `Adaptation`; without a direct inverse nobody reads it.
    """

    values: Mapping[str, Any]
    compensator: ModelNumbers | None
    fingerprint: int
    direct: DirectNumbers | None
    adaptation: Mapping[str, float]


def rounded(value: float, real: str) -> float:
    """Return the nearest number of the precision, as a double."""
    if real == "double":
        return float(value)
    with np.errstate(over="ignore"):  # infinity is refused where all of a unit is looked at
        return float(np.float32(value))


def inward(low: float, high: float, real: str) -> tuple[float, float]:
    """Return a range of numbers of the precision within low .. high: rounding never exceeds a limit."""
    below, above = rounded(low, real), rounded(high, real)
    if below < low:
        below = float(np.nextafter(np.float32(below), np.float32(math.inf)))
    if above > high:
        above = float(np.nextafter(np.float32(above), np.float32(-math.inf)))
    return below, above


def outward(low: float, high: float, real: str) -> tuple[float, float]:
    """Return a range of numbers of the precision that holds low .. high."""
    below, above = rounded(low, real), rounded(high, real)
    if below > low:
        below = float(np.nextafter(np.float32(below), np.float32(-math.inf)))
    if above < high:
        above = float(np.nextafter(np.float32(above), np.float32(math.inf)))
    return below, above


def block_in(numbers: BlockNumbers, real: str) -> BlockNumbers:
    """Return the block in that precision; its values stay doubles."""
    if real == "double":
        return numbers
    single = {name: rounded(getattr(numbers, name), real) for name in ("line_slope", "line_offset", "fade")}
    pairs = {name: (getattr(numbers, f"{name}_low"), getattr(numbers, f"{name}_high")) for name in _LIMITS}
    limits = {name: inward(*pair, real) for name, pair in pairs.items()}
    if not numbers.holds_back:
        # What a model reaches is no limit of a machine: the answers in float must not be cut off by their rounding.
        limits["output"] = outward(*_reached_in_float(numbers), real)
        limits["reach"] = (-FLOAT_LIMIT, FLOAT_LIMIT)
    ends = {f"{name}_{end}": pair[k] for name, pair in limits.items() for k, end in enumerate(("low", "high"))}
    return BlockNumbers(model_in(numbers.model, real), **ends, **single, fingerprint=numbers.fingerprint)


def _reached_in_float(numbers: BlockNumbers) -> tuple[float, float]:
    """Range of the output with the rounding of floats."""
    m = numbers.model
    nothing: Map = ((), ())
    (u, v), (p, q) = ([np.array(values) for values in points or nothing] for points in (m.before, m.after))
    weights = np.diff(np.array(m.slope), prepend=0.0)
    operator = Operator(np.array(m.threshold), weights, m.center, m.offset, u, v, p, q, np.array(m.start))
    bottom, top = operator.in_front_of_after(numbers.output_low, numbers.output_high)
    return operator.widened(numbers.input_low, numbers.input_high, bottom, top, EPS_FLOAT)


def model_in(numbers: ModelNumbers, real: str) -> ModelNumbers:
    """Return the model in that precision; its values stay doubles."""
    if real == "double":
        return numbers

    def table(values: Iterable[float]) -> Floats:
        return tuple(rounded(value, real) for value in values)

    def pair(points: Map | None) -> Map | None:
        return (table(points[0]), table(points[1])) if points else None

    return ModelNumbers(
        table(numbers.threshold),
        table(numbers.slope),
        table(numbers.loading),
        table(numbers.start),
        rounded(numbers.center, real),
        rounded(numbers.offset, real),
        pair(numbers.before),
        pair(numbers.after),
    )


def direct_numbers(parameters: tuple[Any, ...]) -> DirectNumbers:
    """Return the numbers of a direct inverse from what the core takes: ``DirectInverse.parameters(period)``."""
    *tables, numbers, coefficients, groups, known = parameters
    radius, length, gain, weight, group, source, low, high = (tuple(table.tolist()) for table in tables)
    return DirectNumbers(
        int(coefficients), int(groups), bool(known), radius, length, gain, weight, group, source, low, high,
        *map(float, numbers),
    )  # fmt: skip


def direct_in(numbers: DirectNumbers, real: str) -> DirectNumbers:
    """Return the direct inverse in that precision; its values stay doubles, and ranges do not grow."""
    if real == "double":
        return numbers
    tables: dict[str, Any] = {
        name: tuple(rounded(value, real) for value in getattr(numbers, name))
        for name in ("radius", "length", "gain", "weight", "low", "high")
    }
    input_low, input_high = inward(numbers.input_low, numbers.input_high, real)
    output_low, output_high = inward(numbers.output_low, numbers.output_high, real)
    return replace(
        numbers, **tables, center=rounded(numbers.center, real), input_low=input_low, input_high=input_high,
        output_low=output_low, output_high=output_high,
    )  # fmt: skip


def literal(value: float, real: str) -> str:
    """Return the C constant of a number, to the bit.

    Examples
    --------
    >>> literal(3.0, "double"), literal(0.1, "float"), literal(-0.0, "double")
    ('0x1.8p+1', '0x1.99999ap-4f', '-0x0p+0')
    """
    digits, _, exponent = rounded(value, real).hex().partition("p")
    digits = digits.rstrip("0").rstrip(".") if "." in digits else digits
    return f"{digits}p{exponent}{'f' if real == 'float' else ''}"


def table(values: Sequence[float] | npt.NDArray[np.float64], real: str, columns: int = 4) -> str:
    """Return rows of C constants, for the braces of an array."""
    words = [literal(float(value), real) for value in values]
    rows = [words[k : k + columns] for k in range(0, len(words), columns)]
    return ",\n".join("    " + ", ".join(row) for row in rows)


def bits(value: float) -> str:
    """Return the pattern of a double as a C constant."""
    return f"0x{int(np.float64(value).view(np.uint64)):016x}u"


def pattern(value: float, real: str) -> str:
    """Return the pattern of a number in its own precision as a C constant."""
    if real == "double":
        return bits(value)
    with np.errstate(over="ignore"):
        return f"0x{int(np.float32(value).view(np.uint32)):08x}u"
