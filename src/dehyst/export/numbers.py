"""Numbers of a block or a joint controller as the core's structures hold them, in double or float, and as C text."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, ClassVar, TypeAlias, TypeVar, cast

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.export.signal import Whole, moving_input
from dehyst.models import SignalCard

Floats = tuple[float, ...]
Tables: TypeAlias = Iterable[tuple[str, Floats]]
Map = tuple[Floats, Floats]

INPUT_LIMIT = {"double": 1e100, "float": 1e15}  # DEHYST_INPUT_LIMIT of core/dehyst.h
FLOAT_LIMIT = float(np.float32(INPUT_LIMIT["float"]))
TOLERANCE = 1e-5  # of the output's range, in float
LIMITS = ("input", "output", "reach")
T = TypeVar("T")


@dataclass(frozen=True)
class Constant:
    """A constant that a target shows to people."""

    name: str
    about: str
    unit: str
    values: Floats
    array: bool = True


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

    @property
    def rising(self) -> Tables:
        """Tables of which neighbours differ."""
        yield "thresholds", self.threshold
        for place, points in (("before", self.before), ("after", self.after)):
            for what, values in zip(("breakpoints", "values"), points or (), strict=False):
                yield f"{what} of the map {place} the hysteresis", values

    def constants(self, unit: str) -> Iterator[Constant]:
        """Return its numbers by name; `unit` is that of its argument."""
        yield Constant("threshold", "thresholds of the play operators", unit, self.threshold)
        yield Constant("slope", "running sums of their weights", "", self.slope)
        yield Constant("loading", "loading curve at the thresholds", "", self.loading)
        yield Constant("start", "play states after a reset", unit, self.start)
        yield Constant("center", "subtracted from the input", unit, (self.center,), False)
        yield Constant("offset", "added to the output", "", (self.offset,), False)
        for place, points in (("before", self.before), ("after", self.after)):
            for axis, values in zip(("from", "to"), points or (), strict=False):
                yield Constant(f"{place}_{axis}", f"map {place} the hysteresis, breakpoints: {axis}", "", values)


def read(member: str, name: str) -> Any:
    """Return a property that reads a number of a member, by its key or as its attribute."""

    def value(self: Any) -> float:
        held = getattr(self, member)
        return float(held[name] if isinstance(held, Mapping) else getattr(held, name))

    return property(value, doc=f"`{name}` of its {member}.")


@dataclass(frozen=True)
class OffsetUnit:
    """``dehyst_offset``, fields named as there, and whether it is added behind a forward block."""

    limit: float
    turn: float
    part: float
    fingerprint: int
    forward: bool
    functions = (
        "dehyst_offset_reset", "dehyst_offset_next", "dehyst_offset_step", "dehyst_offset_save",
        "dehyst_offset_restore",
    )  # fmt: skip

    def bytes(self, size: int) -> tuple[int, int, int]:
        """Return bytes of constants, state and image on a 32-bit target, by the size of a real."""
        return {4: 16, 8: 32}[size], 6 * size + 16, 4 * (7 + 6 * size // 4)


class UnitNumbers(ABC):
    """What a unit says to the templates of its targets, whatever block of the core it holds.

    Attributes
    ----------
    core
        Its structure and functions are called ``dehyst_<core>``.
    functions
        Of the core, that the unit calls.
    tables
        Template with the macros ``arrays`` and ``structure`` of its constants.
    leading, given
        C names of the inputs of a step; behind the first ones those that the core takes as an array.
    takes_given
        Whether it does.
    memory
        (member of the core's state, name, size) of each array that the unit owns; a size is one of `sizes`.
    sizes
        (name, C expression, comment) of the unit's constants.
    saved
        Whether its state has an image.
    parts, kind
        How many of what it has, for people.
    what
        It is exported as, "" for what was asked for.
    tolerance
        Largest error in float. [output]
    offset
        That follows the last cycle, or None.
    """

    core: ClassVar[str] = "block"
    functions: ClassVar[tuple[str, ...]] = ()
    tables: ClassVar[str] = "c/block_tables.j2"
    leading: ClassVar[tuple[str, ...]] = ("x",)
    takes_given: ClassVar[bool] = False
    saved: ClassVar[bool] = True
    kind: ClassVar[str] = "operators"
    what: ClassVar[str] = ""
    given: tuple[str, ...] = ()
    tolerance: float = 0.0
    offset: OffsetUnit | None = None
    fade: float
    input_low: float
    input_high: float
    output_low: float
    output_high: float
    line_slope: float
    line_offset: float

    @property
    def inputs(self) -> tuple[str, ...]:
        """C names of all inputs of a step."""
        return (*self.leading, *self.given, *(("measured",) if self.offset else ()))

    @property
    def least(self) -> float:
        """No answer lies below. [output]"""
        return self._within(self.output_low, -1.0)

    @property
    def most(self) -> float:
        """No answer lies above. [output]"""
        return self._within(self.output_high, 1.0)

    def _within(self, end: float, side: float) -> float:
        return end + side * self.offset.limit if self.offset and self.offset.forward else end

    @property
    def allowed(self) -> float:
        """Largest error of an answer in float, the offset's part included. [output]"""
        if not self.offset:
            return self.tolerance
        if self.offset.forward:
            return 3.0 * self.tolerance + TOLERANCE * self.offset.limit
        own = TOLERANCE * (self.input_high - self.input_low)
        return self.tolerance + 10.0 * abs(self.line_slope) * own

    @property
    def rising(self) -> Tables:
        """Tables and ranges of which neighbours differ."""
        yield "ends of the input", (self.input_low, self.input_high)
        yield "ends of the output", (self.output_low, self.output_high)

    def signal(self, others: Sequence[SignalCard], ramp: int, real: str) -> tuple[Array, Whole]:
        """Return the test signal, inputs (T, m) and on/off (T,); `others` are the inputs behind the first."""
        ranges = [None if card.low is None or card.high is None else (card.low, card.high) for card in others]
        return moving_input(self.input_low, self.input_high, ranges, ramp, real)

    def avr_ram(self, fixed: int) -> int:
        """Return bytes of RAM on AVR, where constants are copied there; `fixed` of plays beside their operators."""
        constants, state, _ = self.bytes(4)
        return constants + state

    @property
    def direct_inverse(self) -> DirectNumbers | None:
        """The direct inverse, if it is one."""
        return None

    @property
    def map_points(self) -> tuple[int, ...]:
        """Breakpoints of the maps in front of its memory and behind it."""
        return ()

    @property
    @abstractmethod
    def memory(self) -> tuple[tuple[str, str, str], ...]:
        """Arrays of the state."""

    @property
    @abstractmethod
    def sizes(self) -> tuple[tuple[str, str, str], ...]:
        """Constants of the header."""

    @property
    @abstractmethod
    def parts(self) -> int:
        """How many operators, or what it has in their place."""

    @abstractmethod
    def bytes(self, size: int) -> tuple[int, int, int]:
        """Return bytes of constants, state and image on a 32-bit target, by the size of a real."""

    def constants(self, unit: str) -> Iterable[Constant]:
        """Return the numbers of its model by name; `unit` is that of the input."""
        return ()


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
    def rising(self) -> Tables:
        """Tables of which neighbours differ."""
        yield "radii", (0.0, *self.radius)
        yield "path lengths", (0.0, *self.length)
        yield from (("ends of a schedule", pair) for pair in zip(self.low, self.high, strict=True))
        yield "ends of the input", (self.input_low, self.input_high)
        yield "ends of the output", (self.output_low, self.output_high)

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

    def bytes(self, size: int) -> int:
        """Return bytes of its constants on a 32-bit target, by the size of a real."""
        tables = len(self.radius) + len(self.length) + len(self.gain) + len(self.weight)
        return size * (tables + 11) + 4 * len(self.group) + {4: 60, 8: 64}[size]


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
        made = replace(value, **{entry.name: in_real(getattr(value, entry.name), real) for entry in fields(value)})
    return cast(T, made)


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


def direct_numbers(parameters: tuple[Any, ...]) -> DirectNumbers:
    """Return the numbers of a direct inverse from what the core takes: ``DirectInverse.parameters(period)``."""
    *tables, numbers, coefficients, groups, known = parameters
    radius, length, gain, weight, group, source, low, high = (tuple(table.tolist()) for table in tables)
    return DirectNumbers(
        int(coefficients), int(groups), bool(known), radius, length, gain, weight, group, source, low, high,
        *map(float, numbers),
    )  # fmt: skip


def direct_in(numbers: DirectNumbers, real: str) -> DirectNumbers:
    """Return the direct inverse in that precision; ranges do not grow."""
    input_low, input_high = inward(numbers.input_low, numbers.input_high, real)
    output_low, output_high = inward(numbers.output_low, numbers.output_high, real)
    return replace(
        in_real(numbers, real), input_low=input_low, input_high=input_high, output_low=output_low,
        output_high=output_high,
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
