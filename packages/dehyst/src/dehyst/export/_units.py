"""A unit to export: the block in Python, its parameters on the target, and the signal that compares both.

Three kinds of models have a block in the core: plays, direct inverses and sums of elements. What differs between them
stands in the `UnitNumbers` that `play_unit`, `direct_unit` and `element_unit` return.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.export._names import c_names
from dehyst.export._numbers import (
    DirectNumbers,
    ElementNumbers,
    Map,
    ModelNumbers,
    OffsetUnit,
    UnitNumbers,
    direct_in,
    direct_numbers,
    model_numbers,
)
from dehyst.export._policy import POLICY
from dehyst.export._signal import SAMPLES, Whole, moving_input, test_input
from dehyst.export.precision import (
    BYTES,
    FLOAT_LIMIT,
    INPUT_LIMIT,
    check_fade,
    check_float,
    in_real,
    inward,
    outward,
    rounded,
)
from dehyst.families import ElementBlockParameters
from dehyst.families import kit as families_kit
from dehyst.models import BLOCK_FLAGS, Block, Model, SignalCard
from dehyst.models import kit as models_kit

LIMITS = ("input", "output", "reach")
ENDS = tuple(f"{name}_{end}" for name in LIMITS for end in ("low", "high"))
LINE = ("line_slope", "line_offset", "fade")
FAR = {"double": 1e300, "float": 1e38}  # DEHYST_FAR
RATE = "its rate of change a second, 0 if the model has no viscous term"


@dataclass(frozen=True)
class Unit:
    """A unit of any kind.

    Attributes
    ----------
    block
        As it runs here, in double precision.
    numbers
        In the precision of the target.
    inputs, on
        Test signal, (T, m) and (T,).
    more
        (C name, meaning) of each input behind the first.
    heads
        Names of these in tables.
    middle
        A usual value of each input.
    allowed
        Largest error of an answer in float, that of an offset included. [output]
    """

    block: Block
    numbers: UnitNumbers
    inputs: Array
    on: Whole
    more: tuple[tuple[str, str], ...]
    heads: tuple[str, ...]
    middle: tuple[float, ...]
    allowed: float

    @property
    def period(self) -> float | None:
        """Between samples, if that counts. [s]"""
        if not self.block.timed:
            return None
        return self.block.period


def unit_of(
    model: Model, direction: models_kit.Direction, real: str, range: tuple[float, float] | None, ramp: int,
    period: float | None, follow_offset: float | None,
) -> Unit:  # fmt: skip
    """Return a model, or its inverse, as a unit; with an offset it has one input more, what was measured."""
    if model.no_export:
        raise ParameterError(f"the model cannot be exported: {model.no_export}")
    block = Block(model, direction, range, ramp, period=period)
    exact, numbers = NUMBERS[model.core](block, real)
    if real == "float":
        check_fade(numbers.fade, ramp)
        check_float(exact, numbers)
    low, high = numbers.input_low, numbers.input_high
    if numbers.core == "block":
        x, on = test_input(low, high, real, ramp)
        inputs = x[:, None]
    else:
        # A further input without a range is a rate: the test signal computes it from the first input.
        ranges: list[tuple[float, float] | None] = []
        for card in block.more:
            if card.low is None or card.high is None:
                ranges.append(None)
            else:
                ranges.append((card.low, card.high))
        inputs, on = moving_input(low, high, ranges, ramp, real)
    more, heads, middles = [], [], [0.0]
    for name, card in zip(numbers.inputs[1:], block.more, strict=True):
        about, head, middle = _described(card, block.input.name or "y")
        more.append((name, about))
        heads.append(head)
        middles.append(middle)
    unit = Unit(
        block, numbers, inputs, on, tuple(more), tuple(heads), tuple(middles), numbers.tolerance
    )
    if follow_offset is None:
        return unit
    return _followed(
        unit, Block(model, direction, range, ramp, period=period, follow_offset=follow_offset), real
    )


def _described(card: SignalCard, first: str) -> tuple[str, str, float]:
    """Meaning, name in tables and usual value of a further input; one without a range is the rate of the first."""
    if card.low is None or card.high is None:
        return RATE, f"{first}_rate", 0.0
    about = f"{card.label}, held beyond {card.low:.6g} .. {card.high:.6g}"
    return about, card.name, 0.5 * (card.low + card.high)


# ---- Plays


def play_unit(
    model: ModelNumbers, limits: Mapping[str, Any], fingerprint: int, real: str
) -> UnitNumbers:
    """Return a unit of a model of plays from its numbers in a precision; `limits` by the names of `ENDS` and `LINE`."""
    n, points, size = model.parts, sum(model.points), BYTES[real]
    # Counts, pointers and padding, on a processor of 32 bits.
    overhead = {4: 48, 8: 64}[size]
    state = size * (n + 3) + 4 * 4 + (8 if size == 8 else 0)
    return UnitNumbers(
        core="block", model=model, **limits, fingerprint=fingerprint, kind="operators", parts=n,
        map_points=model.points, memory=(("model.z", "z", "OPERATORS"),),
        sizes=(("OPERATORS", f"{n}", ""), ("IMAGE_WORDS", f"DEHYST_STATE_WORDS({n})", "of a saved state")),
        held_bytes=(size * (4 * n + 2 * points + 11) + overhead, state, 4 * (6 + size // 4 * (n + 3))),
        tolerance=POLICY.tolerance * (limits["output_high"] - limits["output_low"]),
    )  # fmt: skip


def block_numbers(block: Block) -> UnitNumbers:
    """Return the numbers of a block of plays, in double precision."""
    values = vars(block.parameters)
    limits = {name: float(values[name]) for name in (*ENDS, *LINE)}
    return play_unit(model_numbers(values), limits, int(values["fingerprint"]), "double")


def block_in(numbers: UnitNumbers, real: str) -> UnitNumbers:
    """Return a block of plays in that precision; its values stay doubles."""
    model = numbers.model
    if real == "double" or not isinstance(model, ModelNumbers):
        return numbers
    ends = {}
    for name in LIMITS:
        low, high = getattr(numbers, f"{name}_low"), getattr(numbers, f"{name}_high")
        ends[name] = inward(low, high, real)
    if numbers.reach_high >= FLOAT_LIMIT:  # forward: it never holds back
        # What a model reaches is no limit of a machine: the answers in float must not be cut off by their rounding.
        ends["output"] = outward(*_reached_in_float(numbers, model), real)
        ends["reach"] = (-FLOAT_LIMIT, FLOAT_LIMIT)
    limits: dict[str, Any] = {}
    for name in LIMITS:
        limits[f"{name}_low"], limits[f"{name}_high"] = ends[name]
    for name in LINE:
        limits[name] = rounded(getattr(numbers, name), real)
    return play_unit(in_real(model, real), limits, numbers.fingerprint, real)


def _reached_in_float(numbers: UnitNumbers, m: ModelNumbers) -> tuple[float, float]:
    """Range of the output with the rounding of floats."""
    nothing: Map = ((), ())
    (u, v), (p, q) = m.before or nothing, m.after or nothing
    weights = np.diff(np.array(m.slope), prepend=0.0)
    operator = models_kit.Operator(
        np.array(m.threshold), weights, m.center, m.offset, np.array(u), np.array(v), np.array(p), np.array(q),
        np.array(m.start),
    )  # fmt: skip
    bottom, top = operator.in_front_of_after(numbers.output_low, numbers.output_high)
    return operator.widened(
        numbers.input_low, numbers.input_high, bottom, top, models_kit.EPS_FLOAT
    )


def _of_plays(block: Block, real: str) -> tuple[UnitNumbers, UnitNumbers]:
    """The numbers in double, and in the precision that is wanted."""
    # What the actuator is given: the unit's output when it is an inverse.
    card, limited = block.model.card.input, block.output
    if block.direction == "forward":
        limited = block.input
    assert limited.low is not None and limited.high is not None  # a block keeps limits
    if (
        card.low is not None
        and card.high is not None
        and limited.high - limited.low < POLICY.narrowest * (card.high - card.low)
    ):
        raise ParameterError(
            f"the range from {limited.low:.9g} to {limited.high:.9g} is less than a millionth of what was identified, "
            f"{card!s}: the unit would do nothing. Pass --range LO HI in {card.unit or 'the unit of the input'}, what "
            f"the actuator can be given.",
            low=limited.low,
            high=limited.high,
        )
    exact = block_numbers(block)
    return exact, block_in(exact, real)


# ---- Direct inverses


def direct_unit(
    d: DirectNumbers, line: Mapping[str, Any], scheduled_by: tuple[str, ...], real: str
) -> UnitNumbers:
    """Return a unit of a direct inverse from its numbers in a precision: y, rate and what schedules it in, u out."""
    size, reals = BYTES[real], max(1, d.memory)
    sizes = (
        ("STOPS", f"{len(d.radius)}", ""),
        ("PATHS", f"{len(d.length)}", ""),
        ("CREEPS", f"{len(d.gain)}", ""),
        ("REALS", f"{reals}", "numbers that it remembers"),
    )
    # Its answer is never held back: its reach lies beyond all outputs.
    return UnitNumbers(
        core="direct_block", model=d, input_low=d.input_low, input_high=d.input_high, output_low=d.output_low,
        output_high=d.output_high, reach_low=-FAR[real], reach_high=FAR[real], **line,
        fingerprint=0, leading=("y", "rate"), given=scheduled_by, takes_given=True, saved=False,
        kind="stops and lags", parts=d.parts, memory=(("direct.memory", "memory", "REALS"),), sizes=sizes,
        held_bytes=(size * 3 + d.bytes(size), size * (reals + 20) + {4: 16, 8: 24}[size], 0),
        tolerance=float_tolerance(d),
    )  # fmt: skip


def _of_direct(block: Block, real: str) -> tuple[UnitNumbers, UnitNumbers]:
    p = block.parameters
    line = {name: float(getattr(p, name)) for name in LINE}
    exact, names = direct_numbers(p.direct), c_names(block.given[1:], ("y", "rate"))
    single = direct_in(exact, real)
    return (
        direct_unit(exact, line, names, "double"),
        direct_unit(single, in_real(line, real), names, real),
    )


def float_tolerance(d: DirectNumbers) -> float:
    """Return how far answers in float may be from those of the model: 1e-5 of the range of u, and rounding of y. [u]

    A creep lag adds less than its last digit when it is nearly there: that can add up over the samples of the test.
    """
    largest = max(abs(d.input_low), abs(d.input_high), d.input_high - d.input_low)
    digit = float(np.spacing(np.float32(largest)))
    table = np.array(d.weight).reshape(d.sets, d.terms)[:, d.coefficients : -1]
    weights = np.abs(table).sum(axis=0) if table.size else np.zeros(0)
    first = len(d.radius) + len(d.length)
    stalled = sum(
        w * 0.5 * digit * min(1.0 / gain, SAMPLES)
        for w, gain in zip(weights[first:], d.gain, strict=True)
    )
    return (
        POLICY.tolerance * (d.output_high - d.output_low)
        + digit * float(weights.sum())
        + float(stalled)
    )


# ---- Sums of elements


def element_unit(
    p: ElementBlockParameters, scheduled_by: tuple[str, ...], tolerance: float, real: str
) -> UnitNumbers:
    """Return a unit of a sum of elements from its parameters in a precision."""
    n, delay, size, model = len(p.kind), p.delay, BYTES[real], ElementNumbers(p)
    map_points = len(p.before[0]), len(p.after[0])
    limits: dict[str, Any] = {name: p.numbers[name] for name in (*ENDS, *LINE)}
    reals = 2 * (len(model.points[0]) + sum(map_points)) + len(p.start) + len(p.numbers) + 9
    return UnitNumbers(
        core="element_block", model=model, **limits,
        fingerprint=p.fingerprint, given=scheduled_by, takes_given=True, kind="elements", parts=n,
        map_points=map_points,
        memory=(("sum.z", "z", "ELEMENTS"), ("delay.ring", "ring", "RING")),
        sizes=(("ELEMENTS", f"{n}", ""), ("RING", f"{max(1, delay)}", "remembered samples of the input, 1 for none"),
               ("IMAGE_WORDS", f"DEHYST_ELEMENT_WORDS({n}, {delay})", "of a saved state")),
        held_bytes=(
            n * {4: 32, 8: 48}[size] + size * reals + {4: 64, 8: 80}[size],
            size * (n + max(1, delay) + 7) + {4: 32, 8: 40}[size],
            4 * (6 + size // 4 * (n + delay + 6)),
        ),
        tolerance=tolerance,
    )  # fmt: skip


def _of_elements(block: Block, real: str) -> tuple[UnitNumbers, UnitNumbers]:
    exact: ElementBlockParameters = block.parameters
    # Only a reach that some output can meet holds an input back.
    holds = exact.numbers["reach_high"] < INPUT_LIMIT["double"]
    numbers = dict(in_real(exact.numbers, real))
    if real == "float":
        for side in LIMITS:
            # What a sum reaches is no limit of a machine: rounding must not cut its answers off.
            towards = outward
            if side == "input" or exact.solves or holds:
                towards = inward
            ends = towards(exact.numbers[f"{side}_low"], exact.numbers[f"{side}_high"], real)
            numbers[f"{side}_low"], numbers[f"{side}_high"] = ends
    if not holds:  # a reach that is none is written as what lies beyond all inputs
        numbers |= {"reach_low": -FAR[real], "reach_high": FAR[real]}
    single = replace(in_real(exact, real), numbers=numbers)
    tolerance = 0.0
    if real != "double":
        tolerance = _tolerance(exact)
    names = c_names(block.given, ("x",))
    return element_unit(exact, names, 0.0, "double"), element_unit(single, names, tolerance, real)


def _tolerance(exact: ElementBlockParameters) -> float:
    """1e-5 of the range, and what rounding makes of it: of x, of each term, of lags that stop short.

    Where the sum is solved, all of it counts over the least slope that one element of ``input`` gives.
    """
    n = exact.numbers
    ends = [abs((n[f"input_{end}"] - n["center"]) / n["half_range"]) for end in ("low", "high")]
    size = max(abs(exact.low), abs(exact.high), *ends, 1.0) + abs(n["center"] / n["half_range"])
    digit = float(np.spacing(np.float32(size)))
    terms, slopes = abs(exact.offset), 0.0
    stalled, direct = 0.0, 0.0
    for k, kind in enumerate(exact.kind):
        u, v = np.array(exact.maps[k][0]), np.array(exact.maps[k][1])
        # An element without a map hands its memory on as it is.
        steep, flat, largest = 1.0, 1.0, size
        if u.size:
            slope = np.diff(v) / np.diff(u)
            steep, flat = float(np.abs(slope).max()), float(slope.min())
            largest = float(np.abs(v).max())
        weight = abs(exact.weight[k]) * steep
        terms += abs(exact.weight[k]) * largest
        slopes += weight
        if families_kit.KINDS[kind] == "input":
            direct += max(0.0, exact.weight[k] * flat)
        # A lag stops short when what it adds is less than its last digit.
        if families_kit.KINDS[kind] in families_kit.LAGS and exact.gain[k] > 0.0:
            stalled += weight * 0.5 * digit * min(1.0 / exact.gain[k], SAMPLES)
    error = 4.0 * digit * (slopes + terms / size) + stalled
    if exact.solves:
        error /= max(direct, 1e-3)
    error *= abs(n["amplitude"]) * _steepest(exact.before) * _steepest(exact.after)
    return POLICY.tolerance * (n["output_high"] - n["output_low"]) + error


def _steepest(map: Map) -> float:
    u, v = np.array(map[0]), np.array(map[1])
    if not u.size:
        return 1.0
    return max(1.0, float(np.abs(np.diff(v) / np.diff(u)).max()))


NUMBERS = {
    "plays": _of_plays,
    "direct": _of_direct,
    "elements": _of_elements,
}  # by what a model is run by


# ---- An offset that follows the last cycle


def _followed(unit: Unit, block: Block, real: str) -> Unit:
    """The unit with the offset of `block` around it: one more input, what was measured."""
    assert block.following is not None
    exact, card, numbers = block.following.numbers, block.model.card.output, unit.numbers
    offset = OffsetUnit(
        rounded(exact.limit, real), rounded(exact.turn, real), rounded(exact.part, real), exact.fingerprint,
        block.direction == "forward",
    )  # fmt: skip
    about = f"measured {card.label} of this sample, no number where there is none; it counts from the next one on"
    if offset.forward:
        allowed = 3.0 * numbers.tolerance + POLICY.tolerance * offset.limit
    else:
        input_error = POLICY.tolerance * (numbers.input_high - numbers.input_low)
        allowed = numbers.tolerance + 10.0 * abs(numbers.line_slope) * input_error
    return replace(
        unit, block=block, numbers=replace(numbers, offset=offset), allowed=allowed,
        inputs=np.column_stack((unit.inputs, _measured(unit, offset, real))),
        more=(*unit.more, (models_kit.MEASURED, about)),
        heads=(*unit.heads, f"{card.name or 'output'}_measured"),
        middle=(*unit.middle, numbers.line_offset if offset.forward else 0.0),
    )  # fmt: skip


def _measured(unit: Unit, offset: OffsetUnit, real: str) -> Array:
    """An actuator on the unit's line whose offset wanders to and fro beyond the limit, with gaps, (T,).

    Nothing is measured near a limit nor near the end of a switching: in float the last digit decides there which
    sample counts.
    """
    near = np.zeros(unit.inputs.shape[0])
    for shift in (0.0,) if offset.forward else (-offset.limit, 0.0, offset.limit):
        unit.block.reset()
        shifted = np.column_stack((unit.inputs[:, 0] + shift, unit.inputs[:, 1:]))
        near += (unit.block.answer(shifted, unit.on)[1] & BLOCK_FLAGS["limited"]) != 0
    unit.block.reset()
    for k in np.flatnonzero(np.diff(unit.on) > 0):
        near[k + 1 : k + unit.block.ramp + 20] = 1.0
    x, n = np.nan_to_num(unit.inputs[:, 0], posinf=0.0, neginf=0.0), unit.numbers
    x = np.clip(x, n.input_low, n.input_high)
    y = n.line_offset + n.line_slope * x if offset.forward else x
    y = y + 1.5 * offset.limit * np.sin(np.arange(y.size) * (2.0 * np.pi / 700.0))
    y[np.convolve(near, np.ones(3), "same") > 0.0] = np.nan
    strange = (np.nan, np.inf, -np.inf, -0.0)
    # The seed is the same in every export, so that equal exports are equal files.
    y[np.random.default_rng(7).choice(y.size, len(strange), replace=False)] = strange
    return np.array(y if real == "double" else y.astype(np.float32), dtype=np.float64)
