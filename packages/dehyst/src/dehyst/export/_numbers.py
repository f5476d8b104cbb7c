"""Parameters of an exported unit: records with the same fields as the C structures of the core."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from dehyst.export.precision import Floats, Tables, in_real, inward
from dehyst.families import ElementBlockParameters
from dehyst.families import kit as families_kit

Map = tuple[Floats, Floats]
REACH = 1e15  # of an output in front of the last map: from there on there is no limit


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
    def parts(self) -> int:
        """Return n."""
        return len(self.threshold)

    @property
    def way(self) -> str:
        """How a sample is answered: there is one way."""
        return ""

    @property
    def work(self) -> dict[str, int]:
        """How often a step does what: the names of instructions.json."""
        return {"operators": self.parts}

    @property
    def points(self) -> tuple[int, int]:
        """Breakpoints of the maps before and after."""
        nothing: Map = ((), ())
        before, after = self.before or nothing, self.after or nothing
        return (len(before[0]), len(after[0]))

    @property
    def rising(self) -> Tables:
        """Tables of which neighbours differ."""
        yield "thresholds", self.threshold
        for place, points in (("before", self.before), ("after", self.after)):
            for axis, values in zip(("breakpoints", "values"), points or (), strict=False):
                yield f"{axis} of the map {place} the hysteresis", values


def model_numbers(values: Mapping[str, Any]) -> ModelNumbers:
    """Return the numbers of the core's model from a mapping of arrays."""

    def floats(name: str) -> Floats:
        return tuple(float(value) for value in np.asarray(values[name]).ravel())

    before = (floats("before_u"), floats("before_v"))
    after = (floats("after_u"), floats("after_v"))
    return ModelNumbers(
        floats("threshold"), floats("slope"), floats("loading"), floats("start"), float(values["center"]),
        float(values["offset"]), before if before[0] else None, after if after[0] else None,
    )  # fmt: skip


STROKES = (2, 3)  # DEHYST_PAST_RISING and DEHYST_PAST_FALLING


@dataclass(frozen=True)
class DirectNumbers:
    """``dehyst_direct``, fields named as there.

    Attributes
    ----------
    coefficients
        Of each polynomial.
    groups
        Number of groups of terms.
    past
        What the actuator did before a reset: the number of the core's DEHYST_PAST_...
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
    past: int
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
        # The zero in front also refuses a first one that float rounds to zero.
        yield "radii", (0.0, *self.radius)
        yield "path lengths", (0.0, *self.length)
        for pair in zip(self.low, self.high, strict=True):
            yield "ends of a schedule", pair
        yield "ends of the input", (self.input_low, self.input_high)
        yield "ends of the output", (self.output_low, self.output_high)

    @property
    def parts(self) -> int:
        """Stops, path lags and creep lags."""
        return len(self.radius) + len(self.length) + len(self.gain)

    @property
    def sets(self) -> int:
        """Number of sets of weights."""
        return max(1, 2 * len(self.source))

    @property
    def terms(self) -> int:
        """Weights of a set: polynomial, lags and rate."""
        return self.coefficients + self.parts + 1

    @property
    def after(self) -> Map | None:
        """No map stands behind it."""
        return None

    @property
    def way(self) -> str:
        """How a sample is answered: there is one way."""
        return ""

    @property
    def work(self) -> dict[str, int]:
        """How often a step does what: the names of instructions.json."""
        return {
            "coefficients": self.coefficients,
            "stops": len(self.radius),
            "paths": len(self.length),
            "creeps": len(self.gain),
            "schedules": len(self.source),
            "more weights": (self.sets - 1) * self.terms,
        }

    @property
    def strokes(self) -> dict[str, int]:
        """What the first step does beside that: it leads stops and path lags along two strokes, where it begins so."""
        if self.past not in STROKES:
            return {}
        # A stop of a step is clamped twice, too; a path lag moves once.
        return {"stops": len(self.radius), "paths": 2 * len(self.length)}

    @property
    def memory(self) -> int:
        """Reals that a state remembers, two of each."""
        return 2 * self.parts

    def bytes(self, size: int) -> int:
        """Return bytes of its constants on a 32-bit target, by the size of a real."""
        # Counts, pointers and padding take the same room in every model.
        return (
            size * (self.parts + len(self.weight) + 11) + 4 * len(self.group) + {4: 60, 8: 64}[size]
        )


def direct_numbers(parameters: tuple[Any, ...]) -> DirectNumbers:
    """Return the numbers of a direct inverse from what the core takes: ``DirectInverse.parameters(period)``."""
    *tables, numbers, coefficients, groups, past = parameters
    radius, length, gain, weight, group, source, low, high = (
        tuple(table.tolist()) for table in tables
    )
    return DirectNumbers(
        int(coefficients), int(groups), int(past), radius, length, gain, weight, group, source, low, high,
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


@dataclass(frozen=True)
class ElementNumbers:
    """``dehyst_element_sum``, and what its block has beside it; values stay doubles."""

    parameters: ElementBlockParameters

    @property
    def rising(self) -> Tables:
        """Maps and schedules."""
        p = self.parameters
        # Arguments of a map must rise; the values of an element may do as they like.
        for points in p.maps:
            yield "breakpoints of an element", points[0]
        for side in (*p.before, *p.after):
            yield "numbers of a map", side
        for pair in zip(p.schedule_low, p.schedule_high, strict=True):
            yield "ends of a schedule", pair

    @property
    def after(self) -> Map | None:
        """Map behind the sum."""
        return self.parameters.after

    @property
    def work(self) -> dict[str, int]:
        """How often a step, or a round of its solution, does what: the names of instructions.json."""
        counts = dict(Counter(families_kit.KINDS[kind] for kind in self.parameters.kind))
        points = [len(u) for u, _ in self.parameters.maps if u]
        # The place in a map is searched by halving its breakpoints.
        halvings = sum(max(0, size - 2).bit_length() for size in points)
        return {**counts, "maps of elements": len(points), "halvings of a map": halvings}

    @property
    def way(self) -> str:
        """How a sample is answered: the sum is evaluated, and perhaps held at a limit, or solved."""
        p = self.parameters
        if p.solves:
            return "_solved"
        if p.numbers["reach_high"] < REACH:
            return "_held"
        return "_evaluated"

    @property
    def elements(self) -> list[dict[str, Any]]:
        """Kind, numbers and place of the map of each element."""
        p, at, rows = self.parameters, 0, []
        for k, kind in enumerate(p.kind):
            # Maps of all elements stand in one table: `at` is where that of this one begins.
            points = len(p.maps[k][0])
            rows.append(
                {"kind": f"DEHYST_{families_kit.KINDS[kind].upper()}", "number": kind, "schedule": p.schedule[k],
                 "radius": p.radius[k], "gain": p.gain[k], "weight": p.weight[k], "points": points, "at": at}
            )  # fmt: skip
            at += points
        return rows

    @property
    def points(self) -> Map:
        """Breakpoints of all maps of elements, one behind the other."""
        u: list[float] = []
        v: list[float] = []
        for arguments, values in self.parameters.maps:
            u += arguments
            v += values
        return tuple(u), tuple(v)


@dataclass(frozen=True)
class OffsetUnit:
    """``dehyst_offset``, fields named as there, and whether it is added behind a forward block."""

    limit: float
    turn: float
    part: float
    fingerprint: int
    forward: bool
    functions: ClassVar = tuple(
        f"dehyst_offset_{name}" for name in ("reset", "next", "step", "save", "restore")
    )

    def bytes(self, size: int) -> tuple[int, int, int]:
        """Return bytes of constants, state and image on a 32-bit target, by the size of a real."""
        return {4: 16, 8: 32}[size], 6 * size + 16, 4 * (7 + 6 * size // 4)


@dataclass(frozen=True, kw_only=True)
class UnitNumbers:
    """A block of the core as a unit: what templates of targets ask of it, whatever runs in it.

    Attributes
    ----------
    core
        Its structure and functions are called ``dehyst_<core>``: "block" of plays, "direct_block" or "element_block".
    model
        Its tables.
    input_low, input_high, output_low, output_high, reach_low, reach_high
        Limits; reach: of the output in front of the last map, where the input is held back.
    line_slope, line_offset, fade
        Of the straight line that answers while it is off; share of a switching that one sample makes.
    fingerprint
        Of the model: images of another one are refused.
    leading, given
        C names of the inputs of a step; behind the first ones those that the core takes as an array.
    takes_given
        Whether it does.
    saved
        Whether its state has an image.
    kind, parts
        What it has in the place of operators, and how many.
    map_points
        Breakpoints of the maps in front of its memory and behind it.
    memory
        (member of the core's state, name, size) of each array that the unit owns; a size is one of `sizes`.
    sizes
        (name, C expression, comment) of the unit's constants.
    held_bytes
        Of constants, state and image on a 32-bit target, without an offset.
    tolerance
        Largest error of the block in float. [output]
    offset
        That follows the last cycle, or None.
    """

    core: str
    model: ModelNumbers | DirectNumbers | ElementNumbers
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
    leading: tuple[str, ...] = ("x",)
    given: tuple[str, ...] = ()
    takes_given: bool = False
    saved: bool = True
    kind: str
    parts: int
    map_points: tuple[int, ...] = ()
    memory: tuple[tuple[str, str, str], ...]
    sizes: tuple[tuple[str, str, str], ...]
    held_bytes: tuple[int, int, int]
    tolerance: float
    offset: OffsetUnit | None = None

    @property
    def work(self) -> tuple[str, dict[str, int]]:
        """Kind of unit, and how often a step does what: the names of instructions.json."""
        return self.core + self.model.way, {
            **self.model.work,
            "maps": sum(points > 0 for points in self.map_points),
        }

    @property
    def back(self) -> Map | None:
        """The map behind its memory, backwards, with rising breakpoints; None if there is none."""
        after = self.model.after
        if not after or not after[0]:
            return None
        # Backwards the values are the arguments, which must rise.
        values, points = zip(*sorted(zip(after[1], after[0], strict=True)), strict=True)
        return values, points

    @property
    def functions(self) -> tuple[str, ...]:
        """Of the core, that the unit calls."""
        verbs: tuple[str, ...] = ("reset", "step")
        if self.saved:
            verbs = ("reset", "step", "save", "restore")
        functions = tuple(f"dehyst_{self.core}_{verb}" for verb in verbs)
        if self.offset:
            functions += self.offset.functions
        return functions

    @property
    def inputs(self) -> tuple[str, ...]:
        """C names of all inputs of a step."""
        inputs = (*self.leading, *self.given)
        if self.offset:
            inputs += ("measured",)
        return inputs

    @property
    def direct(self) -> DirectNumbers | None:
        """The direct inverse, if it is one."""
        if isinstance(self.model, DirectNumbers):
            return self.model
        return None

    @property
    def least(self) -> float:
        """No answer lies below. [output]"""
        return self._within(self.output_low, -1.0)

    @property
    def most(self) -> float:
        """No answer lies above. [output]"""
        return self._within(self.output_high, 1.0)

    def _within(self, end: float, side: float) -> float:
        # Forward the offset is added to the answer, and widens its range.
        if self.offset and self.offset.forward:
            return end + side * self.offset.limit
        return end

    @property
    def rising(self) -> Tables:
        """Tables and ranges of which neighbours differ."""
        yield from self.model.rising
        yield "ends of the input", (self.input_low, self.input_high)
        yield "ends of the output", (self.output_low, self.output_high)

    def bytes(self, size: int) -> tuple[int, int, int]:
        """Return bytes of constants, state and image on a 32-bit target; `size` is that of a real."""
        constants, state, image = self.held_bytes
        more = self.offset.bytes(size) if self.offset else (0, 0, 0)
        return constants + more[0], state + more[1], image + more[2] if self.saved else 0


# Reals of dehyst_joint and dehyst_joint_state beside their tables; bytes of counts, pointers and padding on a 32-bit
# target, by the size of a real. packages/dehyst/tests/export/test_export_c.py asks a compiler for such a target.
JOINT_PARAMETERS, JOINT_REST = 73, {4: 24, 8: 32}
MODEL_REST = {4: 40, 8: 48}
IMAGE_OF_DIRECT = 101  # DEHYST_JOINT_WORDS of packages/dehyst/core/dehyst.h
JOINT_REALS, JOINT_COUNTS = 179, {4: 48, 8: 64}


@dataclass(frozen=True)
class JointNumbers:
    """``dehyst_joint``: its numbers by the names of the core's fields, and the tables of its compensator.

    Attributes
    ----------
    values
        Of the parameters.
    table
        Of the compensator: a model of plays, angle -> pressure difference, or a direct inverse, angle -> torque.
    fingerprint
        Of all of it: images of another one are refused.
    adaptation
        How it learns, by the names of `Adaptation`; without a direct inverse nobody reads it.
    """

    values: Mapping[str, Any]
    table: ModelNumbers | DirectNumbers
    fingerprint: int
    adaptation: Mapping[str, float]
    core: ClassVar = "joint"
    saved: ClassVar = True
    functions: ClassVar = tuple(
        f"dehyst_joint_{name}" for name in ("reset", "step", "save", "restore")
    )

    @property
    def compensator(self) -> ModelNumbers | None:
        """The model of plays, if it is one."""
        if isinstance(self.table, ModelNumbers):
            return self.table
        return None

    @property
    def direct(self) -> DirectNumbers | None:
        """The direct inverse, if it is one."""
        if isinstance(self.table, DirectNumbers):
            return self.table
        return None

    @property
    def work(self) -> tuple[str, dict[str, int]]:
        """Kind of unit, and how often a period does what: the names of instructions.json."""
        maps = sum(points > 0 for points in self.map_points)
        kind = "joint"
        if self.direct:
            kind = "joint_direct"
        return kind, {**self.table.work, "maps": maps}

    @property
    def parts(self) -> int:
        """Operators of the compensator, or stops and lags of the direct inverse."""
        return self.table.parts

    @property
    def map_points(self) -> tuple[int, ...]:
        """Breakpoints of the maps of the compensator."""
        if isinstance(self.table, ModelNumbers):
            return self.table.points
        return ()

    def bytes(self, size: int) -> tuple[int, int, int]:
        """Return bytes of constants, state and image on a 32-bit target; `size` is that of a real."""
        table = self.table
        constants, reals, image = size * JOINT_PARAMETERS + JOINT_REST[size], JOINT_REALS, 75
        if isinstance(table, DirectNumbers):
            constants += table.bytes(size)
            reals += 2 * max(1, table.memory)
            image += IMAGE_OF_DIRECT + 2 * table.memory
        else:
            n = table.parts
            constants += size * (4 * n + 2 * sum(table.points)) + MODEL_REST[size]
            reals, image = n + reals, n + image
        return constants, size * reals + JOINT_COUNTS[size], 4 * (16 + size // 4 * image)
