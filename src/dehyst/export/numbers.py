"""Numbers of a block or a joint controller as the core's structures hold them, in double or float, and as C text."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from dehyst.control.reach import EPS_FLOAT, Operator

Floats = tuple[float, ...]
Map = tuple[Floats, Floats]

INPUT_LIMIT = {"double": 1e100, "float": 1e15}  # DEHYST_INPUT_LIMIT of core/dehyst.h
FLOAT_LIMIT = float(np.float32(INPUT_LIMIT["float"]))
_LIMITS = ("input", "output", "reach")


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


TOLERANCE = 1e-5  # of the output's range, in float


@dataclass(frozen=True)
class BlockNumbers(UnitNumbers):
    """``dehyst_block``, fields named as there."""

    functions = ("dehyst_block_reset", "dehyst_block_step", "dehyst_block_save", "dehyst_block_restore")
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
    offset: OffsetUnit | None = None

    @property
    def tolerance(self) -> float:  # type: ignore[override]
        """1e-5 of the range."""
        return TOLERANCE * (self.output_high - self.output_low)

    @property
    def map_points(self) -> tuple[int, ...]:
        """Breakpoints of the maps."""
        return self.model.points

    @property
    def memory(self) -> tuple[tuple[str, str, str], ...]:
        """Play states."""
        return (("model.z", "z", "OPERATORS"),)

    @property
    def sizes(self) -> tuple[tuple[str, str, str], ...]:
        """Operators, words of an image."""
        n = self.parts
        return ("OPERATORS", f"{n}", ""), ("IMAGE_WORDS", f"DEHYST_STATE_WORDS({n})", "of a saved state")

    @property
    def parts(self) -> int:
        """Play operators."""
        return self.model.operators

    def bytes(self, size: int) -> tuple[int, int, int]:
        """Return bytes of constants, state and image on a 32-bit target, by the size of a real."""
        n, points = self.parts, sum(self.model.points)
        rest = {4: 48, 8: 64}[size]
        state = size * (n + 3) + 4 * 4 + (8 if size == 8 else 0)
        return size * (4 * n + 2 * points + 11) + rest, state, 4 * (6 + size // 4 * (n + 3))

    def avr_ram(self, fixed: int) -> int:
        """Return bytes of RAM on AVR, where constants are copied there."""
        return 20 * self.parts + 8 * sum(self.map_points) + fixed

    def constants(self, unit: str) -> Iterable[Constant]:
        """Return those of the model."""
        return self.model.constants("" if self.model.before else unit)

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

    def bytes(self, size: int) -> int:
        """Return bytes of its constants on a 32-bit target, by the size of a real."""
        tables = len(self.radius) + len(self.length) + len(self.gain) + len(self.weight)
        return size * (tables + 11) + 4 * len(self.group) + {4: 60, 8: 64}[size]


@dataclass(frozen=True)
class DirectBlockNumbers(UnitNumbers):
    """``dehyst_direct_block``, fields named as there; `given` are C names of its scheduling variables from outside."""

    core = "direct_block"
    functions = ("dehyst_direct_block_reset", "dehyst_direct_block_step")
    tables = "c/direct_tables.j2"
    leading = ("y", "rate")
    takes_given = True
    saved = False
    kind = "stops and lags"
    direct: DirectNumbers
    line_slope: float
    line_offset: float
    fade: float
    given: tuple[str, ...] = ()
    tolerance: float = 0.0
    offset: OffsetUnit | None = None

    input_low, input_high = read("direct", "input_low"), read("direct", "input_high")
    output_low, output_high = read("direct", "output_low"), read("direct", "output_high")

    @property
    def direct_inverse(self) -> DirectNumbers | None:
        """It is one."""
        return self.direct

    @property
    def memory(self) -> tuple[tuple[str, str, str], ...]:
        """All that it remembers."""
        return (("direct.memory", "memory", "REALS"),)

    @property
    def sizes(self) -> tuple[tuple[str, str, str], ...]:
        """Its terms, and numbers that it remembers."""
        d = self.direct
        counts = (("STOPS", d.radius), ("PATHS", d.length), ("CREEPS", d.gain))
        reals = ("REALS", f"{max(1, d.memory)}", "numbers that it remembers")
        return (*((name, f"{len(values)}", "") for name, values in counts), reals)

    @property
    def parts(self) -> int:
        """Stops and lags."""
        return self.direct.memory // 2

    def bytes(self, size: int) -> tuple[int, int, int]:
        """Return bytes of constants, state and image on a 32-bit target, by the size of a real."""
        return size * 3 + self.direct.bytes(size), size * (max(1, self.direct.memory) + 20) + {4: 16, 8: 24}[size], 0


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
    single: dict[str, Any] = {
        name: rounded(getattr(numbers, name), real) for name in ("line_slope", "line_offset", "fade")
    }
    pairs = {name: (getattr(numbers, f"{name}_low"), getattr(numbers, f"{name}_high")) for name in _LIMITS}
    limits = {name: inward(*pair, real) for name, pair in pairs.items()}
    if not numbers.holds_back:
        # What a model reaches is no limit of a machine: the answers in float must not be cut off by their rounding.
        limits["output"] = outward(*_reached_in_float(numbers), real)
        limits["reach"] = (-FLOAT_LIMIT, FLOAT_LIMIT)
    ends: dict[str, Any] = {
        f"{name}_{end}": pair[k] for name, pair in limits.items() for k, end in enumerate(("low", "high"))
    }
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
