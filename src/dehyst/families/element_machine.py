"""A sum of elements or its inverse as a block of the core: constants for a period, limits, linear ends."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

import dehyst._native as _native
from dehyst.errors import ParameterError
from dehyst.families.rising import LEAST_SLOPE
from dehyst.models.arrays import parameter_number
from dehyst.models.card import SignalCard
from dehyst.models.machine import Direction, Machine, declared_range

if TYPE_CHECKING:
    from dehyst.families.elements import ElementModel, Pairs

BEYOND = 0.5  # of the slow loop's height: so much further creep and rate may lead
LONG = 1e9  # s, after which every lag is there
ROUNDING = 1e-9
NUMBERS = (
    "origin", "center", "half_range", "level", "amplitude", "input_low", "input_high", "output_low", "output_high",
    "reach_low", "reach_high", "line_slope", "line_offset", "fade",
)  # fmt: skip


@dataclass(frozen=True)
class ElementBlockParameters:
    """Parameters of the core's ``dehyst_element_block`` with the bits that are used: what an exporter prints.

    Attributes
    ----------
    kind, schedule, radius, gain, weight, maps
        Of the elements, in their order; the gain for the period.
    offset
        c of the sum.
    before, after
        Maps in front of what runs and behind it: those of the model, or swapped where the sum is solved.
    low, high
        Of all x of the sum. [scaled]
    source, schedule_low, schedule_high
        Of the schedules.
    solves
        Whether the sum is solved and not evaluated.
    delay
        Dead time in samples.
    start
        Memory before the stroke to the first sample; () at rest there.
    numbers
        By the names of `NUMBERS`.
    fingerprint
        First 32 bits of the SHA-256 of all of it.
    """

    kind: tuple[int, ...]
    schedule: tuple[int, ...]
    radius: tuple[float, ...]
    gain: tuple[float, ...]
    weight: tuple[float, ...]
    maps: tuple[Pairs, ...]
    offset: float
    before: Pairs
    after: Pairs
    low: float
    high: float
    source: tuple[int, ...]
    schedule_low: tuple[float, ...]
    schedule_high: tuple[float, ...]
    solves: bool
    delay: int
    start: tuple[float, ...]
    numbers: Mapping[str, float]
    fingerprint: int


def element_machine(
    model: ElementModel, direction: Direction, range: tuple[float, float] | None, ramp: int, period: float | None
) -> Machine:
    """Return the block of the core: at a fixed period, its first good sample as ``model.before`` says.

    An inverse block takes wanted outputs half of the slow loop's height beyond its ends: so much creep and rate may
    add. Dead time counts forward.
    """
    low, high = declared_range(model.card.input, range)
    period = parameter_number(_usual(model) if period is None else period, "period")
    _refuse_period(model, direction, period)
    p, sum_ = _made(model, direction, period, ramp, low, high)
    numbers = p.numbers
    native = _native.ElementBlock(
        sum_, period, p.solves, p.delay, np.array(p.start), np.array([numbers[name] for name in NUMBERS]),
        p.fingerprint,
    )  # fmt: skip
    card = model.card.swapped() if direction == "inverse" else model.card
    input = replace(card.input, low=numbers["input_low"], high=numbers["input_high"])
    output = replace(card.output, low=numbers["output_low"], high=numbers["output_high"])
    return Machine(native, p, input, output, _followed(model), 2, period=period, timed=model.timed)


def _solves(model: ElementModel, direction: Direction) -> bool:
    """Whether each sample is a solution of the sum, not its value."""
    return (direction == "inverse") == (model.direction == "forward")


def _refuse_period(model: ElementModel, direction: Direction, period: float) -> None:
    if not period > 0.0:
        raise ParameterError(f"a period of {period:g} s is none; pass the time between two samples, above 0.")
    if direction == "inverse":
        model.inverse()  # says why there is none
    if not _solves(model, direction):
        return
    slope = replace(model, direction="forward", period=period, dead_time=0.0).least_slope
    if slope < LEAST_SLOPE:
        raise ParameterError(
            f"every {period:g} s the sum has no stable solution: its least slope is {slope:.3g} of its range, "
            f"and must be {LEAST_SLOPE:g} or more. It was identified every {model.period:g} s; run it so, or "
            f"identify from a log with the period of the machine."
        )


def _usual(model: ElementModel) -> float:
    """Period of the log, or any where time does not count. [s]"""
    if model.timed and not model.period:
        raise ParameterError(
            "the model creeps, depends on the rate or has a dead time, and does not say at which period it was "
            "identified. Pass period, the seconds between two samples of your loop (in a terminal: --period 0.001)."
        )
    return model.period or 1.0


def _followed(model: ElementModel) -> tuple[SignalCard, ...]:
    """Signals 0 and 1 that schedules follow, up to the last one that is used, with the ends of all that follow it."""
    last = max((source for source, _, _ in model.schedules), default=-1)
    cards = []
    for k in range(last + 1):
        ends = [(low, high) for source, low, high in model.schedules if source == k] or [(0.0, 1.0)]
        cards.append(SignalCard(f"signal_{k}", "", min(low for low, _ in ends), max(high for _, high in ends)))
    return tuple(cards)


def _made(
    model: ElementModel, direction: Direction, period: float, ramp: int, low: float, high: float
) -> tuple[ElementBlockParameters, _native.ElementSum]:
    inverse = direction == "inverse"
    solves = _solves(model, direction)
    scaling = model.scaling
    slow = _slow(model, low, high)
    wide = BEYOND * abs(slow[1] - slow[0])
    reached = min(slow) - wide, max(slow) + wide
    slope = (slow[1] - slow[0]) / (high - low)
    line = (1.0 / slope, low - slow[0] / slope) if inverse else (slope, slow[0] - slope * low)
    into = scaling.swapped() if inverse else scaling
    limits = (reached, (low, high)) if inverse else ((low, high), reached)
    before, after = model.before_map, model.after_map
    maps = ((after[1], after[0]), (before[1], before[0])) if solves else (before, after)
    start, origin = _departure(model)
    ends = _through(maps[0], *((end - into.center) / into.half_range for end in limits[0]))
    exits = _through(_swapped(maps[1]), *((end - into.level) / into.amplitude for end in limits[1]))
    x_range, reach = (exits, None) if solves else (ends, exits)
    if not solves and not inverse:  # a forward block never holds back: the actuator did get it
        bottom, top = _bounds(model, *ends, (*start, origin) if start else ())
        bottom, top = sorted(into.level + into.amplitude * v for v in _through(maps[1], bottom, top))
        limits = limits[0], (bottom, top)
        reach = None
    tables = list(model.tables)
    tables[8:12] = [np.array(maps[0]).reshape(2, -1), np.array(maps[1]).reshape(2, -1), *x_range]
    sum_ = _native.ElementSum(*tables)
    far = reach or (-_native.INPUT_LIMIT, _native.INPUT_LIMIT)
    values = (origin, into.center, into.half_range, into.level, into.amplitude, *limits[0], *limits[1], *far, *line)
    numbers = dict(zip(NUMBERS, map(float, (*values, 1.0 / ramp)), strict=True))
    q = model.elements
    parameters = ElementBlockParameters(
        kind=tuple(_native.ELEMENT_KINDS.index(e.kind) for e in q), schedule=tuple(e.schedule for e in q),
        radius=tuple(e.radius for e in q), gain=tuple(sum_.gains(period).tolist()),
        weight=tuple(e.weight for e in q), maps=tuple(e.map for e in q), offset=model.offset, before=maps[0],
        after=maps[1], low=x_range[0], high=x_range[1], source=tuple(s[0] for s in model.schedules),
        schedule_low=tuple(s[1] for s in model.schedules), schedule_high=tuple(s[2] for s in model.schedules),
        solves=solves, delay=0 if inverse else round(model.dead_time / period), start=start, numbers=numbers,
        fingerprint=0,
    )  # fmt: skip
    digest = hashlib.sha256(repr(parameters).encode()).digest()
    return replace(parameters, fingerprint=int.from_bytes(digest[:4], "big")), sum_


def _slow(model: ElementModel, low: float, high: float) -> tuple[float, float]:
    """Outputs at both ends of the loop of an input that waits there until all lags have come."""
    scaling, ends = model.scaling, np.repeat([low, high, low, high], 2)
    x = np.ascontiguousarray(scaling.inward(ends))
    still = replace(model, dead_time=0.0)
    middle = np.full((x.size, 2), 0.0)
    for source, below, above in model.schedules:
        if source >= 0:
            middle[:, source] = 0.5 * (below + above)
    y = scaling.outward(still.run(x, np.full(x.size, LONG), model.evaluated.rest(0.0), middle)[0])
    if not y[5] != y[7]:
        raise ParameterError(
            f"from one end of the input's range, {low:g}, to the other, {high:g}, the output does not move: no block "
            f"can be made of it. Pass range=(low, high), what the actuator can be given.",
            low=low,
            high=high,
        )
    return float(y[5]), float(y[7])


def _departure(model: ElementModel) -> tuple[tuple[float, ...], float]:
    """Memory of the elements from where one stroke leads to the first sample, and its x; () for rest."""
    if model.start == "rest":
        return (), 0.0
    memory = model.evaluated.departure()[0]
    return tuple(memory[2 : 2 + len(model.elements)].tolist()), float(memory[0])


def _swapped(map: Pairs) -> Pairs:
    return map[1], map[0]


def _through(map: Pairs, *values: float) -> tuple[float, float]:
    """Two values behind an increasing map, continued along its ends; the smaller one first."""
    u, v = (np.array(points) for points in map)
    if u.size:
        left = np.clip(np.searchsorted(u, values, side="right") - 1, 0, u.size - 2)
        found = v[left] + (np.array(values) - u[left]) * (v[left + 1] - v[left]) / (u[left + 1] - u[left])
    else:
        found = np.array(values)
    return float(found.min()), float(found.max())


def _bounds(model: ElementModel, low: float, high: float, start: tuple[float, ...]) -> tuple[float, float]:
    """Lower and upper bound of the sum over all inputs in low .. high and all memories that they leave."""
    bottom, top = min(low, *start, low), max(high, *start, high)
    least = most = model.offset
    size = abs(model.offset)
    for q in model.elements:
        reach = {
            "input": (low, high),
            "stop": (-q.radius, q.radius),
            "relax": (low - top, high - bottom),
            "path": (-q.radius, q.radius),
            "product": (-(q.radius**2), q.radius**2),
        }.get(q.kind, (bottom, top))
        inner = [u for u in q.map[0] if reach[0] < u < reach[1]]
        values = [q.weight * _through(q.map, e, e)[0] for e in (*reach, *inner)] + ([0.0] if q.schedule else [])
        least, most, size = least + min(values), most + max(values), size + max(map(abs, values))
    return least - ROUNDING * size, most + ROUNDING * size
